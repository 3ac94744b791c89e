"""What the measuring chains add to a signal: white and 1/f noise, mains hum, the steps of a converter."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from numpy.random import Generator
from pydantic import Field
from scipy import fft

from multilayer.arrays import RealArray
from multilayer.models import NO_BOOL, Model
from multilayer.units import Acceleration, Frequency, Ratio

HEADROOM = 1.25  # range of a converter that sets itself, over the crest


class Hum(Model):
    """Mains hum: `frequency`, Hz; `level`, m/s2 rms of the fundamental; harmonic n of `harmonics` has 1/n of it."""

    frequency: Frequency = 50.0
    level: Acceleration
    harmonics: Annotated[int, Field(ge=1, le=50), NO_BOOL] = 3


class NoiseSettings(Model):
    """Noise of the two channels.

    Attributes
    ----------
    white : float
        Standard deviation of the top channel's white noise over that channel's rms within the burst.
    base : float, optional
        The same of the base channel; `white` when left out.
    pink : float
        Of 1/f noise of both channels, likewise; between one over the record's length and half the sampling rate.
    hum : Hum, optional
        In both channels, each harmonic with a random phase.
    bits : int, optional
        Of the converters; no steps when ``null``.
    full_scale : float, optional
        Largest acceleration of the converters, m/s2; when left out each channel's range is 1.25 times its crest.
    """

    white: Ratio = 0.004
    base: Ratio | None = None
    pink: Ratio = 0.0
    hum: Hum | None = None
    bits: Annotated[int, Field(ge=4, le=32), NO_BOOL] | None = 24
    full_scale: Acceleration | None = None


def add_noise(
    signal: RealArray, level: float, settings: NoiseSettings, white: float, sampling_rate: float, rng: Generator
) -> RealArray:
    """Return a channel with its noise, before the converter.

    Parameters
    ----------
    signal : array, shape (repeats, n_samples)
        m/s2.
    level : float
        Reference of the relative deviations `white` and `settings.pink`, m/s2.
    settings : NoiseSettings
    white : float
        Relative standard deviation of the channel's white noise.
    sampling_rate : float
        Hz.
    rng : Generator
    """
    # drawn whatever the levels: another level gives the same noise, louder or softer
    noise = white * level * rng.standard_normal(signal.shape)
    noise += settings.pink * level * pink_noise(signal.shape, rng)
    if settings.hum is not None:
        noise += hum(settings.hum, signal.shape, sampling_rate, rng)
    return signal + noise


def pink_noise(shape: tuple[int, ...], rng: Generator) -> RealArray:
    """Return noise of unit expected variance whose power falls as 1/f along the last axis."""
    n_samples = shape[-1]
    bins = np.arange(n_samples // 2 + 1, dtype=float)
    weight = np.zeros_like(bins)
    weight[1:] = bins[1:] ** -0.5
    both_sides = 2 * np.sum(weight**2) - (weight[-1] ** 2 if n_samples % 2 == 0 else 0.0)
    spectrum = fft.rfft(rng.standard_normal(shape), axis=-1) * weight * np.sqrt(n_samples / max(both_sides, 1e-300))
    return np.asarray(fft.irfft(spectrum, n_samples, axis=-1), dtype=float)


def hum(settings: Hum, shape: tuple[int, ...], sampling_rate: float, rng: Generator) -> RealArray:
    """Return mains hum, m/s2, with a random phase per record and harmonic, without those beyond half the rate."""
    orders = np.arange(1, settings.harmonics + 1)
    phases = rng.uniform(0, 2 * np.pi, (*shape[:-1], orders.size))
    orders_kept = orders[orders * settings.frequency < 0.5 * sampling_rate]
    angle = 2 * np.pi * settings.frequency * np.arange(shape[-1]) / sampling_rate
    total = np.zeros(shape)
    for order in orders_kept:
        crest = np.sqrt(2) * settings.level / order
        total += crest * np.sin(order * angle + phases[..., order - 1, np.newaxis])
    return total


def quantise(signal: RealArray, bits: int, full_scale: float) -> RealArray:
    """Return a signal in steps of ``2 full_scale / 2^bits``; what lies beyond the range stops at its end.

    Parameters
    ----------
    signal : array
        m/s2.
    bits : int
        Of the converter.
    full_scale : float
        m/s2.
    """
    step = 2 * full_scale / 2**bits
    largest = 2 ** (bits - 1)
    return np.asarray(step * np.clip(np.rint(signal / step), -largest, largest - 1))


def converted(signal: RealArray, settings: NoiseSettings) -> RealArray:
    """Return a channel in the steps of its converter; unchanged where the settings have no `bits`."""
    if settings.bits is None:
        return signal
    crest = float(np.max(np.abs(signal)))
    return quantise(signal, settings.bits, settings.full_scale or HEADROOM * crest) if crest > 0 else signal
