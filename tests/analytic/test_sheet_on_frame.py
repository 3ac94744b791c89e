"""Impervious sheets that lie on the frame of a poroelastic layer, by limits that are known."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from multilayer.matrix.couplings import CouplingError
from multilayer.response import base_motion, plane_wave
from tests.analytic.materials import ALUMINIUM, FOAM2, SHEET, stack

F = np.array([50.0, 400.0, 2000.0])
ANGLES = np.array([0.0, 60.0])
WOOL = FOAM2 | {"young_modulus": 2e5, "poisson_ratio": 0.0, "loss_factor": 0.05, "flow_resistivity": 2e4}


def of_mass(mass):
    return {"type": "membrane", "surface_density": mass}


def with_membrane(mass, thickness=0.05, layer=FOAM2):
    panel = stack((layer, thickness), termination="ambient").model_dump(mode="json")
    panel["layers"].append(of_mass(mass))
    panel["contacts"] = [{"between": [0, 1], "kind": "slip"}]
    return type(stack((layer, thickness))).model_validate(panel)


def test_a_heavy_one_is_a_wall_on_which_the_frame_slides():
    heavy = plane_wave(with_membrane(1e9), F, ANGLES).reflection
    wall = plane_wave(stack((FOAM2, 0.05), termination="rigid", slip=((0, "termination"),)), F, ANGLES).reflection
    np.testing.assert_allclose(heavy, wall, rtol=1e-6)


def test_a_thin_plate_is_a_thin_solid_that_slips():
    plate, solid = (
        plane_wave(stack((kind, 1e-3), (FOAM2, 0.05), slip=((0, 1),)), F[:2], ANGLES).transmission
        for kind in (SHEET, ALUMINIUM | {"loss_factor": SHEET["loss_factor"]})
    )
    np.testing.assert_allclose(plate, solid, rtol=3e-3)


@pytest.mark.parametrize("slips", [True, False])
def test_it_rests_on_frame_and_air_together(slips):
    """A screed on its mat: the stiffnesses of frame and enclosed air add up; across a film there is the air alone."""
    mass, h = 120.0, 0.02
    screed = with_membrane(mass, h, WOOL)
    if not slips:
        screed = screed.model_copy(update={"contacts": ()})
    frame, air = WOOL["young_modulus"] / h, 101325.0 / h / WOOL["porosity"]  # isothermal at these frequencies
    expected = np.sqrt(((frame if slips else 0.0) + air) / mass) / (2 * np.pi)

    def level(log_f):
        return -float(np.abs(base_motion(screed, np.array([np.exp(log_f)])).transmissibility[0]))

    found = np.exp(minimize_scalar(level, bounds=np.log([0.6 * expected, 1.6 * expected]), method="bounded").x)
    assert found == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("beside", [{"type": "fluid"}, {"type": "screen", "flow_resistance": 200.0}])
def test_a_fluid_and_a_sheet_with_pores_do_not_lie_on_a_frame(beside):
    fields = beside | ({"thickness": 0.01} if beside["type"] == "fluid" else {})
    panel = type(stack((FOAM2, 0.05))).model_validate(
        {"layers": [fields, FOAM2 | {"thickness": 0.05}], "contacts": [{"between": [0, 1], "kind": "slip"}]}
    )
    with pytest.raises(CouplingError, match="slips anyway: leave the contact out"):
        plane_wave(panel, F)


@pytest.mark.parametrize("layer", [FOAM2, ALUMINIUM], ids=["foam", "solid"])
def test_nor_does_the_gas_behind(layer):
    panel = stack((layer, 0.05), termination="ambient", slip=((0, "termination"),))
    with pytest.raises(CouplingError, match=r"and the termination: .* slips anyway: leave the contact out"):
        plane_wave(panel, F)
