"""Bursts cut from long recordings: repeats of one frequency together, aligned to one another."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.ndimage import uniform_filter1d

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
_ABOVE_NOISE = 1.5  # or to the noise, by its mean over
_SMOOTH = 2.0  # periods of the burst
_TURN = 0.01  # rad of the tone: what a repeat may be off without being shifted between samples
_SAME_FREQUENCY = 0.01  # relative distance up to which two bursts are repeats, where no frequencies are known
_MARGIN = 256  # samples on both sides of what is shifted, where the shift of a record's ends fades
_FEWEST = 16  # samples that a level is taken of
_LEAST = 0.02  # of a burst: quiet ahead of it and behind it, without which it counts as cut


@dataclass(frozen=True)
class Window:
    """How much is cut out around a burst, s; None for the length of the ring-down, as far as the recording reaches.

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
    """A burst in one of the files, and the samples between it and its neighbours (or the ends of the file)."""

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
    measured_frequency : float
        Of the base's signals, Hz, the median of the repeats.
    recording : Recording
        Its repeats shifted between samples where that aligns them.
    raw : Recording
        The same samples as they were recorded.
    onsets : tuple of (str, float)
        File and time of the onset, s, of each repeat.
    """

    frequency: float
    measured_frequency: float
    recording: Recording
    raw: Recording
    onsets: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class CutResult:
    """Bursts by rising frequency, and a sentence for each that was left out."""

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
        When there is no burst, or without known frequencies bursts that may be repeats or neighbours.
    """
    repeats: list[_Repeat] = []
    left_out: list[str] = []
    for pair in pairs:
        bursts_in_file = find_bursts(pair.base, pair.sampling_rate, window.cycles, partial(progress, pair.file.name))
        kept, reasons = _usable(pair, bursts_in_file, window)
        repeats += kept
        left_out += reasons
    groups = _groups(repeats, known, left_out)
    if not groups:
        raise InputError(_no_burst_message(pairs, window, left_out))
    bursts = [_cut(frequency, group, window) for frequency, group in sorted(groups.items())]
    return CutResult(tuple(bursts), tuple(left_out))


def _no_burst_message(pairs: Sequence[Pair], window: Window, left_out: Sequence[str]) -> str:
    files = ", ".join(str(pair.file) for pair in pairs)
    seen = f" What stands out: {'; '.join(left_out[:3])}" if left_out else ""
    check = "check which channel is the base, the number of cycles (--cycles) and the frequencies"
    return f"{files}: no burst of {window.cycles:g} cycles in the base's signal; {check}.{seen}"


def _usable(pair: Pair, bursts: Sequence[FoundBurst], window: Window) -> tuple[list[_Repeat], list[str]]:
    """Return the bursts of a file that are complete, and a sentence for each of the others."""
    kept: list[_Repeat] = []
    left_out: list[str] = []
    whole = [burst for burst in bursts if burst.fits(window.cycles)]
    edges = [0.0, *(_end(burst, pair, window) for burst in whole)]
    starts = [*(burst.onset for burst in whole), float(pair.base.size)]
    misfits = [burst for burst in bursts if not burst.fits(window.cycles)]
    left_out += [_reason(pair, burst, f"has {burst.cycles:.2g} cycles") for burst in misfits]
    for i, burst in enumerate(whole):
        repeat = _Repeat(pair, burst, burst.onset - edges[i], starts[i + 1] - _end(burst, pair, window))
        least = _LEAST * (_end(burst, pair, window) - burst.onset)
        if min(repeat.room_before, repeat.room_after) < -least:
            left_out.append(_reason(pair, burst, "is cut off, or runs into the next one"))
        else:
            kept.append(repeat)
    return kept, left_out


def _end(burst: FoundBurst, pair: Pair, window: Window) -> float:
    return burst.onset + window.cycles / burst.frequency * pair.sampling_rate


