"""From an optimisation file to its best designs: which searches are made, and what becomes of their ends."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any
from warnings import warn

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError, MultilayerError, MultilayerWarning
from multilayer.errors import Problem as Mistake
from multilayer.executors import as_done, call
from multilayer.number_text import significant, with_unit
from multilayer.optimisation.aims import Aim, Figures
from multilayer.optimisation.design import Key, Variant
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
    StoppedError,
    apart,
    in_order,
    lattice,
    valleys,
)
from multilayer.paths import value_at, with_values
from multilayer.simulation.bands import grid_of
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.result import CaseResult, SimulationResult
from multilayer.simulation.run import simulate

MOST_VARIANTS = 64  # that are gone through one by one
_POINTS, _FEWER = 64, 16  # of a screening, and where there are more than a few variants
_FEW_VARIANTS = 8
_DESCENDED = 16  # variants of a global search, and screened before it, that are searched further
_VALLEYS = 2  # times as many starts as are asked for, where screening shows so many valleys
_DRAWN = 1000  # combinations of choices, for so many that are allowed
_RUNS = 3  # of a global search, from other seeds
_WEIGHTS = 9  # of a front
_SETTLED = 6  # descents with stricter limits, where the exact figures miss what the search's keep
_STRICTER = 0.005  # of a rating, over its size: 0.05 dB, 0.005 of an absorption; doubled each time
_LISTED = 5
_OTHERS = 0.05  # coordinates of designs that are not the same


class LeftOutWarning(MultilayerWarning):
    """Designs that cannot be computed are left out of a search; it goes on."""


class StoppedWarning(MultilayerWarning):
    """Ctrl-C has ended a search; what it has found is computed exactly."""


@dataclass
class _Run:
    """An optimisation on its way.

    `first` are variants by identity, `refused` choices not allowed together, `failed` designs not computed exactly.
    """

    file: OptimisationFile
    name: str
    executor: Executor | None
    progress: Callable[[str], None]
    searches: int = 0
    is_whole: bool = True
    variants: list[Variant] = field(default_factory=list)
    archive: list[Candidate] = field(default_factory=list)
    first: dict[str, Variant] = field(default_factory=dict)
    refused: dict[Key, str] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)

    def gather(self, tasks: Sequence[Callable[[], list[Candidate]]], what: str) -> list[Candidate]:
        """Return what tasks find; of those that are done where Ctrl-C stops them."""
        done: dict[int, list[Candidate]] = {}
        if self.is_whole:
            try:
                for index, found in as_done(call, tasks, self.executor):
                    done[index] = found
                    self.searches += 1
                    self.progress(what)
            except KeyboardInterrupt as stop:
                self.is_whole = False
                done[len(tasks)] = stop.found if isinstance(stop, StoppedError) else []
        every = [one for index in sorted(done) for one in done[index]]
        found = [self.as_first(one) for one in every if np.all(np.isfinite(one.goals))]
        self.archive += found
        self.refuse(one.key for one in every)
        return found

    def as_first(self, one: Candidate) -> Candidate:
        """Return a candidate by the first choices that make the same design: orders of what is left out are one."""
        variant = self.file.space.variant(one.key)
        first = self.first.setdefault(variant.identity, variant)
        if first.key == one.key:
            return one
        by_path = dict(zip((item.path for item in variant.ranges), one.x.tolist(), strict=True))
        return replace(one, key=first.key, x=np.array([by_path[item.path] for item in first.ranges]))

    def refuse(self, keys: Iterable[Key]) -> None:
        """Note which choices are not allowed together."""
        for key in dict.fromkeys(keys):
            try:
                self.file.space.variant(key)
            except InputError as error:
                self.refused[key] = str(error.problems[0])


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

    Warns
    -----
    LeftOutWarning
        Of choices that are not allowed together, of designs that the search found and a simulation refuses, and where
        it refuses the file as written.
    StoppedWarning
        Of Ctrl-C, while the best so far is computed exactly.
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
    return first + n * each + weights * (starts // 2 + 1) + (_LISTED if n == 1 else weights + n)


def _optimise(run: _Run) -> OptimisationResult:
    file = run.file
    many = file.space.count > MOST_VARIANTS
    run.variants = _first_variants(run, many=many)
    margins = np.zeros(len(file.bounds))
    problem = Problem(grid_of(file.frequency), file.goals, file.bounds, file.catalogue, run.variants[0], margins)
    points = _POINTS if len(run.variants) <= _FEW_VARIANTS else _FEWER
    run.gather([Screen(problem, variant, points, file.search.seed) for variant in run.variants], "screening")
    if not run.archive:
        if not run.is_whole:
            raise KeyboardInterrupt
        raise InputError(Mistake(f"no design has a response{_reason(run)}", "design"))
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
    designs = _settled(run, problem, scalars, ends) if run.is_whole else []
    if not designs and (run.failed or not run.is_whole):
        designs = _settled(run, problem, scalars, run.archive)
    _tell_left_out(run)
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


def _first_variants(run: _Run, *, many: bool) -> list[Variant]:
    """Return the variants that are screened: all that differ, of many some at random."""
    space = run.file.space
    keys = _drawn(run) if many else space.keys
    run.refuse(keys)
    variants = space.variants(keys)
    if not variants:
        text = f"none of {len(keys)} combinations of choices is allowed, choose values that fit each other; the first: "
        text += run.refused[keys[0]]
        raise InputError(Mistake(text, "design"))
    return variants


def _reason(run: _Run) -> str:
    """Return what a simulation of one of the designs says."""
    variant = run.variants[0]
    try:
        evaluated(run.file, variant, variant.written)
    except (MultilayerError, ArithmeticError) as error:
        return f"; of one of them: {error}"
    return " of which the search can tell the goals"


def _drawn(run: _Run) -> list[Key]:
    """Return random choices, until enough of them are allowed together."""
    space, rng = run.file.space, np.random.default_rng(run.file.search.seed)
    drawn: dict[Key, bool] = {}
    for _ in range(_DRAWN):
        key = tuple(int(rng.integers(n)) for n in space.axes)
        drawn[key] = space.allowed(key) is not None
        if sum(drawn.values()) == _DESCENDED:
            break
    return [*drawn]


def _tell_left_out(run: _Run) -> None:
    for texts, which in (
        (run.refused, "combinations of choices left out, as they are not allowed together"),
        (run.failed, "designs that the search found left out, as a simulation refuses them"),
    ):
        if texts:
            warn(f"{which}: {len(texts)}; the first: {next(iter(texts.values()))}", LeftOutWarning, stacklevel=4)


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
    """Give descents from the valleys and the best designs known, and from the best of each of some variants."""
    of_variants: dict[Any, Candidate] = {}
    for one in in_order(run.archive, scalar):
        of_variants.setdefault(one.key, one)
    first = valleys(run.archive, scalar)[: _VALLEYS * most]
    starts = [
        *islice(apart(run.archive, scalar, first=first), max(most, len(first))),
        *list(of_variants.values())[:each],
    ]
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


def _settled(run: _Run, problem: Problem, scalars: Sequence[Scalar], found: Sequence[Candidate]) -> list[Design]:
    """Return designs that keep the limits when they are computed as a simulation is; of Ctrl-C those known by then.

    Where none is, it goes on until a second Ctrl-C.
    """
    designs: list[Design] = []
    while True:
        if not run.is_whole:
            warn("stopped by Ctrl-C: the best so far is computed exactly", StoppedWarning, stacklevel=4)
        try:
            designs.extend(_each_settled(run, problem, scalars, found))  # those before Ctrl-C stay
        except KeyboardInterrupt:
            if not designs and not run.is_whole:
                raise
            run.is_whole = False
        else:
            return designs
        if designs:
            return designs


def _each_settled(
    run: _Run, problem: Problem, scalars: Sequence[Scalar], found: Sequence[Candidate]
) -> Iterator[Design]:
    """Give the best designs for each scalar, going down the list until there are enough."""
    wanted = _LISTED if len(scalars) == 1 else 1
    tried: list[tuple[Candidate, bool]] = []
    for scalar in scalars:
        settled = 0
        for one in islice(apart(found, scalar, _OTHERS), MOST_VARIANTS):
            if settled == wanted or one.missed > KEPT:
                break
            same = (good for other, good in tried if one.key == other.key and np.allclose(one.x, other.x, atol=1e-4))
            good = next(same, None)
            if good is None:
                design = _settle(run, problem, scalar, one)
                run.progress("computed exactly")
                good = design is not None
                tried.append((one, good))
                if design is not None:
                    yield design
            settled += good


def _settle(run: _Run, problem: Problem, scalar: Scalar, candidate: Candidate) -> Design | None:
    """Return a candidate as it is simulated; moved where its exact figures miss a limit that the search's keep."""
    variant, x = run.file.space.variant(candidate.key), candidate.x
    for turn in range(_SETTLED):
        try:
            design = evaluated(run.file, variant, x)
        except (MultilayerError, ArithmeticError) as error:
            label = _label(variant, x)
            run.failed[label] = f"{label}: {error}" if label else str(error)
            return None
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


