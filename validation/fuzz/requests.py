"""Questions to the page of `explore`, spoiled: each must be answered, by problems or by curves, in JSON."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from multilayer.explore.explorer import Explorer
from multilayer.explore.server import parsed
from multilayer.json_text import json_text
from validation.fuzz.watch import PASSED, REFUSED, Outcome, UnsoundError, tried
from validation.fuzz.yaml_mutants import spoilt_data

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
        answers: list[dict[str, Any]] = []
        outcome = tried(lambda: _ask(explorer, name, text, answers))
        if outcome.failed:
            return Outcome(outcome.kind, f"{name}: {outcome.text}")
        return Outcome(REFUSED if not answers or answers[0].get("problems") else PASSED, str(answers)[:500])


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
