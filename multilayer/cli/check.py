"""``multilayer check``."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from multilayer.errors import Problem


def check(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="Any of the project's YAML files, or folders with a campaign or a fit."),
    ],
    as_json: Annotated[bool, typer.Option("--json", help="Print what was found of every file as JSON.")] = False,
) -> None:
    """Read files without running anything: say what kind each is, and every mistake with its line and column.

    Stacks, simulations, campaigns, calibrations, fits, diagnoses, virtual rigs and libraries of materials; the signals,
    tables and stacks that they name are read and checked as well. Exit status 2 when anything is wrong.

    Example: multilayer check examples/three_layers.yaml examples/foam_b
    """
    from multilayer.errors import InputError
    from multilayer.json_text import json_text

    checked = [_checked(file) for file in files]
    if as_json:
        typer.echo(json_text([one.to_dict() for one in checked]), nl=False)
        if any(one.problems for one in checked):
            raise typer.Exit(2)
        return
    for one in checked:
        if not one.problems:
            typer.echo(f"{one.file}: a {one.summary} without mistakes")
    if problems := [problem for one in checked for problem in one.problems]:
        raise InputError(problems)


@dataclass(frozen=True)
class _Checked:
    """What was found of one file: its kind and what it holds, where it can be told, or its mistakes."""

    file: Path
    kind: str | None = None
    summary: str = ""
    problems: list[Problem] = field(default_factory=list)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        problems = [{**asdict(one), "file": one.file and str(one.file)} for one in self.problems]
        said = {"kind": self.kind, "sound": not self.problems, "summary": self.summary, "problems": problems}
        return {"file": str(self.file), **said}


def _checked(file: Path) -> _Checked:
    from multilayer.config.validate import placed_in
    from multilayer.errors import InputError
    from multilayer.kinds import kind_of

    kind = None
    try:
        kind = kind_of(file)
        with placed_in(file):
            return _Checked(file, kind.name, kind.read(file))
    except InputError as error:
        return _Checked(file, kind.name if kind else None, problems=error.problems)
