"""Modulus over static stress: what is found, and how it is written down."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.chi2 import exceeding
from multilayer.csv_table import csv_table
from multilayer.inference.consistency import ALIKE, Verdict, verdict_of
from multilayer_campaigns.modulus_points import ModulusPoint, Specimen
from multilayer_campaigns.stress_regression import Cell, Regression, Solution

COLUMNS = (
    "specimen", "frequency_hz", "values", "stress_low_pa", "stress_high_pa", "E1_0_pa", "E1_0_std_pa", "E2_0_pa",
    "E2_0_std_pa", "loss_factor_0", "loss_factor_0_std", "E1_slope_per_pa", "E1_slope_std_per_pa",
    "loss_factor_slope_per_pa", "loss_factor_slope_std_per_pa",
)  # fmt: skip


@dataclass(frozen=True)
class Slope:
    """Relative change of a quantity with the static stress, 1/Pa.

    Attributes
    ----------
    value, std : float
        Of all frequencies together.
    frequency, each : array
        Hz, and the slope at each by itself.
    covariance : array
        Of `each`.
    p_shared : float
        Probability of slopes as different as these if it is one.
    p_none : float
        Probability of what was found if there is no effect.
    """

    value: float
    std: float
    frequency: RealArray
    each: RealArray
    covariance: RealArray
    p_shared: float
    p_none: float

    @property
    def shared(self) -> bool:
        """Whether one slope for all frequencies is in force."""
        return self.p_shared > ALIKE

    @property
    def verdict(self) -> Verdict:
        """Whether an effect is seen, by a test at three standard deviations, hinted at, or none."""
        return verdict_of(self.p_none)

    def percent(self) -> str:
        """Return it in percent per 100 Pa."""
        return f"{1e4 * self.value:+.2f} ± {1e4 * self.std:.2f} %"

    def at(self, frequency: float) -> tuple[float, float]:
        """Return slope and standard deviation of one frequency by itself; nan where no two stresses are known."""
        index = np.flatnonzero(self.frequency == frequency)
        if not index.size:
            return float("nan"), float("nan")
        i = int(index[0])
        return float(self.each[i]), float(np.sqrt(self.covariance[i, i]))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "per_pa": self.value, "std_per_pa": self.std, "verdict": self.verdict, "shared": self.shared,
            "p_shared": self.p_shared, "p_none": self.p_none, "frequency_hz": self.frequency.tolist(),
            "each_per_pa": self.each.tolist(), "each_std_per_pa": np.sqrt(np.diag(self.covariance)).tolist(),
        }  # fmt: skip


@dataclass(frozen=True)
class PreloadResult:
    """Moduli at zero stress and what stress does to them.

    Attributes
    ----------
    campaigns : list of str
    regression : Regression
        The measured values, and what they are a function of.
    solution : Solution
        ln E1 of every cell (specimen and frequency) at zero stress, then its loss factors, and the slopes.
    storage, loss : Slope
        Of E1 and of the loss factor.
    remarks : list of str
    """

    campaigns: list[str]
    regression: Regression
    solution: Solution
    storage: Slope
    loss: Slope
    remarks: list[str] = field(default_factory=list)

    @property
    def points(self) -> list[ModulusPoint]:
        """The measured values."""
        return self.regression.points

    @property
    def cells(self) -> list[Cell]:
        """Specimens and frequencies, in order."""
        return self.regression.cells

    @property
    def p_value(self) -> float:
        """Probability of a scatter as large as this by the stated errors; nan where nothing is left to scatter."""
        degrees = self.solution.degrees
        return exceeding(self.solution.chi_square, degrees) if degrees else float("nan")

    @property
    def verdict(self) -> str:
        """What was found, in a sentence."""
        if self.storage.verdict == "none" and self.loss.verdict == "none":
            top = max(p.stress for p in self.points)
            return f"no effect of the static stress is seen: at {top:.3g} Pa E1 changes by {self._at(top)}"
        found = [
            f"{name} {'changes' if slope.verdict == 'seen' else 'may change'} by {slope.percent()} per 100 Pa"
            for name, slope in (("E1", self.storage), ("the loss factor", self.loss))
            if slope.verdict != "none"
        ]
        return f"{' and '.join(found)} of static stress; the values at zero stress are extrapolated"

    def _at(self, stress: float) -> str:
        change, spread = 100 * stress * self.storage.value, 100 * stress * self.storage.std
        return f"{change:+.2f} ± {spread:.2f} %"

    def rows(self) -> list[dict[str, Any]]:
        """Return one row of `COLUMNS` per specimen and frequency."""
        return [self._row(i, cell) for i, cell in enumerate(self.cells)]

    def _row(self, index: int, cell: Cell) -> dict[str, Any]:
        own = [index, len(self.cells) + index]
        e1, loss = float(np.exp(self.solution.z[own[0]])), float(self.solution.z[own[1]])
        c = self.solution.scale**2 * self.solution.covariance[np.ix_(own, own)]
        std = float(np.sqrt(c[0, 0])), float(np.sqrt(c[1, 1]))
        slope = np.array([loss, 1.0])  # of E2/E1_0 by (ln E1, loss factor)
        stress = [p.stress for p in self.points if (p.specimen, p.frequency) == cell]
        values = (
            specimen_name(cell[0]), cell[1], len(stress), min(stress), max(stress), e1, e1 * std[0], e1 * loss,
            e1 * float(np.sqrt(slope @ c @ slope)), loss, std[1], *self.storage.at(cell[1]), *self.loss.at(cell[1]),
        )  # fmt: skip
        return dict(zip(COLUMNS, values, strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        values = [
            (self.campaigns[p.campaign], p.configuration, p.frequency, p.stress, p.storage_modulus, p.loss_factor)
            for p in self.points
        ]
        names = ("campaign", "configuration", "frequency_hz", "stress_pa", "E1_pa", "loss_factor")
        return {
            "version": 1,
            "campaigns": self.campaigns,
            "verdict": self.verdict,
            "E1_slope": self.storage.to_dict(),
            "loss_factor_slope": self.loss.to_dict(),
            "chi_square": self.solution.chi_square,
            "degrees": self.solution.degrees,
            "p_value": None if np.isnan(self.p_value) else self.p_value,
            "errors_enlarged_by": self.solution.scale,
            "zero_stress": [{name: _known(value) for name, value in row.items()} for row in self.rows()],
            "values": [dict(zip(names, row, strict=True)) for row in values],
            "remarks": self.remarks,
        }

    def to_csv(self) -> str:
        """Return ``preload.csv``."""
        return csv_table(COLUMNS, (row.values() for row in self.rows()))


def _known(value: Any) -> Any:
    return None if isinstance(value, float) and np.isnan(value) else value


def specimen_name(specimen: Specimen) -> str:
    """Return ``h25mm-r22.5mm``."""
    return f"h{1e3 * specimen[0]:.6g}mm-r{1e3 * specimen[1]:.6g}mm"
