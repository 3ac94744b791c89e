"""Measured ratios of the spectra of top and base, in the main lobe of every burst.

Noise of a ratio of spectra to first order: J. S. Bendat & A. G. Piersol, Random Data, 4th ed., Wiley 2010, ch. 9.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import BoolArray, ComplexArray, RealArray
from multilayer.errors import InputError
from multilayer.experiments.two_plate.burst import BurstData
from multilayer.experiments.two_plate.record_end import RecordEnd
from multilayer.inference.whitening import CorrelatedError
from multilayer.measurements.description import Campaign

SMOOTH = 0.3  # correlation length of the model's error in ln f
_BINS = 6  # used of each burst: its main lobe holds about as many independent bins
_FIRST_ORDER = 0.3  # standard deviation of ln(ratio) up to which its noise is Gaussian, and its mean that of the ratio
_BY_BIN = ("frequency", "burst", "ratio", "variance", "stretch_moments", "top_slopes", "friction")


@dataclass(frozen=True)
class ConfigurationData:
    """Measured ratios of spectra, top over base, of one configuration.

    Attributes
    ----------
    name : str
    thickness : float
        Of the specimen, m.
    frequency : array, shape (n,)
        Hz; the bins of all bursts, one burst after the other.
    burst : array of int, shape (n,)
        Index of the burst of each bin.
    ratio : complex array, shape (n,)
    variance : array, shape (n,)
        Of the real and of the imaginary part of the noise in ln(ratio).
    centres : array, shape (n_bursts,)
        Stated frequencies of the bursts, Hz.
    stretch_moments : complex array, shape (k, n), optional
        Means of powers of the amplitude of the sample's stretch, as they act on each bin; see `BurstData`.
    top_slopes : complex array, shape (2, n), optional
        Derivatives by ln f of the logarithm of the top channel's spectrum in each bin; see `BurstData`.
    friction : complex array, shape (n,), optional
        Dry friction of 1 N over the stretch in each bin, 1/m; see `BurstData`.
    ends : mapping
        By index of the burst, the ring-down beyond its record's end, where that matters.
    calibration_std : array, shape (n_bursts,), optional
        Standard deviation of each part of ln(ratio), the same at all bins of a burst.
    completed_by : array, shape (k,), optional
        Largest change of ln(ratio) in each burst whose ring-down beyond its record's end is added (`completed`).
    incomplete_by : array, shape (k,), optional
        The same of bursts whose records are taken as they are (`incomplete`).
    """

    name: str
    thickness: float
    frequency: RealArray
    burst: NDArray[np.intp]
    ratio: ComplexArray
    variance: RealArray
    centres: RealArray
    stretch_moments: ComplexArray | None = None
    top_slopes: ComplexArray | None = None
    friction: ComplexArray | None = None
    ends: Mapping[int, RecordEnd] = field(default_factory=dict, repr=False)
    calibration_std: RealArray | None = None
    completed_by: RealArray | None = None
    incomplete_by: RealArray | None = None

    @cached_property
    def needed(self) -> RealArray:
        """Frequencies at which the model's motion is needed, Hz: those of the bins, then of the records' ends."""
        return np.concatenate([self.frequency, *(end.frequency for end in self.ends.values())])

    @property
    def needed_burst(self) -> NDArray[np.intp]:
        """Index of the burst of each of these."""
        parts = [np.full(len(end.frequency), index) for index, end in self.ends.items()]
        return np.concatenate([self.burst, *parts])

    def cut(self, motion: ComplexArray) -> ComplexArray:
        """Return a model's ratio, shape (..., n), of truncated records, from its motion at `needed`."""
        n = len(self.frequency)
        if not self.ends:
            return motion
        shown, first = motion[..., :n].copy(), n
        for index, end in self.ends.items():
            last = first + len(end.frequency)
            shown[..., self.burst == index] -= end.missing(motion[..., first:last])
            first = last
        return shown

    @cached_property
    def target(self) -> ComplexArray:
        """Logarithm of `ratio`: what is compared."""
        return np.asarray(np.log(self.ratio))

    def covariance(self, model_error: float) -> RealArray:
        """Return the covariance of one part of ln(ratio): noise, and the model's error, smooth in ln f."""
        covariance = np.diag(self.variance) + CorrelatedError(model_error, SMOOTH, smooth=True).covariance(
            self.frequency
        )
        if self.calibration_std is not None:
            together = np.equal.outer(self.burst, self.burst)
            covariance += np.where(together, self.calibration_std[self.burst] ** 2, 0.0)
        return np.asarray(covariance)

    def completed(self, change: ComplexArray, error: float) -> ConfigurationData:
        """Return the data as of records that go on until all is at rest, from what their ends change.

        Parameters
        ----------
        change : complex array, shape (n,)
            Of ln(ratio), by the ends.
        error : float
            Its relative standard deviation.
        """
        variance = self.variance + (error * np.abs(change)) ** 2
        by = self._largest(change)
        return replace(self, ratio=self.ratio * np.exp(-change), variance=variance, ends={}, completed_by=by)

    def incomplete(self, change: ComplexArray) -> ConfigurationData:
        """Return the data as if all were at rest at the ends of the records, which change ln(ratio), shape (n,)."""
        return replace(self, ends={}, incomplete_by=self._largest(change))

    def _largest(self, change: ComplexArray) -> RealArray:
        return np.array([np.abs(change[self.burst == burst]).max() for burst in self.ends])

    def part(self, kept: NDArray[np.intp]) -> ConfigurationData:
        """Return the data of some bursts, by their indices, and renumbered."""
        inside = np.isin(self.burst, kept)
        renumbered = np.searchsorted(kept, self.burst[inside])
        ends = {new: self.ends[old] for new, old in enumerate(kept.tolist()) if old in self.ends}
        std = None if self.calibration_std is None else self.calibration_std[kept]
        bins = self._of_bins(inside)
        return replace(bins, burst=renumbered, centres=self.centres[kept], ends=ends, calibration_std=std)

    def thinned(self, every: int) -> ConfigurationData:
        """Return the data with every so many-th bin of each burst, centred within the burst."""
        place = np.arange(len(self.burst)) - np.searchsorted(self.burst, self.burst)
        count = np.bincount(self.burst)[self.burst]
        return self._of_bins(place % every == (np.minimum(every, count) - 1) // 2)

    def _of_bins(self, inside: BoolArray) -> ConfigurationData:
        columns = {name: getattr(self, name) for name in _BY_BIN}
        return replace(self, **{name: at[..., inside] for name, at in columns.items() if at is not None})


def configuration_data(campaign: Campaign, bursts: Sequence[BurstData]) -> list[ConfigurationData]:
    """Return the data of every configuration from its bursts.

    A burst whose record ends before its ring-down is left out: its ratio of spectra is not the transmissibility. The
    error of a calibration is common to all configurations: its variance is multiplied by their number, so that their
    mean is as uncertain as the calibration, and their difference more than that.

    Raises
    ------
    InputError
        When no burst of a configuration is left.
    """
    configurations = []
    for configuration in campaign.configurations:
        complete = [b for b in bursts if b.configuration == configuration.name and not b.cut_short]
        if not complete:
            raise InputError(
                f"{configuration.name}: every record ends before the top plate's ring-down does; record longer"
            )
        parts = [_ratios(burst) for burst in complete]
        by_bin: dict[str, Any] = {name: np.concatenate([part[name] for part in parts], axis=-1) for name in parts[0]}
        std = np.sqrt(len(campaign.configurations)) * np.array([burst.calibration_std for burst in complete])
        configurations.append(
            ConfigurationData(
                name=configuration.name,
                thickness=configuration.specimen_thickness,
                burst=np.repeat(np.arange(len(complete)), [len(part["frequency"]) for part in parts]),
                centres=np.array([burst.frequency for burst in complete]),
                calibration_std=std if np.any(std) else None,
                **by_bin,
            )
        )
    return configurations


def bursts_left_out(campaign: Campaign, configurations: Sequence[ConfigurationData]) -> list[str]:
    """Return a warning of the bursts of a campaign that `configuration_data` leaves out; none where all are used."""
    used = {data.name: set(data.centres.tolist()) for data in configurations}
    listed = []
    for configuration in campaign.configurations:
        missing = [
            f"{burst.frequency:g}" for burst in configuration.bursts if burst.frequency not in used[configuration.name]
        ]
        if missing:
            listed.append(f"{configuration.name} at {', '.join(missing)} Hz")
    if not listed:
        return []
    return [f"bursts left out, whose records end long before all is at rest: {'; '.join(listed)}; record longer"]


def _ratios(burst: BurstData) -> dict[str, Any]:
    """Return the columns of `ConfigurationData` of a burst, but for its index."""
    f, base, top = burst.in_band
    ratio = top / base
    power = burst.n_samples * (burst.noise.top**2 + np.abs(ratio) ** 2 * burst.noise.base**2)
    variance = power / (2 * np.abs(top) ** 2)
    clear = np.flatnonzero(variance < max(_FIRST_ORDER**2, 1.01 * float(variance.min())))
    kept = clear[np.unique(np.linspace(0, len(clear) - 1, min(_BINS, len(clear))).round().astype(int))]
    return {
        "frequency": f[kept],
        "ratio": ratio[kept],
        "variance": variance[kept],
        "stretch_moments": burst.stretch_moments[:, kept],
        "top_slopes": burst.top_slopes[:, kept],
        "friction": burst.friction[kept],
    }
