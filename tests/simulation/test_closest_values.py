"""Values of single fields that bring a prediction closest to a measurement."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from multilayer.config import parse_yaml
from multilayer.layers import Layer
from multilayer.layers.fluid import fluid_faces
from multilayer.paths import locate, with_values
from multilayer.simulation import SimulationFile
from multilayer.simulation.closest_values import TOLD, closest_values
from multilayer.simulation.file import load_simulation
from multilayer.simulation.run import plan
from multilayer.simulation.tasks import run_task
from multilayer.units import Length
from tests.simulation.files import FOAM, FOAM_BESIDE_CHAMBER, PANEL

EXAMPLES = Path(__file__).parents[2] / "examples"
BANDS = {"third_octaves": ["250 Hz", "1 kHz"]}
LINES = {"from": "200 Hz", "to": "2 kHz", "points": 40}
SIZE = {"width": "1.2 m", "height": "1.5 m"}
DIFFUSE = {"diffuse": {"max_angle": 78}}


def task_of(text, **keys):
    """Return the nominal task of a simulation."""
    file = SimulationFile.model_validate({**parse_yaml(text, "stack.yaml").data, "frequency": LINES, **keys})
    return plan(file).tasks[0]


def measured(task, quantity, **values):
    """Return what a stack with other values would show."""
    changed = {f"layers.{path.replace('__', '.')}": value for path, value in values.items()}
    return run_task(replace(task, stack=with_values(task.stack, changed), deviations={})).quantities[quantity]


def sought(task, quantity, data):
    """Return the closest values where no field was left out."""
    found, left_out = closest_values(task, quantity, data)
    assert left_out == []
    return found


CASES = [
    pytest.param(FOAM, {}, "absorption", "foam__flow_resistivity", 22e3, id="absorption"),
    pytest.param(FOAM, {"incidence": 45}, "reflection", "foam__thickness", 0.06, id="reflection, oblique"),
    pytest.param(FOAM, {}, "normalised_impedance", "foam__viscous_length", 70e-6, id="impedance"),
    pytest.param(FOAM, {"finite_size": SIZE}, "absorption", "foam__thickness", 0.046, id="finite size"),
    pytest.param(FOAM, {"frequency": BANDS}, "absorption", "foam__thickness", 0.046, id="bands"),
    pytest.param(FOAM, {"incidence": DIFFUSE}, "absorption", "foam__flow_resistivity", 12e3, id="diffuse"),
    pytest.param(PANEL, {}, "transmission_loss", "gap__thickness", 0.062, id="loss"),
    pytest.param(PANEL, {}, "transmission", "gap__thickness", 0.045, id="transmission"),
    pytest.param(
        PANEL, {"incidence": DIFFUSE, "frequency": BANDS}, "transmission_loss", "gap__thickness", 0.04,
        id="diffuse loss in bands",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("text", "keys", "quantity", "path", "value"), CASES)
def test_the_field_that_differs_comes_first_with_its_value(text, keys, quantity, path, value):
    task = task_of(text, **keys)
    best, *others = sought(task, quantity, measured(task, quantity, **{path: value}))
    assert best.field == path.replace("__", ".")
    assert best.stated == locate(task.stack, f"layers.{best.field}").value
    assert best.value == pytest.approx(value, rel=1e-4)
    assert best.rms < 1e-3 * min((other.rms for other in others), default=1.0)


def test_insertion_loss_beside_its_reference():
    bare = parse_yaml(PANEL, "bare.yaml").data
    task = task_of(PANEL, reference={**bare, "layers": bare["layers"][:1]})
    best = sought(task, "insertion_loss", measured(task, "insertion_loss", gap__thickness=0.04))[0]
    assert (best.field, best.value) == ("gap.thickness", pytest.approx(0.04, rel=1e-6))


def test_the_rms_is_the_least_along_the_field():
    task = task_of(FOAM)
    data = measured(task, "absorption", foam__flow_resistivity=22e3, foam__thickness=0.055)
    found = sought(task, "absorption", data)
    assert 1 < len(found) <= TOLD
    assert [item.rms for item in found] == sorted(item.rms for item in found)
    for item in found[:2]:
        grid = item.value * np.linspace(0.9, 1.1, 41)
        rms = [
            np.sqrt(np.mean((measured(task, "absorption", **{item.field.replace(".", "__"): x}) - data) ** 2))
            for x in grid
        ]
        assert item.rms <= min(rms) * (1 + 1e-9)
        assert item.rms == pytest.approx(rms[20], rel=1e-6)


@pytest.mark.parametrize("data", [np.ones(40), np.zeros(40)])
def test_values_stay_within_the_bounds_of_their_fields(data):
    task = task_of(FOAM)
    found = sought(task, "absorption", data)  # what no foam does
    assert any(item.at_limit for item in found)
    for item in found:
        field = locate(task.stack, f"layers.{item.field}")
        type(field.owner).model_validate({**dict(field.owner), field.field: item.value})
        assert 0.1 <= item.value / item.stated * (1 + 1e-9) <= 10.1


@pytest.mark.parametrize("factor", [0.5, 1.3, 2.0, 4.0])
def test_a_field_that_is_far_off_is_found(factor):
    """Where no first-order estimate points: several resonances lie between."""
    file = load_simulation(EXAMPLES / "three_layers.yaml")
    task = replace(plan(file).tasks[0], frequency=np.geomspace(100, 4000, 50))
    thickness = factor * locate(task.stack, "layers.foam.thickness").value
    best = sought(task, "transmission_loss", measured(task, "transmission_loss", foam__thickness=thickness))[0]
    assert best.field == "foam.thickness"
    assert best.value == pytest.approx(thickness, rel=1e-3)


def test_rules_between_fields_hold():
    """A loss factor beside a modulus that has losses already is refused."""
    task = task_of(PANEL.replace("70 GPa", "70+1j GPa").replace(", loss_factor: 0.01", ""), incidence=60)
    data = run_task(task).quantities["absorption"] * 1.5
    assert not [item for item in sought(task, "absorption", data) if item.field.endswith("loss_factor")]


def test_no_single_share_of_a_pattern_is_sought():
    """The shares make 1: another value of one alone is no pattern."""
    task = task_of(FOAM_BESIDE_CHAMBER)
    data = np.clip(run_task(task).quantities["absorption"] * 1.2, 0, 1)
    fields = [item.field for item in sought(task, "absorption", data)]
    assert fields
    assert not [field for field in fields if field.endswith("share")]


def test_frequencies_at_which_nothing_was_measured_are_left_out():
    task = task_of(FOAM)
    data = measured(task, "absorption", foam__thickness=0.06)
    data[3::4] = np.nan
    best = sought(task, "absorption", data)[0]
    assert (best.field, best.value) == ("foam.thickness", pytest.approx(0.06, rel=1e-6))


def test_a_field_that_is_0_is_sought_too():
    text = PANEL.replace("loss_factor: 0.01", "loss_factor: 0")
    task = task_of(text, incidence=60, frequency={"from": "8 kHz", "to": "14 kHz", "points": 60})
    found = sought(task, "absorption", measured(task, "absorption", plate__loss_factor=0.02))
    (loss,) = (item for item in found if item.field == "plate.loss_factor")
    assert (loss.stated, loss.value) == (0.0, pytest.approx(0.02, rel=1e-3))


@pytest.mark.parametrize("path", ["layers.foam.thickness", "layers.0.thickness"])
def test_beside_its_tolerance(path):
    task = task_of(FOAM, tolerances={path: {"normal": "1 mm"}}, samples=50)
    best = sought(task, "absorption", measured(task, "absorption", foam__thickness=0.053))[0]
    assert best.deviations == pytest.approx(3e-3 / task.deviations[path], rel=1e-4)


def test_what_is_asked_for_beside_sound_does_not_matter():
    task = task_of(PANEL, excitation={"type": "rain"}, layer_losses=True)
    data = measured(task_of(PANEL), "transmission_loss", gap__thickness=0.04)
    assert sought(task, "transmission_loss", data)[0].field == "gap.thickness"


def test_walls_with_links_have_none():
    wall = {"links": [{"kind": "line", "between": ["plate", "back"], "spacing": "0.6 m"}]}
    task = task_of(PANEL, **wall, finite_size={"width": "3 m", "height": "2.5 m"}, incidence=DIFFUSE)
    assert closest_values(task, "transmission_loss", np.full(40, 20.0)) == ([], [])


def test_a_measurement_that_is_the_prediction_has_none():
    task = task_of(FOAM)
    assert sought(task, "absorption", run_task(task).quantities["absorption"]) == []


class Scalar(Layer):
    """A gap of a plugin that takes no arrays in place of its thickness."""

    type: str = "scalar"
    thickness: Length

    def faces(self, wave):
        """Return those of air."""
        gas = wave.ambient
        return fluid_faces(wave, math.sqrt(self.thickness**2), gas.density, gas.density * gas.sound_speed**2)


def test_fields_without_derivatives_are_left_out():
    plain = task_of(PANEL)
    front, _, back = plain.stack.layers
    stack = plain.stack.model_copy(update={"layers": (front, Scalar(name="gap", thickness=0.05), back)})
    data = measured(plain, "transmission_loss", plate__density=3000.0)
    found, left_out = closest_values(replace(plain, stack=stack), "transmission_loss", data)
    assert left_out == ["gap.thickness"]
    assert "plate.density" in {item.field for item in found}
