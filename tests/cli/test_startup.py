"""How the command starts, helps, and fails."""

import json
import re
from importlib.metadata import version

import pytest

import multilayer
from multilayer.cli import app
from tests.cli.command import python, run, run_elsewhere

HEAVY = ("numpy", "scipy", "matplotlib", "pint", "pydantic", "skfem")
COMMANDS = [command.name or command.callback.__name__ for command in app.registered_commands]


@pytest.mark.parametrize("statement", ["import multilayer", "import multilayer.cli"])
def test_importing_is_cheap(statement):
    done = python("-c", f"{statement}, json, sys; print(json.dumps(list(sys.modules)))")
    assert (done.status, done.err) == (0, "")
    loaded = json.loads(done.out)
    assert "multilayer" in loaded
    assert [name for name in HEAVY if name in loaded] == []


def test_public_names_are_all_there():
    assert sorted(multilayer.__all__) == sorted(multilayer._HOMES)
    for name in multilayer.__all__:
        assert name == "LAYERS" or getattr(multilayer, name).__name__ == name
    assert set(multilayer.__all__) <= set(dir(multilayer))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = multilayer.nothing


def test_help_lists_the_commands():
    done = run_elsewhere("--help")
    assert (done.status, done.err) == (0, "")
    assert "Usage: multilayer [OPTIONS] COMMAND" in done.out
    assert {"simulate", "compare", "fit", "layers", "check"} <= set(COMMANDS)
    for command in COMMANDS:
        assert f"│ {command} " in done.out


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_every_command_shows_an_example(command):
    done = run(command, "--help")
    assert (done.status, done.err) == (0, "")
    assert f"Usage: multilayer {command}" in done.out
    assert f"Example: multilayer {command}" in done.out


def test_example_of_fit_is_the_job_of_make_fit():
    assert "Example: multilayer fit examples/foam_b --out results/foam_b" in run("fit", "--help").out


def test_help_of_fit_says_what_the_exit_status_means():
    text = " ".join(run("fit", "--help").out.split())
    assert re.search("Exit status: 0 all( bursts)? accepted, 1 some have no accepted solution", text)
    assert "2 the input cannot be used (nothing is written)" in text


def test_version():
    done = run("--version")
    assert (done.status, done.out, done.err) == (0, f"{version('multilayer')}\n", "")


def test_without_a_command_the_help_is_shown():
    done = run()
    assert done.status == 2
    assert "│ fit " in done.out + done.err


class TestUnexpectedError:
    @pytest.fixture(autouse=True)
    def broken(self, monkeypatch):
        def fail(*arguments):
            raise RuntimeError("the roof fell in")

        monkeypatch.setattr("multilayer.fits.run.open_source", fail)

    def test_is_told_without_a_traceback(self, tmp_path):
        done = run("fit", "anything", "--out", tmp_path / "out")
        assert done.status == 70
        assert done.out == ""
        assert "Traceback" not in done.err
        assert "RuntimeError: the roof fell in" in done.err
        assert "This is a bug: please report it" in done.err
        assert "MULTILAYER_DEBUG=1" in done.err
        assert len(done.err.splitlines()) == 1
        assert not (tmp_path / "out").exists()

    def test_is_raised_for_who_wants_the_traceback(self):
        done = run("fit", "anything", MULTILAYER_DEBUG="1")
        assert done.status == 1
        assert done.err.startswith("Traceback")
        assert done.err.endswith("RuntimeError: the roof fell in\n")
