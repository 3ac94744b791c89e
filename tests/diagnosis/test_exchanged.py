"""Two configurations whose recordings stand for each other are told before anything is searched for."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.diagnosis.effects.sensor_mass import SensorMass
from multilayer.diagnosis.exchanged import refuse_exchanged
from multilayer.diagnosis.fitting import Fitted, minimise_scaled
from multilayer.diagnosis.thresholds import EXCHANGED
from multilayer.errors import InputError
from tests.diagnosis.rigs import F, measured_with


def fitted(i, j, effects=(), values=()):
    """Return the nominal fit to readings of which those of two configurations are exchanged."""
    sound = measured_with(effects, values)
    data = list(sound.hypothesis.data)
    data[i], data[j] = (
        replace(data[i], ratio=data[j].ratio),
        replace(data[j], ratio=data[i].ratio),
    )
    problem = replace(sound.hypothesis, configurations=data)
    return Fitted(problem, minimise_scaled(problem, sound.minimum.z))


@pytest.mark.parametrize(("i", "j"), [(0, 1), (2, 4), (1, 3), (4, 6)])
def test_both_are_named(i, j):
    with pytest.raises(InputError, match=f"configurations.{j}: 'c{i}' and 'c{j}' look exchanged: ") as caught:
        refuse_exchanged(fitted(i, j))
    assert "exchange their files, or correct which sample and which plate they had" in str(caught.value)


@pytest.mark.parametrize(
    ("effects", "values"), [((), ()), ([SensorMass()], (0.02, 0.0))], ids=["no gap", "a heavy sensor"]
)
def test_others_are_left_to_the_diagnosis(effects, values):
    nominal = measured_with(effects, values)
    assert (nominal.minimum.cost / (2 * 7 * F.size) > EXCHANGED) == bool(effects)
    refuse_exchanged(nominal)


def test_two_errors_are_left_to_the_diagnosis():
    """Exchanged recordings do not explain all of it."""
    nominal = fitted(2, 4, [SensorMass()], (0.02, 0.0))
    assert np.isfinite(nominal.minimum.cost)
    refuse_exchanged(nominal)
