"""What a solution asks of the laboratory's statements: whether chance makes them so far off, and which are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from multilayer.arrays import BoolArray, RealArray
from multilayer.chi2 import exceeding
from multilayer.inference.priors import Parameter

_FAR = 3.0  # standard deviations


class Statement(NamedTuple):
    """A stated quantity, and by how many of its stated standard deviations a solution takes it for wrong."""

    parameter: Parameter
    deviations: float


def _stated(parameters: Sequence[Parameter]) -> BoolArray:
    return np.array([parameter.nuisance for parameter in parameters], dtype=bool)


def nuisance_p_value(parameters: Sequence[Parameter], z: RealArray) -> float:
    """Return the probability that what the laboratory states is as far off, all of it together, as at `z`.

    By itself: within the misfit of hundreds of data even an error of many standard deviations goes unnoticed.

    Parameters
    ----------
    parameters : sequence of Parameter
        Those marked as nuisances count.
    z : array, shape (n,)
        Standard normal coordinates.
    """
    amounts = z[_stated(parameters)]
    return exceeding(float(amounts @ amounts), len(amounts)) if len(amounts) else 1.0


def far_off(parameters: Sequence[Parameter], z: RealArray) -> list[Statement]:
    """Return the statements beyond three standard deviations, or else the one farthest off; the farthest first."""
    off = [
        Statement(parameter, float(value))
        for parameter, value, stated in zip(parameters, z, _stated(parameters), strict=True)
        if stated
    ]
    off.sort(key=lambda statement: -abs(statement.deviations))
    return [statement for statement in off if abs(statement.deviations) > _FAR] or off[:1]
