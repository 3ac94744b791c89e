"""``multilayer check``."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from multilayer.errors import Problem

_RESULTS = "results"


def check(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...", help="Any of the project's YAML files, or folders: with a campaign, a fit, or results."
        ),
    ],
    as_json: Annotated[bool, typer.Option("--json", help="Print what was found of every file as JSON.")] = False,
) -> None:
    """Read files without running anything: say what kind each is, and every mistake with its line and column.

    Stacks, simulations, campaigns, calibrations, fits, diagnoses, virtual rigs and libraries of materials; the signals,
    tables and stacks that they name are read and checked as well. Of a folder of results: whether its files are those
    that were written. Exit status 2 when anything is wrong.

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
            article = "an" if one.summary.startswith("o") else "a"  # an optimisation
            typer.echo(f"{one.file}: {article} {one.summary} without mistakes")
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
        if _is_result(file):
            return _checked_result(file)
        kind = kind_of(file)
        with placed_in(file):
            return _Checked(file, kind.name, kind.read(file))
    except InputError as error:
        return _Checked(file, kind.name if kind else None, problems=error.problems)


def _is_result(folder: Path) -> bool:
    """Tell whether a folder holds results, and no campaign or fit."""
    from multilayer.kinds import FOLDER_FILES
    from multilayer.writing.manifest import MANIFEST

    if any((folder / name).is_file() for name in FOLDER_FILES):
        return False
    return (folder / MANIFEST).is_file()


def _checked_result(folder: Path) -> _Checked:
    from multilayer.errors import Problem
    from multilayer.writing.folders import is_unfinished
    from multilayer.writing.manifest import MANIFEST, changed_inputs, differences, listed, read_manifest

    manifest = read_manifest(folder)
    if manifest is None:
        return _Checked(
            folder, _RESULTS, problems=[Problem("is no manifest; run the command again", file=folder / MANIFEST)]
        )
    problems = [
        Problem("is missing, or is not as it was written; run the command again", file=folder / name)
        for name in differences(folder, manifest)
    ]
    if is_unfinished(folder):
        problems.append(Problem("the last run into this folder was cut off; run it again", file=folder))
    for name in changed_inputs(manifest):
        typer.echo(f"remark: {name} has changed since these results were made", err=True)
    commands = ", ".join(manifest["results"])
    return _Checked(folder, _RESULTS, f"result of {len(listed(manifest))} files by {commands}", problems)
