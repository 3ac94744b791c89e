"""Single-number ratings of a case, where its frequencies suffice for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.errors import InputError
from multilayer.response.bands import Width
from multilayer.response.ratings import (
    enlarged_adaptation_terms,
    noise_reduction_coefficient,
    outdoor_indoor_transmission_class,
    sound_transmission_class,
    weighted_absorption,
    weighted_absorption_octaves,
    weighted_impact_level,
    weighted_impact_level_octaves,
    weighted_reduction_index,
)
from multilayer.simulation.bands import Grid
from multilayer.simulation.quantities import QUANTITIES

_LOW_TO_HIGH = "50-5000"


def _enlarged(bands: Mapping[float, float]) -> str:
    lowest = float(_LOW_TO_HIGH.split("-", maxsplit=1)[0])
    if lowest not in bands or _LOW_TO_HIGH not in (terms := enlarged_adaptation_terms(bands)):
        raise InputError(f"these terms need the bands {_LOW_TO_HIGH} Hz")
    c, ctr = terms[_LOW_TO_HIGH]
    return f"{c}; {ctr} dB"


def _low_impact_term(bands: Mapping[float, float]) -> str:
    term = weighted_impact_level(bands).ci_50
    if term is None:
        raise InputError("this term needs the bands from 50 Hz")
    return f"{term} dB"


IMPACT = "Ln,w (CI)"  # the lower, the better
_RATINGS: dict[tuple[str, Width], dict[str, Callable[[Mapping[float, float]], object]]] = {
    ("absorption", "third octaves"): {
        "alpha_w": weighted_absorption,
        "NRC": lambda bands: f"{noise_reduction_coefficient(bands):.2f}",
    },
    ("transmission_loss", "third octaves"): {
        "Rw (C; Ctr)": weighted_reduction_index,
        f"C{_LOW_TO_HIGH}; Ctr{_LOW_TO_HIGH}": _enlarged,
        "STC": sound_transmission_class,
        "OITC": outdoor_indoor_transmission_class,
    },
    ("impact_level", "third octaves"): {IMPACT: weighted_impact_level, "CI,50-2500": _low_impact_term},
    ("impact_level", "octaves"): {IMPACT: weighted_impact_level_octaves},
    ("absorption", "octaves"): {"alpha_w": weighted_absorption_octaves},
    ("transmission_loss", "octaves"): {},  # C, Ctr and STC are defined in third octaves
}


def ratings(cases: Sequence[Mapping[str, NDArray[Any]]], grid: Grid) -> list[dict[str, str]]:
    """Return the ratings that the bands of each case allow, by name, as text.

    Parameters
    ----------
    cases : sequence of mapping
        Quantities by name, over the frequencies of `grid`.
    grid : Grid
        Values at single frequencies are averaged over third octaves; three of them are needed in each.
    """
    rated: list[dict[str, str]] = [{} for _ in cases]
    for quantity in ("impact_level", "transmission_loss", "absorption"):
        # with transmission, power that is not reflected is not all absorbed: ratings of absorption would mislead
        misleads = "transmission_loss" if quantity == "absorption" else None
        these = [i for i, case in enumerate(cases) if quantity in case and misleads not in case]
        if not these:
            continue
        means = grid.by_band(QUANTITIES[quantity].mean, np.array([cases[i][quantity] for i in these]))
        functions, centres = _RATINGS[quantity, grid.bands or "third octaves"], [*means]
        rows = np.array([*means.values()]).T.tolist() if means else [[]] * len(these)
        for i, row in zip(these, rows, strict=True):
            bands = dict(zip(centres, row, strict=True))
            for name, function in functions.items():
                with suppress(InputError):  # a band is missing
                    rated[i][name] = str(function(bands))
    return rated
