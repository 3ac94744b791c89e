"""Insertion loss."""

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.response.insertion_loss import insertion_loss
from multilayer.stack import Stack

PLATE = {"type": "elastic_plate", "thickness": 1e-3, "density": 2700, "young_modulus": 7e10, "poisson_ratio": 0.33}
SINGLE, THICKER = (
    Stack.model_validate({"layers": [{**PLATE, "density": density}], "termination": "ambient"})
    for density in (2700, 5400)
)
FREQUENCY = np.geomspace(500, 4000, 7)


def test_doubling_the_mass_adds_six_decibels() -> None:
    assert insertion_loss(THICKER, SINGLE, FREQUENCY) == pytest.approx(20 * np.log10(2), abs=0.2)


@pytest.mark.parametrize("max_angle", [None, 78.0])
def test_a_stack_against_itself(max_angle: float | None) -> None:
    assert insertion_loss(SINGLE, SINGLE, FREQUENCY, max_angle=max_angle) == pytest.approx(0)


def test_a_wall_lets_nothing_through() -> None:
    with pytest.raises(InputError, match="termination: ambient"):
        insertion_loss(SINGLE.model_copy(update={"termination": "rigid"}), SINGLE, FREQUENCY)
