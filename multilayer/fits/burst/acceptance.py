"""The acceptance criteria of Bonfiglio & Pompoli 2015, eq. (10)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.experiments.two_plate.burst import BurstProblem

_NEWTON_STEPS = 8
_ROUNDING = 1 + 1e-9  # one whole sample is one whole sample


@dataclass(frozen=True)
class Criteria:
    """Largest differences that an accepted solution may leave.

    Attributes
    ----------
    time_of_flight : float
        s.
    level_db : float
        dB.
    """

    time_of_flight: float
    level_db: float

    def excess(self, delta_tof: RealArray | float, delta_level_db: RealArray | float) -> RealArray:
        """Return the larger of the two differences in units of what is allowed; accepted up to 1."""
        return np.maximum(np.abs(delta_tof) / self.time_of_flight, np.abs(delta_level_db) / self.level_db)

    def reason(self, delta_tof: float, delta_level_db: float) -> str:
        """Say why a solution is not accepted; empty when it is."""
        parts = []
        if not abs(delta_tof) <= self.time_of_flight * _ROUNDING:
            parts.append(f"time of flight off by {delta_tof * 1e6:+.0f} us (allowed {self.time_of_flight * 1e6:.0f})")
        if not abs(delta_level_db) <= self.level_db * _ROUNDING:
            parts.append(f"level off by {delta_level_db:+.2f} dB (allowed {self.level_db:g})")
        return ", ".join(parts)


def discrepancies_in_band(
    problem: BurstProblem, x: RealArray, *, whole_samples: bool = False
) -> tuple[RealArray, RealArray]:
    """Return the differences of eq. (10) for many solutions at once, from the burst's band alone.

    Noise beside the band, and what it makes the model do, thus counts in neither of them.

    Parameters
    ----------
    problem : BurstProblem
    x : array, shape (..., 2)
    whole_samples : bool
        Round both times of flight to samples, as in the paper.

    Returns
    -------
    delta_tof, delta_level_db : array, shape (...)
        Measured minus modelled, s and dB. The delay is that of the correlation peak of the model nearest to the
        measured one: of two peaks equally high, a period apart, neither is wrong.
    """
    measured, modelled, level = _in_band(problem, x)
    if whole_samples:
        rate = problem.data.sampling_rate
        measured, modelled = np.round(measured * rate) / rate, np.round(modelled * rate) / rate
    return np.asarray(measured - modelled), level


def excess_in_band(
    problem: BurstProblem, x: RealArray, criteria: Criteria, *, whole_samples: bool = False
) -> RealArray:
    """Return what `Criteria.excess` says of many solutions, as a continuous function of them, shape (...).

    In whole samples a delay is accepted when it rounds to one that is: to half a sample beyond, measured from the whole
    sample that the measured one rounds to.
    """
    measured, modelled, level = _in_band(problem, x)
    if whole_samples:
        rate = problem.data.sampling_rate
        measured = np.round(measured * rate) / rate
        samples = np.floor(criteria.time_of_flight * rate * _ROUNDING) + 0.5
        criteria = replace(criteria, time_of_flight=float(samples / rate))
    return criteria.excess(np.asarray(measured - modelled), level)


def _in_band(problem: BurstProblem, x: RealArray) -> tuple[RealArray, RealArray, RealArray]:
    """Return both times of flight (s), and the level of the measured over the modelled top (dB)."""
    f, base, top = problem.data.local
    predicted = problem.predict(x)
    level = 10 * np.log10(np.vdot(top, top).real / np.sum(np.abs(predicted) ** 2, axis=-1))
    start = problem.data.time_of_flight
    measured = _peak_near(start, f, top * np.conj(base))
    return measured, _peak_near(np.full(predicted.shape[:-1], start), f, predicted * np.conj(base)), np.asarray(level)


def _peak_near(start: RealArray | float, frequency: RealArray, cross: ComplexArray) -> RealArray:
    """Return the delay of the correlation's peak nearest to `start`, by its phase at the burst's mean frequency."""
    omega = 2 * np.pi * frequency
    tau = np.asarray(start, dtype=float)
    for _ in range(_NEWTON_STEPS):
        turned = cross * np.exp(1j * omega * tau[..., None])
        slope = np.sum(-omega * turned.imag, axis=-1)
        curvature = np.sum(omega**2 * turned.real, axis=-1)
        # never less than a share of its bound: a step stays within the peak, even where phases spread
        floor = 0.3 * np.sum(omega**2 * np.abs(turned), axis=-1)
        tau = tau + slope / np.maximum(curvature, floor)
    return tau
