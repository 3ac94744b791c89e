"""The recording of one burst: accelerations of support plate and top plate, over one or several repeats."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError


@dataclass(frozen=True, eq=False)
class Waveforms:
    """What a file of one burst holds.

    Attributes
    ----------
    base, top : array, shape (repeats, n_samples)
        Accelerations of support plate and top plate, m/s^2.
    sampling_rate : float or None
        Hz; None when the file does not say.
    """

    base: RealArray
    top: RealArray
    sampling_rate: float | None = None


@dataclass(frozen=True, eq=False)
class Recording:
    """The accelerations of one burst.

    Parameters
    ----------
    base, top : array, shape (repeats, n_samples) or (n_samples,)
        Accelerations of support plate and top plate over the same time, m/s^2; kept as float64 with two axes.
    sampling_rate : float
        Hz.

    Raises
    ------
    InputError
        When the shapes differ or the arrays are empty.
    """

    base: RealArray
    top: RealArray
    sampling_rate: float

    def __post_init__(self) -> None:
        base, top = (np.atleast_2d(np.asarray(channel, dtype=float)) for channel in (self.base, self.top))
        if base.shape != top.shape or base.ndim != 2:
            raise InputError(
                f"base has shape {base.shape} and top {top.shape}; both must be (repeats, samples), and alike"
            )
        if base.size == 0:
            raise InputError(f"the recording is empty: its shape is {base.shape}")
        if not self.sampling_rate > 0:
            raise InputError(f"a sampling rate of {self.sampling_rate} Hz is not allowed; it must be above 0")
        object.__setattr__(self, "base", base)
        object.__setattr__(self, "top", top)
        object.__setattr__(self, "sampling_rate", float(self.sampling_rate))

    @property
    def n_repeats(self) -> int:
        """How often the burst was recorded."""
        return int(self.base.shape[0])

    @property
    def n_samples(self) -> int:
        """Samples of one repeat."""
        return int(self.base.shape[1])

    @property
    def time(self) -> RealArray:
        """Time of each sample from the start of the record, s, shape (n_samples,)."""
        return np.arange(self.n_samples) / self.sampling_rate

    def mean(self) -> tuple[RealArray, RealArray]:
        """Return base and top averaged over the repeats, each of shape (n_samples,)."""
        return self.base.mean(axis=0), self.top.mean(axis=0)

    def exchanged(self) -> Recording:
        """Return the recording with its two channels exchanged."""
        return Recording(self.top, self.base, self.sampling_rate)
