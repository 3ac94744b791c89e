"""Whether a recording is fit to be used: its problems as sentences, each with a remedy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from multilayer.arrays import RealArray
from multilayer.signals.clipping import clipped_repeats
from multilayer.signals.envelope import rms
from multilayer.signals.exchange import SWAPPED, leading_channel
from multilayer.signals.neighbours import belongs_exchanged
from multilayer.signals.recording import Recording
from multilayer.signals.repeats import compare_repeats
from multilayer.signals.soft_limit import flattened
from multilayer.signals.spectra import band, frequencies, noise_level, padded_length, to_spectrum

CYCLES = 10.0
_BURST_BAND = 0.1  # of the spectrum's crest: where the burst is, without its side lobes
_SILENT_RATIO = 1e-5  # below the other channel by this: beyond the range of a 16-bit converter
_SILENT_SIGNAL_TO_NOISE = 4.0  # power; noise alone gives 1
_TAIL_RATIO = 0.1  # 20 dB below the crest
_CHANCE = 4.0  # standard deviations of the power of noise
_ONSET_SHARE = 0.025  # of the burst's duration, when a Hann window has reached 0.6 % of its crest
_FREQUENCY_TOLERANCE = 0.05
_RATE_TOLERANCE = 0.02  # what the slope of a shaker's response may do to the centroid of all bursts; less: `clock`
_RATE_AGREEMENT = 0.01
_RATE_SHARE = 0.8


@dataclass(frozen=True)
class Finding:
    """One problem with the recordings of a configuration.

    Attributes
    ----------
    message : str
        What is wrong, and what to do.
    about : {"burst", "configuration", "sampling_rate"}
        What the problem belongs to.
    frequency : float or None
        The burst's stated frequency, Hz, when the problem is one burst's.
    """

    message: str
    about: Literal["burst", "configuration", "sampling_rate"]
    frequency: float | None = None


@dataclass(frozen=True)
class _Look:
    """Of one recording: its problems, which channel leads (+1: base), measured over stated frequency."""

    problems: list[str]
    leads: int = 0
    frequency_ratio: float = np.nan


def check_recording(recording: Recording, frequency: float, *, cycles: float = CYCLES) -> list[str]:
    """Return what is wrong with one recording, each problem with its remedy; empty when it is fine.

    The checks: values that are not finite, a silent channel, a clipped channel (`clipped_repeats`), a record
    that is too short or cuts the burst off, a repeat in which a channel failed (`compare_repeats`), exchanged channels
    (`leading_channel`), and a burst that is not at the stated frequency.

    Parameters
    ----------
    recording : Recording
        Base and top, (repeats, samples).
    frequency : float
        Stated frequency of the burst, Hz.
    cycles : float
        Stated number of cycles under the Hann window.

    Notes
    -----
    From one burst a wrong frequency and a wrong sampling rate look alike; `check_configuration`
    tells them apart. The tolerance on the frequency is 5 %, or half of the burst's bandwidth ``frequency /
    cycles`` if that is more.
    """
    look = _look(recording, frequency, cycles)
    messages = list(look.problems)
    if look.leads == SWAPPED:
        messages.append(_swapped_message("in this burst"))
    if _is_off(look.frequency_ratio, cycles):
        messages.append(_frequency_message(frequency, look.frequency_ratio))
    return messages


def check_configuration(
    recordings: Mapping[float, Recording],
    *,
    cycles: float = CYCLES,
    together: bool = False,
    raw: Mapping[float, Recording] | None = None,
) -> list[Finding]:
    """Return what is wrong with the bursts of one configuration; empty when they are fine.

    Beyond `check_recording`, all bursts are compared. Channels are exchanged in the whole configuration
    when the top leads in more bursts than the base does; in a single burst only where its neighbours, whose bands
    overlap, do not agree with it as it is. The sampling rate is in doubt when at least two
    bursts, and four in five of them, appear at one common factor (within 1 %) beside their stated frequencies
    and that factor is off by more than 2 %; the single frequencies are then not reported as well.

    Parameters
    ----------
    recordings : mapping of float to Recording
        By stated frequency, Hz.
    cycles : float
        Stated number of cycles of the bursts.
    together : bool
        Both accelerometers at one spot (a calibration): neither channel leads, and none is looked for.
    raw : mapping, optional
        The same as the converter gave them, where the recordings are filtered, shifted or rid of hum, which leaves no
        flat tops.
    """
    before = recordings if raw is None else raw
    looks = {f: _look(recording, f, cycles, before[f]) for f, recording in recordings.items()}
    findings = [Finding(text, "burst", f) for f, look in looks.items() for text in look.problems]
    if not together:
        exchanged = _judge_exchange(recordings, looks, cycles)
        findings += exchanged
        looks = looks if exchanged else {f: _as_base_leads(recordings[f], f, look) for f, look in looks.items()}
    findings += _judge_frequencies(recordings, looks, cycles)
    return findings


def _as_base_leads(recording: Recording, frequency: float, look: _Look) -> _Look:
    """Return what was seen of a recording, the burst's frequency by its base: its channels are not exchanged."""
    if look.leads != SWAPPED:
        return look
    base, _ = recording.mean()
    return replace(look, leads=-SWAPPED, frequency_ratio=_centroid(base, recording.sampling_rate) / frequency)


