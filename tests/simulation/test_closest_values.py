"""Values of single fields that bring a prediction closest to a measurement."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.config import parse_yaml
from multilayer.paths import locate, with_values
from multilayer.simulation import SimulationFile
from multilayer.simulation.closest_values import SOUGHT, closest_values
from multilayer.simulation.run import plan
from multilayer.simulation.tasks import run_task
from tests.simulation.files import FOAM, PANEL

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
    best, *others = closest_values(task, quantity, measured(task, quantity, **{path: value}))
    assert best.field == path.replace("__", ".")
    assert best.stated == locate(task.stack, f"layers.{best.field}").value
    assert best.value == pytest.approx(value, rel=1e-4)
    assert best.rms < 1e-3 * min((other.rms for other in others), default=1.0)


def test_insertion_loss_beside_its_reference():
    bare = parse_yaml(PANEL, "bare.yaml").data
    task = task_of(PANEL, reference={**bare, "layers": bare["layers"][:1]})
    best = closest_values(task, "insertion_loss", measured(task, "insertion_loss", gap__thickness=0.04))[0]
    assert (best.field, best.value) == ("gap.thickness", pytest.approx(0.04, rel=1e-6))


def test_the_rms_is_the_least_along_the_field():
    task = task_of(FOAM)
    data = measured(task, "absorption", foam__flow_resistivity=22e3, foam__thickness=0.055)
    found = closest_values(task, "absorption", data)
    assert 1 < len(found) <= SOUGHT
    assert [item.rms for item in found] == sorted(item.rms for item in found)
    for item in found[:2]:
        grid = item.value * np.linspace(0.9, 1.1, 41)
        rms = [
            np.sqrt(np.mean((measured(task, "absorption", **{item.field.replace(".", "__"): x}) - data) ** 2))
            for x in grid
        ]
        assert item.rms <= min(rms) * (1 + 1e-9)
        assert item.rms == pytest.approx(rms[20], rel=1e-6)


def test_values_stay_within_the_bounds_of_their_fields():
    task = task_of(FOAM)
    data = measured(task, "absorption") + 0.3  # what no foam does
    for item in closest_values(task, "absorption", data):
        task.stack.replaced({f"layers.{item.field}": item.value})  # refuses what is not allowed
        assert 0.0999 <= item.value / item.stated <= 10.001


def test_a_field_that_is_0_is_sought_too():
    text = PANEL.replace("loss_factor: 0.01", "loss_factor: 0")
    task = task_of(text, incidence=60, frequency={"from": "8 kHz", "to": "14 kHz", "points": 60})
    found = closest_values(task, "absorption", measured(task, "absorption", plate__loss_factor=0.02))
    (loss,) = (item for item in found if item.field == "plate.loss_factor")
    assert (loss.stated, loss.value) == (0.0, pytest.approx(0.02, rel=1e-3))


def test_beside_its_tolerance():
    task = task_of(FOAM, tolerances={"layers.foam.thickness": {"normal": "1 mm"}}, samples=50)
    best = closest_values(task, "absorption", measured(task, "absorption", foam__thickness=0.053))[0]
    assert best.deviations == pytest.approx(3e-3 / task.deviations["layers.foam.thickness"])


def test_what_is_not_computed_by_derivatives_has_none():
    task = task_of(PANEL, excitation={"type": "rain"})
    assert closest_values(task, "transmission_loss", np.full(40, 20.0)) == []


def test_a_measurement_that_is_the_prediction_has_none():
    task = task_of(FOAM)
    assert closest_values(task, "absorption", run_task(task).quantities["absorption"]) == []
