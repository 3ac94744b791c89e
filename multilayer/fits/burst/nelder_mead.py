"""The minimisation of Bonfiglio & Pompoli 2015 to the letter: envelopes in time, Nelder-Mead, bounded (E1, E2)."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from multilayer.arrays import RealArray
from multilayer.experiments.two_plate.burst import BurstProblem
from multilayer.inference.problem import Minimum
from multilayer.signals.envelope import envelope
from multilayer.signals.time_of_flight import time_of_flight


def envelope_cost(problem: BurstProblem, x: RealArray) -> float:
    """Return eq. (9): the sum over time of the distance between both envelopes, m/s2.

    Each envelope is shifted to the left by its own (whole-sample) time of flight.
    """
    data = problem.data
    signal = problem.signal(x)
    shifted = [_advanced(envelope(top), _samples(problem, top)) for top in (data.top, signal)]
    length = min(len(part) for part in shifted)
    return float(np.sum(np.abs(shifted[0][:length] - shifted[1][:length])))


def _samples(problem: BurstProblem, top: RealArray) -> int:
    data = problem.data
    delay = time_of_flight(data.base, top, data.sampling_rate, subsample=False)
    return round(float(delay) * data.sampling_rate)


def _advanced(values: RealArray, samples: int) -> RealArray:
    if samples >= 0:
        return values[samples:]
    return np.concatenate([np.zeros(-samples), values])


def minimise_envelope_cost(problem: BurstProblem, start: RealArray, low: RealArray, high: RealArray) -> Minimum:
    """Return the minimum of eq. (9) over (E1, E2) reached from `start`.

    Parameters
    ----------
    problem : BurstProblem
    start, low, high : array, shape (2,)
        (ln E1, E2/E1); the simplex itself lives in (E1, E2), as in the paper, with E2 between the bounds that the
        extreme E1 and loss factors give.

    Notes
    -----
    Lagarias et al., SIAM J. Optim. 9 (1998) 112-147, the paper's reference [15]; the history holds the cost of
    eq. (9).
    """
    history: list[tuple[RealArray, float]] = []

    def cost(moduli: RealArray) -> float:
        x = np.array([np.log(moduli[0]), moduli[1] / moduli[0]])
        history.append((x, envelope_cost(problem, x)))
        return history[-1][1]

    e1 = np.exp(np.clip(start[0], low[0], high[0]))
    bounds = [tuple(np.exp([low[0], high[0]])), (0.0, float(np.exp(high[0]) * high[1]))]
    found = minimize(
        cost,
        [e1, e1 * max(start[1], 0.05)],
        method="Nelder-Mead",
        bounds=bounds,
        options={"xatol": 1e-4 * e1, "fatol": 1e-6 * history_scale(problem), "maxfev": 400},
    )
    x = np.array([np.log(found.x[0]), found.x[1] / found.x[0]])
    residual, slopes = problem.residual_and_jacobian(x)
    return Minimum(
        x, residual, slopes, bool(found.success),
        bool(x[0] <= low[0] or x[0] >= high[0]), tuple(history),
    )  # fmt: skip


def history_scale(problem: BurstProblem) -> float:
    """Return the size of eq. (9) for a model that does not move at all, m/s2."""
    return float(np.sum(problem.data.envelope))
