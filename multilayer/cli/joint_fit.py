"""``multilayer fit --joint``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from multilayer.inverse.joint_fit import JointFit
    from multilayer.inverse.sources import FitJob


def fit_one_law(job: FitJob, law: str, elements: int | None, out: Path | None, as_json: bool, figures: bool) -> None:
    """Fit one law to all bursts, write and print; exit status 1 when it does not explain them."""
    from multilayer.cli.progress import progress_bar
    from multilayer.errors import InputError, suggest
    from multilayer.inverse.joint_fit import fit_joint, number_of_steps
    from multilayer.media.laws import LAWS
    from multilayer.report.files import refuse_unusable, write_files
    from multilayer.report.joint_fit import joint_table

    if law not in LAWS:
        raise InputError(f"--law: there is no law '{law}'; {suggest(law, LAWS.names())}")
    refuse_unusable(out or Path("results"))
    with progress_bar("fit", number_of_steps(job.campaign, job.settings)) as advance:
        result = fit_joint(
            job.campaign, job.recordings, law, elements=elements, settings=job.settings, calibration=job.calibration,
            progress=advance,
        )  # fmt: skip
    folder = out or Path("results") / f"{result.campaign}-joint"
    written = write_files(folder, _files(result, figures))
    if as_json:
        typer.echo(json.dumps(result.to_dict(), indent=1))
    else:
        joint_table(result)
        typer.echo(f"written to {folder}: {', '.join(path.name for path in written)}")
    if not result.all_accepted:
        raise typer.Exit(1)


def _files(result: JointFit, figures: bool) -> dict[str, bytes | str]:
    files: dict[str, bytes | str] = {
        "moduli.csv": result.to_csv(),
        "joint.json": json.dumps(result.to_dict(), indent=1) + "\n",
    }
    if figures:
        from multilayer.report.joint_fit import joint_figures

        files.update(joint_figures(result))
    return files
