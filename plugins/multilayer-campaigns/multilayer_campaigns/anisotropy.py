"""Moduli along three axes of one material: how far they differ, and whether that is more than error.

``ln E1`` and ``ln E2`` of every axis and frequency come from all bursts there by generalised least squares. What is
compared is their distance from the mean of the three axes at the same frequency, in which common errors cancel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.csv_table import csv_table
from multilayer.errors import InputError
from multilayer.inference.consistency import birge_ratio, generalised_least_squares, mahalanobis_squared, verdict_of
from multilayer_campaigns.axis_ratios import AXES, LEVEL, AxisRatios
from multilayer_campaigns.modulus_points import ModulusPoint, covariance_of, values_of

COLUMNS = (
    "axis", "campaign", "frequency_hz", "values", "E1_pa", "E1_std_pa", "E2_pa", "E2_std_pa", "E1_ratio",
    "E1_ratio_low", "E1_ratio_high", "E2_ratio", "E2_ratio_low", "E2_ratio_high",
)  # fmt: skip
_FROM_MEAN = np.eye(len(AXES)) - 1 / len(AXES)
_LEAST_P = 1e-9  # nobody knows the tail of an error beyond it


@dataclass(frozen=True)
class AnisotropyResult:
    """Moduli along three axes.

    Attributes
    ----------
    campaigns : list of str
        One per axis.
    frequency : array, shape (n,)
        Hz, those at which all axes have accepted bursts.
    counts : array, shape (n, 3)
        Bursts behind a value.
    logs : array, shape (2, n, 3)
        ln E1 and ln E2.
    covariance : array, shape (6 n, 6 n)
        Of `logs` in their order.
    scale : float
        By which all standard deviations were enlarged, for a scatter beyond the stated errors; 1 otherwise.
    remarks : list of str
    """

    campaigns: list[str]
    frequency: RealArray
    counts: RealArray
    logs: RealArray
    covariance: RealArray
    scale: float
    remarks: list[str] = field(default_factory=list)

    def of_axis(self, axis: int) -> tuple[RealArray, RealArray]:
        """Return E1 and E2 along an axis, Pa, and their standard deviations, both of shape (2, n)."""
        moduli = np.exp(self.logs)
        spread = np.sqrt(np.diag(self.covariance)).reshape(self.logs.shape)
        return moduli[:, :, axis], (moduli * spread)[:, :, axis]

    @cached_property
    def _contrasts(self) -> tuple[RealArray, RealArray]:
        """Distances from the mean over the axes, shape (6 n,), and their covariance, which is singular."""
        turn = np.kron(np.eye(2 * len(self.frequency)), _FROM_MEAN)
        return turn @ self.logs.reshape(-1), turn @ self.covariance @ turn.T

    @cached_property
    def storage(self) -> AxisRatios:
        """Of E1."""
        return self._ratios(0)

    @cached_property
    def loss(self) -> AxisRatios:
        """Of E2."""
        return self._ratios(1)

    def _ratios(self, which: int) -> AxisRatios:
        n = 3 * len(self.frequency)
        own = slice(which * n, (which + 1) * n)
        return AxisRatios.of(self.frequency, self._contrasts[0][own], self._contrasts[1][own, own])

    @property
    def p_isotropic(self) -> float:
        """Probability of what was found if the material is isotropic: the smaller of two, for E1 and E2, doubled."""
        return min(1.0, 2 * min(self.storage.p_isotropic, self.loss.p_isotropic))

    @property
    def verdict(self) -> str:
        """What was found, in a sentence."""
        head = {"seen": "anisotropic", "hint": "perhaps anisotropic", "none": "no anisotropy is seen"}
        p = f"p = {self.p_isotropic:.2g}" if self.p_isotropic > _LEAST_P else "p < 1e-9"
        found = f"{head[verdict_of(self.p_isotropic)]} ({p})"
        return "; ".join([found, self.storage.sentence("E1"), self.loss.sentence("E2")])

    def rows(self) -> list[dict[str, Any]]:
        """Return one row of `COLUMNS` per axis and frequency."""
        return [self._row(a, i) for a in range(len(AXES)) for i in range(len(self.frequency))]

    def _row(self, axis: int, index: int) -> dict[str, Any]:
        values: list[Any] = [
            AXES[axis],
            self.campaigns[axis],
            float(self.frequency[index]),
            int(self.counts[index, axis]),
        ]
        for modulus, std in zip(*self.of_axis(axis), strict=True):
            values += [float(modulus[index]), float(std[index])]
        for ratios in (self.storage, self.loss):
            values += ratios.interval(index, axis)
        return dict(zip(COLUMNS, values, strict=True))

    def to_csv(self) -> str:
        """Return ``anisotropy.csv``."""
        return csv_table(COLUMNS, (row.values() for row in self.rows()))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "version": 1,
            "campaigns": dict(zip(AXES, self.campaigns, strict=True)),
            "verdict": self.verdict,
            "p_isotropic": self.p_isotropic,
            "E1": self.storage.to_dict(),
            "E2": self.loss.to_dict(),
            "errors_enlarged_by": self.scale,
            "level_of_intervals": LEVEL,
            "values": self.rows(),
            "remarks": self.remarks,
        }


def compare_axes(
    campaigns: Sequence[str],
    points: Sequence[ModulusPoint],
    *,
    common: frozenset[str] = frozenset(),
    scatter: float = 0.0,
    remarks: Sequence[str] = (),
) -> AnisotropyResult:
    """Compare the moduli along three axes.

    Parameters
    ----------
    campaigns : sequence of str
        Three, measured along x, y and z.
    points : sequence of ModulusPoint
        Their `campaign` says along which.
    common : set of str
        Stated errors that are the same in all campaigns; see `multi_campaign.common_errors`.
    scatter : float
        Relative standard deviation of moduli from piece to piece; 0 where one cube was turned.
    remarks : sequence of str

    Raises
    ------
    InputError
        When there are not three, or no frequency has accepted bursts along all.

    Notes
    -----
    A model error common to all three, as that of a cube taken for a disc, cancels as far as the axes are alike.
    """
    if len(campaigns) != len(AXES):
        raise InputError(f"{len(campaigns)} campaigns; three are compared, measured along x, y and z in this order")
    points = [p for p in points if p.loss_factor > 0]  # others have no E2 to compare
    each = [{p.frequency for p in points if p.campaign == a} for a in range(len(AXES))]
    frequency = of_all_axes(campaigns, each)
    kept = [p for p in points if p.frequency in frequency]
    n = len(frequency)
    cell = np.array([3 * int(np.searchsorted(frequency, p.frequency)) + p.campaign for p in kept])
    design = np.kron(np.eye(2), np.eye(3 * n)[cell])
    measured, covariance = values_of(kept), covariance_of(kept, scatter, common)
    values, spread = generalised_least_squares(measured, covariance, design)
    scale = birge_ratio(mahalanobis_squared(measured - design @ values, covariance), len(measured) - len(values))
    logs, turn = _logarithms(values)
    counts = np.bincount(cell, minlength=3 * n).astype(float).reshape(n, 3)
    told = [*remarks, *_left_out(frequency, points)]
    square = scale**2 * turn @ spread @ turn.T
    return AnisotropyResult(list(campaigns), frequency, counts, logs.reshape(2, n, 3), square, scale, told)


def of_all_axes(campaigns: Sequence[str], each: Sequence[set[float]]) -> RealArray:
    """Return the frequencies that all axes have, Hz, from those of each.

    Raises
    ------
    InputError
        When there is none.
    """
    if shared := set.intersection(*each):
        return np.array(sorted(shared))
    listed = (
        f"{name}: {', '.join(f'{f:g}' for f in sorted(own)) or 'none'}"
        for name, own in zip(campaigns, each, strict=True)
    )
    raise InputError(f"no frequency is common to all three axes; in Hz, {'; '.join(listed)}")


def _logarithms(values: RealArray) -> tuple[RealArray, RealArray]:
    """Return ln E1 and ln E2 from ln E1 and loss factors, and the derivative."""
    logs, losses = np.split(values, 2)
    one, zero = np.eye(len(logs)), np.zeros((len(logs), len(logs)))
    turn = np.block([[one, zero], [one, np.diag(1 / losses)]])
    return np.concatenate([logs, logs + np.log(losses)]), turn


def _left_out(frequency: RealArray, points: Sequence[ModulusPoint]) -> list[str]:
    others = sorted({p.frequency for p in points} - set(frequency.tolist()))
    if not others:
        return []
    return [f"left out, for not all axes have them: {', '.join(f'{f:g}' for f in others)} Hz"]