def _judge_exchange(
    recordings: Mapping[float, Recording], looks: Mapping[float, _Look], cycles: float
) -> list[Finding]:
    swapped = [frequency for frequency, look in looks.items() if look.leads == SWAPPED]
    right = sum(look.leads == -SWAPPED for look in looks.values())
    if len(swapped) > right:
        where = f"in {len(swapped)} of {len(looks)} bursts"
        return [Finding(_swapped_message(where), "configuration")]
    # of what resonates on the top plate energy seems to come early; neighbours tell that from exchanged channels
    alone = [f for f in swapped if belongs_exchanged(recordings, f, cycles) is not False]
    return [Finding(_swapped_message("in this burst"), "burst", frequency) for frequency in alone]


def _judge_frequencies(
    recordings: Mapping[float, Recording], looks: Mapping[float, _Look], cycles: float
) -> list[Finding]:
    ratios = {f: look.frequency_ratio for f, look in looks.items() if np.isfinite(look.frequency_ratio)}
    off = {f: ratio for f, ratio in ratios.items() if _is_off(ratio, cycles)}
    factor = float(np.median(list(ratios.values()))) if ratios else 1.0
    agree = {f for f, ratio in ratios.items() if abs(ratio / factor - 1.0) < _RATE_AGREEMENT}
    common = len(ratios) > 1 and len(agree) >= _RATE_SHARE * len(ratios) and abs(factor - 1.0) > _RATE_TOLERANCE
    findings = []
    if common:
        stated = next(iter(recordings.values())).sampling_rate
        text = (
            f"all bursts appear at {factor:.3g} times their stated frequency: is a sampling_rate of "
            f"{stated:g} Hz right? {float(f'{stated / factor:.4g}'):g} Hz would fit"
        )
        findings.append(Finding(text, "sampling_rate"))
    return findings + [
        Finding(_frequency_message(f, ratio), "burst", f) for f, ratio in off.items() if not (common and f in agree)
    ]


def _is_off(frequency_ratio: float, cycles: float) -> bool:
    return bool(abs(frequency_ratio - 1.0) > max(_FREQUENCY_TOLERANCE, 0.5 / cycles))


def _swapped_message(where: str) -> str:
    return (
        f"base and top look exchanged: the top's energy arrives before the base's {where}; "
        "exchange the two channels, or check which accelerometer is which"
    )


def _frequency_message(frequency: float, ratio: float) -> str:
    return (
        f"the burst is stated at {frequency:g} Hz but found at {ratio * frequency:.4g} Hz; correct the "
        "frequency, or the sampling_rate, or take the right file"
    )


def _look(recording: Recording, frequency: float, cycles: float, raw: Recording | None = None) -> _Look:
    unusable = _not_finite(recording) or _silent(recording)
    if unusable:
        return _Look(unusable)
    problems = _clipped(raw or recording) + _cut_off(recording, frequency, cycles)
    broken = _broken(recording, frequency, cycles)
    if broken:  # the mean tells nothing then
        return _Look(problems + broken)
    leads = leading_channel(recording, frequency, cycles)
    if leads == SWAPPED and any(flat.limits for flat in flattened(recording, frequency, cycles).values()):
        leads = 0  # flattened crests of a ring-down move the centre of its energy
    # a response drifts towards its resonance: the burst's frequency is that of the channel that was driven
    driven, _ = recording.exchanged().mean() if leads == SWAPPED else recording.mean()
    return _Look(problems, leads, _centroid(driven, recording.sampling_rate) / frequency)


