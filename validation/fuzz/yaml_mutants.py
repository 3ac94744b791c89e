"""Our YAML files, spoiled in their text and in what they hold, through `check`, and what passes through its command."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from multilayer.arrays import RealArray
from multilayer.cli.check import _checked
from multilayer.config.validate import placed_in
from multilayer.errors import InputError
from multilayer.fits.run import FitTask
from multilayer.kinds import kind_of
from multilayer.simulation.file import load_simulation
from multilayer.simulation.run import plan, run
from multilayer.simulation.tasks import OF_FREE_WAVES
from validation.fuzz.watch import PASSED, Outcome, UnsoundError, own, tried

JUNK: tuple[Any, ...] = (
    None, True, False, "", " ", [], {}, [[]], [None], {"": None}, -1, 0, 1, 0.0, -0.0, 1e-300, 1e300, -1e300, 1e-20,
    1e20, float("inf"),
    float("nan"), 10**30, "x", "1 m", "1 kPa", "-5 %", "20 degC", "1e5+1e4j", "1e400", "=1+1", "../x", "/dev/null",
    "a" * 3000, "1" * 150, "é\u202e\x07", "rigid", "normal", "diffuse", "all", [1, 2], [1, "1 m"],
    {"a": 1}, ["a", {"b": []}], "0x10", "1_000", "nan", "1 furlong", "FILL_IN", "frequency", ".", "layers.0",
    12345678901234567890,
)  # fmt: skip
_PIECES = "{}[]:,-#&*!|>'\"%@`\n \t\\0123456789.eE+?~é\x00\ufeff"
_FACTORS = (0.5, 2, -1, 10, 0.1, 1e3, 1e-3, 1e6, 1e-6, 1e9, 1e-9, 1e12, 1e-12, 1e30, 1e-30)
# libyaml's are several times as fast
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
MOST_POINTS = 20_000  # of what passes, what takes longer is not computed


def mutant(text: str, rng: np.random.Generator, others: list[str]) -> str:
    """Return a spoiled text."""
    if rng.random() < 0.35:
        for _ in range(int(rng.integers(1, 5))):
            text = spoilt_text(text, rng)
        return text
    data = pickle.loads(_packed(text))
    for _ in range(int(rng.choice([1, 1, 1, 2, 3]))):
        data = spoilt_data(data, rng, others)
    return yaml.dump(data, Dumper=_DUMPER, sort_keys=False, allow_unicode=True)


@cache
def _packed(text: str) -> bytes:
    """Return the data of a file, to be unpacked for each try, which is faster than to parse it again."""
    return pickle.dumps(yaml.load(text, Loader=_LOADER))  # the safe one


def spoilt_text(text: str, rng: np.random.Generator) -> str:  # noqa: PLR0911
    """Return a text with one of its lines or characters lost, doubled, moved or made another."""
    lines, at = text.splitlines(keepends=True) or [""], int(rng.integers(len(text) + 1))
    i, j = (int(rng.integers(len(lines))) for _ in range(2))
    match int(rng.integers(9)):
        case 0:
            return text[:at] + text[at + 1 :]
        case 1:
            return text[:at] + str(rng.choice(list(_PIECES))) + text[at:]
        case 2:
            return text[:at]
        case 3:
            return "".join(lines[:i] + lines[i + 1 :])
        case 4:
            return "".join([*lines[:i], lines[j], *lines[i:]])
        case 5:
            lines[i], lines[j] = lines[j], lines[i]
            return "".join(lines)
        case 6:
            lines[i] = " " * int(rng.integers(1, 5)) + lines[i]
            return "".join(lines)
        case 7:
            return text[:at] + text[at + int(rng.integers(1, 30)) :]
        case _:
            return text[:at] + str(JUNK[int(rng.integers(len(JUNK)))]) + text[at:]


def _paths(data: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    inner = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    return [path, *(found for key, value in inner for found in _paths(value, (*path, key)))]


def _at(data: Any, path: tuple[Any, ...]) -> Any:
    for step in path:
        data = data[step]
    return data


def spoilt_data(data: Any, rng: np.random.Generator, names: list[str]) -> Any:
    """Return data with a value, or the name of one, lost, doubled or made another; they may be changed themselves."""
    paths = _paths(data)
    path = paths[int(rng.integers(len(paths)))]
    junk = deepcopy(JUNK[int(rng.integers(len(JUNK)))])  # later mutations change it
    if not path:
        return junk if rng.random() < 0.02 or not isinstance(data, dict | list) else data
    parent, key = _at(data, path[:-1]), path[-1]
    value = parent[key]
    match int(rng.integers(9)):
        case 0 | 1:
            parent[key] = junk
        case 2:
            del parent[key]
        case 3:
            parent[key] = deepcopy(_at(data, paths[int(rng.integers(len(paths)))]))
        case 4 if isinstance(value, int | float) and not isinstance(value, bool):
            parent[key] = value * float(rng.choice(_FACTORS))
        case 5 if isinstance(parent, dict):
            name = str(rng.choice(names))
            parent[name] = parent.pop(key) if rng.random() < 0.5 else junk
        case 6 if isinstance(parent, list):
            parent.insert(int(rng.integers(len(parent) + 1)), deepcopy(value))
        case 7 if isinstance(value, str) and value:
            at = int(rng.integers(len(value)))
            parent[key] = value[:at] + str(rng.choice(list(_PIECES))) + value[at + 1 :]
        case 8 if isinstance(value, str) and value[:1].isdigit():
            number, _, unit = value.partition(" ")
            parent[key] = f"{number}e{int(rng.integers(-40, 40))} {unit}"
        case _:
            parent[key] = [deepcopy(value)] if rng.random() < 0.5 else {"law": deepcopy(value)}
    return data


class YamlTarget:
    """Mutants of the files of a corpus, by their number; `run` runs the command for the share `deep` of what passes."""

    def __init__(
        self, files: list[Path], seed: int, deep: float = 1.0, run: Callable[[Path], str] | None = None
    ) -> None:
        self.files, self.seed, self.deep, self.run = files, seed, deep, run or _run
        self.texts = [file.read_text(encoding="utf-8") for file in files]
        keys = {key for text in self.texts for path in _paths(pickle.loads(_packed(text))) for key in path}
        self.names = sorted(key for key in keys if isinstance(key, str))

    def text(self, index: int) -> tuple[Path, str]:
        """Return the place and the text of a mutant."""
        rng = np.random.default_rng([self.seed, index])
        which = int(rng.integers(len(self.files)))
        file = self.files[which]
        return file.with_name(own(file.name)), mutant(self.texts[which], rng, self.names)

    def __call__(self, index: int) -> Outcome:
        file, text = self.text(index)
        file.write_text(text, encoding="utf-8", errors="replace")
        outcome = tried(lambda: checked(file), file)
        if outcome.kind == PASSED and np.random.default_rng([self.seed, index, 1]).random() < self.deep:
            outcome = tried(lambda: self.run(file), file)
        return Outcome(outcome.kind, f"{file.name}: {outcome.text}") if outcome.failed else outcome


def checked(file: Path) -> str:
    """Read a file as `check` does."""
    if problems := _checked(file).problems:
        raise InputError(problems)
    return PASSED


def _run(file: Path) -> str:
    kind = kind_of(file).name
    with placed_in(file):
        if kind in ("stack", "simulation"):
            simulated(file)
        elif kind == "stack-fit":
            # with little effort: it is the mistakes that count
            short = yaml.safe_load(file.read_text(encoding="utf-8")) | {"search": {"candidates": 4, "starts": 1}}
            brief = file.with_name(f"brief{file.name}")
            brief.write_text(yaml.safe_dump(short, allow_unicode=True), encoding="utf-8")
            FitTask(brief).read().run()
    return PASSED


def simulated(file: Path) -> None:
    """Simulate a file, unless that takes long, and look at the results.

    Raises
    ------
    UnsoundError
        When there is one that is no number, or creates energy.
    """
    simulation = load_simulation(file)
    planned = plan(simulation)
    points = sum(task.frequency.size * len(task.stack.layers) for task in planned.tasks)
    if points > MOST_POINTS:
        return
    result = run(planned)
    for case in result.cases:
        for name, values in case.quantities.items():
            if name not in OF_FREE_WAVES and np.isnan(values).any():
                raise UnsoundError(f"{name} is no number")
        if simulation.finite_size is None and not simulation.beside:  # both draw in power from around them
            _refuse_energy(case.quantities)
    result.to_dict()


def _refuse_energy(quantities: Any) -> None:
    loss = quantities.get("transmission_loss")
    through: RealArray | float = 0.0 if loss is None else 10 ** (-loss / 10)
    back = 1 - quantities["absorption"]
    if np.any(back + through > 1 + 2e-3) or np.any(back < -2e-3):
        raise UnsoundError(f"tau + R^2 = {np.max(back + through)}")
