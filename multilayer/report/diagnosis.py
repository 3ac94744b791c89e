"""The report of a diagnosis: the verdict, then where the gap lies, what causes it, and what to measure next."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations
from pathlib import Path
from shlex import quote
from typing import Any

from multilayer.csv_table import csv_table
from multilayer.diagnosis.effects.base import EFFECTS
from multilayer.diagnosis.result import Curves, Diagnosis, Similarity
from multilayer.diagnosis.thresholds import ABSORBED, ALIKE
from multilayer.errors import MultilayerError
from multilayer.number_text import percent, pressure_unit, readable_unit, significant, with_interval, with_unit
from multilayer.report import diagnosis_figures as figures
from multilayer.report.diagnosis_figures import in_words, number_or_nan
from multilayer.report.files import file_names
from multilayer.report.listing import Listing
from multilayer.report.place_figures import draw_place
from multilayer.report.report import Draw, Pairs, Picture, Report, Section

Record = Mapping[str, Any]
_ABSURD = 1e9  # in SI units: an effect that must be that large cannot be seen at all
_MOST_ROWS, _MOST_EXPERIMENTS = 6, 5
_OFF = 3.0  # standard deviations of a stated quantity that are told
_PLUGIN = "multilayer plugins new NAME --kind effect"
_SURE = 100.0  # nats: odds that nobody doubts


def diagnosis_report(diagnosis: Diagnosis, source: Path | None = None, folder: Path | None = None) -> Report:
    """Return the report of a diagnosis.

    Parameters
    ----------
    diagnosis : Diagnosis
    source, folder : Path, optional
        What was diagnosed, and where the files of the report go: for the commands to type next.
    """
    record, verdict = diagnosis.record, diagnosis.verdict
    several = len(record["group"]) > 1
    label = {"effect": "Cause found", "unknown": "Cause unknown", "no_gap": "No gap"}[verdict]
    gap = _gap(record)
    held_out = record["gap"].get("held_out", "") if verdict != "no_gap" else ""
    numbers = "; ".join(f"{name} {value}" for name, value in gap)
    noise = f"noise alone: {significant(number_or_nan(record['gap'].get('noise', 1.0)))}"
    meaning = (
        "The gap is the mean square of measured minus modelled over its variance, stated quantities included; the "
        "misfit is that of the data that were fitted; shrinkage is of what a gap has beyond noise"
    )
    drawn = _drawings(diagnosis)
    tried = [("hypotheses compared", str(record["hypotheses_tried"]))] if "hypotheses_tried" in record else []
    unused = f" Before and after are taken on data that were not used in the fit ({held_out})."
    in_fit = not held_out or held_out.startswith("nothing")
    return Report(
        name=diagnosis.campaign,
        kind="diagnosis",
        label="One of several causes" if several and verdict == "effect" else label,
        tone={"effect": "mind", "unknown": "unknown", "no_gap": "good"}[verdict],
        sentence=record["sentence"],
        facts=(*gap, *tried),
        note=f"{meaning}; {noise}.{'' if in_fit else unused}",
        sections=(*_sections(diagnosis, drawn), *_commands(diagnosis, source, folder)),
        inputs=record.get("inputs", {}),
        opening=(
            f"{diagnosis.campaign}: {record['sentence']}",
            f"{numbers} ({noise}{f'; {held_out}' if held_out else ''})",
        ),
        record=record,
        record_file="diagnosis.json",
        warnings=tuple(record.get("warnings", ())),
        tables={"moduli.csv": _moduli_csv(diagnosis.moduli)} if diagnosis.moduli else {},
        page="report.html",
        figures={f"{name}.png": draw for name, draw in drawn.items()},
    )


def _moduli_csv(moduli: Mapping[str, Any]) -> str:
    """Return the moduli over frequency with their 90 % intervals, Pa."""
    kinds = [(f"{name}_{key}_pa", values) for name in ("nominal", "corrected") for key, values in moduli[name].items()]
    columns = [("frequency_hz", moduli["frequency_hz"]), *kinds]
    names, values = zip(*columns, strict=True)
    return csv_table(names, zip(*values, strict=True), digits=6)


def _commands(diagnosis: Diagnosis, source: Path | None, folder: Path | None) -> tuple[Section, ...]:
    """Return the commands to type next."""
    record = diagnosis.record
    if source is None or folder is None or not diagnosis.moduli:
        return ()
    campaign, found = quote(str(source)), quote(str(folder / "diagnosis.json"))
    both, wrong = record.get("two_causes"), record.get("wrong_statement")
    law = record.get("law")
    # not of two unknown laws at once, nor of one that explains nothing
    is_saved = both["effects"] if both else law and not law.get("objection") and not wrong
    if record["verdict"] == "no_gap":
        before = "uncertainties stated, " if any("not stated" in text for text in record.get("warnings", ())) else ""
        what = f"{before}one modulus law for all bursts: the model explains them"
        lines = [f"multilayer fit {campaign} --joint   # {what}"]
    elif record["verdict"] == "effect" or is_saved:
        acts = "the cause" if record["verdict"] == "effect" else "the law drawn at its place"
        lines = [
            f"multilayer fit {campaign} --with {found}   # the modulus with {acts} in the model",
            f"multilayer diagnose {campaign} --with {found}   # what is left beyond it",
            f"multilayer diagnose {campaign} --save-law rig.yaml   # to apply it to later campaigns of this rig",
        ]
    elif wrong:
        names = " or ".join([wrong["name"], *wrong["tied"]])
        lines = [f"multilayer diagnose {campaign}   # once {names} is measured again and corrected there"]
    else:
        lines = [f"multilayer effects   # what is known to act; a plugin may add what acts here: {_PLUGIN}"]
    if record["verdict"] != "no_gap":
        lines.append(f"multilayer explore {campaign}   # data and model, effects turned by hand")
    return (Section("What to type next", remarks=tuple(lines)),)


def _drawings(diagnosis: Diagnosis) -> dict[str, Draw]:
    """Return what draws the figures, by name; those without data are left out."""
    record, similarity, moduli = diagnosis.record, diagnosis.similarity, diagnosis.moduli
    drawn: dict[str, tuple[bool, Draw]] = {
        "where": (bool(figures.places_in_bands(record)), partial(figures.draw_where, record)),
        "place": (record.get("law") is not None, partial(draw_place, record.get("law") or {})),
        "causes": (bool(record["causes"]), partial(figures.draw_causes, record)),
        **{name: (True, partial(figures.draw_before_after, part)) for name, part in _curves(diagnosis).items()},
        "similarity": (len(similarity.names) > 1, partial(figures.draw_similarity, similarity)),
        "next_experiment": (bool(record["next_experiment"]), partial(figures.draw_experiments, record)),
        "moduli": (bool(moduli.get("frequency_hz")), partial(figures.draw_moduli, moduli)),
    }
    return {name: draw for name, (there, draw) in drawn.items() if there}


def _curves(diagnosis: Diagnosis) -> dict[str, Curves]:
    """Return the residuals of configurations that have any, by the names of their figures."""
    names = file_names([curves.configuration for curves in diagnosis.curves])
    parts = zip(names, diagnosis.curves, strict=True)
    return {f"before_after-{name}": curves for name, curves in parts if curves.frequency.size}


def _sections(diagnosis: Diagnosis, drawn: Mapping[str, Draw]) -> tuple[Section, ...]:
    record, similarity, verdict = diagnosis.record, diagnosis.similarity, diagnosis.verdict

    def picture(name: str, caption: str = "") -> tuple[Picture, ...]:
        return (Picture(drawn[name], caption, name.replace("_", " ")),) if name in drawn else ()

    by_name = _curves(diagnosis)
    curves = sorted(by_name, key=lambda name: -figures.unexplained(by_name[name]))  # the largest gap first
    where = ", where the gap is largest" if len(curves) > 1 else ""
    largest = f"Measured minus modelled{where}; lines: means of bursts or bands."
    corrected = _corrected(diagnosis)
    others = sum(map(picture, curves[1:]), ())
    absorbed = ", ".join(in_words([name]) for name in _absorbed(similarity))
    alike = Section("", listings=(_alike(similarity),), empty="No two effects look alike in these data.")
    return (
        Section(
            "Where the gap lies",
            picture("where", "The most significant places of measured minus modelled."),
            beside=Section("", listings=(_where(record),)),
            empty="Nowhere: no band, channel or configuration differs from the model by more than chance allows.",
        ),
        *_places(record, picture("place", _law_caption(record))),
        Section(
            "Which effect causes it",
            picture("causes", "Ranked causes; each is fitted with all unknowns."),
            (_causes(record),),
            beside=Section("", remarks=(_named(record),), items=_meanings(record)) if record["causes"] else None,
            empty="No cause is named where there is no gap.",
        ),
        Section(
            "What is left" if verdict == "no_gap" else "How far it shrinks",
            (
                *sum((picture(name, largest) for name in curves[:1]), ()),
                *picture("moduli", f"The modulus of the nominal model{corrected}."),
            ),
            (_unknowns(record), *_stated(record)),
            folded=Section("Measured minus modelled, the other configurations", others) if others else None,
            empty="There are no residuals to draw.",
        ),
        Section(
            "What it could be confounded with",
            picture("similarity", "How alike the effects look in these data."),
            beside=alike if "similarity" in drawn else None,
            remarks=(f"Hidden in these data, absorbed by the unknowns: {absorbed}",) if absorbed else (),
            empty="Fewer than two effects were considered: nothing can be confounded.",
        ),
        _next(record, picture("next_experiment", "What each change is expected to tell.")),
        Section(
            "What could have been seen, and from what size on",
            items=_detectable(record, similarity),
            empty="No effect with a size was considered.",
        ),
    )


def _corrected(diagnosis: Diagnosis) -> str:
    """Return what the figure of the modulus shows beside the nominal model."""
    if not diagnosis.moduli or diagnosis.moduli["corrected"] == diagnosis.moduli["nominal"]:
        return ""
    if not all(map(math.isfinite, diagnosis.moduli["corrected"]["E1"])):
        return "; nothing explains the gap, so the modulus is not known beyond it"
    return ", and as corrected" if diagnosis.verdict == "effect" else ", and as corrected by what explains the gap best"


def _gap(record: Record) -> list[tuple[str, str]]:
    """Return the gap before and after, and by how much it shrinks, by what they are called."""
    before, after, shrinkage = (number_or_nan(record["gap"].get(key)) for key in ("before", "after", "shrinkage"))
    nominal = ("gap of the nominal model", significant(before))
    if record["verdict"] == "no_gap" or math.isnan(after):
        return [nominal]
    is_known = record["verdict"] == "unknown" and not record.get("law")
    best = "known effect" if is_known else "explanation"
    return [nominal, (f"gap with the best {best}", significant(after)), ("shrinkage", percent(shrinkage))]


def _where(record: Record) -> Listing:
    """Return where the gap lies, the most significant place first."""
    columns: dict[str, Callable[[Record], str]] = {
        "configuration": lambda place: place.get("configuration") or "all",
        "quantity": lambda place: place["quantity"],
        "band": lambda place: "{:.0f} to {:.0f} Hz".format(*place["band_hz"]) if place.get("band_hz") else "all",
        ">significance": lambda place: f"{place['significance']:.1f} σ",
        "remark": lambda place: place.get("note", ""),
    }
    places = sorted(record["where"], key=lambda place: -abs(place["significance"]))
    return Listing.of(places[:_MOST_ROWS], columns)


def _places(record: Record, pictures: tuple[Picture, ...]) -> tuple[Section, ...]:
    """Return where the cause acts on the rig; nothing where places are not told apart."""
    if not record.get("places"):
        return ()
    columns: dict[str, Callable[[Record], str]] = {
        "place": lambda place: place["place"] + (f" [{place['configuration']}]" if place.get("configuration") else ""),
        "that is": lambda place: place["title"],
        ">probability": lambda place: percent(number_or_nan(place["probability"])),
        ">law: nats behind": lambda place: significant(number_or_nan(place["behind"])),
        ">misfit": lambda place: significant(number_or_nan(place["gap_after"])),
        ">shrinkage": lambda place: percent(number_or_nan(place["shrinkage"])),
    }
    listing = Listing.of(record["places"][:_MOST_ROWS], columns, marked=[0])
    law = record.get("law")
    remarks = (f"The law drawn there looks like {law['form']['text']}.",) if law else ()
    if law and not law["form_is_enough"]:
        nearest = law["form"].get("beyond", law["form"]["text"])  # the sentence tells what is modelled
        remarks = (f"No simple form does as well as the law drawn there; the nearest is {nearest}.",)
    if law and record.get("wrong_statement") and record["verdict"] == "unknown":
        remarks = ("This is how a free law takes up what is stated wrongly (above).", *remarks)
    elif law and law.get("objection"):
        elsewhere = "What is unknown may as well act elsewhere: the probabilities of places add up to less than 100 %."
        remarks = (f"It does not explain the gap: it {law['objection']}. {elsewhere}", *remarks)
    if law:
        remarks = (*remarks, *_differences(law), *_physical(law))
    titles = {"tube": "Where in the tube it acts", "levels": "Where it acts: construction, field or reading"}
    of_tube = "campaign" not in record.get("inputs", {"campaign": ""})
    kind = record["inputs"].get("kind", "tube") if of_tube else "two-plate rig"
    title = titles.get(kind, "Where on the rig it acts")
    return (Section(title, pictures, (listing,), remarks=remarks),)


def _physical(law: Record) -> tuple[str, ...]:
    """Return in sentences whether the law can be that of a passive and causal thing."""
    texts: dict[tuple[str, Any], str] = {
        ("passive", True): "A passive thing may act like this: within its uncertainty the law nowhere gives power.",
        ("passive", False): "It gives power, which no passive thing there does by itself: what acts may replace "
        "something that takes more, act elsewhere, or be driven.",
        ("causal", False): "No causal response has this real and imaginary part: it may be the trace of something at "
        "another place.",
    }
    found = [texts.get((key, law.get(key)), "") for key in ("passive", "causal")]
    return tuple(text for text in found if text)


def _law_caption(record: Record) -> str:
    law = record.get("law")
    return f"The place, and the law drawn there: {law['quantity']}." if law else ""


def _differences(law: Record) -> tuple[str, ...]:
    """Return in sentences how the law differs from configuration to configuration."""
    moved = ", ".join(f"{name} {100 * (factor - 1):+.0f} %" for name, factor in law.get("moved", {}).items())
    factors = ", ".join(f"{name} {factor:.2g}" for name, factor in law.get("factors", {}).items())
    texts = {"frequencies": moved, "factors": factors}
    return tuple(f"Its {what} in the configurations: {text}." for what, text in texts.items() if text)


def _causes(record: Record) -> Listing:
    """Return the causes, most probable first, with the sizes of their parameters (90 % intervals).

    What none of the known effects causes is always among them, and so is what the others come to: the probabilities add
    up to 1. That of an unknown cause is no matter of evidence alone, so that it is behind nothing.
    """
    best = figures.best_score(record)

    def behind(cause: Record) -> str:
        if "counted_with" in cause or cause["effects"] == ["unknown"]:
            return "–"
        nats = best - cause["score"]
        return f"{nats:.{1 if nats < 100 else 0}f}"

    def probability(cause: Record) -> str:
        return "–" if "counted_with" in cause else percent(number_or_nan(cause.get("probability")))

    columns: dict[str, Callable[[Record], str]] = {
        "cause": lambda cause: in_words(cause["effects"]),
        ">probability": probability,
        ">nats behind": behind,
        ">misfit": lambda cause: significant(number_or_nan(cause.get("gap_after"))),
        ">shrinkage": lambda cause: percent(number_or_nan(cause.get("shrinkage"))),
        "size (90 % interval)": lambda cause: _sizes(cause.get("parameters", {}), several=len(cause["effects"]) > 1),
        "remark": lambda cause: _remark(record, cause),
    }
    causes = record["causes"]
    shown = [c for i, c in enumerate(causes) if i < _MOST_ROWS or c["effects"] == ["unknown"]]
    marked = [i for i, cause in enumerate(shown) if cause["effects"] in record["group"]]
    listing = Listing.of(shown, columns, marked=marked)
    if not causes:
        return listing
    rest = 1 - sum(number_or_nan(cause["probability"]) for cause in shown)
    others = ("all others", percent(max(rest, 0.0)), *[""] * (len(columns) - 2))
    return replace(listing, rows=(*listing.rows, others))


def _sizes(parameters: Mapping[str, Mapping[str, Any]], *, several: bool) -> str:
    """Return values and intervals of parameters; with the names of their effects where there are several."""
    texts = []
    for name, parameter in parameters.items():
        named, bracket, where = name.partition("[")  # a configuration's name is told as it is
        effect, _, quantity = named.partition(".")
        shown = (f"{effect} {quantity}" if several else quantity).replace("_", " ") + bracket + where
        value, low, high = (number_or_nan(parameter.get(key)) for key in ("value", "low", "high"))
        texts.append(f"{shown} {with_interval(value, low, high, parameter.get('unit', ''))}")
    return "; ".join(texts)


def _remark(record: Record, cause: Record) -> str:
    tied = len(record["group"]) > 1 and cause["effects"] in record["group"]
    counted = f"counts with {in_words(cause['counted_with'])}" if "counted_with" in cause else ""
    texts = ("not told apart" if tied else "", counted, "absorbed by the unknowns" if cause.get("absorbed") else "")
    return "; ".join(filter(None, texts))


def _named(record: Record) -> str:
    group = "; ".join("an unknown cause" if one == ["unknown"] else in_words(one) for one in record["group"])
    if not group:
        return "None of the hypotheses is named as the cause: see the sentence at the top."
    return f"{'The data cannot tell these apart' if len(record['group']) > 1 else 'Named'}: {group}."


def _meanings(record: Record) -> Pairs:
    """Return what each hypothesis means that the verdict names: the laws of its effects and what would tell them."""
    names = dict.fromkeys(name for effects in record["group"] for name in effects)
    return tuple((in_words([name]), text) for name in names if (text := _about(name)))


def _about(name: str) -> str:
    """Return an effect's law in a line; nothing for what is not registered here."""
    try:
        effect = EFFECTS[name]
    except MultilayerError:  # unknown here, or a plugin that no longer loads
        return ""
    return f"{effect.law}; separated by {effect.separated_by}"


