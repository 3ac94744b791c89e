"""``multilayer blind-check``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from validation.blind_check.check import Outcome


def blind_check(
    campaigns: Annotated[int, typer.Option("--campaigns", metavar="N", help="How many campaigns are drawn.")] = 400,
    seed: Annotated[int, typer.Option(help="Below 1000: development; from 1000 on: final runs, judged once.")] = 1,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where results go.")] = Path("results/blind-check"),
    jobs: Annotated[int, typer.Option("--jobs", metavar="N", help="Processes to compute with.")] = 1,
    cluster: Annotated[str | None, typer.Option("--cluster", metavar="ADDRESS", help="A Dask scheduler.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with what is in --out.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print blind_check.json in place of the tables.")] = False,
    figures: Annotated[bool, typer.Option("--figures/--no-figures", help="Draw the figure.")] = True,
) -> None:
    """Check the diagnosis on campaigns of the virtual rig whose effects it is not told.

    Draws campaigns with no effect, one, two, or one that the library lacks, diagnoses each, then opens the labels and
    scores. Writes answers.jsonl as it goes, then blind_check.md, blind_check.json and a figure.

    Example: multilayer blind-check --campaigns 40 --seed 7 --jobs 2
    """
    from multilayer.cli.progress import progress_bar
    from multilayer.errors import InputError
    from multilayer.executors import as_done, executor_for
    from multilayer.json_lines import JsonLines
    from multilayer.writing.folders import claim_folder, write_files
    from validation.blind_check.check import Answer, BlindTask, answer, unseal
    from validation.blind_check.report import blind_files

    if campaigns < 1:
        raise InputError(f"--campaigns: {campaigns} is not allowed; it must be at least 1")
    if seed < 0:
        raise InputError(f"--seed: {seed} is not allowed; it must be 0 or more")
    claim_folder(out)
    out.mkdir(parents=True, exist_ok=True)
    store = JsonLines(out / "answers.jsonl", _made_with(seed))
    before = [Answer.from_dict(one) for one in store.begin(resume=resume)]
    answers = {one.number: one for one in before if one.number < campaigns}
    left = [BlindTask(number, seed) for number in range(campaigns) if number not in answers]
    try:
        with executor_for(jobs, cluster) as executor, progress_bar("blind check", len(left)) as advance:
            for index, found in as_done(answer, left, executor):
                store.append(found.to_dict())
                answers[left[index].number] = found
                advance(f"campaign {left[index].number}")
    except KeyboardInterrupt:
        typer.echo(f"stopped: {len(answers)} of {campaigns} are in {out}; --resume goes on from there", err=True)
        raise typer.Exit(130) from None
    outcomes = unseal(list(answers.values()), seed)
    files = blind_files(outcomes, seed, figures=figures)
    written = write_files(out, files, made_by="blind-check")
    if as_json:
        typer.echo(files["blind_check.json"], nl=False)
    else:
        _print(outcomes)
        typer.echo(f"written to {out}: {', '.join(path.name for path in written)}")


def _made_with(seed: int) -> dict[str, Any]:
    from importlib.metadata import version

    from multilayer.diagnosis.thresholds import in_force

    return {"seed": seed, "multilayer": version("multilayer"), "thresholds": in_force()}


def _print(outcomes: list[Outcome]) -> None:
    from rich.table import Table

    from multilayer.report.console import console
    from validation.blind_check.report import number, score_table, target

    for name, found in score_table(outcomes):
        table = Table(title=name, title_justify="left", box=None, pad_edge=False)
        for column in ("score", "value", "cases", "target", "met"):
            table.add_column(column, justify="left" if column == "score" else "right")
        for score in found:
            met = {True: "yes", False: "no", None: "-"}[score.met]
            table.add_row(score.name, number(score.value), str(score.n), target(score), met)
        console().print(table)
