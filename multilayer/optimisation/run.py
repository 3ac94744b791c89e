"""From an optimisation file to its best designs: which searches are made, and what becomes of their ends."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError, MultilayerError
from multilayer.errors import Problem as Mistake
from multilayer.executors import as_done, call
from multilayer.number_text import significant, with_unit
from multilayer.optimisation.aims import Aim, Figures
from multilayer.optimisation.design import Variant
from multilayer.optimisation.file import OptimisationFile, load_optimisation
from multilayer.optimisation.predict import size_of
from multilayer.optimisation.result import Design, End, OptimisationResult, labelled
from multilayer.optimisation.search import (
    KEPT,
    Candidate,
    Descent,
    GlobalSearch,
    Problem,
    Scalar,
    Screen,
    apart,
    in_order,
    lattice,
)
from multilayer.paths import value_at, with_values
from multilayer.simulation.bands import grid_of
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.result import SimulationResult
from multilayer.simulation.run import simulate

MOST_VARIANTS = 64  # that are gone through one by one
_POINTS, _FEWER = 64, 16  # of a screening, and where there are more than a few variants
_FEW_VARIANTS = 8
_DESCENDED = 16  # variants of a global search, and screened before it, that are searched further
_RUNS = 3  # of a global search, from other seeds
_WEIGHTS = 9  # of a front
_SETTLED = 6  # descents with stricter limits, where the exact figures miss what the search's keep
_STRICTER = 0.005  # of a rating, over its size: 0.05 dB, 0.005 of an absorption; doubled each time
_LISTED = 5
_OTHERS = 0.05  # coordinates of designs that are not the same


@dataclass
class _Run:
    """An optimisation on its way."""

    file: OptimisationFile
    name: str
    executor: Executor | None
    progress: Callable[[str], None]
    searches: int = 0
    is_whole: bool = True
    variants: list[Variant] = field(default_factory=list)
    archive: list[Candidate] = field(default_factory=list)

    def gather(self, tasks: Sequence[Callable[[], list[Candidate]]], what: str) -> list[Candidate]:
        """Return what tasks find; of those that are done where Ctrl-C stops them."""
        done: dict[int, list[Candidate]] = {}
        if self.is_whole:
            try:
                for index, found in as_done(call, tasks, self.executor):
                    done[index] = found
                    self.searches += 1
                    self.progress(what)
            except KeyboardInterrupt:
                self.is_whole = False
        found = [one for index in sorted(done) for one in done[index] if np.all(np.isfinite(one.goals))]
        self.archive += found
        return found


def optimise(
    source: str | Path | OptimisationFile,
    executor: Executor | None = None,
    progress: Callable[[str], None] = lambda text: None,
    name: str = "",
) -> OptimisationResult:
    """Search the best designs of a file.

    Parameters
    ----------
    source : path or OptimisationFile
        A file as in ``docs/tasks/optimise.md``, or the result of `load_optimisation`.
    executor : Executor, optional
        Of `concurrent.futures`, or anything alike; this process when left out. The result does not depend on it.
    progress : callable, optional
        Called after each part of the search.
    name : str
        Of the result; that of the file when left out.

    Raises
    ------
    InputError
        Where no design keeps all limits, with the limit that excludes it and what can be reached.
    KeyboardInterrupt
        Of Ctrl-C before anything is known; later it ends the search, and the best so far is the result.
    """
    if isinstance(source, OptimisationFile):
        return _optimise(_Run(source, name or "optimisation", executor, progress))
    return _optimise(_Run(load_optimisation(source), name or Path(source).stem, executor, progress))


def steps(file: OptimisationFile) -> int:
    """Return about how many parts the search has."""
    n, starts = len(file.goals), file.search.starts
    if file.space.count > MOST_VARIANTS:
        first, each = _DESCENDED + _RUNS * n, starts + _DESCENDED
    else:
        first, each = file.space.count, starts + file.space.count
    weights = len(lattice(n, _WEIGHTS)) if n > 1 else 0
    first += starts if n == 1 else 0
    return first + n * each + weights * (starts // 2 + 1)


def _optimise(run: _Run) -> OptimisationResult:
    file = run.file
    many = file.space.count > MOST_VARIANTS
    first = file.space.variant((0,) * len(file.space.axes))
    problem = Problem(
        grid_of(file.frequency), file.goals, file.bounds, file.catalogue, first, np.zeros(len(file.bounds))
    )
    _screen(run, problem, many=many)
    if not run.archive:
        if not run.is_whole:
            raise KeyboardInterrupt
        raise InputError(Mistake("no design has a finite response", "design"))
    anchors = list(_anchors(run, len(file.goals)))
    if many:
        seeds = np.random.SeedSequence(file.search.seed).generate_state(_RUNS * len(anchors)).tolist()
        tasks = [GlobalSearch(problem, file.space, anchors[i % len(anchors)], seed) for i, seed in enumerate(seeds)]
        run.gather(tasks, "choices")
    ends: list[Candidate] = []
    for scalar in anchors:
        each = _DESCENDED if many else len(run.variants)
        ends += run.gather([*_descents(run, problem, scalar, file.search.starts, each)], "descents")
    again: list[Candidate] = []
    if len(anchors) == 1:
        again = run.gather([*_again(run, problem, anchors[0], ends)], "once more")
    ends += again
    front = [*_weighted(run, ends)] if len(anchors) > 1 else anchors
    for scalar in front if len(anchors) > 1 else ():
        if many:
            run.gather([GlobalSearch(problem, file.space, scalar, file.search.seed)], "choices")
        ends += run.gather([*_descents(run, problem, scalar, file.search.starts // 2 + 1, 0)], "front")
    scalars = [*front, *anchors] if len(anchors) > 1 else anchors
    designs = [*_settled(run, problem, scalars, ends or run.archive)]
    if not designs:
        if not run.is_whole:  # nothing is known of what was not searched
            raise KeyboardInterrupt
        raise InputError(_why_none(run, problem))
    if len(anchors) == 1:
        designs = sorted(
            designs, key=lambda one: (-file.goals[0].sign * one.goals[0], -file.goals[0].sign * one.followed[0])
        )
        designs = designs[:_LISTED]
    else:
        designs = sorted(_not_dominated(designs, file.goals), key=lambda one: -file.goals[0].sign * one.followed[0])
    numbered = [replace(design, name=str(i)) for i, design in enumerate(designs, start=1)]
    return _result(run, numbered, ends if len(anchors) == 1 else [], again)


def _screen(run: _Run, problem: Problem, *, many: bool) -> None:
    space, seed = run.file.space, run.file.search.seed
    if many:
        rng = np.random.default_rng(seed)
        keys = {tuple(int(rng.integers(n)) for n in space.axes): None for _ in range(_DESCENDED)}
        run.variants = [space.variant(key) for key in keys]
    else:
        run.variants = space.variants()
    points = _POINTS if len(run.variants) <= _FEW_VARIANTS else _FEWER
    run.gather([Screen(problem, variant, points, seed) for variant in run.variants], "screening")


def _anchors(run: _Run, n_goals: int) -> Iterator[Scalar]:
    """Give one scalar for each goal alone."""
    goals = np.array([one.goals for one in run.archive])
    kept = goals[[one.is_kept for one in run.archive]]
    base = kept if len(kept) else goals
    low, high = np.percentile(goals, (5, 95), axis=0)
    span = np.where(high > low, high - low, 1.0)
    for weights in np.eye(n_goals):
        yield Scalar(weights, np.min(base, axis=0), span)


def _weighted(run: _Run, ends: Sequence[Candidate]) -> Iterator[Scalar]:
    """Give scalars whose best designs are spread along the front."""
    kept = np.array([one.goals for one in [*ends, *run.archive] if one.is_kept])
    if not len(kept):
        return
    extremes = kept[np.argmin(kept, axis=0)]  # the best design of each goal
    best, worst = np.min(kept, axis=0), np.max(extremes, axis=0)
    span = np.where(worst > best, worst - best, 1.0)
    for weights in lattice(len(best), _WEIGHTS):
        yield Scalar(weights, best, span)


def _descents(run: _Run, problem: Problem, scalar: Scalar, most: int, each: int) -> Iterator[Descent]:
    """Give descents from the best designs known, and from the best of each of some variants."""
    of_variants: dict[Any, Candidate] = {}
    for one in in_order(run.archive, scalar):
        of_variants.setdefault(one.key, one)
    starts = [*apart(run.archive, scalar, most), *list(of_variants.values())[:each]]
    different = {(one.key, one.x.tobytes()): one for one in starts}
    for one in different.values():
        yield Descent(problem, run.file.space.variant(one.key), scalar, one.x)


def _again(run: _Run, problem: Problem, scalar: Scalar, ends: Sequence[Candidate]) -> Iterator[Descent]:
    """Give descents from anywhere, with the choices of the best design: whether they end there is told."""
    best = next(iter(in_order(ends, scalar)), None)
    if best is None or not len(best.x):
        return
    variant, rng = run.file.space.variant(best.key), np.random.default_rng((run.file.search.seed, 1))
    for start in rng.random((run.file.search.starts, len(best.x))):
        yield Descent(problem, variant, scalar, start)


def _settled(run: _Run, problem: Problem, scalars: Sequence[Scalar], ends: Sequence[Candidate]) -> Iterator[Design]:
    """Give designs that keep the limits when they are computed as a simulation is."""
    seen: list[Candidate] = []
    for scalar in scalars:
        for one in apart(ends, scalar, _LISTED if len(scalars) == 1 else 1, _OTHERS):
            if any(one.key == other.key and np.allclose(one.x, other.x, atol=1e-4) for other in seen):
                continue
            seen.append(one)
            design = _settle(run, problem, scalar, one)
            if design is not None:
                yield design


def _settle(run: _Run, problem: Problem, scalar: Scalar, candidate: Candidate) -> Design | None:
    """Return a candidate as it is simulated; moved where its exact figures miss a limit that the search's keep."""
    variant, x = run.file.space.variant(candidate.key), candidate.x
    if candidate.missed > KEPT:
        return None
    for turn in range(_SETTLED):
        design = evaluated(run.file, variant, x)
        slack = np.array([aim.slack(value) for aim, value in zip(problem.bounds, design.limits, strict=True)])
        if design.is_kept:
            return design
        if not len(x):
            return None
        rated = np.array([aim.rating is not None for aim in problem.bounds])
        stricter = np.where(rated, _STRICTER * 2**turn, -1.05 * slack + 1e-5)
        problem = replace(problem, margins=problem.margins + np.where(slack < -KEPT, stricter, 0.0))
        (end,) = Descent(problem, variant, scalar, x)()
        x = end.x
        if not end.is_kept:
            return None
    return None


