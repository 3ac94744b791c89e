"""The frequencies at which a simulation is computed, and the bands over which it is averaged."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.simulation.quantities import QUANTITIES
from multilayer.simulation.settings import POINTS_PER_BAND, FrequencyRange, ThirdOctaves

_NOMINAL = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)  # IEC 61260-1, table E.1


@dataclass(frozen=True)
class Grid:
    """Frequencies of a result, and those at which it is computed.

    Attributes
    ----------
    frequency : array, shape (n_frequency,)
        Hz; nominal centres of third-octave bands where `bands`.
    points : array, shape (n_frequency,) or (n_frequency, n_points)
        Hz; with bands, what each is averaged over.
    """

    frequency: RealArray
    points: RealArray

    @property
    def bands(self) -> bool:
        """Whether values are averages over bands."""
        return self.points.ndim == 2


def grid_of(frequency: FrequencyRange | ThirdOctaves | tuple[float, ...]) -> Grid:
    """Return the grid that a simulation file asks for."""
    if isinstance(frequency, ThirdOctaves):
        first, last = (band_number(f) for f in frequency.third_octaves)
        return band_grid(range(first, last + 1))
    values = frequency.values() if isinstance(frequency, FrequencyRange) else np.array(frequency, dtype=float)
    return Grid(values, values)


def band_number(frequency: float) -> int:
    """Return n of the third-octave band whose centre 10^(n/10) Hz is nearest."""
    return round(10 * math.log10(frequency))


def band_grid(band_numbers: Iterable[int]) -> Grid:
    """Return the grid of third-octave bands, IEC 61260-1 (base ten), by their numbers."""
    numbers = np.array([*band_numbers], dtype=float)
    decade, step = np.divmod(numbers, 10)
    nominal = 10.0**decade * np.array(_NOMINAL)[step.astype(int)]
    # midpoints of equal parts of the band on the logarithmic axis
    inside = (np.arange(POINTS_PER_BAND) + 0.5) / POINTS_PER_BAND - 0.5
    return Grid(nominal, 10 ** ((numbers[:, None] + inside) / 10))


def band_average(name: str, values: RealArray, shape: tuple[int, ...]) -> RealArray:
    """Return means over bands: of the transmitted power for what is in dB, of the value itself otherwise.

    Parameters
    ----------
    name : str
        Of the quantity.
    values : array, shape (..., n_bands * n_points)
    shape : (n_bands, n_points)
    """
    apart = values.reshape(*values.shape[:-1], *shape)
    if QUANTITIES[name].unit != "dB":
        return np.asarray(apart.mean(axis=-1))
    with np.errstate(divide="ignore"):
        return np.asarray(-10 * np.log10(np.mean(10 ** (-apart / 10), axis=-1)))


def third_octave_edges(frequency: RealArray) -> RealArray:
    """Return the edges, Hz, of adjacent third-octave bands given by their centres: one more than these."""
    numbers = np.array([band_number(f) for f in frequency])
    return np.asarray(10 ** (np.append(numbers - 0.5, numbers[-1] + 0.5) / 10))


def third_octaves_of(frequency: RealArray) -> list[tuple[float, NDArray[np.intp]]]:
    """Return the nominal centre of each third-octave band that holds some of the frequencies, and their indices."""
    numbers = np.array([band_number(f) for f in frequency])
    present = np.unique(numbers)
    return [
        (float(f), np.flatnonzero(numbers == n)) for f, n in zip(band_grid(present).frequency, present, strict=True)
    ]
