"""The front of an optimisation with several goals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from multilayer.number_text import over_unit
from multilayer.optimisation.aims import Aim
from multilayer.optimisation.result import OptimisationResult
from multilayer.report.style import WIDTH, blank, colour, plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_front(result: OptimisationResult, *, upright: bool = False) -> Figure:
    """Draw every other goal over the first: the designs of the front by their numbers, and the design as written.

    Parameters
    ----------
    result : OptimisationResult
        With two goals or more.
    upright : bool
        Small and untitled, as a report has it.
    """
    first, *others = result.goals
    width, height = (WIDTH, 3.0) if upright else (7.5, 4.2)
    figure, grid = blank(len(others), 1, (width, height * len(others)), sharex=True)
    values = np.array([design.goals for design in result.designs]) * [_factor(aim) for aim in result.goals]
    written = np.array(result.written.goals) * [_factor(aim) for aim in result.goals]
    for i, (axis, aim) in enumerate(zip(grid[:, 0], others, strict=True), start=1):
        line = "o-" if len(others) == 1 else "o"
        axis.plot(values[:, 0], values[:, i], line, color=colour(0), markersize=4, linewidth=0.8, label="front")
        for design, row in zip(result.designs, values, strict=True):
            axis.annotate(design.name, (row[0], row[i]), (3, 3), textcoords="offset points", fontsize=6)
        label = "as written" if result.written.is_kept else "as written, misses a limit"
        axis.plot(*written[[0, i]], "x", color=colour(1), label=label)
        axis.set_ylabel(_label(aim))
        axis.legend(fontsize=7)
    grid[-1, 0].set_xlabel(_label(first))
    if not upright:
        figure.suptitle(f"{plain(result.name)}: designs of which none is better in all goals")
    return figure


def _factor(aim: Aim) -> float:
    return 1e3 if aim.unit == "m" else 1.0


def _label(aim: Aim) -> str:
    unit = {"m": "mm", "kg/m^2": "kg/m²"}.get(aim.unit, aim.unit)
    return over_unit(plain(aim.title), unit)
