"""Cases of a sweep that differ in numbers of their layers alone, computed together: every medium once for all."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError, MultilayerError
from multilayer.paths import value_at, with_values
from multilayer.simulation.tasks import Outcome, Task, run_task, takes_arrays
from multilayer.stack import Stack


@dataclass(frozen=True)
class Batch:
    """Consecutive tasks.

    Attributes
    ----------
    tasks : tuple of Task
    values : dict
        By path, the values of the fields in which their stacks differ, one for each task; empty where the tasks are
        run one by one.
    """

    tasks: tuple[Task, ...]
    values: dict[str, RealArray]


def batches(tasks: Sequence[Task], paths: Sequence[str], size: int) -> list[Batch]:
    """Return tasks in batches, in their order.

    Parameters
    ----------
    tasks : sequence of Task
    paths : sequence of str
        All that is swept.
    size : int
        Most tasks of a batch.
    """
    made: list[Batch] = []
    for task in tasks:
        values = _numbers(task, paths)
        if values and made and len(made[-1].tasks) < size and _continues(made[-1], task.stack, values):
            last = made.pop()
            columns = {path: np.append(column, values[path]) for path, column in last.values.items()}
            made.append(Batch((*last.tasks, task), columns))
        else:
            made.append(Batch((task,), {path: np.array([value]) for path, value in values.items()}))
    return made


def _numbers(task: Task, paths: Sequence[str]) -> dict[str, float]:
    """Return what layers hold at those paths that lead to a number; nothing where tasks may differ beside the stack."""
    values: dict[str, float] = {}
    roots = {path.partition(".")[0] for path in paths}
    if task.samples or task.deviations or not takes_arrays(task, []) or not roots <= Stack.model_fields.keys():
        return values
    for path in paths:
        with suppress(InputError):  # as of a material, whose name the stack does not keep
            value = value_at(task.stack, path)
            if path.startswith("layers.") and isinstance(value, float):
                values[path] = value
    return values


def _continues(batch: Batch, stack: Stack, values: dict[str, float]) -> bool:
    """Tell whether a stack differs from those of a batch in these numbers and in nothing else."""
    return batch.values.keys() == values.keys() and with_values(batch.tasks[0].stack, values) == stack


def run_batch(batch: Batch) -> tuple[Outcome, ...]:
    """Return the outcome of every task; see `run_task`."""
    if len(batch.tasks) > 1:
        # of a case without a response, or a plugin's layer that takes no arrays: one by one, which tells the case
        with suppress(MultilayerError, ArithmeticError, TypeError, ValueError):
            whole = run_task(replace(batch.tasks[0], samples=batch.values))
            return tuple(
                Outcome({name: values[i] for name, values in whole.quantities.items()}, whole.warnings)
                for i in range(len(batch.tasks))
            )
    return tuple(run_task(task) for task in batch.tasks)
