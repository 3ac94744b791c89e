"""What the scripts of this folder share: where figures go, and axes in the project's style."""

import sys
from collections.abc import Callable, Mapping
from pathlib import Path

from multilayer.report.style import blank, figure_style, png

FIGURES = Path(__file__).parent / "figures"


def axes(rows: int, columns: int, **options):
    """Return a figure and its axes, shape (rows, columns)."""
    with figure_style():
        return blank(rows, columns, (4.2 * columns, 3.0 * rows), **options)


def write(figures: Mapping[str, Callable]) -> None:
    """Draw every figure into the folder of the command line, or into ``figures`` beside the scripts."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FIGURES
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in figures.items():
        with figure_style():
            (folder / f"{name}.png").write_bytes(png(draw()))
        print(folder / f"{name}.png")  # noqa: T201
