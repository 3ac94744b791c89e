"""The finite-element rig against closed forms, the stack solver, and itself."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.media.laws import FractionalZener
from multilayer.media.rod import rod_transmissibility
from multilayer.response import base_motion
from multilayer.rig import Ranges, ReducedRig, TwoPlateRig, dynamic_shape_factor, static_shape_factor
from multilayer.stack import Stack

FREQUENCY = np.array([20.0, 100.0, 300.0, 500.0, 1000.0, 1500.0])
MODULUS = 2e5 * (1 + 0.2j)
DISC = {"radius": 0.0225, "thickness": 0.025, "density": 80.0, "poisson_ratio": 0.3, "plate_thickness": 1e-3}
PORES = {
    "porosity": 0.97,
    "flow_resistivity": 3e4,
    "tortuosity": 1.2,
    "viscous_length": 8e-5,
    "thermal_length": 2e-4,
}
# shape factors of ../shared/GAP.md: rows nu, columns S = radius / (2 thickness)
SHAPES = (0.25, 0.5, 1.0, 1.5, 2.5)
CONFINED = {
    0.1: (1.005, 1.011, 1.016, 1.019, 1.020),
    0.2: (1.022, 1.047, 1.075, 1.087, 1.097),
    0.3: (1.054, 1.119, 1.211, 1.254, 1.290),
    0.4: (1.108, 1.255, 1.541, 1.712, 1.875),
    0.45: (1.146, 1.370, 1.931, 2.375, 2.872),
    0.49: (1.186, 1.504, 2.636, 4.131, 7.026),
}


def disc(**changes):
    return TwoPlateRig(**{**DISC, **changes})


def relative(found, expected):
    return np.max(np.abs(found / expected - 1))


def test_without_lateral_contraction_it_is_the_rod_under_a_mass():
    # a top plate a thousand times as stiff: the rod's mass is rigid
    rig = disc(poisson_ratio=0.0, plate_modulus=2.1e14, plate_poisson_ratio=0.0)
    rod = rod_transmissibility(FREQUENCY, MODULUS, rig.density, rig.thickness, rig.plate_thickness * rig.plate_density)
    assert relative(rig.transmissibility(FREQUENCY, MODULUS), rod) < 1e-4


def test_a_rim_that_is_held_makes_a_plane_wave():
    rig = disc(rim="held")
    solids = [
        {"name": "s", "thickness": 0.025, "density": 80, "young_modulus": MODULUS, "poisson_ratio": 0.3},
        {"name": "p", "thickness": 1e-3, "density": 7850, "young_modulus": 2.1e11, "poisson_ratio": 0.3},
    ]
    layers = [{"type": "elastic_solid", **solid} for solid in solids]
    stack = Stack.model_validate({"layers": layers, "termination": "free"})
    plane = base_motion(stack, FREQUENCY).transmissibility
    assert relative(rig.transmissibility(FREQUENCY, MODULUS), plane) < 1e-3


def test_a_held_sealed_rim_makes_a_plane_wave_of_biot():
    pores = {**PORES, "type": "poroelastic", "name": "s", "frame_density": 60, "young_modulus": MODULUS}
    plate = {"type": "elastic_solid", "name": "p", "density": 7850, "young_modulus": 2.1e11, "thickness": 1e-3}
    layers = [{**pores, "thickness": 0.025, "poisson_ratio": 0.3}, {**plate, "poisson_ratio": 0.3}]
    plane = base_motion(Stack.model_validate({"layers": layers, "termination": "free"}), FREQUENCY).transmissibility
    rig = disc(density=60.0, rim="held", pore_rim="sealed", **PORES)
    assert relative(rig.transmissibility(FREQUENCY, MODULUS), plane) < 1e-3


def test_pores_full_of_nothing_leave_the_frame():
    # air a thousand times as thin, and not resisted
    thin = disc(air=TwoPlateRig(**DISC).air.__class__(1.2e-3, 343.0, 1.8e-8, 0.71, 1.4, 101.325))
    pores = {**PORES, "flow_resistivity": 3e1}
    found = thin.replaced(**pores).transmissibility(FREQUENCY, MODULUS)
    assert relative(found, thin.transmissibility(FREQUENCY, MODULUS)) < 5e-3


def test_an_open_rim_lets_the_air_out():
    sealed, opened, frame = (
        disc(**fields).transmissibility([50.0], MODULUS)[0]
        for fields in ({**PORES, "pore_rim": "sealed"}, {**PORES, "pore_rim": "open"}, {})
    )
    # trapped air is stiff; air that leaves through the rim hardly is
    assert abs(sealed - 1) < 0.95 * abs(opened - 1)
    assert abs(opened / frame - 1) < 1e-3


@pytest.mark.parametrize("nu", sorted(CONFINED))
def test_static_shape_factors(nu):
    found = [static_shape_factor(nu, shape) for shape in SHAPES]
    np.testing.assert_allclose(found, CONFINED[nu], rtol=1e-3)


def test_a_wide_disc_is_confined_like_a_layer():
    nu = 0.3
    held = (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    assert static_shape_factor(nu, 40.0) == pytest.approx(held, rel=5e-3)
    assert static_shape_factor(0.0, 3.0) == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("ratio", [0.5, 2.0])
def test_a_disc_that_is_stiffer_along_its_radius_is_a_slimmer_one(ratio):
    """The stretched coordinates of `static_shape_factor`, against the rig's own anisotropic elements."""
    plain, other = (
        dynamic_shape_factor(disc(transverse_ratio=t, plate_modulus=2e11), [5.0], MODULUS)[0] for t in (1.0, ratio)
    )
    change = static_shape_factor(0.3, 0.45, radial_stiffness=ratio) / static_shape_factor(0.3, 0.45)
    assert abs(change - 1) > 0.01
    assert other / plain == pytest.approx(change, rel=1e-4)


