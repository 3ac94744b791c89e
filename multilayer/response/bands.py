"""Octave and third-octave bands: centres, edges, and means of spectra over them.

IEC 61260-1:2014, base ten: centres lie at 10^(n/10) Hz in third octaves and at 10^(3 n/10) Hz in octaves, edges midway
between them on the logarithmic axis. A band goes by its nominal centre (table E.1), or by any frequency inside.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import ArrayLike, RealArray
from multilayer.errors import InputError, suggest

Width = Literal["third octaves", "octaves"]
Mean: TypeAlias = Callable[[RealArray], RealArray]

POINTS_PER_THIRD = 21
_NOMINAL = np.array([1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0])
_THIRDS: dict[Width, int] = {"third octaves": 1, "octaves": 3}


def _thirds(width: Width) -> int:
    if width not in _THIRDS:
        raise InputError(f"there are no bands called '{width}'; {suggest(width, _THIRDS)}")
    return _THIRDS[width]


def _numbers(frequency: ArrayLike, width: Width) -> NDArray[np.intp]:
    """Return n of the bands that hold the frequencies."""
    f = np.asarray(frequency, dtype=float)
    within = np.isfinite(f) & (f > 0)
    if not np.all(within):
        raise InputError(f"{f[~within].flat[0]:g} Hz lies in no band; frequencies must be above 0 and finite")
    return np.asarray(np.round(10 * np.log10(f) / _thirds(width)), dtype=np.intp)


def _nominal(numbers: NDArray[np.intp], width: Width) -> RealArray:
    decade, step = np.divmod(numbers * _thirds(width), 10)
    value, power = _NOMINAL[step], 10.0 ** np.abs(decade)
    # 10^-1 is no number of the machine, and 0.1 * 1.25 not always 0.125; 1.25 / 10 is
    return np.where(decade < 0, value / power, value * power)


def nearest_centres(frequency: ArrayLike, width: Width = "third octaves") -> RealArray:
    """Return the nominal centres, Hz, of the bands that hold the frequencies."""
    return _nominal(_numbers(frequency, width), width)


def band_centres(first: float, last: float, width: Width = "third octaves") -> RealArray:
    """Return the nominal centres, Hz, from the band that holds `first` to the one that holds `last`."""
    low, high = _numbers([first, last], width)
    return _nominal(np.arange(low, high + 1), width)


def band_edges(centres: ArrayLike, width: Width = "third octaves") -> RealArray:
    """Return the edges, Hz, of adjacent bands given by their centres: one more than these."""
    numbers = _numbers(centres, width)
    return np.asarray(10 ** (_thirds(width) * (np.append(numbers, numbers[-1] + 1) - 0.5) / 10))


def band_points(centres: ArrayLike, width: Width = "third octaves") -> RealArray:
    """Return the frequencies that stand for bands, Hz, shape (n_bands, n_points): 21 in every third octave.

    They are the midpoints of equal parts of the band on the logarithmic axis.
    """
    thirds = _thirds(width)
    n = thirds * POINTS_PER_THIRD
    inside = (np.arange(n) + 0.5) / n - 0.5
    return np.asarray(10 ** (thirds * (_numbers(centres, width)[:, None] + inside) / 10))


def bands_of(frequency: ArrayLike, width: Width = "third octaves") -> list[tuple[float, NDArray[np.intp]]]:
    """Return the nominal centre of each band that holds some of the frequencies, and their indices."""
    numbers = _numbers(frequency, width)
    present = np.unique(numbers)
    centres = _nominal(present, width).tolist()
    return [(centre, np.flatnonzero(numbers == n)) for centre, n in zip(centres, present, strict=True)]


def mean_value(values: RealArray, weights: RealArray | None = None) -> RealArray:
    """Return the mean over the last axis, of equal weights or of those given, whose sum is 1."""
    return np.asarray(np.mean(values, axis=-1) if weights is None else np.sum(weights * values, axis=-1))


def mean_loss(loss: RealArray, weights: RealArray | None = None) -> RealArray:
    """Return the loss, dB, that belongs to the mean of the transmitted power over the last axis; see `mean_value`."""
    with np.errstate(divide="ignore"):
        return np.asarray(-10 * np.log10(mean_value(10 ** (-np.asarray(loss) / 10), weights)))


def band_means(
    frequency: ArrayLike,
    values: ArrayLike,
    width: Width = "third octaves",
    *,
    mean: Mean = mean_value,
    least: int = 1,
) -> dict[float, float]:
    """Return means of a spectrum over bands, by nominal centre, as `multilayer.response.ratings` takes them.

    Parameters
    ----------
    frequency : array, shape (n_frequency,)
        Hz, in any order.
    values : array, shape (n_frequency,)
        As absorption coefficients; of equal weight.
    width : str
        ``third octaves`` or ``octaves``.
    mean : callable
        Of an array over its last axis.
    least : int
        How many of the frequencies a band must hold not to be left out.

    Raises
    ------
    InputError
        For a frequency that is not above 0, another width, or arrays of different shapes.
    """
    f, spectrum = np.asarray(frequency, dtype=float), np.asarray(values, dtype=float)
    if f.ndim != 1 or spectrum.shape != f.shape:
        raise InputError(f"{f.shape} frequencies and {spectrum.shape} values are no spectrum; give one value for each")
    held = bands_of(f, width)
    return {centre: float(mean(spectrum[inside])) for centre, inside in held if len(inside) >= least}


def band_levels(
    frequency: ArrayLike, loss: ArrayLike, width: Width = "third octaves", *, least: int = 1
) -> dict[float, float]:
    """Return a transmission loss over bands, dB, by nominal centre: that of the mean transmitted power.

    Parameters
    ----------
    frequency, width, least
        As for `band_means`.
    loss : array, shape (n_frequency,)
        dB.
    """
    return band_means(frequency, loss, width, mean=mean_loss, least=least)
