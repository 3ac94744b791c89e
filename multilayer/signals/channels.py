"""What a file of a data recorder holds: named channels with units, each with its sampling rate."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError, Problem

_TOGETHER = 1e-3  # of a sample
_ROUNDING = 8 * np.finfo(float).eps  # of times since long ago
_WHOLE = 1e-5  # of a rate: steps in time are often printed with six digits


@dataclass(frozen=True, eq=False)
class Channel:
    """One channel of a recording.

    Attributes
    ----------
    name : str
    samples : array, shape (n_samples,)
        In the unit of the file.
    unit : str or None
        As the file writes it; None when it does not say.
    sampling_rate : float or None
        Hz; None when the file does not say.
    start : float or None
        Time of the first sample, s, from any instant that all channels of the file share; None when the file does not
        say.
    """

    name: str
    samples: RealArray
    unit: str | None = None
    sampling_rate: float | None = None
    start: float | None = None

    def __str__(self) -> str:
        rate = "no sampling rate" if self.sampling_rate is None else f"{self.sampling_rate:g} Hz"
        return f"'{self.name}' ({self.unit or 'no unit'}, {rate}, {self.samples.size} samples)"


@dataclass(frozen=True, eq=False)
class Channels:
    """All channels of one file.

    Attributes
    ----------
    file : Path
    channels : tuple of Channel
        Their names differ.
    line : int or None
        Number of the line that names the channels, in a text file.
    """

    file: Path
    channels: tuple[Channel, ...]
    line: int | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the channels, in the order of the file."""
        return tuple(channel.name for channel in self.channels)

    def error(self, message: str) -> InputError:
        """Return an error about these channels, placed in their file."""
        return InputError(Problem(message, file=self.file, line=self.line))

    def __str__(self) -> str:
        return ", ".join(str(channel) for channel in self.channels) or "none"

    def __getitem__(self, name: str) -> Channel:
        """Return the channel of a name, in capitals or not.

        Raises
        ------
        InputError
            When there is none, listing those there are.
        """
        alike = [channel for channel in self.channels if channel.name.casefold() == name.strip().casefold()]
        exact = [channel for channel in alike if channel.name == name]
        if not alike:
            raise self.error(f"has no channel '{name}'; it holds: {self}")
        return (exact or alike)[0]


def refuse_other_starts(channels: Channels, chosen: Sequence[Channel]) -> None:
    """Refuse channels that are to be compared sample by sample, but do not start together.

    Parameters
    ----------
    channels : Channels
        Of the file.
    chosen : sequence of Channel
        Those that are compared; those without a start, or of no known rate, are taken to start with the others.

    Raises
    ------
    InputError
        When two starts differ by more than 1e-3 of a sample.
    """
    stated = [(channel, channel.start) for channel in chosen if channel.start is not None]
    if not stated:
        return
    (first, begin), *others = stated
    for channel, start in others:
        rate = channel.sampling_rate or first.sampling_rate or 0.0
        late = start - begin
        if abs(late) > (_TOGETHER / rate if rate else 0.0) + _ROUNDING * max(abs(start), abs(begin)):
            text = f"'{channel.name}' starts {_duration(abs(late))} {'after' if late > 0 else 'before'} '{first.name}'"
            raise channels.error(f"{text}; export all channels on a common time axis")


def _duration(time: float) -> str:
    return f"{time:.6g} s" if time >= 1 else f"{1e3 * time:.4g} ms" if time >= 1e-3 else f"{1e6 * time:.4g} us"


def rate_of_step(step: float) -> float:
    """Return the sampling rate, Hz, of a step in time, s; rounded to a whole number where it is one within 1e-5."""
    rate = 1.0 / step
    return float(round(rate)) if rate >= 1 and abs(rate - round(rate)) <= _WHOLE * rate else rate


def different(names: list[str], longer: list[str]) -> list[str]:
    """Return distinct names: the longer form where the short one comes twice, with a number where that does, too."""
    often = Counter(names)
    chosen = [long if often[short] > 1 else short for short, long in zip(names, longer, strict=True)]
    in_all, so_far, told = Counter(chosen), Counter[str](), []
    for name in chosen:
        so_far[name] += 1
        told.append(name if in_all[name] == 1 else f"{name} {so_far[name]}")
    return told


def as_samples(values: object) -> RealArray:
    """Return samples as float64, shape (n_samples,)."""
    return np.ascontiguousarray(np.asarray(values, dtype=float).ravel())