def test_dynamic_shape_factors_start_at_the_static_one():
    found = dynamic_shape_factor(disc(), [5.0, 1000.0], MODULUS)
    # on the soft base of a rod's mass: an elastic plate, so not to all digits
    assert found[0] == pytest.approx(static_shape_factor(0.3, 0.45), rel=1e-3)
    assert found[1] != pytest.approx(found[0], rel=0.01)


EFFECTS = {
    "sensor": {"sensor_mass": 1e-3},
    "sensor at the edge": {"sensor_mass": 1e-3, "sensor_radius": 0.015},
    "adhesive": {"adhesive_thickness": 0.25e-3, "adhesive_modulus": 1.5e5 * (1 + 0.4j)},
    "partly bonded": {"bonded_fraction": 0.7},
    "skins": {"skin_thickness": 1e-3, "skin_ratio": 3.0},
    "graded": {"modulus_profile": (1.0, 2.0)},
    "transversely isotropic": {"transverse_ratio": 2.0, "shear_ratio": 1.5},
    "elastic base": {"base_thickness": 0.01},
    "flanked": {"flanking_stiffness": 2e3 * (1 + 0.1j)},
    "poroelastic": PORES,
}


@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_changes_the_motion_and_is_passive(name):
    nominal = disc().transmissibility(FREQUENCY, MODULUS)
    found = disc(**EFFECTS[name]).transmissibility(FREQUENCY, MODULUS)
    # a centimetre of metal yields little under a soft sample
    assert relative(found, nominal) > (1e-4 if name == "elastic base" else 1e-3)
    # the base does work on a passive sample: it lags
    assert found[0].imag < 0
    assert abs(found[0] - 1) < 0.1


@pytest.mark.parametrize("name", EFFECTS)
def test_the_reduced_basis_is_the_full_solution(name):
    rig = disc(**EFFECTS[name])
    ranges = Ranges((90.0, 1600.0), (1e5, 5e5), density=(0.95, 1.05), plate_mass=(0.95, 1.05))
    reduced = ReducedRig.build(rig, ranges)
    assert reduced.error < 1e-5
    at = ranges.draw(4, 1234)
    from multilayer.rig.assembly import assemble, coefficients
    from multilayer.rig.solve import full_solution

    assembly = assemble(rig, rig.section(1600.0, 1e5 * 0.95 / 1.05))
    full = full_solution(assembly, coefficients(rig, assembly.names, at))
    found = reduced.transmissibility(at.frequency, at.modulus, at.density, at.thickness, at.plate_mass)
    assert relative(found, full) < 1e-4


