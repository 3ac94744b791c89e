"""``multilayer fit`` with several campaigns: one folder each, a summary, and going on after a stop."""

import csv
import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from warnings import warn

import pytest

from multilayer.errors import MultilayerError, PlausibilityWarning
from multilayer.fits import run as fit_run
from tests.cli.campaigns import write_campaign
from tests.cli.command import run
from tests.explore.command import SCRIPT


@pytest.fixture
def three(tmp_path: Path) -> list[Path]:
    folders = [tmp_path / name for name in ("a", "b", "c")]
    for folder in folders:
        write_campaign(folder)
    return folders


def summary(folder: Path) -> list[dict[str, str]]:
    return list(csv.DictReader((folder / "summary.csv").read_text().splitlines()))


def test_each_has_a_folder_and_a_row(three, tmp_path):
    out = tmp_path / "out"
    done = run("fit", *three, "--out", out, "--no-figures")
    assert done.status == 0, done.err
    assert {path.name for path in out.iterdir()} == {"a", "b", "c", "summary.csv"}
    assert [row["campaign"] for row in summary(out)] == ["a", "b", "c"]
    assert {row["accepted"] for row in summary(out)} == {"3"}
    assert "median E1" in done.out


def test_processes_give_the_same(three, tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"
    assert run("fit", *three, "--out", one, "--no-figures").status == 0
    assert run("fit", *three, "--out", two, "--no-figures", "--jobs", "2").status == 0
    for name in ("a", "b", "c"):
        assert (one / name / "moduli.csv").read_text() == (two / name / "moduli.csv").read_text()


def test_resume_leaves_out_what_is_done_and_does_what_changed(three, tmp_path):
    out = tmp_path / "out"
    run("fit", *three, "--out", out, "--no-figures")
    files = [out / name / "fit.json" for name in ("a", "b", "c")]
    before = [file.stat().st_mtime_ns for file in files]
    description = three[1] / "campaign.yaml"
    description.write_text(description.read_text().replace("density: 90", "density: 91"))
    again = run("fit", *three, "--out", out, "--no-figures", "--resume")
    assert again.status == 0
    changed = [file.stat().st_mtime_ns != time_before for file, time_before in zip(files, before, strict=True)]
    assert changed == [False, True, False]
    assert len(summary(out)) == 3


def test_resume_of_one_campaign(three, tmp_path):
    out = tmp_path / "out"
    assert run("fit", three[0], "--out", out, "--no-figures").status == 0
    again = run("fit", three[0], "--out", out, "--no-figures", "--resume")
    assert again.status == 0
    assert "nothing to do" in again.out
    other = run("fit", three[0], "--out", out, "--no-figures", "--resume", "--model", "plane_wave", "--joint")
    assert "nothing to do" not in other.out


def test_a_mistake_in_one_stops_all_before_anything_is_computed(three, tmp_path):
    (three[2] / "signals" / "0400.npz").unlink()
    done = run("fit", *three, "--out", tmp_path / "out")
    assert done.status == 2
    assert "0400.npz" in done.err
    assert not (tmp_path / "out").exists()


def test_two_of_one_name_are_refused(three, tmp_path):
    done = run("fit", three[0], three[0], "--out", tmp_path / "out")
    assert done.status == 2
    assert "there twice" in done.err


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_what_is_done_stays_after_ctrl_c(three, tmp_path):
    out = tmp_path / "out"
    command = [sys.executable, "-c", SCRIPT, "fit", *map(str, three), "--out", str(out), "--no-figures"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    while not (out / "a" / "fit.json").exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    if process.returncode == 0:
        pytest.skip("all were done before the signal came")
    assert process.returncode == 130
    assert "--resume goes on from there" in err
    assert json.loads((out / "a" / "fit.json").read_text())["all_accepted"]
    assert not (out / "summary.csv").exists()
    assert run("fit", *three, "--out", out, "--no-figures", "--resume").status == 0
    assert len(summary(out)) == 3


@pytest.mark.parametrize(
    "failure", [MultilayerError("no finite elements\nof it"), ArithmeticError("no finite elements of it")]
)
def test_one_that_cannot_be_fitted_is_a_row_and_the_others_go_on(three, tmp_path, monkeypatch, failure):
    whole = fit_run.FitRun.run

    def run_or_fail(fit, *given):
        if fit.name == "b":
            raise failure
        if fit.name == "c":
            warn("its noise is large", PlausibilityWarning, stacklevel=1)
        return whole(fit, *given)

    monkeypatch.setattr(fit_run.FitRun, "run", run_or_fail)
    out = tmp_path / "out"
    done = run("fit", *three, "--out", out, "--no-figures")
    assert done.status == 1, done.err
    assert "no finite elements of it" in done.out
    assert done.err.count("warning: its noise is large") == 1
    assert json.loads((out / "c" / "fit.json").read_text())["warnings"] == ["its noise is large"]
    assert {path.name for path in out.iterdir()} == {"a", "c", "summary.csv"}
    assert [row["accepted"] for row in summary(out)] == ["3", "0", "3"]
    monkeypatch.undo()
    again = run("fit", *three, "--out", out, "--no-figures", "--resume")
    assert (again.status, [row["accepted"] for row in summary(out)]) == (0, ["3", "3", "3"])
