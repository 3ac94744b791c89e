"""The two-plate rig as in Bonfiglio & Pompoli 2015, eqs. (2)-(4): one matrix, one column to the right-hand side."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.matrix.couplings import couple
from multilayer.matrix.families import FLUID, SOLID
from multilayer.media.gas import dry_air
from multilayer.response import base_motion
from tests.analytic.materials import ALUMINIUM, RUBBER, stack

STEEL = {"type": "elastic_solid", "density": 7800.0, "young_modulus": 2.1e11, "poisson_ratio": 0.3}


def d_matrix(layers, frequency, impedance):
    """Return D over (front of the support plate, back of every solid, fluid), the stresses in units of `impedance`."""
    scale = np.diag([1, 1, impedance, impedance])
    support, *others = (np.linalg.solve(scale, layer.transfer_matrix(frequency) @ scale) for layer in layers)
    bonded = [np.array(rows) for rows in couple(SOLID, SOLID, "bonded")]
    wet = [np.array(rows) for rows in couple(SOLID, FLUID, "bonded")]
    d = np.zeros((17, 18), dtype=complex)
    d[0:4, 0:4], d[0:4, 4:8] = np.eye(4), -support
    for i, transfer in enumerate(others, start=1):
        here = slice(4 * i, 4 * i + 4)
        d[here, here], d[here, 4 * i + 4 : 4 * i + 8] = bonded[0], bonded[1] @ transfer
    d[12:15, 12:16], d[12:15, 16:18] = wet
    d[15, 16:18] = 1, -1  # half-space: p = Z v3
    d[16, 0] = 1  # the support plate is held along axis 1
    return d


@pytest.mark.parametrize("frequency", [100.0, 700.0, 1500.0])
def test_base_motion_is_the_solution_of_the_paper_s_matrix(frequency):
    rig = stack((ALUMINIUM, 0.01), (RUBBER, 0.026), (STEEL, 1e-3), termination="ambient")
    d = d_matrix(rig.layers, frequency, dry_air().impedance)
    imposed = SOLID.index("v3")
    force = -d[:, imposed]  # unit velocity
    v2 = np.linalg.solve(np.delete(d, imposed, axis=1), force)
    assert_allclose(base_motion(rig, frequency).transmissibility, v2[-1], rtol=1e-9)
