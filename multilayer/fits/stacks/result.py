"""What a fit of stacks says, and how it is written down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.chi2 import exceeding
from multilayer.config.yaml12 import dump_yaml
from multilayer.csv_table import csv_table
from multilayer.experiments.stacks.problem import FARTHEST
from multilayer.fits.methods import STACKS
from multilayer.fits.result import FitResult
from multilayer.frames import Column, Frame, Tabular, over
from multilayer.inference.posterior import Band
from multilayer.inference.priors import Parameter
from multilayer.inference.pulls import SIGNIFICANT, Pull, beyond_chance, pulls_p_value, spreads_by_chance
from multilayer.inference.summary import PosteriorSummary
from multilayer.simulation.result import plain_list
from multilayer.stack import Stack

POOR = 2.0  # chi-square per datum: the model misses more than noise
_STRONG = 0.9  # correlation that is told
UNDETERMINED = 0.5  # of the prior's spread: what is left of it, from where on the data say little


@dataclass(frozen=True)
class FoundQuantity:
    """An unknown as the data leave it.

    Attributes
    ----------
    name, unit : str
    value : float
        The most probable one, SI.
    std : float
        Standard deviation.
    intervals : tuple of (low, high)
        That hold it with 68 and 90 %, as much below as above.
    left : float
        Standard deviation after over that before the measurement; of the logarithm where the prior is about that.
    nuisance : bool
    """

    name: str
    unit: str
    value: float
    std: float
    intervals: tuple[tuple[float, float], ...]
    left: float
    nuisance: bool = False

    @property
    def determined(self) -> bool:
        """Whether the data say more than was known before."""
        return self.left < UNDETERMINED

    def row(self) -> list[Any]:
        """Return the values of `PARAMETER_COLUMNS`."""
        ends = [end for interval in self.intervals for end in interval]
        return [self.name, self.unit, self.value, self.std, *ends, self.left, self.determined]


PARAMETER_COLUMNS = (
    "name", "unit", "value", "std", "low_68", "high_68", "low_90", "high_90", "left_of_prior", "determined",
)  # fmt: skip


@dataclass(frozen=True, repr=False)
class FittedCurve(Tabular):
    """One measurement beside what the fitted stack gives.

    Attributes
    ----------
    name, kind, stack, unit : str
    frequency : array, shape (n,)
        Hz.
    measured, predicted : array, shape (n,)
        In `unit`.
    residual : array, shape (n_data,)
        Whitened, in the fitted quantity; real parts first.
    band : Band
        That holds each point of the fitted curve at 90 %, part by part as `parts_of` has it.
    """

    name: str
    kind: str
    stack: str
    unit: str
    frequency: RealArray
    measured: NDArray[Any]
    predicted: NDArray[Any]
    residual: RealArray
    band: Band = field(repr=False)

    @property
    def rms(self) -> float:
        """Of the difference, in `unit`."""
        return float(np.sqrt(np.mean(np.abs(self.predicted - self.measured) ** 2)))

    @property
    def misfit(self) -> float:
        """Sum of the squared residuals: chi-square."""
        return float(self.residual @ self.residual)

    @property
    def frame(self) -> Frame:
        """Measured and predicted values over frequency."""
        values = {"measured": self.measured, "predicted": self.predicted}
        units = {"frequency": "Hz", **dict.fromkeys(values, self.unit)}
        return over({"frequency": self.frequency}, values, units, {"name": self.name, "kind": self.kind})

    def columns(self) -> dict[str, RealArray]:
        """Return measured and predicted values and residuals by column, real and imaginary part."""
        found: dict[str, RealArray] = {}
        for what, values in (("measured", self.measured), ("predicted", self.predicted)):
            found |= {f"{what}_re": values.real, f"{what}_im": values.imag}
        n = len(self.frequency)
        return found | {"residual_re": self.residual[:n], "residual_im": np.resize(self.residual[n:], n)}


def parts_of(kind: str, values: NDArray[Any], near: NDArray[Any] | None = None) -> RealArray:
    """Return the parts that a curve is drawn by, shape (..., n_parts, n), of values of shape (..., n).

    The values themselves where real; amplitude and phase (degrees) of a transmissibility, the phase unwrapped, or
    within half a turn of that of `near`; else real and imaginary part.
    """
    if not np.iscomplexobj(values):
        return np.asarray(values[..., None, :])
    if kind != "transmissibility":
        return np.stack([values.real, values.imag], axis=-2)
    phase = np.unwrap(np.angle(values)) if near is None else np.unwrap(np.angle(near)) + np.angle(values / near)
    return np.stack([np.abs(values), np.rad2deg(phase)], axis=-2)


@dataclass(frozen=True)
class FoundMinimum:
    """A set of values that fits better than all near it.

    Attributes
    ----------
    values : tuple of float
        Of the quantities, SI, in their order.
    misfit : float
        Chi-square of the data.
    cost : float
        That and the squared distance from the priors' centres.
    probability : float
        Of this minimum among those found, by Laplace's approximation.
    converged : bool
    """

    values: tuple[float, ...]
    misfit: float
    cost: float
    probability: float
    converged: bool


@dataclass(frozen=True)
class Statements:
    """What normal and lognormal priors state, and by how much a fit departs from it.

    Attributes
    ----------
    parameters : tuple of Parameter
        With such priors.
    deviations : array, shape (k,)
        From the priors' centres, in their standard deviations.
    covariance : array, shape (k, k)
        Of these.
    """

    parameters: tuple[Parameter, ...]
    deviations: RealArray
    covariance: RealArray = field(repr=False)

    @property
    def p_value(self) -> float:
        """Probability that chance takes the fit as far off, from one of the priors or from all of them together.

        Of a prior that the data seem hardly to narrow, too: chance moves no unknown by more than its prior's spread.
        """
        largest = float(np.max(np.abs(self.deviations), initial=0.0))
        return min(
            pulls_p_value(self.deviations, self.covariance), 2 * max(len(self.parameters), 1) * exceeding(largest**2, 1)
        )

    @property
    def remark(self) -> str:
        """Which of the priors the data contradict; empty where chance explains it."""
        if self.p_value > SIGNIFICANT:
            return ""
        by_chance = np.minimum(spreads_by_chance(self.covariance), 1.0)
        rows = zip(self.parameters, self.deviations.tolist(), by_chance.tolist(), strict=True)
        off = "; ".join(_told(pull) for pull in beyond_chance([Pull(*row) for row in rows]))
        return (
            f"this takes what the priors state for wrong, which has the probability {self.p_value:.1g}: {off}. Correct "
            "the prior, or find the cause: something acts that the model lacks, or is not as its file says"
        )


def _told(pull: Pull) -> str:
    """Return by how much a prior is off, and what chance makes of that."""
    if abs(pull.deviations) > FARTHEST:
        return f"{pull.in_words}, as far as the search goes"
    return pull.beside_chance


@dataclass(frozen=True, repr=False, kw_only=True)
class StackFitResult(FitResult):
    """Result of a fit of stacks.

    Attributes
    ----------
    quantities : list of FoundQuantity
    correlation : array, shape (n, n)
        Of the coordinates that were sought, one per quantity.
    minima : list of FoundMinimum
        All that were found, the most probable first.
    curves : list of FittedCurve
        At the first of them.
    scale : float
        By how much the standard deviations were widened because the model misses the data by more than their noise.
    statements : Statements
        What the priors state, and whether the data contradict it.
    stacks : dict
        The fitted stacks by name.
    summary : PosteriorSummary
        Posterior, and what the data determine.
    """

    kind: ClassVar[str] = STACKS
    heading: ClassVar[tuple[str, ...]] = ("name",)

    quantities: list[FoundQuantity]
    correlation: RealArray
    minima: Sequence[FoundMinimum]
    curves: list[FittedCurve]
    scale: float
    statements: Statements
    stacks: dict[str, Stack] = field(repr=False)
    summary: PosteriorSummary = field(repr=False)

    @property
    def frame(self) -> Frame:
        """The columns of ``parameters.csv`` over the unknowns."""
        rows = zip(*(quantity.row() for quantity in self.quantities), strict=True)
        columns: dict[str, Column] = {
            name: (("name",), np.array(values)) for name, values in zip(PARAMETER_COLUMNS, rows, strict=True)
        }
        return Frame({"name": columns.pop("name")}, columns, {}, self.facts)

    @property
    def facts(self) -> dict[str, Any]:
        """Single values that hold for all of it."""
        return {"fit": self.name, "misfit_per_datum": self.misfit_per_datum, "converged": self.converged}

    @property
    def all_accepted(self) -> bool:
        """The same as `converged`."""
        return self.converged

    @property
    def converged(self) -> bool:
        """Whether the search ended in a minimum."""
        return self.minima[0].converged

    @property
    def misfit_per_datum(self) -> float:
        """Chi-square over the number of data: about 1 where model and noise are right."""
        n = sum(len(curve.residual) for curve in self.curves)
        return sum(curve.misfit for curve in self.curves) / n

    @property
    def misses(self) -> bool:
        """Whether the model misses the data by far, and by more than chance explains."""
        return self.misfit_per_datum > POOR and self.scale > 1

    @property
    def remarks(self) -> list[str]:
        """What a reader of the values must know."""
        told = []
        if not self.converged:
            told.append("the search stopped before it reached a minimum; begin from other values, or narrow the priors")
        if self.misses:
            told.append(
                f"chi-square is {self.misfit_per_datum:.3g} per datum: the model misses the data by more than noise; "
                f"intervals are {self.scale:.3g} times wider for it, and need not hold what a better model would give; "
                "look at the stated noise, too: a bare number is a share of each value, {absolute: 0.01} is in its unit"
            )
        elif self.scale > 1:
            text = "chance does not explain the misfit of data and priors together (p below 0.05)"
            told.append(f"intervals are {self.scale:.3g} times wider: {text}")
        if self.statements.remark:
            told.append(self.statements.remark)
        names = [quantity.name.removeprefix("layers.") for quantity in self.quantities]
        open_ones = [name for name, quantity in zip(names, self.quantities, strict=True) if not quantity.determined]
        if open_ones:
            text = "of these the prior tells as much as the data, or more"
            told.append(f"{text}: {', '.join(open_ones)}")
        rows, columns = np.nonzero(np.triu(np.abs(self.correlation) > _STRONG, k=1))
        for i, j in zip(rows.tolist(), columns.tolist(), strict=True):
            told.append(f"{names[i]} and {names[j]} go together (correlation {self.correlation[i, j]:.2f})")
        return [*told, *super().remarks]

    def quantity(self, name: str) -> FoundQuantity:
        """Return a quantity by its name."""
        return next(quantity for quantity in self.quantities if quantity.name == name)

    def to_csv(self) -> str:
        """Return the quantities as a table, SI."""
        return csv_table(PARAMETER_COLUMNS, [quantity.row() for quantity in self.quantities])

    def curves_csv(self) -> str:
        """Return the measurements beside the fit: one row per measurement and frequency."""
        rows = []
        header = ["measurement", "unit", "frequency_hz", *self.curves[0].columns()]
        for curve in self.curves:
            for f, *values in zip(curve.frequency.tolist(), *curve.columns().values(), strict=True):
                rows.append([curve.name, curve.unit, f, *map(float, values)])
        return csv_table(header, rows)

    @property
    def tables(self) -> dict[str, str]:
        """CSV tables by the name of their file."""
        return {"parameters.csv": self.to_csv(), "curves.csv": self.curves_csv()}

    def stack_files(self) -> dict[str, str]:
        """Return the text of a stack file for each fitted stack, by its name."""
        return {name: dump_yaml({"kind": "stack"} | stack.to_dict()) for name, stack in self.stacks.items()}

    def contents(self) -> dict[str, Any]:
        """Return what `to_dict` has of this kind of fit; the curves' values are in their CSV table."""
        return {
            "converged": self.converged,
            "misfit_per_datum": self.misfit_per_datum,
            "widened_by": self.scale,
            "stated_p_value": self.statements.p_value,
            "stated_deviations": {
                parameter.name: off
                for parameter, off in zip(self.statements.parameters, self.statements.deviations.tolist(), strict=True)
            },
            "parameters": [dict(zip(PARAMETER_COLUMNS, quantity.row(), strict=True)) for quantity in self.quantities],
            "correlation": [plain_list(row) for row in self.correlation],
            "minima": [self._minimum(minimum) for minimum in self.minima],
            "measurements": [_curve(curve) for curve in self.curves],
            "warnings": self.warnings,
        }

    def _minimum(self, minimum: FoundMinimum) -> dict[str, Any]:
        names = [quantity.name for quantity in self.quantities]
        return {
            "values": dict(zip(names, minimum.values, strict=True)),
            "misfit": minimum.misfit,
            "cost": minimum.cost,
            "probability": minimum.probability,
            "converged": minimum.converged,
        }


def _curve(curve: FittedCurve) -> dict[str, Any]:
    return {
        "name": curve.name,
        "kind": curve.kind,
        "stack": curve.stack,
        "unit": curve.unit,
        "n_data": len(curve.residual),
        "misfit": curve.misfit,
        **dict(zip(["rms"], plain_list(np.array([curve.rms])), strict=True)),
    }
