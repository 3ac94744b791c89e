"""The report of what a tube says of its sample."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from multilayer.number_text import over_unit
from multilayer.report.report import Report
from multilayer.report.style import blank, colour, plain
from multilayer.simulation.quantities import QUANTITIES
from multilayer.tube.evaluate import TubeResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DRAWN = ("absorption", "normalised_impedance", "transmission_loss")
_TITLES = {"tube": "gas on both sides", "rigid_backed": "before a wall that it does not touch"}
_BACKED = (
    "rigid_backed.csv: before a wall that the sample does not touch, so that an elastic frame is free there; "
    "'termination: rigid' holds it: for such a stack, {type: fluid, thickness: 1 um} goes ahead of the wall"
)


def tube_report(result: TubeResult) -> Report:
    """Return the report of a tube."""
    low, high = result.working_range
    done = "left out" if result.in_range.all() else "kept, and marked in the column in_range"
    return Report(
        name=result.name,
        kind="impedance tube",
        opening=(
            f"working range: {low:.4g} to {high:.4g} Hz (spacing of the microphones, plane waves)",
            *([f"{result.n_outside} frequencies outside of it were {done}"] if result.n_outside else []),
            f"{len(result.frequency)} frequencies evaluated",
            *((_BACKED,) if "rigid_backed" in result.spectra else ()),
        ),
        tables=result.tables(),
        record=result.to_dict(),
        record_file="tube.json",
        figures={"tube.png": partial(draw_tube, result)},
    )


def draw_tube(result: TubeResult) -> Figure:
    """Draw absorption, impedance and transmission loss over frequency, in grey what the tube does not tell."""
    there = [name for name in _DRAWN if any(name in spectra for spectra in result.spectra.values())]
    figure, axes = blank(len(there), 1, (7.5, 2.4 * len(there)), sharex=True)
    for axis, name in zip(axes[:, 0], there, strict=True):
        quantity = QUANTITIES[name]
        for i, (condition, spectra) in enumerate(result.spectra.items()):
            if name in spectra:
                _draw(axis, result, quantity.parts(spectra[name]), colour(i), _TITLES[condition])
        if quantity.is_complex:
            axis.set_title("real part solid, imaginary part dashed", fontsize="small", loc="right")
        axis.set_ylabel(over_unit(quantity.title, quantity.unit))
        _shade(axis, result)
    if len(result.spectra) > 1:
        axes[0, 0].legend()
    axes[-1, 0].set_xlabel("frequency / Hz")
    low, high = result.working_range
    figure.suptitle(f"{plain(result.name)}: working range {low:.0f} to {high:.0f} Hz")
    return figure


def _draw(axis: Any, result: TubeResult, parts: dict[str, Any], tint: str, title: str) -> None:
    form = "o" if len(result.frequency) == 1 else ""
    for line, values in zip(("-", "--"), parts.values(), strict=False):
        axis.plot(result.frequency, values, form + line, color=tint, label=title if line == "-" else "_")


def _shade(axis: Any, result: TubeResult) -> None:
    """Shade what lies outside of the working range."""
    low, high = result.frequency.min(), result.frequency.max()
    for start, end in ((low, min(result.working_range.low, high)), (max(result.working_range.high, low), high)):
        if end > start:
            axis.axvspan(start, end, color="0.9", zorder=0)