def _reason(pair: Pair, burst: FoundBurst, what: str) -> str:
    at = max(burst.onset, 0.0) / pair.sampling_rate
    return f"{pair.file.name}, {at:.3f} s: what is found at {burst.frequency:.4g} Hz {what}"


def _groups(repeats: Sequence[_Repeat], known: tuple[float, ...], left_out: list[str]) -> dict[float, list[_Repeat]]:
    """Return the repeats by stated frequency: of the known ones that of each burst by itself."""
    groups: dict[float, list[_Repeat]] = {}
    for cluster in [[repeat] for repeat in repeats] if known else _clusters(repeats):
        stated = stated_frequency(_median_frequency(cluster), known)
        if stated is None:
            left_out += [_reason(repeat.pair, repeat.burst, "is none of the frequencies given") for repeat in cluster]
        else:
            groups.setdefault(stated, []).extend(cluster)
    return groups


def _clusters(repeats: Sequence[_Repeat]) -> list[list[_Repeat]]:
    """Return the repeats by frequency; refuse a chain of neighbours that is wider than one frequency can be."""
    clusters: list[list[_Repeat]] = []
    for repeat in sorted(repeats, key=lambda repeat: repeat.burst.frequency):
        near = clusters and _are_repeats(clusters[-1][-1], repeat)
        clusters = [*clusters[:-1], [*clusters[-1], repeat]] if near else [*clusters, [repeat]]
    wide = [cluster for cluster in clusters if not _are_repeats(cluster[0], cluster[-1])]
    if wide:
        raise InputError([_of_chain(cluster) for cluster in wide])
    return clusters


def _are_repeats(low: _Repeat, high: _Repeat) -> bool:
    return high.burst.frequency <= (1 + _SAME_FREQUENCY) * low.burst.frequency


def _of_chain(cluster: Sequence[_Repeat]) -> str:
    low, high = (repeat.burst.frequency for repeat in (cluster[0], cluster[-1]))
    span = f"{len(cluster)} bursts are found from {low:.5g} to {high:.5g} Hz"
    text = f"{span}, each within {_SAME_FREQUENCY:.0%} of the next"
    return f"{text}: which are repeats of one frequency cannot be told; list those that were played in --frequencies"


def _median_frequency(group: Sequence[_Repeat]) -> float:
    return float(np.median([repeat.burst.frequency for repeat in group]))


def _cut(frequency: float, group: Sequence[_Repeat], window: Window) -> CutBurst:
    aligned = _aligned(sorted(group, key=lambda repeat: (str(repeat.pair.file), repeat.burst.onset)), frequency, window)
    rate = aligned[0].pair.sampling_rate
    room = [min(getattr(repeat, name) for repeat in aligned) / rate for name in ("room_before", "room_after")]
    before = _given(window.before, room[0], "before", frequency, window)
    after = _given(window.after, room[1], "after", frequency, window)
    before = min(BEFORE, max(room[0], 0.0)) if before is None else before
    after = _ringing(aligned[0], room[1], window) if after is None else after
    n = int((before + window.cycles / frequency + after) * rate + 1e-6)
    shifted, raw = (Recording(base, top, rate) for base, top in _pieces(aligned, before, n, frequency))
    onsets = tuple((repeat.pair.file.name, repeat.burst.onset / rate) for repeat in aligned)
    return CutBurst(frequency, _median_frequency(group), shifted, raw, onsets)


def _given(wanted: float | None, room: float, what: str, frequency: float, window: Window) -> float | None:
    """Return a time that the user gives, refused where the recording does not have it."""
    if wanted is not None and wanted > room + _LEAST * window.cycles / frequency:
        there = f"there are only {max(room, 0.0):.3g} s in every repeat of the burst at {frequency:g} Hz"
        raise InputError(f"--{what}: {wanted:g} s are not there: {there}; ask for less, or leave it out")
    return wanted


