"""``docs/validation/inverse_speed.md``: how long fits take, beside Nelder-Mead on the same model.

Run it as ``OMP_NUM_THREADS=1 python -m validation.inverse_speed > docs/validation/inverse_speed.md``; about two
minutes. Both sides minimise the same function from the same start: least squares with a Jacobian of one batched solve,
``scipy.optimize.minimize(method="Nelder-Mead")`` by values alone. Times are processor time, the least of some repeats;
with one thread that is the time on an idle machine.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
import scipy
from scipy.optimize import minimize

from multilayer.experiments.two_plate.burst import BurstProblem
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.fits.burst.branches import find_candidates, refine
from multilayer.fits.burst.fit import burst_problems, fit_bursts, search_bounds
from multilayer.fits.joint.fit import fit_joint
from multilayer.fits.joint.posterior import with_posterior
from multilayer.fits.joint.result import JointFit
from multilayer.fits.sources import FitJob, read_fit
from multilayer.inference.least_squares import draw_prior, minimise
from multilayer.measurements.description import Uncertainty

ROOT = Path(__file__).parents[1]
JOINT_LIMIT, BURSTS_LIMIT = 5.0, 1.0  # s
MOST = 20_000  # evaluations of Nelder-Mead
CANDIDATES = 128
COARSE = 0.02  # model error while only the law is sought, as in `solve_joint`


@dataclass(frozen=True)
class Timed:
    """What something returned, and how long it took, s of processor time."""

    value: Any
    seconds: float


def timed(function: Callable[[], Any], repeats: int) -> Timed:
    """Return the least time of some repeats."""
    best = Timed(None, np.inf)
    for _ in range(repeats):
        start = time.process_time()
        value = function()
        best = min(best, Timed(value, time.process_time() - start), key=lambda one: one.seconds)
    return best


def cost_of(problem: CampaignProblem) -> Callable[[np.ndarray], float]:
    """Return what is minimised: misfit plus prior, of one point."""

    def cost(z: np.ndarray) -> float:
        residual = problem.residual(z)
        return float(residual @ residual + z @ z)

    return cost


def nelder_mead(cost: Callable[[np.ndarray], float], start: np.ndarray) -> Timed:
    """Return scipy's result from a start; adaptive, as its documentation advises for many unknowns."""
    options = {"maxfev": MOST, "maxiter": MOST, "xatol": 1e-4, "fatol": 1e-4, "adaptive": start.size > 4}
    return timed(lambda: minimize(cost, start, method="Nelder-Mead", options=options), 1)


def joint(job: FitJob, repeats: int) -> list[str]:
    """Return the section on a joint fit."""
    fitted = timed(lambda: fit_joint(job.campaign, job.recordings, settings=job.settings), repeats)
    known = timed(lambda: with_posterior(fitted.value), repeats)
    bursts = sum(len(c.bursts) for c in job.campaign.configurations)
    total = fitted.seconds + known.seconds
    return [
        f"`{job.campaign.folder.resolve().name}`: {len(job.campaign.configurations)} configurations, {bursts} bursts, "
        f"fractional Zener law, {len(fitted.value.problem.parameters)} unknowns, {fitted.value.n_data} data.",
        "",
        "| step | s |",
        "|---|---|",
        f"| signals, 6 starts for the law, those worth it with all unknowns | {fitted.seconds:.2f} |",
        f"| intervals and what the data determine (Laplace, checked by 256 points) | {known.seconds:.2f} |",
        f"| together | {total:.2f} |",
        "",
        f"Target: below {JOINT_LIMIT:g} s: **{'met' if total < JOINT_LIMIT else 'not met'}**, on one thread.",
        "",
        *beside(fitted.value, repeats),
    ]


