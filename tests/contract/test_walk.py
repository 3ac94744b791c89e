"""The walk of one burst from its file to E goes down the floors of ``docs/design.md``, and comes back."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from inspect import CO_GENERATOR
from pathlib import Path
from types import FrameType
from typing import NamedTuple

import pytest

import multilayer
from tests.cli.campaigns import write_campaign
from tests.cli.command import run
from tests.cli.test_fit import keep_bursts
from tests.contract.test_imports import floors

ROOT = f"{Path(multilayer.__file__).parent}/"
# functions that were handed down and are called from below: by whom, and what they are
HANDED_DOWN = {
    "log.py:logged": "the progress function",
    "inference/": "the residual of a problem, and its derivative",
    "models.py:Model._tell_in_words": "validators of a model's fields",
    "config/validate.py:validate": "validators of a model",
    "registry.py:Registry._refuse_faulty": "what a registry asks of its plugins",
}


class Call(NamedTuple):
    """A call from one package into another."""

    caller: str  # file:function
    above: str
    below: str


@contextmanager
def calls() -> Iterator[list[Call]]:
    """Give the calls between packages while a block runs; from where through other libraries they come at last."""
    found: list[Call] = []

    def note(frame: FrameType, event: str, _: object) -> None:
        if event != "call" or (below := package(frame)) is None or frame.f_code.co_flags & CO_GENERATOR:
            return  # a generator that goes on is no call
        outer = frame.f_back
        while outer is not None and package(outer) is None:
            outer = outer.f_back
        if outer is not None and (above := package(outer)) not in (None, below):
            code = outer.f_code
            found.append(Call(f"{code.co_filename.removeprefix(ROOT)}:{code.co_qualname}", str(above), below))

    sys.setprofile(note)
    try:
        yield found
    finally:
        sys.setprofile(None)


def package(frame: FrameType) -> str | None:
    """Return the package or module of ours that a frame belongs to; None for others, and while modules are loaded."""
    code = frame.f_code
    if not code.co_filename.startswith(ROOT) or code.co_name == "<module>":
        return None
    return code.co_filename.removeprefix(ROOT).partition("/")[0].removesuffix(".py")


@pytest.fixture(scope="module")
def walk(tmp_path_factory) -> list[Call]:
    folder = write_campaign(tmp_path_factory.mktemp("walk") / "foam")
    keep_bursts(folder, 400)
    (folder / "fit.yaml").write_text("version: 1\ncampaign: .\nacceptance: {level_db: 0.4}\n")
    run("fit", folder, "--out", folder / "first")  # all modules are loaded then
    with calls() as found:
        assert run("fit", folder, "--out", folder / "out").status == 0
    return found


def test_no_call_climbs(walk):
    floor = floors()
    climbs = {call for call in walk if floor[call.below] > floor[call.above]}
    assert {call for call in climbs if not call.caller.startswith(tuple(HANDED_DOWN))} == set()
    assert {call.below for call in climbs if call.caller.startswith("log.py")} == {"cli"}
    used = {name for name in HANDED_DOWN for call in climbs if call.caller.startswith(name)}
    assert used == set(HANDED_DOWN), "some are not needed any more"


def test_the_command_goes_down_and_comes_back(walk):
    """Read, fit, report: nothing twice."""
    floor = floors()
    visited = [call.below for call in walk if call.above == "cli" and floor[call.below] > 0]
    turns = [name for i, name in enumerate(visited) if visited[i - 1 : i] != [name]]
    assert turns == ["fits", "report"]


def test_all_is_read_before_anything_is_computed(walk):
    computed = next(i for i, call in enumerate(walk) if call.below == "inference")
    opened = ("config", "readers", "campaign.py")
    assert [call for call in walk[computed:] if call.caller.startswith("fits") and call.below in opened] == []
    assert not any(call.below == "config" for call in walk[computed:])


def test_reports_compute_no_fit(walk):
    assert not {call.below for call in walk if call.above == "report"} & {"experiments", "inference", "signals", "cli"}
