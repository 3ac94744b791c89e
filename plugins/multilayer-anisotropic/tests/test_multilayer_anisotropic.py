"""Transversely isotropic layers: isotropic limit, closed forms, Christoffel's wave speeds, and the laws of layers."""

import re
from pathlib import Path

import numpy as np
import pytest
from multilayer_anisotropic import AnisotropicPoroelastic, AnisotropicSolid

from multilayer import Stack, plane_wave
from multilayer.config import parse_yaml
from multilayer.errors import ValidityWarning
from multilayer.layers.elastic_solid import ElasticSolid
from multilayer.layers.poroelastic import Poroelastic
from multilayer.matrix.wave import Wave
from multilayer.media.gas import dry_air
from multilayer.testing import check_layer

FREQUENCIES = np.geomspace(10.0, 2e4, 12)
ANGLES = [0.0, 20.0, 55.0, 80.0]
FOAM = {"young_modulus": 1.6e5, "young_modulus_inplane": 0.8e5, "shear_modulus": 0.5e5, "poisson_ratio": 0.5,
        "poisson_ratio_inplane": 0.2}  # fmt: skip
FIBRES = {"young_modulus": 9e9, "young_modulus_inplane": 120e9, "shear_modulus": 4e9, "poisson_ratio": 0.02,
          "poisson_ratio_inplane": 0.3}  # fmt: skip
WOOL = {"young_modulus": 2e3, "young_modulus_inplane": 4e4, "shear_modulus": 6e3, "poisson_ratio": 0.01,
        "poisson_ratio_inplane": 0.1, "loss_factor": 0.2}  # fmt: skip
PORES = {"porosity": 0.98, "flow_resistivity": 2e4, "tortuosity": 1.02, "viscous_length": 8e-5, "thermal_length": 2e-4,
         "frame_density": 40.0}  # fmt: skip
INPLANE = {"flow_resistivity_inplane": 9e3, "tortuosity_inplane": 1.0, "viscous_length_inplane": 1.2e-4}
ZENER = {"law": "fractional_zener", "relaxed_modulus": 1e5, "unrelaxed_modulus": 4e5, "relaxation_time": 1e-4,
         "order": 0.5}  # fmt: skip


def solid(thickness=0.02, density=60.0, **fields):
    return AnisotropicSolid.model_validate({"thickness": thickness, "density": density, **fields})


def porous(thickness=0.04, **fields):
    return AnisotropicPoroelastic.model_validate({"thickness": thickness, **PORES, **fields})


@pytest.mark.parametrize(
    ("layer", "lossless"),
    [
        (solid(**FOAM), True),
        (solid(**FOAM, loss_factor=0.1), False),
        (solid(thickness=2e-3, density=1600.0, **FIBRES), True),
        (solid(thickness=2e-3, density=1600.0, **FIBRES, loss_factor=0.01), False),
        (solid(**{**FOAM, "young_modulus": ZENER, "young_modulus_inplane": ZENER, "shear_modulus": ZENER}), False),
        (porous(**WOOL), False),
        (porous(**WOOL, **INPLANE), False),
        (porous(**FOAM, **INPLANE, model="jcal", thermal_permeability=4e-9), False),
    ],
)
def test_laws_of_layers(layer, lossless):
    check_layer(layer, lossless=lossless)


def isotropic(young_modulus, poisson_ratio):
    shear = young_modulus / (2 * (1 + poisson_ratio))
    return {"young_modulus": young_modulus, "young_modulus_inplane": young_modulus, "shear_modulus": shear,
            "poisson_ratio": poisson_ratio, "poisson_ratio_inplane": poisson_ratio}  # fmt: skip


def responses(*layers):
    for termination in ("rigid", "ambient"):
        for layer in layers:
            result = plane_wave(Stack(layers=(layer,), termination=termination), FREQUENCIES, ANGLES)
            yield result.reflection if result.transmission is None else result.transmission


@pytest.mark.parametrize("thickness", [1e-4, 1e-3, 0.03, 0.5])
@pytest.mark.parametrize(
    ("young_modulus", "poisson_ratio", "density"), [(8e5 + 3e5j, 0.3, 240.0), (7e10 + 7e8j, 0.33, 2700.0)]
)
def test_isotropic_limit_of_the_solid(thickness, young_modulus, poisson_ratio, density):
    ours = solid(thickness, density, **isotropic(young_modulus, poisson_ratio))
    theirs = ElasticSolid(
        thickness=thickness, density=density, young_modulus=young_modulus, poisson_ratio=poisson_ratio
    )
    on_wall, on_wall_too, through, through_too = responses(ours, theirs)
    assert np.allclose(on_wall, on_wall_too, rtol=0, atol=1e-11)
    assert np.allclose(through, through_too, rtol=1e-10, atol=0)


