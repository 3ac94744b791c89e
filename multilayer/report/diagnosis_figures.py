"""Figures of a diagnosis: where the gap lies, its causes, before and after, look-alikes, what to measure next."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.diagnosis.result import Diagnosis
from multilayer.diagnosis.thresholds import TIED
from multilayer.executors import run_all
from multilayer.report.diagnosis_curves import draw_before_after, draw_moduli, draw_similarity
from multilayer.report.diagnosis_rows import best_score, in_words, number_or_nan
from multilayer.report.files import file_names
from multilayer.report.numbers import percent
from multilayer.report.style import WIDTH, blank, colour, figure_style, plain, png, shortened
from multilayer.report.svg import inline_svg

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_PLACES = 24
_MOST_CAUSES = 10
_MOST_EXPERIMENTS = 5
_TINT = 0.7  # of the strongest cell: dark and light text stay readable on it
_NARROW = 0.11  # share of the axis below which a number is written upright


@dataclass(frozen=True)
class Drawn:
    """A figure as a PNG file, and as an SVG element for a page."""

    png: bytes
    svg: str


def diagnosis_drawings(diagnosis: Diagnosis) -> dict[str, Callable[[], Figure]]:
    """Return what draws the figures of a diagnosis, by name; those without data are left out."""
    record, similarity, moduli = diagnosis.record, diagnosis.similarity, diagnosis.moduli
    found: dict[str, Callable[[], Figure]] = {}
    if _places(record):
        found["where"] = partial(draw_where, record)
    if record["causes"]:
        found["causes"] = partial(draw_causes, record)
    for curves, name in zip(diagnosis.curves, curve_names(diagnosis), strict=True):
        if len(curves.frequency):
            found[name] = partial(draw_before_after, curves)
    if len(similarity.names) > 1:
        found["similarity"] = partial(draw_similarity, similarity)
    if record["next_experiment"]:
        found["next_experiment"] = partial(draw_experiments, record)
    if moduli.get("frequency_hz"):
        found["moduli"] = partial(draw_moduli, moduli)
    return found


def curve_names(diagnosis: Diagnosis) -> list[str]:
    """Return the names of the figures before and after, one for each configuration."""
    return [f"before_after-{name}" for name in file_names([one.configuration for one in diagnosis.curves])]


def diagnosis_pictures(diagnosis: Diagnosis, executor: Executor | None = None) -> dict[str, Drawn]:
    """Return the figures of a diagnosis by name, drawn in the processes of an executor where one is given."""
    drawings = diagnosis_drawings(diagnosis)
    tasks = [(draw, f"f{i}", name) for i, (name, draw) in enumerate(drawings.items())]
    return dict(zip(drawings, run_all(_drawn, tasks, executor), strict=True))


def _drawn(task: tuple[Callable[[], Figure], str, str]) -> Drawn:
    draw, key, name = task
    with figure_style(compact=True):
        figure = draw()
        image = png(figure)
        figure.set_layout_engine("none")  # it is laid out, and that takes as long as to draw it
        return Drawn(image, inline_svg(figure, key, name.replace("_", " ")))


def _places(record: Mapping[str, Any]) -> dict[tuple[str, str], list[Mapping[str, Any]]]:
    """Return the places that have a band, by configuration and quantity, the most significant rows only."""
    rows: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for place in sorted(record["where"], key=lambda one: -abs(one["significance"])):
        row = (place.get("configuration") or "all", place["quantity"])
        if place.get("band_hz") and (row in rows or len(rows) < _MOST_PLACES):
            rows.setdefault(row, []).append(place)
    return dict(sorted(rows.items()))


def draw_where(record: Mapping[str, Any]) -> Figure:
    """Draw the significance of the residual by band, for every configuration and quantity that shows one."""
    from matplotlib.colors import LinearSegmentedColormap, Normalize, to_rgba

    rows = _places(record)
    blue = to_rgba(colour(0))
    tints = LinearSegmentedColormap.from_list("tint", [(*blue[:3], 0.05), (*blue[:3], _TINT)])
    scale = Normalize(0, max(abs(place["significance"]) for places in rows.values() for place in places))
    figure, axes = blank(1, 1, (WIDTH, 0.9 + 0.25 * len(rows)))
    axis = axes[0, 0]
    bands = [f for places in rows.values() for place in places for f in place["band_hz"]]
    axis.set(xscale="log", xlim=(0.97 * min(bands), 1.03 * max(bands)), ylim=(len(rows) - 0.4, -0.6))
    for i, places in enumerate(rows.values()):
        for place in places:
            _cell(axis, i, place, tints(scale(abs(place["significance"]))))
    axis.set_yticks(range(len(rows)), [f"{shortened(name, 16)}\n{plain(quantity)}" for name, quantity in rows])
    _plain_frequencies(axis, min(bands), max(bands))
    axis.tick_params(axis="y", length=0)
    axis.set_xlabel("frequency / Hz")
    axis.set_title("significance / standard deviations")
    axis.grid(axis="y")
    return figure


def _cell(axis: Axes, row: int, place: Mapping[str, Any], tint: Any) -> None:
    low, high = place["band_hz"]
    axis.barh(row, high - low, left=low, height=0.86, color=tint, edgecolor="black", linewidth=0.4)
    first, last = axis.get_xlim()
    narrow = math.log(high / low) < _NARROW * math.log(last / first)
    text = f"{abs(place['significance']):.{0 if narrow else 1}f}"
    axis.text(math.sqrt(low * high), row, text, ha="center", va="center", fontsize=6 if narrow else 8)


def _plain_frequencies(axis: Axes, low: float, high: float) -> None:
    """Write 200, 500, 1000 on a logarithmic axis."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks = [n * 10.0**d for d in decades for n in (1, 2, 5) if 0.97 * low <= n * 10.0**d <= 1.03 * high]
    if len(ticks) < 2:
        ticks = [low, high]
    axis.set_xticks(ticks, [f"{f:.0f}" for f in ticks])
    axis.minorticks_off()


