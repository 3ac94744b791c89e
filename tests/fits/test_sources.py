"""A source is opened once, whatever it is, and mistakes are told with their places."""

from collections import Counter
from pathlib import Path

import pytest

from multilayer.config import yaml12
from multilayer.errors import InputError
from multilayer.fits.run import FitTask
from multilayer.fits.sources import open_source, read_fit
from tests.cli.campaigns import write_calibration, write_campaign
from tests.cli.command import run

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture
def opened(monkeypatch):
    """Give how often each YAML file is parsed."""
    times: Counter[str] = Counter()
    compose = yaml12.compose

    def counted(text, file):
        times[Path(file).name] += 1
        return compose(text, file)

    monkeypatch.setattr(yaml12, "compose", counted)
    return times


@pytest.fixture
def campaign(tmp_path):
    return write_campaign(tmp_path / "foam")


def test_a_fit_file_is_parsed_once(campaign, tmp_path, opened):
    write_calibration(tmp_path / "calibration", 1.0, 0.0)
    (campaign / "fit.yaml").write_text("version: 1\ncampaign: .\ncalibration: ../calibration\n")
    FitTask(campaign).read()
    assert opened == {"fit.yaml": 1, "campaign.yaml": 2}  # that of the calibration, too
    opened.clear()
    FitTask(campaign / "fit.yaml", method="nelder-mead").read()
    assert opened["fit.yaml"] == 1


@pytest.mark.parametrize("name", ["", "campaign.yaml"])
def test_a_campaign_is_parsed_once(campaign, opened, name):
    FitTask(campaign / name).read()
    assert opened == {"campaign.yaml": 1}


def test_stacks_are_parsed_once(opened):
    FitTask(EXAMPLES / "foam_tube").read()
    assert opened["fit.yaml"] == 1


def test_a_diagnosis_parses_its_file_once(opened, tmp_path):
    done = run("diagnose", EXAMPLES / "foam_tube", "--without", "nothing", "--out", tmp_path / "out")
    assert done.status == 2
    assert opened["fit.yaml"] == 1


def test_kinds_are_told_once():
    assert (open_source(EXAMPLES / "foam_tube").kind, open_source(EXAMPLES / "foam_b").kind) == ("stack-fit", "fit")
    assert open_source(EXAMPLES / "foam_b" / "campaign.yaml").kind == "campaign"
    assert open_source(EXAMPLES / "foam_tube").of_stacks


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("version: 1\ncampaign: gone\n", "fit.yaml:2:11: campaign: there is no "),
        ("version: 1\ncampaign: .\ncalibration: gone\n", "fit.yaml:3:14: calibration: there is no "),
        ("kind: fit\nversion: 1\nmethod: joined\n", "fit.yaml:3:9: method: there is no method 'joined'; did you mean"),
        ("kind: fit\nmodel: finite\nmethod: nelder-mead\n", "fit.yaml:3:9: method: nelder-mead is the paper's method"),
        ("kind: stack\nlayers: []\n", "fit.yaml: this is a stack file; a fit needs a campaign folder or a fit file"),
        ("kind: diagnose\n", "fit.yaml: this is a stack-fit file; fit it by itself, without campaigns beside it"),
    ],
)
def test_mistakes_have_their_places(campaign, text, words):
    (campaign / "fit.yaml").write_text(text)
    with pytest.raises(InputError) as caught:
        read_fit(campaign)
    assert words in str(caught.value)
