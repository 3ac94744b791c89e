"""Results of an optimisation, as tables and as plain data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from multilayer.config.yaml12 import dump_yaml
from multilayer.csv_table import csv_table
from multilayer.optimisation.aims import Aim
from multilayer.optimisation.design import Range
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.result import CaseResult, SimulationResult

_UNUSED = ("sweep", "tolerances", "samples", "seed")  # of a simulation of one design


@dataclass(frozen=True)
class Design:
    """A design, computed as ``multilayer simulate`` does.

    Attributes
    ----------
    name : str
        ``as written``, or its number.
    choices : mapping
        As text, by name.
    values : mapping
        Fields between bounds, SI, by path without ``layers.``.
    goals, limits : tuple of float
        Values of the goals and of what is limited; ratings in their steps.
    followed : tuple of float
        The goals as the search follows them: ratings as real numbers.
    is_kept : bool
        Whether all limits are kept, as far as their values are known.
    case : CaseResult or None
        None of the file as written, where a simulation refuses it.
    simulation : SimulationFile
    """

    name: str
    choices: Mapping[str, str]
    values: Mapping[str, float]
    goals: tuple[float, ...]
    followed: tuple[float, ...]
    limits: tuple[float, ...]
    is_kept: bool
    case: CaseResult | None
    simulation: SimulationFile

    @property
    def yaml(self) -> str:
        """The text of a simulation file of the design."""
        data = {key: value for key, value in self.simulation.to_dict().items() if key not in _UNUSED}
        return dump_yaml({"kind": "simulation", **data})


@dataclass(frozen=True)
class End:
    """Where a descent ended.

    Attributes
    ----------
    goal : float
        As the search follows it.
    choices : str
    is_kept : bool
        Whether all limits are kept.
    is_repeat : bool
        Whether it was begun anywhere, with the choices of the best design, to see whether it ends there, too.
    """

    goal: float
    choices: str
    is_kept: bool
    is_repeat: bool = False


@dataclass(frozen=True)
class OptimisationResult:
    """The best designs of a file.

    Attributes
    ----------
    name : str
    ranges : tuple of Range
    goals, bounds : tuple of Aim
    written : Design
        What the file has.
    designs : tuple of Design
        With one goal the best first; with several the front, by the first goal.
    ends : tuple of End
        Where all searches for the one goal ended; none with several goals.
    variants : int
        How many combinations of choices there are.
    searches : int
        Parts of the search that were done.
    is_whole : bool
        False where it was stopped.
    left_out : tuple of str
        Choices that are not allowed together, and designs that the search found and a simulation refuses, with reasons.
    simulated : SimulationResult
        What was written and the best designs.
    settings : mapping
        The file as plain data.
    """

    name: str
    ranges: tuple[Range, ...]
    goals: tuple[Aim, ...]
    bounds: tuple[Aim, ...]
    written: Design
    designs: tuple[Design, ...]
    ends: tuple[End, ...]
    variants: int
    searches: int
    is_whole: bool
    left_out: tuple[str, ...]
    simulated: SimulationResult
    settings: Mapping[str, Any]

    @property
    def best(self) -> Design:
        """The first design."""
        return self.designs[0]

    @property
    def files(self) -> dict[str, str]:
        """Texts of simulation files by name."""
        if len(self.goals) == 1:
            return {"best.yaml": self.best.yaml}
        return {f"design-{design.name}.yaml": design.yaml for design in self.designs}

    def to_csv(self) -> str:
        """Return one row per design: choices, fields (SI), goals, what is limited."""
        choices = list(dict.fromkeys(name for design in self.designs for name in design.choices))
        headings = ["design", *choices, *(f"{item.name} [{item.unit or '1'}]" for item in self.ranges)]
        headings += [f"{aim.title} [{aim.unit or '1'}]" for aim in (*self.goals, *self.bounds)]
        rows = (
            [
                design.name,
                *(design.choices.get(name, "") for name in choices),
                *(design.values.get(item.name) for item in self.ranges),
                *(None if math.isnan(value) else value for value in (*design.goals, *design.limits)),
            ]
            for design in (self.written, *self.designs)
        )
        return csv_table(headings, rows)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "version": 1,
            "name": self.name,
            "settings": dict(self.settings),
            "goals": [{"title": aim.title, "unit": aim.unit} for aim in self.goals],
            "limits": [{"title": aim.title, "unit": aim.unit, "bound": aim.bound} for aim in self.bounds],
            "whole": self.is_whole,
            "variants": self.variants,
            "searches": self.searches,
            "left_out": list(self.left_out),
            "ends": [
                {"goal": _plain(end.goal), "choices": end.choices, "kept": end.is_kept, "repeat": end.is_repeat}
                for end in self.ends
            ],
            "written": _design_dict(self.written),
            "designs": [_design_dict(design) for design in self.designs],
            "simulation": self.simulated.to_dict(),
        }


def _plain(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _design_dict(design: Design) -> dict[str, Any]:
    return {
        "name": design.name,
        "choices": dict(design.choices),
        "values": dict(design.values),
        "goals": [*map(_plain, design.goals)],
        "goals_followed": [*map(_plain, design.followed)],
        "limits": [*map(_plain, design.limits)],
        "kept": design.is_kept,
        "ratings": {} if design.case is None else dict(design.case.ratings),
    }


def labelled(case: CaseResult, name: str) -> CaseResult:
    """Return a case under the name of its design."""
    return replace(case, label=name, shown={"design": name})
