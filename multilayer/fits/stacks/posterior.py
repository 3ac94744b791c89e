"""What a fit of stacks leaves known: the unknowns' intervals, and bands of the fitted curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from multilayer.arrays import RealArray
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.experiments.stacks.unknowns import Unknown
from multilayer.fits.stacks.result import parts_of
from multilayer.inference.identifiability import Derived
from multilayer.inference.posterior import Band, Posterior
from multilayer.inference.problem import Minimum, Scaled
from multilayer.inference.summary import PosteriorSummary, Tell, summarise

_DRAWN, _CHECKED = 400, 256
_SLOWLY = 64  # of either, where stacks are solved one by one


def summary_of(
    problem: StackProblem, minima: Sequence[Minimum], scale: float, method: str, tell: Tell | None = None
) -> PosteriorSummary:
    """Return what is known of the unknowns.

    Parameters
    ----------
    problem : StackProblem
    minima : sequence of Minimum
        Of the widened problem.
    scale : float
        By which standard deviations are widened.
    method : {'laplace', 'profile', 'nested'}
    tell : callable, optional
    """
    checked = _SLOWLY if _is_slow(problem) else _CHECKED
    return summarise(
        Scaled(problem, scale), minima, method, derived=law_quantities(problem), checked=checked, tell=tell
    )


def _is_slow(problem: StackProblem) -> bool:
    return any(observation.one_by_one for observation in problem.observations)


def law_quantities(problem: StackProblem) -> list[Derived]:
    """Return the parameters of laws, which may be made up of several coordinates."""
    found, first = [], 0
    for unknown in problem.unknowns:
        own = slice(first, first + len(unknown.parameters))
        first = own.stop
        if unknown.space is not None:
            named = zip(unknown.parameters, unknown.names, unknown.units, strict=True)
            found += [
                Derived(parameter.name, name, unit, parameter.nuisance, partial(_log_of_law, unknown, own, index))
                for index, (parameter, name, unit) in enumerate(named)
            ]
    return found


def _log_of_law(unknown: Unknown, own: slice, index: int, z: RealArray) -> RealArray:
    return np.asarray(np.log(unknown.values(z[..., own])[..., index]))


def curve_bands(problem: StackProblem, z: RealArray, posterior: Posterior) -> list[Band]:
    """Return the 90 % band of every fitted curve, part by part as `parts_of` has it, arrays of shape (n_parts, n)."""
    count = _SLOWLY if _is_slow(problem) else _DRAWN
    few = replace(posterior, samples=posterior.samples[:: max(1, len(posterior.samples) // count)])
    here = [o.scale.shown(response) for o, response in zip(problem.observations, problem.predict(z), strict=True)]

    def parts(points: RealArray) -> list[RealArray]:
        responses = zip(problem.observations, problem.predict(points), here, strict=True)
        return [parts_of(o.kind, o.scale.shown(response), near=at) for o, response, at in responses]

    shapes = [part.shape for part in parts(z)]
    band = few.band(lambda points: np.concatenate([p.reshape(len(points), -1) for p in parts(points)], axis=-1))
    ends = np.cumsum([np.prod(shape) for shape in shapes])[:-1]
    rows = [np.split(end, ends) for end in band]
    return [Band(*(row[i].reshape(shape) for row in rows)) for i, shape in enumerate(shapes)]