def _unknowns(record: Record) -> Listing:
    """Return the unknowns of the nominal model, and as corrected if they were; pairs are real and imaginary part."""
    rows = []
    for name, values in record["unknowns"].items():
        before, after = (_parts(values[key]) for key in ("nominal", "corrected"))
        labels = (name,) if len(before) == 1 else (f"Re {name}", f"Im {name}")
        rows += [_unknown(*pair, values.get("unit", "")) for pair in zip(labels, before, after, strict=True)]
    headings = ("unknown", "nominal", "corrected", "change")
    kept = 4 if any(row[1] != row[2] for row in rows) else 2
    return Listing(headings[:kept], tuple(row[:kept] for row in rows), (1, 2, 3), "Unknowns")


def _stated(record: Record) -> tuple[Listing, ...]:
    """Return the stated quantities that are taken to be off, farthest first; nothing where chance moves them as far."""
    off = {name: (d["nominal"], d["corrected"]) for name, d in record.get("stated_deviations", {}).items()}
    far = sorted((name for name in off if max(map(abs, off[name])) > _OFF), key=lambda name: -max(map(abs, off[name])))
    headings = ("stated quantity", "nominal", "corrected")
    rows = tuple((name, *(f"{z:+.1f} σ" for z in off[name])) for name in far[:_MOST_ROWS])
    caption = "What is stated of the laboratory, by how many of its standard deviations it is taken to be off"
    return (Listing(headings, rows, (1, 2), caption),) if rows else ()


