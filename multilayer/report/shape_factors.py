"""The report of shape factors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from multilayer.report.listing import Listing
from multilayer.report.report import Report, Section


def shape_factors_report(
    along: Literal["shape", "frequency_hz"], values: Sequence[float], factors: Mapping[float, Sequence[complex]]
) -> Report:
    """Return the report of shape factors.

    Parameters
    ----------
    along : {'shape', 'frequency_hz'}
        What they are given along: shapes (static), or frequencies (dynamic, complex).
    values : sequence of float
        Shapes, or frequencies, Hz.
    factors : mapping
        By Poisson's ratio.
    """
    dynamic = along == "frequency_hz"
    rows = tuple((f"{nu:g}", *(_shown(g, dynamic) for g in row)) for nu, row in factors.items())
    headings = ("nu", *(f"{value:g} Hz" if dynamic else f"S = {value:.3g}" for value in values))
    listing = Listing(headings, rows, tuple(range(len(headings))), "apparent modulus over Young's modulus")
    record = [
        {"poisson_ratio": nu, "storage": [g.real for g in row]} | ({"loss": [g.imag for g in row]} if dynamic else {})
        for nu, row in factors.items()
    ]
    return Report(
        kind="shape factors",
        sections=(Section("", listings=(listing,)),),
        record={along: list(values), "factors": record},
    )


def _shown(factor: complex, dynamic: bool) -> str:
    if not dynamic:
        return f"{factor.real:.4f}"
    return "-" if np.isnan(factor) else f"{factor.real:.3f} {factor.imag:+.3f}i"