def _label(variant: Variant, x: RealArray) -> str:
    values = [
        f"{item.name} = {with_unit(float(value), item.unit)}"
        for item, value in zip(variant.ranges, variant.values(x).values(), strict=True)
    ]
    return ", ".join([*([variant.label] if variant.shown else []), *values])


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
    values = {path: float(value) for path, value in variant.values(x).items()}
    changed = with_values(variant.simulation, values).to_dict() if values else variant.simulation.to_dict()
    simulation = SimulationFile.model_validate(changed)
    (case,) = simulate(simulation).cases
    design = _design(file, variant, simulation, case, name)
    return replace(design, values={item.name: values[item.path] for item in variant.ranges})


def _design(
    file: OptimisationFile, variant: Variant, simulation: SimulationFile, case: CaseResult | None, name: str
) -> Design:
    """Return a design with the figures of its case; NaN where it has none."""
    spectra = {} if case is None else {key: np.asarray(value)[None] for key, value in case.quantities.items()}
    stack = simulation.stack
    aims = (*file.goals, *file.bounds)
    sizes = {
        aim.name: np.array([float(np.ravel(_size(aim, stack, variant, file))[0])]) for aim in aims if not aim.quantity
    }
    figures = Figures(spectra, sizes)
    limits = tuple(aim.true(figures) if _is_of(aim, spectra) else np.nan for aim in file.bounds)
    return Design(
        name,
        variant.shown,
        {},
        tuple(aim.true(figures) if _is_of(aim, spectra) else np.nan for aim in file.goals),
        tuple(float(aim.values(figures)[0, 0]) if _is_of(aim, spectra) else np.nan for aim in file.goals),
        limits,
        not any(aim.slack(value) < -KEPT for aim, value in zip(file.bounds, limits, strict=True)),
        case,
        simulation,
    )