def beside(found: JointFit, repeats: int) -> list[str]:
    """Return the table of single descents beside Nelder-Mead's, on the same functions."""
    problem = found.problem
    law = replace(problem, known=Uncertainty(), model_error=COARSE)
    points = draw_prior(len(law.parameters), CANDIDATES, seed=0)
    first = points[np.argmin([cost_of(law)(z) for z in points])]
    second = np.concatenate([minimise(law, first).z, np.zeros(len(problem.nuisances.parameters))])
    lines = [
        "One descent from the same start, by least squares and by Nelder-Mead:",
        "",
        "| what | unknowns | least squares, s | cost reached | Nelder-Mead, s | cost reached | evaluations | ratio |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, one, start in (("law alone", law, first), ("law and rig", problem, second)):
        own = timed(lambda one=one, start=start: minimise(one, start), repeats)
        other = nelder_mead(cost_of(one), start)
        ended = f"{other.value.nfev}{'' if other.value.success else ', stopped there'}"
        lines.append(
            f"| {name} | {start.size} | {own.seconds:.3f} | {own.value.cost:.5g} | {other.seconds:.2f} | "
            f"{other.value.fun:.5g} | {ended} | {other.seconds / own.seconds:.0f} |"
        )
    return lines


def bursts(job: FitJob, repeats: int) -> list[str]:
    """Return the section on a campaign fitted burst by burst."""
    whole = timed(lambda: fit_bursts(job.campaign, job.recordings, job.settings, job.calibration), repeats)
    problems = burst_problems(job.campaign, job.recordings, job.settings, job.calibration)
    low, high = search_bounds(job.settings)
    searched = timed(lambda: [find_candidates(problem, low, high) for problem in problems], repeats)
    seconds, worse, evaluations = np.zeros(2), 0, 0
    for problem, candidates in zip(problems, searched.value, strict=True):
        best = candidates.minima[0]
        start = best.history[0][0]  # where the coarse search sent the best minimum off
        down = timed(partial(refine, problem, start, low, high), repeats)
        simplex = nelder_mead(partial(squared_misfit, problem), start)
        seconds += (down.seconds, simplex.seconds)
        evaluations += simplex.value.nfev
        worse += bool(np.sqrt(simplex.value.fun) > 1.01 * best.norm)
    n, met = len(problems), "met" if whole.seconds < BURSTS_LIMIT else "not met"
    return [
        f"`{job.campaign.folder.resolve().name}`: {n} bursts, plane waves, with means, standard deviations and all "
        "alternatives.",
        "",
        "| step | s |",
        "|---|---|",
        f"| whole fit, without reading and figures | {whole.seconds:.2f} |",
        f"| of that the search for all minima of all bursts | {searched.seconds:.2f} |",
        f"| only the descent to each best minimum, least squares | {seconds[0]:.3f} |",
        f"| the same by Nelder-Mead, {evaluations / n:.0f} evaluations per burst | {seconds[1]:.3f} |",
        "",
        f"Target: the whole fit below {BURSTS_LIMIT:g} s: **{met}**. With two unknowns Nelder-Mead takes "
        f"{seconds[1] / seconds[0]:.1f} times as long for one descent; its misfit is more than 1 % larger at {worse} "
        f"of {n} bursts. The search looks at the whole range and follows every valley.",
    ]


def squared_misfit(problem: BurstProblem, x: np.ndarray) -> float:
    """Return what is minimised for a burst."""
    return float(problem.misfit(x)) ** 2


def page(options: argparse.Namespace) -> str:
    """Return the page."""
    threads = os.environ.get("OMP_NUM_THREADS", "unset")
    return "\n".join(
        [
            "# Speed of the inverse",
            "",
            f"Made by `python -m validation.inverse_speed`, OMP_NUM_THREADS={threads}, one process, numpy "
            f"{np.__version__}, scipy {scipy.__version__}; s of processor time, the least of {options.repeats} runs "
            "(Nelder-Mead: one). The times are those of one machine; the ratios, taken in one run, are what to read.",
            "",
            "## One law for a whole campaign",
            "",
            *joint(read_fit(options.joint), options.repeats),
            "",
            "## Burst by burst",
            "",
            *bursts(read_fit(options.bursts), options.repeats),
        ]
    )


def wrapped(text: str) -> str:
    """Return text with lines of at most 120 characters, but for tables."""
    return "\n".join(line if line.startswith("|") else fill(line, 120) for line in text.split("\n"))


def main() -> None:
    """Measure and print the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--joint", type=Path, default=ROOT.parent / "shared" / "campaigns" / "effect-none")
    parser.add_argument("--bursts", type=Path, default=ROOT / "examples" / "foam_b")
    parser.add_argument("--repeats", type=int, default=3)
    print(wrapped(page(parser.parse_args())))  # noqa: T201


if __name__ == "__main__":
    main()
