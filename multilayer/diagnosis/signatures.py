"""What effects look like in the data: which look alike, which the unknowns absorb, which could be seen at all."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.thresholds import DETECTED
from multilayer.inference.problem import Minimum


def signature(nominal: Fitted, effect: BaseEffect) -> RealArray:
    """Return what an effect of its prior's median size does to the whitened residuals, shape (n_data,).

    Signed parameters are taken at one standard deviation.
    """
    hypothesis = nominal.hypothesis.with_effects(effect)
    z = np.concatenate([nominal.minimum.z, [1.0 if p.prior.normal else 0.0 for p in effect.parameters]])
    return np.asarray(hypothesis.residual(z) - nominal.hypothesis.residual(nominal.minimum.z))


def inner_products(minimum: Minimum, columns: RealArray) -> tuple[RealArray, RealArray]:
    """Return cosines of columns (n_data, k) in the metric of noise and unknowns, and the share of each that is left.

    ``|d|`` in the metric of noise and unknowns over ``|d|`` in that of noise alone: below 0.1 the unknowns absorb it.
    """
    jacobian = minimum.jacobian
    weighted = columns - jacobian @ np.linalg.solve(minimum.precision, jacobian.T @ columns)
    gram = columns.T @ weighted
    norms = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    bare = np.sqrt(np.maximum(np.sum(columns**2, axis=0), 1e-300))
    return np.asarray(gram / np.outer(norms, norms)), np.asarray(norms / bare)


def detectable(nominal: Fitted, effects: Mapping[str, BaseEffect], columns: RealArray) -> dict[str, dict[str, object]]:
    """Return the smallest size of each effect that this campaign would show, in the unit of its first parameter.

    Where the signature of the effect, taken as proportional to that parameter, is `DETECTED` standard deviations.
    """
    jacobian, precision = nominal.minimum.jacobian, nominal.minimum.precision
    weighted = columns - jacobian @ np.linalg.solve(precision, jacobian.T @ columns)
    strength = np.sqrt(np.maximum(np.sum(columns * weighted, axis=0), 1e-300))
    found: dict[str, dict[str, object]] = {}
    for (name, effect), size in zip(effects.items(), strength, strict=True):
        if not effect.parameters:
            continue
        first = effect.parameters[0]
        value = float(first.prior.value(np.asarray(1.0 if first.prior.normal else 0.0)))
        found[name] = {
            "parameter": first.name,
            "smallest": float(f"{abs(value) * DETECTED / size:.3g}"),
            "unit": first.unit,
        }
    return found
