"""Table 2 of Bonfiglio & Pompoli 2015 in full: ``docs/validation/factorial.md`` and its figures.

Run it as ``python -m validation.factorial [--jobs 2] [--cluster ADDRESS] > docs/validation/factorial.md``. What
is done is kept in a file; started again after an interruption, the command does the rest.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import Any

from multilayer.cli.progress import progress_bar
from multilayer.errors import MultilayerError
from multilayer.executors import as_done, cluster, local_pool
from multilayer.json_lines import JsonLines
from validation.factorial_cases import CYCLES, LINES, PERIOD, Design, Outcome, Task
from validation.factorial_fit import solve
from validation.factorial_numbers import Run
from validation.factorial_page import write_page

ROOT = Path(__file__).parents[1]


def kept_in(path: Path, design: Design) -> JsonLines:
    """Return the file of a design's outcomes."""
    made_with = repr((design, CYCLES, PERIOD, LINES.tolist()))
    return JsonLines(path, {"design": sha256(made_with.encode()).hexdigest()[:12]})


def run(design: Design, store: JsonLines, workers: AbstractContextManager[Executor | None]) -> Run:
    """Compute what the store lacks, and return all of the design."""
    known = {outcome.key for outcome in _outcomes(store)}
    left = [task for task in design.tasks if task.key not in known]
    start = time.perf_counter()
    with workers as executor, progress_bar("factorial", len(left)) as advance:
        for index, outcome in as_done(solve, left, executor):
            store.append(asdict(outcome))
            advance(_told(left[index]))
    return Run(design, _outcomes(store), time.perf_counter() - start, len(left))


def _outcomes(store: JsonLines) -> list[Outcome]:
    return [Outcome.read(found) for found in store.begin(resume=True)]


def _told(task: Task) -> str:
    return f"E1 {task.modulus:g} Pa, {1e3 * task.thickness:g} mm, nu {task.poisson_ratio:g}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Compute and print the page."""
    options = _options(arguments)
    options.results.parent.mkdir(parents=True, exist_ok=True)
    if options.fresh:
        options.results.unlink(missing_ok=True)
    design = Design()
    try:
        workers: Any = cluster(options.cluster) if options.cluster else local_pool(options.jobs)
        print(write_page(run(design, kept_in(options.results, design), workers), options.figures))  # noqa: T201
    except MultilayerError as error:
        sys.exit(str(error))


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=1, help="processes of this machine to compute with")
    parser.add_argument("--cluster", help="a Dask scheduler whose workers compute, as tcp://10.0.0.1:8786")
    parser.add_argument("--results", type=Path, default=ROOT / "results" / "factorial.jsonl", help="what is done")
    parser.add_argument("--fresh", action="store_true", help="forget what is done")
    parser.add_argument("--figures", type=Path, default=ROOT / "docs" / "validation", help="folder of the figures")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    main()
