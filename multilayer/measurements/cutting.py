"""Bursts cut from long recordings: repeats of one frequency together, aligned to one another."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError
from multilayer.measurements.pairs import Pair
from multilayer.signals.envelope import envelope
from multilayer.signals.find_bursts import FoundBurst, find_bursts, stated_frequency
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import frequencies, padded_length, to_signal, to_spectrum
from multilayer.signals.time_of_flight import time_of_flight

BEFORE = 0.005  # s ahead of a burst
SHORTEST_AFTER, LONGEST_AFTER = 0.04, 3.0  # s behind it
_QUIET = 1e-3  # of the top's crest: a ring-down is followed down to this,
_ABOVE_NOISE = 3.0  # or to the noise
_TURN = 0.01  # rad of the tone: what a repeat may be off without being shifted between samples
_ONE_GROUP = 0.01  # relative distance of frequencies that are one
_MARGIN = 256  # samples on both sides of what is shifted, where the shift of a record's ends fades
_FEWEST = 16  # samples that a level is taken of
_LEAST = 0.02  # of a burst: quiet ahead of it and behind it, without which it counts as cut


@dataclass(frozen=True)
class Window:
    """How much is cut out around a burst, s; None: as much as the ring-down takes and the recording has.

    Attributes
    ----------
    cycles : float
        Periods of the bursts.
    before, after : float or None
        Ahead of the onset, and behind the end.
    """

    cycles: float = 10.0
    before: float | None = None
    after: float | None = None


@dataclass(frozen=True)
class _Repeat:
    """A burst in one of the files, and how far it is from its neighbours, in samples."""

    pair: Pair
    burst: FoundBurst
    room_before: float
    room_after: float


@dataclass(frozen=True)
class CutBurst:
    """The repeats of one frequency.

    Attributes
    ----------
    frequency : float
        Stated, Hz.
    found : float
        What the base's signals show, Hz, the median of the repeats.
    recording : Recording
    onsets : tuple of (str, float)
        Of each repeat: file and time of the onset, s.
    """

    frequency: float
    found: float
    recording: Recording
    onsets: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class CutResult:
    """Bursts by rising frequency, and what was left out, in words."""

    bursts: tuple[CutBurst, ...]
    left_out: tuple[str, ...]


def cut_bursts(
    pairs: Sequence[Pair],
    window: Window,
    known: tuple[float, ...] = (),
    progress: Callable[[str], None] = lambda _: None,
) -> CutResult:
    """Find the bursts of several recordings, and cut them out.

    Parameters
    ----------
    pairs : sequence of Pair
        Of one sampling rate.
    window : Window
    known : tuple of float
        Frequencies there are, Hz; others are left out. Without any, all that are found, at round numbers.
    progress : callable
        Called with the name of a file after each of `find_bursts.number_of_blocks` steps.

    Returns
    -------
    CutResult

    Raises
    ------
    InputError
        When there is no burst.
    """
    repeats: list[_Repeat] = []
    left_out: list[str] = []
    for pair in pairs:
        found = find_bursts(pair.base, pair.sampling_rate, window.cycles, partial(progress, pair.file.name))
        kept, told = _usable(pair, found, window)
        repeats += kept
        left_out += told
    groups = _groups(repeats, known, left_out)
    if not groups:
        raise InputError(_none_found(pairs, window, left_out))
    bursts = [_cut(frequency, group, window) for frequency, group in sorted(groups.items())]
    return CutResult(tuple(bursts), tuple(left_out))


def _none_found(pairs: Sequence[Pair], window: Window, left_out: Sequence[str]) -> str:
    files = ", ".join(str(pair.file) for pair in pairs)
    seen = f" What stands out: {'; '.join(left_out[:3])}" if left_out else ""
    check = "check which channel is the base, the number of cycles (--cycles) and the frequencies"
    return f"{files}: no burst of {window.cycles:g} cycles in the base's signal; {check}.{seen}"


def _usable(pair: Pair, found: Sequence[FoundBurst], window: Window) -> tuple[list[_Repeat], list[str]]:
    """Return the bursts of a file that are whole, and in words those that are not."""
    kept: list[_Repeat] = []
    told: list[str] = []
    fitting = [one for one in found if one.fits(window.cycles)]
    edges = [0.0, *(_end(one, pair, window) for one in fitting)]
    starts = [*(one.onset for one in fitting), float(pair.base.size)]
    told += [_told(pair, one, f"has {one.cycles:.2g} cycles") for one in found if not one.fits(window.cycles)]
    for i, one in enumerate(fitting):
        repeat = _Repeat(pair, one, one.onset - edges[i], starts[i + 1] - _end(one, pair, window))
        least = _LEAST * (_end(one, pair, window) - one.onset)
        if min(repeat.room_before, repeat.room_after) < -least:
            told.append(_told(pair, one, "is cut off, or runs into the next one"))
        else:
            kept.append(repeat)
    return kept, told


def _end(one: FoundBurst, pair: Pair, window: Window) -> float:
    return one.onset + window.cycles / one.frequency * pair.sampling_rate


def _told(pair: Pair, one: FoundBurst, what: str) -> str:
    at = max(one.onset, 0.0) / pair.sampling_rate
    return f"{pair.file.name}, {at:.3f} s: what is found at {one.frequency:.4g} Hz {what}"


def _groups(repeats: Sequence[_Repeat], known: tuple[float, ...], left_out: list[str]) -> dict[float, list[_Repeat]]:
    """Return the repeats by stated frequency."""
    ordered = sorted(repeats, key=lambda repeat: repeat.burst.frequency)
    clusters: list[list[_Repeat]] = []
    for repeat in ordered:
        near = clusters and repeat.burst.frequency <= (1 + _ONE_GROUP) * clusters[-1][-1].burst.frequency
        clusters = [*clusters[:-1], [*clusters[-1], repeat]] if near else [*clusters, [repeat]]
    groups: dict[float, list[_Repeat]] = {}
    for cluster in clusters:
        stated = stated_frequency(_median_frequency(cluster), known)
        if stated is None:
            left_out += [_told(one.pair, one.burst, "is none of the frequencies given") for one in cluster]
        else:
            groups.setdefault(stated, []).extend(cluster)
    return groups


def _median_frequency(group: Sequence[_Repeat]) -> float:
    return float(np.median([repeat.burst.frequency for repeat in group]))


def _cut(frequency: float, group: Sequence[_Repeat], window: Window) -> CutBurst:
    aligned = _aligned(sorted(group, key=lambda one: (str(one.pair.file), one.burst.onset)), frequency, window)
    rate = aligned[0].pair.sampling_rate
    room = [min(getattr(one, name) for one in aligned) / rate for name in ("room_before", "room_after")]
    before = _given(window.before, room[0], "before", frequency, window)
    after = _given(window.after, room[1], "after", frequency, window)
    before = min(BEFORE, max(room[0], 0.0)) if before is None else before
    after = _ringing(aligned[0], room[1], window) if after is None else after
    signals = _pieces(aligned, before, int((before + window.cycles / frequency + after) * rate + 1e-6), frequency)
    onsets = tuple((one.pair.file.name, one.burst.onset / rate) for one in aligned)
    return CutBurst(frequency, _median_frequency(group), Recording(*signals, rate), onsets)


def _given(wanted: float | None, room: float, what: str, frequency: float, window: Window) -> float | None:
    """Return a time that the user gives, refused where the recording does not have it."""
    if wanted is not None and wanted > room + _LEAST * window.cycles / frequency:
        there = f"there are only {max(room, 0.0):.3g} s in every repeat of the burst at {frequency:g} Hz"
        raise InputError(f"--{what}: {wanted:g} s are not there: {there}; ask for less, or leave it out")
    return wanted


def _aligned(group: Sequence[_Repeat], frequency: float, window: Window) -> list[_Repeat]:
    """Return the repeats with onsets that lie as the first one's does, by the time of flight from base to base."""
    rate = group[0].pair.sampling_rate
    n = int(window.cycles / frequency * rate)
    starts = [max(round(one.burst.onset), 0) for one in group]
    n = min(n, *(one.pair.base.size - start for one, start in zip(group, starts, strict=True)))
    pieces = np.stack([one.pair.base[start : start + n] for one, start in zip(group, starts, strict=True)])
    pieces = pieces - pieces.mean(axis=-1, keepdims=True)
    delays = time_of_flight(pieces[0], pieces, rate) * rate
    ahead = group[0].burst.onset - starts[0]
    onsets = [start + ahead + float(delay) for start, delay in zip(starts, delays, strict=True)]
    return [replace(one, burst=replace(one.burst, onset=at)) for one, at in zip(group, onsets, strict=True)]


