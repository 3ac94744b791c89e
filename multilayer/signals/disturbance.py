"""What a recorder adds to a burst and can be taken off again: an offset, a slow drift, and hum below the burst."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from multilayer.arrays import RealArray
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import frequencies, to_spectrum

MAINS = (50.0, 60.0)  # Hz
_LEAST = {"offset": 2e-3, "drift": 2e-3, "hum": 4e-3}  # of a channel's crest: less changes a modulus by less than 0.3 %
_APART = 3.0  # the burst's main lobe begins at this multiple of the mains' frequency: it does not pass for hum
_MOST_OF_TOP = 0.05  # of its crest may be drift where the base has none: what rings below ten hertz passes for more
_PERIODS = 2.0  # of the mains
_LASTS = 0.3  # most that the offset of a third of the record departs from that of the whole
_STRAIGHT = 0.2  # most that the thirds of a record are apart from its drift, over half of its rise
_FEWEST = 16  # samples through which a line is laid
_LEFT = 0.3  # most that hum leaves of the end of a record, over itself
_CLEAR = 6.0  # standard deviations of what the rest of the record leaves
_OF_MEDIAN = 1.2533 * 1.4826  # standard deviation of a median, over the median deviation and the root of the number
_OF_SLOPE = 5**0.5 * 1.4826  # standard deviation of half the rise of such a line, over the same


@dataclass(frozen=True)
class Disturbance:
    """One thing that was taken off a channel.

    Attributes
    ----------
    kind : str
        "offset", "drift" or "hum of 50 Hz".
    channel : {'base', 'top'}
    size : float
        Largest of the repeats, m/s2.
    share : float
        Of the channel's crest.
    """

    kind: str
    channel: str
    size: float
    share: float


def without_disturbances(
    recording: Recording, frequency: float, cycles: float
) -> tuple[Recording, tuple[Disturbance, ...]]:
    """Return a recording without offset, drift and hum, and what was taken off; unchanged where none is seen.

    The offset is the median of a channel, which a burst and its ring-down are symmetric about; it must be there in
    the second and in the last third of the record alike, as the rest of a slow ring-down is not. Drift is a straight
    line over the whole record, from which no third may depart, either. Hum is a sine of the mains' frequency by least
    squares, repeat by repeat: under a Hann window where the burst lies three times as high or more, and where it stands
    out of what lies beside its frequency; nearer to the burst over the end of the record, where it must be nearly all
    there is. The base rests there; a top plate may ring at the mains' frequency by itself, so its hum is taken off only
    where the base has some, too.

    Parameters
    ----------
    recording : Recording
    frequency : float
        Of the burst, Hz.
    cycles : float
        Of the burst, under its Hann window: its main lobe reaches ``2 / cycles`` to either side.
    """
    if not (np.all(np.isfinite(recording.base)) and np.all(np.isfinite(recording.top))):
        return recording, ()
    seen: list[Disturbance] = []
    lowest = frequency * (1 - 2 / cycles)

    def cleaned(name: str, signal: RealArray) -> RealArray:
        crest = float(np.max(np.abs(signal - np.median(signal, axis=-1, keepdims=True))))
        possible = MAINS if name == "base" else tuple(f for f in MAINS if f"hum of {f:g} Hz" in {s.kind for s in seen})
        hum, mains = _hum(signal, recording.sampling_rate, lowest, crest, possible)
        drifts = name == "base" or "drift" in {s.kind for s in seen}
        drift = _drift(signal - hum, np.inf if drifts else _MOST_OF_TOP * crest)
        parts = (("offset", _offset(signal - hum - drift)), ("drift", drift), (f"hum of {mains:g} Hz", hum))
        for kind, part in parts:
            size = float(np.max(np.abs(part)))
            if crest > 0 and size > _LEAST[kind.split()[0]] * crest:
                seen.append(Disturbance(kind, name, size, size / crest))
                signal = signal - part
        return signal

    base, top = cleaned("base", recording.base), cleaned("top", recording.top)
    return (Recording(base, top, recording.sampling_rate), tuple(seen)) if seen else (recording, ())


def _offset(signal: RealArray) -> RealArray:
    """Return the offset of every repeat, shape (repeats, 1); zeros where there is none that lasts."""
    offset = np.median(signal, axis=-1, keepdims=True)
    chance = _OF_MEDIAN * float(np.median(np.abs(signal - offset))) / signal.shape[-1] ** 0.5
    later = (np.median(part, axis=-1, keepdims=True) for part in np.array_split(signal, 3, axis=-1)[1:])
    lasts = all(np.all(np.abs(part - offset) < _LASTS * np.abs(offset)) for part in later)
    return offset if lasts and float(np.max(np.abs(offset))) > _CLEAR * chance else np.zeros_like(offset)


def _drift(signal: RealArray, most: float) -> RealArray:
    """Return the straight line through every repeat, its mean 0; zeros where there is none that lasts, or too large.

    By least squares under a parabola, which makes little of where a burst or its ring-down is cut.
    """
    n = signal.shape[-1]
    if n < _FEWEST:
        return np.zeros_like(signal)
    time = np.linspace(-1, 1, n)
    weight = (1 - time**2) / np.sum(1 - time**2)
    centred = signal - np.sum(weight * signal, axis=-1, keepdims=True)
    slope = np.sum(weight * time * centred, axis=-1, keepdims=True) / np.sum(weight * time**2)
    line, rest = slope * time, centred - slope * time
    chance = _OF_SLOPE * float(np.median(np.abs(rest))) / n**0.5
    thirds = np.array_split(np.arange(n), 3)
    left = np.stack([rest[..., third] @ np.hanning(third.size) / (third.size / 2) for third in thirds])
    size = np.abs(slope[..., 0])
    lasts = np.all(np.ptp(left, axis=0) < _STRAIGHT * size) and _CLEAR * chance < float(size.max()) < most
    return line if lasts else np.zeros_like(line)


def _hum(
    signal: RealArray, sampling_rate: float, lowest: float, crest: float, possible: tuple[float, ...]
) -> tuple[RealArray, float]:
    """Return the hum of every repeat at one of the possible frequencies, and that; zeros where none can be told."""
    n = signal.shape[-1]
    time = np.arange(n) / sampling_rate
    largest, best, at = 0.0, np.zeros_like(signal), MAINS[0]
    for mains in possible:
        is_apart = lowest >= _APART * mains
        least = int(_PERIODS * sampling_rate / mains)  # a Hann window's line is two periods wide
        if n < (1 if is_apart else 2) * least:
            continue
        window = np.hanning(n) if is_apart else (np.arange(n) >= n - least).astype(float)
        turn = 2 * np.pi * mains * time
        columns = np.stack([np.ones(n), time, np.cos(turn), np.sin(turn)], axis=-1)
        amplitudes = np.linalg.lstsq(columns * window[:, None], (signal * window).T, rcond=None)[0]
        hum = (columns[:, 2:] @ amplitudes[2:]).T
        rest = signal - (columns @ amplitudes).T
        if not is_apart:
            rest, kept = rest[:, -least:], hum[:, -least:]
            if np.mean(rest**2) > _LEFT**2 * np.mean(kept**2):
                continue
        chance = _beside(rest * window, sampling_rate, mains) / np.sum(window) if is_apart else 0.0
        # where too little lies beside it, as noise the rest would leave this much at one frequency
        chance = chance or float(np.sqrt(2 * np.mean(rest**2) / rest.shape[-1]))
        size = float(np.max(np.abs(hum)))
        if size > max(largest, _CLEAR * chance, _LEAST["hum"] * crest):
            largest, best, at = size, hum, mains
    return best, at


def _beside(windowed: RealArray, sampling_rate: float, mains: float) -> float:
    """Return twice the rms of the spectrum beside the mains' frequency, up to an octave away; 0 where that has no bins.

    The burst is no noise there: it lies higher.
    """
    n = windowed.shape[-1]
    away = frequencies(n, sampling_rate) / mains
    near = (away > 0.5) & (away < 2) & (np.abs(away - 1) * mains > 2 * sampling_rate / n)
    if not np.any(near):
        return 0.0
    return 2 * float(np.sqrt(np.mean(np.abs(to_spectrum(windowed, n)[..., near]) ** 2)))


def in_words(seen: Mapping[str, tuple[Disturbance, ...]]) -> list[str]:
    """Return one sentence for each kind of disturbance.

    Parameters
    ----------
    seen : mapping
        What was taken off each recording, by a name for it.
    """
    kinds = sorted({one.kind for found in seen.values() for one in found})
    sentences = []
    for kind in kinds:
        named = [(one, name) for name, found in seen.items() for one in found if one.kind == kind]
        worst, where = max(named, key=lambda pair: pair[0].share)
        number = len({name for _, name in named})
        sentences.append(
            f"{kind} in {number} of {len(seen)} recordings, taken off: up to {worst.size:.2g} m/s2, "
            f"{100 * worst.share:.2g} % of the {worst.channel} channel's crest ({where}); {_REMEDY[kind.split()[0]]}"
        )
    return sentences


_REMEDY = {
    "offset": "couple the channels AC, or let the accelerometers warm up",
    "drift": "couple the channels AC, or let the accelerometers warm up",
    "hum": "look for a ground loop",
}
