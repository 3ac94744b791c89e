"""``multilayer simulate``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from multilayer.cli.options import AsJson, Cluster, Figures, Jobs, Out, finish, folder_for

if TYPE_CHECKING:
    from multilayer.simulation.result import SimulationResult
    from multilayer.simulation.run import Plan


def simulate(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A simulation file, or a stack file.")],
    out: Out = None,
    as_json: AsJson = False,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    figures: Figures = True,
) -> None:
    """Compute absorption, impedance and transmission loss of a stack, for every case of its sweep.

    A diffuse field is averaged over all azimuths, and stops at the limit angle of 78 degrees, also with a finite_size:
    write {diffuse: {max_angle: 90}} for all of it.

    Writes simulation.csv, simulation.json, report.html and figures. Exit status: 0 done, 2 the input cannot be used
    (nothing is written).

    Example: multilayer simulate examples/foam_absorption.yaml --out results/foam_absorption
    """
    from multilayer.config.validate import placed_in
    from multilayer.report.simulation import simulation_report
    from multilayer.simulation.file import load_simulation
    from multilayer.simulation.run import plan

    with placed_in(file):
        planned = plan(load_simulation(file), file.stem)
    folder = folder_for(out, file.stem)
    with placed_in(file):
        result = run_plan(planned, jobs, cluster)
    finish(simulation_report(result), folder, as_json=as_json, figures=figures)


def run_plan(planned: Plan, jobs: int, address: str | None) -> SimulationResult:
    """Run a plan where the options say, with a progress bar."""
    from multilayer.cli.progress import progress_bar
    from multilayer.executors import executor_for
    from multilayer.simulation.run import run

    bar = progress_bar("simulate", len(planned.tasks))
    with executor_for(jobs, address) as executor, bar as advance:
        return run(planned, executor, advance)
