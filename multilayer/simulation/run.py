"""Running a simulation: from a file to tasks, from their outcomes to the result."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from warnings import catch_warnings, simplefilter, warn

import numpy as np

from multilayer.bounds import RESULT_BYTES, SOLVES, counted
from multilayer.errors import ValidityWarning
from multilayer.executors import as_done
from multilayer.log import LOGGER
from multilayer.response.chunks import POINTS
from multilayer.simulation.bands import Grid, grid_of
from multilayer.simulation.batches import batches, run_batch
from multilayer.simulation.file import Case, SimulationFile, load_simulation
from multilayer.simulation.percentiles import Percentiles, bytes_kept
from multilayer.simulation.quantities import columns_of
from multilayer.simulation.result import PERCENTILES, CaseResult, SimulationResult
from multilayer.simulation.settings import DiffuseIncidence, FrequencyRange
from multilayer.simulation.single_numbers import ratings
from multilayer.simulation.spread import standard_deviation
from multilayer.simulation.tasks import Arrays, Outcome, Task, hidden_between, refuse_unsound
from multilayer.simulation.tolerances import draw
from multilayer.stack import Ambient

_MOST_VALUES = 10_000  # frequencies times angles times samples of a task: some hundred MB in a stack of many layers
_FASTEST = 20_000  # points of cases of a sweep: more at a time gain nothing
_MOST_SAMPLES = 50
_MANY_LAYERS = 10  # of which cases of a sweep take as much memory together as samples
_ANGLES_OF_DIFFUSE_FIELD = 60
_WAVENUMBERS_OF_EXCITATION = 200
_WAVENUMBERS_OF_FREE_WAVES = 400
_WAVENUMBERS_OF_DUCT = 2700
_BYTES_OF_RESULT = 96  # all quantities at one frequency, once more where they are put together
_COLUMNS = 6  # of which there are percentiles
_BYTES_OF_DRAW = 16  # of a field, and its copy in a task
_BYTES_OF_SPREAD = 48  # of a field at one frequency: of absorption and losses, and their copies in tables
_BYTES_OF_LAYER = 1200  # face matrices of a poroelastic layer at one point


@dataclass(frozen=True)
class Plan:
    """All tasks of a simulation, in order: for each case the nominal one, then its samples in chunks.

    `spaced`: whether the frequencies are those of a range, and nobody asked for just these.
    """

    name: str
    simulation: SimulationFile
    grid: Grid
    tasks: tuple[Task, ...]
    case_of: tuple[int, ...]
    spaced: bool = False


def plan(simulation: SimulationFile, name: str = "simulation", grid: Grid | None = None) -> Plan:
    """Return the tasks of a simulation, with all samples drawn.

    Parameters
    ----------
    simulation : SimulationFile
    name : str
        Of the result.
    grid : Grid, optional
        Frequencies in place of those of the simulation.

    Raises
    ------
    InputError
        When hardly any draw within the tolerances is allowed, or the simulation needs more memory or solves than
        `bounds.RESULT_BYTES` and `bounds.SOLVES`.
    """
    spaced = grid is None and isinstance(simulation.frequency, FrequencyRange)
    grid = grid or grid_of(simulation.frequency)
    _refuse_endless(simulation, grid)
    tasks, case_of = [], []
    for i, case in enumerate(simulation.cases):
        of_case = list(_tasks(case, grid))
        tasks += of_case
        case_of += [i] * len(of_case)
    return Plan(name, simulation, grid, tuple(tasks), tuple(case_of), spaced)


def _refuse_endless(simulation: SimulationFile, grid: Grid) -> None:
    """Tell how much a simulation takes, and refuse what no machine of ours does."""
    solves, held, at_once = 0, 0, 0
    for case in simulation.cases:
        file = case.simulation
        samples = file.samples if file.scatter else 0
        angles = _ANGLES_OF_DIFFUSE_FIELD if isinstance(file.incidence, DiffuseIncidence) else 1
        angles += 0 if file.excitation is None else _WAVENUMBERS_OF_EXCITATION
        angles += _WAVENUMBERS_OF_FREE_WAVES if file.free_waves else 0
        angles += _WAVENUMBERS_OF_DUCT if file.duct is not None else 0
        points, layers = grid.points.size * angles, len(file.layers)
        solves += points * layers * (1 + samples)
        held += len(grid.frequency) * (_BYTES_OF_RESULT + _COLUMNS * bytes_kept(samples, len(PERCENTILES)))
        held += samples * len(file.scatter) * _BYTES_OF_DRAW
        held += len(grid.frequency) * len(file.scatter) * _BYTES_OF_SPREAD
        # samples are not cut into pieces along the frequencies
        alone = min(points, POINTS // max(1, layers // 50))
        cases = _points_at_once(layers) if len(simulation.cases) > 1 else 0
        together = max(grid.points.size, _MOST_VALUES) if samples else max(alone, cases)
        at_once = max(at_once, together * layers * _BYTES_OF_LAYER)
    LOGGER.info("%s solves of a layer, about %s MB of memory", counted(solves), counted((held + at_once) / 1e6))
    remedy = "ask for fewer frequencies, cases or samples"
    SOLVES.check(solves, remedy=remedy)
    RESULT_BYTES.check(held + at_once, remedy=remedy)


def _tasks(case: Case, grid: Grid) -> Iterator[Task]:
    file = case.simulation
    nominal = Task(
        file.stack, grid.points, file.incidence, case.label, file.finite_size, file.reference, file.excitation,
        file.free_waves, file.layer_losses, file.duct,
    )  # fmt: skip
    if not file.scatter:
        yield nominal
        return
    drawn = draw(file.stack, file.scatter, file.samples, file.seed)
    yield replace(nominal, deviations={path: standard_deviation(values) for path, values in drawn.items()})
    angles = _ANGLES_OF_DIFFUSE_FIELD if isinstance(file.incidence, DiffuseIncidence) else 1
    size = int(np.clip(_MOST_VALUES // (grid.points.size * angles), 1, _MOST_SAMPLES))
    sampled = replace(nominal, layer_losses=False)
    for start in range(0, file.samples, size):
        yield replace(sampled, samples={path: values[start : start + size] for path, values in drawn.items()})


def cases_at_once(plan: Plan) -> int:
    """Return how many cases of a sweep are computed together at most."""
    layers = max(len(case.simulation.layers) for case in plan.simulation.cases)
    return int(np.clip(_points_at_once(layers) // plan.grid.points.size, 1, _MOST_SAMPLES))


def _points_at_once(layers: int) -> int:
    return min(_MOST_VALUES * _MANY_LAYERS // max(1, layers), _FASTEST)


def run(
    plan: Plan, executor: Executor | None = None, progress: Callable[[str], None] | None = None
) -> SimulationResult:
    """Return the result of a plan.

    The numbers are the same whatever the executor.

    Parameters
    ----------
    plan : Plan
    executor : Executor, optional
        Of `concurrent.futures`, or anything alike; this process when left out.
    progress : callable, optional
        Called with the label of the case after each task.

    Raises
    ------
    InputError
        When a stack has no finite response, or one that creates energy.

    Warns
    -----
    ValidityWarning
        Where a model is used outside its range, once per text, and where narrow resonances lie between single
        frequencies of the first case.
    LostWorkerWarning
        When an executor failed on some tasks, which were then computed here.
    """
    cases = plan.simulation.cases
    together = batches(plan.tasks, [*cases[0].values], cases_at_once(plan))
    first = np.cumsum([0, *(len(batch.tasks) for batch in together)])
    nominal: dict[int, Outcome] = {}
    scatter: list[dict[str, Percentiles]] = [{} for _ in cases]
    warned: dict[int, tuple[str, ...]] = {}
    for index, outcomes in as_done(run_batch, together, executor):
        for i, outcome in enumerate(outcomes, first[index]):
            task, case = plan.tasks[i], plan.case_of[i]
            refuse_unsound(task, outcome, plan.grid.frequency)
            if outcome.warnings:
                warned[i] = outcome.warnings
            if task.samples:
                _add(scatter[case], outcome.quantities)
            else:
                nominal[case] = outcome
            if progress is not None:
                progress(cases[case].label)
    _warn_once(plan.tasks, dict(sorted(warned.items())))
    if plan.spaced and (text := hidden_between(plan.tasks[0], nominal[0].quantities)):  # of the first case: it is cheap
        warn(text, ValidityWarning, stacklevel=2)
    rated = ratings([nominal[i].quantities for i in range(len(cases))], plan.grid)
    return SimulationResult(
        plan.name,
        plan.grid.frequency,
        plan.grid.bands,
        tuple(_case_result(case, nominal[i], scatter[i], rated[i]) for i, case in enumerate(cases)),
        plan.simulation.to_dict(),
    )


def _add(percentiles: dict[str, Percentiles], quantities: Arrays) -> None:
    """Take samples of all quantities into the percentiles of their columns."""
    for name, values in columns_of(quantities).items():
        percentiles.setdefault(name, Percentiles(PERCENTILES)).add(values)


def _warn_once(tasks: Sequence[Task], warned: Mapping[int, tuple[str, ...]]) -> None:
    """Warn of the nominal cases' warnings; of one of the samples' only where the nominal cases have none."""
    texts: dict[bool, dict[str, None]] = {True: {}, False: {}}
    for i, warnings in warned.items():
        texts[not tasks[i].samples].update(dict.fromkeys(warnings))
    of_samples = [f"within the tolerances, {text}" for text in list(texts[False])[:1]]
    for text in list(texts[True]) or of_samples:
        warn(text, ValidityWarning, stacklevel=3)


@lru_cache  # most cases are in the same air
def _impedance(ambient: Ambient) -> float:
    with catch_warnings():
        simplefilter("ignore", ValidityWarning)  # the tasks tell it
        return ambient.gas.impedance


def _case_result(case: Case, nominal: Outcome, scatter: Mapping[str, Percentiles], rated: dict[str, str]) -> CaseResult:
    percentiles = {name: of_column.result() for name, of_column in scatter.items()}
    impedance = _impedance(case.simulation.ambient)
    spread = {
        name: {path.removeprefix("layers."): values for path, values in of_quantity.items()}
        for name, of_quantity in nominal.spread.items()
    }
    return CaseResult(case.label, case.shown, impedance, nominal.quantities, percentiles, rated, spread)


def simulate(
    source: str | Path | SimulationFile,
    executor: Executor | None = None,
    progress: Callable[[str], None] | None = None,
) -> SimulationResult:
    """Run a simulation file.

    Parameters
    ----------
    source : path or SimulationFile
        A file as in ``docs/simulation.md``, or the result of `load_simulation`.
    executor, progress
        As for `run`.
    """
    if isinstance(source, SimulationFile):
        return run(plan(source), executor, progress)
    return run(plan(load_simulation(source), Path(source).stem), executor, progress)
