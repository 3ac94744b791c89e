"""Folders that come from somebody else: what lies in them acts on nothing outside of them."""

import json
import os
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import pytest

from multilayer.diagnosis.saved_law import known_effects
from multilayer.errors import InputError
from multilayer.writing import disk
from multilayer.writing.folders import claim_folder, write_files
from multilayer.writing.manifest import differences, read_manifest
from multilayer.writing.workspace import claims, hidden_folder
from tests.cli.command import run

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="links")
FILES = {"a.csv": "new"}


@pytest.fixture
def home(tmp_path):
    """Give a folder of the user's with a file that nothing may change."""
    folder = tmp_path / "home"
    folder.mkdir()
    (folder / "precious").write_text("precious")
    return folder


@pytest.fixture
def place(tmp_path):
    """Give a folder of results in a project of somebody else, and the hidden folder beside it."""
    place = tmp_path / "project" / "foam"
    write_files(place, {"a.csv": "old"}, made_by="fit")
    return place


@pytest.fixture(params=["written", "claimed"])
def refused(request):
    """Give a function that writes to a place, or claims it, and must be refused."""

    def act(place: Path) -> None:
        if request.param == "claimed":
            claim_folder(place)
        write_files(place, FILES, made_by="fit")

    def write(place: Path, match: str) -> None:
        with claims(), pytest.raises(InputError, match=match):
            act(place)
        assert (place / "a.csv").read_text() == "old"

    return write


def hidden(place: Path) -> Path:
    folder = hidden_folder(place)
    folder.mkdir()
    return folder


def test_a_hidden_folder_that_leads_elsewhere(home, place, refused):
    hidden_folder(place).symlink_to(home)
    refused(place, "is a link")
    assert {path.name: path.read_text() for path in home.iterdir()} == {"precious": "precious"}


@pytest.mark.parametrize("name", ["lock", "committed", "old", "beside", "journal.json"])
def test_links_in_the_hidden_folder(name, home, place, refused):
    target = home / "precious" if name in ("lock", "journal.json") else home
    (hidden(place) / name).symlink_to(target)
    refused(place, "is a link")
    assert {path.name: path.read_text() for path in home.iterdir()} == {"precious": "precious"}


@pytest.mark.parametrize(
    "target",
    ["{home}/precious", "{home}/foam.truth.json", "../home/precious", "../foam.rc", ".a/.b/foam.rc", "rc", ".rc"],
)
@pytest.mark.parametrize("n_new", [0, 1])
def test_a_journal_of_files_elsewhere(target, n_new, home, place, refused):
    folder = hidden(place)
    for name in ("old", "beside"):
        (folder / name).mkdir()
        (folder / name / "0").write_text("evil")
    named = target.format(home=home)
    (folder / "journal.json").write_text(json.dumps({"new": 1, "targets": [named], "n_new": n_new}))
    refused(place, "no run of multilayer wrote this; remove")
    assert {path.name: path.read_text() for path in home.iterdir()} == {"precious": "precious"}
    assert {path.name for path in place.parent.iterdir()} == {"foam", ".foam.multilayer"}


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{", "[" * 100_000, "\ud800", None, '{"new": {}, "targets": [], "n_new": 0}',
     '{"new": 1e999, "targets": [], "n_new": 0}', '{"new": 1, "targets": ["foam.\\u0000"], "n_new": 0}',
     '{"new": 1, "targets": ["foam.\\ud800"], "n_new": 0}', '{"new": 1, "targets": [3], "n_new": 0}'],
)  # fmt: skip
def test_a_journal_that_is_none(text, place, refused):
    file = hidden(place) / "journal.json"
    os.mkfifo(file) if text is None else file.write_text(text, errors="surrogatepass")
    refused(place, "no run of multilayer wrote this")


def test_a_place_that_was_refused_is_refused_again(place):
    (hidden(place) / "journal.json").write_text("{")
    for _ in range(2):
        with pytest.raises(InputError, match="no run of multilayer wrote this"):
            write_files(place, FILES, made_by="fit")


def test_what_an_old_manifest_lists_behind_a_link(home, place):
    (place / "figures").symlink_to(home)
    manifest(place, {"figures/precious": sha256(b"precious").hexdigest()})
    (hidden(place) / "committed").mkdir()
    (hidden_folder(place) / "committed" / "manifest.json").write_text('{"results": {}}')
    write_files(place, FILES, made_by="fit")  # finishes that first
    assert (home / "precious").read_text() == "precious"


