"""Campaigns on disk, and one fit of them that many tests read."""

import shutil
from typing import NamedTuple

import pytest

from tests.cli.campaigns import write_campaign
from tests.cli.command import Outcome, run


@pytest.fixture(scope="session")
def sound_campaign(tmp_path_factory):
    """Give a campaign without mistakes, not to be written to."""
    return write_campaign(tmp_path_factory.mktemp("sound") / "foam")


@pytest.fixture
def campaign(sound_campaign, tmp_path):
    """Give a campaign without mistakes to spoil."""
    return shutil.copytree(sound_campaign, tmp_path / "foam")


class Fitted(NamedTuple):
    """What a fit printed, and the folder it wrote."""

    outcome: Outcome
    folder: object


@pytest.fixture(scope="session")
def fitted(sound_campaign, tmp_path_factory):
    """Give the fit of the sound campaign with default settings."""
    folder = tmp_path_factory.mktemp("fitted") / "results"
    return Fitted(run("fit", sound_campaign, "--out", folder), folder)
