"""Several solutions that fit one burst alike: finding them, and choosing by the other bursts of the same material."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from multilayer.arrays import RealArray
from multilayer.experiments.two_plate.burst import BurstProblem
from multilayer.inference.least_squares import distinct, trust_region
from multilayer.inference.multistart import lowest_on_grid
from multilayer.inference.problem import Minimum

_LOSS_GRID = np.array([0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.5])
_MODULUS_STEP = 0.1  # of ln E1: half the width of a resonance with loss factor 0.1
_GRID_BINS = 10
_REFINED = 6  # valleys looked into
_GLANCE, _PATIENCE = 6, 60  # evaluations for a first look, and for the promising ones
_PROMISING, _HOPELESS = (
    10.0,
    0.3,
)  # misfits, relative to the best and absolute, within which a valley is followed
_APART = np.array([0.01, 0.02])
_STEPS = np.array([0.1, 0.05])


@dataclass(frozen=True)
class Candidates:
    """The minima of one burst, best first, and how many of them the data cannot tell apart."""

    minima: list[Minimum]
    plausible: int


@dataclass(frozen=True)
class Choice:
    """The branch taken for one burst.

    Attributes
    ----------
    minimum : Minimum
    by_neighbours : bool
        Whether other bursts had to decide.
    unresolved : bool
        Whether nothing could decide.
    """

    minimum: Minimum
    by_neighbours: bool = False
    unresolved: bool = False


def find_candidates(problem: BurstProblem, low: RealArray, high: RealArray) -> Candidates:
    """Return every minimum of a burst within bounds.

    Parameters
    ----------
    problem : BurstProblem
    low, high : array, shape (2,)
        Bounds of (ln E1, E2/E1).

    Notes
    -----
    The coarse search covers the whole range in one model evaluation. A minimum is called plausible, not told apart
    from the best by the data, when noise could make up the difference (25 in chi-square), or when what the model
    leaves unexplained at the best, doubled, could.
    """
    starts = lowest_on_grid(*_coarse_misfit(problem, low, high), _REFINED)
    first = [refine(problem, start, low, high, _GLANCE) for start in starts]
    limit = max(_PROMISING * min(m.norm for m in first), _HOPELESS)
    promising = [m for m in first if m.norm <= limit]
    minima = distinct([refine(problem, m.z, low, high, _PATIENCE, m.history) for m in promising], _APART)
    noise, best = _noise_misfit(problem) ** 2, minima[0].misfit
    unexplained = max(best - noise, 0.0)
    limit = best + 3 * unexplained + 25 * noise / (2 * len(problem.data.local[0]))
    return Candidates(minima, sum(1 for minimum in minima if minimum.misfit <= limit))


def refine(
    problem: BurstProblem,
    start: RealArray,
    low: RealArray,
    high: RealArray,
    most: int = _PATIENCE,
    before: Sequence[tuple[RealArray, float]] = (),
) -> Minimum:
    """Return the minimum of a burst's misfit reached from a start within bounds; see `trust_region`."""
    # hardly any `gtol`: of a product of two numbers that are both small where the data hardly depend on the unknowns
    return trust_region(
        problem.residual_and_jacobian, start, bounds=(low, high), scale=_STEPS, most=most,
        ftol=1e-9, xtol=1e-8, gtol=1e-15, before=before,
    )  # fmt: skip


def _coarse_misfit(
    problem: BurstProblem, low: RealArray, high: RealArray
) -> tuple[RealArray, tuple[RealArray, RealArray]]:
    moduli = np.linspace(low[0], high[0], int(np.ceil((high[0] - low[0]) / _MODULUS_STEP)) + 1)
    losses = np.unique(np.clip(_LOSS_GRID, low[1], high[1]))
    f, base, top = problem.data.local
    kept = np.unique(np.linspace(0, len(f) - 1, _GRID_BINS).astype(int))
    x = np.stack(np.meshgrid(moduli, losses, indexing="ij"), axis=-1)
    ratio = problem.rig.transmissibility(f[kept], problem.modulus(x, f[kept]))
    misfit = np.linalg.norm(ratio * base[kept] - top[kept], axis=-1) / np.linalg.norm(top[kept])
    return misfit, (moduli, losses)


def _noise_misfit(problem: BurstProblem) -> float:
    """Return the misfit that noise of the top channel alone would leave at the true solution."""
    data = problem.data
    return float(data.noise.top * np.sqrt(data.n_samples * len(data.local[0])) / problem.scale)


def choose_branches(frequencies: Sequence[float], candidates: Sequence[Candidates]) -> list[Choice]:
    """Return one branch per burst: its best minimum, or where several fit alike, the one the other bursts ask for.

    Parameters
    ----------
    frequencies : sequence of float
        Hz; the bursts may come from several configurations of one material.
    candidates : sequence of Candidates

    Notes
    -----
    The bursts with a single plausible minimum give (ln E1, E2/E1) over ln f, interpolated and held constant beyond;
    the nearest candidate wins. Steps of ln E1 and of the loss factor count alike.
    """
    sure = [i for i, c in enumerate(candidates) if c.plausible == 1]
    choices = []
    for frequency, found in zip(frequencies, candidates, strict=True):
        if found.plausible == 1:
            choices.append(Choice(found.minima[0]))
        elif not sure:
            choices.append(Choice(found.minima[0], unresolved=True))
        else:
            expected = _expected(frequency, frequencies, candidates, sure)
            distance = [float(np.linalg.norm(m.z - expected)) for m in found.minima[: found.plausible]]
            choices.append(Choice(found.minima[int(np.argmin(distance))], by_neighbours=True))
    return choices


def _expected(
    frequency: float, frequencies: Sequence[float], candidates: Sequence[Candidates], sure: list[int]
) -> RealArray:
    known = np.array([frequencies[i] for i in sure])
    values = np.array([candidates[i].minima[0].z for i in sure])
    at = np.unique(known)
    middle = np.array([np.median(values[known == f], axis=0) for f in at])
    return np.array([np.interp(np.log(frequency), np.log(at), middle[:, k]) for k in range(2)])
