"""How all figures look."""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from multilayer.doors import for_log
from multilayer.response.bands import band_centres

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LONGEST_LABEL = 28  # of a legend in two columns below a figure
_LONGEST_NAME = 70  # of what stands in one line; longer ones would leave no room for axes
_MOST_IN_LEGEND = 20  # within axes
WIDTH = 3.9  # inches of a figure in a report: half a printed page, and all of a telephone

# Okabe & Ito: told apart by people with any colour vision
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
_SETTINGS: dict[Any, Any] = {
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "font.size": 9.0,
    "legend.frameon": False,
    "text.usetex": False,  # whatever a matplotlibrc says: names are no programs of TeX
    "figure.constrained_layout.use": True,
    "figure.dpi": 150,
    "lines.linewidth": 1.3,
    "lines.markersize": 4.5,
}


_COMPACT: dict[Any, Any] = {"font.size": 8.0, "axes.titlesize": 8.0, "xtick.labelsize": 7.5, "ytick.labelsize": 7.5}


@contextmanager
def figure_style(*, compact: bool = False) -> Iterator[None]:
    """Draw with the project's settings, leaving the user's untouched; compact for figures half a page wide."""
    from matplotlib import rc_context  # heavy: only when something is drawn

    with rc_context({**_SETTINGS, **_COMPACT} if compact else _SETTINGS):
        yield


def blank(
    rows: int, columns: int, size: tuple[float, float], *, laid_out: bool = True, **options: Any
) -> tuple[Figure, Any]:
    """Return a figure of a size in inches, and its axes in an array of rows and columns; if wanted, placed by hand."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure as NewFigure  # without pyplot: no window system, no global state

    with rc_context({} if laid_out else {"figure.constrained_layout.use": False}):
        figure = NewFigure(figsize=size)
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def legend_below(figure: Figure, axis: Axes, most: int = 10) -> None:
    """Put what an axis labels below the figure, each label once, where there are at least two of them."""
    handles = {label: handle for handle, label in zip(*axis.get_legend_handles_labels(), strict=True)}
    if len(handles) > 1:
        cut = [shortened(label.replace(r"\$", "$"), _LONGEST_LABEL) for label in handles][:most]
        figure.legend([*handles.values()][:most], cut, loc="outside lower center", ncols=2, fontsize=7)


def finished(figure: Figure, axis: Axes, title: str, *, upright: bool, **options: Any) -> Figure:
    """Return a figure with the legend of an axis and a title; in a report the legend is below, a caption the title."""
    if upright:
        legend_below(figure, axis)
    else:
        handles, labels = axis.get_legend_handles_labels()
        if handles:
            axis.legend(handles[:_MOST_IN_LEGEND], labels[:_MOST_IN_LEGEND], fontsize=7, **options)
        figure.suptitle(title)
    return figure


def octave_ticks(axis: Axes, low: float, high: float, most: int = 12) -> None:
    """Mark octaves along the frequency axis, Hz, or every so many of them; logarithmic where it is wide enough."""
    if high < 4 * low:
        return
    axis.set_xscale("log")
    ticks = [tick for tick in band_centres(16, 16000, "octaves") if low <= tick <= high]
    ticks = ticks[:: math.ceil(len(ticks) / most)]
    axis.set_xticks(ticks, [f"{tick / 1000:g}k" if tick >= 1000 else f"{tick:g}" for tick in ticks])
    axis.set_xticks([], minor=True)


def readable_decades(axis: Axes) -> None:
    """Write plain numbers along a logarithmic axis of ordinates, between the powers of ten too where there are few."""
    from matplotlib.ticker import LogFormatter

    for setter in (axis.yaxis.set_major_formatter, axis.yaxis.set_minor_formatter):
        setter(LogFormatter(labelOnlyBase=False, minor_thresholds=(1.2, 0.5)))


@contextmanager
def any_script() -> Iterator[None]:
    """Save figures whatever script their names are in: what the font lacks shows as boxes."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph \d+ .* missing from (current )?font", UserWarning)
        yield


def png(figure: Figure) -> bytes:
    """Return a figure as a PNG file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    buffer = io.BytesIO()
    canvas: Any = FigureCanvasAgg(figure)  # savefig would draw all of it twice, first to lay it out
    with any_script():
        canvas.print_png(buffer, pil_kwargs={"compress_level": 3})  # half the time, hardly more bytes
    return buffer.getvalue()


def plain(name: str) -> str:
    """Return a user's name as matplotlib shows it to the letter: no formula, in one line, and kept in a legend."""
    shown = _without_middle(for_log(name), _LONGEST_NAME).replace("$", r"\$")
    return f" {shown}" if shown.startswith("_") else shown


def colour(index: int) -> str:
    """Return the colour of the n-th series."""
    return COLOURS[index % len(COLOURS)]


def shortened(name: str, longest: int = 22) -> str:
    """Return a user's name for the tick of an axis: its middle left out where it is long."""
    return plain(_without_middle(name, longest))


def _without_middle(name: str, longest: int) -> str:
    kept = (longest - 1) // 2
    return name if len(name) <= longest else f"{name[:kept]}…{name[-kept:]}"
