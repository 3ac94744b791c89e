"""Channels that limit softly: crests flattened by a sensor or an amplifier near its range, without equal samples."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from multilayer.arrays import RealArray
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import frequencies, noise_level, padded_length, to_signal, to_spectrum

_LOBE = 2.0  # over the duration: half the width of a Hann window's main lobe
_HIGHEST = 0.9  # of half the sampling rate: above it a filter against aliasing takes off the harmonic
_LEAST = 0.01  # of the amplitude
_CLEAR = 5.0  # standard deviations of the noise
_EXPLAINED = 0.7  # of the power about the third harmonic that is not noise
_PHASE = 15.0  # degrees
_FEWEST = 2  # recordings
_MOST_OF_THEM = 0.75  # of those with a third harmonic


class Flattening(NamedTuple):
    """By how much a cube takes off a channel's crests.

    Attributes
    ----------
    share : float
        Of the amplitude of the fundamental.
    limits : bool
        Whether the harmonic is in phase with that of a soft limit; otherwise it is that of a source or a sample.
    """

    share: float
    limits: bool


def flattening(signal: RealArray, noise: float, sampling_rate: float, frequency: float, cycles: float) -> Flattening:
    """Return by how much a channel flattens the crests of a burst; 0 where its third harmonic is not that of a cube.

    A sensor that limits reads ``y = x - c x^3`` at every instant, c > 0. From a burst of amplitude A it takes
    ``3/4 c A^2`` of the fundamental and adds a third of that as a third harmonic, whose window is the burst's cubed
    and whose phase is fixed. c is the least-squares estimate in the main lobe about the third harmonic, x the signal
    in that about the fundamental.

    Parameters
    ----------
    signal : array, shape (n_samples,)
        The mean over the repeats.
    noise : float
        Its standard deviation.
    sampling_rate : float
        Hz.
    frequency : float
        Of the burst, Hz.
    cycles : float
        Of the burst, under its Hann window.
    """
    nothing = Flattening(0.0, False)
    width = _LOBE * frequency / cycles
    if 3 * frequency + width > _HIGHEST * sampling_rate / 2 or width > frequency:
        return nothing
    n_fft = padded_length(signal.size, 1)  # a burst that wraps round keeps its harmonics
    f = frequencies(n_fft, sampling_rate)
    spectrum = to_spectrum(signal - np.median(signal), n_fft)
    fundamental = to_signal(np.where(np.abs(f - frequency) < width, spectrum, 0), n_fft, n_fft)
    third = np.abs(f - 3 * frequency) < width
    cube, shown = to_spectrum(fundamental**3, n_fft)[third], spectrum[third]
    power = float(np.sum(np.abs(cube) ** 2))
    if power == 0:
        return nothing
    of_noise = signal.size * noise**2
    c = complex(-np.vdot(cube, shown)) / power
    taken = 0.75 * c * float(np.max(np.abs(fundamental))) ** 2
    left = float(np.sum(np.abs(shown) ** 2)) - of_noise * third.sum()
    if abs(c) * power**0.5 < _CLEAR * of_noise**0.5 or abs(c) ** 2 * power < _EXPLAINED * left or abs(taken) < _LEAST:
        return nothing
    return Flattening(abs(taken), bool(abs(np.rad2deg(np.angle(c))) < _PHASE))


def flattened(recording: Recording, frequency: float, cycles: float) -> dict[str, Flattening]:
    """Return `flattening` of base and top."""
    noise = noise_level(recording, of_mean=True)._asdict()
    channels = zip(("base", "top"), recording.mean(), strict=True)
    return {name: flattening(x, noise[name], recording.sampling_rate, frequency, cycles) for name, x in channels}


def limits_in_words(recordings: Mapping[str, tuple[float, Recording]], cycles: float) -> list[str]:
    """Return a sentence about each channel that limits softly.

    A harmonic of the shaker, or of the sample, may be in phase with that of a limit by chance: told is what shows in
    two recordings at least, and in three of four of those whose channel has such a harmonic.

    Parameters
    ----------
    recordings : mapping of (float, Recording)
        By a name for each, the burst's frequency, Hz, and the recording.
    cycles : float
        Of the bursts.
    """
    every = {name: flattened(recording, frequency, cycles) for name, (frequency, recording) in recordings.items()}
    sentences = []
    for channel in ("base", "top"):
        harmonic = {name: of_both[channel] for name, of_both in every.items() if of_both[channel].share}
        limited = {name: flat.share for name, flat in harmonic.items() if flat.limits}
        if len(limited) < max(_FEWEST, _MOST_OF_THEM * len(harmonic)):
            continue
        worst = max(limited, key=lambda name: limited[name])
        most = float(f"{100 * limited[worst]:.1g}")
        sentences.append(
            f"the {channel} channel limits softly in {len(limited)} of {len(every)} recordings: the third harmonic is "
            f"that of flattened crests, by up to some {most:g} % of the amplitude ({worst}); lower "
            "the level or widen the input range, and measure again"
        )
    return sentences
