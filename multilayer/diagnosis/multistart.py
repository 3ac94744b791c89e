"""Valleys of a hypothesis, sought all over the prior: of gaps that hide what the nominal model's unknowns are."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from functools import partial
from typing import TypeVar

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import Effect
from multilayer.diagnosis.fitting import ROUGHLY, Fitted, at_minimum, best_of, starting_points
from multilayer.diagnosis.hypothesis import Hypothesis, rig_hypothesis
from multilayer.executors import call, run_all
from multilayer.inverse.least_squares import descend, draw_prior, in_pieces

K = TypeVar("K")
# by how much each datum may be off, relative, descents that go on with it, and their steps
_STAGES = ((0.3, 32, 12), (0.06, 12, 12), (0.015, 6, 15))
_FINISHED = 2  # valleys whose floor is sought
# where starts are: resonances over the band, how many moduli, angles of loss, points of laws they are chosen from
_AROUND, _LEVELS, _ANGLES, _LAWS = (0.3, 4.0), 20, (0.08, 0.24, 0.47, 0.79, 1.1), 4096
_NEAR_LEVEL, _NEAR_ANGLE, _LIKELY = 0.5, 0.15, 0.02  # what counts as near a level and an angle; against odd laws
_LOST = 2.0  # times the misfit that chance makes: of campaigns that nothing explains
_APART = 0.5  # rms of what residuals differ by: descents that end nearer have found the same


def scattered(hypothesis: Hypothesis) -> RealArray:
    """Return coordinates of the nominal model all over its prior, shape (m, d); what is stated is as stated.

    Laws whose moduli and losses are evenly spread where the sample's resonance may lie. To choose starts by a law's own
    parameters is of little use: what a campaign sees of it first is how stiff and how lossy the sample is in the middle
    of the band.
    """
    joint, f = hypothesis.joint, np.concatenate([data.frequency for data in hypothesis.data])
    stiff = []
    for setting in hypothesis.settings:
        height = setting.configuration.specimen_thickness
        stiff.append((setting.plate_mass / setting.area + hypothesis.campaign.specimen.density * height / 3) * height)
    slow, fast = 2 * np.pi * _AROUND[0] * f.min(), 2 * np.pi * _AROUND[1] * f.max()
    levels = np.linspace(np.log(slow**2 * min(stiff)), np.log(fast**2 * max(stiff)), _LEVELS)
    laws = draw_prior(len(joint.law_parameters), _LAWS, 0)
    e = joint.space.modulus(joint.law_coordinates(laws), np.array([np.sqrt(f.min() * f.max())]))[:, 0]
    off = (
        ((np.log(np.abs(e)) - levels[:, None, None]) / _NEAR_LEVEL) ** 2
        + ((np.angle(e) - np.array(_ANGLES)[:, None]) / _NEAR_ANGLE) ** 2
        + _LIKELY * np.sum(laws**2, axis=-1)
    )
    chosen = laws[np.unique(np.argmin(off, axis=-1))]
    return np.concatenate([chosen, np.zeros((len(chosen), len(joint.parameters) - chosen.shape[1]))], axis=1)


def valleys(hypothesis: Hypothesis, first: RealArray, own: RealArray) -> RealArray:
    """Return where the data can be explained roughly, coordinates of shape (k, d), the best first.

    What is added to a reading may bury it: of a rocking plate's resonance the nominal model makes one of the sample,
    and from there no descent leads back. So an effect is sought with unknowns all over their prior, by continuation:
    each datum may be off by some more, much at first, and differences count as `Hypothesis.bounded` has them. What the
    laboratory states is taken as stated.

    Parameters
    ----------
    hypothesis : Hypothesis
    first : array, shape (m, n)
        Starts of the parameters but the last ones.
    own : array, shape (p, k)
        Starts of the last ones; each goes with each of the others.
    """
    coarse = hypothesis.thinned
    free = [i for i, parameter in enumerate(hypothesis.parameters) if not parameter.nuisance]
    grid = np.zeros((len(first), len(own), len(hypothesis.parameters)))
    grid[:, :, : first.shape[1]], grid[:, :, first.shape[1] :] = first[:, None], own
    points = grid.reshape(-1, grid.shape[-1])[:, free]
    residual = _rough(coarse, free, _STAGES[0][0])
    costs = np.sum(in_pieces(residual, points) ** 2, axis=-1) + np.sum(points**2, axis=-1)
    points = points[_promising(np.nan_to_num(costs, nan=np.inf).reshape(len(first), len(own)), _STAGES[0][1])]
    for size, kept, steps in _STAGES:
        residual = _rough(coarse, free, size)
        points = _distinct(residual, *descend(residual, points[:kept], steps))
    found = np.zeros((len(points), len(hypothesis.parameters)))
    found[:, free] = points
    return found


def _rough(hypothesis: Hypothesis, free: list[int], size: float) -> Callable[[RealArray], RealArray]:
    """Return the residuals of free coordinates, shape (m, k), each datum being allowed to be off by some more."""
    spread = [np.sqrt(data.variance + size**2) for data in hypothesis.data]

    def residual(points: RealArray) -> RealArray:
        z = np.zeros((len(points), len(hypothesis.parameters)))
        z[:, free] = points
        logs = hypothesis.log_ratios(z)
        parts = [hypothesis.bounded(values) / width for values, width in zip(logs, spread, strict=True)]
        return np.concatenate([part.view(float) for part in parts], axis=-1)

    return residual


def _promising(costs: RealArray, most: int) -> list[int]:
    """Return flat indices of a table (m, k) of costs: the best of rows and of columns, no two of the same."""
    k = costs.shape[1]
    rows = [int(i) * k + int(np.argmin(costs[i])) for i in np.argsort(costs.min(axis=1), kind="stable")]
    columns = [int(np.argmin(costs[:, j])) * k + int(j) for j in np.argsort(costs.min(axis=0), kind="stable")]
    return list(dict.fromkeys([*rows[: most - most // 3], *columns[: most // 3]]))


def _distinct(residual: Callable[[RealArray], RealArray], points: RealArray, costs: RealArray) -> RealArray:
    """Return the points that explain the data differently, that of the lowest cost first."""
    values = residual(points)
    kept: list[int] = []
    for i in np.argsort(costs, kind="stable"):
        if np.isfinite(costs[i]) and all(np.mean((values[i] - values[j]) ** 2) > _APART**2 for j in kept):
            kept.append(int(i))
    return points[kept]


def is_lost(nominal: Fitted, fits: Iterable[Fitted]) -> bool:
    """Tell whether a gap is there that nothing explains which has been tried."""
    least = min((one.minimum.cost for one in (nominal, *fits)), default=0.0)
    return least > _LOST * len(nominal.minimum.residual)


def valleys_with(fitted: Fitted, effect: Effect) -> list[Callable[[], Fitted]]:
    """Return the fits with one more effect, not done yet, from the valleys of the whole prior.

    Parameters
    ----------
    fitted : Fitted
        The nominal model, or effects whose sizes are kept for a start.
    effect : Effect
    """
    before = rig_hypothesis(fitted.hypothesis)
    n = len(before.nominal_parameters)
    laws = scattered(before)
    sizes = np.broadcast_to(fitted.minimum.z[n:], (len(laws), len(fitted.minimum.z) - n))
    first = np.concatenate([np.concatenate([laws, sizes], axis=1), fitted.minimum.z[None]])
    hypothesis = before.with_effects(*before.effects, effect)
    own = np.stack(starting_points(hypothesis, len(effect.parameters)))
    return [partial(at_minimum, hypothesis, z, *ROUGHLY) for z in valleys(hypothesis, first, own)[:_FINISHED]]


def improved(
    fits: Mapping[K, Fitted],
    sought: Mapping[K, Callable[[], list[Callable[[], Fitted]]]],
    executor: Executor | None = None,
) -> dict[K, Fitted]:
    """Return fits, or better ones of the same hypotheses from what `valleys_with` gives.

    Parameters
    ----------
    fits : mapping
    sought : mapping
        By the keys of some of them; calls of `valleys_with`.
    executor : Executor, optional
        Where fits run; in this process when left out.
    """
    ends = dict(zip(sought, run_all(call, [*sought.values()], executor), strict=True))
    tasks = [(key, end) for key, own in ends.items() for end in own]
    best = dict(fits)
    for (key, _), end in zip(tasks, run_all(call, [end for _, end in tasks], executor), strict=True):
        best[key] = best_of([best[key], end])
    return best
