"""The frequencies at which a simulation is computed, and the bands over which it is averaged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from multilayer.arrays import IndexArray, RealArray
from multilayer.response.bands import Width, band_centres, band_points, bands_of
from multilayer.simulation.settings import Bands, FrequencyRange

_LEAST_POINTS = 3  # in a third octave, for their mean to stand for the band


@dataclass(frozen=True)
class Grid:
    """Frequencies of a result, and those at which it is computed.

    Attributes
    ----------
    frequency : array, shape (n_frequency,)
        Hz; nominal centres where there are `bands`.
    points : array, shape (n_frequency,) or (n_frequency, n_points)
        Hz; with bands, the frequencies over which each is averaged.
    bands : str or None
        ``third octaves`` or ``octaves``; None for single frequencies.
    """

    frequency: RealArray
    points: RealArray
    bands: Width | None = None

    @cached_property
    def thirds(self) -> list[tuple[float, IndexArray]]:
        """The nominal centre of each third octave that holds some of the frequencies, and their indices."""
        return bands_of(self.frequency)

    def by_band(self, mean: Callable[[RealArray], RealArray], values: RealArray) -> dict[float, RealArray]:
        """Return values by centre of a band, in which ratings read them.

        Parameters
        ----------
        mean : callable
            Of the last axis; single frequencies are averaged over the third octaves that hold at least three of them.
        values : array, shape (..., n_frequency)

        Returns
        -------
        dict
            Arrays of shape (...).
        """
        if self.bands is not None:
            return {float(centre): values[..., i] for i, centre in enumerate(self.frequency)}
        return {centre: mean(values[..., inside]) for centre, inside in self.thirds if len(inside) >= _LEAST_POINTS}


def grid_of(frequency: FrequencyRange | Bands | tuple[float, ...]) -> Grid:
    """Return the grid that a simulation file asks for."""
    if isinstance(frequency, Bands):
        return band_grid(band_centres(*frequency.ends, frequency.width), frequency.width)
    values = frequency.values() if isinstance(frequency, FrequencyRange) else np.array(frequency, dtype=float)
    return Grid(values, values)


def band_grid(centres: RealArray, width: Width) -> Grid:
    """Return the grid of bands by their nominal centres."""
    return Grid(centres, band_points(centres, width), width)
