"""``multilayer rig``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from multilayer.cli.options import folder_for

if TYPE_CHECKING:
    from multilayer.rig.file import RigFile
    from multilayer.rig.synthesis import Measured, SyntheticCampaign, Task


def rig(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A virtual rig, as examples/virtual_rig.yaml.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="CAMPAIGN", help="Folder of the campaign; results/NAME when left out."),
    ] = None,
    quiet_truth: Annotated[
        bool,
        typer.Option("--quiet-truth", help="Hide the truth file in .truth beside the campaign, and say nothing of it."),
    ] = False,
    seed: Annotated[
        int | None, typer.Option("--seed", metavar="N", min=0, help="In place of the seed in the file.")
    ] = None,
    jobs: Annotated[int, typer.Option("--jobs", metavar="N", help="Processes of this machine to compute with.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print what was written as JSON.")] = False,
) -> None:
    """Measure a campaign on the virtual two-plate rig, with the effects and the noise that FILE lists.

    Writes a campaign folder that fit reads, and beside it NAME.truth.json, which says what was done. Exit status: 0
    done, 2 the input cannot be used (nothing is written).

    Example: multilayer rig examples/virtual_rig.yaml --out results/virtual
    """
    from multilayer.json_text import json_text
    from multilayer.rig.file import load_rig
    from multilayer.rig.writer import refuse_foreign, write_campaign

    settings = load_rig(file)
    folder = folder_for(out, file.stem)
    refuse_foreign(folder)
    made = _make(file, settings, seed, jobs)
    truth = write_campaign(made, folder, quiet=quiet_truth)
    if as_json:
        typer.echo(json_text(_said(made, folder, None if quiet_truth else truth)), nl=False)
        return
    configurations = len(made.campaign.configurations)
    typer.echo(f"written to {folder}: {len(made.recordings)} bursts of {configurations} configurations")
    if not quiet_truth:
        typer.echo(f"truth ({made.truth['effect']}): {truth}")


def _said(made: SyntheticCampaign, folder: Path, truth: Path | None) -> dict[str, Any]:
    """Return what was written as plain data; of the truth nothing where it is to be hidden."""
    return {
        "version": 1,
        "campaign": str(folder),
        "configurations": [one.name for one in made.campaign.configurations],
        "bursts": len(made.recordings),
        "truth": None if truth is None else str(truth),
        "effect": None if truth is None else made.truth["effect"],
    }


def _make(file: Path, settings: RigFile, seed: int | None, jobs: int) -> SyntheticCampaign:
    from multilayer.cli.progress import progress_bar
    from multilayer.config.yaml12 import read_yaml
    from multilayer.errors import InputError
    from multilayer.executors import local_pool, run_all
    from multilayer.rig.synthesis import make_campaign

    names = [mounting.name for mounting in settings.mountings]
    with progress_bar("rig", len(names)) as advance, local_pool(jobs) as executor:

        def mapper(function: Callable[[Task], Measured], tasks: Sequence[Task]) -> list[Measured]:
            return run_all(function, tasks, executor, lambda index: advance(names[index]))

        try:
            return make_campaign(settings, seed, mapper)
        except InputError as error:
            document = read_yaml(file)  # what only shows on the rig is told at its line, too
            places = [document.position(tuple(problem.path.split("."))) for problem in error.problems]
            placed = [problem.at(file, *place) for problem, place in zip(error.problems, places, strict=True)]
            raise InputError(placed) from None
