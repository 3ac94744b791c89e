"""``docs/validation/methods.md``: the default method beside Nelder-Mead, and all methods against the truth.

Run it as ``make bench``, or ``python -m validation.methods [CAMPAIGN] [--bursts N] [--no-truth]``, on one thread.
For every burst of the campaign:

- the cost of eq. (9) at the optimum of each method, each with its own model;
- the same with one and the same model (the paper's: half-space of air above, modulus constant within the burst);
- the differences of eq. (10) that each optimum leaves;
- the time of the optimisation itself, without region and figures.

Then, some minutes more, `methods_truth`: every method on the paper's three materials, and how far a rod reaches.
"""

from __future__ import annotations

import argparse
import os
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from multilayer.experiments.two_plate.burst import BurstProblem
from multilayer.fits.burst.acceptance import discrepancies_in_band
from multilayer.fits.burst.branches import find_candidates
from multilayer.fits.burst.fit import burst_problems, search_bounds
from multilayer.fits.burst.nelder_mead import envelope_cost, minimise_envelope_cost
from multilayer.fits.settings import FitSettings
from multilayer.fits.sources import read_fit
from validation.methods_truth import against_truth, reach_of_the_rod

ROOT = Path(__file__).parents[1]


@dataclass(frozen=True)
class Row:
    """One burst solved by one method."""

    cost: float
    delta_tof: float
    delta_level: float
    seconds: float


def _default(problem: BurstProblem, low: np.ndarray, high: np.ndarray) -> Row:
    start = time.perf_counter()
    x = find_candidates(problem, low, high).minima[0].z
    return _row(problem, x, time.perf_counter() - start)


def _nelder_mead(problem: BurstProblem, low: np.ndarray, high: np.ndarray, begin: np.ndarray) -> Row:
    start = time.perf_counter()
    x = minimise_envelope_cost(problem, begin, low, high).z
    return _row(problem, x, time.perf_counter() - start)


def _row(problem: BurstProblem, x: np.ndarray, seconds: float) -> Row:
    # relative to the cost of a model that gives no signal at all
    cost = envelope_cost(problem, x) / float(np.sum(problem.data.envelope))
    return Row(cost, *(float(delta) for delta in discrepancies_in_band(problem, x)), seconds)


def compare(source: Path, n_bursts: int | None) -> dict[str, list[Row]]:
    """Return the rows of each method over the bursts of a campaign."""
    job = read_fit(source)
    paper = FitSettings(method="nelder-mead")
    same = FitSettings(termination="ambient", dispersion="none")
    rows: dict[str, list[Row]] = {"nelder-mead": [], "default": [], "default, paper's model": []}
    problems = {
        name: burst_problems(job.campaign, job.recordings, settings, job.calibration)[:n_bursts]
        for name, settings in (("nelder-mead", paper), ("default", FitSettings()), ("default, paper's model", same))
    }
    low, high = search_bounds(job.settings)
    given = job.settings.quasi_static
    for literal, own, shared in zip(*problems.values(), strict=True):
        rows["default"].append(_default(own, low, high))
        rows["default, paper's model"].append(_default(shared, low, high))
        begin = find_candidates(literal, low, high).minima[0].z
        if given is not None:
            begin = np.array([np.log(given.storage_modulus), given.loss_modulus / given.storage_modulus])
        rows["nelder-mead"].append(_nelder_mead(literal, low, high, begin))
    return rows


def report(rows: dict[str, list[Row]]) -> str:
    """Return the comparison as text."""
    lines = [
        "| method | median cost (9), relative | median time-of-flight difference, us | median level difference, dB | "
        "median time per burst, s |",
        "|---|---|---|---|---|",
    ]
    for name, found in rows.items():
        columns = np.array([[r.cost, abs(r.delta_tof) * 1e6, abs(r.delta_level), r.seconds] for r in found])
        cost, tof, level, seconds = np.median(columns, axis=0)
        lines.append(f"| {name} | {cost:.4f} | {tof:.2f} | {level:.3f} | {seconds:.2f} |")
    literal, own, shared = (rows[name] for name in ("nelder-mead", "default", "default, paper's model"))
    ratios = np.array([a.seconds / b.seconds for a, b in zip(literal, own, strict=True)])
    total = sum(r.seconds for r in literal) / sum(r.seconds for r in own)
    span = f"per burst {ratios.min():.0f} to {ratios.max():.0f}"
    lines += ["", f"- Nelder-Mead takes {total:.0f} times as long as the default ({span})."]
    for name, found in (("the default", own), ("the default with the paper's model", shared)):
        better = sum(a.cost <= b.cost for a, b in zip(found, literal, strict=True))
        lines.append(f"- The cost (9) of {name} is not above Nelder-Mead's at {better} of {len(literal)} bursts.")
    return "\n".join(lines)


def main() -> None:
    """Run the comparison and print it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("campaign", nargs="?", type=Path, default=ROOT / "examples" / "foam_b")
    parser.add_argument("--bursts", type=int, default=None, help="only the first N bursts")
    parser.add_argument("--no-truth", action="store_true", help="without the part on the shared campaigns")
    options = parser.parse_args()
    threads = os.environ.get("OMP_NUM_THREADS", "not set")
    heading = f"""# Methods side by side

Made by `make bench`, OMP_NUM_THREADS={threads}; `docs/methods.md` says what each method does.

## The default method beside Nelder-Mead

On `{options.campaign.resolve().name}`. Nelder-Mead starts from the quasi-static values and minimises eq. (9) with the
paper's model; the default minimises the distance of the spectra. The cost is relative to that of no signal at all.
"""
    print(heading)  # noqa: T201
    print(report(compare(options.campaign, options.bursts)))  # noqa: T201
    if not options.no_truth:
        print(against_truth())  # noqa: T201
        print(reach_of_the_rod(), end="")  # noqa: T201


if __name__ == "__main__":
    main()
