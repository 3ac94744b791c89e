"""The files of a diagnosis."""

from __future__ import annotations

from multilayer.diagnosis.result import Diagnosis
from multilayer.report.diagnosis_figures import diagnosis_figures
from multilayer.report.diagnosis_html import diagnosis_html


def diagnosis_files(result: Diagnosis, *, figures: bool = True) -> dict[str, bytes | str]:
    """Return what ``multilayer diagnose`` writes, by file name.

    Parameters
    ----------
    result : Diagnosis
    figures : bool
        Whether to draw: figures and the report that holds them.
    """
    files: dict[str, bytes | str] = {"diagnosis.json": result.to_json()}
    if figures:
        files["report.html"] = diagnosis_html(result)
        files.update(diagnosis_figures(result))
    return files