def _bars(axis: Axes, labels: Sequence[str], values: Sequence[float], tints: Sequence[str]) -> None:
    axis.barh(range(len(labels)), values, height=0.5, color=tints)
    axis.set_yticks(range(len(labels)), labels)
    axis.set_ylim(len(labels) - 0.4, -0.6)
    axis.tick_params(axis="y", length=0)
    axis.grid(visible=False, axis="y")


def _shown_causes(record: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the most probable causes; what is none of the effects is always among them."""
    ranked = sorted(record["causes"], key=lambda cause: -cause["score"])
    return [c for i, c in enumerate(ranked) if i < _MOST_CAUSES or c["effects"] in ([], ["unknown"])]


def draw_causes(record: Mapping[str, Any]) -> Figure:
    """Draw how far the score of every cause is behind the best, and by how much each makes the gap shrink."""
    causes, best = _shown_causes(record), best_score(record)
    behind = [best - cause["score"] for cause in causes]
    labels = [_cause_label(cause["effects"]) for cause in causes]
    figure, axes = blank(1, 1, (WIDTH, 0.8 + (0.25 if "\n" in "".join(labels) else 0.22) * len(causes)))
    axis = axes[0, 0]
    # far ones would squeeze the near ones, which matter, into nothing
    position = [math.asinh(x / TIED) for x in behind]
    tints = [colour(0) if x < TIED else colour(5) for x in behind]
    _bars(axis, labels, position, tints)
    axis.axvspan(0, math.asinh(1), color=colour(4), alpha=0.25, linewidth=0, zorder=0)
    for i, (cause, x, tint) in enumerate(zip(causes, position, tints, strict=True)):
        axis.plot(x, i, "o", color=tint)
        axis.annotate(_shrinks(cause), (x, i), (6, 0), textcoords="offset points", va="center", fontsize=7)
    _ticks_of_asinh(axis, max(*position, math.asinh(10 / TIED)))
    axis.set_xlabel("score behind the best / nats")
    axis.set_title(f"shaded: within {TIED:g} nats, not told apart")
    return figure


def _cause_label(effects: Sequence[str]) -> str:
    """Return the names of a hypothesis, those of several effects one below the other."""
    if len(effects) < 2:
        return shortened(in_words(effects), 26)
    return "\n+ ".join(shortened(in_words([name])) for name in effects)


def _ticks_of_asinh(axis: Axes, last: float) -> None:
    """Write round numbers where `draw_causes` has them, not too close to each other."""
    numbers = [0, *(n * 10**d for d in range(9) for n in (1, 3))]
    ticks: list[int] = []
    for number in numbers:
        place = math.asinh(number / TIED)
        if place <= last and (not ticks or place - math.asinh(ticks[-1] / TIED) > 0.18 * last):
            ticks.append(number)
    axis.set_xticks([math.asinh(n / TIED) for n in ticks], [str(n) for n in ticks])
    axis.set_xlim(0, 1.7 * last)


def _shrinks(cause: Mapping[str, Any]) -> str:
    shrinkage = number_or_nan(cause.get("shrinkage"))
    if math.isnan(shrinkage) or not cause["effects"]:
        return ""
    return f"gap {'grows' if shrinkage < 0 else 'shrinks'} by {percent(abs(shrinkage))}"


def draw_experiments(record: Mapping[str, Any]) -> Figure:
    """Draw what the next experiments are expected to tell, for each hour where their cost is known."""
    entries = record["next_experiment"]
    known = all(entry.get("cost_hours") for entry in entries)
    values = [entry["expected_gain"] / (entry["cost_hours"] if known else 1.0) for entry in entries]
    order = np.argsort([-value for value in values], kind="stable")[:_MOST_EXPERIMENTS]
    labels = [textwrap.fill(entries[i]["change"].replace("_", " "), 24) for i in order]
    labels = ["\n".join(shortened(line, 30) for line in label.split("\n")[:2]) for label in labels]
    figure, axes = blank(1, 1, (WIDTH, 0.6 + 0.27 * len(order)))
    axis = axes[0, 0]
    _bars(axis, labels, [values[i] for i in order], [colour(2)] * len(order))
    for row, i in enumerate(order):
        axis.annotate(f"{values[i]:.1f}", (values[i], row), (3, 0), textcoords="offset points", va="center", fontsize=7)
    axis.set_xlim(0, 1.15 * max(*values, 1e-3))
    axis.set_xlabel("expected gain / nats per hour" if known else "expected gain / nats")
    return figure
