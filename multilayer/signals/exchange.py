"""Which channel leads: base and top told apart by the order in which energy arrives."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from multilayer.arrays import RealArray
from multilayer.signals.spectra import noise_level

if TYPE_CHECKING:
    from multilayer.measurements.recording import Recording

SWAPPED = -1
_SIGNIFICANT = 5.0  # standard deviations of the noise
_CHAIN_DELAY = 1.0  # samples by which two chains may differ before they are calibrated
_DEEP = 0.1  # top 20 dB below base


def energy_delay(recording: Recording) -> tuple[float, float]:
    """Return by how much the top's energy comes later than the base's, and the standard deviation of that.

    The instant of a channel is the centre of its energy, ``sum t x(t)^2 / sum x(t)^2``, with the energy of
    the noise taken out. In terms of spectra it is the group delay weighted with the channel's own energy
    spectrum.

    Parameters
    ----------
    recording : Recording

    Returns
    -------
    delay, deviation : float
        In samples. The deviation is what the noise of the repeats causes; infinite when a channel is mere
        noise.
    """
    noise = noise_level(recording, of_mean=True)
    base, base_variance = _centre_of_energy(recording.mean()[0], noise.base)
    top, top_variance = _centre_of_energy(recording.mean()[1], noise.top)
    return top - base, float(np.sqrt(base_variance + top_variance))


def _centre_of_energy(signal: RealArray, noise: float) -> tuple[float, float]:
    centred = signal - signal.mean()
    index = np.arange(signal.size)
    energy = np.sum(centred**2) - signal.size * noise**2
    if energy <= 0:
        return 0.0, np.inf
    centre = (np.sum(index * centred**2) - noise**2 * np.sum(index)) / energy
    # noise against signal to first order, plus the scatter of the noise's own energy
    lever = (index - centre) ** 2
    noise_lever = noise**2 * np.sum(lever)
    signal_lever = max(np.sum(lever * centred**2) - noise_lever, 0.0)
    variance = noise**2 * (4.0 * signal_lever + 2.0 * noise_lever) / energy**2
    return float(centre), float(variance)


def leading_channel(recording: Recording) -> int:
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
    delay, deviation = energy_delay(recording)
    limit = max(_CHAIN_DELAY, _SIGNIFICANT * deviation)
    if delay > limit:
        return -SWAPPED
    base, top = (np.sum((signal - signal.mean()) ** 2) for signal in recording.mean())
    return SWAPPED if delay < -limit and top > _DEEP**2 * base else 0