def evaluated(file: OptimisationFile, variant: Variant, x: RealArray, name: str = "") -> Design:
    """Return a design computed as a simulation is, at all frequencies and directions.

    Parameters
    ----------
    file : OptimisationFile
    variant : Variant
    x : array, shape (n_ranges,)
        Coordinates from 0 to 1.
    name : str
    """
    return _design(file, variant, {path: float(value) for path, value in variant.values(x).items()}, name)


def _design(file: OptimisationFile, variant: Variant, values: dict[str, float], name: str) -> Design:
    changed = with_values(variant.simulation, values).to_dict() if values else variant.simulation.to_dict()
    simulation = SimulationFile.model_validate(changed)
    (case,) = simulate(simulation).cases
    spectra = {key: np.asarray(value)[None] for key, value in case.quantities.items()}
    stack = simulation.stack
    aims = (*file.goals, *file.bounds)
    sizes = {
        aim.name: np.array([float(np.ravel(_size(aim, stack, variant, file))[0])]) for aim in aims if not aim.quantity
    }
    figures = Figures(spectra, sizes)
    limits = tuple(aim.true(figures) for aim in file.bounds)
    return Design(
        name,
        variant.shown,
        {item.name: values[item.path] for item in variant.ranges if item.path in values},
        tuple(aim.true(figures) for aim in file.goals),
        tuple(float(aim.values(figures)[0, 0]) for aim in file.goals),
        limits,
        all(aim.slack(value) >= -KEPT for aim, value in zip(file.bounds, limits, strict=True)),
        case,
        simulation,
    )


