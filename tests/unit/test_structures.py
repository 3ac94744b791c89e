"""Pores from geometry against exact solutions of arrays, published drag, and the limits of thin fibres."""

from dataclasses import astuple

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

from multilayer.errors import ValidityWarning
from multilayer.layers.equivalent_fluid import EquivalentFluid
from multilayer.layers.poroelastic import Poroelastic
from multilayer.media.gas import dry_air
from multilayer.media.pore_models import PORE_MODELS
from multilayer.media.structures import fibres, grains, open_cells
from multilayer.response import plane_wave
from multilayer.stack import Stack

AIR = dry_air()
OMEGA = 2 * np.pi * np.array([100.0, 1000.0, 5000.0])


class TestFibres:
    @pytest.mark.parametrize(("solid", "drag"), [(0.05, 15.56), (0.1, 24.83), (0.2, 51.53)])
    def test_across_a_square_array(self, solid, drag):
        """A. S. Sangani & A. Acrivos, Int. J. Multiphase Flow 8 (1982) 193-206: force / (viscosity velocity length)."""
        assert fibres(1 - solid, 2.0).permeability == pytest.approx(np.pi / (solid * drag), rel=0.02)

    @pytest.mark.parametrize("solid", [0.1, 0.2, 0.3])
    def test_tortuosity_of_a_square_array(self, solid):
        """Lord Rayleigh, Phil. Mag. 34 (1892) 481-502: the conductivity beside cylinders that do not conduct."""
        conductivity = 1 - 2 * solid / (1 + solid - 0.3058 * solid**4)
        assert fibres(1 - solid, 1.0).tortuosity == pytest.approx((1 - solid) / conductivity, rel=2e-3)

    def test_along_they_are_tubes_turned_inside_out(self):
        """Flow and heat obey one equation: both permeabilities and both lengths are equal."""
        pores = fibres(0.9, 1e-5, 1.0)
        assert pores.permeability == pores.thermal_permeability
        assert pores.viscous_length == pores.thermal_length
        assert pores.tortuosity == 1

    def test_thin_fibres(self):
        """Lambda = 1 / (2 pi r length) across thin fibres (Allard & Champoux 1992), Lambda' twice that."""
        pores = fibres(1 - 1e-6, 2e-6)
        length = 1e-6 / (np.pi * 1e-12)  # of fibres in unit volume
        assert pores.viscous_length == pytest.approx(1 / (2 * np.pi * 1e-6 * length), rel=1e-5)
        assert pores.thermal_length == pytest.approx(2 * pores.viscous_length, rel=1e-5)

    @pytest.mark.parametrize("orientation", [0.0, 1 / 3, 0.7])
    def test_viscous_length_is_that_of_growing_walls(self, orientation):
        """2 / Lambda = d ln(tortuosity / porosity) / d radius."""
        solid, radius, step = 0.2, 1.0, 1e-6

        def formation(growth):
            share = solid * (radius + growth) ** 2
            return fibres(1 - share, 1.0, orientation).tortuosity / (1 - share)

        slope = np.log(formation(step) / formation(-step)) / (2 * step)
        assert fibres(0.8, 2.0, orientation).viscous_length == pytest.approx(2 / slope, rel=1e-7)

    @pytest.mark.parametrize("solid", [0.01, 0.02, 0.05, 0.1])
    def test_what_the_docstring_says_of_uneven_ones(self, solid):
        """Jackson & James 1986, Davies 1952; Bies & Hansen 1980, 3.18e-9 density^1.53 / d^2, glass of 2450 kg/m3."""
        random = 3 / (20 * solid) * (-np.log(solid) - 0.931)
        assert 1.15 < random / fibres(1 - solid, 2.0, 1 / 3).permeability < 1.4
        filters = 1 / (16 * solid**1.5 * (1 + 56 * solid**3))
        assert 1.35 < filters / fibres(1 - solid, 2.0).permeability < 1.8
        if solid < 0.1:
            wool = 4 * 1.84e-5 / (3.18e-9 * (2450 * solid) ** 1.53)
            assert 3.4 < wool / fibres(1 - solid, 2.0).permeability < 4.6


class TestCells:
    def test_struts_of_a_cell(self):
        """36 edges that three cells share make the solid; Gibson & Ashby: 1.06 (strut / edge)^2 of square ones."""
        size, porosity = 6e-4, 0.97
        pores = open_cells(porosity, size)
        edge = size / (2 * np.sqrt(2))
        radius = pores.thermal_length * (1 - porosity) / porosity
        assert 12 * edge * np.pi * radius**2 / (8 * np.sqrt(2) * edge**3) == pytest.approx(1 - porosity)
        assert 1.06 * np.pi * radius**2 / edge**2 == pytest.approx(1 - porosity, rel=1e-3)

    def test_fibres_in_all_directions(self):
        pores = open_cells(0.98, 6e-4)
        same = fibres(0.98, 2 * pores.thermal_length * 0.02 / 0.98, 1 / 3)
        assert_allclose(astuple(pores), astuple(same), rtol=1e-12)
        assert pores.viscous_length / pores.thermal_length == pytest.approx(0.6, rel=0.02)

    def test_size_of_a_common_foam(self):
        """Reticulated foam of 0.6 mm: some 3 to 5 kN s/m4."""
        assert 3e3 < AIR.viscosity / open_cells(0.98, 6e-4).permeability < 5e3


