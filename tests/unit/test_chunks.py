"""Pieces of a frequency axis give what the whole gives."""

import numpy as np
import pytest

from multilayer.paths import with_values
from multilayer.response import plane_wave
from multilayer.response.chunks import POINTS, in_chunks
from multilayer.stack import Stack

STACK = Stack.model_validate({"layers": [{"type": "fluid", "name": "gap", "thickness": 0.1}], "termination": "ambient"})


@pytest.mark.parametrize("workers", [1, 2])
def test_a_long_axis_equals_single_calls(workers: int) -> None:
    frequency = np.geomspace(10, 1e4, 9 * POINTS)
    whole = plane_wave(STACK, frequency, [0.0, 60.0], workers=workers)
    assert whole.reflection.shape == whole.transmission_loss.shape == (len(frequency), 2)
    assert whole.angle.shape == (2,)
    some = [0, POINTS // 2 - 1, POINTS // 2, 5 * POINTS, -1]
    alone = plane_wave(STACK, frequency[some], [0.0, 60.0])
    assert whole.reflection[some] == pytest.approx(alone.reflection, rel=1e-12, abs=1e-14)
    assert np.array_equal(whole.frequency, frequency)


def test_pieces_are_bounded_and_complete() -> None:
    frequency = np.arange(1.0, 10_001.0)
    pieces = in_chunks(lambda piece: piece, STACK, frequency, n_angles=100)
    assert max(len(piece) for piece in pieces) * 100 <= POINTS
    assert np.array_equal(np.concatenate(pieces), frequency)


def test_arrays_in_the_stack_are_not_cut() -> None:
    frequency = np.geomspace(10, 1e4, 2 * POINTS)
    gaps = STACK.replaced({"layers.gap.thickness": np.linspace(0.05, 0.1, 2 * POINTS)})
    response = plane_wave(gaps, frequency)
    last = plane_wave(STACK, frequency[-1:])
    assert response.reflection[-1] == pytest.approx(last.reflection[0], rel=1e-12)


def test_arrays_in_a_law_are_not_cut() -> None:
    law = {"law": "kelvin_voigt", "young_modulus": 1e5, "viscosity": 10.0}
    solid = {"type": "elastic_solid", "name": "foam", "thickness": 0.02, "density": 50.0, "poisson_ratio": 0.3}
    stack = Stack.model_validate({"layers": [{**solid, "young_modulus": law}]})
    frequency, viscosity = np.geomspace(10, 1e4, 2 * POINTS), np.array([5.0, 20.0])
    found = plane_wave(with_values(stack, {"layers.foam.young_modulus.viscosity": viscosity[:, None]}), frequency)
    assert found.reflection.shape == (2, len(frequency))
    alone = plane_wave(with_values(stack, {"layers.foam.young_modulus.viscosity": 20.0}), frequency)
    assert found.reflection[1] == pytest.approx(alone.reflection, rel=1e-9)
