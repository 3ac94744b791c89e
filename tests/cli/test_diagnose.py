"""``multilayer diagnose`` and ``multilayer effects``."""

import json

import pytest

from tests.cli.campaigns import write_campaign
from tests.cli.command import run


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory):
    folder = write_campaign(tmp_path_factory.mktemp("campaign") / "foam")
    out = folder.parent / "out"
    return run("diagnose", folder, "--out", out), out


def test_it_writes_record_report_and_figures(diagnosed):
    done, out = diagnosed
    record = json.loads((out / "diagnosis.json").read_text())
    # the sample of these signals is held at its rim, as the nominal model has it
    assert (done.status, record["verdict"]) == (0, "no_gap"), done.err
    assert (out / "report.html").read_text().lstrip().lower().startswith("<!doctype html>")
    assert any(path.suffix == ".png" for path in out.iterdir())
    assert record["sentence"] in " ".join(done.out.split())


def test_what_the_campaign_does_not_state_is_told(diagnosed):
    done, out = diagnosed
    text = "uncertainty: not stated, so taken as usual of a careful laboratory: remount_gain 0.001; state"
    assert text in " ".join(done.err.split())
    assert [text in warning for warning in json.loads((out / "diagnosis.json").read_text())["warnings"]] == [True]
    assert text in " ".join((out / "report.html").read_text().split())


def test_an_effect_that_is_not_there_is_told(tmp_path):
    folder = write_campaign(tmp_path / "foam")
    done = run("diagnose", folder, "--without", "sensor_mas", "--out", tmp_path / "out")
    assert done.status == 2
    assert "did you mean 'sensor_mass'" in done.err
    assert not (tmp_path / "out").exists()


def test_effects_are_listed():
    done = run("effects")
    assert done.status == 0
    assert "sensor_mass" in done.out
    found = json.loads(run("effects", "--json").out)
    assert {"name", "law", "parameters", "separated_by", "source"} <= set(found[0])
    (finer,) = [effect["finer_parameters"] for effect in found if effect["name"] == "delamination"]
    assert [parameter["name"] for parameter in finer] == ["depth"]
