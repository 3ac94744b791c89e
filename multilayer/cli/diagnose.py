"""``multilayer diagnose``."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from multilayer.cli import completion
from multilayer.cli.options import AsJson, Figures, finish, folder_for

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from multilayer.diagnosis.result import Diagnosis
    from multilayer.fits.sources import Source

_MODULES = ("multilayer.cli", "multilayer.diagnosis.diagnose")  # that workers need
_DRAWING = ("multilayer.report.diagnosis_figures", "matplotlib.figure", "matplotlib.backends.backend_svg")
_MOST_JOBS = 4  # there are some twenty fits, most of them short


def diagnose(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="CAMPAIGN_OR_FILE",
            help="A campaign folder, its campaign.yaml, a fit file; or stacks and their measurements: of a tube, "
            "transmission loss, absorption.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Where results go; results/NAME-diagnosis when left out."),
    ] = None,
    as_json: AsJson = False,
    without: Annotated[
        list[str] | None,
        typer.Option(
            "--without",
            metavar="EFFECT",
            help="Leave an effect out; may be repeated.",
            autocompletion=completion.effects,
        ),
    ] = None,
    known: Annotated[
        list[str] | None,
        typer.Option(
            "--with",
            metavar="EFFECT_OR_FILE",
            help="What is known to act: an effect, a file of --save-law, a diagnosis.json; may be repeated. What is "
            "left beyond it is diagnosed.",
            autocompletion=completion.effects,
        ),
    ] = None,
    save_law: Annotated[
        Path | None,
        typer.Option("--save-law", metavar="FILE", help="Write what was found for --with of later campaigns (YAML)."),
    ] = None,
    law: Annotated[
        str | None,
        typer.Option(
            help="The modulus law of a campaign's nominal model; fractional_zener by default.",
            autocompletion=completion.laws,
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the search's starting points.")] = 0,
    jobs: Annotated[
        int | None, typer.Option(metavar="N", help="Processes to compute with; one per core, at most 4, by default.")
    ] = None,
    figures: Figures = True,
    exit_code: Annotated[
        bool, typer.Option("--exit-code", help="End with status 1 where there is a gap, as diff does; for scripts.")
    ] = False,
) -> None:
    """Say where model and measurement disagree, which effect causes it, how far it shrinks.

    Writes diagnosis.json, moduli.csv (nominal and corrected, with intervals), figures and report.html. Exit status: 0
    done, whatever was found (with --exit-code 1 for a gap), 2 the input cannot be used (nothing is written).

    Example: multilayer diagnose examples/foam_b --out results/why

    Example: multilayer diagnose examples/foam_tube

    Example: multilayer diagnose examples/foam_b --with sensor_mass

    Example: multilayer diagnose campaigns/one --save-law rig.yaml, then multilayer fit campaigns/two --with rig.yaml
    """
    from multilayer.executors import local_pool

    n_jobs = min(os.cpu_count() or 1, _MOST_JOBS) if jobs is None else jobs
    # before the imports of this process: the workers' own take as long
    with local_pool(n_jobs, [*_MODULES, *(_DRAWING if figures else ())]) as executor:
        from multilayer.config.validate import placed_in
        from multilayer.errors import InputError
        from multilayer.fits.sources import open_source
        from multilayer.report.diagnosis import diagnosis_report
        from multilayer.writing.folders import claim_file

        opened = open_source(source)
        if opened.of_stacks and (known or save_law):
            raise InputError(f"--with and --save-law are of campaigns; {source} is of stacks: leave them out")
        _check_without(without or [])
        if save_law is not None:
            with _told_of_law():
                claim_file(save_law)
        ask = _stacks if opened.of_stacks else partial(_campaign, known or [])
        with placed_in(source):
            result, folder = ask(opened, out, without or [], law, seed, executor)
        report = diagnosis_report(result, source, folder)
        finish(report, folder, as_json=as_json, figures=figures, executor=executor)
        if save_law is not None:
            _save(result, save_law)
    if exit_code and result.verdict != "no_gap":
        raise typer.Exit(1)


def _save(result: Diagnosis, file: Path) -> None:
    """Write what was found, or say why there is nothing to write: that is no reason to lose the diagnosis."""
    from multilayer.config.yaml12 import dump_yaml
    from multilayer.diagnosis.saved_law import saved_law
    from multilayer.errors import InputError
    from multilayer.writing.folders import write_file

    try:
        found = saved_law(result.record, result.campaign)
    except InputError as error:
        typer.echo(f"warning: --save-law: {error}", err=True)
        return
    data = {"kind": "rig-law", **found.model_dump(mode="json", exclude_defaults=True), "version": 1}
    with _told_of_law():
        write_file(file, dump_yaml(data))
    typer.echo(f"law written to {file}", err=True)


@contextmanager
def _told_of_law() -> Iterator[None]:
    """Tell of a file that cannot be written which option names it."""
    from multilayer.errors import InputError

    try:
        yield
    except InputError as error:
        raise InputError(f"--save-law: {error}".replace("another folder with --out", "another file")) from None


def _check_without(names: list[str]) -> None:
    from multilayer.diagnosis.effects.base import EFFECTS
    from multilayer.errors import InputError, suggest

    for name in names:
        if name not in EFFECTS:
            raise InputError(f"--without: there is no effect '{name}'; {suggest(name, EFFECTS.names())}")


def _campaign(
    known: list[str],
    source: Source,
    out: Path | None,
    without: list[str],
    law: str | None,
    seed: int,
    executor: Executor | None,
) -> tuple[Diagnosis, Path]:
    """Return the diagnosis of a campaign, and the folder for its files."""
    from multilayer.cli.progress import progress_bar
    from multilayer.diagnosis.diagnose import N_STEPS, chosen_effects, diagnose_campaign, warn_of_settings
    from multilayer.diagnosis.saved_law import known_effects
    from multilayer.errors import InputError, suggest
    from multilayer.fits.settings import DEFAULT_LAW
    from multilayer.media.laws import LAWS

    effects = chosen_effects(None, without)
    chosen = law or DEFAULT_LAW
    if chosen not in LAWS:
        raise InputError(f"--law: there is no law '{chosen}'; {suggest(chosen, LAWS.names())}")
    given = [effect for name in known for effect in known_effects(name)]
    job = source.campaign_job(source.settings())
    warn_of_settings(job.settings, given)
    folder = folder_for(out, f"{job.name}-diagnosis")
    with progress_bar("diagnose", N_STEPS) as advance:
        result = diagnose_campaign(
            job.campaign, job.recordings, effects,
            law=chosen, calibration=job.calibration, given=given, seed=seed, progress=advance, executor=executor,
        )  # fmt: skip
    return result, folder


def _stacks(
    source: Source, out: Path | None, without: list[str], law: str | None, seed: int, executor: Executor | None
) -> tuple[Diagnosis, Path]:
    """Return the diagnosis of stacks and measurements of a tube, or of levels, and the folder for its files."""
    from multilayer.cli.progress import progress_bar
    from multilayer.diagnosis.file import load_diagnosis
    from multilayer.diagnosis.levels.diagnose import diagnose_levels
    from multilayer.diagnosis.tube.diagnose import N_STEPS, diagnose_tube
    from multilayer.errors import InputError
    from multilayer.experiments.stacks.file import name_of

    if law is not None:
        raise InputError(f"--law is of campaigns; {source.path} is of stacks, whose unknowns it names: leave it out")
    file, name = load_diagnosis(source.document), name_of(source.path)
    effects = file.chosen(without)
    folder = folder_for(out, f"{name}-diagnosis")
    with progress_bar("diagnose", N_STEPS) as advance:
        kind = diagnose_levels if file.of_levels else diagnose_tube
        result = kind(file, name, effects, seed=seed, progress=advance, executor=executor)
    return result, folder
