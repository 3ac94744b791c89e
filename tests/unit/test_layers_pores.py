"""`equivalent_fluid`, `limp`, and the pores of `poroelastic`: fields by model, and what the layers do with them."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.config import parse_yaml
from multilayer.config.validate import validate
from multilayer.errors import InputError, ValidityWarning
from multilayer.layers.equivalent_fluid import EquivalentFluid
from multilayer.layers.limp import Limp
from multilayer.layers.poroelastic import Poroelastic
from multilayer.media.gas import dry_air
from multilayer.media.pore_models import PORE_MODELS
from multilayer.response import plane_wave
from multilayer.stack import Stack
from multilayer.testing import check_layer

FREQUENCIES = np.array([100.0, 500.0, 2000.0])
BAND = np.array([400.0, 4000.0])  # within the range of the empirical models
JCA = {
    "thickness": 0.05, "porosity": 0.98, "flow_resistivity": 15e3, "tortuosity": 1.05, "viscous_length": 1e-4,
    "thermal_length": 2.5e-4,
}  # fmt: skip
FIELDS = {
    "delany_bazley": {"flow_resistivity": 15e3},
    "miki": {"flow_resistivity": 15e3},
    "jca": JCA,
    "jcal": {**JCA, "thermal_permeability": 9e-9},
    "jcapl": {
        **JCA, "thermal_permeability": 9e-9, "static_viscous_tortuosity": 1.4, "static_thermal_tortuosity": 1.5,
    },
    "wilson": {"porosity": 0.98, "tortuosity": 1.05, "flow_resistivity": 15e3},
    "horoshenkov_swift": {"porosity": 0.4, "median_pore_size": 1e-4, "pore_size_deviation": 0.3},
    "fibres": {"porosity": 0.97, "fibre_diameter": 1e-5},
    "open_cells": {"porosity": 0.97, "cell_size": 6e-4},
    "grains": {"porosity": 0.4, "grain_diameter": 1e-3},
    "double_porosity": {**JCA, "perforation": 0.1, "hole_radius": 1e-3},
}  # fmt: skip
TAKEN = {name: {**fields, "thickness": 0.05} for name, fields in FIELDS.items()}


def mistakes(layer):
    """Return the messages of a stack file with one layer, written in flow style, by path."""
    with pytest.raises(InputError) as caught:
        validate(parse_yaml(f"layers:\n- {layer}\n", Path("stack.yaml")), Stack)
    return {problem.path: (problem.message, problem.line, problem.column) for problem in caught.value.problems}


def surface(layer, frequency=FREQUENCIES, angle=0.0):
    return plane_wave(Stack(layers=(layer,)), frequency, angle).surface_impedance


class TestFields:
    @pytest.mark.parametrize("name", FIELDS)
    def test_every_model(self, name):
        layer = EquivalentFluid.model_validate({"model": name, **TAKEN[name]})
        assert np.all(np.isfinite(surface(layer, BAND)))

    def test_all_models_are_here(self):
        assert set(FIELDS) == set(PORE_MODELS)

    @pytest.mark.parametrize("name", sorted(set(FIELDS) - {"double_porosity"}))
    def test_limp_wants_the_porosity_too(self, name):
        layer = Limp.model_validate({"model": name, **TAKEN[name], "porosity": 0.96, "frame_density": 20.0})
        assert np.all(np.isfinite(surface(layer, BAND)))
        told = mistakes(f"{{type: limp, model: {name}, thickness: 1 mm, frame_density: 20}}")
        assert "porosity" in told["layers.0.porosity"][0]

    def test_wilson_by_its_times(self):
        fields = {"thickness": 0.05, "porosity": 0.98, "tortuosity": 1.05}
        layer = EquivalentFluid(model="wilson", vorticity_time=1e-4, entropy_time=7e-5, **fields)
        assert np.all(np.isfinite(surface(layer)))

    def test_everything_wrong_is_told_at_its_place(self):
        told = mistakes("{type: equivalent_fluid, model: miki, thickness: -1 mm, porosity: 0.9, thermal_length: 1 mm}")
        takes = "model 'miki' takes flow_resistivity"
        assert told == {
            "layers.0.thickness": ("-0.001 is not allowed: it must be above 0.0", 2, 52),
            "layers.0.flow_resistivity": (f"is missing; {takes}", 2, 3),
            "layers.0.porosity": (f"does not belong here; {takes}", 2, 59),
            "layers.0.thermal_length": (f"does not belong here; {takes}", 2, 74),
        }

    def test_the_nearest_variant_is_asked_for(self):
        told = mistakes("{type: equivalent_fluid, model: wilson, thickness: 1 mm, porosity: 0.9, entropy_time: 1 ms}")
        assert set(told) == {"layers.0.tortuosity", "layers.0.vorticity_time"}
        assert told["layers.0.tortuosity"][0] == (
            "is missing; model 'wilson' takes porosity, tortuosity, vorticity_time and entropy_time, "
            "or porosity, tortuosity and flow_resistivity"
        )

    def test_unknown_model(self):
        told = mistakes("{type: equivalent_fluid, model: jcb, thickness: 1 mm}")
        assert set(told) == {"layers.0.model"}
        assert "'jcb' is not allowed; allowed: 'delany_bazley', 'miki'" in told["layers.0.model"][0]

    def test_unknown_field(self):
        told = mistakes("{type: equivalent_fluid, model: miki, thickness: 1 mm, flow_resistivty: 2e4}")
        assert told["layers.0.flow_resistivty"][0] == "there is no such field; did you mean 'flow_resistivity'?"

    def test_model_that_is_no_text(self):
        assert "layers.0.model" in mistakes("{type: equivalent_fluid, model: [jca], thickness: 1 mm}")

    def test_static_tortuosity_is_the_larger(self):
        fields = {**FIELDS["jcapl"], "static_viscous_tortuosity": 1.01}
        with pytest.raises(ValueError, match="must be above tortuosity"):
            EquivalentFluid(model="jcapl", **fields)

    def test_poroelastic_takes_the_johnson_family(self):
        frame = "frame_density: 20, young_modulus: 1 MPa, poisson_ratio: 0.3"
        pores = "porosity: 0.9, flow_resistivity: 1e4, tortuosity: 1.1, viscous_length: 1 mm, thermal_length: 2 mm"
        told = mistakes(f"{{type: poroelastic, thickness: 1 mm, model: jcal, {pores}, {frame}}}")
        assert set(told) == {"layers.0.thermal_permeability"}
        told = mistakes(f"{{type: poroelastic, thickness: 1 mm, thermal_permeability: 1e-9, {pores}, {frame}}}")
        assert told["layers.0.thermal_permeability"][0].startswith("does not belong here; model 'jca' takes porosity")
        told = mistakes(f"{{type: poroelastic, thickness: 1 mm, model: miki, {pores}, {frame}}}")
        assert set(told) == {"layers.0.model"}

    def test_poroelastic_says_what_is_missing_once(self):
        told = mistakes("{type: poroelastic, thickness: 1 mm, frame_density: 9, young_modulus: 1e5, poisson_ratio: 0}")
        assert told["layers.0.porosity"][0] == "is missing; it is required"
        assert len(told) == 5


class TestLaws:
    """The contract in the band of the empirical models; the other models are in tests/contract."""

    @pytest.mark.parametrize("name", ["delany_bazley", "miki"])
    def test_empirical_models(self, name):
        band = np.geomspace(0.02, 0.98, 5) * 15e3
        check_layer(EquivalentFluid(model=name, thickness=0.05, flow_resistivity=15e3), frequency=band)
        limp = Limp(model=name, thickness=0.05, flow_resistivity=15e3, porosity=0.95, frame_density=30.0)
        check_layer(limp, frequency=band)


class TestPhysics:
    def test_warns_once_an_evaluation(self):
        layer = EquivalentFluid(model="miki", thickness=0.05, flow_resistivity=15e3)
        with pytest.warns(ValidityWarning, match=r"Miki .* \(100 Hz\)") as caught:
            result = plane_wave(Stack(layers=(layer,)), FREQUENCIES, [0.0, 30.0, 60.0])
        assert len(caught) == 1
        assert np.all(np.isfinite(result.reflection))

    def test_heavy_limp_frame_is_rigid(self):
        assert_allclose(surface(Limp(**JCA, frame_density=1e9)), surface(EquivalentFluid(**JCA)), rtol=1e-4)

    def test_soft_elastic_frame_is_limp(self):
        """Without stiffness of the frame Biot's medium is Panneton's fluid, but for the pressure on the frame."""
        elastic = Poroelastic(**JCA, frame_density=30.0, young_modulus=1.0 + 0.3j, poisson_ratio=0.0)
        frequency = np.array([300.0, 1000.0])
        air = plane_wave(Stack(layers=(elastic,), termination="ambient"), frequency)
        limp = plane_wave(Stack(layers=(Limp(**JCA, frame_density=30.0),), termination="ambient"), frequency)
        assert_allclose(air.reflection, limp.reflection, rtol=0.01)
        assert_allclose(air.transmission, limp.transmission, rtol=0.01)

    def test_stiff_elastic_frame_is_rigid(self):
        elastic = Poroelastic(**JCA, frame_density=1e5, young_modulus=1e13, poisson_ratio=0.3)
        assert_allclose(surface(elastic), surface(EquivalentFluid(**JCA)), rtol=0.01)

    @pytest.mark.parametrize("name", ["jcal", "jcapl"])
    def test_pores_of_a_stiff_elastic_frame(self, name):
        elastic = Poroelastic(model=name, **FIELDS[name], frame_density=1e5, young_modulus=1e13, poisson_ratio=0.3)
        assert_allclose(surface(elastic), surface(EquivalentFluid(model=name, **FIELDS[name])), rtol=0.01)

    def test_thick_layer_has_the_characteristic_impedance(self):
        density, bulk = PORE_MODELS["miki"].fluid(2 * np.pi * BAND, dry_air(), FIELDS["miki"])
        layer = EquivalentFluid(model="miki", thickness=4.0, flow_resistivity=15e3)
        assert_allclose(surface(layer, BAND), np.sqrt(density * bulk), rtol=1e-6)
