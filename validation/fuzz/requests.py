"""Questions to the pages of `explore`, spoiled: each must be answered, by problems or by curves, in JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from multilayer.explore.explorer import Explorer
from multilayer.explore.model import ModelExplorer
from multilayer.explore.server import parsed
from multilayer.fits.sources import open_source
from multilayer.json_text import json_text
from validation.fuzz.watch import PASSED, REFUSED, Outcome, UnsoundError, tried
from validation.fuzz.yaml_mutants import spoilt_data

EXAMPLES, MEASURED = Path(__file__).parents[2] / "examples", ("foam_tube", "foam_b")
_FIELDS = ("thickness", "type", "model", "material", "name", "young_modulus", "", "\ud800", "a\x1b[2J")
_NAMES = ("new.yaml", "../x.yaml", "\ud800.yaml", "\x1b[2J.yaml", "CON.yaml", "n" * 300 + ".yaml", "", "new.yaml/x")
_LONGEST_AXIS = 2000  # frequencies that are asked for; what takes longer is not computed


class RequestTarget:
    """Mutants of questions about stacks and simulations, by their number; what is saved lands beside their files."""

    def __init__(self, files: list[Path], seed: int) -> None:
        self.explorers, self.seed = [Explorer(file) for file in files], seed
        self.data = [explorer.answer("start", {})["data"] for explorer in self.explorers]
        self.names = sorted({key for data in self.data for one in (data, *data["layers"]) for key in one})

    def text(self, index: int) -> tuple[Explorer, str, str]:
        """Return who is asked, a question's name, and the JSON that is sent with it."""
        rng = np.random.default_rng([self.seed, index])
        which = int(rng.integers(len(self.explorers)))
        data = self.data[which]
        name = str(rng.choice(["evaluate", "edit", "save"], p=[0.5, 0.3, 0.2]))
        layers, fields = [*range(len(data["layers"])), -1, 99], list(_FIELDS)
        request: dict[str, Any] = {"data": json.loads(json.dumps(data))}
        if name == "evaluate":
            request |= {"describe": bool(rng.random() < 0.7), "moving": True, "points": 20}
        elif name == "edit":
            deed = str(rng.choice(["add", "copy", "remove", "move", "become", "rename", "contact"]))
            request["edit"] = {"do": deed, "field": str(rng.choice(fields)), "value": str(rng.choice(self.names))}
            request["edit"] |= {key: int(rng.choice(layers)) for key in ("layer", "at", "to")}
            request["edit"] |= {"name": str(rng.choice(fields)), "type": "fluid", "kind": "slip"}
        else:
            request |= {"name": str(rng.choice(_NAMES)), "kind": str(rng.choice(["stack", "simulation", "x"]))}
            request |= {"replace": True, "aside": bool(rng.random() < 0.5)}
        for _ in range(int(rng.choice([1, 1, 2, 3]))):
            request = spoilt_data(request, rng, self.names)
        text = json.dumps(request).replace("NaN", "-1e999")  # a number that JSON has, and no computer
        return self.explorers[which], name, text.replace("Infinity", "1e999")

    def __call__(self, index: int) -> Outcome:
        explorer, name, text = self.text(index)
        return _outcome(name, lambda answers: _ask(explorer, name, text, answers))


class ModelRequestTarget:
    """Mutants of questions about a model beside its measurements, by their number."""

    def __init__(self, source: Path, seed: int) -> None:
        self.explorer, self.seed = ModelExplorer(open_source(source)), seed
        self.start = self.explorer.answer("start", {})
        self.effects = {one["name"]: one["z"] for one in self.start["effects"] if not one["slow"]}
        self.names = [one["name"] for one in self.start["unknowns"]]

    def text(self, index: int) -> tuple[str, str]:
        """Return a question's name, and the JSON that is sent with it."""
        rng = np.random.default_rng([self.seed, index])
        chosen = rng.choice(list(self.effects), size=int(rng.integers(3)), replace=False)
        request: dict[str, Any] = {
            "z": (np.array(self.start["z"]) + rng.normal(size=len(self.start["z"]))).tolist(),
            "effects": {str(name): self.effects[str(name)] for name in chosen},
            "at": int(rng.integers(-1, 3)),
            "held": [str(rng.choice(self.names))],
            "beside": {"z": self.start["z"], "effects": {}},
        }
        if rng.random() < 0.5:
            text = str(rng.choice(["1", "2 mm", "-3", "0", "1e400", "nan", "", "\x1b[2J", "3 kg", "1e-320"]))
            request["typed"] = {"name": str(rng.choice(self.names)), "text": text}
        request = json.loads(json.dumps(request))  # spoiling changes what it is given
        for _ in range(int(rng.choice([0, 1, 1, 2, 3]))):
            request = spoilt_data(request, rng, self.names)
        text = json.dumps(request).replace("NaN", "-1e999").replace("Infinity", "1e999")
        return str(rng.choice(["evaluate", "evaluate", "fit"])), text

    def __call__(self, index: int) -> Outcome:
        name, text = self.text(index)
        return _outcome(name, lambda answers: _ask_model(self.explorer, name, text, answers))


def _outcome(name: str, ask: Callable[[list[dict[str, Any]]], str]) -> Outcome:
    """Return what becomes of a question, which puts its answer into a list."""
    answers: list[dict[str, Any]] = []
    outcome = tried(lambda: ask(answers))
    if outcome.failed:
        return Outcome(outcome.kind, f"{name}: {outcome.text}")
    return Outcome(REFUSED if not answers or answers[0].get("problems") else PASSED, str(answers)[:500])


def _ask_model(explorer: ModelExplorer, name: str, text: str, answers: list[dict[str, Any]]) -> str:
    request = parsed(text.encode())
    if request is not None:
        answer = explorer.answer(name, request)
        json_text(answer).encode()
        if not answer["problems"] and not math.isfinite(answer["misfit"]):
            raise UnsoundError("the misfit is no number")
        answers.append(answer)
    return PASSED


def _ask(explorer: Explorer, name: str, text: str, answers: list[dict[str, Any]]) -> str:
    request = parsed(text.encode())
    if request is None:  # 400, before anybody is asked
        return PASSED
    if _points(request) > _LONGEST_AXIS:
        return PASSED
    answer = explorer.answer(name, request)
    json_text(answer).encode()
    for curve in answer.get("curves", {}).values():
        if any(value is not None and math.isnan(value) for part in curve["parts"] for value in part["values"]):
            raise UnsoundError("a value of a curve is no number")
    answers.append(answer)
    return PASSED


def _points(request: Any) -> float:
    data = request.get("data")
    frequency = data.get("frequency") if isinstance(data, dict) else None
    points = frequency.get("points") if isinstance(frequency, dict) else None
    return points if isinstance(points, int | float) else 0
