"""What a diagnosis says, row by row, in words and rounded numbers: the same for the terminal and for the report."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

from multilayer.diagnosis.effects.base import EFFECTS
from multilayer.diagnosis.result import Similarity
from multilayer.diagnosis.thresholds import ABSORBED, ALIKE
from multilayer.errors import MultilayerError
from multilayer.report.listing import Listing, flat_items
from multilayer.report.numbers import percent, pressure_unit, readable_unit, significant, with_interval, with_unit

Record = Mapping[str, Any]
_ABSURD = 1e9  # in SI units: an effect that must be that large cannot be seen at all
_UNSEEN = "not visible at any size"


def in_words(effects: Sequence[str]) -> str:
    """Return the names of a hypothesis for people: none is the nominal model."""
    if list(effects) == ["unknown"]:
        return "none of the known"
    return " + ".join(name.replace("_", " ") for name in effects) or "no effect"


def band_text(band: Sequence[float] | None) -> str:
    """Return a band of frequencies."""
    return "all" if band is None else f"{band[0]:.0f} to {band[1]:.0f} Hz"


def where_rows(record: Record, most: int | None = None) -> Listing:
    """Return where the gap lies, the most significant place first."""
    places = sorted(record["where"], key=lambda place: -abs(place["significance"]))[:most]
    rows = [
        (
            place.get("configuration") or "all",
            place["quantity"],
            band_text(place.get("band_hz")),
            f"{place['significance']:.1f} σ",
            place.get("note", ""),
        )
        for place in places
    ]
    return Listing(("configuration", "quantity", "band", "significance", "remark"), tuple(rows), (3,))


def best_score(record: Record) -> float:
    """Return the largest score of all causes: evidence, how common the cause is, and held-out data."""
    return max((float(cause["score"]) for cause in record["causes"]), default=math.nan)


def number_or_nan(value: Any) -> float:
    """Return a number, not a number where there is none."""
    return math.nan if value is None else float(value)


def cause_rows(record: Record, most: int | None = None) -> Listing:
    """Return the causes, most probable first, with the sizes of their parameters (90 % intervals)."""
    best, causes = best_score(record), record["causes"][:most]
    rows = [
        (
            in_words(cause["effects"]),
            percent(number_or_nan(cause.get("probability"))),
            f"{(behind := best - cause['score']):.{1 if behind < 100 else 0}f}",
            significant(number_or_nan(cause.get("gap_after"))),
            percent(number_or_nan(cause.get("shrinkage"))),
            sizes(cause.get("parameters", {}), several=len(cause["effects"]) > 1),
            _remark(record, cause),
        )
        for cause in causes
    ]
    headings = ("cause", "probability", "nats behind", "gap in fit", "shrinkage", "size (90 % interval)", "remark")
    return Listing(headings, tuple(rows), (1, 2, 3, 4))


def sizes(parameters: Mapping[str, Mapping[str, Any]], *, several: bool = False) -> str:
    """Return values and intervals of parameters; with the names of their effects where there are several."""
    found = []
    for name, one in parameters.items():
        shown = name if several else name.rpartition(".")[2]
        found.append(f"{shown.replace('.', ' ').replace('_', ' ')} {_value(one)}")
    return "; ".join(found)


def _value(parameter: Mapping[str, Any]) -> str:
    value, low, high = (number_or_nan(parameter.get(key)) for key in ("value", "low", "high"))
    return with_interval(value, low, high, parameter.get("unit", ""))


def _remark(record: Record, cause: Mapping[str, Any]) -> str:
    found = []
    if len(record["group"]) > 1 and cause["effects"] in record["group"]:
        found.append("not told apart")
    if cause.get("absorbed"):
        found.append("absorbed by the unknowns")
    return "; ".join(found)


def group_items(record: Record) -> list[tuple[str, str]]:
    """Return what each hypothesis means that the verdict names: the laws of its effects and what would tell them."""
    names = dict.fromkeys(name for effects in record["group"] for name in effects)
    return [(in_words([name]), text) for name in names if (text := _about(name))]


def _about(name: str) -> str:
    """Return an effect's law in a line; nothing for what is not registered here."""
    try:
        effect = EFFECTS[name]
    except MultilayerError:  # unknown here, or a plugin that no longer loads
        return ""
    return f"{effect.law}; separated by {effect.separated_by}"


