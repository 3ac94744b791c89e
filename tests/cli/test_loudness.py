"""``--verbose`` logs steps, ``--quiet`` leaves out warnings; in Python the steps are `logging`'s."""

import html
import json
import logging

import pytest

from multilayer import fit_campaign
from tests.cli.command import run


def test_verbose_logs_every_burst(sound_campaign, tmp_path):
    done = run("fit", sound_campaign, "--verbose", "--no-figures", "--out", tmp_path / "out")
    steps = [line for line in done.err.splitlines() if line.endswith(" Hz: solved")]
    assert (done.status, len(steps)) == (0, len(list(sound_campaign.glob("signals/*"))))
    assert steps[0][:2] == "20"  # the date
    assert run("fit", sound_campaign, "--no-figures", "--out", tmp_path / "other").err == ""


def test_quiet_leaves_warnings_out(tmp_path):
    file = tmp_path / "thick.yaml"
    file.write_text("version: 1\ntermination: rigid\nfrequency: [100]\nlayers:\n  - {type: fluid, thickness: 50}\n")
    loud, quiet = (
        run("simulate", file, *option, "--no-figures", "--out", tmp_path / "o") for option in ((), ("--quiet",))
    )
    assert (loud.status, quiet.status, quiet.err) == (0, 0, "")
    assert loud.err.startswith("warning: ")
    assert loud.out == quiet.out


@pytest.mark.parametrize("options", [(), ("--quiet",)])
def test_results_hold_the_warnings(tmp_path, options):
    file, out = tmp_path / "thick.yaml", tmp_path / "out"
    file.write_text(
        "version: 1\ntermination: rigid\nfrequency: [100, 20000]\nlayers:\n  - {type: fluid, thickness: 50}\n"
        "  - {type: equivalent_fluid, model: delany_bazley, thickness: 0.05, flow_resistivity: 5000}\n"
    )
    done = run("simulate", file, *options, "--out", out)
    warned = json.loads((out / "simulation.json").read_text())["warnings"]
    page = html.unescape((out / "report.html").read_text())
    assert warned
    assert done.err.splitlines() == ([] if options else [f"warning: {text}" for text in warned])
    assert all(text in page for text in warned)
    assert "What to mind" in page

    file.write_text("version: 1\ntermination: rigid\nfrequency: [100]\nlayers:\n  - {type: fluid, thickness: 0.1}\n")
    assert run("simulate", file, "--out", out).err == ""
    assert json.loads((out / "simulation.json").read_text())["warnings"] == []
    assert "What to mind" not in (out / "report.html").read_text()


def test_both_are_refused(sound_campaign):
    done = run("fit", sound_campaign, "--quiet", "--verbose")
    assert (done.status, done.err) == (2, "--verbose and --quiet contradict each other; give one of them\n")


@pytest.mark.parametrize("level", [logging.WARNING, logging.INFO])
def test_python(sound_campaign, caplog, level):
    with caplog.at_level(level, logger="multilayer"):
        fit_campaign(sound_campaign)
    assert bool(caplog.messages) == (level == logging.INFO)
