"""The table of shape factors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from rich.table import Table

from multilayer.report.console import console


@dataclass(frozen=True)
class ShapeFactors:
    """Shape factors by Poisson's ratio, along shapes (static) or frequencies (dynamic, complex)."""

    along: Literal["shape", "frequency_hz"]
    values: Sequence[float]
    factors: Mapping[float, Sequence[complex]]

    def to_dict(self) -> dict[str, Any]:
        """Return plain lists, fit for JSON."""
        rows = [
            {"poisson_ratio": nu, "storage": [g.real for g in row]}
            | ({"loss": [g.imag for g in row]} if self.along == "frequency_hz" else {})
            for nu, row in self.factors.items()
        ]
        return {self.along: list(self.values), "factors": rows}


def shape_table(found: ShapeFactors) -> None:
    """Print one row per Poisson's ratio."""
    dynamic = found.along == "frequency_hz"
    table = Table(box=None, pad_edge=False, title="apparent modulus over Young's modulus", title_justify="left")
    table.add_column("nu", justify="right")
    for value in found.values:
        table.add_column(f"{value:g} Hz" if dynamic else f"S = {value:.3g}", justify="right")
    for nu, row in found.factors.items():
        table.add_row(f"{nu:g}", *(_shown(g, dynamic) for g in row))
    console().print(table)


def _shown(factor: complex, dynamic: bool) -> str:
    if not dynamic:
        return f"{factor.real:.4f}"
    return "-" if np.isnan(factor) else f"{factor.real:.3f} {factor.imag:+.3f}i"
