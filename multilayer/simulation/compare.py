"""Measured spectra beside predicted ones, and the differences between them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.csv_table import csv_table
from multilayer.errors import InputError
from multilayer.simulation.closest_values import ClosestValue, closest_values, fields_sought
from multilayer.simulation.measured import Measured
from multilayer.simulation.quantities import QUANTITIES
from multilayer.simulation.result import CaseResult, SimulationResult, plain_list
from multilayer.simulation.run import Plan
from multilayer.simulation.tasks import Task, run_task

OF_SOUND = ("absorption", "transmission_loss", "insertion_loss", "reflection", "transmission", "normalised_impedance")


@dataclass(frozen=True)
class Misfit:
    """How far a prediction lies from what was measured.

    Attributes
    ----------
    case, quantity : str
    rms, largest : float
        Of the difference, of its absolute value where it is complex; in the unit of the quantity.
    worst_frequency : float
        Hz, where the difference is largest.
    inside : float or None
        Share of the measured values between the 5 and 95 % percentiles; None without tolerances.
    """

    case: str
    quantity: str
    rms: float
    largest: float
    worst_frequency: float
    inside: float | None


@dataclass(frozen=True)
class Comparison:
    """A measurement and its prediction at the same frequencies.

    Attributes
    ----------
    measured : Measured
    predicted : SimulationResult
    closest_values : tuple of ClosestValue
        Of each quantity of sound, in the case that predicts it best; empty where they were not asked for.
    sought : tuple of str
        Quantities for which such values were sought.
    not_sought : tuple of str
        Fields that were left out.
    """

    measured: Measured
    predicted: SimulationResult
    closest_values: tuple[ClosestValue, ...] = ()
    sought: tuple[str, ...] = ()
    not_sought: tuple[str, ...] = ()

    @property
    def quantities(self) -> list[str]:
        """Names of the quantities that are both measured and predicted, in the order of `QUANTITIES`."""
        return [name for name in QUANTITIES if name in self.measured.quantities and self._is_predicted(name)]

    @property
    def left_out(self) -> list[str]:
        """Names of the quantities that are measured but not predicted."""
        return [name for name in self.measured.quantities if not self._is_predicted(name)]

    def _is_predicted(self, name: str) -> bool:
        return all(name in case.quantities for case in self.predicted.cases)

    @cached_property
    def misfits(self) -> list[Misfit]:
        """One per case and quantity."""
        return [self._misfit(case, name) for case in self.predicted.cases for name in self.quantities]

    @property
    def best(self) -> dict[str, Misfit]:
        """By quantity, the misfit of the case that predicts it best."""
        of_quantity = {name: self.misfits[i :: len(self.quantities)] for i, name in enumerate(self.quantities)}
        return {name: min(misfits, key=lambda misfit: misfit.rms) for name, misfits in of_quantity.items()}

    def _misfit(self, case: CaseResult, name: str) -> Misfit:
        difference = np.abs(case.quantities[name] - self.measured.quantities[name])
        worst = int(np.argmax(difference))
        rms = float(np.sqrt(np.mean(difference**2)))
        frequency = float(self.predicted.frequency[worst])
        return Misfit(case.label, name, rms, float(difference[worst]), frequency, self._inside(case, name))

    def _inside(self, case: CaseResult, name: str) -> float | None:
        if not case.percentiles:
            return None
        measured = QUANTITIES[name].parts(self.measured.quantities[name])
        within = [
            (case.percentiles[column][0] <= values) & (values <= case.percentiles[column][-1])
            for column, values in measured.items()
        ]
        return float(np.mean(within))

    def _columns(self, case: CaseResult) -> dict[str, RealArray]:
        """Return the measured values, as ``NAME_measured``, and the predicted ones, as ``NAME_predicted``."""
        columns: dict[str, RealArray] = {}
        for name in self.quantities:
            for column, values in QUANTITIES[name].parts(self.measured.quantities[name]).items():
                columns[f"{column}_measured"] = values
                alike = {k: v for k, v in case.columns.items() if k == column or k.startswith(f"{column}_p")}
                columns |= {key.replace(column, f"{column}_predicted", 1): value for key, value in alike.items()}
        return columns

    def to_csv(self) -> str:
        """Return one row per case and frequency."""
        tables = [(case.label, self._columns(case)) for case in self.predicted.cases]
        rows = (
            [label, *row]
            for label, columns in tables
            for row in zip(self.predicted.frequency, *columns.values(), strict=True)
        )
        return csv_table(["case", "frequency_hz", *tables[0][1]], rows)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "version": 1,
            "name": self.predicted.name,
            "measured": self.measured.name,
            "settings": dict(self.predicted.settings),
            "misfits": [_misfit_dict(misfit) for misfit in self.misfits],
            "closest_values": [asdict(value) for value in self.closest_values],
            "frequency_hz": self.predicted.frequency.tolist(),
            "cases": [
                {"label": case.label, **{name: plain_list(values) for name, values in self._columns(case).items()}}
                for case in self.predicted.cases
            ],
        }


def _misfit_dict(misfit: Misfit) -> Mapping[str, Any]:
    return {
        "case": misfit.case,
        "quantity": misfit.quantity,
        "unit": QUANTITIES[misfit.quantity].unit,
        **dict(zip(("rms", "largest"), plain_list(np.array([misfit.rms, misfit.largest])), strict=True)),
        "worst_frequency_hz": misfit.worst_frequency,
        "inside_percentiles": misfit.inside,
    }


def compare(measured: Measured, predicted: SimulationResult) -> Comparison:
    """Return a measurement beside its prediction.

    Parameters
    ----------
    measured : Measured
    predicted : SimulationResult
        At the measured frequencies.

    Raises
    ------
    InputError
        When the simulation predicts nothing of what was measured.
    """
    comparison = Comparison(measured, predicted)
    if not comparison.quantities:
        raise _nothing(measured, predicted.cases[0].quantities)
    return comparison


def refuse_not_predicted(measured: Measured, plan: Plan) -> None:
    """Refuse what `compare` would refuse, before everything is computed: the first case is at one frequency or band.

    Raises
    ------
    InputError
        When it predicts nothing of what was measured, or cannot be computed.
    """
    first = plan.tasks[0]
    predicted = run_task(replace(first, frequency=first.frequency[:1], deviations={})).quantities
    if not set(measured.quantities) & set(predicted):
        raise _nothing(measured, predicted)


def _nothing(measured: Measured, predicted: Iterable[str]) -> InputError:
    return InputError(
        f"{measured.name} holds {', '.join(measured.quantities)}, and this simulation predicts "
        f"{', '.join(predicted)}; change its termination, incidence, frequency or reference"
    )


def searches(comparison: Comparison, plan: Plan) -> dict[str, Task]:
    """Return by quantity of sound the task of the case that predicts it best, whose fields can be sought."""
    labels = [case.label for case in comparison.predicted.cases]
    best = {
        name: plan.tasks[plan.case_of.index(labels.index(misfit.case))]
        for name, misfit in comparison.best.items()
        if name in OF_SOUND
    }
    return {name: task for name, task in best.items() if fields_sought(task)}


def with_closest_values(
    comparison: Comparison,
    tasks: Mapping[str, Task],
    executor: Executor | None = None,
    progress: Callable[[str], None] | None = None,
) -> Comparison:
    """Return a comparison with values of single fields that bring predictions closest to what was measured.

    Parameters
    ----------
    comparison : Comparison
    tasks : mapping
        As `searches` returns them.
    executor, progress
        As of `closest_values`.
    """
    found, left_out = [], []
    for name, task in tasks.items():
        values, missing = closest_values(task, name, comparison.measured.quantities[name], executor, progress)
        found += values
        left_out += missing
    return replace(
        comparison, closest_values=tuple(found), sought=tuple(tasks), not_sought=tuple(dict.fromkeys(left_out))
    )
