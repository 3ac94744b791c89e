"""The kernel against many digits: every family, every coupling, every end, and extremes of scale."""

import numpy as np
import pytest

from multilayer.response import base_motion, plane_wave
from multilayer.stack import FluidHalfSpace
from tests.analytic import mp_reference
from tests.analytic.materials import AIR, ALUMINIUM, FOAM, FOAM2, GEL, RUBBER, SHEET, WATER, stack

FREQUENCIES = [1.0, 300.0, 2e4, 5e4]
ANGLES = [0.0, 1e-6, 45.0, 89.0, 89.9]
ENDS = ["ambient", "rigid", "free", FluidHalfSpace(density=1000.0, sound_speed=1480.0)]


def name_of(end):
    return end if isinstance(end, str) else "water"


SINGLE = {
    "foam 1 um": (FOAM, 1e-6),
    "foam 10 m": (FOAM, 10.0),
    "soft foam 0.5 m": (FOAM2, 0.5),
    "soft foam 2 m": (FOAM2, 2.0),
    "aluminium 1 um": (ALUMINIUM, 1e-6),
    "aluminium 0.1 mm": (ALUMINIUM, 1e-4),
    "aluminium 10 m": (ALUMINIUM, 10.0),
    "rubber 26 mm": (RUBBER, 0.026),
    "gel 10 m": (GEL, 10.0),
    "sheet 1 mm": (SHEET, 1e-3),
    "thick sheet": (SHEET, 0.1),
    "air 10 m": (AIR, 10.0),
    "water 1 um": (WATER, 1e-6),
}

MIXED = {
    "solid, foam, solid": stack((ALUMINIUM, 1e-3), (FOAM2, 0.05), (RUBBER, 2e-3)),
    "the same, slipping": stack((ALUMINIUM, 1e-3), (FOAM2, 0.05), (RUBBER, 2e-3), slip=((0, 1), (1, 2))),
    "two foams": stack((FOAM2, 0.05), (FOAM, 0.02)),
    "two foams, slipping": stack((FOAM, 0.02), (FOAM2, 0.05), slip=((0, 1),)),
    "two solids": stack((ALUMINIUM, 1e-3), (RUBBER, 0.02)),
    "two solids, slipping": stack((RUBBER, 0.02), (ALUMINIUM, 1e-3), slip=((0, 1),)),
    "sheet on foam": stack((SHEET, 1e-3), (FOAM2, 0.05)),
    "sheet lying on foam": stack((SHEET, 1e-3), (FOAM2, 0.05), (SHEET, 5e-4), slip=((0, 1), (1, 2))),
    "of every kind": stack((ALUMINIUM, 1e-3), (FOAM2, 0.05), (AIR, 0.01), (SHEET, 1e-3), (FOAM, 0.02), (GEL, 0.01)),
    "foil, thick foam, foil": stack((ALUMINIUM, 1e-6), (FOAM2, 2.0), (ALUMINIUM, 1e-6)),
    "thick and thin": stack((GEL, 3.0), (FOAM, 1e-5), (ALUMINIUM, 0.3), (FOAM2, 0.5), (WATER, 1e-5), (RUBBER, 1.0)),
}


def assert_close(computed, exact, what):
    """Within 1e-9 of its size; a reflection that all but vanishes, 1e-11 of 1; a transmission below 1e-8, 1e-8."""
    kind, *_ = what
    allowed = {"R": 1e-9 * abs(exact) + 1e-11, "T": (1e-9 if abs(exact) > 1e-8 else 1e-8) * abs(exact)}
    assert abs(computed - exact) <= allowed[kind], (what, computed, exact)


def assert_plane_waves_agree(panel, frequencies, angles):
    result = plane_wave(panel, frequencies, angles)
    for i, j in np.ndindex(result.reflection.shape):
        f, angle = frequencies[i], angles[j]
        reflection, transmission = mp_reference.plane_wave(panel, f, angle)
        assert_close(result.reflection[i, j], reflection, ("R", f, angle))
        if transmission is not None:
            assert_close(result.transmission[i, j], transmission, ("T", f, angle))


@pytest.mark.filterwarnings("ignore:.*bending wavelength")  # the theory is the same
@pytest.mark.parametrize("name", SINGLE)
def test_one_layer_in_air(name):
    assert_plane_waves_agree(stack(SINGLE[name]), FREQUENCIES, ANGLES)


@pytest.mark.parametrize("end", ENDS, ids=name_of)
@pytest.mark.parametrize("name", MIXED)
def test_mixed_stacks(name, end):
    panel = MIXED[name].model_copy(update={"termination": end})
    assert_plane_waves_agree(panel, [20.0, 3e3], [0.0, 70.0])


@pytest.mark.parametrize("layer", [RUBBER, FOAM2], ids=lambda layer: layer["type"])
def test_slip_on_a_wall(layer):
    panel = stack((ALUMINIUM, 1e-3), (layer, 0.02), termination="rigid", slip=((1, "termination"),))
    assert_plane_waves_agree(panel, [20.0, 3e3], [0.0, 70.0])


@pytest.mark.parametrize("end", [end for end in ENDS if end != "rigid"], ids=name_of)
@pytest.mark.parametrize("name", MIXED)
def test_base_motion(name, end):
    panel = MIXED[name].model_copy(update={"termination": end})
    result = base_motion(panel, FREQUENCIES)
    for f, top in zip(FREQUENCIES, result.transmissibility, strict=True):
        exact = mp_reference.base_motion(panel, f)
        assert abs(top - exact) <= 1e-9 * abs(exact), f
