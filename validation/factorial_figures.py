"""The figures of ``docs/validation/factorial.md``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from multilayer.report.style import colour, figure_style, png
from validation.factorial_fit import static_ratio
from validation.factorial_numbers import Cases

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLES = {"storage": "E1 of the finite elements / E1 found", "loss": "E2 of the finite elements / E2 found"}
_DODGE = 0.0035  # of Poisson's ratio, between frequencies
_HIGHEST = 6.0  # ratio that the figures show


def draw(cases: Cases, folder: Path) -> None:
    """Write all figures."""
    for name in TITLES:
        (folder / f"factorial_{name}.png").write_bytes(_remade(cases, name))
    (folder / "factorial_waves.png").write_bytes(_waves(cases))


def _remade(cases: Cases, name: str) -> bytes:
    """Return Fig. 4 or 5 of the paper: mean and standard deviation over the ratio of Poisson."""
    with figure_style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6.4, 3.6))
        axes = figure.subplots()
        grid, ratios = cases.grid(name, cases.accepted), np.array(cases.design.poisson_ratios)
        for i, f in enumerate(cases.design.frequencies):
            spread = np.array([grid[nu, f][:2] for nu in ratios])
            shift = _DODGE * (i - 0.5 * (len(cases.design.frequencies) - 1))
            axes.errorbar(ratios + shift, *spread.T, color=colour(i), marker="o", capsize=2, label=f"{f:g} Hz")
        slow = [np.mean([static_ratio(nu, h) for h in cases.design.thicknesses]) for nu in ratios]
        axes.plot(ratios, slow, "k--", label="slow compression")
        axes.set(xlabel="Poisson's ratio", ylabel=TITLES[name], ylim=(0, None))
        axes.legend(ncols=2)
        return png(figure)


def _waves(cases: Cases) -> bytes:
    """Return the ratios of single cases over radius / wavelength."""
    with figure_style():
        from matplotlib.figure import Figure

        shown = cases.design.poisson_ratios[-4::3] if len(cases.design.poisson_ratios) > 3 else (0.3,)
        figure = Figure(figsize=(7.2, 5.0))
        axes = figure.subplots(2, len(shown), sharex=True, squeeze=False)
        for column, nu in zip(axes.T, shown, strict=True):
            for panel, name in zip(column, TITLES, strict=True):
                _scatter(panel, cases, name, nu)
            column[0].set_title(f"Poisson's ratio {nu:g}")
            column[1].set_xlabel("radius / wavelength of a rod")
        for row, name in zip(axes, TITLES, strict=True):
            row[0].set_ylabel("ratio of E1" if name == "storage" else "ratio of E2")
        axes[0, 0].legend()
        return png(figure)


def _scatter(axes: Axes, cases: Cases, name: str, poisson_ratio: float) -> None:
    for i, thickness in enumerate(cases.design.thicknesses):
        chosen = cases.accepted & cases.where(poisson_ratio=poisson_ratio, thickness=thickness)
        label = f"{1e3 * thickness:g} mm"
        axes.plot(cases.waves[chosen], cases[name][chosen], ".", color=colour(i), markersize=2.5, label=label)
        axes.axhline(static_ratio(poisson_ratio, thickness), color=colour(i), linewidth=0.8)
    axes.axhline(1.0, color="k", linewidth=0.8, linestyle=":")
    axes.set(xscale="log", ylim=(0, min(_HIGHEST, axes.get_ylim()[1])))