def _is_of(aim: Aim, spectra: dict[str, Any]) -> bool:
    """Tell whether an aim is one of these spectra: the file as written may end otherwise than every design."""
    absorber = aim.rating is not None and aim.quantity == "absorption"
    return not aim.quantity or (aim.quantity in spectra and not (absorber and "transmission_loss" in spectra))


def _size(aim: Aim, stack: Any, variant: Variant, file: OptimisationFile) -> Any:
    try:
        return size_of(aim.name, stack, variant, file.catalogue)
    except InputError:  # of what the file has, and no design chooses
        return np.nan


def _as_written(run: _Run) -> Design:
    """Return what the file has; without a response where a simulation refuses it, or Ctrl-C stops that."""
    file, case = run.file, None
    simulation = file.space.validated(file.space.data)
    layers = file.space.data["layers"]
    materials = tuple(layer.get("material") if isinstance(layer, dict) else None for layer in layers)
    variant = Variant((), {}, simulation, file.space.ranges, materials)
    there = {item.path: value_at(simulation, item.path) for item in file.space.ranges}
    simulation = SimulationFile.model_validate(simulation.to_dict())  # as that of every design
    try:
        (case,) = simulate(simulation).cases
    except (MultilayerError, ArithmeticError) as error:
        warn(f"as the file has it, the stack has no figures: {error}", LeftOutWarning, stacklevel=5)
    except KeyboardInterrupt:
        run.is_whole = False
    design = _design(file, variant, simulation, case, "as written")
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
    if run.failed:
        text = f"no design is left, a simulation refuses {len(run.failed)} that the search found; the first: "
        return [Mistake(text + next(iter(run.failed.values())), "design")]
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
    limits: tuple[float, ...] = (np.nan,) * len(problem.bounds)
    with suppress(MultilayerError, ArithmeticError):
        limits = evaluated(run.file, run.file.space.variant(nearest.key), nearest.x).limits
    for aim, value in zip(problem.bounds, limits, strict=True):
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
    written = _as_written(run)
    grid = grid_of(file.frequency)
    some = np.linspace(0, len(designs) - 1, _LISTED).round().astype(int) if len(file.goals) > 1 else [0]
    shown = [written, *(designs[i] for i in dict.fromkeys(map(int, some)))]
    names = {"1": "best"} if len(file.goals) == 1 else {}
    simulated = SimulationResult(
        run.name,
        grid.frequency,
        grid.bands,
        tuple(
            labelled(design.case, names.get(design.name, design.name)) for design in shown if design.case is not None
        ),
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
        run.searches, run.is_whole, (*run.refused.values(), *run.failed.values()), simulated,
        file.model_dump(mode="json", exclude_none=True, by_alias=True),
    )  # fmt: skip
