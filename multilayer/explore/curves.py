"""Curves and ratings of the stack on a page: what `multilayer simulate` computes of the same file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.explore.file import ASIDE, validated
from multilayer.simulation.bands import Grid, grid_of
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.quantities import QUANTITIES
from multilayer.simulation.run import plan, run
from multilayer.simulation.settings import Bands, DiffuseIncidence, FrequencyRange

MOST_POINTS = 400  # frequencies: more than a screen shows of a curve
_LEAST_POINTS = 20
_LEAST_IN_BAND = 5  # points while a slider moves: 0.1 dB of a duct, 0.4 dB of a double wall with studs
_DIGITS = 6


@dataclass(frozen=True)
class _Effort:
    """How much a diffuse field may take: frequencies, and arguments of `diffuse_field`."""

    points: int = MOST_POINTS
    tolerances: Mapping[str, float] = field(default_factory=dict)


_AT_REST = _Effort()
_MOVING = _Effort(tolerances={"tolerance_db": 0.1, "tolerance": 1e-3, "max_panels": 8})
# of a layer that is not isotropic in its plane: azimuths times angles, near coincidence ten thousands of directions
_TURNED_AT_REST = _Effort(120, {"tolerance_db": 0.3, "tolerance": 5e-3, "max_panels": 4})
_TURNED_MOVING = _Effort(40, {"tolerance_db": 0.5, "tolerance": 1e-2, "max_panels": 2})


def computed(data: Mapping[str, Any], file: Path, points: int | None = None, *, moving: bool = False) -> dict[str, Any]:
    """Return curves and ratings of data as a file has them.

    Sweeps and tolerances are left aside. The numbers are those of `multilayer simulate`, but for this: of more than
    `MOST_POINTS` frequencies as many are computed, spread over all of them; while a slider moves, bands have fewer
    points where fewer are asked for, and a diffuse field wider tolerances. These it has always where a layer is not
    isotropic in its plane (0.3 dB, at 120 frequencies): near coincidences of layers with little damping it may miss
    even these, and warns then.

    Parameters
    ----------
    data : mapping
    file : Path
        In whose folder other files are looked for.
    points : int, optional
        Fewer frequencies than the data ask for; in bands, while a slider moves, fewer points.
    moving : bool
        Whether the curves have to follow a slider.

    Returns
    -------
    dict
        ``frequency`` (Hz), ``curves`` by quantity, ``ratings``, ``left_out`` (how many frequencies were not computed),
        ``elapsed`` (ms).

    Raises
    ------
    MultilayerError
        When the data have mistakes, with their paths, or the stack cannot be computed.
    """
    begun = perf_counter()
    simulation = validated({key: value for key, value in data.items() if key not in ASIDE}, file)
    assert isinstance(simulation, SimulationFile)
    effort = _effort(simulation, moving=moving)
    wanted = min(max(points or MOST_POINTS, _LEAST_POINTS), effort.points)
    grid, left_out = _thinned(simulation.frequency, wanted)
    if moving and grid.bands is not None and points is not None:
        grid = _fewer_in_bands(grid, points)
    planned = plan(simulation, file.stem, grid)
    tasks = tuple(replace(task, effort=effort.tolerances) for task in planned.tasks)
    result = run(replace(planned, tasks=tasks))
    case = result.cases[0]
    return {
        "frequency": rounded(result.frequency),
        "bands": result.bands,
        "curves": curves(case.quantities),
        "ratings": dict(case.ratings),
        "left_out": left_out,
        "elapsed": 1e3 * (perf_counter() - begun),
    }


def _effort(simulation: SimulationFile, *, moving: bool) -> _Effort:
    if not isinstance(simulation.incidence, DiffuseIncidence):
        return _AT_REST
    if simulation.isotropic_in_plane:
        return _MOVING if moving else _AT_REST
    return _TURNED_MOVING if moving else _TURNED_AT_REST


def _thinned(frequency: FrequencyRange | Bands | Sequence[float], most: int) -> tuple[Grid, int]:
    """Return a grid of so many frequencies at most, and how many are left out of it; bands stay as they are."""
    if isinstance(frequency, Bands):
        return grid_of(frequency), 0
    if isinstance(frequency, FrequencyRange):
        points = min(frequency.points, most)
        return grid_of(frequency.model_copy(update={"points": points})), frequency.points - points
    kept = np.unique(np.linspace(0, len(frequency) - 1, min(most, len(frequency))).round().astype(int))
    return grid_of(tuple(frequency[i] for i in kept)), len(frequency) - len(kept)


def _fewer_in_bands(grid: Grid, most: int) -> Grid:
    """Return a grid of bands with about so many points in all, spread evenly over each band, a few at least."""
    n = grid.points.shape[1]
    step = min(max(math.ceil(grid.points.size / most), 1), n // _LEAST_IN_BAND)
    first = (n - 1) % step // 2
    return replace(grid, points=grid.points[:, first::step])


def curves(quantities: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """Return quantities as plain data, in the order of `QUANTITIES`: title, unit and the values of each part."""
    shown = {}
    for name, quantity in QUANTITIES.items():
        if name in quantities:
            values = quantities[name]
            parts = (("re", values.real), ("im", values.imag)) if quantity.is_complex else (("", values),)
            listed = [{"label": label, "values": rounded(part)} for label, part in parts]
            shown[name] = {"title": quantity.title, "unit": quantity.unit, "parts": listed}
    return shown


def rounded(values: NDArray[Any]) -> list[float | None]:
    """Return numbers with as many digits as a drawing needs; None where one is not finite."""
    return [float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None for value in values.tolist()]
