"""Fields inside a stack, and the balance of power."""

from itertools import pairwise

import numpy as np
import pytest

from multilayer.response import plane_wave
from multilayer.response.fields import fields, power_balance
from multilayer.stack import Stack

FOAM = {
    "type": "poroelastic", "name": "foam", "thickness": 0.05, "porosity": 0.98, "flow_resistivity": 15e3,
    "tortuosity": 1.05, "viscous_length": 1e-4, "thermal_length": 2.5e-4, "frame_density": 25,
    "young_modulus": 140e3, "poisson_ratio": 0.3, "loss_factor": 0.1,
}  # fmt: skip
SHEET = {"type": "elastic_solid", "name": "sheet", "thickness": 1e-3, "density": 2700, "young_modulus": 7e10,
         "poisson_ratio": 0.3, "loss_factor": 0.01}  # fmt: skip
PLATE = {**SHEET, "type": "elastic_plate", "name": "plate"}
AIR = {"type": "fluid", "name": "air", "thickness": 0.02}
FREQUENCY = np.geomspace(10, 20e3, 12)
STACKS = {
    "foam on a wall": {"layers": [FOAM]},
    "double wall": {"layers": [SHEET, FOAM, AIR, {**PLATE, "name": "back"}], "termination": "ambient"},
    "foam slipping": {
        "layers": [SHEET, FOAM],
        "contacts": [
            {"between": ["sheet", "foam"], "kind": "slip"},
            {"between": ["foam", "termination"], "kind": "slip"},
        ],
    },
    "into water": {
        "layers": [AIR, FOAM, SHEET],
        "termination": {"type": "fluid", "density": 1000, "sound_speed": 1480},
    },
    "free": {"layers": [SHEET, FOAM], "termination": "free"},
}  # fmt: skip


@pytest.mark.parametrize("name", STACKS)
@pytest.mark.parametrize("angle", [0.0, 45.0, 80.0, 89.0])
def test_power_is_conserved(name: str, angle: float) -> None:
    balance = power_balance(Stack.model_validate(STACKS[name]), FREQUENCY, angle)
    assert np.abs(balance.residual).max() < 1e-10
    assert balance.dissipated.min() > -1e-12
    assert balance.dissipated.max() > 0.01


def test_a_lossless_layer_loses_nothing() -> None:
    stack = Stack.model_validate({"layers": [AIR, {**SHEET, "loss_factor": 0}, FOAM], "termination": "ambient"})
    balance = power_balance(stack, FREQUENCY, [0.0, 60.0])
    assert np.abs(balance.dissipated[:2]).max() < 1e-10


def test_standing_wave_in_front_of_a_wall() -> None:
    stack = Stack.model_validate({"layers": [{**AIR, "thickness": 0.3}]})
    gas = stack.ambient.gas
    (air,) = fields(stack, FREQUENCY, 30.0, points=16)
    k3 = 2 * np.pi * FREQUENCY / gas.sound_speed * np.cos(np.deg2rad(30))
    to_wall = (0.3 - air.position)[:, None]
    expected = 2 * np.cos(k3 * to_wall) * np.exp(-1j * k3 * 0.3)
    assert air["p"] == pytest.approx(expected, abs=1e-9)
    assert np.abs(air["v3"][-1]).max() < 1e-15


@pytest.mark.parametrize("name", STACKS)
def test_states_continue_from_layer_to_layer(name: str) -> None:
    stack = Stack.model_validate(STACKS[name])
    found = fields(stack, FREQUENCY, 40.0, points=5)
    response = plane_wave(stack, FREQUENCY, 40.0)
    first = found[0]
    assert _pressure(first) == pytest.approx(1 + response.reflection, abs=1e-10)
    for before, after in pairwise(found):
        assert before.position[-1] == pytest.approx(after.position[0])
        assert _volume_velocity(before, -1) == pytest.approx(_volume_velocity(after, 0), rel=1e-8, abs=1e-14)


def _pressure(state) -> np.ndarray:
    parts = ("p", "s33", "s33s", "s33f")
    return sum((1 if part == "p" else -1) * state[part][0] for part in parts if part in state.components)


def _volume_velocity(state, point: int) -> np.ndarray:
    if "v3s" not in state.components:
        return state["v3"][point]
    return 0.02 * state["v3s"][point] + 0.98 * state["v3f"][point]


def test_a_thick_layer_at_high_frequency_has_a_field() -> None:
    stack = Stack.model_validate({"layers": [{**FOAM, "thickness": 0.5}]})
    (foam,) = fields(stack, 20e3, 45.0, points=101)
    size = np.abs(foam["v3f"])
    assert np.all(np.isfinite(foam.values))
    assert size[80] < 1e-6 * size[0]  # the wave has died out on the way


def test_slices_do_not_change_the_faces() -> None:
    stack = Stack.model_validate(STACKS["double wall"])
    coarse, fine = (fields(stack, FREQUENCY, 40.0, points=n) for n in (2, 33))
    for one, other in zip(coarse, fine, strict=True):
        assert one.values[:, [0, -1]] == pytest.approx(other.values[:, [0, -1]], rel=1e-7, abs=1e-10)
