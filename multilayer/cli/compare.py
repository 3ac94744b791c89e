"""``multilayer compare``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from multilayer.cli.completion import quantities
from multilayer.cli.simulate import Cluster, Jobs, run_plan

if TYPE_CHECKING:
    from multilayer.simulation.compare import Comparison


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
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Where results go; results/NAME when left out."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as JSON in place of the table.")] = False,
    jobs: Jobs = 1,
    cluster: Cluster = None,
    figures: Annotated[bool, typer.Option("--figures/--no-figures", help="Draw figures and the HTML report.")] = True,
) -> None:
    """Lay measured spectra over what a simulation file predicts at the same frequencies.

    Prints the rms and the largest misfit of every case; writes comparison.csv, comparison.json, comparison.html and
    figures. Exit status: 0 done, whatever the misfit, 2 the input cannot be used (nothing is written).

    Example: multilayer compare examples/foam_absorption.yaml tube.csv
    """
    from multilayer.json_text import json_text
    from multilayer.report.files import refuse_unusable, write_files
    from multilayer.report.simulation_table import comparison_table
    from multilayer.simulation.compare import compare as compared
    from multilayer.simulation.file import load_simulation
    from multilayer.simulation.measured import known_quantity, read_measured
    from multilayer.simulation.run import plan

    simulation = load_simulation(file)
    spectra = read_measured(measured, known_quantity(quantity))
    planned = plan(simulation, file.stem, spectra.grid(simulation.frequency))
    folder = out or Path("results") / file.stem
    refuse_unusable(folder)
    comparison = compared(spectra, run_plan(planned, jobs, cluster))
    written = write_files(folder, _files(comparison, figures))
    if as_json:
        typer.echo(json_text(comparison.to_dict()), nl=False)
    else:
        comparison_table(comparison)
        typer.echo(f"written to {folder}: {', '.join(path.name for path in written)}")


def _files(comparison: Comparison, figures: bool) -> dict[str, bytes | str]:
    from multilayer.json_text import json_text

    files: dict[str, bytes | str] = {
        "comparison.csv": comparison.to_csv(),
        "comparison.json": json_text(comparison.to_dict()),
    }
    if figures:
        from multilayer.report.simulation_figures import comparison_figures
        from multilayer.report.simulation_html import comparison_html

        files["comparison.html"] = comparison_html(comparison)
        files.update(comparison_figures(comparison))
    return files
