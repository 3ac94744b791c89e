"""Diagnoses of tubes whose effect is known."""

import json
from dataclasses import replace

import numpy as np
import pytest

from multilayer.arrays import ComplexArray
from multilayer.config.yaml12 import dump_yaml
from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.effects.sample_position import SamplePosition
from multilayer.diagnosis.effects.tube import Tube, TubeSetting, Values, with_layers
from multilayer.diagnosis.file import diagnosis_file, load_diagnosis, tube_names
from multilayer.diagnosis.nominal import nominal_minimum
from multilayer.diagnosis.tube.data import roughness
from multilayer.diagnosis.tube.diagnose import N_STEPS, diagnose_tube
from multilayer.errors import InputError, PluginWarning
from multilayer.experiments.hypothesis import Data, Hypothesis
from multilayer.inference.problem import GaussianPrior
from multilayer.layers.fluid import Fluid
from multilayer.response import plane_wave
from multilayer.stack import Stack
from tests.diagnosis.tubes import CASES, ELASTIC, NOISE, PRIORS, F, foam, measured, reflection, table

KEYS = {"version", "verdict", "where", "causes", "group", "gap", "unknowns", "detectable", "next_experiment"}
RIVALS = ("sample_position", "microphone_gain")


def test_every_effect_of_tubes_is_tried():
    assert set(CASES) == set(tube_names())


@pytest.mark.parametrize("name", CASES)
def test_an_effect_is_named_with_its_size(tmp_path, name):
    file = measured(tmp_path, {name: CASES[name]}, effects=list(dict.fromkeys((name, *RIVALS))))
    record = diagnose_tube(file).record
    assert record["verdict"] == "effect", record["sentence"]
    assert [name] in record["group"]
    first = next(iter(CASES[name]))
    size = next(c for c in record["causes"] if c["effects"] == [name])["parameters"][f"{name}.{first}"]
    assert size["low"] < CASES[name][first] < size["high"]
    assert record["gap"]["held_out"] == "leave one configuration out"


def test_without_an_effect_there_is_no_gap(tmp_path):
    told = []
    found = diagnose_tube(measured(tmp_path, {}, effects=[*RIVALS, "rear_air_gap"]), progress=told.append)
    record = json.loads(found.to_json())
    assert len(told) == N_STEPS
    assert set(record) >= KEYS
    assert (record["verdict"], record["causes"], record["where"]) == ("no_gap", [], [])
    assert record["detectable"]["rear_air_gap"]["smallest"] < 0.01
    assert found.curves[0].labels == ("Re R", "Im R")


def test_an_effect_keeps_the_contacts_of_a_stack():
    sheet = {"type": "membrane", "surface_density": 0.5}
    layers = [sheet, *foam(0.03, ELASTIC)["layers"]]
    stack = Stack.model_validate({
        "layers": layers, "termination": "rigid",
        "contacts": [{"between": [0, 1], "kind": "slip"}, {"between": [1, "termination"], "kind": "slip"}],
    })  # fmt: skip
    setting = TubeSetting("tube", F, 0.0, stack, Tube())
    before = setting.reflection(stack)
    front, behind = (
        with_layers(stack, layers)
        for layers in ((Fluid(thickness=1e-9), *stack.layers), (*stack.layers, Fluid(thickness=1e-9)))
    )
    assert front.interfaces == ("bonded", "bonded", "slip", "slip")
    assert behind.interfaces == ("bonded", "slip", "bonded", "bonded")
    np.testing.assert_allclose(setting.reflection(front), before, rtol=1e-5)
    assert with_layers(stack, stack.layers[::-1]).contacts == ()


class Silent(SamplePosition):
    """An effect of a plugin that never gives a number."""

    name = "silent"

    def reading(self, setting: TubeSetting, reflection: ComplexArray, values: Values) -> ComplexArray:
        return np.nan * super().reading(setting, reflection, values)