@pytest.mark.parametrize("name", ["plain", "pores"])
def test_one_basis_holds_for_several_samples(name):
    rig, ranges = disc(**(PORES if name == "pores" else {})), Ranges((90.0, 1600.0), (1e5, 5e5), (0.1, 0.4))
    reduced = ReducedRig.of_solids(rig, ranges, [(0.4, 1.0), (0.2, 1.0), (0.3, 2.0), (0.3, 0.5)], 1e-4)
    with pytest.raises(AssertionError, match="made by `of_solids`"):
        replace(reduced, constants=None).with_solid((0.2, 1.0))
    for ratio, radial in [(0.3, 1.0), (0.35, 1.0), (0.25, 1.6), (0.38, 0.6)]:
        full = rig.replaced(poisson_ratio=ratio, transverse_ratio=radial)
        found = reduced.with_solid((ratio, radial)).transmissibility(FREQUENCY[1:], MODULUS)
        assert relative(found, full.transmissibility(FREQUENCY[1:], MODULUS)) < 1e-3


def test_partial_fractions_are_the_reduced_solution():
    reduced = ReducedRig.build(disc(), Ranges((90.0, 1600.0), (1e5, 5e5), thickness=(0.98, 1.02)))
    f = np.array([120.0, 700.0, 1500.0])
    moduli = np.array([[1.2e5], [4e5]]) * (1 + np.array([0.1j, 0.3j, 0.8j]))
    together = reduced.transmissibility(f, moduli, thickness=1.01)
    apart = [reduced.transmissibility(f, row, thickness=1.01) for row in moduli]
    np.testing.assert_allclose(together, apart, rtol=1e-8)


def test_relative_thickness_is_thickness():
    reduced = ReducedRig.build(disc(), Ranges((90.0, 1600.0), (1e5, 5e5), thickness=(0.95, 1.05)))
    thicker = disc(thickness=0.025 * 1.05).transmissibility(FREQUENCY[1:], MODULUS)
    assert relative(reduced.transmissibility(FREQUENCY[1:], MODULUS, thickness=1.05), thicker) < 1e-3


def test_many_frequencies_are_the_same_as_few():
    law = FractionalZener(relaxed_modulus=1e5, unrelaxed_modulus=1e6, relaxation_time=1e-4, order=0.4)
    many = np.linspace(100, 1500, 57)
    swept = disc().transmissibility(many, law)
    one_by_one = disc().transmissibility(many[::8], law)
    # the meshes are the same: they follow the shortest wavelength
    assert relative(swept[::8], one_by_one) < 1e-4


def test_halving_the_mesh_tells_its_error():
    rig = disc()
    estimate = rig.error_estimate(FREQUENCY, MODULUS)
    finer = rig.replaced(resolution=4.0).transmissibility(FREQUENCY, MODULUS)
    true = np.abs(rig.transmissibility(FREQUENCY, MODULUS) / finer - 1)
    assert np.all(estimate < 1e-3)
    assert np.all(true < 2 * estimate + 1e-6)


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"poisson_ratio": 0.5}, "incompressible"),
        ({"sensor_radius": 0.03}, "off the plate"),
        ({"sensor_radius": 0.021, "sensor_mass": 1e-3}, "off the plate"),
        ({"adhesive_thickness": 0.03, "adhesive_modulus": 1e6}, "more than the sample's thickness"),
        ({"adhesive_thickness": 1e-4}, "adhesive_modulus: is missing"),
        ({"bonded_fraction": 0.0}, "bonded_fraction"),
        ({"skin_thickness": 0.0125}, "leaves no core"),
        ({"porosity": 0.9}, "flow_resistivity"),
        ({"density": -1.0}, "density: -1.0 is not allowed"),
    ],
)
def test_what_makes_no_rig_is_refused(changes, word):
    with pytest.raises(InputError, match=word):
        disc(**changes)


def test_a_wavelength_too_short_for_the_mesh_is_refused():
    with pytest.raises(InputError, match="limit is 20000"):
        disc().transmissibility([50e3], 1e4 * (1 + 0.1j))


@pytest.mark.parametrize(("frequency", "modulus"), [([0.0], 1e5), ([100.0], -1e5), ([100.0], 1e5 - 1e4j), ([], 1e5)])
def test_frequencies_and_moduli_out_of_range_are_refused(frequency, modulus):
    with pytest.raises(InputError):
        disc().transmissibility(frequency, modulus)


def test_a_reduced_rig_refuses_what_it_was_not_made_for():
    reduced = ReducedRig.build(disc(), Ranges((90.0, 300.0), (1e5, 2e5)))
    with pytest.raises(InputError, match="leaves the reduced rig's range"):
        reduced.transmissibility([400.0], 1.5e5)
    with pytest.raises(InputError, match="modulus"):
        reduced.transmissibility([100.0], 3e5)
