"""``multilayer simulate``."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from multilayer.simulation.result import SimulationResult
    from multilayer.simulation.run import Plan

Jobs = Annotated[int, typer.Option("--jobs", metavar="N", help="Processes of this machine to compute with.")]
Cluster = Annotated[
    str | None,
    typer.Option(
        "--cluster", metavar="ADDRESS", help="A Dask scheduler whose workers compute, as tcp://10.0.0.1:8786."
    ),
]


def simulate(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A simulation file, or a stack file.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Where results go; results/NAME when left out."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as JSON in place of the table.")] = False,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    figures: Annotated[bool, typer.Option("--figures/--no-figures", help="Draw figures and the HTML report.")] = True,
) -> None:
    """Compute absorption, impedance and transmission loss of a stack, for every case of its sweep.

    A diffuse field is averaged over all azimuths, and stops at the limit angle of 78 degrees, also with a finite_size:
    write {diffuse: {max_angle: 90}} for all of it.

    Writes simulation.csv, simulation.json, report.html and figures. Exit status: 0 done, 2 the input cannot be used
    (nothing is written).

    Example: multilayer simulate examples/foam_absorption.yaml --out results/foam_absorption
    """
    from multilayer.json_text import json_text
    from multilayer.report.files import refuse_unusable, write_files
    from multilayer.report.simulation_table import simulation_table
    from multilayer.simulation.file import load_simulation
    from multilayer.simulation.run import plan

    planned = plan(load_simulation(file), file.stem)
    folder = out or Path("results") / file.stem
    refuse_unusable(folder)
    result = run_plan(planned, jobs, cluster)
    written = write_files(folder, _files(result, figures))
    if as_json:
        typer.echo(json_text(result.to_dict()), nl=False)
    else:
        simulation_table(result)
        typer.echo(f"written to {folder}: {', '.join(path.name for path in written)}")


def _files(result: SimulationResult, figures: bool) -> dict[str, bytes | str]:
    from multilayer.json_text import json_text

    files: dict[str, bytes | str] = {
        "simulation.csv": result.to_csv(),
        "simulation.json": json_text(result.to_dict()),
    }
    if figures:
        from multilayer.report.simulation_figures import simulation_figures
        from multilayer.report.simulation_html import simulation_html

        files["report.html"] = simulation_html(result)
        files.update(simulation_figures(result))
    return files


def run_plan(planned: Plan, jobs: int, address: str | None) -> SimulationResult:
    """Run a plan where the options say, with a progress bar; warnings become one line each on standard error."""
    from multilayer.cli.progress import progress_bar
    from multilayer.executors import executor_for
    from multilayer.simulation.run import run

    bar = progress_bar("simulate", len(planned.tasks))
    with _warnings_as_lines(), executor_for(jobs, address) as executor, bar as advance:
        return run(planned, executor, advance)


@contextmanager
def _warnings_as_lines() -> Iterator[None]:
    import warnings

    from multilayer.errors import ValidityWarning
    from multilayer.executors import LostWorkerWarning

    with warnings.catch_warnings(record=True) as caught:
        for category in (ValidityWarning, LostWorkerWarning):
            warnings.simplefilter("always", category)
        yield
    for one in caught:
        if issubclass(one.category, ValidityWarning | LostWorkerWarning):
            typer.echo(f"warning: {' '.join(str(one.message).split())}", err=True)
        else:
            warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)