def _ringing(one: _Repeat, room: float, window: Window) -> float:
    """Return how long the top rings, s: to a thousandth of its crest or to the noise, as far as there is room."""
    rate, most = one.pair.sampling_rate, min(max(room, 0.0), LONGEST_AFTER)
    start, end = max(int(one.burst.onset), 0), int(_end(one.burst, one.pair, window))
    top = envelope(one.pair.top[start : end + int(most * rate)] - np.median(one.pair.top))
    tail = top[end - start :]
    if tail.size < _FEWEST:
        return most
    quiet = max(_QUIET * float(top.max()), _ABOVE_NOISE * float(np.median(tail[-tail.size // 10 :])))
    loud = np.flatnonzero(tail > quiet)
    return min(max((int(loud[-1]) + 1) / rate if loud.size else 0.0, SHORTEST_AFTER), most)


def _pieces(group: Sequence[_Repeat], before: float, n: int, frequency: float) -> tuple[RealArray, RealArray]:
    """Return n samples of base and top of every repeat, shape (repeats, n), or fewer where the recording is shorter."""
    rate = group[0].pair.sampling_rate
    starts = np.array([one.burst.onset - group[0].burst.onset for one in group]) + round(
        group[0].burst.onset - before * rate
    )
    starts += max(-float(np.round(starts.min())), 0.0)
    whole = np.round(starts).astype(int)
    n = min(n, *(one.pair.base.size - int(start) for one, start in zip(group, whole, strict=True)))
    rest = np.where(np.abs(2 * np.pi * frequency / rate * (starts - whole)) > _TURN, starts - whole, 0.0)
    places = list(zip(group, whole, rest, strict=True))
    base, top = (
        np.stack([_moved(getattr(one.pair, role), int(at), n, float(by)) for one, at, by in places])
        for role in ("base", "top")
    )
    return base, top


def _moved(signal: RealArray, start: int, n: int, fraction: float) -> RealArray:
    """Return samples from a start on, `fraction` of a sample later: as they are when that is nothing."""
    if not fraction:
        return signal[start : start + n]
    ahead = min(start, _MARGIN)
    piece = signal[start - ahead : start + n + _MARGIN]
    n_fft = padded_length(piece.size)
    turn = np.exp(2j * np.pi * frequencies(n_fft, 1.0) * fraction)
    shifted = to_signal(to_spectrum(piece - piece.mean(), n_fft) * turn, n_fft, piece.size)
    return np.asarray((shifted + piece.mean())[ahead : ahead + n])