def _unknown(label: str, before: float, after: float, unit: str) -> tuple[str, ...]:
    largest = max(abs(before), abs(after))
    shown, factor = pressure_unit(largest) if unit == "Pa" else readable_unit(largest, unit)
    texts = [f"{significant(value / factor)} {shown}" for value in (before, after)]
    return label, *texts, f"{100 * (after / before - 1):+.1f} %" if before else "–"


def _parts(value: Any) -> tuple[float, ...]:
    return tuple(map(float, value)) if isinstance(value, Sequence) else (float(value),)


def _absorbed(similarity: Similarity) -> list[str]:
    """Return the effects that the unknowns absorb."""
    return [name for name, share in zip(similarity.names, similarity.kept, strict=True) if share < ABSORBED]


def _alike(similarity: Similarity) -> Listing:
    """Return the pairs of effects whose signatures are one, the most alike first."""
    names, cosines = similarity.names, abs(similarity.cosines)
    pairs = [
        (cosines[i, j], names[i], names[j]) for i, j in combinations(range(len(names)), 2) if cosines[i, j] > ALIKE
    ]
    rows = tuple((in_words([a]), in_words([b]), f"{cosine:.3f}") for cosine, a, b in sorted(pairs, reverse=True))
    caption = "Pairs that these data cannot tell apart"
    return Listing(("effect", "looks like", "|cosine|"), rows, (2,), caption, only="page")


