"""``multilayer tube``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from multilayer.cli.options import AsJson, Figure, Out, finish, folder_for


def tube(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A tube file, or a folder with a tube.yaml.")],
    out: Out = None,
    as_json: AsJson = False,
    figures: Figure = True,
) -> None:
    """Evaluate raw data of an impedance tube: R, Z and absorption (ISO 10534-2), transmission loss (ASTM E2611).

    Writes tube.csv, which compare, fit, diagnose and explore --measured take as measured data, tube.json and a figure;
    of four microphones also rigid_backed.csv (air at rest behind the sample, an elastic frame free) and
    transfer_matrix.csv. Exit status: 0 done, 2 the input cannot be used (nothing is written).

    Example: multilayer tube examples/raw_tube --out results/raw_tube
    """
    from multilayer.config.validate import placed_in
    from multilayer.report.tube import tube_report
    from multilayer.tube.evaluate import evaluate, name_of

    folder = folder_for(out, name_of(file))
    with placed_in(file):
        result = evaluate(file)
    finish(tube_report(result), folder, as_json=as_json, figures=figures)
