"""Imports point down: the floors of ``docs/design.md`` hold, and no package leads back to itself."""

from __future__ import annotations

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

import multilayer

ROOT = Path(multilayer.__file__).parent
DESIGN = Path(__file__).parents[2] / "docs" / "design.md"
ROW = re.compile(r"^\| (\d+) \| ([^|]*) \|", re.MULTILINE)


def floors() -> dict[str, int]:
    """Return the floor of every package and single module, as the table of the design page has them."""
    rows = ROW.findall(DESIGN.read_text(encoding="utf-8"))
    return {name: int(floor) for floor, names in rows for name in re.findall(r"`(\w+)(?:/|\.py)`", names)}


def arrows() -> dict[tuple[str, str], str]:
    """Return which package imports which, those within functions among them, and a file that does."""
    found = {}
    for file in ROOT.rglob("*.py"):
        parts = file.relative_to(ROOT).with_suffix("").parts
        if parts in (("__init__",), ("__main__",)):
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            for name in imported(node):
                if name.startswith("multilayer.") and (target := name.split(".")[1]) != parts[0]:
                    found[parts[0], target] = file.relative_to(ROOT).as_posix()
    return found


def imported(node: ast.AST) -> list[str]:
    """Return the modules that a statement imports."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.module:
        return [f"{node.module}.{alias.name}" for alias in node.names] if node.module == "multilayer" else [node.module]
    return []


def test_every_package_has_a_floor() -> None:
    packages = {path.stem for path in ROOT.iterdir() if path.suffix == ".py" or (path / "__init__.py").is_file()}
    assert packages - {"__init__", "__main__"} == set(floors())


def test_no_import_points_up() -> None:
    floor = floors()
    assert {pair: file for pair, file in arrows().items() if floor[pair[1]] > floor[pair[0]]} == {}


def test_no_package_leads_back_to_itself() -> None:
    graph: dict[str, set[str]] = {}
    for above, below in arrows():
        graph.setdefault(above, set()).add(below)
    order = [*TopologicalSorter(graph).static_order()]  # raises CycleError
    assert set(order) <= set(floors())


def test_inference_knows_no_acoustics() -> None:
    floor = floors()
    assert {below for above, below in arrows() if above == "inference" and floor[below] > 0} == set()
