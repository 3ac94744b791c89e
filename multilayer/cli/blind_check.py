"""``multilayer blind-check``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from multilayer.diagnosis.blind_check import Answer, Outcome


def blind_check(
    campaigns: Annotated[int, typer.Option("--campaigns", metavar="N", help="How many campaigns are drawn.")] = 400,
    seed: Annotated[int, typer.Option(help="Below 1000: development; from 1000 on: final runs.")] = 1,
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
    from multilayer.diagnosis.blind_check import BlindTask, answer, unseal
    from multilayer.errors import InputError
    from multilayer.executors import as_done, executor_for
    from multilayer.report.blind_report import blind_files
    from multilayer.report.files import refuse_unusable, write_files

    if campaigns < 1:
        raise InputError(f"--campaigns: {campaigns} is not allowed; it must be at least 1")
    if seed < 0:
        raise InputError(f"--seed: {seed} is not allowed; it must be 0 or more")
    refuse_unusable(out)
    out.mkdir(parents=True, exist_ok=True)
    store = Store(out / "answers.jsonl", seed)
    answers = {one.number: one for one in store.begin(resume=resume) if one.number < campaigns}
    left = [BlindTask(number, seed) for number in range(campaigns) if number not in answers]
    try:
        with executor_for(jobs, cluster) as executor, progress_bar("blind check", len(left)) as advance:
            for index, found in as_done(answer, left, executor):
                store.append(found)
                answers[left[index].number] = found
                advance(f"campaign {left[index].number}")
    except KeyboardInterrupt:
        typer.echo(f"stopped: {len(answers)} of {campaigns} are in {out}; --resume goes on from there", err=True)
        raise typer.Exit(130) from None
    outcomes = unseal(list(answers.values()), seed)
    files = blind_files(outcomes, seed, figures=figures)
    written = write_files(out, files)
    if as_json:
        typer.echo(files["blind_check.json"], nl=False)
    else:
        _print(outcomes)
        typer.echo(f"written to {out}: {', '.join(path.name for path in written)}")


class Store:
    """A file of answers, one line of JSON each, with what they were made with in the first."""

    def __init__(self, path: Path, seed: int) -> None:
        self.path, self._head = path, _made_with(seed)

    def begin(self, *, resume: bool) -> list[Answer]:
        """Return the answers to go on with; without `resume` none, and the file begins anew.

        Raises
        ------
        InputError
            For answers of another seed, version, or other thresholds.
        """
        from multilayer.diagnosis.blind_check import Answer
        from multilayer.errors import InputError

        lines = self.path.read_text(encoding="utf-8").splitlines() if resume and self.path.exists() else []
        plain = [one for one in map(_parsed, lines) if one is not None]  # the last may be cut short
        if plain and plain[0] != self._head:
            text = "holds answers of another seed, version or other thresholds"
            raise InputError(f"{self.path} {text}; choose another --out, or leave out --resume")
        kept = [self._head, *plain[1:]]
        beside = self.path.with_suffix(".part")
        beside.write_text("".join(f"{json.dumps(one)}\n" for one in kept), encoding="utf-8")
        beside.replace(self.path)
        return [Answer.from_dict(one) for one in kept[1:]]

    def append(self, answer: Answer) -> None:
        """Add an answer."""
        with self.path.open("a", encoding="utf-8") as file:
            file.write(f"{json.dumps(answer.to_dict())}\n")


def _parsed(line: str) -> dict[str, Any] | None:
    try:
        found: dict[str, Any] = json.loads(line)
    except ValueError:
        return None
    return found


def _made_with(seed: int) -> dict[str, Any]:
    from importlib.metadata import version

    from multilayer.diagnosis import thresholds

    values = {name: getattr(thresholds, name) for name in dir(thresholds) if name.isupper()}
    return {"seed": seed, "multilayer": version("multilayer"), "thresholds": values}


def _print(outcomes: list[Outcome]) -> None:
    from rich.table import Table

    from multilayer.report.blind_report import number, score_table, target
    from multilayer.report.console import console

    for name, found in score_table(outcomes):
        table = Table(title=name, title_justify="left", box=None, pad_edge=False)
        for column in ("score", "value", "cases", "target", "met"):
            table.add_column(column, justify="left" if column == "score" else "right")
        for score in found:
            met = {True: "yes", False: "no", None: "-"}[score.met]
            table.add_row(score.name, number(score.value), str(score.n), target(score), met)
        console().print(table)
