"""Folders of results: what stays, what goes, what a manifest tells, and who may write."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from threading import Thread

import pytest

from multilayer.errors import InputError
from multilayer.writing import disk
from multilayer.writing.folders import claim_folder, write_file, write_files, write_new
from multilayer.writing.manifest import changed_inputs, differences, inputs_noted, note_input, read_manifest
from multilayer.writing.workspace import claims, hidden_folder, is_claimed
from tests.cli.command import run

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="links")
_HOLDER = """
import sys, time
from pathlib import Path
from multilayer.writing.folders import claim_folder
claim_folder(Path(sys.argv[1]))
print("claimed", flush=True)
time.sleep(60)
"""


@pytest.fixture(params=["exchange", "one by one"])
def mode(request, monkeypatch):
    if request.param == "one by one":
        monkeypatch.setattr(disk, "_exchange", lambda: None)
    return request.param


@pytest.fixture
def holder(tmp_path):
    """Give a process that has claimed a folder."""
    with subprocess.Popen([sys.executable, "-c", _HOLDER, tmp_path / "foam"], stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"claimed\n"
        yield process
        process.kill()


def names(folder):
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir()}


@pytest.mark.usefixtures("mode")
class TestWhatStays:
    def test_files_of_the_user(self, tmp_path):
        folder = tmp_path / "foam"
        write_files(folder, {"a.csv": "old", "b.csv": "old"}, made_by="fit")
        (folder / "mine" / "deep").mkdir(parents=True)
        (folder / "mine" / "deep" / "notes.txt").write_text("mine")
        (folder / "link").symlink_to("nowhere")
        folder.chmod(0o750)
        write_files(folder, {"a.csv": "new"}, made_by="fit")
        assert names(folder) == {"a.csv", "manifest.json", "mine/deep/notes.txt", "link"}
        assert (folder / "a.csv").read_text() == "new"
        assert (folder / "mine" / "deep" / "notes.txt").read_text() == "mine"
        assert (folder / "link").readlink() == Path("nowhere")
        assert folder.stat().st_mode & 0o777 == 0o750
        assert {path.name for path in tmp_path.iterdir()} == {"foam"}

    def test_what_the_user_has_changed(self, tmp_path):
        folder = tmp_path / "foam"
        write_files(folder, {"a.csv": "old", "b.csv": "old", "c.csv": "old"}, made_by="fit")
        (folder / "b.csv").write_text("with remarks")
        write_files(folder, {"a.csv": "new"}, made_by="fit")
        assert names(folder) == {"a.csv", "b.csv", "manifest.json"}
        assert (folder / "b.csv").read_text() == "with remarks"

    def test_results_of_other_commands(self, tmp_path):
        folder = tmp_path / "foam"
        write_files(folder, {"fit.json": "1", "shared.html": "fit"}, made_by="fit")
        write_files(folder, {"methods.json": "2", "shared.html": "methods"}, made_by="methods")
        write_files(folder, {"fit.json": "3"}, made_by="fit")
        assert names(folder) == {"fit.json", "methods.json", "shared.html", "manifest.json"}
        manifest = read_manifest(folder)
        assert {name: set(entry["files"]) for name, entry in manifest["results"].items()} == {
            "fit": {"fit.json"}, "methods": {"methods.json", "shared.html"},
        }  # fmt: skip
        assert differences(folder, manifest) == []

    def test_a_folder_behind_a_link(self, tmp_path):
        (tmp_path / "real").mkdir()
        (tmp_path / "link").symlink_to("real")
        write_files(tmp_path / "link", {"a.csv": "1"}, made_by="fit")
        assert (tmp_path / "link").is_symlink()
        assert names(tmp_path / "real") == {"a.csv", "manifest.json"}

    def test_the_current_folder(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        for number in "12":
            write_files(Path(), {"a.csv": number}, made_by="fit")
            assert Path("a.csv").read_text() == number
            Path("notes.txt").write_text("mine")  # this process still stands in it
        assert names(tmp_path) == {"a.csv", "manifest.json", "notes.txt"}

    def test_folders_of_the_user_are_not_touched(self, tmp_path):
        folder = tmp_path / "foam"
        write_files(folder, {"a.csv": "old"}, made_by="fit")
        (folder / "mine").mkdir()
        (folder / "mine").chmod(0o2775)
        handle = os.open(folder / "mine", os.O_RDONLY)  # as a program that writes there
        before = (folder / "mine").stat()
        write_files(folder, {"a.csv": "new"}, made_by="fit")
        after = (folder / "mine").stat()
        assert (after.st_ino, after.st_mode, after.st_mtime_ns) == (before.st_ino, before.st_mode, before.st_mtime_ns)
        assert os.fstat(handle).st_nlink > 0
        os.close(handle)
        assert (folder / "a.csv").read_text() == "new"


def test_where_nobody_may_write_beside_it_the_workspace_is_inside(tmp_path, monkeypatch):
    """As a folder that a container has of its host."""
    folder = tmp_path / "foam"
    write_files(folder, {"a.csv": "old", "b.csv": "old"}, made_by="fit")
    monkeypatch.setattr(os.path, "ismount", lambda path: Path(path) == folder)
    assert hidden_folder(folder) == folder / ".multilayer"
    write_files(folder, {"a.csv": "new"}, made_by="fit")
    assert names(folder) == {"a.csv", "manifest.json"}
    assert list(folder.glob(".*")) == []


def test_a_reader_sees_whole_results_only(tmp_path):
    if disk._exchange() is None:
        pytest.skip("no exchange of folders here")
    folder, seen, stop = tmp_path / "foam", set(), []
    write_files(folder, {"a": "0", "b": "0"}, made_by="fit")

    def read():
        while not stop:
            handle = os.open(folder, os.O_RDONLY)  # one folder, whatever happens to its name
            try:
                seen.add(tuple(Path(f"/proc/self/fd/{handle}/{name}").read_text() for name in "ab"))
            except FileNotFoundError:  # an old folder that is being removed
                continue
            finally:
                os.close(handle)

    reader = Thread(target=read)
    reader.start()
    for number in range(30):
        write_files(folder, {"a": str(number), "b": str(number)}, made_by="fit")
    stop.append(True)
    reader.join()
    assert all(a == b for a, b in seen)


class TestLock:
    def test_a_second_run_is_refused(self, tmp_path, holder):
        with pytest.raises(InputError, match=rf"process {holder.pid} on .* is writing there; wait for it"):
            write_files(tmp_path / "foam", {"a": "1"}, made_by="fit")
        assert is_claimed(tmp_path / "foam")
        assert not (tmp_path / "foam").exists()

    def test_a_command_is_refused_before_it_computes(self, tmp_path, holder):
        done = run("simulate", "examples/double_wall.yaml", "--out", tmp_path / "foam")
        assert done.status == 2
        assert f"process {holder.pid}" in done.err
        assert done.out == ""

    def test_that_of_a_dead_run_is_taken_over(self, tmp_path, holder):
        holder.kill()
        holder.wait()
        hidden = hidden_folder(tmp_path / "foam")
        (hidden / "new").mkdir()
        (hidden / "new" / "half").write_text("of a result")
        write_files(tmp_path / "foam", {"a": "1"}, made_by="fit")
        assert names(tmp_path) == {"foam/a", "foam/manifest.json"}

    def test_ends_with_the_command(self, tmp_path):
        with claims():
            claim_folder(tmp_path / "deep" / "foam")
            assert is_claimed(tmp_path / "deep" / "foam")
        assert list(tmp_path.iterdir()) == []


class TestManifest:
    def test_inputs_and_what_has_changed(self, tmp_path):
        source = tmp_path / "stack.yaml"
        source.write_text("1")
        with inputs_noted("fit"):
            note_input(source)
            write_files(tmp_path / "foam", {"a": "1", "b": "2"}, made_by="fit")
        manifest = read_manifest(tmp_path / "foam")
        assert list(manifest["results"]["fit"]["inputs"]) == [str(source)]
        assert changed_inputs(manifest) == []
        source.write_text("2")
        (tmp_path / "foam" / "a").unlink()
        (tmp_path / "foam" / "b").write_text("3")
        assert changed_inputs(manifest) == [str(source)]
        assert differences(tmp_path / "foam", manifest) == ["a", "b"]

    @pytest.mark.parametrize("text", ["", "[]", "{}", '{"results": 1}', '{"results": {"fit": {"files": {"a": 1}}}}'])
    def test_that_is_none(self, tmp_path, text):
        folder = tmp_path / "foam"
        write_files(folder, {"a": "1"}, made_by="fit")
        (folder / "manifest.json").write_text(text)
        assert read_manifest(folder) is None
        done = run("check", folder)
        assert (done.status, done.out) == (2, "")
        assert "manifest.json: is no manifest; run the command again" in done.err
        write_files(folder, {"a": "2"}, made_by="fit")
        assert differences(folder, read_manifest(folder)) == []

    def test_check(self, tmp_path):
        stack = tmp_path / "wall.yaml"
        stack.write_text(Path("examples/double_wall.yaml").read_text())
        out = tmp_path / "out"
        assert run("simulate", stack, "--out", out, "--no-figures").status == 0
        inputs = json.loads((out / "manifest.json").read_text())["results"]["simulate"]["inputs"]
        assert list(inputs) == [str(stack)]
        done = run("check", out)
        assert (done.status, done.err) == (0, "")
        assert done.out == f"{out}: a result of 2 files by simulate without mistakes\n"
        stack.write_text(stack.read_text() + "\n")
        assert run("check", out).err == f"remark: {stack} has changed since these results were made\n"
        (out / "simulation.csv").write_text("1")
        done = run("check", out, "--json")
        assert done.status == 2
        (problem,) = json.loads(done.out)[0]["problems"]
        assert problem["file"] == str(out / "simulation.csv")


class TestSingle:
    def test_a_file_in_place_of_another(self, tmp_path):
        write_file(tmp_path / "law.yaml", "old")
        write_file(tmp_path / "law.yaml", b"new")
        assert names(tmp_path) == {"law.yaml"}
        with pytest.raises(InputError, match="is a folder"):
            write_file(tmp_path, "x")

    def test_a_new_folder_takes_an_empty_place_only(self, tmp_path):
        (tmp_path / "foam").mkdir()
        assert write_new(tmp_path / "foam", {"a/b": "1", "a/c": "2", "d": "3"}) == ["a/b", "a/c", "d"]
        with pytest.raises(InputError, match="holds files already"):
            write_new(tmp_path / "foam", {"e": "4"})
        assert names(tmp_path) == {"foam/a/b", "foam/a/c", "foam/d"}


def test_stopped_by_a_signal(tmp_path):
    """As a scheduler of a cluster stops a run: one line, status 130, no files."""
    out = tmp_path / "out"
    script = "import sys; from multilayer.cli import main; sys.argv[0] = 'multilayer'; main()"
    arguments = ["diagnose", "examples/foam_b", "--out", str(out)]
    with subprocess.Popen(
        [sys.executable, "-c", script, *arguments], stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        for _ in range(300):
            if is_claimed(out):
                break
            time.sleep(0.1)
        process.terminate()
        _, told = process.communicate(timeout=30)
    assert process.returncode == 130
    assert told.splitlines()[-1] == "stopped by SIGTERM: nothing was written"
    assert list(tmp_path.iterdir()) == []
