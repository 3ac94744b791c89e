"""Records that end before the ring-down does: the model is cut there, too. Data of rods, another forward model."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.experiments.two_plate.burst import BurstData
from multilayer.experiments.two_plate.record_end import RecordEnd, period_of
from multilayer.fits.joint import fit as joint_fit
from multilayer.signals.spectra import Noise, frequencies, to_signal, to_spectrum
from tests.fits.rods import campaign_of_rods, constant_loss

BURSTS = (100.0, 300.0, 500.0, 700.0, 900.0)
AT = np.array(BURSTS)


def off(fit, law):
    """Return the largest error of E2, relative, and that of E1 and E2 over their standard deviations."""
    moduli, covariance = fit.moduli(AT)
    error = moduli - law(AT)
    spread = np.sqrt([covariance[:, 0, 0], covariance[:, 1, 1]])
    return np.max(np.abs(error.imag / law(AT).imag)), np.max(np.abs(np.stack([error.real, error.imag]) / spread))


@pytest.mark.parametrize("storage", [2e5, 4e5])
def test_low_loss_and_a_short_record(storage, monkeypatch):
    law = constant_loss(storage, 0.02)
    campaign, recordings = campaign_of_rods(law, frequencies=BURSTS, tail=0.08, noise=(0.002, 0.002))
    fit = joint_fit.fit_joint(campaign, recordings)
    error, sigmas = off(fit, law)
    assert fit.p_value > 0.01
    assert sigmas < 3
    assert error < 0.1
    # what the ends do otherwise
    monkeypatch.setattr(joint_fit, "cut_where_records_end", lambda solved, bursts: solved)
    before = joint_fit.fit_joint(campaign, recordings)
    assert before.p_value < 1e-5


def test_where_the_ring_down_is_over_nothing_changes(monkeypatch):
    campaign, recordings = campaign_of_rods(constant_loss(2e5, 0.3), frequencies=BURSTS[:3])
    fit = joint_fit.fit_joint(campaign, recordings)
    monkeypatch.setattr(joint_fit, "cut_where_records_end", lambda solved, bursts: solved)
    before = joint_fit.fit_joint(campaign, recordings)
    (now, covariance), (then, _) = fit.moduli(AT[:3]), before.moduli(AT[:3])
    assert np.all(np.abs((now - then).real) < 0.5 * np.sqrt(covariance[:, 0, 0]))
    assert np.all(np.abs((now - then).imag) < 0.5 * np.sqrt(covariance[:, 1, 1]))


def test_what_is_missing_is_what_the_record_lacks():
    rate, f0, resonance, decay = 25600.0, 400.0, 320.0, 15.0
    long = 2**16
    time = np.arange(long) / rate
    base = np.where(time < 10 / f0, np.sin(2 * np.pi * f0 * time) * np.sin(np.pi * time * f0 / 10) ** 2, 0.0)

    def motion(f):
        pole = (2 * np.pi) ** 2 * (resonance**2 + 0j) + 2j * np.pi * f * 2 * decay
        return pole / (pole - (2 * np.pi * np.asarray(f)) ** 2)

    f = frequencies(long, rate)
    top = to_signal(motion(f) * to_spectrum(base, long), long, long)
    n = round((10 / f0 + 0.02) * rate)
    assert np.abs(top[n - 100 : n]).max() > 0.02 * np.abs(top).max()
    burst = BurstData("one", f0, rate, base[:n], top[:n], Noise(0.0, 0.0))
    bins = np.array([310.0, 350.0, 402.5, 470.0])
    end = RecordEnd.of(burst, bins, (0.0, np.inf), period_of(burst, motion, (0.0, np.inf)))
    w = np.exp(-2j * np.pi * np.outer(bins / rate, np.arange(n)))
    shown = (w @ top[:n]) / (w @ base[:n])
    whole = motion(bins)
    assert np.max(np.abs(shown / whole - 1)) > 0.05
    np.testing.assert_allclose(whole - end.missing(motion(end.frequency)), shown, rtol=2e-3)


def test_the_effect_of_the_ends_to_first_order_is_that_of_differences():
    campaign, recordings = campaign_of_rods(constant_loss(2e5, 0.02), frequencies=(300.0, 500.0), tail=0.08)
    fit = joint_fit.fit_joint(campaign, recordings)
    problem = fit.problem
    assert all(data.ends for data in problem.data)
    z = fit.best.z
    step = np.where(np.arange(z.size) % 2, 1e-4, -1e-4)
    exact = replace(problem, end_effect=None)
    there = exact.residual(z + step) - exact.residual(z)
    first_order = problem.residual(z + step) - problem.residual(z)
    np.testing.assert_allclose(first_order, there, atol=2e-2 * np.abs(there).max())
