"""Signatures of effects in the data: which are alike, which the unknowns absorb, and which could be detected."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from functools import partial

import numpy as np
from scipy.optimize import brentq

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.result import Similarity
from multilayer.diagnosis.thresholds import DETECTED
from multilayer.executors import run_all
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Minimum

_NEXT_TO_NOTHING = 1e-9  # of a usual size
_POSITIVE = np.arange(-4.0, 5.0)  # coordinates of sizes above 0 between which the first one that shows is sought ...
_SIGNED = np.array([1.0, 2.0, 4.0, 8.0])  # ... and of sizes of either sign; those of usual sizes among them
_INVISIBLE = 1e-9  # standard deviations
_CLOSE = 1e-3  # of a coordinate, or of the logarithm of one


def signatures(nominal: Fitted, effects: Mapping[str, BaseEffect], executor: Executor | None = None) -> RealArray:
    """Return the changes of the whitened residuals by effects of usual size, shape (n_data, n_effects).

    Positive parameters are at the median of their prior, signed ones at one standard deviation.
    """
    columns = run_all(partial(_signature, nominal), [*effects.values()], executor)
    return np.stack(columns, axis=1) if columns else np.empty((len(nominal.minimum.residual), 0))


def _signature(nominal: Fitted, effect: BaseEffect) -> RealArray:
    hypothesis = nominal.hypothesis.with_effects(effect)
    z = np.concatenate([nominal.minimum.z, effect.usual])
    return np.asarray(hypothesis.residual(z) - nominal.hypothesis.residual(nominal.minimum.z))


def similarity(minimum: Minimum, names: tuple[str, ...], columns: RealArray) -> Similarity:
    """Return cosines of signatures, shape (n_data, k), and the share of each that the unknowns do not absorb.

    The metric is the inverse covariance of noise and unknowns, ``(1 + J J^T)^-1``. A share is the length of a signature
    in this metric over its length by noise alone.
    """
    gram = columns.T @ _weighted(minimum, columns)
    norms = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    noise_norms = np.sqrt(np.maximum(np.sum(columns**2, axis=0), 1e-300))
    return Similarity(names, np.asarray(gram / np.outer(norms, norms)), np.asarray(norms / noise_norms))


def detectable_sizes(
    nominal: Fitted, effects: Mapping[str, BaseEffect], columns: RealArray, executor: Executor | None = None
) -> dict[str, dict[str, object]]:
    """Return the size of the smallest effect of each kind that these data would show, in its first parameter's unit.

    What the first parameter changes there, from where the effect is absent and with the others at their usual size, is
    `DETECTED` standard deviations. The effect `shows` from that size on or, where it vanishes at large values, up to
    it; `smallest` is None where it shows at no size. Effects whose first parameter is no size (`Effect.aside`) are left
    out.

    Parameters
    ----------
    nominal : Fitted
    effects : mapping
        By name.
    columns : array, shape (n_data, n_effects)
        Their `signatures`.
    executor : Executor, optional
        Where sizes are sought; in this process when left out.
    """
    tasks = {
        name: (effect, column)
        for (name, effect), column in zip(effects.items(), columns.T, strict=True)
        if effect.parameters and effect.parameters[0].name not in effect.aside
    }
    sizes = run_all(partial(_detectable_size, nominal), [*tasks.values()], executor)
    return dict(zip(tasks, sizes, strict=True))


def _detectable_size(nominal: Fitted, task: tuple[BaseEffect, RealArray]) -> dict[str, object]:
    """Return the entry of an effect, given its signature."""
    effect, column = task
    first, usual, z = effect.parameters[0], effect.usual, nominal.minimum.z
    prior, hypothesis = first.prior, nominal.hypothesis.with_effects(effect)
    bare = nominal.hypothesis.residual(z)[:, None]
    # sizes of either sign are sought by the logarithm of their coordinate: what they change is about as large
    is_signed = prior.normal is not None and not prior.normal[0]
    tried = np.log(_SIGNED) if is_signed else _POSITIVE

    def changes(at: RealArray) -> RealArray:
        points = np.tile(np.concatenate([z, usual]), (len(at), 1))
        points[:, len(z)] = np.exp(at) if is_signed else at
        return np.asarray(hypothesis.residual(points).T - bare)

    def excess(at: RealArray) -> RealArray:
        return np.log(np.fmax(_length(nominal.minimum, changes(at) - at_absent), _INVISIBLE) / DETECTED)

    known = 0.0 if is_signed else usual[0]
    absent, at_absent = _stated_absence(effect, first), np.zeros_like(bare)
    if absent is not None:
        nearer, farther = excess(np.array([tried.max(), tried.min()] if absent > known else [tried.min(), tried.max()]))
        if nearer > 0 > farther:  # as of a frame that moves already: it is at rest there, and as stated without springs
            absent = None
    if absent is None:
        size = prior.coordinate(_NEXT_TO_NOTHING * prior.value(usual[0]))
        absent = float(np.log(size) if is_signed else size)
        at_absent = changes(np.array([absent]))
    outward = 1.0 if known > absent else -1.0
    tried = outward * np.sort(outward * tried)
    tried = tried[outward * (tried - absent) > 0]
    if _length(nominal.minimum, column[:, None] - at_absent)[0] > DETECTED:
        tried = tried[outward * (tried - known) <= 0]  # a larger size need not be tried
    visible = np.flatnonzero(excess(tried) > 0)
    smallest = None
    if visible.size:
        low, high = np.append(absent, tried)[visible[0] : visible[0] + 2]
        if excess(np.array([low]))[0] < 0:  # far from any minimum a size next to nothing shows as well: none is told
            found = brentq(lambda at: excess(np.array([at]))[0], low, high, xtol=_CLOSE)
            smallest = abs(float(prior.value(np.exp(found) if is_signed else found)))
    return {
        "parameter": first.name,
        "smallest": None if smallest is None else float(f"{smallest:.3g}"),
        "unit": first.unit,
        "shows": "from" if outward > 0 else "up to",
    }


def _stated_absence(effect: BaseEffect, parameter: Parameter) -> float | None:
    """Return the coordinate at which an effect states that it vanishes, if it does."""
    value = effect.absent.get(parameter.name)
    return None if value is None else float(parameter.prior.coordinate(value))


def _length(minimum: Minimum, columns: RealArray) -> RealArray:
    """Return the lengths of changes in the metric of noise and unknowns, shape (k,)."""
    return np.asarray(np.sqrt(np.maximum(np.sum(columns * _weighted(minimum, columns), axis=0), 0.0)))


def _weighted(minimum: Minimum, columns: RealArray) -> RealArray:
    """Return ``(1 + J J^T)^-1`` times columns."""
    jacobian = minimum.jacobian
    return np.asarray(columns - jacobian @ np.linalg.solve(minimum.precision, jacobian.T @ columns))