class TestGrains:
    @pytest.mark.parametrize(
        ("solid", "drag", "within"), [(0.5236, 42.14, 0.1), (0.6802, 162.9, 0.15), (0.7405, 435, 0.17)]
    )
    def test_regular_packings(self, solid, drag, within):
        """A. A. Zick & G. M. Homsy, J. Fluid Mech. 115 (1982) 13-26: drag over Stokes's."""
        assert grains(1 - solid, 2.0).permeability == pytest.approx(2 / (9 * solid * drag), rel=within)

    @pytest.mark.parametrize("porosity", [0.35, 0.4, 0.45])
    def test_kozeny_carman(self, porosity):
        """P. C. Carman 1937: d^2 porosity^3 / (180 (1 - porosity)^2)."""
        carman = 4 * porosity**3 / (180 * (1 - porosity) ** 2)
        assert grains(porosity, 2.0).permeability == pytest.approx(carman, rel=0.12)

    def test_a_single_grain(self):
        """Stokes: k = 2 r^2 / (9 solid) far apart."""
        assert grains(1 - 1e-15, 2.0).permeability * 1e-15 == pytest.approx(2 / 9, rel=1e-3)

    def test_heat(self):
        """T of a cell, laplacian T = -1, 0 at the grain, no flow through the cell's face."""
        solid = 0.6
        b = solid ** (-1 / 3)
        mean = quad(lambda r: 3 * r**2 / b**3 * ((1 - r**2) / 6 + b**3 / 3 * (1 - 1 / r)), 1, b)[0]
        assert grains(0.4, 2.0).thermal_permeability == pytest.approx(mean, rel=1e-10)

    def test_lengths(self):
        """Boutin & Geindreau 2010: 2 phi (3 - phi) r / (9 (1 - phi)); twice the volume over the surface."""
        pores = grains(0.4, 2.0)
        assert pores.viscous_length == pytest.approx(2 * 0.4 * 2.6 / (9 * 0.6))
        assert pores.thermal_length == pytest.approx(2 * 0.4 / (3 * 0.6))


@pytest.mark.parametrize("make", [fibres, lambda p, d: fibres(p, d, 1 / 3), open_cells, grains])
@pytest.mark.parametrize("porosity", [0.4, 0.7, 0.95, 0.999])
def test_what_holds_of_all_pores(make, porosity):
    """Viscous at most thermal (M. Avellaneda & S. Torquato, Phys. Fluids A 3 (1991) 2529-2540), tortuosity above 1."""
    pores = make(porosity, 1e-4)
    assert pores.permeability <= pores.thermal_permeability
    assert pores.viscous_length <= pores.thermal_length
    assert pores.tortuosity >= 1
    doubled = make(porosity, 2e-4)
    assert doubled.permeability == pytest.approx(4 * pores.permeability)
    assert doubled.viscous_length == pytest.approx(2 * pores.viscous_length)


def test_a_layer_by_its_structure_is_one_by_its_parameters():
    pores = grains(0.4, 2e-3)
    by_parameters = EquivalentFluid(
        model="jcal", thickness=0.05, porosity=0.4, flow_resistivity=AIR.viscosity / pores.permeability,
        tortuosity=pores.tortuosity, viscous_length=pores.viscous_length, thermal_length=pores.thermal_length,
        thermal_permeability=pores.thermal_permeability,
    )  # fmt: skip
    by_structure = EquivalentFluid(model="grains", thickness=0.05, porosity=0.4, grain_diameter=2e-3)
    ours, theirs = (plane_wave(Stack(layers=(layer,)), OMEGA / (2 * np.pi)) for layer in (by_structure, by_parameters))
    assert_allclose(ours.surface_impedance, theirs.surface_impedance, rtol=1e-12)


def test_a_thinner_gas_flows_more_easily():
    """Geometry stays, the viscosity changes: not so with a given flow resistivity."""
    layer = EquivalentFluid(model="fibres", thickness=0.05, porosity=0.97, fibre_diameter=1e-5)
    normal, thin = (
        plane_wave(Stack(layers=(layer,), ambient={"viscosity": eta}), 50.0).surface_impedance.real
        for eta in (1.8e-5, 0.9e-5)
    )
    assert thin == pytest.approx(normal / 2, rel=0.05)


def test_in_an_elastic_frame():
    felt = Poroelastic(
        model="fibres", thickness=0.02, porosity=0.9, fibre_diameter=2e-5, frame_density=1e5, young_modulus=1e13,
        poisson_ratio=0.3,
    )  # fmt: skip
    rigid = EquivalentFluid(model="fibres", thickness=0.02, porosity=0.9, fibre_diameter=2e-5)
    ours, theirs = (
        plane_wave(Stack(layers=(layer,)), OMEGA / (2 * np.pi)).surface_impedance for layer in (felt, rigid)
    )
    assert_allclose(ours, theirs, rtol=0.01)


@pytest.mark.parametrize(
    ("model", "fields", "told"),
    [
        (
            "fibres",
            {"porosity": 0.6, "fibre_diameter": 1e-5},
            r"fibres holds for porosity from 0\.7 to 1; here it is 0\.6",
        ),
        ("open_cells", {"porosity": 0.9, "cell_size": 1e-3}, r"open cells holds for porosity from 0\.95"),
        ("grains", {"porosity": 0.2, "grain_diameter": 1e-3}, r"grains holds for porosity from 0\.26"),
        ("grains", {"porosity": 0.4, "grain_diameter": 0.1}, r"2 pi pore size / wavelength up to 1; .*5000 Hz"),
    ],
)
def test_outside_the_range(model, fields, told):
    with pytest.warns(ValidityWarning, match=told):
        PORE_MODELS[model].fluid(OMEGA, AIR, fields)
