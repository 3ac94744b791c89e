"""What several methods say of one campaign: points, checks, agreement, and how they are written down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.csv_table import csv_table
from multilayer.errors import InputError
from multilayer.fits.result import BurstFit, number_or_none
from multilayer.media.kramers_kronig import Verdict, check_kramers_kronig, gross_loss_modulus

CSV_COLUMNS = ("configuration", "frequency_hz", "method", "E1_pa", "E1_std_pa", "E2_pa", "E2_std_pa", "remark")
_FEWEST = 3  # points for a slope


@dataclass(frozen=True)
class MethodPoint:
    """What one method says at one frequency.

    Attributes
    ----------
    configuration : str
    frequency : float
        Hz.
    method : str
        Under which it stands in the comparison.
    storage_modulus, storage_modulus_std, loss_modulus, loss_modulus_std : float
        Pa; NaN where the method has no answer, or no standard deviation.
    loss_factor_std : float
    reliable : bool
        Accepted, and within what the method is made for.
    remark : str
    """

    configuration: str
    frequency: float
    method: str
    storage_modulus: float
    storage_modulus_std: float
    loss_modulus: float
    loss_modulus_std: float
    loss_factor_std: float = float("nan")
    reliable: bool = True
    remark: str = ""

    @classmethod
    def of(cls, method: str, burst: BurstFit) -> MethodPoint:
        """Return what a method says of a burst."""
        return cls(
            burst.configuration, burst.frequency, method, burst.storage_modulus, burst.storage_modulus_std,
            burst.loss_modulus, burst.loss_modulus_std, burst.loss_factor_std, burst.accepted, burst.remark,
        )  # fmt: skip

    @property
    def loss_factor(self) -> float:
        """E2/E1."""
        return self.loss_modulus / self.storage_modulus

    def row(self) -> tuple[Any, ...]:
        """Return the values of `CSV_COLUMNS`."""
        return (
            self.configuration, self.frequency, self.method, self.storage_modulus, self.storage_modulus_std,
            self.loss_modulus, self.loss_modulus_std, self.remark,
        )  # fmt: skip


@dataclass(frozen=True)
class CausalityCheck:
    """Whether E1 and E2 of one method and configuration belong together.

    Attributes
    ----------
    configuration, method : str
    frequency : array, shape (n,)
        Hz; of the reliable points.
    gross : array, shape (n,)
        E2 that the slope of E1 asks for, eq. (12), Pa.
    gross_error : float
        Mean relative error of that against E2 as found.
    verdict : {'consistent', 'inconsistent', 'cannot tell'}
        Of the full Kramers-Kronig relation.
    reasons : tuple of str
    """

    configuration: str
    method: str
    frequency: RealArray
    gross: RealArray
    gross_error: float
    verdict: Verdict
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class Agreement:
    """How far one method lies from the reference.

    Attributes
    ----------
    configuration, method, reference : str
    n_points : int
        Frequencies at which both are reliable.
    storage_difference, loss_difference : float
        Median of method over reference, less one.
    within : float
        Share of the values that differ by no more than two standard deviations of both together; of those whose
        standard deviations are known, NaN where there are none.
    """

    configuration: str
    method: str
    reference: str
    n_points: int
    storage_difference: float
    loss_difference: float
    within: float


@dataclass(frozen=True)
class MethodComparison:
    """All methods on one campaign.

    Attributes
    ----------
    campaign : str
        Its name.
    points : list of MethodPoint
        By configuration, frequency and method.
    limits : dict
        Upper frequency limit of the transfer function method by configuration, Hz; infinite above all bursts.
    left_out : dict
        Methods that could not be used, and why.
    remarks : list of str
        On the campaign as a whole.
    titles : dict
        What each method is, in a few words, in the order in which they are listed.
    """

    campaign: str
    points: list[MethodPoint]
    limits: dict[str, float] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)
    titles: dict[str, str] = field(default_factory=dict)

    @property
    def configurations(self) -> list[str]:
        """Names of the configurations, in order."""
        return list(dict.fromkeys(point.configuration for point in self.points))

    @property
    def names(self) -> list[str]:
        """Names of all methods, in the order of `titles`."""
        return list(dict.fromkeys([*self.titles, *(point.method for point in self.points)]))

    @property
    def methods(self) -> list[str]:
        """Methods that said something, in that order."""
        used = {point.method for point in self.points}
        return [name for name in self.names if name in used]

    @property
    def reference(self) -> str:
        """The method the others are measured by: the one whose model holds most."""
        return "finite" if "finite" in self.methods else "plane-wave"

    def of(self, configuration: str, method: str | None = None) -> list[MethodPoint]:
        """Return the points of a configuration, of one method or of all."""
        points = [p for p in self.points if p.configuration == configuration]
        return [p for p in points if method is None or p.method == method]

    def checks(self) -> list[CausalityCheck]:
        """Return the checks of every configuration and method with at least three reliable points."""
        pairs = [(name, method) for name in self.configurations for method in self.methods]
        found = [causality_check([p for p in self.of(*pair) if p.reliable]) for pair in pairs]
        return [check for check in found if check is not None]

    def agreements(self) -> list[Agreement]:
        """Return how far every other method lies from the reference, by configuration."""
        others = [method for method in self.methods if method != self.reference]
        pairs = [(name, method) for name in self.configurations for method in others]
        found = [_agreement(self.of(name, method), self.of(name, self.reference)) for name, method in pairs]
        return [agreement for agreement in found if agreement is not None]

    def to_csv(self) -> str:
        """Return all points; numbers with nine significant digits, an empty cell where there is none."""
        return csv_table(CSV_COLUMNS, [[number_or_none(value) for value in point.row()] for point in self.points])

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "version": 1,
            "campaign": self.campaign,
            "methods": {name: self.titles.get(name, "") for name in self.methods},
            "left_out": self.left_out,
            "remarks": self.remarks,
            "points": [_point_dict(point) for point in self.points],
            "transfer_function_limit_hz": {name: number_or_none(f) for name, f in self.limits.items()},
            "kramers_kronig": [_check_dict(check) for check in self.checks()],
            "agreement": [_agreement_dict(agreement) for agreement in self.agreements()],
        }


def causality_check(points: Sequence[MethodPoint]) -> CausalityCheck | None:
    """Return the checks of eq. (12) and of the full relation for the points of one method; None for fewer than three.

    Parameters
    ----------
    points : sequence of MethodPoint
        Reliable ones of one configuration.
    """
    order = sorted((p for p in points if p.storage_modulus > 0), key=lambda point: point.frequency)
    if len(order) < _FEWEST:
        return None
    names = ("frequency", "storage_modulus", "loss_modulus", "storage_modulus_std", "loss_modulus_std")
    f, e1, e2, s1, s2 = (np.array([getattr(p, name) for p in order]) for name in names)
    gross = gross_loss_modulus(f, e1)
    known = e2 > 0
    error = float(np.mean(np.abs(gross[known] / e2[known] - 1))) if known.any() else float("nan")
    try:
        full = check_kramers_kronig(f, e1 + 1j * e2, s1, s2)
        verdict, reasons = full.verdict, full.reasons
    except InputError as problem:
        verdict, reasons = "cannot tell", (str(problem),)
    return CausalityCheck(order[0].configuration, order[0].method, f, gross, error, verdict, reasons)


def _agreement(own: Sequence[MethodPoint], reference: Sequence[MethodPoint]) -> Agreement | None:
    there = {point.frequency: point for point in reference if point.reliable}
    pairs = [(point, there[point.frequency]) for point in own if point.reliable and point.frequency in there]
    if not pairs:
        return None
    quantities = ("storage_modulus", "loss_modulus")
    values = np.array([[[getattr(p, name) for name in quantities] for p in pair] for pair in pairs])
    stds = np.array([[[getattr(p, f"{name}_std") for name in quantities] for p in pair] for pair in pairs])
    e1, e2 = np.median(values[:, 0] / values[:, 1] - 1, axis=0)
    both = np.linalg.norm(stds, axis=1)
    known = np.isfinite(both)
    near = (np.abs(values[:, 0] - values[:, 1]) <= 2 * both)[known]
    within, first = float(near.mean()) if known.any() else float("nan"), pairs[0]
    return Agreement(first[0].configuration, first[0].method, first[1].method, len(pairs), float(e1), float(e2), within)


def _point_dict(point: MethodPoint) -> dict[str, Any]:
    loss = {"loss_factor": point.loss_factor, "loss_factor_std": point.loss_factor_std}
    plain = {**dict(zip(CSV_COLUMNS, point.row(), strict=True)), **loss, "reliable": point.reliable}
    return {name: number_or_none(value) for name, value in plain.items()}


def _check_dict(check: CausalityCheck) -> dict[str, Any]:
    return {
        "configuration": check.configuration,
        "method": check.method,
        "verdict": check.verdict,
        "reasons": list(check.reasons),
        "gross_mean_relative_error": number_or_none(check.gross_error),
        "frequency_hz": check.frequency.tolist(),
        "gross_E2_pa": check.gross.tolist(),
    }


def _agreement_dict(agreement: Agreement) -> dict[str, Any]:
    return {
        "configuration": agreement.configuration,
        "method": agreement.method,
        "reference": agreement.reference,
        "points": agreement.n_points,
        "E1_median_difference": number_or_none(agreement.storage_difference),
        "E2_median_difference": number_or_none(agreement.loss_difference),
        "within_two_std": number_or_none(agreement.within),
    }
