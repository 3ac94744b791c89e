"""The frequencies at which a simulation is computed, and the bands over which it is averaged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from multilayer.arrays import IndexArray, RealArray
from multilayer.response.bands import Width, band_centres, band_edges, band_points, bands_of
from multilayer.simulation.settings import Bands, FrequencyRange

_LEAST_POINTS = 3  # in a third octave, for their mean to stand for the band
_NEAR = 1.25  # spacings from its edges to them: even steps in Hz are that uneven on the logarithmic axis
_AT_EDGE = 0.05  # of the band from an edge, near enough however fine the spacing
_RATED = ((100.0, 3150.0), (200.0, 5000.0))  # first and last third octave of Rw, and of alpha_w


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

    @cached_property
    def _whole_thirds(self) -> list[tuple[float, IndexArray]]:
        """Those third octaves that frequencies fill from edge to edge."""
        return [(centre, inside) for centre, inside in self.thirds if _fill(self.frequency[inside], centre)]

    @property
    def partly_filled(self) -> list[float]:
        """Centres of third octaves for which a rating is lost, Rw or alpha_w, though many frequencies lie in all."""
        if self.bands is not None:
            return []
        held = {centre for centre, inside in self.thirds if len(inside) >= _LEAST_POINTS}
        whole = {centre for centre, _ in self._whole_thirds}
        needed = [set(band_centres(*ends, "third octaves").tolist()) for ends in _RATED]
        return sorted(set[float]().union(*(bands - whole for bands in needed if bands <= held)))

    def by_band(self, mean: Callable[[RealArray], RealArray], values: RealArray) -> dict[float, RealArray]:
        """Return values by centre of a band, in which ratings read them.

        Parameters
        ----------
        mean : callable
            Of the last axis; single frequencies are averaged over the third octaves that at least three of them fill
            from edge to edge: half of a band is not the band.
        values : array, shape (..., n_frequency)

        Returns
        -------
        dict
            Arrays of shape (...).
        """
        if self.bands is not None:
            return {float(centre): values[..., i] for i, centre in enumerate(self.frequency)}
        return {centre: mean(values[..., inside]) for centre, inside in self._whole_thirds}


def _fill(frequency: RealArray, centre: float) -> bool:
    """Tell whether frequencies inside a third octave are enough for a mean, and reach close to both of its edges."""
    x = np.log(np.unique(frequency))
    if len(x) < _LEAST_POINTS:
        return False
    low, high = np.log(band_edges([centre]))
    near = max(_NEAR * (x[-1] - x[0]) / (len(x) - 1), _AT_EDGE * (high - low))
    return bool(x[0] - low <= near and high - x[-1] <= near)


def grid_of(frequency: FrequencyRange | Bands | tuple[float, ...]) -> Grid:
    """Return the grid that a simulation file asks for."""
    if isinstance(frequency, Bands):
        return band_grid(band_centres(*frequency.ends, frequency.width), frequency.width)
    values = frequency.values() if isinstance(frequency, FrequencyRange) else np.array(frequency, dtype=float)
    return Grid(values, values)


def band_grid(centres: RealArray, width: Width) -> Grid:
    """Return the grid of bands by their nominal centres."""
    return Grid(centres, band_points(centres, width), width)
