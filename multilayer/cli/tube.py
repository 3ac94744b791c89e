"""``multilayer tube``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def tube(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A tube file, or a folder with a tube.yaml.")],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Where results go; results/NAME when left out.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as JSON in place of a summary.")] = False,
    figures: Annotated[bool, typer.Option("--figures/--no-figures", help="Draw the figure.")] = True,
) -> None:
    """Evaluate raw data of an impedance tube: R, Z and absorption (ISO 10534-2), transmission loss (ASTM E2611).

    Writes tube.csv, which simulate, compare, fit and diagnose take as measured data, and a figure; of four microphones
    also rigid_backed.csv and transfer_matrix.csv. Exit status: 0 done, 2 the input cannot be used (nothing is written).

    Example: multilayer tube examples/raw_tube --out results/raw_tube
    """
    from multilayer.json_text import json_text
    from multilayer.report.files import refuse_unusable, write_files
    from multilayer.tube.evaluate import evaluate, name_of

    folder = out or Path("results") / name_of(file)
    refuse_unusable(folder)
    result = evaluate(file)
    files: dict[str, bytes | str] = dict(result.tables())
    if figures:
        from multilayer.report.tube_figures import tube_figures

        files.update(tube_figures(result))
    written = write_files(folder, files)
    if as_json:
        typer.echo(json_text(result.to_dict()), nl=False)
        return
    low, high = result.working_range
    typer.echo(f"working range: {low:.4g} to {high:.4g} Hz (spacing of the microphones, plane waves)")
    if result.n_outside:
        done = "left out" if result.in_range.all() else "kept, and marked in the column in_range"
        typer.echo(f"{result.n_outside} frequencies outside of it were {done}")
    typer.echo(f"written to {folder}: {len(result.frequency)} frequencies; {', '.join(path.name for path in written)}")
