"""The place where a cause acts, marked in a drawing of the rig, the tube or the wall, and the law drawn there."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.number_text import over_unit, readable_unit
from multilayer.report.style import WIDTH, blank, colour, octave_ticks

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_HEIGHT = 2.6  # inches
_LINE = 36  # characters of a label beside an axis of that height
_SHAKER, _BASE, _SAMPLE, _TOP = (0.0, 0.16), (0.2, 0.32), (0.32, 0.68), (0.68, 0.76)  # heights in the drawing
_LEFT, _RIGHT = 0.28, 0.72
_MARK = 1  # colour of what is marked
_MOST_TICKS = 6  # of frequency, on all panels


def draw_place(law: Mapping[str, Any]) -> Figure:
    """Draw rig, tube or wall with the place marked, and the law there with 90 % bands: one part where it is real."""
    parts = [part for part in ("real", "imag") if part in law]
    figure, axes = blank(1, 1 + len(parts), (WIDTH, _HEIGHT), width_ratios=(0.8, *(2.4 / len(parts) for _ in parts)))
    draw = {"tube": _tube, "levels": _wall}.get(str(law.get("kind")), partial(_rig, variant=law.get("variant", "")))
    draw(axes[0, 0], str(law["place"]))
    f = np.asarray(law["frequency_hz"], dtype=float)
    sizes = np.abs([law[f"{part}_{end}"] for part in parts for end in ("low", "high")])
    unit, factor = readable_unit(float(np.max(sizes)), law["unit"])
    labels = ("real part", "imaginary part") if len(parts) > 1 else ("",)
    for axis, part, label in zip(axes[0, 1:], parts, labels, strict=True):
        low, high, values = (np.asarray(law[f"{part}{end}"]) / factor for end in ("_low", "_high", ""))
        axis.fill_between(f, low, high, alpha=0.25, color=colour(0), linewidth=0, label="90 %")
        axis.plot(f, values, color=colour(0), label="drawn")
        axis.axhline(0.0, color="0.6", linewidth=0.6)
        if "form" in law and f"{part}" in law["form"]:
            axis.plot(f, np.asarray(law["form"][part]) / factor, "--", color=colour(_MARK), label="simple form")
        octave_ticks(axis, float(f[0]), float(f[-1]), _MOST_TICKS // len(parts))
        axis.set_xlabel("frequency / Hz")
        axis.set_title(label, fontsize=8)
    axes[0, 1].set_ylabel(fill(over_unit(law["quantity"], unit), _LINE), fontsize=7)
    figure.legend(*axes[0, 1].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=7)
    return figure


def _rig(axis: Axes, place: str, variant: str) -> None:
    """Draw base plate, sample, top plate and accelerometers from the side."""
    from matplotlib.patches import Rectangle

    axis.set_xlim(0, 1)
    axis.set_ylim(0, 1)
    axis.set_axis_off()

    def box(heights: tuple[float, float], left: float, right: float, *, marked: bool, filled: str = "0.85") -> None:
        shade = colour(_MARK) if marked else filled
        low, high = heights
        axis.add_patch(Rectangle((left, low), right - left, high - low, facecolor=shade, edgecolor="0.3", lw=0.7))

    is_plate = place == "plate" or (place, variant) == ("one_configuration", "plate")
    in_sample = place.startswith("sample") or (place == "one_configuration" and not is_plate)
    box(_SHAKER, 0.38, 0.62, marked=False, filled="0.95")
    axis.annotate("", (0.5, 0.19), (0.5, 0.02), arrowprops={"arrowstyle": "<->", "color": "0.3", "lw": 0.8})
    box(_BASE, 0.12, 0.88, marked=False)
    box(_SAMPLE, _LEFT, _RIGHT, marked=in_sample, filled="0.95")
    box(_TOP, _LEFT, _RIGHT, marked=is_plate)
    if place == "faces":
        for height in {"lower": _SAMPLE[:1], "upper": _SAMPLE[1:]}.get(variant, _SAMPLE):
            box((height - 0.015, height + 0.015), _LEFT, _RIGHT, marked=True)
    if place == "beside":
        heights = np.linspace(_BASE[1], _TOP[0] + 0.04, 13)
        sides = 0.79 + 0.03 * np.array([0, *([1, -1] * 6)][:13])
        axis.plot([*sides, 0.72], [*heights, heights[-1]], color=colour(_MARK), lw=1.2)
    if place == "top_plate":
        box((_TOP[1], _TOP[1] + 0.08), 0.33, 0.42, marked=True)
    box((_TOP[1], _TOP[1] + 0.06), 0.47, 0.53, marked=place == "reading", filled="0.6")
    box((_BASE[1], _BASE[1] + 0.06), 0.16, 0.22, marked=place == "reading", filled="0.6")
    if place == "added_reading":
        style = {"arrowstyle": "->", "color": colour(_MARK), "lw": 1.2, "connectionstyle": "arc3,rad=-0.35"}
        axis.annotate("", (0.47, _TOP[1] + 0.05), (0.19, _BASE[1] + 0.07), arrowprops=style)
    axis.text(0.5, 0.93, place.replace("_", " "), ha="center", fontsize=8, color=colour(_MARK))


def _wall(axis: Axes, place: str) -> None:
    """Draw two leaves with what is between them, held in a wall, from above: sound comes from the left."""
    from matplotlib.patches import Rectangle

    axis.set_xlim(0, 1)
    axis.set_ylim(0, 1)
    axis.set_axis_off()

    def box(left: float, right: float, low: float, high: float, *, marked: bool, filled: str = "0.85") -> None:
        shade = colour(_MARK) if marked else filled
        axis.add_patch(Rectangle((left, low), right - left, high - low, facecolor=shade, edgecolor="0.3", lw=0.7))

    low, high, gap = 0.2, 0.72, 0.05 if place == "beside" else 0.0
    box(0.36, 0.64, 0.05, low, marked=False, filled="0.6")
    box(0.36, 0.64, high + gap, 0.87, marked=False, filled="0.6")
    if gap:
        box(0.36, 0.64, high, high + gap, marked=True)
    box(0.46, 0.56, low, high, marked=place in ("cavity", "filling", "one_measurement"), filled="0.97")
    for left in (0.42, 0.56):
        box(left, left + 0.04, low, high, marked=place.startswith("boards") or place == "one_measurement")
    if place == "links":
        for height in (0.32, 0.58):
            box(0.46, 0.56, height, height + 0.03, marked=True)
    for height, slope in ((0.3, 0.1), (0.46, 0.0), (0.62, -0.1)):
        style = {"arrowstyle": "->", "color": colour(_MARK) if place == "field" else "0.5", "lw": 0.9}
        axis.annotate("", (0.38, height), (0.12, height - slope), arrowprops=style)
    box(0.84, 0.88, 0.43, 0.49, marked=place == "reading", filled="0.6")
    axis.text(0.5, 0.93, place.replace("_", " "), ha="center", fontsize=8, color=colour(_MARK))


def _tube(axis: Axes, place: str) -> None:
    """Draw loudspeaker, microphones, sample and wall of an impedance tube from the side."""
    from matplotlib.patches import Polygon, Rectangle

    axis.set_xlim(0, 1)
    axis.set_ylim(0, 1)
    axis.set_axis_off()
    low, high = 0.35, 0.65
    for height in (low, high):
        axis.plot([0.1, 0.97], [height, height], color="0.3", lw=1.0)
    cone = [(0.04, 0.45), (0.04, 0.55), (0.1, high), (0.1, low)]
    axis.add_patch(Polygon(cone, facecolor="0.9", edgecolor="0.3", lw=0.7))

    def box(left: float, right: float, bottom: float, top: float, *, marked: bool, filled: str = "0.85") -> None:
        shade = colour(_MARK) if marked else filled
        axis.add_patch(Rectangle((left, bottom), right - left, top - bottom, facecolor=shade, edgecolor="0.3", lw=0.7))

    narrow = 0.05 if place == "beside" else 0.0
    box(0.66, 0.88, low, high - narrow, marked=place == "one_measurement", filled="0.95")
    if place == "beside":
        box(0.66, 0.88, high - narrow, high, marked=True)
    if place.startswith("layer"):
        box(0.72, 0.82, low, high, marked=True)
    if place == "in_front":
        box(0.63, 0.66, low, high, marked=True)
    if place == "behind":
        box(0.88, 0.95, low, high, marked=True)
    box(0.95, 0.99, 0.3, 0.7, marked=False, filled="0.6")
    for at in (0.35, 0.5):
        box(at - 0.015, at + 0.015, high, high + 0.08, marked=place == "reading", filled="0.6")
    axis.text(0.5, 0.9, place.replace("_", " "), ha="center", fontsize=8, color=colour(_MARK))
