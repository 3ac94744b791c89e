"""Slabs made from their field equations alone are those of the waves in closed form."""

import numpy as np
import pytest

from multilayer.layers import LAYERS
from multilayer.matrix.equations import slab_faces
from multilayer.matrix.faces import Faces
from multilayer.matrix.families import SOLID
from multilayer.matrix.scattering import Scattering, joined
from multilayer.matrix.solve import HalfSpace, System, solve
from multilayer.matrix.wave import Wave
from multilayer.media.gas import dry_air
from tests.contract.samples import LAYER_SAMPLES

WAVE = Wave.incident(np.geomspace(1.0, 5e4, 25), np.array([0.0, 10.0, 45.0, 85.0, 89.9]), dry_air())
KINDS = ("fluid", "equivalent_fluid", "elastic_solid", "poroelastic")
SAMPLES = [pytest.param(name, fields, id=f"{name}-{what}") for name in KINDS for what, fields, _ in LAYER_SAMPLES[name]]
pytestmark = pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")


def response(faces: Faces):
    air = dry_air()
    k3 = np.sqrt((WAVE.omega / air.sound_speed) ** 2 - WAVE.kx**2)
    half = HalfSpace(WAVE.omega * air.density / k3)
    solution = solve(System(half, [faces], half, ("bonded", "bonded")))
    return solution.reflected, solution.transmitted


@pytest.mark.parametrize(("name", "fields"), SAMPLES)
def test_at_any_thickness(name, fields):
    layer = LAYERS[name].model_validate(fields)
    for thickness in np.geomspace(1e-6, 10.0, 8):
        layer = layer.model_copy(update={"thickness": thickness})
        theirs, ours = response(layer.faces(WAVE)), response(
            slab_faces(WAVE, thickness, layer.field_equations(WAVE))
        )  # fmt: skip
        assert np.max(np.abs(ours[0] - theirs[0])) < 2e-10
        seen = np.abs(theirs[1]) > 1e-250
        assert np.max(np.abs(ours[1] / np.where(seen, theirs[1], 1) - 1)[seen], initial=0) < 2e-9


def test_slices_join_to_the_whole():
    layer = LAYERS["elastic_solid"](thickness=0.01, density=240.0, young_modulus=8e5 + 3e5j, poisson_ratio=0.3)
    wave = Wave.incident(2000.0, 30.0, dry_air())
    equations = layer.field_equations(wave)
    reference = equations.reference(wave.kx)

    def slice_of(h):
        faces = slab_faces(wave, h, equations)
        return Scattering.of(reference, np.linalg.solve(faces.front.T, faces.back.T).T)

    whole, parts = slice_of(0.01), joined(slice_of(0.003), slice_of(0.007))
    for one, other in zip(whole._all(), parts._all(), strict=True):
        assert np.allclose(one, other, rtol=0, atol=1e-13)


def test_scattering_of_a_passive_slice_is_no_gain():
    layer = LAYERS["elastic_solid"](thickness=0.01, density=240.0, young_modulus=8e5 + 3e5j, poisson_ratio=0.3)
    equations = layer.field_equations(WAVE)
    reference = equations.reference(WAVE.kx)
    faces = layer.faces(WAVE)
    front, back = (np.moveaxis(matrix, (0, 1), (-2, -1)) for matrix in (faces.front, faces.back))
    propagator = np.moveaxis(back @ np.linalg.inv(front), (-2, -1), (0, 1))
    found = Scattering.of(reference, propagator)
    whole = np.block([[found.r, found.t_back], [found.t, found.r_back]])
    weights = np.sqrt(np.concatenate([reference.impedances] * 2, axis=-1))
    weighed = whole * weights[..., :, None] / weights[..., None, :]
    thin = np.abs(WAVE.kx * 0.01 + 0 * WAVE.omega) < 3
    assert reference.family == SOLID
    assert np.max(np.linalg.norm(weighed, ord=2, axis=(-2, -1))[thin]) < 1 + 1e-9
