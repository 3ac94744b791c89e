"""``--verbose`` logs steps, ``--quiet`` leaves out warnings; in Python the steps are `logging`'s."""

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


def test_both_are_refused(sound_campaign):
    done = run("fit", sound_campaign, "--quiet", "--verbose")
    assert (done.status, done.err) == (2, "--verbose and --quiet contradict each other; give one of them\n")


@pytest.mark.parametrize("level", [logging.WARNING, logging.INFO])
def test_python(sound_campaign, caplog, level):
    with caplog.at_level(level, logger="multilayer"):
        fit_campaign(sound_campaign)
    assert bool(caplog.messages) == (level == logging.INFO)