def gap_numbers(record: Record) -> dict[str, str]:
    """Return the gap before and after, and by how much it shrinks, by what they are called."""
    gap = record["gap"]
    found = {"gap of the nominal model": significant(number_or_nan(gap.get("before")))}
    if record["verdict"] == "no_gap":
        return found
    best = "known effect" if record["verdict"] == "unknown" else "hypothesis"
    found[f"gap with the best {best}"] = significant(number_or_nan(gap.get("after")))
    found["shrinkage"] = percent(number_or_nan(gap.get("shrinkage")))
    return found


def unknown_rows(record: Record) -> Listing:
    """Return the unknowns of the nominal model, and as corrected if they were; pairs are real and imaginary part."""
    rows = []
    for name, one in record["unknowns"].items():
        before, after = (_parts(one[key]) for key in ("nominal", "corrected"))
        labels = (name,) if len(before) == 1 else (f"Re {name}", f"Im {name}")
        rows += [_unknown(*values, one.get("unit", "")) for values in zip(labels, before, after, strict=True)]
    headings = ("unknown", "nominal", "corrected", "change")
    kept = 4 if any(row[1] != row[2] for row in rows) else 2
    return Listing(headings[:kept], tuple(row[:kept] for row in rows), (1, 2, 3))


def _unknown(label: str, before: float, after: float, unit: str) -> tuple[str, ...]:
    shown, factor = _common_unit((before, after), unit)
    texts = [f"{significant(value / factor)} {shown}" for value in (before, after)]
    return label, *texts, f"{100 * (after / before - 1):+.1f} %" if before else "–"


def _parts(value: Any) -> tuple[float, ...]:
    return tuple(map(float, value)) if isinstance(value, Sequence) else (float(value),)


def _common_unit(values: Sequence[float], unit: str) -> tuple[str, float]:
    largest = max(map(abs, values))
    return pressure_unit(largest) if unit == "Pa" else readable_unit(largest, unit)


def next_rows(record: Record, most: int | None = None) -> Listing:
    """Return the experiments that would separate what is still alive, the best for its cost first."""
    rows = [
        (
            entry["change"].replace("_", " "),
            " from ".join(in_words(names) for names in entry["separates"]),
            f"{entry['expected_gain']:.1f} nats",
            f"{entry['cost_hours']:g} h" if "cost_hours" in entry else "–",
        )
        for entry in record["next_experiment"][:most]
    ]
    return Listing(("change", "separates", "expected gain", "cost"), tuple(rows), (2, 3))


def detectable_items(record: Record, similarity: Similarity) -> list[tuple[str, str]]:
    """Return from what size on each effect would have been seen."""
    absorbed = set(absorbed_names(similarity))
    found = []
    for name, one in sorted(record["detectable"].items()):
        smallest = number_or_nan(one.get("smallest"))
        if not abs(smallest) < _ABSURD:
            text = _UNSEEN
        else:
            text = f"{one['parameter'].replace('_', ' ')} from {with_unit(smallest, one.get('unit', ''), 2)}"
        found.append((in_words([name]), f"{text}, largely hidden by the unknowns" if name in absorbed else text))
    return found


def absorbed_names(similarity: Similarity) -> list[str]:
    """Return the effects that the unknowns absorb."""
    return [name for name, share in zip(similarity.names, similarity.kept, strict=True) if share < ABSORBED]


def alike_rows(similarity: Similarity) -> Listing:
    """Return the pairs of effects whose signatures are one, the most alike first."""
    pairs = [
        (abs(float(similarity.cosines[i, j])), similarity.names[i], similarity.names[j])
        for i, j in combinations(range(len(similarity.names)), 2)
        if abs(similarity.cosines[i, j]) > ALIKE
    ]
    rows = [(in_words([a]), in_words([b]), f"{cosine:.3f}") for cosine, a, b in sorted(pairs, reverse=True)]
    return Listing(("effect", "looks like", "|cosine|"), tuple(rows), (2,))


def input_rows(record: Record) -> list[tuple[str, str]]:
    """Return what the diagnosis was made from, flat."""
    return flat_items(record.get("inputs", {}))
