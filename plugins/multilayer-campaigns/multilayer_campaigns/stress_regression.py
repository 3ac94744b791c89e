"""Moduli and loss factors against the static stress: values at zero stress of every cell, and slopes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from multilayer.arrays import RealArray
from multilayer.inference.consistency import birge_ratio
from multilayer_campaigns.modulus_points import ModulusPoint, Specimen, covariance_of, values_of

Cell: TypeAlias = tuple[Specimen, float]
"""A specimen at a frequency, Hz."""
_STEPS, _SETTLED = 50, 1e-10
_LEAST = -0.9  # b s, d s: a modulus stays above 0


@dataclass(frozen=True)
class Solution:
    """A regression's result.

    Attributes
    ----------
    z : array, shape (n,)
        ln E1 of the cells at zero stress, their loss factors, then the slopes of E1 and those of the loss factor.
    covariance : array, shape (n, n)
    chi_square : float
    degrees : int
    slopes : tuple of array
        The last part of `z`, 1/Pa, of E1 and of the loss factor.
    slope_covariance : tuple of array
    """

    z: RealArray
    covariance: RealArray
    chi_square: float
    degrees: int
    slopes: tuple[RealArray, RealArray]
    slope_covariance: tuple[RealArray, RealArray]

    @property
    def scale(self) -> float:
        """Birge's ratio where the scatter is more than chance, else 1."""
        return birge_ratio(self.chi_square, self.degrees)


@dataclass(frozen=True)
class Regression:
    """``ln E1 = ln E1_0 + ln(1 + b s)`` and ``E2/E1 = eta_0 (1 + d s)`` with all errors that points share.

    Attributes
    ----------
    points : list of ModulusPoint
    frequencies : list of float
        Hz; those with a slope of their own where slopes are `apart`.
    apart : tuple of bool
        Whether every frequency has a slope of its own, of E1 and of the loss factor.
    all_cells : list of Cell, optional
        More than those of the points.
    """

    points: list[ModulusPoint]
    frequencies: list[float]
    apart: tuple[bool, bool]
    all_cells: list[Cell] | None = None

    @cached_property
    def cells(self) -> list[Cell]:
        """What values at zero stress belong to, in order."""
        return self.all_cells or sorted({(p.specimen, p.frequency) for p in self.points})

    @cached_property
    def _cell(self) -> RealArray:
        """Which cell a point belongs to, as a matrix of zeros and ones."""
        index = [self.cells.index((p.specimen, p.frequency)) for p in self.points]
        return np.asarray(np.eye(len(self.cells))[index])

    @cached_property
    def _slope(self) -> list[RealArray]:
        """Which slope a point is subject to, likewise, for E1 and the loss factor."""
        n = len(self.frequencies)
        index = [self.frequencies.index(p.frequency) if any(self.apart) else 0 for p in self.points]
        return [np.eye(n)[index] if apart else np.ones((len(self.points), 1)) for apart in self.apart]

    @cached_property
    def _stress(self) -> RealArray:
        return np.array([p.stress for p in self.points])

    def _modelled(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return the values at a point of the parameters, and their derivative."""
        m, s = len(self.cells), self._stress[:, None]
        logs, losses = self._cell @ z[:m], self._cell @ z[m : 2 * m]
        n = self._slope[0].shape[1]
        stiffening = self._slope[0] @ z[2 * m : 2 * m + n] * self._stress
        damping = self._slope[1] @ z[2 * m + n :] * self._stress
        values = np.concatenate([logs + np.log1p(stiffening), losses * (1 + damping)])
        zero = [np.zeros((len(self.points), k)) for k in (m, n, self._slope[1].shape[1])]
        upper = [self._cell, zero[0], self._slope[0] * s / (1 + stiffening[:, None]), zero[2]]
        lower = [zero[0], self._cell * (1 + damping[:, None]), zero[1], self._slope[1] * s * losses[:, None]]
        return values, np.concatenate([np.concatenate(upper, axis=1), np.concatenate(lower, axis=1)])

    def line(self, solution: Solution, cell: Cell, stress: RealArray) -> tuple[RealArray, RealArray]:
        """Return (ln E1, loss factor) of a cell at stresses (n,), Pa, and standard deviations, both of shape (n, 2)."""
        near = next(p for p in self.points if (p.specimen, p.frequency) == cell)
        there = replace(self, points=[replace(near, stress=float(s)) for s in stress], all_cells=self.cells)
        values, slopes = there._modelled(solution.z)
        spread = solution.scale * np.sqrt(np.einsum("ij,jk,ik->i", slopes, solution.covariance, slopes))
        return values.reshape(2, -1).T, spread.reshape(2, -1).T

    def solve(self) -> Solution:
        """Return the solution by Gauss and Newton's steps."""
        measured = values_of(self.points)
        white = np.linalg.inv(np.linalg.cholesky(covariance_of(self.points)))
        m, count = len(self.cells), self._cell.sum(axis=0)
        start = [self._cell.T @ part / count for part in np.split(measured, 2)]
        z = np.concatenate([*start, np.zeros(sum(slope.shape[1] for slope in self._slope))])
        least = _LEAST / self._stress.max()
        for _ in range(_STEPS):
            values, slopes = self._modelled(z)
            step = np.linalg.lstsq(white @ slopes, white @ (measured - values), rcond=None)[0]
            z = z + step
            z[2 * m :] = np.maximum(z[2 * m :], least)
            if np.max(np.abs(step[: 2 * m])) < _SETTLED:
                break
        values, slopes = self._modelled(z)
        residual = white @ (measured - values)
        covariance: RealArray = np.asarray(
            np.linalg.pinv((white @ slopes).T @ (white @ slopes), hermitian=True), dtype=float
        )
        ends = [2 * m, 2 * m + self._slope[0].shape[1], len(z)]
        own = [slice(a, b) for a, b in pairwise(ends)]
        return Solution(
            z, covariance, float(residual @ residual), len(measured) - len(z), (z[own[0]], z[own[1]]),
            (covariance[own[0], own[0]], covariance[own[1], own[1]]),
        )  # fmt: skip
