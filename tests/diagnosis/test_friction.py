"""Dry friction beside the sample is told as such: forces in time beside those of its describing function."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.diagnosis import diagnose
from multilayer.diagnosis.place_fits import fit_places
from multilayer.diagnosis.places import PLACES
from multilayer.diagnosis.places.beside import Beside, Friction
from multilayer.diagnosis.simple_forms import simple_form
from multilayer.experiments.places import Term
from multilayer.experiments.two_plate.burst import BurstData
from multilayer.fits.burst.fit import burst_problems
from multilayer.fits.settings import FitSettings
from multilayer.signals.spectra import Noise, frequencies, padded_length, to_signal, to_spectrum
from multilayer.testing import check_place
from multilayer.testing.benches import joint_bench
from tests.fits.rods import campaign_of_rods, fractional_zener

LAW = fractional_zener(1.2e5, 12 * 1.2e5, 2e-5, 0.45)
STICKS = 0.02  # of the largest velocity: the force is F tanh(v / STICKS)
OVERSAMPLING = 8


def force(base, top, rate, frequency):
    """Return the force of 1 N of dry friction on the top plate over time, by what both plates do, and padded."""
    n = padded_length(2 * base.size, 1)
    f = frequencies(n, rate)
    near = (f > 0.3 * frequency) & (f < 5 * frequency)
    velocity = np.zeros(OVERSAMPLING * n // 2 + 1, dtype=complex)
    velocity[: len(f)][near] = (to_spectrum(top, n) - to_spectrum(base, n))[near] / (2j * np.pi * f[near])
    moving = to_signal(OVERSAMPLING * velocity, OVERSAMPLING * n, OVERSAMPLING * n)
    return f, -to_spectrum(np.tanh(moving / (STICKS * np.abs(moving).max())), OVERSAMPLING * n)[: len(f)] / OVERSAMPLING


def with_friction(newton):
    """Return a campaign of rods with friction between the plates, found by iteration, and its recordings."""
    campaign, recordings = campaign_of_rods(
        LAW, frequencies=(150.0, 300.0, 500.0, 700.0, 900.0, 1200.0), thicknesses=(0.0125, 0.025),
        top_plates=(0.001, 0.003), tail=0.4, noise=(0.002, 0.002),
    )  # fmt: skip
    for configuration in campaign.configurations:
        height, area = configuration.specimen_thickness, np.pi * configuration.specimen_radius**2
        mass = campaign.top_plate.density * configuration.top_plate_thickness
        for burst in configuration.bursts:
            key = configuration.name, burst.frequency
            base, top = (np.atleast_2d(each) for each in (recordings[key].base, recordings[key].top))
            change = np.zeros(base.shape[-1])
            for _ in range(8):
                moved = top.mean(axis=0) + change
                f, resists = force(base.mean(axis=0), moved, campaign.sampling_rate, burst.frequency)
                # of the plate on a rod whose foot is at rest
                omega, modulus = 2 * np.pi * np.maximum(f, 1.0), LAW(np.maximum(f, 1.0))
                wave = omega * np.sqrt(campaign.specimen.density / modulus)
                inertia = area * (mass - modulus * wave / np.tan(wave * height) / omega**2)
                answer = np.where(f > 20, newton * resists / inertia, 0.0)
                change = to_signal(answer, padded_length(2 * base.shape[-1], 1), base.shape[-1])
            recordings[key] = replace(recordings[key], top=np.reshape(top + change, recordings[key].top.shape))
    return campaign, recordings


def test_the_friction_of_a_steady_tone():
    rate, f0, n = 25600.0, 400.0, 25600
    tone = np.sin(2 * np.pi * f0 * np.arange(n) / rate)
    data = BurstData("", f0, rate, tone, 3 * tone, Noise(0.0, 0.0))
    object.__setattr__(data, "n_fft", n)
    object.__setattr__(data, "cut_short", False)
    at = np.argmin(np.abs(data.in_band[0] - f0))
    assert data.friction[at] == pytest.approx(4j / np.pi / (2 / (2 * np.pi * f0) ** 2), rel=3e-4)


@pytest.mark.parametrize("height", [0.0125, 0.05])
@pytest.mark.parametrize("frequency", [200.0, 800.0, 1500.0])
def test_the_friction_of_a_burst_is_that_of_its_force_in_time(height, frequency):
    campaign, recordings = campaign_of_rods(
        LAW, frequencies=(frequency,), thicknesses=(height,), tail=0.4, noise=(0, 0)
    )
    (recording,) = recordings.values()
    base, top = (np.atleast_2d(each).mean(axis=0) for each in (recording.base, recording.top))
    data = BurstData("", frequency, campaign.sampling_rate, base, top, Noise(0.0, 0.0))
    f, motion_base, motion_top = data.in_band
    at, resists = force(base, top, campaign.sampling_rate, frequency)
    expected = -np.interp(f, at, resists.real) - 1j * np.interp(f, at, resists.imag)
    found = data.friction * (motion_top - motion_base) / -((2 * np.pi * f) ** 2)
    assert np.max(np.abs(found - expected)) < 0.02 * np.abs(expected).max()


def test_plates_that_hardly_move_apart_have_no_larger_friction():
    """Of a stiff sample the stretch is in the noise, which may not pass for a force that is large beside it."""
    found = []
    for noise in (0.0, 0.01):
        campaign, recordings = campaign_of_rods(
            fractional_zener(1e7, 1.2e8, 2e-5, 0.45), frequencies=(100.0,), thicknesses=(0.0125,), tail=0.4,
            noise=(noise, noise),
        )  # fmt: skip
        (problem,) = burst_problems(campaign, recordings, FitSettings(), None)
        found.append(np.abs(problem.data.friction).max())
    assert found[1] < 2 * found[0]


def test_it_keeps_the_laws_and_needs_signals():
    check_place(Friction())
    settings = joint_bench().settings
    assert [type(place) for place in PLACES["beside"].instances(settings)] == [Beside, Friction]
    bare = tuple(replace(each, data=replace(each.data, friction=None)) for each in settings)
    assert [type(place) for place in PLACES["beside"].instances(bare)] == [Beside]


@pytest.mark.parametrize("newton", [2e-4, pytest.param(1e-3, marks=pytest.mark.slow)])
def test_it_is_told_beside_the_sample_with_its_force(newton):
    nominal, _ = diagnose.fit_nominal(*with_friction(newton))
    first, second, *_ = fit_places(nominal).values()
    assert type(first.place) is Friction
    assert first.log_evidence - second.log_evidence > 30
    form = simple_form(nominal, first).fitted.hypothesis.effects[-1]
    assert form.terms[0].kind in ("power", "lossy")
    middle = np.argmin(np.abs(first.grid - 400.0))
    assert first.law()[middle] == pytest.approx(newton, rel=0.15)
    if newton < 5e-4:
        assert form.terms == (Term("power", 0),)
