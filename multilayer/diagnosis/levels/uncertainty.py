"""What measurements of sound insulation and absorption are worth, by band.

ISO 12999-1:2020, table 2: airborne sound insulation; ISO 12999-2:2020, table 1: absorption in reverberation rooms.
Repeatability is that of one team with its equipment in the same rooms; in situ, of other teams there; reproducibility,
of other laboratories. What goes beyond repeatability is alike in neighbouring bands: rooms, mounting, edges.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from multilayer.arrays import RealArray

Situation = Literal["repeatability", "in_situ", "reproducibility"]

_BANDS = np.array([
    50.0, 63.0, 80.0, 100.0, 125.0, 160.0, 200.0, 250.0, 315.0, 400.0, 500.0,
    630.0, 800.0, 1000.0, 1250.0, 1600.0, 2000.0, 2500.0, 3150.0, 4000.0, 5000.0,
])  # fmt: skip
_INSULATION: dict[Situation, list[float]] = {  # dB
    "reproducibility": [6.8, 4.6, 3.8, 3.0, 2.7, 2.4, 2.1, *[1.8] * 10, 1.9, 2.0, 2.4, 2.8],
    "in_situ": [4.0, 3.6, 3.2, 2.8, 2.4, 2.0, 1.8, 1.6, 1.4, 1.2, 1.1, *[1.0] * 6, 1.3, 1.6, 1.9, 2.2],
    "repeatability": [2.0, 1.8, 1.6, 1.4, 1.2, 1.0, 0.9, 0.8, 0.7, *[0.6] * 12],
}
# the standard deviation of reproducibility is m alpha + n; the first band is 63 Hz
_SLOPE = [
    0.45, 0.33, 0.24, 0.18, 0.14, 0.11, 0.09, 0.075, 0.06, 0.05,
    0.045, 0.04, 0.04, 0.04, 0.037, 0.035, 0.03, 0.03, 0.03, 0.026,
]  # fmt: skip
_LEAST = [*[0.015] * 13, 0.016, 0.018, 0.021, 0.026, 0.032, 0.04, 0.06]
_REPEATED = 0.6  # of the reproducibility of absorption is its repeatability


class Spread(NamedTuple):
    """Standard deviations, shape (n,): of what differs from band to band, and of what is alike in neighbouring ones."""

    alone: RealArray
    together: RealArray


def insulation_spread(frequency: RealArray, situation: Situation) -> Spread:
    """Return the standard deviations of transmission losses, dB, at frequencies in Hz of shape (n,).

    Between the bands of the table interpolated in ln f; beyond, those of the last one.
    """
    alone, whole = (_at(frequency, _BANDS, _INSULATION[name]) for name in ("repeatability", situation))
    return Spread(alone, np.sqrt(whole**2 - alone**2))


def absorption_spread(frequency: RealArray, absorption: RealArray, situation: Situation) -> Spread:
    """Return the standard deviations of absorption coefficients of a reverberation room; in situ there are none."""
    slope, least = (_at(frequency, _BANDS[1:], values) for values in (_SLOPE, _LEAST))
    whole = slope * np.maximum(absorption, 0.0) + least
    alone = _REPEATED * whole
    return Spread(alone, np.zeros_like(alone) if situation == "repeatability" else np.sqrt(whole**2 - alone**2))


def _at(frequency: RealArray, bands: RealArray, values: list[float]) -> RealArray:
    return np.asarray(np.interp(np.log(frequency), np.log(bands), values))
