"""Entries of ``diagnosis.json`` on places: where the cause acts, and the law that it follows there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from scipy.special import ndtri

from multilayer.arrays import RealArray
from multilayer.diagnosis.causality import is_causal, is_passive
from multilayer.diagnosis.cross_validation import Shrinkage
from multilayer.diagnosis.entries import gap_in_fit
from multilayer.diagnosis.evidence import ModelComparison
from multilayer.diagnosis.place_fits import PlaceFit, SimpleForm
from multilayer.diagnosis.places import BasePlace
from multilayer.diagnosis.thresholds import FORM_AS_WELL, RIGHT_PLACE, TIED
from multilayer.experiments.places import Term
from multilayer.inference.priors import Parameter
from multilayer.number_text import with_interval

_PROBABILITY = 0.9  # of intervals


@dataclass(frozen=True)
class DrawnPlace:
    """The place of a cause with its law.

    Attributes
    ----------
    free : PlaceFit
    form : SimpleForm
    shrinkage : Shrinkage
        Of the gap on held-out data, with the free law as it was compared; `free` has it as it is told.
    objection : str
        Why that law does not explain the gap (`decision.objection_to_law`); empty where it does.
    """

    free: PlaceFit
    form: SimpleForm
    shrinkage: Shrinkage
    objection: str = ""


def place_entries(
    comparison: ModelComparison, shares: Mapping[tuple[str, ...], float], drawn: DrawnPlace | None
) -> list[dict[str, Any]]:
    """Return the entries of ``places``, the most probable first; `behind` is in nats of free laws.

    Places that are `tied` are a group: the data cannot tell them apart. `shares` are the probabilities of all causes
    as the verdict tells them. Where the law drawn at the best place does not explain the gap, something unknown may as
    well act elsewhere: the probabilities add up to less than 1.
    """
    probabilities = comparison.place_probabilities(shares, RIGHT_PLACE if drawn and drawn.objection else 1.0)
    best = max((fit.log_evidence for fit in comparison.places.values()), default=0.0)
    entries = []
    for label, probability in probabilities.items():
        fit = comparison.places[label]
        entries.append(
            {
                "place": fit.place.name,
                **({"variant": fit.place.variant} if fit.place.variant else {}),
                **({"configuration": configuration} if (configuration := fit.place.configuration) else {}),
                "title": fit.place.title,
                "probability": round(probability, 4),
                "log_evidence": round(fit.log_evidence, 2),
                "behind": round(best - fit.log_evidence, 2),
                "tied": best - fit.log_evidence < TIED,
                "gap_after": gap_in_fit(fit.explanation),
                "shrinkage": round(drawn.shrinkage.share, 4) if drawn and drawn.free.place is fit.place else None,
            }
        )
    first = drawn.free.place.name if drawn else ""
    return sorted(entries, key=lambda entry: (entry["place"] != first, -entry["probability"], entry["behind"]))


def law_entry(drawn: DrawnPlace) -> dict[str, Any]:
    """Return the entry ``law``: the law drawn at the place, with its 90 % band, and the simple form nearest to it."""
    fit, place = drawn.free, drawn.free.place
    law, (low, high) = fit.law(), fit.band()
    imaginary = {"imag": law.imag.tolist(), "imag_low": low.imag.tolist(), "imag_high": high.imag.tolist()}
    return {
        "kind": place.kind,
        "place": place.name,
        **place.entry,
        **({"modelled": place.modelled} if place.modelled else {}),
        "quantity": place.quantity,
        "unit": place.unit,
        "correlation_length": fit.drawn.length,
        "frequency_hz": fit.grid.tolist(),
        "real": law.real.tolist(), "real_low": low.real.tolist(), "real_high": high.real.tolist(),
        **({} if place.is_real else imaginary),
        "passive": is_passive(fit),
        "causal": is_causal(fit),
        "form": form_entry(drawn.form, fit.grid),
        "objection": drawn.objection,
        "form_is_enough": drawn.form.log_evidence > fit.log_evidence - FORM_AS_WELL,
    }  # fmt: skip


def form_entry(form: SimpleForm, frequency: RealArray) -> dict[str, Any]:
    """Return a simple form: its terms with values and 90 % intervals, and its curve at frequencies, Hz."""
    law, parts, position = form.form, [], 0
    spreads = form.covariance(frequency).diagonal() ** 0.5
    for term in law.terms:
        count = term.count
        named, unit, factor = _told(law.at_place, term, law.centre)
        parameters = law.parameters[position : position + count]
        z = form.fitted.minimum.z[-len(law.parameters) :]
        intervals = [_interval(parameter, z[i], spreads[i]) for i, parameter in enumerate(parameters, position)]
        entry: dict[str, Any] = {"term": named, "kind": term.kind, "order": term.order, "parameters": {}}
        for name, (value, low, high), parameter in zip(_keys(parameters), intervals, parameters, strict=True):
            entry["parameters"][name] = {"value": value, "low": low, "high": high, "unit": parameter.unit}
            if name == "amplitude":
                ends = sorted((factor * low, factor * high))
                entry |= {"value": factor * value, "low": ends[0], "high": ends[1], "unit": unit}
            elif (
                term.kind == "lossy" and law.at_place.passive_sign < 0
            ):  # a loss factor is positive where power is lost
                entry[name] = {"value": -value, "low": -high, "high": -low, "unit": parameter.unit}
            else:
                entry[name] = {"value": value, "low": low, "high": high, "unit": parameter.unit}
        parts.append(entry)
        position += count
    words = ", and ".join(map(_in_words, parts))
    curve = law.curve(form.fitted.minimum.z[-position:], frequency)
    return {
        "text": law.at_place.in_words(words),
        **({"beyond": words} if law.at_place.tells_more else {}),
        "centre_hz": law.centre,
        "terms": parts,
        "log_evidence": round(form.log_evidence, 2),
        "real": curve.real.tolist(),
        **({} if law.at_place.is_real else {"imag": curve.imag.tolist()}),
    }


def _told(place: BasePlace, term: Term, centre: float) -> tuple[str, str, float]:
    """Return what a term is called at a place, its unit, and its value over the amplitude at the centre, Hz."""
    order = 0 if place.is_real else term.order
    factor = (2 * math.pi * centre) ** -order
    named, unit = place.terms.get(term.key, (place.quantity, place.unit))
    if term.kind in ("power", "resonance") and term.key in place.terms:
        # in Hz a corner frequency fc is told, that of 1/(1 - i fc/f): about 1 - fc/(i f)
        return named, unit, -centre if unit == "Hz" else factor
    if term != Term("power"):
        named = f"{named} {term.real_words(centre) if place.is_real else term.words}"
    return named, _times_seconds(unit, order), factor


def _times_seconds(unit: str, power: int) -> str:
    """Return a unit times seconds to a power."""
    if not power:
        return unit
    over, _, under = (part.strip("()") for part in unit.partition("/"))
    seconds = "s" if abs(power) == 1 else f"s{abs(power)}"
    if power > 0:
        over = f"{over} {seconds}".removeprefix("1 ").strip()
    else:
        over, under = over or "1", f"({under} {seconds})" if under else seconds
    return f"{over}/{under}" if under else over


def _in_words(entry: Mapping[str, Any]) -> str:
    """Return a term for people, as ``a mass of 0.99 (0.96 to 1.02) g``."""
    article = "an" if entry["term"].startswith(("a", "e", "i", "o", "u", "ln")) else "a"
    text = f"{article} {entry['term']} of {_size(entry)}"
    named = {key: value for key, value in entry.items() if isinstance(value, Mapping) and key != "parameters"}
    others = [f"{key.replace('_', ' ')} {_size(value)}" for key, value in named.items()]
    return f"{text}, {', '.join(others)}" if others else text


def _size(entry: Mapping[str, Any]) -> str:
    return with_interval(entry["value"], entry["low"], entry["high"], entry["unit"])


def _keys(parameters: Sequence[Parameter]) -> list[str]:
    return [parameter.name.partition(".")[2] for parameter in parameters]


def _interval(parameter: Parameter, z: float, spread: float) -> tuple[float, float, float]:
    """Return value and ends of the 90 % interval of a parameter whose coordinate has a standard deviation."""
    reach = float(ndtri(0.5 + _PROBABILITY / 2)) * spread
    value, low, high = (float(parameter.prior.value(z + step)) for step in (0.0, -reach, reach))
    return value, low, high
