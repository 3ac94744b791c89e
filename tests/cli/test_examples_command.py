"""``multilayer examples``: listed, copied, refused."""

import json
from pathlib import Path

import pytest

from multilayer.examples import WHAT, examples
from tests.cli.command import run

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_every_example_of_the_repository_is_listed():
    there = {path.stem if path.is_file() else path.name for path in EXAMPLES.iterdir() if path.name != "__pycache__"}
    assert there == set(WHAT) == set(examples())
    done = run("examples")
    assert done.status == 0
    assert all(what in done.out for what in WHAT.values())


@pytest.mark.parametrize("name", ["double_wall", "foam_tube"])
def test_a_copy_runs(name, tmp_path):
    done = run("examples", name, "--out", tmp_path)
    (copy,) = tmp_path.iterdir()
    assert (done.status, done.out, done.err) == (0, f"written to {copy}\n", "")
    files = [copy] if copy.is_file() else sorted(copy.glob("*.yaml"))
    assert run("check", *files).status == 0


def test_all_are_copied(tmp_path):
    done = run("examples", "--out", tmp_path / "new", "--json")
    assert {entry["name"] for entry in json.loads(done.out)} == set(WHAT)
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == sorted(p.name for p in examples().values())


def test_what_is_there_is_kept(tmp_path):
    (tmp_path / "double_wall.yaml").write_text("mine")
    done = run("examples", "foam_absorption", "double_wall", "--out", tmp_path)
    assert done.status == 2
    assert "double_wall.yaml: is there already; remove it" in done.err
    assert [path.read_text() for path in tmp_path.iterdir()] == ["mine"]


def test_a_name_that_is_none(tmp_path):
    done = run("examples", "foam_a", "--out", tmp_path / "new")
    assert (done.status, "did you mean 'foam_b'" in done.err, (tmp_path / "new").exists()) == (2, True, False)
