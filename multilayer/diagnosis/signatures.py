"""Signatures of effects in the data: which are alike, which the unknowns absorb, and which could be detected."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from functools import partial

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.result import Similarity
from multilayer.diagnosis.thresholds import DETECTED
from multilayer.executors import run_all
from multilayer.inference.problem import Minimum


def signatures(nominal: Fitted, effects: Mapping[str, BaseEffect], executor: Executor | None = None) -> RealArray:
    """Return the changes of the whitened residuals by effects of usual size, shape (n_data, n_effects).

    Positive parameters are at the median of their prior, signed ones at one standard deviation.
    """
    columns = run_all(partial(_signature, nominal), [*effects.values()], executor)
    return np.stack(columns, axis=1) if columns else np.empty((len(nominal.minimum.residual), 0))


def _signature(nominal: Fitted, effect: BaseEffect) -> RealArray:
    hypothesis = nominal.hypothesis.with_effects(effect)
    z = np.concatenate([nominal.minimum.z, [1.0 if p.prior.normal else 0.0 for p in effect.parameters]])
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
    nominal: Fitted, effects: Mapping[str, BaseEffect], columns: RealArray
) -> dict[str, dict[str, object]]:
    """Return the smallest size of each effect that these data would show, in the unit of its first parameter.

    At this size the signature, taken as proportional to that parameter, is `DETECTED` standard deviations.
    """
    strength = np.sqrt(np.maximum(np.sum(columns * _weighted(nominal.minimum, columns), axis=0), 1e-300))
    sizes: dict[str, dict[str, object]] = {}
    for (name, effect), size in zip(effects.items(), strength, strict=True):
        if not effect.parameters:
            continue
        first = effect.parameters[0]
        value = float(first.prior.value(np.asarray(1.0 if first.prior.normal else 0.0)))
        sizes[name] = {
            "parameter": first.name,
            "smallest": float(f"{abs(value) * DETECTED / size:.3g}"),
            "unit": first.unit,
        }
    return sizes


def _weighted(minimum: Minimum, columns: RealArray) -> RealArray:
    """Return ``(1 + J J^T)^-1`` times columns."""
    jacobian = minimum.jacobian
    return np.asarray(columns - jacobian @ np.linalg.solve(minimum.precision, jacobian.T @ columns))
