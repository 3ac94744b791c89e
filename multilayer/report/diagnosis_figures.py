"""Figures of a diagnosis: where the gap lies, its causes, before and after, look-alikes, what to measure next."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.result import Curves, Similarity
from multilayer.diagnosis.thresholds import ABSORBED, ALIKE, TIED
from multilayer.number_text import percent, pressure_unit
from multilayer.report.style import WIDTH, blank, colour, plain, shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

_HEIGHT = 2.5  # inches
_NUMBERED = 8  # signatures up to which the cells of the matrix hold numbers
_MOST_PLACES = 24
_MOST_CAUSES = 10
_MOST_EXPERIMENTS = 5
_TINT = 0.7  # of the strongest cell: dark and light text stay readable on it
_NARROW = 0.11  # share of the axis below which a number is written upright


def in_words(effects: Sequence[str]) -> str:
    """Return the names of a hypothesis for people: none is the nominal model."""
    if list(effects) == ["unknown"]:
        return "none of the known"
    return " + ".join(name.replace("_", " ") for name in effects) or "no effect"


def number_or_nan(value: Any) -> float:
    """Return a number, not a number where there is none."""
    return math.nan if value is None else float(value)


def best_score(record: Mapping[str, Any]) -> float:
    """Return the largest score of all causes: evidence, how common the cause is, and held-out data.

    Of those that count by themselves.
    """
    return max((float(cause["score"]) for cause in record["causes"] if "counted_with" not in cause), default=math.nan)


def places_in_bands(record: Mapping[str, Any]) -> dict[tuple[str, str], list[Mapping[str, Any]]]:
    """Return the places that have a band, by configuration and quantity, the most significant rows only."""
    rows: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for place in sorted(record["where"], key=lambda each: -abs(each["significance"])):
        row = (place.get("configuration") or "all", place["quantity"])
        if place.get("band_hz") and (row in rows or len(rows) < _MOST_PLACES):
            rows.setdefault(row, []).append(place)
    return dict(sorted(rows.items()))


def draw_where(record: Mapping[str, Any]) -> Figure:
    """Draw the significance of the residual by band, for every configuration and quantity that shows one."""
    from matplotlib.colors import Normalize

    rows = places_in_bands(record)
    tints = _tints(0.05)
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
    alone = [cause for cause in record["causes"] if "counted_with" not in cause]
    ranked = sorted(alone, key=lambda cause: -cause["score"])
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


def unexplained(curves: Curves) -> float:
    """Return the root mean square of the nominal residuals in standard deviations."""
    parts = (curves.level_before / curves.sigma_level, curves.phase_before / curves.sigma_phase)
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


def draw_before_after(curves: Curves) -> Figure:
    """Draw the residuals of the quantities of a configuration, of the nominal model and of the best hypothesis."""
    both = (
        (curves.level_before, curves.level_after, curves.sigma_level, curves.labels[0]),
        (curves.phase_before, curves.phase_after, curves.sigma_phase, curves.labels[1]),
    )
    parts = [part for part in both if part[0].size]
    figure, axes = blank(len(parts), 1, (WIDTH, _HEIGHT), sharex=True)
    for axis, (before, after, sigma, label) in zip(axes[:, 0], parts, strict=True):
        _residuals(axis, curves, before, after, sigma)
        axis.set_ylabel(label)
    axes[-1, 0].set_xlabel("frequency / Hz")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=7)
    axes[0, 0].set_title(shortened(curves.configuration, 44))
    return figure


def _residuals(axis: Axes, curves: Curves, before: RealArray, after: RealArray, sigma: RealArray) -> None:
    f, typical = (_by_burst(curves, values, sigma) for values in (curves.frequency, sigma))
    for sigmas, label in ((2, None), (1, "expected, 1 and 2 σ")):
        bound = sigmas * typical
        axis.fill_between(f, -bound, bound, color="0.5", alpha=0.25, linewidth=0, label=label)
    axis.axhline(0, color="black", linewidth=0.6)
    kinds = [(before, "x", 1, "nominal"), (after, ".", 0, "best hypothesis")]
    # without a hypothesis to speak of, both are the same
    for values, style, tint, label in kinds[: 1 if np.array_equal(before, after) else 2]:
        axis.plot(curves.frequency, values, style, color=colour(tint), markersize=3.5, alpha=0.4)
        axis.plot(f, _by_burst(curves, values, sigma), f"{style}-", color=colour(tint), markersize=4, label=label)


def _by_burst(curves: Curves, values: RealArray, sigma: RealArray) -> RealArray:
    """Return the mean of each burst, lowest frequency first; the noisy edges of its band count little."""
    bursts = np.unique(curves.burst)
    weights = (curves.burst == bursts[:, None]) / sigma**2
    weights /= weights.sum(axis=1, keepdims=True)
    return np.asarray((weights @ values)[np.argsort(weights @ curves.frequency)])


def draw_similarity(similarity: Similarity) -> Figure:
    """Draw how alike the signatures of effects are, and mark those that the unknowns absorb.

    Each name stands where its row ends and its column begins.
    """
    n, alike = len(similarity.names), np.abs(np.asarray(similarity.cosines))
    figure, axes = blank(1, 1, (WIDTH, 0.5 + max(0.13 * n, 1.2)))
    axis = axes[0, 0]
    shown = np.ma.masked_where(np.triu(np.ones((n, n), dtype=bool)), alike)
    tints = _tints()
    axis.pcolormesh(shown, cmap=tints, vmin=0, vmax=1, edgecolors="none")
    axis.set(xlim=(0, 1.45 * n), ylim=(n, 0), xticks=[], yticks=[])
    axis.spines[:].set_visible(False)
    for i, (name, share) in enumerate(zip(similarity.names, similarity.kept, strict=True)):
        cross = "× " if share < ABSORBED else ""
        axis.text(i + 0.2, i + 0.5, f"{cross}{shortened(in_words([name]))}", va="center", fontsize=7)
    for row in range(n):
        for column in range(row):
            _mark(axis, row, column, float(alike[row, column]), n)
    _scale(axis, tints)
    absorbed = "; ×: absorbed by the unknowns" if np.min(similarity.kept) < ABSORBED else ""
    figure.suptitle(f"●: above {ALIKE:g}{absorbed}", fontsize=8)
    return figure


def _tints(least: float = 0.0) -> Colormap:
    """Return colours through which light and dark paper shows: text stays readable on all of them."""
    from matplotlib.colors import LinearSegmentedColormap, to_rgba

    rgb = to_rgba(colour(0))[:3]
    return LinearSegmentedColormap.from_list("tint", [(*rgb, least), (*rgb, _TINT)])


def _mark(axis: Axes, row: int, column: int, cosine: float, n: int) -> None:
    if n <= _NUMBERED:
        text = f"{'●' if cosine > ALIKE else ''}{cosine:.2f}"
        axis.text(column + 0.5, row + 0.5, text, ha="center", va="center", fontsize=7)
    elif cosine > ALIKE:
        axis.plot(column + 0.5, row + 0.5, "o", color="black", markersize=3.5)


def _scale(axis: Axes, tints: Colormap) -> None:
    """Draw the meaning of the colours into the empty corner."""
    scale = axis.inset_axes((0.68, 0.9, 0.3, 0.05))
    steps = np.linspace(0, 1, 6)
    scale.pcolormesh(steps, [0, 1], (steps[None, :-1] + steps[None, 1:]) / 2, cmap=tints, vmin=0, vmax=1)
    scale.set(xticks=[0, 0.5, 1], yticks=[], xlabel="|cosine|")
    scale.tick_params(length=2, labelsize=7)
    scale.grid(visible=False)


def draw_moduli(moduli: Mapping[str, Any]) -> Figure:
    """Draw storage and loss modulus over frequency, of nominal model and best hypothesis, with 90 % intervals."""
    f = np.asarray(moduli["frequency_hz"], dtype=float)
    figure, axes = blank(2, 1, (WIDTH, _HEIGHT), sharex=True)
    is_corrected = moduli["corrected"] != moduli["nominal"] and np.all(np.isfinite(moduli["corrected"]["E1"]))
    kinds = (("nominal", "--"), ("corrected", "-"))[: 2 if is_corrected else 1]
    for axis, part in zip(axes[:, 0], ("E1", "E2"), strict=True):
        unit, factor = pressure_unit(max(max(moduli[name][part]) for name, _ in kinds))
        for i, (name, style) in enumerate(kinds):
            axis.plot(f, np.asarray(moduli[name][part]) / factor, style, color=colour(1 - i), label=name)
            ends = [np.asarray(moduli[name][f"{part}_{end}"]) / factor for end in ("low", "high")]
            axis.fill_between(f, *ends, color=colour(1 - i), alpha=0.2, linewidth=0)
        axis.set_ylabel(f"{part} / {unit}")
    axes[1, 0].set_xlabel("frequency / Hz")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=7)
    return figure
