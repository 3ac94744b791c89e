"""Discs with open rims as a reduced model, beside rods and full finite elements."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.special import iv, jv, roots_legendre

from multilayer.errors import InputError
from multilayer.media.elastic import FIRST_BENDING
from multilayer.rig import TwoPlateRig
from multilayer.rig.partly_bonded import CENTRE_DEFLECTION, WIDEST_RIM, deflection, partly_bonded_disc, slope

SLOW = pytest.mark.slow
F = np.linspace(60, 1500, 30)
NONE = np.zeros((1, 1))


def wave(radius, thickness, loss=0.15):
    """Return x of the frequencies F and what a plate of 2 mm adds to the force, in units of E A / h."""
    modulus, omega = 3e5 * (1 + 1j * loss), 2 * np.pi * F
    return 60.0 * (omega * thickness) ** 2 / modulus, omega**2 * 7850 * 2e-3 * thickness / modulus


@pytest.mark.parametrize("shape", [0.2, 0.45, 1.125, 3.0])
def test_without_rims_it_is_a_rod(shape):
    x = np.geomspace(1e-6, 30, 60) * (1 - 0.1j)
    root = np.sqrt(x)
    disc = partly_bonded_disc(0.0, shape)
    for top, base in (disc.bonded(x), disc.stiffness(x, NONE, NONE + 1)[:2]):
        scale = np.abs(root / np.sin(root))
        assert np.max(np.abs(top - root / np.tan(root)) / scale) < 3e-3
        assert np.max(np.abs(base + root / np.sin(root)) / scale) < 3e-3
        np.testing.assert_allclose(top.ravel()[:30], (root / np.tan(root))[:30], rtol=1e-5)


@pytest.mark.parametrize("at_base", [0, pytest.param(1, marks=SLOW), pytest.param(2, marks=SLOW)])
@pytest.mark.parametrize("rim", [0.05, *(pytest.param(rim, marks=SLOW) for rim in (0.125, 0.3, 0.303)), 0.5])
@pytest.mark.parametrize(
    ("radius", "thickness", "ratio"),
    [(0.0225, 0.025, 0.0), (0.0225, 0.01, 0.0), (0.012, 0.03, 0.0), (0.0225, 0.025, 0.3)],
)
def test_it_moves_a_plate_as_full_finite_elements_do(radius, thickness, ratio, rim, at_base):
    """Within 0.25 % of the largest motion, of elements so small that halving them changes nothing."""
    x, load = wave(radius, thickness)
    coarse, fine = (
        TwoPlateRig(
            radius, thickness, 60.0, ratio, 2e-3, plate_modulus=2.1e13,
            bonded_fraction=(1 - rim) ** 2, open_faces=("top", "both", "base")[at_base], resolution=resolution,
        ).transmissibility(F, 3e5 * (1 + 0.15j))
        for resolution in (1.25, 2.5)
    )  # fmt: skip
    expected = 2 * fine - coarse  # errors are as large as the elements, about where the bond ends
    disc = partly_bonded_disc(ratio, radius / (2 * thickness))
    top, base, *_ = disc.stiffness(x, NONE + rim, NONE + at_base)
    bonded_top, bonded_base = disc.bonded(x)
    moved, nominal = (-b / (t - load) for t, b in ((top[0], base[0]), (bonded_top, bonded_base)))
    largest = np.abs(expected).max()
    assert np.abs(moved - expected).max() < 0.0025 * largest
    if rim > 0.1:
        assert np.abs(moved - expected).max() < 0.1 * np.abs(nominal - expected).max()


def test_a_thick_soft_sample_at_every_frequency():
    """Up to 1.3 wavelengths of height, where the plate moves by a hundredth of its largest motion."""
    radius, thickness, rim = 0.0225, 0.04, 0.15
    rig = TwoPlateRig(
        radius, thickness, 60.0, 0.0, 2e-3, plate_modulus=2.1e13, bonded_fraction=(1 - rim) ** 2, open_faces="top",
        resolution=1.5,
    )  # fmt: skip
    modulus = 1.5e5 * (1 + 0.3j)
    expected = rig.transmissibility(F, modulus)
    omega = 2 * np.pi * F
    x = 60.0 * (omega * thickness) ** 2 / modulus
    disc = partly_bonded_disc(0.0, radius / (2 * thickness))
    top, base, *_ = disc.stiffness(x, NONE + rim, NONE)
    moved = -base[0] / (top[0] - omega**2 * 7850 * 2e-3 * thickness / modulus)
    assert np.abs(x).max() > 50
    assert np.abs(expected).min() < 0.01 * np.abs(expected).max()
    np.testing.assert_allclose(moved, expected, rtol=0.02)


@pytest.mark.parametrize("rim", [0.05, 0.253, 0.6])
def test_an_open_rim_below_is_the_mirror_image_of_one_above(rim):
    """Forces of slow motion, and of one plate on the other at any frequency, are the same; those by inertia are not."""
    disc, x = partly_bonded_disc(0.3, 0.6), np.array([[1e-9, 1.0, 8.0, 30.0]]) * (1 - 0.1j)
    above, below = (disc.stiffness(x, NONE + rim, NONE + at_base) for at_base in (0, 2))
    np.testing.assert_allclose(below[1], above[1], rtol=2e-3)
    np.testing.assert_allclose(below[0][:, 0], above[0][:, 0], rtol=1e-6)
    assert np.all(np.abs(below[0] / above[0] - 1)[:, 2:] > 1e-3)
    np.testing.assert_allclose(below[2][:, 0], -below[3][:, 0], rtol=1e-6)
    halves = disc.stiffness(x, NONE + rim, NONE + 1.5)
    both = disc.stiffness(x, NONE + rim, NONE + 1)
    np.testing.assert_allclose(halves[0], (both[0] + below[0]) / 2, rtol=1e-12)


@pytest.mark.parametrize("place", [0.35, 0.6, 0.85, 1.0])
def test_deflection_of_a_free_plate_by_rayleigh_and_ritz(place):
    """Least energy over polynomials in r^2 under a force in the centre that inertia, spread evenly, balances."""
    powers, ratio = np.arange(1, 25), 0.3
    x, weights = roots_legendre(80)
    t, weights = 0.5 * (x + 1)[:, None], 0.5 * weights[:, None]  # r^2, and 2 r dr = dt
    radial = 2 * powers * (2 * powers - 1) * t ** (powers - 1)  # W''
    round_ = 2 * powers * t ** (powers - 1)  # W'/r
    mixed = radial.T @ (weights * round_)
    energy = radial.T @ (weights * radial) + round_.T @ (weights * round_) + ratio * (mixed + mixed.T)
    amounts = 8 * np.linalg.lstsq(energy, -1 / (powers + 1), rcond=1e-14)[0]
    expected = np.sum(amounts * (place ** (2 * powers) - 1 / (powers + 1)))
    assert float(deflection(np.array([place]))[0]) == pytest.approx(expected, abs=2e-3)


def test_the_first_mode_of_a_free_plate():
    """Neither a moment nor a force at the rim, with Bessel functions."""
    k, ratio = np.sqrt(FIRST_BENDING), 0.3
    share = -jv(1, k) / iv(1, k)  # of I0 beside J0, for no force
    moment = -jv(0, k) + jv(1, k) / k + share * (iv(0, k) - iv(1, k) / k) + ratio / k * (share * iv(1, k) - jv(1, k))
    assert moment == pytest.approx(0.0, abs=1e-4)


def test_slope_is_the_derivative_of_deflection():
    place, step = np.linspace(0.31, 1.0, 7), 1e-5
    expected = (deflection(place + step) - deflection(place - step)) / (2 * step)
    np.testing.assert_allclose(slope(place), expected, rtol=1e-8)


def test_a_moved_plate_does_not_bend_by_its_inertia():
    radii = np.sqrt((np.arange(20000) + 0.5) / 20000)
    assert np.mean(deflection(radii)) == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("rim", [0.1, 0.2, 0.35])
@pytest.mark.parametrize("thickness", [0.0125, 0.025, 0.04])
def test_a_sample_with_an_open_rim_bends_the_plate_of_finite_elements(thickness, rim):
    """1 mm of steel beside a rigid plate: within 0.2 % of the reading, and 2 % of its bending, which is a quarter."""
    radius, plate, modulus = 0.0225, 1e-3, 2e5 * (1 + 0.2j)
    elastic, rigid = (
        TwoPlateRig(
            radius, thickness, 60.0, 0.0, plate, plate_modulus=e, bonded_fraction=(1 - rim) ** 2, open_faces="top"
        ).transmissibility(F, modulus)
        for e in (2.1e11, 2.1e14)
    )
    expected = elastic / rigid
    omega, area = 2 * np.pi * F, np.pi * radius**2
    stiffness = 2.1e11 * plate**3 / (12 * (1 - 0.3**2))
    first = FIRST_BENDING / radius**2 * np.sqrt(stiffness / (7850 * plate))
    disc = partly_bonded_disc(0.0, radius / (2 * thickness))
    x = 60.0 * (omega * thickness) ** 2 / modulus
    unit = modulus * area / thickness
    forces = disc.stiffness(x, NONE + rim, NONE, plate / (2 * radius))
    top, base, by_top, by_base, by_bending = (unit * part[0] for part in forces)
    # the plate's mean motion and its bending: forces on both are 0 but those of the base
    inertia = omega**2 * 7850 * plate * area
    own = 8 * np.pi * stiffness / radius**2 * CENTRE_DEFLECTION * (1 - (omega / first) ** 2)
    matrix = np.moveaxis(np.array([[top - inertia, by_top], [by_top, own + by_bending]]), -1, 0)
    mean, bent = np.linalg.solve(matrix, -np.stack([base, by_base], axis=-1)[..., None])[..., 0].T
    found = (mean + CENTRE_DEFLECTION * bent) / (-base / (top - inertia))
    off, largest = np.abs(found - expected).max(), np.abs(expected - 1).max()
    assert largest > 0.02
    assert off < 0.002
    assert off < 0.02 * largest


@given(
    st.floats(0.0, WIDEST_RIM - 0.05),
    st.floats(0.0, 0.05),
    st.floats(0.0, 1.0),
    st.sampled_from([(0.0, 0.24), (0.0, 1.8), (0.3, 0.9)]),
)
@example(0.0, 0.00195, 0.5, (0.0, 1.8))
@example(0.625, 0.0, 1.0, (0.0, 1.8))
@settings(max_examples=30, deadline=None)
@pytest.mark.slow
def test_wider_rims_are_softer_and_take_power(rim, more, at_base, ratio_and_shape):
    disc = partly_bonded_disc(*ratio_and_shape)
    soft, softer = (disc.stiffness(np.array([1e-9 + 0j]), NONE + w, NONE + at_base)[0].real for w in (rim, rim + more))
    assert 0 < softer <= soft * (1 + 1e-9)
    # E (1 + 0.2 i) at a displacement that is not moved at the base: power flows into the sample
    top, *_ = disc.stiffness(np.geomspace(1e-3, 50, 40) / (1 + 0.2j), NONE + rim, NONE + at_base)
    assert np.all((top * (1 + 0.2j)).imag > 0)


@pytest.mark.parametrize("at_base", [0.0, 1.0])
def test_the_widest_rims_resonate_as_those_a_little_narrower(at_base):
    """A straight line through two narrower rims foretells the widest to 10 %, with the resonances of the others."""
    disc, x = partly_bonded_disc(0.0, 0.9), np.geomspace(0.1, 9, 60) / (1 + 0.2j)
    rims = (0.68, 0.69, WIDEST_RIM)
    first, second, widest = (np.array(disc.stiffness(x, NONE + rim, NONE + at_base)) for rim in rims)
    off = np.abs(widest - 2 * second + first).max(axis=-1) / np.abs(widest).max(axis=-1)
    assert np.all(off < 0.1)


def test_rims_broadcast_over_samples():
    disc, x = partly_bonded_disc(0.0, 0.9), np.geomspace(0.1, 9, 5) * (1 - 0.2j)
    rims, shares = np.array([[0.02], [0.31], [0.6]]), np.array([[0.0], [0.5], [1.0]])
    together = np.array(disc.stiffness(x, rims, shares))
    alone = [np.array(disc.stiffness(x, r[None], s[None]))[:, 0] for r, s in zip(rims, shares, strict=True)]
    np.testing.assert_allclose(together, np.stack(alone, axis=1), rtol=1e-12)


@pytest.mark.parametrize(("ratio", "shape", "field"), [(0.5, 1.0, "poisson_ratio"), (0.3, 0.0, "shape")])
def test_out_of_range(ratio, shape, field):
    with pytest.raises(InputError, match=field):
        partly_bonded_disc(ratio, shape)
