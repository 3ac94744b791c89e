"""What each tolerance makes results scatter by: slopes at the nominal stack times the standard deviation of the draws.

To first order: contributions of fields that scatter independently add up by their squares. Slopes are exact
(`simulation.linearised`) by real fields of layers, of plane waves and diffuse fields on a stack alone; all others are
differences of the whole response.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.paths import locate, with_values
from multilayer.simulation.quantities import QUANTITIES
from multilayer.simulation.tolerances import allowed
from multilayer.stack import Stack

Slopes = dict[str, RealArray]  # by quantity
_STEP = 0.5  # of the standard deviation; a diffuse field is known to 1e-4 only
_HALVINGS = 10  # of a step that leads where a field is not allowed


def standard_deviation(drawn: NDArray[Any]) -> float:
    """Return that of what was drawn; of complex values, whose phase does not scatter, that of the absolute value."""
    return float(np.std(np.abs(drawn) if np.iscomplexobj(drawn) else drawn))


def by_differences(
    stack: Stack, path: str, deviation: float, respond: Callable[[Stack], Mapping[str, NDArray[Any]]]
) -> Slopes:
    """Return slopes of all real quantities by one field, central where its bounds leave room; none without any room.

    Parameters
    ----------
    stack : Stack
    path : str
    deviation : float
        Standard deviation of its draws.
    respond : callable
        Returns the quantities of a stack.
    """
    field = locate(stack, path)
    along = field.value / abs(field.value) if isinstance(field.value, complex) else 1.0
    step = _STEP * deviation
    for _ in range(_HALVINGS):
        steps = step * np.array([1.0, 0.0, -1.0])
        inside = steps[allowed({path: field}, {path: field.value + along * steps})]
        if len(inside) > 1:  # at a bound, to one side
            ends = inside[[0, -1]]
            above, below = (respond(with_values(stack, {path: field.value + along * float(end)})) for end in ends)
            real = [name for name in above if name in QUANTITIES and not QUANTITIES[name].is_complex]
            return {name: (above[name] - below[name]) / (ends[0] - ends[1]) for name in real}
        step /= 2
    return {}
