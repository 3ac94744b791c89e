"""Answers to the page of a model beside its measurements."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from multilayer.diagnosis.effects.base import EFFECTS
from multilayer.explore.model import ModelExplorer
from multilayer.fits.sources import open_source
from multilayer.inference.problem import GaussianPrior
from multilayer.response import plane_wave
from tests.cli.command import run
from tests.cli.test_diagnose_levels import write
from tests.fits import stack_fits

EXAMPLES = Path("examples")


@pytest.fixture(scope="module")
def tube():
    """Give the foam in a tube."""
    return ModelExplorer(open_source(EXAMPLES / "foam_tube"))


@pytest.fixture(scope="module")
def rig():
    """Give a campaign."""
    return ModelExplorer(open_source(EXAMPLES / "foam_b"))


@pytest.fixture(scope="module")
def wall(tmp_path_factory):
    """Give a board's transmission loss in third octaves, of which 4 dB are missing."""
    return ModelExplorer(open_source(write(tmp_path_factory.mktemp("wall"))))


@pytest.fixture(params=["tube", "rig", "wall"])
def explorer(request):
    """Give each of them."""
    return request.getfixturevalue(request.param)


def effect_of(explorer, name):
    return next(one for one in explorer.answer("start", {})["effects"] if one["name"] == name)


def test_it_begins_at_the_fitted_nominal_model(explorer):
    start, minimum = explorer.answer("start", {}), explorer.model.fitted.minimum
    assert start["z"] == minimum.z.tolist()
    assert len(start["unknowns"]) == len(start["z"])
    answer = explorer.answer("evaluate", {"z": start["z"], "effects": {}})
    assert answer["problems"] == []
    assert answer["misfit"] == pytest.approx(minimum.misfit / len(minimum.residual), rel=1e-6)
    assert len(answer["misfits"]) == len(start["configurations"])
    assert set(answer["values"]) == {one["name"] for one in start["unknowns"]}
    data, differences = explorer.hypothesis.data[0], explorer.hypothesis.differences(minimum.z)[0]
    for i, (part, shown) in enumerate(zip(explorer.hypothesis.shown_as, answer["curves"]["parts"], strict=True)):
        gap = part.factor * (differences.imag if i else differences.real)
        assert np.array(shown["model"]) - np.array(shown["measured"]) == pytest.approx(gap, abs=2e-3 * part.factor)
        assert len(shown["spread"]) == len(data.frequency)
    json.dumps(answer, allow_nan=False)


def test_an_effect_that_is_turned_changes_the_model_and_may_be_fitted(rig):
    z, effect = rig.answer("start", {})["z"], effect_of(rig, "sensor_mass")
    asked = {"z": z, "effects": {"sensor_mass": effect["z"]}, "beside": {"z": z, "effects": {}}}
    before = rig.answer("evaluate", asked)
    assert before["values"]["sensor_mass.mass"] == {"text": "1", "unit": "g", "factor": 1e-3}
    (level, _), (nominal, _) = (
        part["parts"] for part in (before["curves"], rig.answer("evaluate", {"z": z})["curves"])
    )
    assert level["beside"] == nominal["model"]
    assert level["model"] != nominal["model"]
    fitted = rig.answer("fit", asked)
    assert fitted["misfit"] < 0.9 * before["misfit"]
    held = rig.answer("fit", asked | {"held": ["sensor_mass.mass"]})
    assert held["effects"]["sensor_mass"][0] == effect["z"][0]
    assert held["effects"]["sensor_mass"][1] != effect["z"][1]
    everything = rig.answer("fit", asked | {"held": list(before["values"])})
    assert (everything["z"], everything["effects"]) == (before["z"], before["effects"])


def test_every_effect_there_is_can_be_turned(explorer):
    start = explorer.answer("start", {})
    assert {one["name"] for one in start["effects"]} <= set(EFFECTS.names())
    assert start["effects"]
    for effect in start["effects"]:
        answer = explorer.answer("evaluate", {"z": start["z"], "effects": {effect["name"]: effect["z"]}})
        assert answer["problems"] == [], effect["name"]
        assert answer["effects"] == {effect["name"]: effect["z"]}


def test_missing_decibels_are_received_elsewhere(wall):
    z, effect = wall.answer("start", {})["z"], effect_of(wall, "receiving_absorption")
    fitted = wall.answer("fit", {"z": z, "effects": {"receiving_absorption": effect["z"]}})
    (name,) = (one["name"] for one in effect["unknowns"])
    assert abs(float(fitted["values"][name]["text"])) == pytest.approx(4, abs=0.5)
    assert fitted["misfit"] < 0.2 * wall.answer("evaluate", {"z": z, "effects": {}})["misfit"]
    (part,) = fitted["curves"]["parts"]
    assert np.array(part["model"]) == pytest.approx(np.array(part["measured"]), abs=2)


def test_a_rim_needs_finite_elements_which_are_made_once(rig):
    z, effect = rig.answer("start", {})["z"], effect_of(rig, "finite_size")
    assert effect["slow"]
    asked = {"z": z, "effects": {"finite_size": effect["z"]}}
    assert rig.answer("fit", asked)["misfit"] < 1
    made = rig.hypothesis.finite
    assert made
    rig.answer("evaluate", asked)
    assert rig.hypothesis.finite is made


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("layers.foam.flow_resistivity", "12", 12e3),  # in the unit beside the box
        ("layers.foam.flow_resistivity", "1.1e4 N*s/m^4", 11e3),
        ("layers.foam.viscous_length", "0.08 mm", 80e-6),
    ],
)
def test_a_value_may_be_typed(name, text, value, tube):
    z = tube.answer("start", {})["z"]
    shown = tube.answer("evaluate", {"z": z, "typed": {"name": name, "text": text}})["values"][name]
    assert float(shown["text"]) * shown["factor"] == pytest.approx(value, rel=1e-3)