def test_an_effect_that_never_responds_is_left_out_and_told(tmp_path):
    file = measured(tmp_path, {"microphone_gain": {"gain": 0.03}}, effects=["microphone_gain"])
    effects = {effect.name: effect for effect in (Silent(), EFFECTS["microphone_gain"]())}
    with pytest.warns(PluginWarning, match="effect silent: the model has no response"):
        record = diagnose_tube(file, effects=effects).record
    assert record["group"] == [["microphone_gain"]]


def test_of_one_measurement_blocks_of_frequencies_are_left_out(tmp_path):
    file = measured(tmp_path, {"rear_air_gap": {"depth": 0.02}}, (0.03,), effects=["rear_air_gap", *RIVALS])
    record = diagnose_tube(file).record
    assert record["group"][0] == ["rear_air_gap"]
    assert record["gap"]["held_out"].startswith("contiguous blocks of frequencies")
    assert record["gap"]["shrinkage"] > 0.9
    assert record["where"][0]["quantity"] in ("real", "imag")
    # no known rival comes within 100 nats
    assert all("unknown" in plan["separates"][1] for plan in record["next_experiment"])
    nominal, corrected = (record["unknowns"]["layers.foam.flow_resistivity"][key] for key in ("nominal", "corrected"))
    assert abs(corrected / 1.2e4 - 1) < abs(nominal / 1.2e4 - 1)


def test_the_nominal_hypothesis_is_the_stack(tmp_path):
    hypothesis: Hypothesis = measured(tmp_path, {}).hypothesis
    data: Data = hypothesis.data[0]
    z = np.array([float(p.prior.coordinate(v)) for p, v in zip(hypothesis.parameters, (1.2e4, 1.3), strict=True)])
    expected = plane_wave(Stack.model_validate(foam(0.03)), data.frequency).reflection
    np.testing.assert_allclose(hypothesis.predict(z)[0], expected, rtol=1e-12)
    batch = hypothesis.differences(np.stack([z, z + 0.1]))[1]
    np.testing.assert_allclose(batch[1], hypothesis.differences(z + 0.1)[1], rtol=1e-12)


def test_groups_are_left_out_whole(tmp_path):
    (data,) = measured(tmp_path, {}, (0.03,)).observations
    part = data.part(np.array([0, 2]))
    assert set(part.burst) == {0, 1}
    np.testing.assert_array_equal(part.frequency, data.frequency[np.isin(data.burst, [0, 2])])


@pytest.mark.parametrize("name", ["microphone_gain", "microphone_phase", "temperature"])
def test_a_transfer_function_leads_back_to_what_was_reflected(tmp_path, name):
    setting = measured(tmp_path, {}, (0.03,)).hypothesis.settings[0]
    r = reflection(0.03, {})
    read = setting.transfer_function(r, setting.wavenumber)
    np.testing.assert_allclose(setting.evaluated(read), r, rtol=1e-10)
    parameter = EFFECTS[name].parameters[0].name
    np.testing.assert_allclose(reflection(0.03, {name: {parameter: 0.0}}), r, rtol=1e-10)


def test_noise_is_estimated_and_that_is_said(tmp_path):
    rng = np.random.default_rng(3)
    f = np.geomspace(200, 2000, 400)
    r = reflection(0.03, {}, f) + NOISE * (rng.standard_normal(400) + 1j * rng.standard_normal(400))
    assert roughness(r) == pytest.approx(NOISE, rel=0.15)
    (tmp_path / "tube.csv").write_text(table(r, f))
    search = {"starts": 1, "candidates": 8}
    file = diagnosis_file(
        tmp_path, nominal=foam(0.03), measurements=[{"kind": "reflection", "file": "tube.csv"}], unknowns=PRIORS,
        effects=list(RIVALS), search=search,
    )  # fmt: skip
    record = diagnose_tube(file).record
    assert "no noise is said" in record["warnings"][0]
    assert record["inputs"]["noise"]["reflection tube"].startswith("estimated, 0.00")
    assert record["verdict"] == "no_gap"


