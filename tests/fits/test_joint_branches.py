"""The right one of several solutions of a joint fit, or all of them. Data of rods, another forward model."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.fits.joint.fit import fit_joint
from multilayer.fits.joint.laws import Candidate, LawMixture, with_deviations
from multilayer.inference.least_squares import minimise
from multilayer.measurements.description import USUAL_UNCERTAINTY
from tests.fits.rods import campaign_of_rods, constant_loss, fractional_zener

RINGING = (100.0, 300.0, 500.0, 700.0, 900.0)
SOFT = fractional_zener(1e4, 1.5e5, 2e-5, 0.4)  # one and a half wavelengths in a sample of 4 cm at 1500 Hz


def made(frequencies, height=0.04, noise=0.01, law=SOFT, **options):
    return campaign_of_rods(
        law, thicknesses=(height,), frequencies=frequencies, density=87.0, noise=(noise, noise), **options
    )


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(
    ("frequencies", "height", "noise"),
    [((1400.0, 1500.0), 0.04, 0.01), ((1500.0, 1600.0), 0.04, 0.01), ((1200.0, 1300.0), 0.05, 0.02)],
)
def test_the_right_wavelength_is_found_of_few_bursts(frequencies, height, noise, seed):
    fit = fit_joint(*made(frequencies, height, noise, seed=seed))
    at = np.array(frequencies)
    moduli, covariance = fit.moduli(at)
    assert fit.p_value > 1e-3
    assert np.all(np.abs(moduli / SOFT(at) - 1) < 0.03)
    assert np.all(np.abs((moduli - SOFT(at)).real) < 4 * np.sqrt(covariance[:, 0, 0]))


@pytest.fixture(scope="module")
def noisy():
    """A burst whose top is nearly noise: half the wavelength explains it nearly as well."""
    return fit_joint(*made((1500.0,), noise=0.6, seed=0))


def two_modes(fit):
    """Return a law with its solution, and another one of the same evidence with a modulus a half of that."""
    problem, best = fit.problem, fit.best
    other = replace(best, z=best.z - np.eye(best.z.size)[problem.space.scale])
    return Candidate("one", problem, [best]), Candidate("two", problem, [best, other])


def test_moduli_are_means_over_all_solutions(noisy):
    one, two = two_modes(noisy)
    f = np.array([1500.0])
    shares = [share for share, _, _ in two.moments_of_modes(f)]
    ((_, first, within), (_, second, beside)) = two.moments_of_modes(f)
    mean, covariance = two.moments(f)
    assert np.allclose(one.moments(f)[0], first)
    assert sum(shares) == pytest.approx(1)
    assert mean == pytest.approx(shares[0] * first + shares[1] * second)
    apart = (first - second).real
    expected = shares[0] * within[:, 0, 0] + shares[1] * beside[:, 0, 0] + shares[0] * shares[1] * apart**2
    assert covariance[:, 0, 0] == pytest.approx(expected)
    assert LawMixture([one]).far_modes(f) == []
    assert len(LawMixture([two]).far_modes(f)) == 2


def test_departures_are_sought_from_every_solution(noisy):
    problem = noisy.problem
    far = [minimise(problem, minimum.z) for minimum in noisy.minima]
    assert len(Candidate("", problem, far).modes) > 1
    for candidate in with_deviations("", problem, far):
        e1 = [modulus[0].real for _, modulus, _ in candidate.moments_of_modes(np.array([1500.0]))]
        assert max(e1) > 1.3 * min(e1)


def test_solutions_that_are_left_open_are_told(noisy):
    open_ones = noisy.laws.far_modes(np.array([1500.0]))
    assert len(open_ones) > 1
    (burst,) = noisy.bursts
    e1 = np.array([modulus[0].real for _, modulus in open_ones])
    assert min(e1) < burst.storage_modulus < max(e1)
    assert abs(burst.storage_modulus - SOFT(1500.0).real) < 2 * burst.storage_modulus_std
    assert "several solutions are left open (probability): E1 at 1500 Hz is" in noisy.remark_on_laws
    assert "several solutions" not in fit_joint(*made((1500.0, 1600.0))).remark_on_laws


def test_where_nothing_is_stated_a_careful_laboratory_is_supposed_and_that_is_told():
    campaign, recordings = made((300.0, 600.0), 0.025)
    stated = fit_joint(campaign, recordings)
    assert (stated.problem.known, stated.warnings) == (campaign.uncertainty, [])
    silent = fit_joint(campaign.model_copy(update={"uncertainty": type(campaign.uncertainty)()}), recordings)
    assert silent.problem.known == USUAL_UNCERTAINTY
    (told,) = silent.warnings
    assert "uncertainty: not stated, so taken as usual of a careful laboratory: channel_gain 0.003" in told
    assert "channel_delay 1e-06 s" in told
    assert silent.bursts[0].storage_modulus_std == pytest.approx(stated.bursts[0].storage_modulus_std, rel=1e-3)


def test_what_is_left_out_beside_what_is_stated_is_exact():
    fit = fit_joint(*made((300.0, 600.0), 0.025, stated={"channel_gain": 0.003, "thickness": 0.0}))
    assert [parameter.name for parameter in fit.problem.nuisances.parameters] == ["channel_gain"]
    assert fit.warnings == []


def test_bursts_that_are_left_out_are_told():
    fit = fit_joint(*made(RINGING, 0.025, 0.002, constant_loss(2e5, 0.02), tail=0.05))
    (missing,) = set(RINGING) - set(fit.problem.data[0].centres)
    (told,) = fit.warnings
    assert "bursts left out, whose records end long before all is at rest: " in told
    assert f"h25mm-t1mm at {missing:g} Hz; record longer" in told
