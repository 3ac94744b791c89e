"""The files of a diagnosis."""

from __future__ import annotations

from concurrent.futures import Executor

from multilayer.diagnosis.result import Diagnosis
from multilayer.report.diagnosis_figures import diagnosis_pictures
from multilayer.report.diagnosis_html import diagnosis_html


def diagnosis_files(
    result: Diagnosis, *, figures: bool = True, executor: Executor | None = None
) -> dict[str, bytes | str]:
    """Return what ``multilayer diagnose`` writes, by file name.

    Parameters
    ----------
    result : Diagnosis
    figures : bool
        Whether to draw: figures and the report that holds them.
    executor : Executor, optional
        Where figures are drawn; in this process when left out.
    """
    files: dict[str, bytes | str] = {"diagnosis.json": result.to_json()}
    if figures:
        pictures = diagnosis_pictures(result, executor)
        files["report.html"] = diagnosis_html(result, {name: one.svg for name, one in pictures.items()})
        files.update({f"{name}.png": one.png for name, one in pictures.items()})
    return files
