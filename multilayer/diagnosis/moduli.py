"""The modulus over frequency: of the nominal model, and as what explains the gap corrects it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.special import ndtr

from multilayer.arrays import RealArray
from multilayer.diagnosis.fitting import Fitted
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.inference.consistency import birge_ratio
from multilayer.inference.derivative import Stencil

_TAIL = 0.05  # of 90 % intervals, on each side
_POINTS = 60
_FARTHEST = 9.0  # standard deviations from an explanation's value to where its probability is 0
_HALVINGS = 60


def moduli(nominal: Fitted, explanations: Sequence[tuple[float, Fitted]]) -> dict[str, Any]:
    """Return frequencies, Hz, and E1 and E2, Pa, with 90 % intervals: ``nominal`` and ``corrected``.

    The corrected values are those of the first explanation, the intervals those of all of them, each with its weight:
    J. A. Hoeting et al., Statist. Sci. 14 (1999) 382-417. What an explanation leaves beyond chance widens its own by
    Birge's ratio. NaN where nothing explains the gap: the modulus is not known then.

    Parameters
    ----------
    nominal : Fitted
    explanations : sequence of (float, Fitted)
        With weights, the best first.
    """
    f = np.concatenate([data.frequency for data in nominal.hypothesis.data])
    at = np.geomspace(f.min(), f.max(), _POINTS)
    pairs = (("nominal", [(1.0, nominal)]), ("corrected", explanations))
    return {"frequency_hz": at.tolist(), **{name: _with_band(fits, at) for name, fits in pairs}}


def _with_band(explanations: Sequence[tuple[float, Fitted]], frequency: RealArray) -> dict[str, list[float]]:
    weights = np.array([weight for weight, _ in explanations])
    each = [_logarithms(fitted, frequency) for _, fitted in explanations]
    told: dict[str, list[float]] = {}
    for i, name in enumerate(("E1", "E2")):
        if not each:
            told |= {f"{name}{end}": [float("nan")] * len(frequency) for end in ("", "_low", "_high")}
            continue
        values, spreads = (np.stack([parts[i][j] for parts in each]) for j in (0, 1))
        # of a modulus that is negative there is no logarithm: such rivals count for nothing there
        known = np.isfinite(values) & np.isfinite(spreads)
        known_values, known_spreads = np.where(known, values, values[0]), np.where(known, spreads, spreads[0])
        low, high = (_quantile(known_values, known_spreads, weights, p) for p in (_TAIL, 1 - _TAIL))
        ends = {"": values[0], "_low": low, "_high": high}
        told |= {f"{name}{end}": np.exp(logarithm).tolist() for end, logarithm in ends.items()}
    return told


def _logarithms(fitted: Fitted, frequency: RealArray) -> list[tuple[RealArray, RealArray]]:
    """Return ln E1 and ln E2, each with its standard deviation."""
    minimum = fitted.minimum
    stencil = Stencil.central(minimum.z)
    e = fitted.hypothesis_as(CampaignProblem).own_modulus(stencil.points, frequency)
    covariance = minimum.covariance * birge_ratio(minimum.cost, len(minimum.residual)) ** 2
    found = []
    for part in (e.real, e.imag):
        with np.errstate(invalid="ignore"):
            value, slopes = stencil.linearised(np.log(part))
        found.append((value, np.sqrt(np.einsum("fi,ij,fj->f", slopes, covariance, slopes))))
    return found


def _quantile(means: RealArray, spreads: RealArray, weights: RealArray, probability: float) -> RealArray:
    """Return the quantile of mixtures of normal distributions, shape (n,); means and spreads have the shape (k, n)."""
    low, high = np.min(means - _FARTHEST * spreads, axis=0), np.max(means + _FARTHEST * spreads, axis=0)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        is_below = weights @ ndtr((middle - means) / spreads) < probability * weights.sum()
        low, high = np.where(is_below, middle, low), np.where(is_below, high, middle)
    return np.asarray(0.5 * (low + high))
