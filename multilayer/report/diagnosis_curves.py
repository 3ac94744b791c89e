"""Figures of a diagnosis over frequency, and which effects look alike."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.result import Curves, Similarity
from multilayer.diagnosis.thresholds import ABSORBED, ALIKE
from multilayer.report.diagnosis_rows import in_words
from multilayer.report.numbers import pressure_unit
from multilayer.report.style import WIDTH, blank, colour, shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

_HEIGHT = 2.5  # inches
_NUMBERED = 8  # signatures up to which the cells of the matrix hold numbers


def unexplained(curves: Curves) -> float:
    """Return the root mean square of the nominal residuals in standard deviations."""
    parts = (curves.level_before / curves.sigma_level, curves.phase_before / curves.sigma_phase)
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


def draw_before_after(curves: Curves) -> Figure:
    """Draw the residuals of both quantities of a configuration, of the nominal model and of the best hypothesis."""
    figure, axes = blank(2, 1, (WIDTH, _HEIGHT), sharex=True)
    parts = (
        (curves.level_before, curves.level_after, curves.sigma_level, curves.labels[0]),
        (curves.phase_before, curves.phase_after, curves.sigma_phase, curves.labels[1]),
    )
    for axis, (before, after, sigma, label) in zip(axes[:, 0], parts, strict=True):
        _residuals(axis, curves, before, after, sigma)
        axis.set_ylabel(label)
    axes[1, 0].set_xlabel("frequency / Hz")
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


def _tints() -> Colormap:
    """Return colours through which light and dark paper shows: text stays readable on all of them."""
    from matplotlib.colors import LinearSegmentedColormap, to_rgba

    rgb = to_rgba(colour(0))[:3]
    return LinearSegmentedColormap.from_list("tint", [(*rgb, 0.0), (*rgb, 0.7)])


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
    """Draw storage and loss modulus over frequency, of the nominal model and of the best hypothesis."""
    f = np.asarray(moduli["frequency_hz"], dtype=float)
    figure, axes = blank(2, 1, (WIDTH, _HEIGHT), sharex=True)
    kinds = (("nominal", "--"), ("corrected", "-"))[: 1 if moduli["corrected"] == moduli["nominal"] else 2]
    for axis, part in zip(axes[:, 0], ("E1", "E2"), strict=True):
        unit, factor = pressure_unit(max(max(moduli[name][part]) for name, _ in kinds))
        for i, (name, style) in enumerate(kinds):
            axis.plot(f, np.asarray(moduli[name][part]) / factor, style, color=colour(1 - i), label=name)
        axis.set_ylabel(f"{part} / {unit}")
    axes[1, 0].set_xlabel("frequency / Hz")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=7)
    return figure