def _size(aim: Aim, stack: Any, variant: Variant, file: OptimisationFile) -> Any:
    try:
        return size_of(aim.name, stack, variant, file.catalogue)
    except InputError:  # of what the file has, and no design chooses
        return np.nan


def _as_written(file: OptimisationFile) -> Design:
    simulation = file.space.validated(file.space.data)
    layers = file.space.data["layers"]
    materials = tuple(layer.get("material") if isinstance(layer, dict) else None for layer in layers)
    variant = Variant((), {}, simulation, file.space.ranges, materials)
    there = {item.path: value_at(simulation, item.path) for item in file.space.ranges}
    design = _design(file, variant, {}, "as written")
    shown = {item.name: float(there[item.path]) for item in file.space.ranges if there[item.path] is not None}
    choices = {path.removeprefix("layers."): _written_choice(file, path) for path in file.space.choices}
    return replace(design, values=shown, choices=choices)


def _written_choice(file: OptimisationFile, path: str) -> str:
    *parents, last = path.split(".")
    data: Any = file.space.data
    try:
        for token in parents:
            if isinstance(data, list | tuple):
                names = [one.get("name") for one in data]
                data = data[names.index(token) if token in names else int(token)]
            else:
                data = data[token]
        return str(data[last])
    except (KeyError, ValueError, TypeError, IndexError):
        return ""


