"""``multilayer compare``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from multilayer.cli.completion import quantities
from multilayer.cli.options import AsJson, Cluster, Figures, Jobs, Out, finish, folder_for
from multilayer.cli.simulate import run_plan

_STOPPED = "stopped by Ctrl-C: the comparison is written without the values that would bring the prediction closest"


def compare(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A simulation file, or a stack file.")],
    measured: Annotated[
        Path,
        typer.Argument(metavar="MEASURED.csv", help="Measured spectra, units in the header; also .mat, .h5, .uff."),
    ],
    quantity: Annotated[
        str | None,
        typer.Option(
            help="What to compare, as absorption; everything that both have when left out.", autocompletion=quantities
        ),
    ] = None,
    closest: Annotated[
        bool,
        typer.Option(
            "--closest-values/--no-closest-values",
            help="Seek the value of a single field of a layer that brings the prediction closest.",
        ),
    ] = True,
    out: Out = None,
    as_json: AsJson = False,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    figures: Figures = True,
) -> None:
    """Lay measured spectra over what a simulation file predicts at the same frequencies.

    Prints the rms and the largest misfit of every case, and which value of a single field of a layer would bring the
    prediction closest; writes comparison.csv, comparison.json, comparison.html and figures. Ctrl-C while such values
    are sought leaves them out, and all else is written. Exit status: 0 done, whatever the misfit, 2 the input cannot be
    used (nothing is written), 130 stopped.

    Example: multilayer compare examples/foam_tube/truth.yaml examples/foam_tube/tube.csv
    """
    from multilayer.cli.plugin_commands import STOPPED
    from multilayer.cli.progress import progress_bar
    from multilayer.cli.warned import tell
    from multilayer.config.validate import placed_in
    from multilayer.executors import executor_for
    from multilayer.report.simulation import comparison_report
    from multilayer.simulation.closest_values import TOLD, fields_sought
    from multilayer.simulation.compare import compare as compared
    from multilayer.simulation.compare import refuse_not_predicted, searches, with_closest_values
    from multilayer.simulation.file import load_simulation
    from multilayer.simulation.measured import known_quantity, read_measured
    from multilayer.simulation.run import plan

    simulation = load_simulation(file)
    spectra = read_measured(measured, known_quantity(quantity))
    with placed_in(measured):
        grid = spectra.grid(simulation.frequency)
    with placed_in(file):
        planned = plan(simulation, file.stem, grid)
        refuse_not_predicted(spectra, planned)
    folder = folder_for(out, file.stem)
    with placed_in(file):
        comparison = compared(spectra, run_plan(planned, jobs, cluster))
    tasks = searches(comparison, planned) if closest else {}
    steps = sum(len(fields_sought(task)) + TOLD for task in tasks.values())
    stopped = False
    if steps:
        try:
            with executor_for(jobs, cluster) as executor, progress_bar("closest values", steps) as advance:
                comparison = with_closest_values(comparison, tasks, executor, advance)
        except KeyboardInterrupt:
            stopped = True
            tell([_STOPPED])
    finish(comparison_report(comparison), folder, as_json=as_json, figures=figures)
    if stopped:
        raise typer.Exit(STOPPED)
