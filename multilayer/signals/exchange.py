"""Which channel leads: base and top told apart by the order in which energy arrives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multilayer.arrays import RealArray
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import frequencies, noise_level, padded_length, to_signal, to_spectrum

SWAPPED = -1
_SIGNIFICANT = 5.0  # standard deviations of the noise
_CHAIN_DELAY = 1.0  # samples by which two chains may differ before they are calibrated
_DEEP = 0.1  # top 20 dB below base
_FADE = 2.0  # nepers over a record


def energy_delay(recording: Recording, frequency: float, cycles: float) -> tuple[float, float]:
    """Return by how much the top's energy comes later than the base's, and the standard deviation of that.

    The instant of a channel is the centre of its energy, ``sum t x(t)^2 / sum x(t)^2``, after the channel is
    filtered to the burst's main lobe and the energy of the noise is taken out. So mains hum and noise at other
    frequencies do not count, nor does a resonance there that rings until the record cuts it. In terms of spectra the
    delay is the group delay weighted with the energy spectrum.

    Both channels are multiplied by the same decaying exponential, ``exp(-s t)``, so that the missing rest of a
    ring-down that the record cuts hardly counts. The result is the group delay of T(w - i s), which for a response
    without zeros is positive like that of T(w): its poles only move further away.

    Parameters
    ----------
    recording : Recording
    frequency : float
        Of the burst, Hz.
    cycles : float
        Of the burst, under its Hann window: the main lobe reaches ``2 / cycles`` to either side.

    Returns
    -------
    delay, deviation : float
        In samples. The deviation is what the noise of the repeats causes; infinite when a channel is mere
        noise.
    """
    noise = noise_level(recording, of_mean=True)
    lobe = _Lobe.of(recording, frequency, cycles)
    base, top = recording.mean()
    (early, base_variance), (late, top_variance) = lobe.centre(base, noise.base), lobe.centre(top, noise.top)
    return late - early, float(np.sqrt(base_variance + top_variance))


@dataclass(frozen=True)
class _Lobe:
    """A filter without delay for the main lobe of a burst, after a fade over the record.

    Attributes
    ----------
    fade : array, shape (n_samples,)
    gain : array, shape (n_fft // 2 + 1,)
        A Hann window about the burst's frequency: smooth, so that it does not ring.
    n_fft : int
        Transform length.
    """

    fade: RealArray
    gain: RealArray
    n_fft: int

    @classmethod
    def of(cls, recording: Recording, frequency: float, cycles: float) -> _Lobe:
        n_fft = padded_length(recording.n_samples)
        away = (frequencies(n_fft, recording.sampling_rate) - frequency) * cycles / frequency  # the lobe ends at 2
        gain = np.where(np.abs(away) < 2, np.cos(np.pi / 4 * away) ** 2, 0.0)
        return cls(np.exp(-_FADE * np.linspace(0, 1, recording.n_samples)), gain, n_fft)

    def filtered(self, signal: RealArray) -> RealArray:
        """Return the faded and filtered signal, shape (n_fft,); times before the record's start are at the end."""
        return self._through(self.fade * (signal - signal.mean()))

    def _through(self, signal: RealArray) -> RealArray:
        return to_signal(self.gain * to_spectrum(signal, self.n_fft), self.n_fft, self.n_fft)

    def centre(self, signal: RealArray, noise: float) -> tuple[float, float]:
        """Return the centre of a channel's energy, in samples, and its variance."""
        n, n_fft = signal.size, self.n_fft
        passed = self.filtered(signal)
        index = np.arange(n_fft)
        index = np.where(index < (n + n_fft) // 2, index, index - n_fft)
        # the energy that white noise leaves at each sample, by the filter's impulse response
        pulse = to_signal(self.gain, n_fft, n_fft)
        spread = to_spectrum(self.fade**2, n_fft) * to_spectrum(pulse**2, n_fft)
        of_noise = noise**2 * to_signal(spread, n_fft, n_fft)
        energy = float(np.sum(passed**2) - np.sum(of_noise))
        if energy <= 0:
            return 0.0, np.inf
        centre = float(np.sum(index * (passed**2 - of_noise)) / energy)
        # noise against signal to first order, and the scatter of the noise's own energy, alike over the filter's memory
        against = self.fade * self._through((index - centre) * passed)[:n]
        memory = np.sum(to_signal(self.gain**2, n_fft, n_fft) ** 2) / np.sum(pulse**2) ** 2
        variance = 4 * noise**2 * np.sum(against**2) + 2 * memory * np.sum(((index - centre) * of_noise) ** 2)
        return centre, float(variance / energy**2)


def leading_channel(recording: Recording, frequency: float, cycles: float) -> int:
    """Return 1 when the base clearly leads, -1 (`SWAPPED`) when the top does, 0 when one burst cannot tell.

    The top plate answers to the base: its energy comes later, by the group delay of the transmissibility, at
    all frequencies below, at and above the resonance, although the phase nears 180 degrees and the
    cross-correlation may then show a negative delay. Base and top are called exchanged when the energy of the
    top comes earlier by more than one sample (chains may differ by that before their calibration) and by more
    than five standard deviations of the noise.

    Notes
    -----
    Limits. Where the transmissibility is near 1 (stiff specimen, low frequency), or the specimen
    stiff and heavily damped far above its resonance, the delay is below a sample and nothing is said. A zero
    of the transmissibility (a parallel path, crosstalk, lateral motion) can turn the group delay negative
    without harm; hence tops more than 20 dB below the base never count as leading. A shaker that rings for
    long after its burst blurs the difference.
    """
    delay, deviation = energy_delay(recording, frequency, cycles)
    limit = max(_CHAIN_DELAY, _SIGNIFICANT * deviation)
    if delay > limit:
        return -SWAPPED
    lobe = _Lobe.of(recording, frequency, cycles)
    base, top = (np.sum(lobe.filtered(signal) ** 2) for signal in recording.mean())
    return SWAPPED if delay < -limit and top > _DEEP**2 * base else 0
