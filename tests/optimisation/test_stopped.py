"""Ctrl-C in each part of a search: what was found by then is the result."""

import time
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context

import numpy as np
import pytest

from multilayer.executors import abandon
from multilayer.optimisation import run
from multilayer.optimisation.run import StoppedWarning, _anchors, _Run, optimise
from multilayer.optimisation.search import Descent, GlobalSearch, Problem, Screen, StoppedError
from multilayer.simulation.bands import grid_of
from tests.optimisation.test_known_answers import FOAM, read

DATA = {
    "layers": [
        {"type": "screen", "name": "cloth", "flow_resistance": 2000.0},
        {"type": "fluid", "name": "gap", "thickness": 0.05},
    ],
    "frequency": [500.0],
    "design": {"layers.cloth.flow_resistance": {"among": [1000, 2000]}, "layers.gap.thickness": [0.02, 0.3]},
    "goal": {"highest": "absorption"},
    "search": {"starts": 2},
}


def stopping(function, *calls):
    """Return a function that Ctrl-C stops in some of its calls, counted from 0."""
    count = iter(range(100_000))

    def stopped(*arguments):
        if next(count) in calls:
            raise KeyboardInterrupt
        return function(*arguments)

    return stopped


@pytest.fixture
def searches():
    """Return a descent, a global search, and the best goal where they begin."""
    file = read(**DATA)
    variant = file.space.variants()[0]
    problem = Problem(grid_of(file.frequency), file.goals, (), {}, variant, np.zeros(0))
    archive = Screen(problem, variant, 4, 0)()
    scalar = next(_anchors(_Run(file, "", None, print, archive=archive), 1))
    start = archive[0]
    return Descent(problem, variant, scalar, start.x), GlobalSearch(problem, file.space, scalar, 1), start.goals[0]


def test_a_stopped_descent_gives_its_best(searches, monkeypatch):
    monkeypatch.setattr(Problem, "measure", stopping(Problem.measure, 8))
    descent, _, first = searches
    with pytest.raises(StoppedError) as stop:
        descent()
    (one,) = stop.value.found
    assert one.goals[0] < first


def test_a_stopped_global_search_gives_its_best(searches, monkeypatch):
    monkeypatch.setattr(Problem, "measure", stopping(Problem.measure, 9))
    with pytest.raises(StoppedError) as stop:
        searches[1]()
    assert {one.key for one in stop.value.found} == {(0,), (1,)}


@pytest.mark.parametrize("task", [Descent, GlobalSearch])
def test_what_a_stopped_search_has_found_is_the_result(task, monkeypatch):
    """Nothing but what it had found leads to the best design: the screening is of one point."""
    for name, value in {"_POINTS": 0, "_FEWER": 0, "MOST_VARIANTS": 1 if task is GlobalSearch else 64}.items():
        monkeypatch.setattr(run, name, value)
    found = []

    def stopped(self):
        found.extend(evolved(self))
        raise StoppedError(found)

    evolved = task.__call__
    monkeypatch.setattr(task, "__call__", stopped)
    monkeypatch.setattr(run, "_SETTLED", 1)
    with pytest.warns(StoppedWarning, match="the best so far is computed exactly"):
        result = optimise(read(**DATA))
    assert not result.is_whole
    assert result.best.goals[0] == pytest.approx(-min(one.goals[0] for one in found), abs=1e-9)


CHOICES = {
    **DATA,
    "design": {"layers.cloth.flow_resistance": {"among": [500, 1000, 2000, 4000]}},
}


@pytest.mark.parametrize(("calls", "designs"), [((2,), 2), ((0,), 4), ((0, 3), 2)])
@pytest.mark.filterwarnings("ignore::multilayer.optimisation.run.StoppedWarning")
def test_designs_that_are_settled_are_kept(calls, designs, monkeypatch):
    monkeypatch.setattr(run, "evaluated", stopping(run.evaluated, *calls))
    told = []
    result = optimise(read(**CHOICES), progress=told.append)
    assert (result.is_whole, len(result.designs)) == (False, designs)
    assert told.count("computed exactly") == designs


@pytest.mark.filterwarnings("ignore::multilayer.optimisation.run.StoppedWarning")
def test_a_second_ctrl_c_before_any_is_settled_ends_it(monkeypatch):
    monkeypatch.setattr(run, "evaluated", stopping(run.evaluated, 0, 1))
    with pytest.raises(KeyboardInterrupt):
        optimise(read(**CHOICES))


def test_stopped_in_the_file_as_written(monkeypatch):
    monkeypatch.setattr(run, "simulate", stopping(run.simulate, 4))
    result = optimise(read(**CHOICES))
    assert (result.is_whole, len(result.designs)) == (False, 4)
    assert np.isnan(result.written.goals[0])


@pytest.mark.filterwarnings("ignore::multilayer.optimisation.run.StoppedWarning")
@pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")
def test_the_front_of_a_stopped_search_has_the_best_of_each_goal(monkeypatch):
    """Stopped in the descents for the first goal: of the second the screening has the best so far."""
    monkeypatch.setattr(Descent, "__call__", stopping(Descent.__call__, 2))
    data = {
        "layers": [FOAM], "frequency": [500.0], "design": {"layers.foam.thickness": [0.01, 0.05]},
        "goal": [{"highest": "absorption"}, {"lowest": "thickness"}],
    }  # fmt: skip
    result = optimise(read(**data))
    assert not result.is_whole
    assert result.designs[-1].goals[1] < 0.012


def test_processes_of_a_pool_are_not_waited_for():
    pool = ProcessPoolExecutor(1, get_context("spawn"))
    future = pool.submit(time.sleep, 60)
    while not future.running():
        time.sleep(0.05)
    began = time.monotonic()
    abandon(pool)
    pool.shutdown()
    with pytest.raises(BrokenProcessPool):
        future.result(20)
    assert time.monotonic() - began < 30
