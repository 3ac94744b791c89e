"""Measured spectra beside predicted ones, and the differences between them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from multilayer.arrays import BoolArray, RealArray
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
        Of the difference, of its absolute value where it is complex; in the unit of the quantity. Where nothing was
        measured, or is predicted (no free wave), it is left out.
    worst_frequency : float
        Hz, where the difference is largest.
    inside : float or None
        Share of the measured values between the 5 and 95 % percentiles; None without these.
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

    @cached_property
    def quantities(self) -> list[str]:
        """Names of the quantities that are both measured and predicted, in the order of `QUANTITIES`."""
        predicted = [_predicted(case, self.measured) for case in self.predicted.cases]
        common = set(self.measured.quantities).intersection(*predicted)
        return [name for name in QUANTITIES if name in common]

    @property
    def left_out(self) -> list[str]:
        """What is measured but not predicted: names of quantities, of others at how many frequencies of all cases."""
        told = [name for name in self.measured.quantities if name not in self.quantities]
        for name in self.quantities:
            there = ~np.isnan(self.measured.quantities[name])
            missing = sum(np.count_nonzero(np.isnan(case.quantities[name][there])) for case in self.predicted.cases)
            if missing:
                n = len(self.predicted.cases)
                of_cases = f" of {n} cases" if n > 1 else ""
                told.append(f"{name} at {missing} of {n * np.count_nonzero(there)} frequencies{of_cases}")
        return told

    @cached_property
    def misfits(self) -> list[Misfit]:
        """One per case and quantity."""
        return [self._misfit(case, name) for case in self.predicted.cases for name in self.quantities]

    @property
    def best(self) -> dict[str, Misfit]:
        """By quantity, the misfit of the case that predicts it best."""
        return {name: self._of_quantity(name)[case] for name, case in self.best_case.items()}

    @property
    def best_case(self) -> dict[str, int]:
        """By quantity, which case predicts it best."""
        return {name: int(np.argmin([misfit.rms for misfit in self._of_quantity(name)])) for name in self.quantities}

    def _of_quantity(self, name: str) -> list[Misfit]:
        return [misfit for misfit in self.misfits if misfit.quantity == name]

    def _misfit(self, case: CaseResult, name: str) -> Misfit:
        difference = np.abs(case.quantities[name] - self.measured.quantities[name])
        worst = int(np.nanargmax(difference))
        rms = float(np.sqrt(np.nanmean(difference**2)))
        frequency = float(self.predicted.frequency[worst])
        return Misfit(case.label, name, rms, float(difference[worst]), frequency, self._inside(case, name))

    def _inside(self, case: CaseResult, name: str) -> float | None:
        if not case.percentiles:
            return None
        within: list[BoolArray] = []
        for column, values in QUANTITIES[name].parts(self.measured.quantities[name]).items():
            low, *_, high = case.percentiles[column]
            known = ~(np.isnan(low) | np.isnan(high) | np.isnan(values))
            within.append(((low <= values) & (values <= high))[known])
        inside = np.concatenate(within)
        return float(np.mean(inside)) if inside.size else None

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
        When the simulation predicts nothing of what was measured in all of its cases.
    """
    _refuse_nothing_common(measured, ((case.label, _predicted(case, measured)) for case in predicted.cases))
    return Comparison(measured, predicted)


def _predicted(case: CaseResult, measured: Measured) -> list[str]:
    """Return the names of what a case predicts; of what was measured, where it was at one frequency at least."""
    numbers = {name: values - measured.quantities.get(name, 0.0) for name, values in case.quantities.items()}
    return [name for name, values in numbers.items() if not np.all(np.isnan(values))]


def refuse_not_predicted(measured: Measured, plan: Plan) -> None:
    """Refuse what `compare` would refuse, before everything is computed: cases are at one frequency or band.

    Of cases that predict the same quantities the first is.

    Raises
    ------
    InputError
        When they predict nothing in common of what was measured, or cannot be computed.
    """
    different = {_kind(task): task for task in reversed(_nominal(plan))}
    alone = (replace(task, frequency=task.frequency[:1], deviations={}) for task in reversed(different.values()))
    _refuse_nothing_common(measured, ((task.label, run_task(task).quantities) for task in alone))


def _nominal(plan: Plan) -> list[Task]:
    """Return the tasks of the cases themselves, in their order."""
    return [task for task in plan.tasks if not task.samples]


def _kind(task: Task) -> tuple[Any, ...]:
    """Return what of a case decides which quantities it predicts."""
    kinds = [type(part) for part in (task.stack, task.incidence, task.excitation, task.duct)]
    return (str(task.stack.termination), *kinds)


def _refuse_nothing_common(measured: Measured, predicted: Iterable[tuple[str, Collection[str]]]) -> None:
    """Refuse a measurement of which cases, by their labels, predict nothing in common."""
    common = list(measured.quantities)
    for label, names in predicted:
        left = [name for name in common if name in names]
        if not left:
            which = f"the case {label}" if label else "this simulation"
            remedy = "change its termination, incidence, frequency or reference"
            remedy += ", or leave it out of the sweep" if label else ""
            held, told = ", ".join(common), ", ".join(names)
            raise InputError(f"{measured.name} holds {held}, and {which} predicts {told}; {remedy}")
        common = left


def searches(comparison: Comparison, plan: Plan) -> dict[str, Task]:
    """Return by quantity of sound the task of the case that predicts it best, whose fields can be sought."""
    nominal = _nominal(plan)
    best = {name: nominal[case] for name, case in comparison.best_case.items() if name in OF_SOUND}
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
