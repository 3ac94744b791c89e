"""Double porosity: its diffusion of pressure against exact solutions, and its limits."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.special import iv, kv

from multilayer.errors import ValidityWarning
from multilayer.layers.equivalent_fluid import EquivalentFluid
from multilayer.layers.fluid import Fluid
from multilayer.media.double_porosity import annular_permeability, holed, pressure_ratio, slitted
from multilayer.media.gas import dry_air
from multilayer.media.pore_models import PORE_MODELS
from multilayer.media.porous import champoux_allard_modulus, johnson_density
from multilayer.response import plane_wave
from multilayer.stack import Stack

AIR = dry_air()
OMEGA = 2 * np.pi * np.geomspace(20, 4000, 40)
WOOL = {
    "porosity": 0.95, "flow_resistivity": 1.5e5, "tortuosity": 1.1, "viscous_length": 3e-5, "thermal_length": 6e-5,
}  # fmt: skip


@pytest.mark.parametrize("share", [0.01, 0.2, 0.7])
def test_annulus(share):
    """T = (a^2 - r^2) / 4 + b^2 / 2 ln(r / a) between a and b, 0 within a."""
    b = 1 / np.sqrt(share)
    mean = quad(lambda r: 2 * r / b**2 * ((1 - r**2) / 4 + b**2 / 2 * np.log(r)), 1, b)[0]
    assert annular_permeability(1.0, share) == pytest.approx(mean, rel=1e-9)


class TestDiffusion:
    def test_slab(self):
        """Exact: tanh(z) / z, z = half thickness times sqrt(i w phi sigma / P)."""
        s = 0.03
        z = s / 2 * np.sqrt(1j * OMEGA * 0.95 * 1.5e5 / AIR.pressure)
        ours = pressure_ratio(OMEGA, 0.95, 1.5e5, s**2 / 12, s, AIR)
        assert_allclose(ours, np.tanh(z) / z, atol=0.03)

    def test_annulus(self):
        """Exact, by modified Bessel functions."""
        share, a = 0.1, 5e-3
        b, q = a / np.sqrt(share), np.sqrt(1j * OMEGA * 0.95 * 1.5e5 / AIR.pressure)
        top = iv(1, q * b) * kv(1, q * a) - kv(1, q * b) * iv(1, q * a)
        bottom = iv(0, q * a) * kv(1, q * b) + kv(0, q * a) * iv(1, q * b)
        exact = 2 * a / (q * (b**2 - a**2)) * top / bottom
        diffusion = annular_permeability(a, share) / (1 - share)
        ours = pressure_ratio(OMEGA, 0.95, 1.5e5, diffusion, a * (1 - share) / share, AIR)
        assert_allclose(ours, exact, atol=0.03)

    def test_half_way(self):
        """Where i w is the rate of diffusion the loss is near its largest, about 0.4."""
        rates = 1.5e5 * 0.95 * 0.03**2 / 12 / AIR.pressure
        ratio = pressure_ratio(np.geomspace(0.01, 100, 200) / rates, 0.95, 1.5e5, 0.03**2 / 12, 0.03, AIR)
        at = int(np.argmin(ratio.imag))
        assert 0.3 < np.geomspace(0.01, 100, 200)[at] < 3
        assert ratio[at].imag == pytest.approx(-0.42, abs=0.02)  # tanh(z) / z has -0.417


class TestLimits:
    def test_tiny_holes_change_nothing(self):
        density, bulk = holed(OMEGA, AIR, **WOOL, perforation=1e-7, hole_radius=1e-8)
        wool = {key: WOOL[key] for key in ("porosity", "thermal_length")}
        others = [WOOL[key] for key in ("porosity", "flow_resistivity", "tortuosity", "viscous_length")]
        assert_allclose(density, johnson_density(OMEGA, *others, AIR), rtol=1e-5)
        assert_allclose(bulk, champoux_allard_modulus(OMEGA, **wool, gas=AIR), rtol=1e-3)

    def test_tight_material_is_a_wall(self):
        """Holes in what lets nothing through: straight tubes."""
        tight = {**WOOL, "flow_resistivity": 1e16, "viscous_length": 1e-8, "thermal_length": 1e-8}
        density, bulk = holed(OMEGA, AIR, **tight, perforation=0.2, hole_radius=2e-3)
        tubes = (0.2, 8 * AIR.viscosity / (0.2 * 4e-6), 1.0, 2e-3)
        assert_allclose(density, johnson_density(OMEGA, *tubes, AIR), rtol=1e-3)
        assert_allclose(bulk, champoux_allard_modulus(OMEGA, 0.2, 2e-3, AIR), rtol=0.02)

    def test_like_permeabilities_share_one_pressure(self):
        """Olny & Boutin's low contrast: both compressed alike."""
        open_wool = {**WOOL, "flow_resistivity": 1e3, "viscous_length": 4e-4, "thermal_length": 8e-4}
        bulk = holed(OMEGA, AIR, **open_wool, perforation=0.2, hole_radius=1e-3)[1]
        both = 1 / (
            1 / champoux_allard_modulus(OMEGA, 0.2, 1e-3, AIR) + 0.8 / champoux_allard_modulus(OMEGA, 0.95, 8e-4, AIR)
        )
        assert_allclose(bulk, both, rtol=1e-3)

    def test_slits_and_holes_are_alike(self):
        """Of one hydraulic radius and one thickness between them, within the factor that their shapes make."""
        holes = holed(OMEGA, AIR, **WOOL, perforation=0.2, hole_radius=2e-3)
        slits = slitted(OMEGA, AIR, **WOOL, perforation=0.2, slit_width=2e-3)
        assert_allclose(np.abs(slits[1] / holes[1]), 1, atol=0.25)


def test_holes_make_dense_wool_absorb():
    """Atalla et al. 2001: of a material too tight, holes raise the absorption at middle frequencies by far."""
    band = np.linspace(300, 1200, 40)
    dense = EquivalentFluid(thickness=0.06, **WOOL)
    holes = EquivalentFluid(thickness=0.06, model="double_porosity", perforation=0.1, hole_radius=6e-3, **WOOL)
    plain, holed_wool = (plane_wave(Stack(layers=(layer,)), band).absorption for layer in (dense, holes))
    assert np.all(holed_wool[10:] > plain[10:] + 0.1)


def test_only_holes_are_air():
    """Holes that take all of the area are air."""
    layer = EquivalentFluid(thickness=0.1, model="double_porosity", perforation=0.999, hole_radius=5e-3, **WOOL)
    band = np.array([200.0, 700.0])
    ours, air = (
        plane_wave(Stack(layers=(each,), termination="ambient"), band).transmission
        for each in (layer, Fluid(thickness=0.1))
    )
    assert_allclose(ours, air, atol=0.05)


def test_wide_pitch():
    fields = {**WOOL, "perforation": 0.1, "hole_radius": 0.01}
    with pytest.warns(ValidityWarning, match="double porosity holds for 2 pi pore size / wavelength up to 1; .*2000"):
        PORE_MODELS["double_porosity"].fluid(2 * np.pi * np.array([200.0, 2000.0]), AIR, fields)