@pytest.mark.parametrize("thickness", [1e-4, 1e-3, 0.03, 0.5])
def test_isotropic_limit_of_the_porous_material(thickness):
    ours = porous(thickness, **isotropic(1.6e5 + 1.6e4j, 0.4))
    theirs = Poroelastic(thickness=thickness, **PORES, young_modulus=1.6e5 + 1.6e4j, poisson_ratio=0.4)
    on_wall, on_wall_too, through, through_too = responses(ours, theirs)
    assert np.allclose(on_wall, on_wall_too, rtol=0, atol=1e-11)
    assert np.allclose(through, through_too, rtol=1e-10, atol=0)


def stiffness_by_inversion(fields):
    """Return the 6 x 6 stiffness (11, 22, 33, 23, 13, 12), from the compliance by a matrix inverse."""
    e1, e3, g = fields["young_modulus_inplane"], fields["young_modulus"], fields["shear_modulus"]
    nu31, nu12 = fields["poisson_ratio"], fields["poisson_ratio_inplane"]
    compliance = np.diag([1 / e1, 1 / e1, 1 / e3, 1 / g, 1 / g, 2 * (1 + nu12) / e1])
    compliance[0, 1] = compliance[1, 0] = -nu12 / e1
    compliance[0, 2] = compliance[2, 0] = compliance[1, 2] = compliance[2, 1] = -nu31 / e3
    return np.linalg.inv(compliance)


@pytest.mark.parametrize("fields", [FOAM, FIBRES])
def test_normal_incidence_meets_c33(fields):
    """On a wall the surface impedance is -i Z cot(k h) with Z = sqrt(rho C33)."""
    h, density = 0.03, 60.0
    c33 = stiffness_by_inversion(fields)[2, 2] * (1 + 0.05j)
    found = plane_wave(Stack(layers=(solid(h, density, **fields, loss_factor=0.05),)), FREQUENCIES).surface_impedance
    k = 2 * np.pi * FREQUENCIES * np.sqrt(density / c33)
    assert np.allclose(found, -1j * np.sqrt(density * c33) / np.tan(k * h), rtol=1e-9, atol=0)


@pytest.mark.parametrize("fields", [FOAM, FIBRES])
@pytest.mark.parametrize("angle", [0.0, 15.0, 40.0, 75.0])
def test_wave_speeds_are_christoffels(fields, angle):
    """A plane wave along any direction: the layer lets it pass with the phase of its phase speed."""
    density, frequency = 1200.0, 1000.0
    c = stiffness_by_inversion(fields)
    n1, n3 = np.sin(np.radians(angle)), np.cos(np.radians(angle))
    christoffel = np.array(
        [
            [c[0, 0] * n1**2 + c[4, 4] * n3**2, (c[0, 2] + c[4, 4]) * n1 * n3],
            [(c[0, 2] + c[4, 4]) * n1 * n3, c[4, 4] * n1**2 + c[2, 2] * n3**2],
        ]
    )
    for speed in np.sqrt(np.linalg.eigvalsh(christoffel) / density):
        k = 2 * np.pi * frequency / speed
        layer = solid(0.5 / k, density, **fields)
        wave = Wave(np.array(frequency), np.array(k * n1), dry_air())
        faces = layer.faces(wave)
        phases = np.linalg.eigvals(np.linalg.solve(faces.front.T, faces.back.T))
        assert np.min(np.abs(phases - np.exp(-0.5j * n3))) < 1e-9


def test_pores_in_the_plane_are_not_met_at_normal_incidence():
    one, other = (plane_wave(Stack(layers=(porous(**WOOL, **more),)), FREQUENCIES, ANGLES) for more in ({}, INPLANE))
    assert np.allclose(one.reflection[:, 0], other.reflection[:, 0], rtol=0, atol=1e-13)
    assert np.max(np.abs(one.reflection[:, 2] - other.reflection[:, 2])) > 1e-3


def test_stiffness_that_sets_energy_free_is_told():
    fields = {**FOAM, "young_modulus": 1.6e5 + 1.6e5j, "poisson_ratio": 0.8}
    with pytest.warns(ValidityWarning, match="set energy free"):
        solid(**fields).faces(Wave.incident(100.0, 0.0, dry_air()))


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"poisson_ratio": 1.2}, "no elastic solid has such Poisson's ratios"),
        ({"young_modulus": 1e5 + 1e4j, "loss_factor": 0.1}, "loss_factor stands beside a modulus"),
        ({"poisson_ratio_inplane": 1.5}, "it must be below 1"),
    ],
)
def test_what_no_solid_is_like_is_refused(changed, words):
    with pytest.raises(ValueError, match=words):
        solid(**{**FOAM, **changed})


def test_the_example_of_the_readme():
    text = Path(__file__).parents[1].joinpath("README.md").read_text()
    (example,) = re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)
    stack = Stack.model_validate(parse_yaml(example, Path("stack.yaml")).data)
    absorption = plane_wave(stack, FREQUENCIES).absorption
    assert np.all((absorption > 0) & (absorption <= 1))
