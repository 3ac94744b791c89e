"""What commands write, kept and compared: nothing a user reads may change with the code's shape.

Run it as ``python -m validation.golden FOLDER`` before a change and into another folder after it, then
``python -m validation.golden BEFORE --against AFTER`` (exit status 1 where they differ). Each of the commands
writes into a folder of its own; their JSON and CSV files are compared, numbers to 1e-6. Several minutes on two cores;
``--quick`` leaves the diagnoses of large campaigns out.
"""

from __future__ import annotations

import csv
import json
import math
import os
import subprocess
import sys
from argparse import ArgumentParser
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
CAMPAIGNS = ROOT / ".." / "shared" / "campaigns"
SAME = 1e-6  # of a number, or of the largest of the list it stands in
FOAM = "examples/foam_b"
COMMANDS = {
    "fit": ["fit", FOAM],
    "fit-nelder-mead": ["fit", FOAM, "--method", "nelder-mead"],
    "fit-finite": ["fit", FOAM, "--model", "finite"],
    "joint": ["fit", FOAM, "--joint"],
    "joint-finite": ["fit", FOAM, "--joint", "--model", "finite"],
    "joint-auto": ["fit", FOAM, "--joint", "--law", "auto"],
    "joint-profile": ["fit", FOAM, "--joint", "--posterior", "profile"],
    "stack-fit": ["fit", "examples/foam_tube"],
    "stack-fit-profile": ["fit", "examples/foam_tube", "--posterior", "profile"],
    "methods": ["methods", FOAM],
    "tube": ["tube", "examples/raw_tube/tube.yaml"],
    "diagnose-tube": ["diagnose", "examples/foam_tube/fit.yaml"],
    "diagnose-foam_b": ["diagnose", FOAM],
    "simulate": ["simulate", "examples/foam_absorption.yaml"],
    "simulate-wall": ["simulate", "examples/double_wall.yaml"],
}
SHARED = {
    "fit": ["fit"],
    "joint": ["fit", "--joint"],
    "diagnose": ["diagnose"],
}


def main() -> None:
    """Run the commands, or compare two folders of theirs."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--against", type=Path, help="another folder, made by another state of the code")
    parser.add_argument("--quick", action="store_true", help="without the shared campaigns")
    given = parser.parse_args()
    if given.against:
        told = [line for name in compared(given.folder) for line in differences(given.folder, given.against, name)]
        tell("\n".join([*told, f"{len(compared(given.folder))} files, {len(told) or 'no'} differences"]))
        sys.exit(int(bool(told)))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for line in pool.map(lambda pair: run(given.folder, *pair), commands(quick=given.quick).items()):
            tell(line)


def commands(*, quick: bool) -> dict[str, list[str]]:
    """Return the commands by the name of the folder that each writes into."""
    found = dict(COMMANDS)
    if not quick:
        for file in sorted(CAMPAIGNS.glob("*/campaign.yaml")):
            name = file.parent.name
            found |= {f"{kind}-{name}": [*words, str(file.parent)] for kind, words in SHARED.items()}
    return found


def run(folder: Path, name: str, words: list[str]) -> str:
    """Run a command, one thread, and return what is to be told of it."""
    command = [sys.executable, "-m", "multilayer", *words, "--out", str((folder / name).resolve())]
    done = subprocess.run(
        command, cwd=ROOT, env={"OMP_NUM_THREADS": "1", **os.environ}, capture_output=True, text=True, check=False
    )
    return f"{name}: exit status {done.returncode}" + ("" if done.returncode < 2 else f"\n{done.stderr}")


def compared(folder: Path) -> list[str]:
    """Return the files that are compared."""
    files = sorted(path for path in folder.rglob("*") if path.suffix in (".json", ".csv"))
    return [path.relative_to(folder).as_posix() for path in files]


def differences(before: Path, after: Path, name: str) -> Iterator[str]:
    """Give a line for every value of a file that differs."""
    if not (after / name).is_file():
        yield f"{name}: is not there any more"
        return
    yield from (f"{name}: {told}" for told in unlike(read(before / name), read(after / name)))


def read(path: Path) -> Any:
    """Return what a file holds; a table as a list of rows."""
    if path.suffix == ".json":
        return json.loads(path.read_text(encoding="utf-8"))
    with path.open(newline="", encoding="utf-8") as lines:
        return [[number(cell) for cell in row] for row in csv.reader(lines)]


def number(cell: str) -> float | str:
    """Return a cell's number, or its text."""
    try:
        return float(cell)
    except ValueError:
        return cell


def unlike(one: Any, other: Any, place: str = "", scale: float = 0.0) -> Iterator[str]:
    """Give a line for every value that differs, with its place."""
    if isinstance(one, dict) and isinstance(other, dict):
        yield from (f"{place}.{key}: only in one of them" for key in sorted(one.keys() ^ other.keys()))
        for key in one.keys() & other.keys():
            yield from unlike(one[key], other[key], f"{place}.{key}")
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        largest = max((abs(v) for v in one if isinstance(v, float) and math.isfinite(v)), default=0.0)
        for i, pair in enumerate(zip(one, other, strict=True)):
            yield from unlike(*pair, f"{place}[{i}]", largest)
    elif isinstance(one, float) and isinstance(other, int | float):
        if not (
            math.isclose(one, other, rel_tol=SAME, abs_tol=SAME * scale) or (math.isnan(one) and math.isnan(other))
        ):
            yield f"{place}: {one!r} was, {other!r} is"
    elif one != other:
        yield f"{place}: {one!r} was, {other!r} is"


def tell(text: str) -> None:
    """Write a line."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