def _aligned(group: Sequence[_Repeat], frequency: float, window: Window) -> list[_Repeat]:
    """Return the repeats with onsets aligned to that of the first, by the delay between their base signals."""
    rate = group[0].pair.sampling_rate
    n = int(window.cycles / frequency * rate)
    starts = [max(round(repeat.burst.onset), 0) for repeat in group]
    n = min(n, *(repeat.pair.base.size - start for repeat, start in zip(group, starts, strict=True)))
    pieces = np.stack([repeat.pair.base[start : start + n] for repeat, start in zip(group, starts, strict=True)])
    pieces = pieces - pieces.mean(axis=-1, keepdims=True)
    delays = time_of_flight(pieces[0], pieces, rate) * rate
    ahead = group[0].burst.onset - starts[0]
    onsets = [start + ahead + float(delay) for start, delay in zip(starts, delays, strict=True)]
    return [replace(repeat, burst=replace(repeat.burst, onset=at)) for repeat, at in zip(group, onsets, strict=True)]


def _ringing(repeat: _Repeat, room: float, window: Window) -> float:
    """Return how long the top rings, s: to a thousandth of its crest or to the noise, as far as there is room.

    By the envelope's mean over some periods: of many samples of noise, some always stand out.
    """
    rate, most = repeat.pair.sampling_rate, min(max(room, 0.0), LONGEST_AFTER)
    start, end = max(int(repeat.burst.onset), 0), int(_end(repeat.burst, repeat.pair, window))
    top = envelope(repeat.pair.top[start : end + int(most * rate)] - np.median(repeat.pair.top))
    tail = uniform_filter1d(top, max(int(_SMOOTH * rate / repeat.burst.frequency), 1))[end - start :]
    if tail.size < _FEWEST:
        return most
    quiet = max(_QUIET * float(top.max()), _ABOVE_NOISE * float(np.median(tail[-tail.size // 10 :])))
    loud = np.flatnonzero(tail > quiet)
    return min(max((int(loud[-1]) + 1) / rate if loud.size else 0.0, SHORTEST_AFTER), most)


def _pieces(group: Sequence[_Repeat], before: float, n: int, frequency: float) -> list[tuple[RealArray, RealArray]]:
    """Return n samples of base and top of every repeat, shape (repeats, n), or fewer where the recording is shorter.

    First shifted by fractions of a sample, then as they were recorded.
    """
    rate = group[0].pair.sampling_rate
    starts = np.array([repeat.burst.onset - group[0].burst.onset for repeat in group]) + round(
        group[0].burst.onset - before * rate
    )
    starts += max(-float(np.round(starts.min())), 0.0)
    whole = np.round(starts).astype(int)
    n = min(n, *(repeat.pair.base.size - int(start) for repeat, start in zip(group, whole, strict=True)))
    rest = np.where(np.abs(2 * np.pi * frequency / rate * (starts - whole)) > _TURN, starts - whole, 0.0)
    places = list(zip(group, whole, rest, strict=True))

    def piece(role: str, share: float) -> RealArray:
        return np.stack(
            [_moved(getattr(repeat.pair, role), int(at), n, share * float(by)) for repeat, at, by in places]
        )

    return [(piece("base", share), piece("top", share)) for share in (1.0, 0.0)]


def _moved(signal: RealArray, start: int, n: int, fraction: float) -> RealArray:
    """Return n samples from a start on, read `fraction` of a sample later (by the phase of their spectrum)."""
    if not fraction:
        return signal[start : start + n]
    ahead = min(start, _MARGIN)
    piece = signal[start - ahead : start + n + _MARGIN]
    n_fft = padded_length(piece.size)
    turn = np.exp(2j * np.pi * frequencies(n_fft, 1.0) * fraction)
    shifted = to_signal(to_spectrum(piece - piece.mean(), n_fft) * turn, n_fft, piece.size)
    return np.asarray((shifted + piece.mean())[ahead : ahead + n])
