"""Fits that start all over the prior: of gaps that hide what the nominal model's unknowns are."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from functools import partial

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.fitting import Begun, Fitted, begin_eased, starting_points
from multilayer.diagnosis.interface import AnyHypothesis
from multilayer.executors import call, run_all
from multilayer.inverse.least_squares import draw_prior
from multilayer.inverse.problem import Minimum

_LOST = 20.0  # times the misfit that chance makes: of campaigns that no effect comes near to explaining
_POINTS = 64  # of the prior of the nominal model's unknowns, each with every start of the effect
_FOLLOWED = 4  # starts, and of these ...
_FINISHED = 2
_BEHIND = 10.0  # times the least misfit after the first steps: of one that is given up
_CHUNK = 256  # points that are looked at together
_REACH = 2.3  # standard deviations, to which points of the prior are kept


def sought_afresh(
    nominal: Fitted,
    found: Mapping[tuple[str, ...], Fitted],
    effects: Mapping[str, BaseEffect],
    executor: Executor | None = None,
) -> dict[tuple[str, ...], Fitted]:
    """Return the fits of effects one by one, those of the lost found again.

    What is added to a reading may bury it: of a rocking plate's resonance the nominal model makes one of the sample,
    and from there no descent leads back. Where no effect comes near to explaining the gap, each is tried with unknowns
    all over their prior. What counts is then by how much the logarithm of the ratio is off, whatever the noise:
    standard deviations differ by a hundred from the middle of a burst's band to its edge, and starts by more than any.

    Parameters
    ----------
    nominal : Fitted
    found : mapping
        Fits of the effects, by their names.
    effects : mapping
        Those to be tried, by name.
    executor : Executor, optional
        Where fits run; in this process when left out.
    """
    least = min((one.minimum.cost for one in found.values()), default=0.0)
    if not effects or least < _LOST * len(nominal.minimum.residual):
        return dict(found)
    tasks = {
        (name,): partial(_begin, nominal.hypothesis.with_effects(effect), nominal.minimum)
        for name, effect in effects.items()
    }
    begun = dict(zip(tasks, run_all(call, [*tasks.values()], executor), strict=True))
    least = min(min(one.costs) for one in begun.values())
    going = [(names, end) for names, one in begun.items() if min(one.costs) < _BEHIND * least for end in one.ends]
    best = dict(found)
    for (names, _), fitted in zip(going, run_all(call, [end for _, end in going], executor), strict=True):
        if fitted.log_evidence > best[names].log_evidence:
            best[names] = fitted
    return best


def _begin(hypothesis: AnyHypothesis, nominal: Minimum) -> Begun:
    """Return the first steps from the starts whose ratios are least off; what is stated is taken as stated."""
    n = len(nominal.z)
    free = [i for i, parameter in enumerate(hypothesis.parameters[:n]) if not parameter.nuisance]
    own = np.stack(starting_points(hypothesis, len(hypothesis.parameters) - n))
    grid = np.zeros((_POINTS, len(own), len(hypothesis.parameters)))
    grid[:, :, free] = np.clip(draw_prior(len(free), _POINTS, 0), -_REACH, _REACH)[:, None]
    grid[:, :, n:] = own
    points = grid.reshape(-1, grid.shape[-1])
    off = [_off(hypothesis, points[i : i + _CHUNK]) for i in range(0, len(points), _CHUNK)]
    best = points[np.argsort(np.concatenate(off))[:_FOLLOWED]]
    return begin_eased(hypothesis, best, nominal.cost / len(nominal.residual), _FINISHED)


def _off(hypothesis: AnyHypothesis, points: RealArray) -> RealArray:
    """Return the mean square of the difference of ln(ratio), shape (m,); infinite where there is no response."""
    difference = np.concatenate(hypothesis.log_ratios(points), axis=-1)
    return np.asarray(np.nan_to_num(np.mean(np.abs(difference) ** 2, axis=-1), nan=np.inf))
