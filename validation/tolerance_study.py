"""A tolerance study of a hundred million points on a Dask cluster: ``docs/validation/tolerance_study.md``.

Run it as ``OMP_NUM_THREADS=1 python -m validation.tolerance_study > docs/validation/tolerance_study.md``. A point is
one sample at one frequency. It takes about a quarter of an hour on two cores.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from distributed import Client, LocalCluster

from multilayer.executors import executor_for
from multilayer.simulation.batches import Batch, run_batch
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.result import PERCENTILES, SimulationResult
from multilayer.simulation.run import plan, run
from tests.analytic.materials import FOAM, stack

FREQUENCIES = 1000
SCATTER = {"thickness": "2 %", "porosity": "1 %", "flow_resistivity": "10 %", "tortuosity": "3 %"}
WORKERS = (1, 2, 3, 4)


class Run(NamedTuple):
    """What a study took: seconds from tasks to percentiles, and the largest memory of this process and of a worker."""

    workers: int
    points: int
    seconds: float
    here: float
    there: float

    @property
    def row(self) -> str:
        """A row of the table."""
        each = 1e6 * self.seconds / self.points
        cost = each * self.workers
        return (
            f"| {self.workers} | {self.points:.0e} | {self.seconds:.0f} | {each:.2f} | {cost:.2f} "
            f"| {self.here:.0f} | {self.there:.0f} |"
        )


def study(samples: int) -> SimulationFile:
    """Return foam before a wall whose thickness and pores scatter."""
    foam = stack((FOAM, 0.05), termination="rigid")
    return SimulationFile.model_validate({
        **foam.to_dict(), "frequency": np.geomspace(50.0, 5000.0, FREQUENCIES).tolist(), "samples": samples,
        "tolerances": {f"layers.0.{name}": width for name, width in SCATTER.items()},
    })  # fmt: skip


def megabytes() -> float:
    """Return the largest memory that this process has held so far, on Linux."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(float(line.split()[1]) / 1e3 for line in lines if line.startswith("VmHWM"))


def on_cluster(workers: int, points: int, tell: Callable[[str], None]) -> tuple[Run, SimulationResult]:
    """Run a study on so many workers of one thread each."""
    planned = plan(study(points // FREQUENCIES))
    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
        with executor_for(1, cluster.scheduler_address) as executor:
            begun, done = time.perf_counter(), 0

            def progress(label: str) -> None:
                nonlocal done
                done += 1
                if done % 500 == 0:
                    tell(f"{workers} workers: {done} of {len(planned.tasks)} tasks")

            result = run(planned, executor, progress)
            seconds = time.perf_counter() - begun
        with Client(cluster.scheduler_address, set_as_default=False) as client:
            there = max(client.run(megabytes).values())
    return Run(workers, points, seconds, megabytes(), there), result


def same(a: SimulationResult, b: SimulationResult) -> bool:
    """Tell whether the percentiles of two results are the same to the last bit."""
    first, second = (result.cases[0].percentiles for result in (a, b))
    return first.keys() == second.keys() and all(np.array_equal(first[name], second[name]) for name in first)


def held_at_once(points: int) -> str:
    """Return whether percentiles are those of all samples at once, of a study that memory holds."""
    planned = plan(study(points // FREQUENCIES))
    values: list[Any] = [
        outcome.quantities["absorption"]
        for task in planned.tasks
        if task.samples
        for outcome in run_batch(Batch((task,), {}))
    ]
    expected = np.percentile(np.concatenate(values), PERCENTILES, axis=0)
    return "yes" if np.array_equal(expected, run(planned).cases[0].percentiles["absorption"]) else "**no**"


def main() -> None:
    """Print the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=float, default=1e8, help="of the large study, on two workers")
    parser.add_argument("--each", type=float, default=1e7, help="of those on one to four workers")
    options = parser.parse_args()

    def tell(text: str) -> None:
        sys.stderr.write(f"{text}\n")

    few = int(options.each / 10)
    alone = run(plan(study(few // FREQUENCIES)))
    _, spread = on_cluster(2, few, tell)
    runs = [on_cluster(workers, int(options.each), tell)[0] for workers in WORKERS]
    large = on_cluster(2, int(options.points), tell)[0]
    days = large.seconds / large.points * 1e10 / 86400
    rows = "\n".join(each.row for each in (*runs, large))
    answers = ("yes" if same(alone, spread) else "**no**"), held_at_once(20 * few)
    sys.stdout.write(f"""# A tolerance study on a cluster

Made by `python -m validation.tolerance_study`, {os.cpu_count()} cores, Python {platform.python_version()}, numpy
{np.__version__}. Foam of 50 mm before a wall at {FREQUENCIES} frequencies, whose thickness, porosity, flow resistivity
and tortuosity scatter; a point is one sample at one frequency, with all its quantities. A Dask scheduler and its
workers, one thread each, run on this machine beside the process that asks and puts the percentiles together. Seconds
are those of the clock.

| workers | points | s | µs per point | times workers | MB, this process | MB, a worker |
|---|---|---|---|---|---|---|
{rows}

The same percentiles to the last bit in this process and on two workers ({few:.0e} points): {answers[0]}. The same as
those of all samples held at once ({20 * few:.0e} points): {answers[1]}.

Samples are counted where they lie far from a percentile, and kept near it, so that memory grows as the root of their
number, and the exact percentiles come out. No more than 512 tasks are with the cluster at a time.

On paper, 1e10 points take {days:.1f} days at the pace of the last row. The process that asks sees every sample once,
which bounds what further workers gain; beyond, a study is better cut into several with other seeds.
""")


if __name__ == "__main__":
    main()
