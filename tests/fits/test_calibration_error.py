"""The calibration's own uncertainty is in every deviation. Data of rods, another forward model."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.fits.burst.fit import fit_bursts
from multilayer.fits.joint.fit import fit_joint
from multilayer.signals.calibration import Calibration
from tests.fits.rods import campaign_of_rods, fractional_zener

BURSTS = (200.0, 500.0, 800.0, 1100.0)
LAW = fractional_zener(1.2e5, 1.5e6, 2e-5, 0.45)
NOTHING = {"channel_gain": 1e-6}  # stated, so that deviations are those of noise, calibration and misfit


def calibrated(std, rng=None):
    error = np.zeros(4) if rng is None else std * rng.standard_normal(4)
    phase = np.zeros(4) if rng is None else std * rng.standard_normal(4)
    return Calibration(BURSTS, 1 + error, phase / (2 * np.pi * np.array(BURSTS)), np.full(4, std))


@pytest.mark.parametrize("heights", [(0.025,), (0.0125, 0.025)])
def test_burst_by_burst_and_jointly_the_truth_is_held(heights):
    std, rng = 0.01, np.random.default_rng(2)
    campaign, recordings = campaign_of_rods(
        LAW, thicknesses=heights, frequencies=BURSTS, noise=(0.001, 0.001), stated=NOTHING
    )
    true, bursts, moduli = LAW(np.array(BURSTS)), [], []
    for _ in range(8):
        calibration = calibrated(std, rng)
        result = fit_bursts(campaign, recordings, None, calibration)
        bursts += [(b.storage_modulus - LAW(b.frequency).real) / b.storage_modulus_std for b in result.bursts]
        fit = fit_joint(campaign, recordings, calibration=calibration)
        found, covariance = fit.moduli(np.array(BURSTS))
        moduli += list((found - true).real / np.sqrt(covariance[:, 0, 0]))
        assert fit.p_value > 1e-3
    for errors in (bursts, moduli):
        assert np.mean(np.abs(errors) < 2) > 0.85
        assert np.std(errors) > 0.3  # several mountings share a calibration: at most twice as wide as needed


def test_a_calibration_that_is_known_exactly_changes_no_deviation():
    campaign, recordings = campaign_of_rods(LAW, frequencies=BURSTS[:2])
    sure = calibrated(0.0)
    with_it, without = (fit_bursts(campaign, recordings, None, c).bursts for c in (sure, None))
    for b, c in zip(with_it, without, strict=True):
        assert b.storage_modulus_std == pytest.approx(c.storage_modulus_std, rel=1e-6)


def test_deviations_survive_a_file():
    made = calibrated(0.003)
    again = Calibration.from_dict(made.to_dict())
    assert again.std_at(350.0) == pytest.approx(0.003)
    old = {name: values for name, values in made.to_dict().items() if name != "std"}
    assert Calibration.from_dict(old).std_at(350.0) == 0.0
    assert replace(made, std=np.zeros(4)).std_at(200.0) == 0.0