def test_a_folder_of_results_with_a_link_out_of_it(home, place, monkeypatch):
    monkeypatch.setattr(disk, "_exchange", lambda: None)
    (place / "figures").symlink_to(home)
    with pytest.raises(InputError, match="leads by a link out of"):
        write_files(place, {"figures/precious": "evil"}, made_by="fit")
    assert (home / "precious").read_text() == "precious"


def manifest(place: Path, files: dict[str, str], inputs: dict[str, str] | None = None) -> None:
    entry = {"made_with": {}, "inputs": inputs or {}, "files": files}
    (place / "manifest.json").write_text(json.dumps({"version": 1, "results": {"fit": entry}}))


@pytest.mark.parametrize("name", ["{home}/precious", "../../home/precious"])
def test_a_manifest_of_files_elsewhere(name, home, place, monkeypatch):
    monkeypatch.setattr(disk, "_exchange", lambda: None)
    manifest(place, {name.format(home=home): sha256(b"precious").hexdigest()})
    assert read_manifest(place) is None
    write_files(place, FILES, made_by="fit")  # which drops what the old result has and the new one has not
    assert (home / "precious").read_text() == "precious"


def test_a_manifest_of_what_has_no_end(place):
    os.mkfifo(place / "pipe")
    manifest(place, {"pipe": "0" * 64}, {"/dev/zero": "0" * 64, str(place / "pipe"): "0" * 64})
    assert differences(place, read_manifest(place) or {}) == ["pipe"]
    assert run("check", place).status == 2


def test_a_manifest_that_is_a_pipe(place):
    (place / "manifest.json").unlink()
    os.mkfifo(place / "manifest.json")
    assert read_manifest(place) is None


MODULUS = "{law: table, file: referred}"
SOLID = (
    f"type: elastic_plate, thickness: 1 mm, density: 1000, poisson_ratio: 0.3, loss_factor: 0, young_modulus: {MODULUS}"
)
FLUID = "type: fluid, thickness: 10 mm"


SIMULATION = "version: 1\nlayers: [{{{layer}}}]\ntermination: rigid\n{more}frequency: [100]\nincidence: normal\n"
FIT = "kind: fit\nversion: 1\ncampaign: referred\n"
REFERENCES = {
    "reference": (SIMULATION.format(layer=FLUID, more="reference: referred\n"), "reference: "),
    "library": (SIMULATION.format(layer=FLUID, more="library: referred\n"), "library: "),
    "law": (SIMULATION.format(layer=SOLID, more=""), "layers.0.young_modulus"),
    "campaign": (FIT, "referred"),
}


@pytest.mark.parametrize("is_device", [False, True])
@pytest.mark.parametrize("name", REFERENCES)
def test_a_reference_without_end(name, is_device, tmp_path):
    referred = tmp_path / "referred"
    referred.symlink_to("/dev/zero") if is_device else os.mkfifo(referred)
    text, place = REFERENCES[name]
    file = tmp_path / "file.yaml"
    file.write_text(text)
    done = run("check", file)
    assert done.status == 2
    assert place in done.err
    assert "is a pipe or a device" in done.err


def test_what_the_shell_gives_is_read(tmp_path):
    table = b"name,sigma [N s/m4],phi,alpha_inf,Lambda [um],Lambda' [um]\nwool,10000,0.98,1.1,100,200\n"
    out, into = os.pipe()
    os.write(into, table)
    os.close(into)
    call = [sys.executable, "-m", "multilayer", "materials", "--from", f"/dev/fd/{out}", "--out", "made.yaml"]
    done = subprocess.run(call, pass_fds=[out], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60)
    os.close(out)
    assert (done.returncode, done.stderr) == (0, "")
    assert "wool" in (tmp_path / "made.yaml").read_text()


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "[" * 100_000, '{"verdict": "effect"}', '{"verdict": "effect", "causes": [], "group": [[]]}',
     '{"verdict": "unknown", "law": 3}', '{"verdict": "unknown", "law": {"form": {}}}', None],
)  # fmt: skip
def test_a_diagnosis_that_is_none(text, tmp_path):
    file = tmp_path / "diagnosis.json"
    os.mkfifo(file) if text is None else file.write_text(text)
    with pytest.raises(InputError, match=r"diagnosis\.json: (this is no|is a pipe)"):
        known_effects(str(file))
