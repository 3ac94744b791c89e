"""The files of a fit, and its table: what is drawn and printed of results of every kind; nothing is fitted here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from multilayer.fits.methods import JOINT, STACKS
from multilayer.fits.result import FitResult
from multilayer.fits.run import FitRun
from multilayer.json_text import json_text
from multilayer.report.files import file_names

Files = dict[str, bytes | str]


def fit_files(fit: FitRun, result: FitResult, record: Mapping[str, Any], *, figures: bool = True) -> Files:
    """Return the files of a result by name.

    Parameters
    ----------
    fit : FitRun
    result : FitResult
        Of that fit.
    record : mapping
        All of it as plain data, `FitRun.to_dict`.
    figures : bool
        Whether to draw figures and the HTML report.
    """
    files: Files = {**result.tables, result.record_name: json_text(record), **_stack_files(result)}
    return files | (_DRAWN.get(result.kind, _draw_bursts)(fit, result) if figures else {})


def print_fit(result: FitResult) -> None:
    """Print the table of a result."""
    _PRINTED.get(result.kind, _print_bursts)(result)


def _stack_files(result: Any) -> Files:
    if result.kind != STACKS:
        return {}
    texts = result.stack_files()
    return {f"fitted-{name}.yaml": text for name, text in zip(file_names(list(texts)), texts.values(), strict=True)}


def _draw_bursts(fit: FitRun, result: FitResult) -> Files:
    from multilayer.report.fit_figures import draw_gross_check, draw_moduli, fit_figures
    from multilayer.report.fit_html import fit_html
    from multilayer.report.style import figure_style, png

    job: Any = fit.job
    if any(burst.time.size for burst in result.bursts):
        page = fit_html(result, job.campaign, job.settings, fit.inputs)
        return {"report.html": page, **fit_figures(result, job.campaign, job.settings)}
    known = replace(result, bursts=[burst for burst in result.bursts if np.isfinite(burst.storage_modulus)])
    if not known.bursts:
        return {}
    with figure_style():
        return {"moduli.png": png(draw_moduli(known, job.settings)), "gross_check.png": png(draw_gross_check(known))}


def _draw_joint(fit: FitRun, result: Any) -> Files:
    from multilayer.report.joint_fit import joint_figures
    from multilayer.report.joint_html import joint_html

    return {"report.html": joint_html(result, fit.inputs), **joint_figures(result)}


def _draw_stacks(fit: FitRun, result: Any) -> Files:
    del fit
    from multilayer.report.stack_fit import stack_fit_figures
    from multilayer.report.stack_fit_html import stack_fit_html

    return {"report.html": stack_fit_html(result), **stack_fit_figures(result)}


def _print_bursts(result: FitResult) -> None:
    from rich.text import Text

    from multilayer.report.console import console
    from multilayer.report.fit_table import fit_table

    fit_table(result)
    for remark in result.remarks:
        console().print(Text(remark))


def _print_joint(result: Any) -> None:
    from multilayer.report.joint_fit import joint_table

    joint_table(result)


def _print_stacks(result: Any) -> None:
    from multilayer.report.stack_fit import stack_fit_table

    stack_fit_table(result)


# by the kind of result; moduli burst by burst otherwise
_DRAWN = {JOINT: _draw_joint, STACKS: _draw_stacks}
_PRINTED = {JOINT: _print_joint, STACKS: _print_stacks}
