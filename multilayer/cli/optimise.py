"""``multilayer optimise``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from multilayer.cli.options import AsJson, Cluster, Figures, Jobs, Out, finish, folder_for

if TYPE_CHECKING:
    from multilayer.optimisation.file import OptimisationFile
    from multilayer.optimisation.result import OptimisationResult


def optimise(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A simulation with a design, a goal and limits.")],
    out: Out = None,
    as_json: AsJson = False,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    figures: Figures = True,
) -> None:
    """Search the best design: thicknesses and other fields, materials, order and number of layers.

    Writes best.yaml (with several goals one file for each design of the front), designs.csv, curves.csv,
    optimisation.json, report.html and figures. Ctrl-C ends the search, and the best so far is written.

    Exit status: 0 done, 2 the input cannot be used or no design keeps all limits (nothing is written), 130 stopped.

    Example: multilayer optimise examples/best_absorber.yaml --out results/best_absorber
    """
    from multilayer.cli.plugin_commands import STOPPED
    from multilayer.config.validate import placed_in
    from multilayer.optimisation.file import load_optimisation
    from multilayer.report.optimisation import optimisation_report

    read = load_optimisation(file)
    folder = folder_for(out, file.stem)
    with placed_in(file):
        result = _searched(read, file.stem, jobs, cluster)
    finish(optimisation_report(result), folder, as_json=as_json, figures=figures)
    if not result.is_whole:
        typer.echo(f"stopped by Ctrl-C after {result.searches} parts of the search: this is the best so far", err=True)
        raise typer.Exit(STOPPED)


def _searched(file: OptimisationFile, name: str, jobs: int, address: str | None) -> OptimisationResult:
    """Search where the options say, with a progress bar."""
    from multilayer.cli.progress import progress_bar
    from multilayer.executors import abandon, executor_for
    from multilayer.optimisation.run import optimise as search
    from multilayer.optimisation.run import steps

    with executor_for(jobs, address) as executor, progress_bar("optimise", steps(file)) as advance:
        result = search(file, executor, advance, name=name)
        if not result.is_whole:
            abandon(executor)  # searches that still run there are not waited for
        return result
