"""The report of an optimisation."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from multilayer.number_text import significant, with_unit
from multilayer.optimisation.aims import Aim
from multilayer.optimisation.design import Range
from multilayer.optimisation.result import Design, End, OptimisationResult
from multilayer.report.listing import Listing, Tinted
from multilayer.report.optimisation_figures import draw_front
from multilayer.report.report import Picture, Report, Section
from multilayer.report.simulation_figures import draw_quantity

_AT_A_BOUND = 1e-3  # of the way from one bound to the other
_ALIKE = 0.005  # of searches that end at the same goal: of it, or of 1
_DRAWN = ("absorption", "transmission_loss", "insertion_loss")
_MOST_ENDS = 12
_SHIFTED = ("Rw", "STC", "alpha_w")  # ratings by a reference curve; the search follows others without rounding


def optimisation_report(result: OptimisationResult) -> Report:
    """Return the report of an optimisation."""
    curves = [name for name in _DRAWN if all(name in case.quantities for case in result.simulated.cases)]
    if "transmission_loss" in curves:  # what does not come back from a stack that lets sound through is not absorbed
        curves.remove("absorption")
    front = len(result.goals) > 1
    pictures = [
        Picture(partial(draw_quantity, result.simulated, name, upright=True), _caption(name)) for name in curves
    ]
    figures = {f"{name}.png": partial(draw_quantity, result.simulated, name) for name in curves}
    if front:
        pictures.insert(0, Picture(partial(draw_front, result, upright=True), "The front, and the design as written."))
        figures["front.png"] = partial(draw_front, result)
    return Report(
        name=result.name,
        kind="optimisation",
        label=("Front" if front else "Best design") if result.is_whole else "Best so far",
        tone="good" if result.is_whole else "mind",
        sentence=_sentence(result),
        facts=_facts(result),
        sections=(
            Section("Design", listings=(_designs(result), *_limits(result)), remarks=(_note(result),)),
            Section("Over frequency", tuple(pictures)),
            *([Section("Where the searches ended", listings=(_ends(result),))] if result.ends else []),
        ),
        inputs=result.settings,
        tables={"designs.csv": result.to_csv(), "curves.csv": result.simulated.to_csv()},
        record=result.to_dict(),
        record_file="optimisation.json",
        texts=result.files,
        page="report.html",
        figures=figures,
    )


def _caption(name: str) -> str:
    return f"{name.replace('_', ' ').capitalize()} of what was found, beside the design as written."


def shown(value: float, aim: Aim) -> str:
    """Return a value of a goal or a limit with its unit."""
    if not np.isfinite(value):
        return "-"
    if aim.unit == "dB":
        return f"{value:.1f} dB" if aim.rating is None else f"{value:.0f} dB"
    if aim.unit:
        return with_unit(value, aim.unit)
    return f"{value:.2f}" if aim.quantity and aim.target is None else significant(value)


def _sentence(result: OptimisationResult) -> str:
    if len(result.goals) > 1:
        ranges = (
            f"{aim.title}: {shown(design[0], aim)} to {shown(design[1], aim)}"
            for aim, design in zip(result.goals, _extremes(result), strict=True)
        )
        return f"{len(result.designs)} designs of which none is better in all goals: {'; '.join(ranges)}."
    (aim,), best, written = result.goals, result.best, result.written
    misses = "" if written.is_kept else " (which misses a limit)"
    was = f", {shown(written.goals[0], aim)} as written{misses}" if np.isfinite(written.goals[0]) else ""
    return f"{aim.title}: {shown(best.goals[0], aim)}{was}."


def _extremes(result: OptimisationResult) -> list[tuple[float, float]]:
    values = np.array([design.goals for design in result.designs])
    ends = zip(values.min(axis=0).tolist(), values.max(axis=0).tolist(), strict=True)
    return [end if aim.sign > 0 else end[::-1] for end, aim in zip(ends, result.goals, strict=True)]


def _facts(result: OptimisationResult) -> tuple[tuple[str, str], ...]:
    if len(result.goals) > 1:
        facts = [("designs on the front", str(len(result.designs)))]
    else:
        facts = [(result.goals[0].title, shown(result.best.goals[0], result.goals[0]))]
    facts.append(("choices", str(result.variants)))
    facts.append(("fields between bounds", str(len(result.ranges))))
    return (*facts, ("parts of the search", str(result.searches)))


def _note(result: OptimisationResult) -> str:
    """Return how far the result hangs on where the search began, and the rating that it followed."""
    told, (aim, *others) = [], result.goals
    repeats = [end for end in result.ends if end.is_repeat]
    if repeats:
        told.append(
            f"{_alike(result, repeats)} of {len(repeats)} descents from anywhere, with the choices of the best, "
        )
        told.append(f"end within {_ALIKE:.1%} of its goal (seed {result.settings['search']['seed']})")
    else:
        told.append(f"the search began with the seed {result.settings['search']['seed']}")
    if aim.rating is not None and not others:
        value = f"{result.best.followed[0]:.{2 if aim.unit == 'dB' else 3}f} {aim.unit}".rstrip()
        how = "with a real shift of its reference curve" if aim.name in _SHIFTED else "without rounding"
        told.append(f"; {how}, as the search follows it, {aim.name} is {value}")
    return "".join(told)


def _alike(result: OptimisationResult, ends: list[End]) -> int:
    """Return how many searches ended as high, or low, as the best."""
    sign = result.goals[0].sign
    best = max(sign * end.goal for end in result.ends if end.is_kept)
    return sum(end.is_kept and sign * end.goal >= best - _ALIKE * max(abs(best), 1e-9) for end in ends)


def _columns(result: OptimisationResult) -> dict[str, Callable[[Design], str]]:
    choices = list(dict.fromkeys(name for design in result.designs for name in design.choices))
    columns: dict[str, Callable[[Design], str]] = {"design": lambda design: design.name}
    columns |= {f">{aim.title}": partial(_goal, i, aim) for i, aim in enumerate(result.goals)}
    columns |= {name: partial(_choice, name) for name in choices}
    return columns | {f">{item.name}": partial(_value, item) for item in result.ranges}


def _goal(i: int, aim: Aim, design: Design) -> str:
    text = shown(design.goals[i], aim)
    return text if design.is_kept else f"{text} (misses a limit)"


def _choice(name: str, design: Design) -> str:
    return design.choices.get(name, "-")


def _value(item: Range, design: Design) -> str:
    if item.name not in design.values:
        return "-"
    value = design.values[item.name]
    where = item.coordinate(value)
    mark = "*" if design.name != "as written" and min(where, 1 - where) < _AT_A_BOUND else ""
    return with_unit(value, item.unit) + mark


def _designs(result: OptimisationResult) -> Listing:
    listing = Listing.of([result.written, *result.designs], _columns(result))
    marked = any(cell.endswith("*") for row in listing.rows for cell in row)
    notes = ("* at a bound of the design: a wider one may give more",) if marked else ()
    return Listing(listing.headings, listing.rows, listing.numeric, f"{result.name}: designs", notes).filled()


def _limits(result: OptimisationResult) -> tuple[Listing, ...]:
    if not result.bounds:
        return ()
    pairs = [(i, aim) for i, aim in enumerate(result.bounds)]

    def state(pair: tuple[int, Aim]) -> str:
        slack = pair[1].slack(result.best.limits[pair[0]])
        return "at the limit" if slack < _ALIKE else "kept"

    def written(pair: tuple[int, Aim]) -> str:
        i, aim = pair
        text = shown(result.written.limits[i], aim)
        return text if not aim.slack(result.written.limits[i]) < 0 else Tinted(text, "red")

    first = "best" if len(result.goals) == 1 else "design 1"
    columns: dict[str, Callable[[tuple[int, Aim]], str]] = {
        "limit": lambda pair: pair[1].title,
        ">as written": written,
        f">{first}": lambda pair: shown(result.best.limits[pair[0]], pair[1]),
        "": state,
    }
    return (Listing.of(pairs, columns, caption="Limits"),)


def _ends(result: OptimisationResult) -> Listing:
    (aim,) = result.goals
    ends = sorted(result.ends, key=lambda end: (not end.is_kept, -aim.sign * end.goal))

    def goal(end: End) -> str:
        return (f"{end.goal:.2f}" if aim.unit == "dB" else significant(end.goal, 4)) + f" {aim.unit}".rstrip()

    columns: dict[str, Callable[[End], str]] = {
        f">{aim.title}": goal,
        "choices": lambda end: end.choices,
        "limits": lambda end: "kept" if end.is_kept else "missed",
    }
    listing = Listing.of(ends[:_MOST_ENDS], columns, only="page")
    return listing.filled()