def _not_finite(recording: Recording) -> list[str]:
    counts = {name: int(np.sum(~np.isfinite(channel))) for name, channel in _channels(recording)}
    return [
        f"the {name} channel holds {count} values that are not finite; export or measure the burst again"
        for name, count in counts.items()
        if count
    ]


def _channels(recording: Recording) -> tuple[tuple[str, RealArray], tuple[str, RealArray]]:
    return ("base", recording.base), ("top", recording.top)


def _silent(recording: Recording) -> list[str]:
    """Find channels of zeros, far below the other one, or of mere noise in the band where the base moves."""
    channels = [signal - signal.mean() for signal in recording.mean()]
    levels = np.array([float(rms(signal)) for signal in channels])
    silent = levels <= _SILENT_RATIO * levels.max()
    if not silent.any():
        n_fft = padded_length(recording.n_samples)
        spectra = [to_spectrum(signal, n_fft) for signal in channels]
        inside = band(spectra[0], _BURST_BAND)
        power = np.array([np.mean(np.abs(spectrum[inside]) ** 2) for spectrum in spectra])
        noise = np.array(noise_level(recording, of_mean=True))
        silent = power < _SILENT_SIGNAL_TO_NOISE * recording.n_samples * noise**2
    return [
        f"the {name} channel is silent (no burst above its noise); check accelerometer, cable and range"
        for name, is_silent in zip(("base", "top"), silent, strict=True)
        if is_silent
    ]


def _clipped(recording: Recording) -> list[str]:
    counts = {name: int(clipped_repeats(channel).sum()) for name, channel in _channels(recording)}
    return [
        f"the {name} channel is clipped in {count} of {recording.n_repeats} repeats: its tops are flat; "
        "lower the level or widen the input range, and measure again"
        for name, count in counts.items()
        if count
    ]


def _broken(recording: Recording, frequency: float, cycles: float) -> list[str]:
    """Find repeats in which a channel failed or changed its range."""
    apart = compare_repeats(recording, frequency, cycles)
    return [apart.refusal] if apart is not None and apart.refusal else []


def _cut_off(recording: Recording, frequency: float, cycles: float) -> list[str]:
    """Find records shorter than the burst, or without its beginning or its end."""
    rate = recording.sampling_rate
    duration = cycles / frequency
    if recording.n_samples < duration * rate:
        return [
            f"the record lasts {recording.n_samples / rate:.3g} s, less than the burst of {duration:.3g} s; "
            "record longer, or correct frequency, cycles or sampling_rate"
        ]
    onset, period = max(int(_ONSET_SHARE * duration * rate), 1), max(round(rate / frequency), 2)
    # a soft specimen's top may still move from the burst before, and ring on at the end (the inverse cuts its model at
    # the same time): the base says when this burst began and ended
    base, _ = recording.mean()
    centred = base - base.mean()
    crest, noise = float(np.max(np.abs(centred))), noise_level(recording, of_mean=True).base
    problems = []
    if _amplitude(centred[:onset], noise) > _TAIL_RATIO * crest:
        problems.append("the record starts within the burst; trigger earlier, or record some time ahead of it")
    left = _amplitude(centred[-period:], noise) / crest
    if left > _TAIL_RATIO:
        problems.append(f"the base is still at {left:.0%} of its crest when the record ends; record longer")
    return problems


def _amplitude(signal: RealArray, noise: float) -> float:
    """Return the amplitude of a tone in some samples, less what their noise has on the average, and may have more."""
    power = float(np.mean(signal**2)) - noise**2 * (1 + _CHANCE * (2 / signal.size) ** 0.5)
    return float(np.sqrt(2 * max(power, 0.0)))


def _centroid(signal: RealArray, sampling_rate: float) -> float:
    """Return the centre of the power spectrum within 20 dB of its crest, Hz."""
    n_fft = padded_length(signal.shape[-1])
    spectrum = to_spectrum(signal - signal.mean(), n_fft)
    power = np.where(band(spectrum, _BURST_BAND), np.abs(spectrum) ** 2, 0.0)
    return float(np.sum(power * frequencies(n_fft, sampling_rate)) / np.sum(power))
