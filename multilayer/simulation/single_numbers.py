"""Single-number ratings of a case, where its frequencies suffice for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from numpy.typing import NDArray

from multilayer.errors import InputError
from multilayer.response.ratings import (
    noise_reduction_coefficient,
    sound_transmission_class,
    weighted_absorption,
    weighted_reduction_index,
)
from multilayer.simulation.bands import Grid, band_average, third_octaves_of

_LEAST_POINTS = 3  # in a third octave, for their mean to stand for the band
_RATINGS: dict[str, dict[str, Callable[[Mapping[float, float]], object]]] = {
    "absorption": {
        "alpha_w": weighted_absorption,
        "NRC": lambda bands: f"{noise_reduction_coefficient(bands):.2f}",
    },
    "transmission_loss": {"Rw (C; Ctr)": weighted_reduction_index, "STC": sound_transmission_class},
}


def ratings(quantities: Mapping[str, NDArray[Any]], grid: Grid) -> dict[str, str]:
    """Return the ratings that the bands of a case allow, by name, as they are written.

    Parameters
    ----------
    quantities : mapping
        By name, over the frequencies of `grid`.
    grid : Grid
        Values at single frequencies are averaged over third octaves; three of them are needed in each.
    """
    # what does not come back from a stack that lets sound through is not absorbed
    quantity = "transmission_loss" if "transmission_loss" in quantities else "absorption"
    bands = third_octave_values(quantity, quantities[quantity], grid)
    found: dict[str, str] = {}
    for name, function in _RATINGS[quantity].items():
        try:
            found[name] = str(function(bands))
        except InputError:  # a band is missing
            continue
    return found


def third_octave_values(quantity: str, values: NDArray[Any], grid: Grid) -> dict[float, float]:
    """Return a value for every third octave that holds enough frequencies, by nominal centre."""
    if grid.bands:
        return dict(zip(grid.frequency.tolist(), values.tolist(), strict=True))
    return {
        centre: float(band_average(quantity, values[inside], (1, len(inside)))[0])
        for centre, inside in third_octaves_of(grid.frequency)
        if len(inside) >= _LEAST_POINTS
    }
