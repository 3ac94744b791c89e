"""Every step of writing fails in every way: what is there is the old or the new one, and the next run is well."""

import os
import sys

import pytest

from multilayer.writing.folders import write_file, write_files, write_new
from validation.faults import MODES, try_all

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="copies of a process")
FAULTS = ("KILL before", "INT after", "EIO")  # of all that `python -m validation.faults` tries
OLD = {"fit.json": "1", "figures/a.png": b"png", "stale.csv": "a,b\n"}
NEW = {"fit.json": "2", "figures/a.png": b"gnp", "report.html": "<p>"}


def assert_sound(tally, at_least):
    assert tally.failures == []
    assert tally.whole + tally.pending == tally.tried
    assert tally.tried > at_least


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fsync", lambda handle: None)  # takes long, and no process loses what it has written
    (tmp_path / "here").mkdir()
    return tmp_path / "here" / "foam"


@pytest.mark.parametrize(
    ("mode", "there", "at_once"),
    [
        ("exchange", "nothing", True),
        pytest.param("exchange", "a result alone", True, marks=pytest.mark.slow),
        pytest.param("exchange", "the user's beside", False, marks=pytest.mark.slow),
        pytest.param("one by one", "nothing", True, marks=pytest.mark.slow),
        ("one by one", "the user's beside", False),
    ],
)
def test_a_folder(place, mode, there, at_once):
    older = None if there == "nothing" else lambda: write_files(place, OLD, made_by="fit")
    newer = lambda: write_files(place, NEW, made_by="fit")  # noqa: E731
    tally = try_all(place, newer, older, mode, FAULTS, alone=there == "a result alone")
    assert_sound(tally, 100)
    assert (tally.pending == 0) == at_once


@pytest.mark.slow
@pytest.mark.parametrize("mode", MODES)
def test_a_folder_and_its_truth_beside(place, mode):
    truth, hidden = place.with_name("foam.truth.json"), place.with_name("foam.hidden.json")
    older = lambda: write_files(place, OLD, made_by="rig", beside={hidden: b"old"})  # noqa: E731
    newer = lambda: write_files(place, NEW, made_by="rig", beside={truth: b"new"}, gone=[hidden])  # noqa: E731
    assert_sound(try_all(place, newer, older, mode, FAULTS[::2]), 100)


@pytest.mark.slow
def test_a_new_folder(place):
    assert_sound(try_all(place, lambda: write_new(place, NEW), None, MODES[0], FAULTS), 60)


@pytest.mark.parametrize("is_there", [False, True])
def test_a_file(place, is_there):
    older = (lambda: write_file(place, "old")) if is_there else None
    tally = try_all(place, lambda: write_file(place, "new"), older, MODES[0], FAULTS)
    assert_sound(tally, 40)
    assert tally.pending == 0