def _next(record: Record, picture: tuple[Picture, ...]) -> Section:
    """Return the experiments that would separate what is still alive, the best for its cost first."""
    title, entries = "What to measure next", record["next_experiment"][:_MOST_EXPERIMENTS]
    if not entries:
        told = "Nothing to measure next: no other known effect comes near to the first" if record["causes"] else ""
        empty = "Fewer than two hypotheses are alive: no experiment is needed to separate them."
        return Section(title, remarks=(told,) if told else (), empty=empty)
    columns: dict[str, Callable[[Record], str]] = {
        "change": lambda entry: entry["change"].replace("_", " "),
        "separates": lambda entry: " from ".join(in_words(names) for names in entry["separates"]),
        ">expected gain": _gain,
        ">cost": lambda entry: f"{entry['cost_hours']:g} h" if "cost_hours" in entry else "–",
    }
    listing = Listing.of(entries, columns)
    if separates := listing.common(1):
        listing = replace(listing.without(1), caption=f"{title}, to separate {separates}")
    return Section(title, picture, beside=Section("", listings=(listing,)))


def _gain(entry: Record) -> str:
    """Return the expected gain; beyond what is sure to tell, the number means nothing."""
    gain = number_or_nan(entry["expected_gain"])
    return f"{gain:.1f} nats" if gain < _SURE else f"above {_SURE:g} nats"


def _detectable(record: Record, similarity: Similarity) -> Pairs:
    """Return from what size on, or up to which, each effect would have been seen."""
    absorbed = set(_absorbed(similarity))
    items = []
    for name, effect in sorted(record["detectable"].items()):
        smallest = number_or_nan(effect.get("smallest"))
        text = "not visible at any size"
        if abs(smallest) < _ABSURD:
            size = with_unit(smallest, effect.get("unit", ""), 2)
            text = f"{effect['parameter'].replace('_', ' ')} {effect.get('shows', 'from')} {size}"
        items.append((in_words([name]), f"{text}, largely hidden by the unknowns" if name in absorbed else text))
    return tuple(items)