def test_names_and_the_order_of_rows_say_nothing(tmp_path):
    r = reflection(0.03, {"sample_position": {"distance": 4e-3}})
    lines = table(r).splitlines()
    shuffled = [lines[0], *np.random.default_rng(2).permutation(lines[1:])]
    evidences = []
    for name, rows in (("sample_position", lines), ("microphone_gain", shuffled)):
        (tmp_path / f"{name}.csv").write_text("\n".join([*rows, ""]))
        measurement = {"kind": "reflection", "file": f"{name}.csv", "noise": {"absolute": NOISE}}
        search = {"starts": 1, "candidates": 8}
        file = diagnosis_file(
            tmp_path, nominal=foam(0.03), measurements=[measurement], unknowns=PRIORS, effects=list(RIVALS),
            search=search,
        )  # fmt: skip
        record = diagnose_tube(file, name).record
        evidences.append([(cause["effects"], cause["log_evidence"]) for cause in record["causes"]])
    assert evidences[0] == evidences[1]
    assert evidences[0][0][0] == ["sample_position"]


def test_what_a_reference_says_is_known(tmp_path):
    reference = measured(tmp_path, {}, (0.06,))
    (tmp_path / "cavity").mkdir()
    chosen = ["rear_air_gap", "thickness_error"]
    file = measured(tmp_path / "cavity", {"rear_air_gap": {"depth": 0.004}}, (0.03,), effects=chosen)
    known = GaussianPrior.of(nominal_minimum(reference))
    hypothesis = replace(file.hypothesis, earlier=known)
    np.testing.assert_array_equal(hypothesis.own_coordinates(hypothesis.start), known.mean)
    values = diagnose_tube(file.with_reference(reference)).record["unknowns"]
    corrected = values["layers.foam.flow_resistivity"]["corrected"]
    assert corrected == pytest.approx(1.2e4, rel=0.05)


def test_a_reference_has_none_itself(tmp_path):
    text = (
        "kind: diagnose\nversion: 1\nnominal: foam.yaml\nmeasurements: [{kind: reflection, file: r.csv, noise: 0.02}]\n"
        "unknowns: {layers.foam.flow_resistivity: {lognormal: [1.2e4, 0.5]}}\nreference: REFERENCE\n"
    )
    (tmp_path / "foam.yaml").write_text(dump_yaml(foam(0.03)))
    (tmp_path / "r.csv").write_text(table(reflection(0.03, {})))
    for name, reference in (("itself", "itself"), ("first", "second"), ("second", "first")):
        (tmp_path / f"{name}.yaml").write_text(text.replace("REFERENCE", f"{reference}.yaml"))
    for name in ("itself", "first"):
        with pytest.raises(InputError, match="a file that is a reference cannot have one itself"):
            load_diagnosis(tmp_path / f"{name}.yaml")


@pytest.mark.reference
def test_a_cavity_behind_plants_is_found(shared):
    from validation.tube_gaps import WIDE, delft, sure_from

    name = "Grass 6 cm"
    sure = sure_from("plants", {name: 0.06}, WIDE)
    file = delft("plants", {f"{name} + cavity 3 cm": 0.06}, WIDE, sure.error).with_reference(sure.file)
    chosen = {key: EFFECTS[key]() for key in ("rear_air_gap", "thickness_error", "sample_position")}
    record = diagnose_tube(file, effects=chosen).record
    assert "rear_air_gap" in record["causes"][0]["effects"]
    depth = next(c for c in record["causes"] if c["effects"] == ["rear_air_gap"])["parameters"]["rear_air_gap.depth"]
    assert depth["value"] == pytest.approx(0.03, rel=0.2)
    assert depth["low"] < 0.03 < depth["high"]
