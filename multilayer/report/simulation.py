"""The report of a simulation, and of a comparison of measured spectra with one."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.number_text import over_unit, with_unit
from multilayer.report.listing import Listing
from multilayer.report.report import Picture, Report, Section
from multilayer.report.simulation_figures import draw_losses, draw_quantity, draw_spread
from multilayer.response.bands import band_centres, bands_of
from multilayer.simulation.closest_values import ClosestValue
from multilayer.simulation.compare import Comparison, Misfit
from multilayer.simulation.quantities import QUANTITIES, Quantity, mean_of
from multilayer.simulation.result import CaseResult, SimulationResult
from multilayer.simulation.single_numbers import IMPACT

_DRAWN = {
    "absorption": "absorption.png",
    "transmission_loss": "transmission_loss.png",
    "insertion_loss": "insertion_loss.png",
    "normalised_impedance": "impedance.png",
    "sound_power_level": "sound_power_level.png",
    "impact_level": "impact_level.png",
    "radiation_efficiency": "radiation_efficiency.png",
    "input_mobility": "input_mobility.png",
    "bending_stiffness": "bending_stiffness.png",
    "loss_factor": "loss_factor.png",
    "phase_speed": "phase_speed.png",
    "duct_attenuation": "duct_attenuation.png",
}
# the last that there is, a simulation is made for
_LISTED = ("absorption", "transmission_loss", "insertion_loss", "duct_attenuation", "sound_power_level", "impact_level")
_MOST_COLUMNS = 6  # of cases beside each other; more of them stand below each other
_MOST_POINTS = 40  # frequencies listed as they are; more are averaged over third octaves
_MOST_PICTURES = 4
_CLOSER = 0.9  # of the rms difference, above which another value makes no difference worth telling
_RATED = re.compile(r"-?[0-9]+(\.[0-9]+)?")
Rows: TypeAlias = list[tuple[float, NDArray[np.intp]]]


def simulation_report(result: SimulationResult) -> Report:
    """Return the report of a simulation."""
    there = {name for case in result.cases for name in case.quantities}
    through = "transmission_loss" in there
    # what does not come back from a stack that lets sound through is not absorbed
    *others, main = [QUANTITIES[name] for name in _LISTED[through:] if name in there]
    cases = _with(result, main)
    rated = [case for case in result.cases if case.ratings]
    ratings = [", ".join(f"{name} {value}" for name, value in case.ratings.items()) for case in rated]
    notes = tuple(f"{case.label}: {text}" if case.label else text for case, text in zip(rated, ratings, strict=True))
    pictures = _pictures(result, [name for name in _DRAWN if name in there])
    figures = {file: partial(draw_quantity, result, name) for name, file in _DRAWN.items() if name in there}
    if any(case.layer_losses for case in result.cases):
        pictures += (Picture(partial(draw_losses, result, upright=True), "Share of the power that each layer loses."),)
        figures["layer_losses.png"] = partial(draw_losses, result)
    scatter = _scatter(result, main)
    if scatter:
        figures["scatter.png"] = partial(draw_spread, result, main.name)
    listings = [_values(result, quantity, only="console") for quantity in others]
    means = [_mean(case, main) for case in cases]
    ranked = _ranked(cases, main)
    return Report(
        name=result.name,
        kind="simulation",
        label="Simulation",
        sentence=_rating_sentence(ranked) or _sentence(result, main, cases, means),
        facts=(
            (result.bands or "frequencies", str(len(result.frequency))),
            ("cases", str(len(result.cases))),
            *(_tiles(ranked) or [(f"largest mean {main.title}", _shown(max(means), main))]),
        ),
        note=_note(result),
        sections=(
            Section("Over frequency", pictures),
            Section("Values", listings=(*listings, _values(result, main, notes=notes))),
            *scatter,
        ),
        inputs=result.settings,
        tables={"simulation.csv": result.to_csv()},
        record=result.to_dict(),
        record_file="simulation.json",
        page="report.html",
        figures=figures,
    )


def comparison_report(comparison: Comparison) -> Report:
    """Return the report of measured spectra over predicted ones."""
    predicted, misfits = comparison.predicted, comparison.misfits
    best = min(comparison.best.values(), key=lambda misfit: misfit.rms)
    name, f = f"{comparison.measured.name} over {predicted.name}", predicted.frequency
    values = {name: comparison.measured.quantities[name] for name in comparison.quantities}
    case = f" of the case {best.case}" if best.case else ""
    left_out = f"not predicted, left out: {', '.join(comparison.left_out)}"
    helpful = (value for value in _helpful(comparison) if value.quantity == best.quantity and not value.at_limit)
    closer = next(helpful, None)
    listing = Listing.of(
        misfits,
        {
            "quantity": lambda misfit: misfit.quantity,
            "case": lambda misfit: misfit.case or "-",
            ">rms": lambda misfit: _size(misfit.rms, misfit),
            ">largest": lambda misfit: _size(misfit.largest, misfit),
            ">at / Hz": lambda misfit: f"{misfit.worst_frequency:.4g}",
            ">within 5 to 95 %": lambda misfit: "" if misfit.inside is None else f"{misfit.inside:.0%}",
        },
        caption=f"{name}: {len(f)} {predicted.bands or 'frequencies'}, {f[0]:g} to {f[-1]:g} Hz",
    )
    return Report(
        name=name,
        kind="comparison",
        label="Comparison",
        sentence=f"The {'closest' if len(misfits) > 1 else 'measured'} {QUANTITIES[best.quantity].title}{case} differs "
        f"from the prediction by {_size(best.rms, best)} (rms), by {_size(best.largest, best)} at most, "
        f"at {best.worst_frequency:.4g} Hz{_with_closest_value(closer)}.",
        facts=(
            ("frequencies", f"{len(f)}"),
            ("from", f"{f[0]:g} Hz"),
            ("to", f"{f[-1]:g} Hz"),
            ("cases", f"{len(predicted.cases)}"),
        ),
        note=_note(predicted),
        sections=(
            Section("Measured over predicted", _pictures(predicted, values, values)),
            Section("How far apart", listings=(listing,), remarks=(left_out,) if comparison.left_out else ()),
            *_closest_values(comparison),
        ),
        inputs={"measured": comparison.measured.name, **predicted.settings},
        tables={"comparison.csv": comparison.to_csv()},
        record=comparison.to_dict(),
        record_file="comparison.json",
        page="comparison.html",
        figures={f"comparison_{name}.png": partial(draw_quantity, predicted, name, v) for name, v in values.items()},
    )


def _with_closest_value(closer: ClosestValue | None) -> str:
    """Return what the difference would be with the one value that lessens it most, behind what it is."""
    if closer is None:
        return ""
    value, stated = (with_unit(number, closer.unit, 4) for number in (closer.value, closer.stated))
    return f"; it would differ by {_size(closer.rms, closer)} (rms) with {closer.field} of {value} in place of {stated}"


def _helpful(comparison: Comparison) -> list[ClosestValue]:
    """Return the values of single fields that bring a quantity closer by more than is not worth telling."""
    best = comparison.best
    return [value for value in comparison.closest_values if value.rms < _CLOSER * best[value.quantity].rms]


def _closest_values(comparison: Comparison) -> tuple[Section, ...]:
    """Return the section on what values of single fields would bring predictions closer; none where none was sought."""
    if not comparison.sought:
        return ()
    shown = _helpful(comparison)
    remarks = [
        f"No single value of a layer brings the {QUANTITIES[name].title} closer by more than {1 - _CLOSER:.0%}."
        for name in comparison.sought
        if name not in {value.quantity for value in shown}
    ]
    if comparison.not_sought:
        remarks.append(f"Left out, since no derivatives can be computed: {', '.join(comparison.not_sought)}.")
    listings: tuple[Listing, ...] = ()
    if shown:
        columns: dict[str, Callable[[ClosestValue], str]] = {
            "value of": lambda value: value.field,
            "quantity": lambda value: value.quantity,
            **({"case": lambda value: value.case} if any(value.case for value in shown) else {}),
            ">stated": lambda value: with_unit(value.stated, value.unit, 4),
            ">would be": _at_or_beyond,
            ">change": lambda value: f"{value.value / value.stated - 1:+.1%}" if value.stated else "",
            ">rms then": lambda value: _size(value.rms, value),
        }
        notes = ["Not what these values are: that tells a fit, which varies several at once, with their uncertainty."]
        if any(value.deviations is not None for value in shown):
            columns[">deviations"] = lambda value: "" if value.deviations is None else f"{value.deviations:.1f}"
            notes.insert(0, "Deviations: the change in standard deviations of what is drawn within the tolerance.")
        caption = "One value changed, all others as stated: where the prediction comes closest"
        listings = (Listing.of(shown, columns, caption=caption, notes=tuple(notes)),)
    return (Section("If one value were another", listings=listings, remarks=tuple(remarks)),)


def _at_or_beyond(value: ClosestValue) -> str:
    """Return the value, and on which side of it a closer one lies where it is the last that was searched."""
    sign = ("≤ " if value.value < value.stated else "≥ ") if value.at_limit else ""
    return f"{sign}{with_unit(value.value, value.unit, 4)}"


def _with(result: SimulationResult, quantity: Quantity) -> list[CaseResult]:
    return [case for case in result.cases if quantity.name in case.quantities]


def _mean(case: CaseResult, quantity: Quantity) -> float:
    return float(mean_of(quantity.name, case.quantities))


def _shown(value: float, quantity: Quantity) -> str:
    return f"{_in_cell(value, quantity)} {quantity.unit}".strip()


def _in_cell(value: float, quantity: Quantity) -> str:
    """Return a value without its unit, which stands above a table."""
    return f"{value:.{1 if quantity.unit == 'dB' else 2}f}"


def _size(value: float, of: Misfit | ClosestValue) -> str:
    return f"{value:.3g} {QUANTITIES[of.quantity].unit}".strip()


def _ranked(cases: Sequence[CaseResult], quantity: Quantity) -> list[CaseResult]:
    """Return the cases by what people rank by, their first single-number rating, the best first; none without it.

    ISO 717 and ISO 11654; a mean over frequency may rank them otherwise. A rating of another quantity than the main one
    ranks nothing: a roof against rain is not the better for its Rw.
    """
    if not cases or not all(case.ratings and _rated(case) == quantity.name for case in cases):
        return []
    return sorted(cases, key=_rank, reverse=IMPACT not in cases[0].ratings)


def _rated(case: CaseResult) -> str:
    """Return the name of the quantity to which the first rating of a case belongs, as `ratings` puts them in order."""
    if IMPACT in case.ratings:
        return "impact_level"
    return "absorption" if case.transmission_loss is None else "transmission_loss"


def _rank(case: CaseResult) -> float:
    return _number(_first(case)[1])


def _first(case: CaseResult) -> tuple[str, str]:
    """Return the first rating of a case, its name and its value."""
    return next(iter(case.ratings.items()))


def _number(rating: str) -> float:
    """Return the number with which a rating begins, as 47 of ``47 (-1; -5) dB``."""
    found = _RATED.match(rating)
    return float(found[0]) if found else float("-inf")


def _tiles(ranked: Sequence[CaseResult]) -> list[tuple[str, str]]:
    """Return the ratings of the best case, and the first of the worst where there are several."""
    if not ranked:
        return []
    best, worst = _ends(ranked)
    if len(ranked) == 1:
        return list(ranked[0].ratings.items())
    if len(best) == len(ranked):
        return [(f"{_first(ranked[0])[0]}, all {len(ranked)} cases", _values_of_first(ranked))]
    (name, value), *others = best[0].ratings.items()
    return [(f"best {name}, {_told(best)}", value), *others, (f"worst, {_told(worst)}", _first(worst[0])[1])]


def _rating_sentence(ranked: Sequence[CaseResult]) -> str:
    """Return the headline by the first rating; empty where there is none."""
    if not ranked:
        return ""
    best, worst = _ends(ranked)
    if len(ranked) > 1 and len(best) == len(ranked):
        return f"All {len(ranked)} cases are alike: {_first(ranked[0])[0]} {_values_of_first(ranked)}."
    first, last = (", ".join(f"{name} {value}" for name, value in end[0].ratings.items()) for end in (best, worst))
    if len(ranked) == 1:
        return f"{first}."
    return f"Of {len(ranked)} cases the best is {_told(best)}: {first}; the worst is {_told(worst)}: {last}."


def _ends(ranked: Sequence[CaseResult]) -> tuple[list[CaseResult], list[CaseResult]]:
    """Return the cases that are as good as the best, and those as bad as the worst."""
    best, worst = ([case for case in ranked if _rank(case) == _rank(end)] for end in (ranked[0], ranked[-1]))
    return best, worst


def _told(alike: Sequence[CaseResult]) -> str:
    """Return the label of the first of cases, and how many are like it."""
    more = f" (and {len(alike) - 1} alike)" if len(alike) > 1 else ""
    return f"{alike[0].label}{more}"


def _values_of_first(cases: Iterable[CaseResult]) -> str:
    """Return the first ratings of cases that are alike: their adaptation terms may differ."""
    return " or ".join(dict.fromkeys(_first(case)[1] for case in cases))


def _sentence(result: SimulationResult, quantity: Quantity, cases: list[CaseResult], means: Sequence[float]) -> str:
    f, mean = result.frequency, _shown(means[0], quantity)
    band = f"from {f[0]:g} to {f[-1]:g} Hz"
    if len(cases) > 1:
        labelled = list(zip(means, (case.label for case in cases), strict=True))
        low, high = (extreme(labelled, key=lambda pair: pair[0]) for extreme in (min, max))
        alike = _shown(low[0], quantity) == _shown(high[0], quantity)
        ends = (f"{_shown(value, quantity)} ({label})" for value, label in (low, high))
        told = f"{mean} in all of them" if alike else " to ".join(ends)
        return f"Over {len(cases)} cases the {quantity.title}, averaged {band}, is {told}."
    if len(f) == 1:
        return f"The {quantity.title} at {f[0]:g} Hz is {mean}."
    values = cases[0].quantities[quantity.name]
    most = int(np.argmax(np.where(np.isfinite(values), values, -np.inf)))  # what nothing gets through is no value
    largest = _shown(float(values[most]), quantity)
    return f"The {quantity.title} is {mean} on average {band}, and {largest} at most, at {f[most]:.4g} Hz."


def _note(result: SimulationResult) -> str:
    if not any(case.percentiles for case in result.cases):
        return ""
    return "Bands in figures, and brackets in tables, hold 5 to 95 % of the samples drawn within the tolerances."


def _pictures(result: SimulationResult, names: Iterable[str], measured: Any = None) -> tuple[Picture, ...]:
    return tuple(
        Picture(
            partial(draw_quantity, result, name, measured and measured[name], upright=True),
            f"{QUANTITIES[name].title[0].upper()}{QUANTITIES[name].title[1:]}.",
        )
        for name in list(names)[:_MOST_PICTURES]
    )


def _values(result: SimulationResult, quantity: Quantity, **options: Any) -> Listing:
    """Return a quantity over frequency, cases beside each other; of many cases a row for each."""
    cases, rows = _with(result, quantity), _rows(result)
    bands = result.bands or ("third octaves" if len(rows) != len(result.frequency) else None)
    named = over_unit(quantity.title, quantity.unit)
    caption = f"{result.name}: {named}{f', averages over {bands}' if bands else ''}"
    if len(cases) <= _MOST_COLUMNS:
        headings = ["\n".join([*cases[0].shown, "f / Hz"])]
        headings += ["\n".join([*case.shown.values(), " "]) if case.shown else "value" for case in cases]
        cells = tuple((f"{f:.4g}", *(_cell(case, quantity, at) for case in cases)) for f, at in rows)
        return Listing(tuple(headings), cells, tuple(range(len(headings))), caption, **options)
    octaves = [row for row in rows if np.any(np.abs(row[0] / band_centres(63, 8000, "octaves") - 1) < 0.01)]
    chosen = octaves or rows[:_MOST_COLUMNS]
    headings = ["case", *(f"{f:.4g} Hz" for f, _ in chosen), "mean"]
    cells = tuple(
        (
            case.label,
            *(_cell(case, quantity, at) for _, at in chosen),
            _in_cell(_mean(case, quantity), quantity),
        )
        for case in cases
    )
    return Listing(tuple(headings), cells, tuple(range(1, len(headings))), caption, **options)


def _scatter(result: SimulationResult, quantity: Quantity) -> tuple[Section, ...]:
    """Return the section on what tolerances contribute to the scatter of a quantity; none where it does not scatter."""
    cases = [case for case in result.cases if case.spread.get(quantity.name)]
    if not cases:
        return ()
    text = f"Standard deviation of the {quantity.title} that comes of each tolerance; black: of all."
    picture = Picture(partial(draw_spread, result, quantity.name, upright=True), text)
    return (Section("Scatter", (picture,), (_origins(cases, quantity),)),)


def _origins(cases: Sequence[CaseResult], quantity: Quantity) -> Listing:
    """Return what each tolerance contributes to the scatter of a quantity, most first; of several cases a range."""
    variances = [{path: _mean_square(sd) for path, sd in case.spread[quantity.name].items()} for case in cases]
    shares = [{path: value / (sum(of_case.values()) or 1) for path, value in of_case.items()} for of_case in variances]
    fields = sorted(shares[0], key=lambda path: -max(of_case[path] for of_case in shares))
    named = over_unit(quantity.title, quantity.unit)
    of_cases = " (range of the cases)" if len(cases) > 1 else ""
    return Listing.of(
        fields,
        {
            "tolerance of": str,
            ">share of the variance": lambda path: _range([f"{of_case[path]:.0%}" for of_case in shares]),
            ">standard deviation": lambda path: _range([f"{np.sqrt(of_case[path]):.2g}" for of_case in variances]),
        },
        caption=f"Where the scatter of the {named} comes from, over all frequencies{of_cases}",
    )


def _mean_square(values: RealArray) -> float:
    finite = values[np.isfinite(values)]
    return float(np.mean(finite**2)) if finite.size else 0.0


def _range(texts: Sequence[str]) -> str:
    """Return the least and the most of numbers, each written as it is to be told."""
    ends = (extreme(texts, key=lambda text: float(text.rstrip("%"))) for extreme in (min, max))
    return " to ".join(dict.fromkeys(ends))


def _rows(result: SimulationResult) -> Rows:
    """Return what a row stands for: its frequency, and the indices of the values averaged in it."""
    if result.bands or len(result.frequency) <= _MOST_POINTS:
        return [(f, np.array([i])) for i, f in enumerate(result.frequency)]
    return bands_of(result.frequency)


def _cell(case: CaseResult, quantity: Quantity, indices: NDArray[np.intp]) -> str:
    """Return a value of a case, averaged over the frequencies at some indices; of one, with its percentiles."""
    there = {name: values[indices] for name, values in case.quantities.items()}
    value = _in_cell(float(mean_of(quantity.name, there)), quantity)
    (column,) = quantity.columns
    if len(indices) > 1 or column not in case.percentiles:
        return value
    low, _, high = (_in_cell(band[indices[0]], quantity) for band in case.percentiles[column])
    return f"{value} [{low}, {high}]"
