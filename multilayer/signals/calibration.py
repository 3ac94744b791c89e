"""Calibration of the two accelerometer chains against each other, from bursts with both at one spot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from multilayer.arrays import ArrayLike, BoolArray, ComplexArray, RealArray
from multilayer.errors import InputError
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import frequencies, noise_level, padded_length, to_signal, to_spectrum
from multilayer.signals.time_of_flight import time_of_flight

# the main lobe of a Hann window reaches 2 / duration to either side of the tone
_LOBE = 2.0
_COLUMNS = ("frequencies", "amplitude_ratio", "time_shift", "std")


@dataclass(frozen=True, eq=False)
class Calibration:
    """How the top channel differs from the base channel when both feel the same motion.

    Bonfiglio & Pompoli 2015, Section 2: with both accelerometers at one spot the transmissibility must be 1
    with phase 0; what it is instead is kept per burst frequency and taken out of later measurements.

    Parameters
    ----------
    frequencies : array, shape (n,)
        Burst frequencies, Hz, in any order but all different; kept in rising order.
    amplitude_ratio : array, shape (n,)
        Top over base.
    time_shift : array, shape (n,)
        Delay of top behind base, s.
    std : array, shape (n,), optional
        Standard deviation of the ratio, relative, and of its phase, rad: noise gives both alike. Zero when left out.

    Raises
    ------
    InputError
        When the arrays are empty or unlike in shape, a frequency comes twice, a value is not finite, or a
        ratio is not positive.
    """

    frequencies: RealArray
    amplitude_ratio: RealArray
    time_shift: RealArray
    std: RealArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        columns = [np.atleast_1d(np.asarray(getattr(self, name), dtype=float)) for name in _COLUMNS]
        if not columns[3].size:
            columns[3] = np.zeros_like(columns[0])
        _check_columns(*columns)
        order = np.argsort(columns[0])
        for name, values in zip(_COLUMNS, columns, strict=True):
            object.__setattr__(self, name, values[order])

    def to_dict(self) -> dict[str, list[float]]:
        """Return plain lists, fit for JSON and YAML."""
        return {name: getattr(self, name).tolist() for name in _COLUMNS}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Calibration:
        """Return the calibration that `to_dict` wrote.

        Raises
        ------
        InputError
            When a field is missing or holds no numbers.
        """
        needed = _COLUMNS[:3]
        missing = [name for name in needed if name not in data]
        if missing:
            raise InputError(f"the calibration lacks {', '.join(missing)}; it needs {', '.join(needed)}")
        try:
            return cls(*(np.asarray(data[name], dtype=float) for name in _COLUMNS if name in data))
        except (TypeError, ValueError) as error:
            raise InputError(f"the calibration must hold lists of numbers: {error}") from None

    def at(self, frequency: float) -> tuple[float, float]:
        """Return amplitude ratio and time shift (s) at a frequency, interpolated linearly.

        Raises
        ------
        InputError
            Outside of the calibrated frequencies: nothing is known there.
        """
        low, high = self.frequencies[0], self.frequencies[-1]
        # half a millihertz: 0.1 kHz read from text must still be 100 Hz
        if not low - 5e-4 <= frequency <= high + 5e-4:
            raise InputError(
                f"{frequency:g} Hz lies outside of the calibrated range {low:g} Hz to {high:g} Hz; "
                "calibrate at this frequency too"
            )
        ratio, shift = (np.interp(frequency, self.frequencies, y) for y in (self.amplitude_ratio, self.time_shift))
        return float(ratio), float(shift)

    def std_at(self, frequency: float) -> float:
        """Return the standard deviation of ln(ratio), each part, at a frequency within the calibrated ones."""
        return float(np.interp(frequency, self.frequencies, self.std))

    def correct(self, top: ArrayLike, sampling_rate: float, frequency: float) -> RealArray:
        """Return a top signal as the base channel would have shown it.

        Ratio and shift at the burst's frequency apply to the whole signal, a ring-down at another frequency
        included: the chains are supposed to differ little and smoothly.

        Parameters
        ----------
        top : array, shape (..., n_samples)
        sampling_rate : float
            Hz.
        frequency : float
            Of the burst, Hz.

        Returns
        -------
        array, shape (..., n_samples)

        Raises
        ------
        InputError
            Outside of the calibrated frequencies.
        """
        ratio, shift = self.at(frequency)
        samples = np.asarray(top, dtype=float)
        n_fft = padded_length(samples.shape[-1])
        omega = 2.0 * np.pi * frequencies(n_fft, sampling_rate)
        spectrum = to_spectrum(samples, n_fft) * np.exp(1j * omega * shift) / ratio
        return to_signal(spectrum, n_fft, samples.shape[-1])


def _check_columns(frequency: RealArray, ratio: RealArray, shift: RealArray, std: RealArray) -> None:
    if not (frequency.shape == ratio.shape == shift.shape == std.shape) or frequency.ndim != 1 or frequency.size == 0:
        raise InputError(
            "a calibration needs as many amplitude ratios and time shifts as frequencies, and at least one; "
            f"the shapes are {frequency.shape}, {ratio.shape}, {shift.shape}"
        )
    if not all(np.isfinite(values).all() for values in (frequency, ratio, shift)):
        raise InputError("the calibration holds values that are not finite")
    if not np.all(np.isfinite(std) & (std >= 0)):
        raise InputError("the calibration's standard deviations must be finite and not below 0")
    if np.any(ratio <= 0) or np.any(frequency <= 0):
        raise InputError("the calibration's frequencies and amplitude ratios must be above 0")
    if np.unique(frequency).size != frequency.size:
        raise InputError("a frequency is calibrated twice; keep one of the two")


def calibrate(recordings: Mapping[float, Recording], *, cycles: float = 10.0) -> Calibration:
    """Return the calibration from bursts recorded with both accelerometers at one spot.

    Per burst, top is fitted to base by least squares over the burst's band, with a ratio and a delay as
    unknowns. The mean over the repeats is fitted, and the noise that is left in the mean base signal, known
    from the scatter of the repeats, is taken out of the sum of squares it would otherwise swell.

    Parameters
    ----------
    recordings : mapping of float to Recording
        One recording per burst frequency, Hz.
    cycles : float
        Cycles of the bursts under their Hann window; their spectra reach ``2 / cycles`` to either side.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        When there are no recordings, or one of them shows no common motion.

    Notes
    -----
    The standard deviation is what the noise of both channels makes of such a fit, ``sigma^2 n_fft / (2 sum |B|^2)`` of
    either part, or the scatter of the repeats where that is more.

    A delay is known only modulo the burst's period (see `time_of_flight`). One beyond a quarter
    of it, 0.17 ms at 1500 Hz, is refused: it is more likely a channel of the wrong sign than a slow one.
    """
    if not recordings:
        raise InputError("a calibration needs at least one burst")
    burst_frequencies = sorted(recordings)
    fits = [_fit(frequency, recordings[frequency], cycles) for frequency in burst_frequencies]
    ratios, shifts, stds = np.transpose(fits)
    return Calibration(np.asarray(burst_frequencies, dtype=float), ratios, shifts, stds)


def _fit(frequency: float, recording: Recording, cycles: float) -> tuple[float, float, float]:
    """Return amplitude ratio, time shift and relative standard deviation of one burst."""
    base, top = recording.mean()
    n_fft = padded_length(recording.n_samples)
    base_spectrum, top_spectrum = to_spectrum(base, n_fft), to_spectrum(top, n_fft)
    f = frequencies(n_fft, recording.sampling_rate)
    # a band that is known beforehand: bins picked by their height would be picked for their noise
    inside = np.abs(f - frequency) < _LOBE * frequency / cycles
    clean_base, clean_top = (_only(spectrum, inside, n_fft) for spectrum in (base_spectrum, top_spectrum))
    shift = float(time_of_flight(clean_base, clean_top, recording.sampling_rate))
    common = np.sum((np.conj(base_spectrum) * top_spectrum * np.exp(2j * np.pi * f * shift))[inside].real)
    noise = noise_level(recording, of_mean=True)
    noise_power = np.sum(inside) * recording.n_samples * noise.base**2
    power = np.sum(np.abs(base_spectrum[inside]) ** 2) - noise_power
    if not (common > 0 and power > 0 and abs(shift) < 0.25 / frequency):
        raise InputError(
            f"the calibration burst at {frequency:g} Hz shows no motion common to both channels "
            f"(delay {shift:.3g} s); check that both accelerometers are connected, of the same sign, "
            "and at one spot"
        )
    ratio = float(common / power)
    variance = 0.5 * n_fft * (noise.base**2 + (noise.top / ratio) ** 2) / power
    return ratio, shift, float(np.sqrt(max(variance, _scatter(recording, inside, n_fft))))


def _scatter(recording: Recording, inside: BoolArray, n_fft: int) -> float:
    """Return the relative variance of either part of the mean ratio, from the repeats; 0 where there is one only."""
    if recording.n_repeats < 2:
        return 0.0
    base, top = (to_spectrum(channel, n_fft)[:, inside] for channel in (recording.base, recording.top))
    ratios = np.sum(np.conj(base) * top, axis=-1) / np.sum(np.abs(base) ** 2, axis=-1)
    return float(0.5 * np.var(ratios / ratios.mean(), ddof=1) / recording.n_repeats)


def _only(spectrum: ComplexArray, inside: BoolArray, n_fft: int) -> RealArray:
    """Return the signal of some bins only, over the whole transform length."""
    return to_signal(np.where(inside, spectrum, 0.0), n_fft, n_fft)
