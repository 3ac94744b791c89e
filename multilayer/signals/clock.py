"""Whether the clock of a recorder runs as stated, by the frequencies of the bursts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from multilayer.arrays import BoolArray, RealArray
from multilayer.signals.envelope import envelope
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import noise_level, padded_length, to_signal, to_spectrum

_ROUNDS = 8
_DONE = 1e-7  # relative change of the frequency
_FARTHEST = 0.05  # beyond it the burst is another, which `quality` tells
_FEWEST_SAMPLES = 40
_LEFT = 0.005  # of a burst's amplitude, noise apart: another window, or a shaker that resonates within the main lobe
_FEWEST_BURSTS = 3
_AGREEMENT = 1e-3  # of the bursts of a configuration: a resonance of the shaker nearby moves single ones
_SHARE = 0.8  # of the bursts that must agree
_LEAST = 2e-3
_CLEAR = 5.0  # standard errors
_CHANCE = 4.0  # standard deviations of the power of noise


class Ratio(NamedTuple):
    """A measured frequency over the stated one, and its standard deviation."""

    value: float
    deviation: float


def frequency_ratio(recording: Recording, frequency: float, cycles: float) -> Ratio | None:
    """Return the frequency of a burst's carrier at the base over the stated one; None where it cannot be told.

    A shaker's response H changes the centre of a burst's spectrum by 0.7 % for every 6 dB per octave (ten cycles). To
    second order in frequency about the burst, H turns the window w into a complex combination of w, w' and w''; another
    carrier adds ``2 pi i (f - f0) t w``. All are fitted together by least squares, again from the new frequency until
    it stays.

    Parameters
    ----------
    recording : Recording
    frequency : float
        Of the burst, Hz.
    cycles : float
        Of the burst, under its Hann window.
    """
    signal, _ = recording.mean()
    signal = signal - np.median(signal)
    time = np.arange(signal.size) / recording.sampling_rate
    noise = noise_level(recording, of_mean=True).base
    centre = _centre(signal, cycles / frequency, recording.sampling_rate)
    carrier, deviation = frequency, np.inf
    for _ in range(_ROUNDS):
        duration = cycles / carrier
        inside = np.abs(time - centre) < duration / 2
        n = int(inside.sum())
        if n < _FEWEST_SAMPLES:
            return None
        columns, x = _columns(time[inside] - centre, duration, carrier), signal[inside]
        inverse = np.linalg.pinv(columns)
        fitted = inverse @ x
        left = float(np.mean((x - columns @ fitted) ** 2))
        window, turning = (complex(*fitted[i : i + 2]) for i in (0, 6))
        if window == 0:
            return None
        step = (turning / window).imag / (2 * np.pi * duration)
        spread = float(np.linalg.norm(inverse[-1])) * max(left**0.5, noise)
        deviation = spread / abs(window) / (2 * np.pi * duration)
        carrier += step
        if abs(carrier / frequency - 1) > _FARTHEST:
            return None
        if abs(step) < _DONE * frequency:
            break
    if left - noise**2 * (1 + _CHANCE * (2 / n) ** 0.5) > _LEFT**2 * float(np.mean(x**2)):
        return None
    return Ratio(carrier / frequency, deviation / frequency)


def _centre(signal: RealArray, duration: float, sampling_rate: float) -> float:
    """Return the middle of a burst, s: where its envelope resembles the window most."""
    n_fft = padded_length(signal.size)
    window = np.hanning(max(int(duration * sampling_rate), 3))[: signal.size]
    likeness = to_signal(to_spectrum(envelope(signal), n_fft) * to_spectrum(window, n_fft), n_fft, n_fft)
    return float(np.argmax(likeness) - (window.size - 1) / 2) / sampling_rate


def _columns(time: RealArray, duration: float, carrier: float) -> RealArray:
    """Return w, w', w'' (but for factors) and t w on a carrier, real and imaginary part each, shape (n, 8)."""
    turn = 2 * np.pi * time / duration
    window = (1 + np.cos(turn)) / 2
    parts = np.stack([window, np.sin(turn), np.cos(turn), window * time / duration])
    phase = 2 * np.pi * carrier * time
    return np.stack([parts * np.cos(phase), -parts * np.sin(phase)], axis=1).reshape(8, -1).T


def clock_ratio(recordings: Mapping[float, Recording], cycles: float) -> Ratio | None:
    """Return the common ratio of measured to stated frequencies where a clock is off; None where none is seen to be.

    Off by 0.2 % and five standard errors, and alike within 0.1 % in four of five bursts, three at least.

    Parameters
    ----------
    recordings : mapping of float to Recording
        By the bursts' stated frequencies, Hz.
    cycles : float
        Of the bursts.
    """
    every = [frequency_ratio(recording, frequency, cycles) for frequency, recording in recordings.items()]
    known = [ratio for ratio in every if ratio is not None]
    if 2 * len(known) < len(every) or len(known) < _FEWEST_BURSTS:
        return None
    values, deviations = (np.array(column) for column in zip(*known, strict=True))
    agree: BoolArray = np.abs(values - np.median(values)) < _AGREEMENT
    if agree.sum() < max(_SHARE * len(known), _FEWEST_BURSTS):
        return None
    mean, number = float(values[agree].mean()), int(agree.sum())
    scatter = max(float(values[agree].std(ddof=1)), float(np.sqrt(np.mean(deviations[agree] ** 2))))
    error = scatter / number**0.5
    return Ratio(mean, error) if abs(mean - 1) > max(_LEAST, _CLEAR * error) else None


def clocks_in_words(recordings: Mapping[str, Mapping[float, Recording]], cycles: float) -> list[str]:
    """Return a sentence for all configurations in which a clock is off by the same.

    Parameters
    ----------
    recordings : mapping
        By name of the configuration and the bursts' stated frequencies, Hz.
    cycles : float
        Of the bursts.
    """
    ratios = {name: clock_ratio(of_this, cycles) for name, of_this in recordings.items()}
    off = {name: ratio for name, ratio in ratios.items() if ratio is not None}
    sentences = []
    while off:
        first = next(iter(off.values())).value
        alike = [name for name, ratio in off.items() if abs(ratio.value - first) < _AGREEMENT]
        which = "all bursts" if len(alike) == len(recordings) else f"the bursts of {', '.join(alike)}"
        stated = next(iter(recordings[alike[0]].values())).sampling_rate
        sentences.append(f"{which} {_sentence([off.pop(name) for name in alike], stated)}")
    return sentences


def _sentence(ratios: list[Ratio], stated: float) -> str:
    value = float(np.mean([ratio.value for ratio in ratios]))
    error = float(np.linalg.norm([ratio.deviation for ratio in ratios])) / len(ratios)
    return (
        f"appear at {value:.4f} times their stated frequencies (standard error {max(100 * error, 0.001):.1g} %): a "
        f"clock is off by {100 * abs(value - 1):.2g} %, and a modulus by twice as much; is a sampling_rate of "
        f"{stated:g} Hz right? {float(f'{stated / value:.5g}'):g} Hz would fit"
    )