def test_what_is_shown_may_be_typed_with_its_unit(explorer):
    start = explorer.answer("start", {})
    for effect in [None, *(one for one in start["effects"] if not one["slow"])]:
        asked = {"z": start["z"], "effects": {effect["name"]: effect["z"]} if effect else {}}
        shown = explorer.answer("evaluate", asked)["values"]
        for name in {one["name"] for one in (effect or start)["unknowns"]} & set(shown):
            text = f"{shown[name]['text']} {shown[name]['unit']}"
            answer = explorer.answer("evaluate", asked | {"typed": {"name": name, "text": text}})
            assert answer["problems"] == [], text
            assert answer["values"][name] == shown[name]


def test_what_an_earlier_measurement_tells_is_no_obstacle_to_typing(tube):
    minimum = tube.model.fitted.minimum
    explorer = ModelExplorer.__new__(ModelExplorer)
    explorer.__dict__ |= tube.__dict__
    explorer.hypothesis = replace(tube.hypothesis, earlier=GaussianPrior.of(minimum))
    explorer.answers = {"evaluate": explorer.evaluate}
    name, z = "layers.foam.flow_resistivity", [0.0] * len(minimum.z)
    now = explorer.answer("evaluate", {"z": z})["values"][name]
    wanted = 1.01 * float(now["text"])
    shown = explorer.answer("evaluate", {"z": z, "typed": {"name": name, "text": f"{wanted}"}})["values"][name]
    assert float(shown["text"]) == pytest.approx(wanted, rel=1e-3)


def test_a_law_is_shown_by_itself_and_not_by_its_logarithm(rig):
    z, name = rig.answer("start", {})["z"], "ln relaxed_modulus"
    shown = rig.answer("evaluate", {"z": z, "typed": {"name": name, "text": "70 kPa"}})["values"][name]
    assert shown == {"text": "70", "unit": "kPa", "factor": 1e3}


def test_a_law_of_a_stack_has_its_units(tmp_path):
    truth = stack_fits.stack(stack_fits.FOAM)
    reflection = plane_wave(truth, stack_fits.F).reflection
    tables = {"tube.csv": stack_fits.parts("frequency_hz,real,imag", stack_fits.F, reflection)}
    columns = {"real": "real", "imag": "imag"}
    measurement = {"kind": "reflection", "file": "tube.csv", "columns": columns, "noise": {"absolute": 0.01}}
    unknowns = {"E": {"paths": "layers.foam.young_modulus", "law": "fractional_zener"}}
    explorer = ModelExplorer(open_source(stack_fits.write(tmp_path, truth, tables, [measurement], unknowns)))
    z, name = explorer.answer("start", {})["z"], "ln E.relaxed_modulus"
    shown = explorer.answer("evaluate", {"z": z, "typed": {"name": name, "text": "70 kPa"}})["values"][name]
    assert shown == {"text": "70", "unit": "kPa", "factor": 1e3}


@pytest.mark.parametrize(
    ("request_", "told"),
    [
        ({"z": [0.0]}, "coordinates are needed"),
        ({"z": None}, "coordinates are needed"),
        ({"z": "all"}, "coordinates are needed"),
        ({"effects": []}, "by name"),
        ({"effects": {"no_such": []}}, "no effect 'no_such'"),
        ({"effects": {"facing": []}}, "coordinates are needed"),
        ({"effects": {"facing": [None, 1.0]}}, "coordinates are needed"),
        ({"typed": {"name": "no_such", "text": "1"}}, "no unknown 'no_such'"),
        ({"typed": "text"}, "no unknown"),
        ({"typed": {"name": "layers.foam.porosity", "text": "\x1b[2J"}}, "porosity"),
        ({"typed": {"name": "layers.foam.porosity", "text": "nan"}}, "no number"),
        ({"typed": {"name": "layers.foam.flow_resistivity", "text": "-3"}}, "not above 0"),
        ({"typed": {"name": "layers.foam.flow_resistivity", "text": "3 kg"}}, "flow resistivity"),
    ],
)
def test_a_question_that_cannot_be_answered_says_why(request_, told, tube):
    answer = tube.answer("evaluate", {"z": tube.answer("start", {})["z"], **request_})
    (problem,) = answer["problems"]
    assert told in problem["text"]
    assert "\x1b" not in problem["text"]


@pytest.mark.parametrize("error", [ValueError("array must not contain infs or NaNs"), np.linalg.LinAlgError("SVD")])
def test_a_descent_that_overflows_is_told(error, tube, monkeypatch):
    def fail(*_):
        raise error

    monkeypatch.setattr("multilayer.explore.model.minimise_scaled", fail)
    (problem,) = tube.answer("fit", {"z": tube.answer("start", {})["z"]})["problems"]
    assert "no response near here" in problem["text"]


def test_a_fit_from_where_the_air_is_colder_than_can_be_is_told(tube):
    asked = {"z": tube.answer("start", {})["z"], "effects": {"temperature": [-4000.0]}}
    (problem,) = tube.answer("fit", asked)["problems"]
    assert "no response near here" in problem["text"]


def test_measurements_have_no_others_beside_them(tmp_path):
    done = run("explore", str(EXAMPLES / "foam_tube"), "--measured", "other.csv", "--no-browser")
    assert done.status == 2
    assert "measurements of its own" in done.err
