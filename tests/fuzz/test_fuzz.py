"""A little of `validation.fuzz`: input that nobody means ends in a message with its place, or in a sound result."""

import os
import sys
import time

import numpy as np
import pytest

from multilayer.kinds import kind_of
from validation.fuzz import watch
from validation.fuzz.commands import command_target
from validation.fuzz.corpus import write_corpus, write_tables
from validation.fuzz.extremes import ExtremeTarget
from validation.fuzz.flips import FORMATS, FlipTarget
from validation.fuzz.requests import EXAMPLES, MEASURED, ModelRequestTarget, RequestTarget
from validation.fuzz.sizes import DATA, NAMES, SizeTarget
from validation.fuzz.tables import TableTarget
from validation.fuzz.watch import PASSED, REFUSED, Outcome, Tally, tried, watched
from validation.fuzz.yaml_mutants import YamlTarget, checked

SEED = 20
LIBRARIES = {"HDF5": "h5py", "UFF": "pyuff", "TDMS": "nptdms"}
QUICK = [name for name in DATA if "claims" in name or "links" in name or "pickle" in name]


def tally(target, indices):
    return watched(target, indices, Tally("", SEED))


def test_spoiled_yaml_files(tmp_path):
    found = tally(YamlTarget(write_corpus(tmp_path / "yaml"), SEED, 0.1), range(250))
    assert found.failures == {}
    assert found.counts[REFUSED] > 150


def test_files_pass_before_they_are_spoiled(tmp_path):
    for file in write_corpus(tmp_path / "yaml"):
        assert tried(lambda file=file: checked(file), file).kind == PASSED, file
    for table in write_tables(tmp_path / "tables"):
        assert TableTarget([table], SEED).tried(table).kind == PASSED, table


def test_spoiled_walls_and_designs(tmp_path):
    files = [file for file in write_corpus(tmp_path / "yaml") if file.parent.name == "walls"]
    assert {kind_of(file).name for file in files} == {"simulation", "stack", "optimisation", "diagnose"}
    assert tally(YamlTarget(files, SEED), range(120)).failures == {}
    assert tally(command_target(files, SEED), range(60)).failures == {}


def test_spoiled_tables_of_materials(tmp_path):
    found = tally(TableTarget(write_tables(tmp_path / "tables"), SEED), range(150))
    assert found.failures == {}
    assert found.counts[PASSED] > 15


def test_spoiled_questions_to_the_page_of_explore(tmp_path):
    files = [file for file in write_corpus(tmp_path / "yaml") if file.parent.name == "walls"]
    simulations = [file for file in files if kind_of(file).name == "simulation"]
    found = tally(RequestTarget(simulations, SEED), range(150))
    assert found.failures == {}
    assert min(found.counts[PASSED], found.counts[REFUSED]) > 15


@pytest.mark.parametrize("name", MEASURED)
def test_spoiled_questions_to_the_page_of_a_model(name):
    found = tally(ModelRequestTarget(EXAMPLES / name, SEED), range(150))
    assert found.failures == {}
    assert min(found.counts[PASSED], found.counts[REFUSED]) > 15


@pytest.mark.parametrize("name", FORMATS)
def test_spoiled_data_files(tmp_path, name):
    pytest.importorskip(LIBRARIES.get(name.partition(",")[0], "numpy"))
    found = tally(FlipTarget(name, tmp_path, SEED), range(40))
    assert found.failures == {}


def test_extreme_stacks(tmp_path):
    found = tally(ExtremeTarget(tmp_path, SEED), range(150))
    assert found.failures == {}
    assert found.counts["passed"] > 50


@pytest.mark.parametrize("name", [*QUICK, "a complex modulus of 1 000 digits", "aliases of aliases"])
def test_claims_are_refused_before_they_are_read(tmp_path, name):
    pytest.importorskip({"HDF5": "h5py", "UFF ": "pyuff", "TDMS": "nptdms"}.get(name[:4], "numpy"))
    found = tally(SizeTarget(tmp_path), [NAMES.index(name)])
    assert found.counts[REFUSED] == 1, found.failures


def test_the_same_seed_gives_the_same_tries(tmp_path):
    files = write_corpus(tmp_path / "yaml")
    assert [YamlTarget(files, 7).text(i) for i in range(50)] == [YamlTarget(files, 7).text(i) for i in range(50)]


def test_tries_do_not_depend_on_the_number_of_processes(tmp_path):
    target = YamlTarget(write_corpus(tmp_path / "yaml"), 7, 0.1)
    alone, shared = (watched(target, range(60), Tally("", 7), jobs=jobs) for jobs in (1, 3))
    assert alone.row == shared.row


def test_a_process_that_dies_is_counted_and_the_others_go_on():
    def target(index):
        if index == 3:
            os._exit(9)
        return tried(lambda: "passed")

    result = watched(target, range(8), Tally("", 1), jobs=2)
    assert result.counts["tried"] == 8
    assert result.counts["passed"] == 7
    assert [index for index, _ in result.failures["the process died"]] == [3]


def test_failures_are_seen():
    def overflow():
        np.square(np.float64(1e300))
        return "passed"

    assert tried(overflow).kind.startswith("RuntimeWarning at")
    assert tried(lambda: {}["no"]).kind.startswith("KeyError at")


def waits_or_computes(index):
    """Wait for ever, or compute for longer than what waits is allowed."""
    if not index:
        time.sleep(60)
    until = time.process_time() + 2.0
    while time.process_time() < until:
        pass
    return Outcome(PASSED)


@pytest.mark.skipif(sys.platform != "linux", reason="what a process has computed is told by Linux's clocks")
def test_what_waits_for_ever_is_told_and_what_is_slow_is_not(monkeypatch):
    monkeypatch.setattr(watch, "_HANGS", 0.5)
    found = tally(waits_or_computes, range(2))
    assert [*found.failures] == ["hangs where nothing can stop it"]
    assert found.counts[PASSED] == 1
