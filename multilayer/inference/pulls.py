"""Pulls of nuisance parameters: by how many stated standard deviations a solution moves what a laboratory states.

L. Demortier & L. Lyons, Everything you always wanted to know about pulls, CDF note 5776, Fermilab 2002.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from multilayer.arrays import BoolArray, RealArray
from multilayer.chi2 import exceeding
from multilayer.inference.priors import Parameter

_FAR = 3.0  # standard deviations


class Pull(NamedTuple):
    """A stated quantity, and by how many of its stated standard deviations a solution moves it."""

    parameter: Parameter
    deviations: float


def _nuisances(parameters: Sequence[Parameter]) -> BoolArray:
    return np.array([parameter.nuisance for parameter in parameters], dtype=bool)


def stated_pulls(parameters: Sequence[Parameter], z: RealArray) -> RealArray:
    """Return the pulls of all stated quantities, shape (k,)."""
    return np.asarray(z[_nuisances(parameters)])


def nuisance_p_value(parameters: Sequence[Parameter], z: RealArray) -> float:
    """Return the probability that all stated quantities together are as far off by chance as at `z`.

    This is tested apart from the misfit: beside hundreds of data even an error of many standard deviations in one
    stated quantity would go unnoticed.

    Parameters
    ----------
    parameters : sequence of Parameter
        Those marked as nuisances count.
    z : array, shape (n,)
        Standard normal coordinates.
    """
    pulls = stated_pulls(parameters, z)
    return exceeding(float(pulls @ pulls), len(pulls)) if len(pulls) else 1.0


def largest_pulls(parameters: Sequence[Parameter], z: RealArray) -> list[Pull]:
    """Return the pulls beyond three standard deviations, or else the largest pull alone; the largest first."""
    pulls = [
        Pull(parameter, float(value))
        for parameter, value, is_nuisance in zip(parameters, z, _nuisances(parameters), strict=True)
        if is_nuisance
    ]
    pulls.sort(key=lambda pull: -abs(pull.deviations))
    return [pull for pull in pulls if abs(pull.deviations) > _FAR] or pulls[:1]
