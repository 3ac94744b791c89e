"""Layers that are alike: their matrices are made once."""

import numpy as np
import pytest

from multilayer.layers.fluid import Fluid
from multilayer.response import plane_wave, system
from multilayer.stack import Stack

F = np.array([100.0, 900.0])
WOOL = {"type": "equivalent_fluid", "model": "miki", "thickness": 0.02, "flow_resistivity": 1e4}
BOARD = {"type": "elastic_plate", "thickness": 0.0125, "density": 700.0, "young_modulus": 2.5e9, "poisson_ratio": 0.3}
AIR = {"type": "fluid", "thickness": 0.03, "density": 1.2, "sound_speed": 343.0}


def wall(*layers):
    return Stack.model_validate({"version": 1, "layers": list(layers), "termination": "ambient"})


def test_the_response_is_that_of_layers_made_one_by_one(monkeypatch):
    made = wall(BOARD, WOOL, AIR, BOARD | {"name": "back"}, WOOL, AIR | {"thickness": 0.04}, BOARD)
    found = plane_wave(made, F, 30.0).transmission_loss
    monkeypatch.setattr(system, "_all_but_name", id)
    np.testing.assert_array_equal(found, plane_wave(made, F, 30.0).transmission_loss)


@pytest.mark.parametrize(
    ("layers", "computed"), [((AIR, AIR | {"name": "b"}), 1), ((AIR, AIR | {"thickness": 0.04}), 2)]
)
def test_like_layers_are_computed_once(monkeypatch, layers, computed):
    calls, faces = [], Fluid.faces
    monkeypatch.setattr(Fluid, "faces", lambda layer, wave: calls.append(layer) or faces(layer, wave))
    plane_wave(wall(BOARD, layers[0], BOARD, layers[1], BOARD), F, 30.0)
    assert len(calls) == computed


def test_arrays_are_alike_only_as_the_same_object():
    values = np.array([[0.03], [0.05]])
    made = wall(BOARD, AIR, BOARD, AIR).replaced({"layers.1.thickness": values, "layers.3.thickness": 2 * values})
    alone = [wall(BOARD, AIR | {"thickness": float(v)}, BOARD, AIR | {"thickness": 2 * float(v)}) for v in values[:, 0]]
    expected = [plane_wave(one, F, 30.0).transmission_loss for one in alone]
    np.testing.assert_allclose(plane_wave(made, F, 30.0).transmission_loss, expected, rtol=1e-12)
