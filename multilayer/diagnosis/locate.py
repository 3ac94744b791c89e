"""Localisation of the gap: which quantity, band and configuration.

Matched filters, with a Monte Carlo test of the largest (the look-elsewhere effect: E. Gross & O. Vitells, Eur. Phys. J.
C 70 (2010) 525-530).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.special import ndtri

from multilayer.arrays import RealArray
from multilayer.experiments.hypothesis import Hypothesis
from multilayer.inference.problem import Minimum

_BANDS = 4  # per configuration
_DRAWS = 2000
_MOST_PLACES = 12
_CHANCE = 0.01
_NOTHING = 1e-9  # share of a template's square that rounding leaves of what the unknowns take up


@dataclass(frozen=True)
class Place:
    """A template, and how significant the residual is along it.

    Attributes
    ----------
    quantity : str
        One of the hypothesis' quantities, as level and phase.
    configuration : str
    band_hz : (low, high)
    significance : float
        Standard deviations, signed: positive where the measurement is larger than the model.
    """

    quantity: str
    configuration: str
    band_hz: tuple[float, float]
    significance: float

    def to_dict(self, limit: float) -> dict[str, Any]:
        """Return the entry of ``diagnosis.json``."""
        more = "above" if self.significance > 0 else "below"
        beyond = "" if abs(self.significance) > limit else "; no more than chance among so many places"
        return {
            "quantity": self.quantity,
            "configuration": self.configuration,
            "band_hz": [round(f, 1) for f in self.band_hz],
            "significance": round(abs(self.significance), 2),
            "note": f"measured {self.quantity} {more} the model{beyond}",
        }


def _templates(hypothesis: Hypothesis) -> list[tuple[str, str, tuple[float, float], RealArray]]:
    """Return whitened unit steps of the quantities, by configuration and band."""
    units = hypothesis.part_units
    total = sum(len(units) * len(data.frequency) for data in hypothesis.data)
    templates, first = [], 0
    for i, data in enumerate(hypothesis.data):
        n, f = len(data.frequency), data.frequency
        edges = np.quantile(np.log(f), np.linspace(0, 1, min(_BANDS, len(data.centres)) + 1))
        for low, high in pairwise(edges):
            inside = ((np.log(f) >= low) & (np.log(f) <= high)).astype(float)
            for quantity, unit in zip(hypothesis.quantities, units, strict=True):
                column = np.zeros(total)
                column[first : first + len(units) * n] = hypothesis.experiments[i].whiten(unit * inside)
                templates.append((quantity, data.name, (float(np.exp(low)), float(np.exp(high))), column))
        first += len(units) * n
    return templates


def locate(hypothesis: Hypothesis, minimum: Minimum, seed: int = 0) -> tuple[list[Place], float]:
    """Return the places of the gap, the most significant first, and the significance that chance reaches.

    The significance along a template d is ``t = d^T C^-1 r / sqrt(d^T C^-1 d)``, C being the covariance of noise and of
    all unknowns, linearised. The second number is exceeded by the largest of all templates in one of a hundred data
    sets without a gap. Templates of which the unknowns leave nothing cannot be seen, and are left out.
    """
    templates = _templates(hypothesis)
    columns = np.stack([t[-1] for t in templates], axis=1)
    jacobian = minimum.jacobian
    # residuals at the priors' means: the uncertainty of the unknowns is part of the covariance
    residual = minimum.residual - jacobian @ minimum.z
    inner = np.linalg.inv(minimum.precision)

    def weighted(values: RealArray) -> RealArray:
        return np.asarray(values - jacobian @ (inner @ (jacobian.T @ values)))

    left = np.sum(columns * weighted(columns), axis=0)
    is_seen = left > _NOTHING * np.sum(columns**2, axis=0)
    templates = [template for template, seen in zip(templates, is_seen, strict=True) if seen]
    columns, norms = columns[:, is_seen], np.sqrt(left[is_seen])
    # residuals are modelled minus measured
    scores = -(columns.T @ weighted(residual)) / norms
    rng = np.random.default_rng(seed)
    draws = rng.standard_normal((len(residual), _DRAWS)) + jacobian @ rng.standard_normal((jacobian.shape[1], _DRAWS))
    largest = np.max(np.abs(columns.T @ weighted(draws)) / norms[:, None], axis=0, initial=0.0)
    limit = float(np.quantile(largest, 1 - _CHANCE))
    places = [Place(q, name, band, float(s)) for (q, name, band, _), s in zip(templates, scores, strict=True)]
    return sorted(places, key=lambda place: -abs(place.significance)), max(limit, float(ndtri(1 - _CHANCE)))


def where_entries(places: list[Place], limit: float) -> list[dict[str, Any]]:
    """Return the entries of ``where``: those beyond chance, at least one, at most twelve."""
    beyond = [place for place in places if abs(place.significance) > limit] or places[:1]
    return [place.to_dict(limit) for place in beyond[:_MOST_PLACES]]
