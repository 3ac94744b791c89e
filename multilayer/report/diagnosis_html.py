"""The report of a diagnosis: one HTML file for screen and paper, verdict first, without scripts or anything outside."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from multilayer.diagnosis.result import Diagnosis
from multilayer.report.diagnosis_curves import unexplained
from multilayer.report.diagnosis_figures import curve_names
from multilayer.report.diagnosis_rows import (
    absorbed_names,
    alike_rows,
    cause_rows,
    detectable_items,
    gap_numbers,
    group_items,
    in_words,
    input_rows,
    next_rows,
    unknown_rows,
    where_rows,
)
from multilayer.report.html import render

_LABELS = {"effect": "Cause found", "unknown": "Cause unknown", "no_gap": "No gap"}
_FIGURES = ("where", "causes", "similarity", "next_experiment", "moduli")
_MOST_CURVES = 12  # the first is printed, the others are folded away; all of them are files
_MOST_ROWS, _MOST_EXPERIMENTS = 6, 5


def diagnosis_html(diagnosis: Diagnosis, svgs: Mapping[str, str]) -> str:
    """Return the report of a diagnosis as an HTML file, with its figures as SVG elements by name."""
    return render("diagnosis.html", _content(diagnosis, svgs))


def _content(diagnosis: Diagnosis, svgs: Mapping[str, str]) -> dict[str, Any]:
    from markupsafe import Markup

    record = diagnosis.record
    curves = _largest_gaps(diagnosis)[:_MOST_CURVES]
    figures = {name: Markup(svg) for name, svg in svgs.items()}  # drawn here, and names in it escaped
    group, causes = record["group"], cause_rows(record, _MOST_ROWS)
    experiments = next_rows(record, _MOST_EXPERIMENTS)
    separates = experiments.common(1)
    return {
        "campaign": diagnosis.campaign,
        "verdict": diagnosis.verdict,
        "label": "One of several causes" if len(group) > 1 else _LABELS[diagnosis.verdict],
        "sentence": record["sentence"],
        "numbers": _numbers(record),
        "held_out": record["gap"].get("held_out") if diagnosis.verdict != "no_gap" else "",
        "figures": {name: figures.get(name) for name in _FIGURES},
        "where": where_rows(record, _MOST_ROWS),
        "causes": causes if any(row[-1] for row in causes.rows) else causes.without(len(causes.headings) - 1),
        "group": [in_words(names) for names in group],
        "meanings": group_items(record),
        "curves": [figures[name] for name in curves],
        "unknowns": unknown_rows(record),
        "alike": alike_rows(diagnosis.similarity),
        "absorbed": ", ".join(in_words([name]) for name in absorbed_names(diagnosis.similarity)),
        "experiments": experiments.without(1) if separates else experiments,
        "separates": separates,
        "detectable": detectable_items(record, diagnosis.similarity),
        "inputs": input_rows(record),
    }


def _numbers(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    found = list(gap_numbers(record).items())
    if "hypotheses_tried" in record:
        found.append(("hypotheses compared", str(record["hypotheses_tried"])))
    return found


def _largest_gaps(diagnosis: Diagnosis) -> list[str]:
    """Return the names of the figures before and after, the configuration with the largest gap first."""
    named = zip(curve_names(diagnosis), diagnosis.curves, strict=True)
    sized = [(unexplained(curves), name) for name, curves in named if len(curves.frequency)]
    return [name for _, name in sorted(sized, key=lambda pair: -pair[0])]
