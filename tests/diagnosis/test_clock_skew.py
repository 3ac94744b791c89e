"""A skew between the clocks of the two channels is told where it is: in the reading, over the time of each record."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.diagnosis import diagnose
from multilayer.diagnosis.place_fits import fit_places
from multilayer.diagnosis.places import PLACES
from multilayer.diagnosis.places.reading import Reading, ReadingOverTime
from multilayer.diagnosis.simple_forms import simple_form
from multilayer.diagnosis.unknown_cause import tolerant_evidence
from multilayer.experiments.places import Term
from multilayer.experiments.two_plate.burst import BurstData
from multilayer.experiments.two_plate.nuisances import with_usual_uncertainty
from multilayer.rig.effects.clock_skew import resampled
from multilayer.signals.spectra import Noise
from multilayer.testing import check_place
from multilayer.testing.benches import joint_bench
from tests.fits.rods import campaign_of_rods, constant_loss, fractional_zener

RATE, FREQUENCY = 25600.0, 400.0


def burst(top):
    return BurstData("", FREQUENCY, RATE, top, top, Noise(0.0, 0.0))


def test_the_slopes_of_a_gaussian_pulse():
    """Its spectrum is a Gaussian of standard deviation 1/T about its frequency, and a delay."""
    time, delay, duration = np.arange(8192) / RATE, 0.08, 0.006
    pulse = np.exp(-0.5 * ((time - delay) / duration) ** 2) * np.cos(2 * np.pi * FREQUENCY * (time - delay))
    data = burst(pulse)
    omega, centre = 2 * np.pi * data.in_band[0], 2 * np.pi * FREQUENCY
    by_omega = -((omega - centre) * duration**2) - 1j * delay
    expected = np.stack([omega * by_omega, omega * by_omega - (omega * duration) ** 2])
    np.testing.assert_allclose(data.top_slopes, expected, rtol=1e-7)


@pytest.mark.parametrize(("skew", "error"), [(5e-5, 1e-7), (-2e-3, 4e-5), (1e-2, 5e-3)])
def test_the_place_reads_as_a_converter_with_that_clock(skew, error):
    """Beside the motion that is read at the samples of such a clock; the error of the third order in the skew."""
    time, rest = np.arange(8192) / RATE, 0.05
    since = np.maximum(time - rest, 0.0)
    ring_down = np.where(since > 0, since**2 * np.exp(-since / 0.004) * np.sin(2 * np.pi * FREQUENCY * since), 0.0)
    true, read = burst(ring_down), burst(resampled(ring_down, np.arange(time.size) * (1 + skew)))
    setting = joint_bench().settings[0]
    setting = replace(setting, data=replace(setting.data, top_slopes=read.top_slopes))
    bins = np.searchsorted(true.spectra[0], read.in_band[0])
    found = ReadingOverTime().motion(setting, np.ones(len(bins), dtype=complex), np.array([skew]))
    expected = read.in_band[2] / true.spectra[2][bins]
    assert np.max(np.abs(np.log(expected))) > 100 * abs(skew)
    assert np.max(np.abs(np.log(found / expected))) < error


def test_it_keeps_the_laws_and_needs_signals():
    check_place(ReadingOverTime())
    settings = joint_bench().settings
    assert [type(place) for place in PLACES["reading"].instances(settings)] == [Reading, ReadingOverTime]
    bare = tuple(replace(each, data=replace(each.data, top_slopes=None)) for each in settings)
    assert [type(place) for place in PLACES["reading"].instances(bare)] == [Reading]


@pytest.mark.parametrize("skew", [pytest.param(1e-4, marks=pytest.mark.slow), -1e-3])
def test_it_is_told_in_the_reading_with_its_size(skew):
    campaign, recordings = campaign_of_rods(
        constant_loss(2e5, 0.2), frequencies=(150.0, 300.0, 500.0, 700.0, 900.0, 1200.0), thicknesses=(0.0125, 0.025),
        top_plates=(0.001, 0.003), tail=0.4, noise=(0.002, 0.002),
    )  # fmt: skip
    for key, recording in recordings.items():
        index = np.arange(recording.top.shape[-1]) * (1 + skew)
        rows = [resampled(row, index) for row in np.atleast_2d(recording.top)]
        recordings[key] = replace(recording, top=np.reshape(rows, recording.top.shape))
    nominal, _ = diagnose.fit_nominal(campaign, recordings)
    first, second, *_ = fit_places(nominal).values()
    assert type(first.place) is ReadingOverTime
    assert first.log_evidence - second.log_evidence > 10
    form = simple_form(nominal, first)
    assert form.form.terms == (Term("power", 0),)
    value, deviation = form.fitted.minimum.z[-1], np.sqrt(form.fitted.minimum.covariance[-1, -1])
    assert abs(value - form.form.parameters[0].prior.coordinate(skew)) < 4 * deviation
    assert deviation < 0.2 * abs(value)


def test_the_noise_of_a_long_record_is_no_skew():
    """What is computed of the signals carries their noise, by which a law may not take up that of their ratio."""
    campaign, recordings = campaign_of_rods(
        fractional_zener(1.2e5, 12 * 1.2e5, 2e-5, 0.45), frequencies=tuple(range(100, 1501, 100)),
        thicknesses=(0.0125, 0.025), top_plates=(0.001, 0.003), tail=1.0, noise=(0.004, 0.004), seed=3,
    )  # fmt: skip
    nominal, _ = diagnose.fit_nominal(with_usual_uncertainty(campaign)[0], recordings)
    for name, place in fit_places(nominal, names=["reading", "beside"]).items():
        assert place.log_evidence < tolerant_evidence(nominal) + 2, name
