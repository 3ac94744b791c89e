"""Repeats of a burst that do not belong together: a channel that failed in one of them, or changed its range."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from multilayer.arrays import BoolArray, ComplexArray, RealArray
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import frequencies, noise_level, to_spectrum

_LOBE = 2.0  # over the duration: half the width of a Hann window's main lobe
_BROKEN = 0.4  # of top over base: ranges are apart by a factor of 2 or more
_APART = 0.05
_CHANCE = 5.0  # standard deviations of the noise
_DEAD = 0.1  # of the level of one channel over the other
_EVEN = 0.1  # of a repeat's departure: what it may vary over the lobe where a channel changed its gain
_ASIDE = 5.0  # degrees
_ALONE = 50.0  # over what the others are apart
_TURN = 0.08  # of a gain: what its imaginary part may be


@dataclass(frozen=True, eq=False)
class RepeatsApart:
    """How far the repeats of a burst are apart.

    Attributes
    ----------
    ratio : complex array, shape (repeats,)
        Top over base over the burst's main lobe, over that of the repeat which is nearest to all others; of two over
        the larger one.
    chance : float
        What noise does to it, at most.
    is_broken : array of bool, shape (repeats,)
        Where a channel has failed or changed its range.
    """

    ratio: ComplexArray
    chance: float
    is_broken: BoolArray

    @property
    def off(self) -> RealArray:
        """How far each is from the middle one, relative, shape (repeats,)."""
        return np.asarray(np.abs(self.ratio - 1))

    @property
    def largest(self) -> float:
        """Largest departure beyond 5 % and what noise explains, relative; 0 where there is none."""
        largest = float(self.off.max())
        return largest if largest > _APART + self.chance else 0.0

    @property
    def refusal(self) -> str:
        """What is wrong and what to do; empty where no channel failed."""
        bad, n = np.flatnonzero(self.is_broken), self.ratio.size
        if not bad.size:
            return ""
        if 2 * bad.size >= n:
            told = "its two repeats differ" if n == 2 else f"repeats {_listed(bad)} of {n} differ from the others"
            return (
                f"{told} in top over base {_in_words(self.ratio[bad[0]])}: a channel failed or changed its range, and "
                "nothing tells in which of them; look at each, and leave out what is wrong, or measure the burst again"
            )
        number = f"repeat {_listed(bad)} of {n} differs" if bad.size == 1 else f"repeats {_listed(bad)} of {n} differ"
        return (
            f"{number} from the others in top over base {_in_words(self.ratio[bad[0]])}: a channel failed or changed "
            "its range; leave that out, or measure the burst again"
        )


def _listed(indices: np.ndarray) -> str:
    return ", ".join(str(i + 1) for i in indices)


def _in_words(ratio: complex) -> str:
    if not np.isfinite(ratio):
        return "(its base is silent)"
    size, angle = abs(ratio), float(np.rad2deg(np.angle(ratio)))
    if size < _DEAD or abs(angle) < _ASIDE:
        return f"by a factor of {size:.2g}"
    return (
        f"by a factor of {-size:.2g}"
        if abs(angle) > 180 - _ASIDE
        else f"by a factor of {size:.2g} and {angle:.0f} degrees"
    )


def compare_repeats(recording: Recording, frequency: float, cycles: float) -> RepeatsApart | None:
    """Return how far the repeats of a burst are apart in top over base; None where there is a single one.

    What the source does differently from repeat to repeat, in level or in time, is the same in both channels and does
    not count. A channel has failed or changed its range where the two levels are apart by a factor of 10, or top over
    base is off by more than 40 % and what noise allows, and either by one real factor over the whole main lobe or while
    all others agree: a sample that drifts moves its resonance, which turns the phase and is not the same over the lobe,
    and one that is mounted anew is hardly ever twice the same.

    Parameters
    ----------
    recording : Recording
        Its values finite.
    frequency : float
        Of the burst, Hz.
    cycles : float
        Of the burst, under its Hann window.
    """
    if recording.n_repeats < 2:
        return None
    base, top = lobe_spectra(recording, frequency, cycles)
    noise, n = noise_level(recording), recording.n_samples
    base_power, top_power = (np.sum(np.abs(part) ** 2, axis=-1) for part in (base, top))
    moves = base_power > 0
    power = np.where(moves, base_power, 1.0)
    ratio, level = np.sum(np.conj(base) * top, axis=-1) / power, np.sqrt(top_power / power)
    middle = _middle(np.where(moves, ratio, 0.0))
    if not abs(ratio[middle]) > 0:
        return None
    relative = np.where(moves, ratio / ratio[middle], np.inf)
    variance = n * (noise.top**2 / abs(ratio[middle]) ** 2 + noise.base**2) / power[middle]
    chance = _CHANCE * float(np.sqrt(2 * variance))  # of the difference of two
    # as in a cross product: nothing is divided where the base hardly moves
    here, there = top * base[middle], top[middle] * base
    size = np.sum(np.abs(there) ** 2, axis=-1)
    factor = np.sum(np.conj(there) * here, axis=-1) / np.where(size > 0, size, 1.0)
    left = np.sum(np.abs(here - factor[:, None] * there) ** 2, axis=-1)
    left -= n * noise.top**2 * (power[middle] + np.abs(factor) ** 2 * power)
    left -= n * noise.base**2 * (top_power + np.abs(factor) ** 2 * top_power[middle])
    is_real = np.abs(factor.imag) < _TURN * np.abs(factor) + chance / 2
    is_even = left < (_EVEN * np.abs(factor - 1)) ** 2 * size
    off = np.abs(relative - 1)
    is_far = off > _BROKEN + chance
    spread = float(off[~is_far].max())  # of the rest, the middle one included
    is_alone = 2 * int(is_far.sum()) < off.size and spread < chance
    is_wrong = is_far & ((is_real & is_even) | (is_alone & (off > _ALONE * spread)))
    is_dead = ~moves | (level < _DEAD * level[middle]) | (level > level[middle] / _DEAD)
    return RepeatsApart(relative, chance, is_dead | is_wrong)


def _middle(ratio: ComplexArray) -> int:
    """Return the repeat whose ratio is nearest to those of all others, of two the larger one."""
    apart = np.sum(np.abs(ratio[:, None] - ratio), axis=-1)
    return int(np.lexsort((-np.abs(ratio), apart))[0])


def lobe_spectra(recording: Recording, frequency: float, cycles: float) -> tuple[ComplexArray, ComplexArray]:
    """Return the spectra of base and top within the burst's main lobe, of every repeat, shape (repeats, bins).

    Without zeros behind the record, so that white noise is independent from bin to bin.
    """
    f = frequencies(recording.n_samples, recording.sampling_rate)
    inside = np.abs(f - frequency) < _LOBE * frequency / cycles
    base, top = (to_spectrum(channel, recording.n_samples)[:, inside] for channel in (recording.base, recording.top))
    return base, top


def repeats_in_words(recordings: Mapping[str, tuple[float, Recording]], cycles: float) -> list[str]:
    """Return `in_words` of recordings.

    Parameters
    ----------
    recordings : mapping of (float, Recording)
        By a name for each, the burst's frequency, Hz, and the recording.
    cycles : float
        Of the bursts.
    """
    return in_words({name: compare_repeats(recording, f, cycles) for name, (f, recording) in recordings.items()})


def in_words(apart: Mapping[str, RepeatsApart | None]) -> list[str]:
    """Return a sentence about repeats that are apart beyond 5 % and their noise, if there are any.

    Parameters
    ----------
    apart : mapping
        Of each recording, by a name for it.
    """
    named = {name: repeats for name, repeats in apart.items() if repeats is not None and repeats.largest}
    if not named:
        return []
    worst = max(named, key=lambda name: named[name].largest)
    number = int(np.argmax(named[worst].off)) + 1
    return [
        f"repeats differ in top over base in {len(named)} of {len(apart)} recordings, beyond their noise: up to "
        f"{100 * named[worst].largest:.2g} % (repeat {number}, {worst}); a fit averages them: look at these "
        "signals, and leave out what went wrong, or wait until the sample has settled"
    ]
