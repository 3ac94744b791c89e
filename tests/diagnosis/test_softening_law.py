"""The law of softening with strain beside a rod whose equations of motion are integrated in time."""

import numpy as np
import pytest
from scipy.signal import resample

from multilayer.diagnosis.effects.amplitude_softening import AmplitudeSoftening
from multilayer.experiments.two_plate.burst import BurstData
from multilayer.experiments.two_plate.effects import Setting
from multilayer.experiments.two_plate.ratios import ConfigurationData
from multilayer.media.rod import rod_transmissibility
from multilayer.rig.softening import PronySeries, SofteningRod
from tests.fits.test_joint import campaign_and_signals

RATE, N, HEIGHT, DENSITY = 51200.0, 8192, 0.025, 60.0
SERIES = PronySeries(np.array([2e5]), np.array([[6e4], [6e4]]), np.array([1e-3, 1e-4]))
SINGLE = PronySeries(SERIES.relaxed[0], SERIES.stiffnesses[:, 0], SERIES.times)


def burst(frequency, cycles=10):
    t = np.arange(N) / RATE - 0.01
    inside = (t > 0) & (t < cycles / frequency)
    return np.where(inside, 5 * np.sin(np.pi * t * frequency / cycles) ** 2 * np.sin(2 * np.pi * frequency * t), 0)


def heard(top, frequency):
    """Return a burst whose record is long enough."""
    data = BurstData("", frequency, RATE, burst(frequency), top, None, 10.0)
    object.__setattr__(data, "n_fft", 4 * N)
    object.__setattr__(data, "cut_short", False)
    return data


def setting_of(data, load=15.7):
    """Return the setting of a burst alone: a sample of `HEIGHT` and `DENSITY` under a plate of a mass per area."""
    campaign, _ = campaign_and_signals()
    f = data.in_band[0]
    configuration = campaign.configurations[0].model_copy(
        update={"specimen_thickness": HEIGHT, "top_plate_thickness": load / campaign.top_plate.density}
    )
    specimen = campaign.specimen.model_copy(update={"density": DENSITY})
    of_all, base, top = data.spectra
    bins = np.searchsorted(of_all, f)
    measured = ConfigurationData(
        "", HEIGHT, f, np.zeros(len(f), dtype=int), top[bins] / base[bins], np.ones(len(f)), np.array([data.frequency]),
        stretch_moments=data.stretch_moments,
    )  # fmt: skip
    return Setting(campaign.model_copy(update={"specimen": specimen}), configuration, measured, np.zeros(len(f)))


@pytest.mark.parametrize("load", [3.0, 15.7])
@pytest.mark.parametrize("power", [0.7, 1.0, 1.3])
@pytest.mark.parametrize(
    ("softening", "frequency"), [(50.0, 150.0), (200.0, 200.0), (200.0, 400.0), (1000.0, 150.0), (1000.0, 200.0)]
)
def test_the_modulus_as_a_softening_rod_shows_it(load, power, softening, frequency):
    rod = SofteningRod(HEIGHT, DENSITY, load, SERIES, softening, power, 1500.0)
    steps = rod.oversampling(RATE)
    base = resample(burst(frequency), N * steps)[np.newaxis]
    soft, linear = (rod.top(base, steps * RATE, softened=softened)[0, ::steps] for softened in (True, False))
    bursts = [heard(top, frequency) for top in (soft, linear)]
    f = bursts[0].in_band[0]
    softened, exact = (np.fft.rfft(b.top, b.n_fft)[np.searchsorted(b.spectra[0], f)] for b in bursts)
    law = AmplitudeSoftening()
    values = {"softening": np.array(softening), "memory": np.array(0.0), "power": np.array([power])}
    modulus = law.modulus(setting_of(bursts[0], load), SINGLE(f), values)
    change = rod_transmissibility(f, modulus, DENSITY, HEIGHT, load) / rod_transmissibility(
        f, SINGLE(f), DENSITY, HEIGHT, load
    )
    found = softened / exact
    assert np.abs(found - 1).max() > 2e-3
    is_strong = softening > 500
    if not is_strong:  # where it is, bins at the ends of the band may show next to nothing
        assert np.abs(change / found - 1).max() < 0.02 * np.abs(found - 1).max()
    # as the noise of the channel shows it
    shown = np.abs(exact) / np.abs(exact).max()
    largest = np.max(shown * np.abs(found - 1))
    assert np.max(shown * np.abs(change - found)) < (0.025 if is_strong and load < 5 else 0.007) * largest


def test_moments_between_the_powers_that_are_kept():
    data = heard(2 * burst(200.0) + 0.3 * burst(230.0), 200.0)
    setting = setting_of(data)
    f, base, top = data.spectra
    stretch = np.zeros(data.n_fft, dtype=complex)
    near = (f > 80) & (f < 360)
    stretch[: len(f)][near] = 2 * (top - base)[near] / (2 * np.pi * f[near]) ** 2 / HEIGHT
    signal, bins = np.fft.ifft(stretch), np.searchsorted(f, data.in_band[0])
    for power in (0.4, 0.7, 1.0, 1.7, 2.6, 4.0):
        expected = np.fft.fft(np.abs(signal) ** power * signal)[bins] / stretch[bins]
        found = setting.by_strain(setting.strain_nodes**power)
        strong = np.abs(base[bins]) > 0.3 * np.abs(base[bins]).max()
        np.testing.assert_allclose(found, expected, rtol=5e-4)
        np.testing.assert_allclose(found[strong], expected[strong], rtol=1e-4)


@pytest.mark.parametrize("centre", [180.0, 200.0, 215.0, 240.0])
def test_the_strain_of_a_tone_at_a_resonance_between_the_bins(centre):
    """The ratio bends sharply at a resonance of loss factor 0.15; its reciprocal does not."""
    f = centre * np.linspace(0.82, 1.18, 6)
    law, plate = 2.2e5 * (1 + 0.15j), 7.85
    ratio = rod_transmissibility(f, law, DENSITY, HEIGHT, plate)
    exact = rod_transmissibility(np.array([centre]), law, DENSITY, HEIGHT, plate)
    data = ConfigurationData("", HEIGHT, f, np.zeros(6, dtype=int), ratio, np.ones(6), np.array([centre]))
    campaign, _ = campaign_and_signals()
    setting = Setting(
        campaign, campaign.configurations[0].model_copy(update={"specimen_thickness": HEIGHT}), data, np.zeros(6)
    )
    stretch = abs(exact[0] - 1) * campaign.burst.level_rms * np.sqrt(16 / 3) / (2 * np.pi * centre) ** 2
    np.testing.assert_allclose(setting.burst_strain, stretch / HEIGHT, rtol=2e-3)
