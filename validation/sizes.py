"""How many lines the package has, and of what: ``docs/validation/sizes.md``.

Run it as ``python -m validation.sizes --before COMMIT > docs/validation/sizes.md``.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from argparse import ArgumentParser
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
HEADING = """# How large the package is

Made by `python -m validation.sizes`. Lines of `multilayer/**/*.py`: docstrings (which numpydoc wants with shapes,
units, errors and sources), imports, blank lines and comments, and what is left: code. [Design](../design.md#size) says
what could not shrink, and why.
"""


@dataclass(frozen=True)
class Lines:
    """Lines of some modules, by what they are.

    Attributes
    ----------
    modules, total, docstrings, imports, blank, code : int
    """

    modules: int = 0
    total: int = 0
    docstrings: int = 0
    imports: int = 0
    blank: int = 0
    code: int = 0

    def __add__(self, other: Lines) -> Lines:
        """Return the lines of both."""
        return Lines(*(getattr(self, name) + getattr(other, name) for name in self.__dataclass_fields__))

    @classmethod
    def of(cls, text: str) -> Lines:
        """Return the lines of a module."""
        docstrings, imports = set[int](), set[int]()
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node) is not None:
                docstrings |= _span(node.body[0])
            elif isinstance(node, ast.Import | ast.ImportFrom):
                imports |= _span(node)
        lines = text.splitlines()
        bare = {i for i, line in enumerate(lines, 1) if not line.strip() or line.lstrip().startswith("#")} - docstrings
        rest = len(lines) - len(docstrings | imports | bare)
        return cls(1, len(lines), len(docstrings), len(imports), len(bare), rest)


def _span(node: ast.stmt) -> set[int]:
    return set(range(node.lineno, (node.end_lineno or node.lineno) + 1))


def git(*words: str) -> str:
    """Return what git says."""
    return subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True, check=True).stdout


def lines_of(commit: str) -> dict[str, Lines]:
    """Return the lines of a commit by package; single modules together."""
    found: defaultdict[str, Lines] = defaultdict(Lines)
    for path in git("ls-tree", "-r", "--name-only", commit, "multilayer").splitlines():
        if path.endswith(".py"):
            part = path.split("/")[1]
            name = "single modules" if part.endswith(".py") else f"{part}/"
            found[name] += Lines.of(git("show", f"{commit}:{path}"))
    return dict(found)


def page(commit: str, before: str) -> str:
    """Return the page: a table of a commit by package, and the sums of it and of another one."""
    now, then = lines_of(commit), lines_of(before)
    head = ["| | modules | lines | docstrings | imports | blank, comments | code |", "|---|---|---|---|---|---|---|"]
    rows = [row(name, lines) for name, lines in sorted(now.items(), key=lambda item: -item[1].total)]
    sums = [row("**all**", total(now)), row(f"all, commit `{before}`", total(then))]
    return "\n".join([HEADING, *head, *rows, *sums, ""])


def total(parts: dict[str, Lines]) -> Lines:
    """Return the sum."""
    return sum(parts.values(), Lines())


def row(name: str, lines: Lines) -> str:
    """Return a row of the table."""
    shown = name if " " in name or "*" in name else f"`{name}`"
    numbers = (lines.modules, lines.total, lines.docstrings, lines.imports, lines.blank, lines.code)
    return f"| {shown} | {' | '.join(str(number) for number in numbers)} |"


def main() -> None:
    """Print the page."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--commit", default="HEAD", help="that is counted")
    parser.add_argument("--before", required=True, help="another commit, whose sum stands below")
    given = parser.parse_args()
    sys.stdout.write(page(given.commit, given.before))


if __name__ == "__main__":
    main()