def _not_dominated(designs: Sequence[Design], goals: Sequence[Aim]) -> list[Design]:
    signs = np.array([aim.sign for aim in goals])
    values = np.array([design.followed for design in designs]) * -signs
    scale = np.ptp(values, axis=0) * 1e-3
    kept = []
    for i, one in enumerate(values):
        better = np.all(values <= one + 1e-12, axis=1) & np.any(values < one - 1e-12, axis=1)
        same = [j for j in range(i) if np.all(np.abs(values[j] - one) <= scale)]
        if not better.any() and not same:
            kept.append(designs[i])
    return kept


def _why_none(run: _Run, problem: Problem) -> list[Mistake]:
    """Return which limits exclude all designs that the search meets, and what it reaches."""
    mistakes = []
    for aim in problem.bounds:
        wanted = replace(aim, bound=None, worst=True)
        alone = replace(problem, goals=(wanted,), bounds=(), margins=np.zeros(0))
        starts = sorted(run.archive, key=lambda one: one.missed)[:_LISTED]
        scalar = Scalar(np.ones(1), np.zeros(1), np.full(1, aim.scale))
        tasks = [Descent(alone, run.file.space.variant(one.key), scalar, one.x) for one in starts]
        tasks += [Descent(alone, variant, scalar, variant.written) for variant in run.variants[:_DESCENDED]]
        reached = -aim.sign * min(float(one.goals[0]) for task in tasks for one in task())
        if aim.slack(reached) < -KEPT:
            most = "most" if aim.sign > 0 else "least"
            text = f"{aim.title}: the search finds no design that keeps this; the {most} it reaches is "
            mistakes.append(Mistake(text + _shown(reached, aim), ".".join(map(str, aim.place))))
    if mistakes:
        return mistakes
    nearest = min(run.archive, key=lambda one: one.missed)
    design = evaluated(run.file, run.file.space.variant(nearest.key), nearest.x)
    for aim, value in zip(problem.bounds, design.limits, strict=True):
        if aim.slack(value) < -KEPT:
            text = f"{aim.title}: kept by some designs, but by none together with the other limits"
            text += f"; the nearest has {_shown(value, aim)}"
            mistakes.append(Mistake(text, ".".join(map(str, aim.place))))
    return mistakes or [Mistake("no design keeps all limits when it is computed exactly; relax one a little", "limits")]


def _shown(value: float, aim: Aim) -> str:
    return with_unit(value, aim.unit) if aim.unit else significant(value)


def _result(
    run: _Run, designs: Sequence[Design], ends: Sequence[Candidate], again: Sequence[Candidate]
) -> OptimisationResult:
    file = run.file
    try:
        written = _as_written(file)
    except MultilayerError as error:
        raise InputError(f"as the file has it: {error}") from error
    grid = grid_of(file.frequency)
    some = np.linspace(0, len(designs) - 1, _LISTED).round().astype(int) if len(file.goals) > 1 else [0]
    shown = [written, *(designs[i] for i in dict.fromkeys(map(int, some)))]
    names = {"1": "best"} if len(file.goals) == 1 else {}
    simulated = SimulationResult(
        run.name,
        grid.frequency,
        grid.bands,
        tuple(labelled(design.case, names.get(design.name, design.name)) for design in shown),
        written.simulation.to_dict(),
    )
    sign = file.goals[0].sign
    fresh = set(map(id, again))
    told = tuple(
        End(-sign * float(one.goals[0]), file.space.variant(one.key).label, one.is_kept, id(one) in fresh)
        for one in ends
    )
    return OptimisationResult(
        run.name, file.space.ranges, file.goals, file.bounds, written, tuple(designs), told, file.space.count,
        run.searches, run.is_whole, simulated, file.model_dump(mode="json", exclude_none=True, by_alias=True),
    )  # fmt: skip
