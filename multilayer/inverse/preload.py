"""What the static weight on a sample does to its modulus, and the modulus without any.

``E1 = E1_0 (1 + b s)`` and ``E2/E1 = eta_0 (1 + d s)``, s the static stress: at every frequency and for every specimen
(height and radius) values at zero stress, the slopes b and d common to all specimens, and to all frequencies where the
data allow. So slopes come from what differs between top plates over the same specimen, never between specimens.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from scipy.stats import chi2

from multilayer.arrays import RealArray
from multilayer.errors import InputError
from multilayer.inverse.modulus_points import ModulusPoint, Specimen
from multilayer.inverse.result import csv_cell
from multilayer.inverse.stress_regression import Cell, Regression, Solution

COLUMNS = (
    "specimen", "frequency_hz", "values", "stress_low_pa", "stress_high_pa", "E1_0_pa", "E1_0_std_pa", "E2_0_pa",
    "E2_0_std_pa", "loss_factor_0", "loss_factor_0_std", "E1_slope_per_pa", "E1_slope_std_per_pa",
    "loss_factor_slope_per_pa", "loss_factor_slope_std_per_pa",
)  # fmt: skip
Verdict = Literal["seen", "hint", "none"]
_ONE_SLOPE = 0.01  # least probability at which one slope for all frequencies is kept
_SEEN, _HINT = 0.0027, 0.05  # three and two standard deviations
_ALIKE = 0.01  # relative: stresses nearer than this are one


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
        return self.p_shared > _ONE_SLOPE

    @property
    def verdict(self) -> Verdict:
        """Whether an effect is seen, by a test at three standard deviations, hinted at, or none."""
        return "seen" if self.p_none < _SEEN else "hint" if self.p_none < _HINT else "none"

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
    points : list of ModulusPoint
        The measured values.
    cells : list of (specimen, frequency)
    zero : array, shape (2 n_cells,)
        ln E1 of every cell at zero stress, then its loss factors.
    covariance : array
        Of `zero`.
    storage, loss : Slope
        Of E1 and of the loss factor.
    chi_square : float
    degrees : int
    scale : float
        By which all standard deviations were enlarged, for a scatter beyond the stated errors; 1 otherwise.
    remarks : list of str
    """

    campaigns: list[str]
    points: list[ModulusPoint]
    cells: list[Cell]
    zero: RealArray
    covariance: RealArray
    storage: Slope
    loss: Slope
    chi_square: float
    degrees: int
    scale: float
    remarks: list[str] = field(default_factory=list)

    @property
    def p_value(self) -> float:
        """Probability of a scatter as large as this by the stated errors; nan where nothing is left to scatter."""
        return float(chi2.sf(self.chi_square, self.degrees)) if self.degrees else float("nan")

    def rows(self) -> list[dict[str, Any]]:
        """Return one row of `COLUMNS` per specimen and frequency."""
        return [self._row(i, cell) for i, cell in enumerate(self.cells)]

    def _row(self, index: int, cell: Cell) -> dict[str, Any]:
        own = [index, len(self.cells) + index]
        e1, loss = float(np.exp(self.zero[own[0]])), float(self.zero[own[1]])
        c = self.covariance[np.ix_(own, own)]
        std = float(np.sqrt(c[0, 0])), float(np.sqrt(c[1, 1]))
        slope = np.array([loss, 1.0])  # of E2/E1_0 by (ln E1, loss factor)
        stress = [p.stress for p in self.points if (p.specimen, p.frequency) == cell]
        values = (
            specimen_name(cell[0]), cell[1], len(stress), min(stress), max(stress), e1, e1 * std[0], e1 * loss,
            e1 * float(np.sqrt(slope @ c @ slope)), loss, std[1], *self.storage.at(cell[1]), *self.loss.at(cell[1]),
        )  # fmt: skip
        return dict(zip(COLUMNS, values, strict=True))

    def to_csv(self) -> str:
        """Return ``preload.csv``."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in self.rows():
            writer.writerow([csv_cell(value) for value in row.values()])
        return text.getvalue()


def specimen_name(specimen: Specimen) -> str:
    """Return ``h25mm-r22.5mm``."""
    return f"h{1e3 * specimen[0]:.6g}mm-r{1e3 * specimen[1]:.6g}mm"


def fit_preload(campaigns: Sequence[str], points: Sequence[ModulusPoint], remarks: Sequence[str] = ()) -> PreloadResult:
    """Find slopes and values at zero stress.

    Parameters
    ----------
    campaigns : sequence of str
        Their names.
    points : sequence of ModulusPoint
    remarks : sequence of str
        What a reader should know besides.

    Raises
    ------
    InputError
        When no specimen was measured under two top plates.

    Notes
    -----
    Generalised least squares by Gauss and Newton's steps. The covariance holds the errors that bursts share (see
    `modulus_points.covariance_of`): those of gain, delay, thickness, density and plate mass mostly leave a slope alone,
    and the value at zero stress keeps them in full.
    """
    contrasted = _contrasted(points)
    if not contrasted:
        stresses = ", ".join(f"{s:.3g} Pa" for s in sorted({round(p.stress, 1) for p in points}))
        raise InputError(
            f"{', '.join(campaigns)}: no specimen (height and radius) has accepted bursts of one frequency under two "
            f"static stresses ({stresses}); measure each under two top plates, or name several campaigns"
        )
    apart = Regression([p for p in points if p.frequency in contrasted], contrasted, (True, True))
    found = apart.solve()
    scale = found.scale
    p_shared = [_p_equal(found.slopes[k], scale**2 * found.slope_covariance[k]) for k in range(2)]
    apart_in = (p_shared[0] <= _ONE_SLOPE, p_shared[1] <= _ONE_SLOPE)
    kept = apart.points if any(apart_in) else list(points)
    last = Regression(kept, contrasted, apart_in)
    final = last.solve()
    slopes = [_slope(k, contrasted, found, final, p_shared[k], apart_in[k]) for k in range(2)]
    n = 2 * len(last.cells)
    return PreloadResult(
        list(campaigns), kept, last.cells, final.z[:n], final.scale**2 * final.covariance[:n, :n],
        slopes[0], slopes[1], final.chi_square, final.degrees, final.scale, list(remarks),
    )  # fmt: skip


def _contrasted(points: Sequence[ModulusPoint]) -> list[float]:
    """Return the frequencies at which some specimen was measured under two stresses."""
    by_cell: dict[Cell, list[float]] = {}
    for point in points:
        by_cell.setdefault((point.specimen, point.frequency), []).append(point.stress)
    return sorted({f for (_, f), stress in by_cell.items() if max(stress) > (1 + _ALIKE) * min(stress)})


def _p_equal(values: RealArray, covariance: RealArray) -> float:
    """Return the probability of values as different as these if they are one."""
    if len(values) < 2:
        return 1.0
    mean, _ = combined(values, covariance)
    return float(chi2.sf(_distance(values - mean, covariance), len(values) - 1))


def combined(values: RealArray, covariance: RealArray) -> tuple[float, float]:
    """Return the mean of correlated values and its variance."""
    weights = np.linalg.solve(covariance, np.ones(len(values)))
    variance = 1 / float(weights.sum())
    return variance * float(weights @ values), variance


def _distance(difference: RealArray, covariance: RealArray) -> float:
    return float(difference @ np.linalg.solve(covariance, difference))


def _slope(
    which: int, frequencies: list[float], found: Solution, final: Solution, p_shared: float, apart: bool
) -> Slope:
    scale = max(found.scale, final.scale)
    each, covariance = found.slopes[which], scale**2 * found.slope_covariance[which]
    if apart:
        value, variance = combined(each, covariance)
        p_none = float(chi2.sf(_distance(each, covariance), len(each)))
    else:
        value, variance = float(final.slopes[which][0]), scale**2 * float(final.slope_covariance[which][0, 0])
        p_none = float(chi2.sf(value**2 / variance, 1))
    return Slope(value, float(np.sqrt(variance)), np.array(frequencies), each, covariance, p_shared, p_none)
