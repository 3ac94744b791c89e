"""How accurate derivatives are, and what they cost beside differences: ``docs/validation/derivatives.md``.

Run it as ``OMP_NUM_THREADS=1 python -m validation.derivatives > docs/validation/derivatives.md``; it takes about
three minutes. Exact derivatives are differences of an independent solution in 120 digits
(``tests/analytic/mp_reference.py``). Times are processor time, the least of some repeats, side by side in one run.
"""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any
from unittest.mock import patch

import numpy as np
from scipy.stats.qmc import Sobol

from multilayer.arrays import RealArray
from multilayer.optimisation import search
from multilayer.optimisation.file import OptimisationFile
from multilayer.optimisation.search import Candidate, Descent, Point, Problem, Scalar, in_order
from multilayer.paths import value_at, with_values
from multilayer.response import (
    base_motion_derivatives,
    diffuse_field,
    diffuse_field_derivatives,
    plane_wave,
    plane_wave_derivatives,
)
from multilayer.response.linearised import real_fields
from multilayer.simulation import closest_values, tasks
from multilayer.simulation.bands import grid_of
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.tasks import Task, run_task
from multilayer.stack import Stack
from tests.analytic import mp_reference
from tests.analytic.materials import AIR, ALUMINIUM, FOAM, FOAM2, GEL, SHEET, stack
from tests.analytic.test_against_mp import ENDS, MIXED, SINGLE
from validation.timing import least_seconds

FREQUENCIES, ANGLES = (1.0, 300.0, 2e4), (0.0, 45.0, 89.0)
DRAWS = 1  # fields, frequencies and angles of each stack and end
STEP = 1e-4  # of central differences, as a share of the value
REPEATS = 3
AT_ONCE = 16_384  # points of one batch, as in fits of stacks


@dataclass(frozen=True)
class Error:
    """An error beside the derivative, and beside the response as the field changes by its own size."""

    relative: float
    of_response: float


def errors() -> Iterator[Error]:
    """Give the errors of R, T and the motion of a shaken stack, of fields drawn from all stacks and ends."""
    rng = np.random.default_rng(0)
    panels = [panel.model_copy(update={"termination": end}) for panel in MIXED.values() for end in ENDS]
    panels += [stack(layer) for name, layer in SINGLE.items() if name != "air 10 m"]  # which reflects nothing
    for panel in panels:
        found = plane_wave_derivatives(panel, None, FREQUENCIES, ANGLES)
        for _ in range(DRAWS):
            place, i, j = (int(rng.integers(n)) for n in found.reflection.shape)
            exact = mp_reference.plane_wave_slopes(panel, found.fields[place], FREQUENCIES[i], ANGLES[j])
            for name, slope in zip(("reflection", "transmission"), exact, strict=False):
                response = getattr(found.response, name)[i, j]
                yield error(getattr(found, name)[place, i, j], slope, response, panel, found.fields[place])
        if panel.termination != "rigid":
            moved = base_motion_derivatives(panel, None, FREQUENCIES)
            (slope,) = mp_reference.base_motion_slopes(panel, found.fields[place], FREQUENCIES[i])
            response = moved.response.transmissibility[i]
            yield error(moved.transmissibility[place, i], slope, response, panel, found.fields[place])


def error(computed: complex, exact: complex, response: complex, panel: Stack, path: str) -> Error:
    """Return the error of one derivative."""
    off, value = abs(computed - exact), abs(value_at(panel, path)) or 1.0
    return Error(off / max(abs(exact), 1e-300), off * value / abs(response))


def accuracy() -> list[str]:
    """Return the section on errors."""
    with np.errstate(all="ignore"):  # responses of extreme stacks vanish
        found = list(errors())
    either = np.array([min(one.relative / 1e-8, one.of_response / 1e-12) for one in found])
    relative = np.sort([one.relative for one in found])
    of_response = np.sort([one.of_response for one in found])
    return [
        f"{len(found)} derivatives of R, T and the motion of shaken stacks, by fields drawn from {len(MIXED)} stacks "
        f"at {len(ENDS)} ends each and {len(SINGLE) - 1} single layers, at 1, 300 and 20 000 Hz and 0, 45 and 89 "
        "degrees.",
        "",
        "| error | median | 90 % | 99 % | largest |",
        "|---|---|---|---|---|",
        row("beside the derivative", relative, ends=False),
        row("beside the response, the field changing by its own size", of_response),
        "",
        f"Within 1e-8 of the derivative, or 1e-12 of the response: {np.count_nonzero(either <= 1)} of {len(found)}. "
        "What is farther off beside the derivative belongs to fields that hardly matter, whose effect lies below the "
        "digits of the response.",
    ]


def row(name: str, values: np.ndarray, ends: bool = True) -> str:
    """Return a row of quantiles, the last two only with `ends`."""
    picked = [*np.quantile(values, (0.5, 0.9, 0.99), method="lower"), values[-1]]
    texts = [f"{value:.0e}" for value in picked]
    return f"| {name} | " + " | ".join(texts if ends else [*texts[:2], "", ""]) + " |"


WOOL = {
    "type": "equivalent_fluid", "porosity": 0.95, "flow_resistivity": 1e4, "tortuosity": 1.1, "viscous_length": 1e-4,
    "thermal_length": 2e-4,
}  # fmt: skip
PANELS = {
    "wool before a wall": stack((WOOL, 0.05), termination="rigid"),
    "foam before a wall": stack((FOAM2, 0.03), termination="rigid"),
    "sheet, gap, foam": stack((SHEET, 1e-3), (AIR, 0.05), (FOAM2, 0.03)),
    "seven layers": stack(
        (ALUMINIUM, 1e-3), (FOAM, 0.02), (AIR, 0.05), (WOOL, 0.04), (GEL, 0.01), (FOAM2, 0.03), (ALUMINIUM, 2e-3)
    ),
}


def by_differences(panel: Stack, paths: tuple[str, ...], frequency: np.ndarray, angle: Any) -> None:
    """Compute the responses at all points of central differences, as many at once as fits compute."""
    values = np.array([value_at(panel, path) for path in paths], dtype=float)
    steps = STEP * np.where(values == 0, 1.0, values)
    points = np.concatenate([values[None], values + np.diag(steps), values - np.diag(steps)])
    at_once = max(AT_ONCE // (frequency.size * np.size(angle)), 1)
    for first in range(0, len(points), at_once):
        some = points[first : first + at_once]
        columns = {path: some[:, i].reshape(-1, *(1,) * (1 + np.ndim(angle))) for i, path in enumerate(paths)}
        plane_wave(panel.replaced(columns), frequency, angle)


def price() -> list[str]:
    """Return the section on times."""
    heads = ["stack", "fields", "frequencies x angles", "response, ms", "all derivatives with it, ms", "responses"]
    lines = ["| " + " | ".join([*heads, "differences, ms", "gain"]) + " |", "|---|---|---|---|---|---|---|---|"]
    for name, panel in PANELS.items():
        lines += [plane_waves(name, panel, 100, 0.0), plane_waves(name, panel, 1000, 0.0)]
        lines += [plane_waves(name, panel, 100, np.linspace(0, 80, 30)), diffuse(name, panel)]
    return lines


def plane_waves(name: str, panel: Stack, count: int, angle: Any) -> str:
    """Return the row of plane waves at some frequencies and angles."""
    f, paths = np.geomspace(50.0, 5000.0, count), real_fields(panel, None)
    alone = least_seconds(lambda: plane_wave(panel, f, angle), REPEATS)[0]
    derived = least_seconds(lambda: plane_wave_derivatives(panel, paths, f, angle), REPEATS)[0]
    apart = least_seconds(lambda: by_differences(panel, paths, f, angle), REPEATS)[0]
    return times(name, paths, f"{count} x {np.size(angle)}", alone, derived, apart)


def diffuse(name: str, panel: Stack) -> str:
    """Return the row of a diffuse field in third octaves."""
    f, paths = np.geomspace(100.0, 5000.0, 18), real_fields(panel, None)
    alone = least_seconds(lambda: diffuse_field(panel, f), REPEATS)[0]
    derived = least_seconds(lambda: diffuse_field_derivatives(panel, paths, f), REPEATS)[0]
    apart = (2 * len(paths) + 1) * alone
    return times(name, paths, "18, diffuse", alone, derived, apart)


def times(name: str, paths: tuple[str, ...], grid: str, alone: float, derived: float, apart: float) -> str:
    """Return a row of times."""
    cells = [name, str(len(paths)), grid, f"{1e3 * alone:.2f}", f"{1e3 * derived:.2f}", f"{derived / alone:.1f}"]
    return "| " + " | ".join([*cells, f"{1e3 * apart:.1f}", f"{apart / derived:.1f}"]) + " |"


MINERAL_WOOL = {**WOOL, "type": "limp", "frame_density": 40.0}
PLATE = {"type": "elastic_plate", "density": 800.0, "young_modulus": 2.5e9, "poisson_ratio": 0.2, "loss_factor": 0.03}
GRADED = [{**WOOL, "name": f"wool{i}", "thickness": 0.02} for i in range(4)]
DESIGNS: dict[str, Mapping[str, Any]] = {
    "wool and gap, alpha_w": {
        "layers": [GRADED[0], {"type": "fluid", "name": "gap", "thickness": 0.02}],
        "termination": "rigid",
        "design": {"layers.wool0.thickness": [0.005, 0.05], "layers.gap.thickness": [0.002, 0.1]},
        "goal": {"highest": "alpha_w"},
        "limits": [{"of": "thickness", "at_most": 0.06}],
    },
    "double wall, Rw": {
        "layers": [
            {**PLATE, "name": "front", "thickness": 0.0125},
            {**MINERAL_WOOL, "name": "wool", "thickness": 0.04},
            {"type": "fluid", "name": "gap", "thickness": 0.02},
            {**PLATE, "name": "back", "thickness": 0.0125},
        ],
        "termination": "ambient",
        "design": {
            "layers.front.thickness": [0.006, 0.025], "layers.back.thickness": [0.006, 0.025],
            "layers.wool.thickness": [0.01, 0.08], "layers.gap.thickness": [0.002, 0.08],
            "layers.wool.flow_resistivity": [2e3, 5e4],
        },
        "goal": {"highest": "Rw"},
        "limits": [{"of": "thickness", "at_most": 0.1}, {"of": "mass", "at_most": 30.0}],
    },
    "four wools, absorption": {
        "layers": GRADED,
        "termination": "rigid",
        "design": {
            f"layers.{layer['name']}.{field}": ends
            for layer in GRADED
            for field, ends in (
                ("thickness", [0.005, 0.04]), ("flow_resistivity", [2e3, 1e5]), ("porosity", [0.7, 0.99])
            )
        },
        "goal": {"highest": "absorption", "from": 100, "to": 1000},
        "limits": [{"of": "thickness", "at_most": 0.08}],
    },
}  # fmt: skip
BAND, STARTS = {"third_octaves": [100, 5000]}, 4


def optimisation() -> list[str]:
    """Return the section on searches of the best design."""
    heads = ["problem", "fields", "derivatives, ms", "differences, ms", "gain", "descents, s", "by differences, s"]
    lines = ["| " + " | ".join([*heads, "gain", "best", "by differences"]) + " |", "|---" * 10 + "|"]
    return [*lines, *(design(name, data) for name, data in DESIGNS.items())]


def design(name: str, data: Mapping[str, Any]) -> str:
    """Return the row of one problem: the price of a slope, and descents from the same designs by either."""
    file = OptimisationFile.model_validate({"version": 1, "frequency": BAND, "incidence": "diffuse", **data})
    (variant,) = file.space.variants()
    problem = Problem(grid_of(file.frequency), file.goals, file.bounds, {}, variant, np.zeros(len(file.bounds)))
    starts = Sobol(len(variant.ranges), rng=np.random.default_rng(0)).random(STARTS)
    here = Point(starts[0], *(values[0] for values in problem.measure(variant, starts[:1])))
    scalar = Scalar(np.ones(1), np.zeros(1), np.ones(1))

    def descended() -> list[Candidate]:
        return [end for start in starts for end in Descent(problem, variant, scalar, start)()]

    single, whole, best = [], [], []
    for most in (0, 10**9):
        with patch.object(search, "FEW_FIELDS", most):
            single.append(least_seconds(lambda: problem.slopes(variant, here), REPEATS)[0])
            begin = time.process_time()
            ends = descended()
            whole.append(time.process_time() - begin)
        best.append(in_order(ends, scalar)[0].goals[0])
    cells = [name, str(len(variant.ranges)), *(f"{1e3 * one:.1f}" for one in single), f"{single[1] / single[0]:.1f}"]
    cells += [*(f"{one:.1f}" for one in whole), f"{whole[1] / whole[0]:.1f}", *(f"{-one:.4f}" for one in best)]
    return "| " + " | ".join(cells) + " |"


NARROW = {"third_octaves": [250, 1000]}
SPREAD = 0.005  # standard deviation of every field, as a share of its value
SAMPLES = 200  # as many as simulations draw


def tolerances() -> list[str]:
    """Return the section on what each tolerance contributes to the scatter of a simulation."""
    heads = [
        "stack",
        "fields",
        "incidence",
        "derivatives, ms",
        "differences, ms",
        "gain",
        "apart",
        f"{SAMPLES} responses, ms",
    ]
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for name, panel in PANELS.items():
        lines += [contributions(name, panel, incidence) for incidence in (45, "diffuse")]
    return lines


def contributions(name: str, panel: Stack, incidence: str | int) -> str:
    """Return the row of one stack: by derivatives, by differences of whole responses, and the samples themselves."""
    paths = [path for path in real_fields(panel, None) if value_at(panel, path)]
    deviations = {path: SPREAD * value_at(panel, path) for path in paths}
    layers = [{**WOOL, "thickness": 0.05}]  # of a file that says the rest
    file = SimulationFile.model_validate({"layers": layers, "frequency": NARROW, "incidence": incidence})
    task = Task(panel, grid_of(file.frequency).points, file.incidence, deviations=deviations)
    alone = least_seconds(lambda: run_task(replace(task, deviations={})), REPEATS)[0]
    spreads, seconds = [], []
    for exact in (True, False):
        with patch.object(tasks, "_takes_derivatives", lambda _task, _path, exact=exact: exact):
            spreads.append(run_task(task).spread)
            seconds.append(least_seconds(lambda: run_task(task), REPEATS)[0] - alone)
    apart = max(
        np.max(np.abs(of_fields[path] - spreads[1][quantity][path])) / np.max([*of_fields.values()])
        for quantity, of_fields in spreads[0].items()
        for path in of_fields
    )
    cells = [
        name,
        str(len(paths)),
        str(incidence),
        *(f"{1e3 * one:.1f}" for one in seconds),
        f"{seconds[1] / seconds[0]:.1f}",
    ]
    return "| " + " | ".join([*cells, f"{apart:.1g}", f"{1e3 * SAMPLES * alone:.0f}"]) + " |"


WRONG = 1.1  # times its stated value, the thickness of the first layer in the measurement that is compared


def comparisons() -> list[str]:
    """Return the section on values of single fields that bring a prediction closest to a measurement."""
    heads = ["stack", "fields", "incidence", "derivatives, ms", "differences, ms", "gain", "values apart"]
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for name, panel in PANELS.items():
        lines += [comparison(name, panel, incidence) for incidence in (45, "diffuse")]
    return lines


def comparison(name: str, panel: Stack, incidence: str | int) -> str:
    """Return the row of one stack: the search by exact derivatives, and by central differences of responses."""
    layers = [{**WOOL, "thickness": 0.05}]  # of a file that says the rest
    file = SimulationFile.model_validate({"layers": layers, "frequency": NARROW, "incidence": incidence})
    task = Task(panel, grid_of(file.frequency).points, file.incidence)
    path = next(path for path in real_fields(panel, None) if path.endswith(".thickness"))
    wrong = panel.replaced({path: WRONG * value_at(panel, path)})
    spectra = run_task(replace(task, stack=wrong)).quantities
    quantity = "transmission_loss" if "transmission_loss" in spectra else "absorption"
    found, seconds = [], []
    for slopes in (closest_values.linearised, stepped):
        with patch.object(closest_values, "linearised", slopes):
            found.append(closest_values.closest_values(task, quantity, spectra[quantity])[0][0])
            seconds.append(
                least_seconds(lambda: closest_values.closest_values(task, quantity, spectra[quantity]), REPEATS)[0]
            )
    apart = abs(found[1].value / found[0].value - 1)
    paths = real_fields(panel, None)
    cells = [name, str(len(paths)), str(incidence), *(f"{1e3 * one:.0f}" for one in seconds)]
    return "| " + " | ".join([*cells, f"{seconds[1] / seconds[0]:.1f}", f"{apart:.0e}"]) + " |"


def stepped(
    panel: Stack, paths: Sequence[str], frequency: RealArray, incidence: Any, _window: object, effort: Mapping[str, Any]
) -> dict[str, tuple[RealArray, RealArray]]:
    """Return quantities and slopes as `simulation.linearised` does, by central differences of whole responses."""

    def respond(stack: Stack) -> dict[str, Any]:
        return run_task(Task(stack, frequency, incidence, effort=effort)).quantities

    here, slopes = respond(panel), []
    for path in paths:
        value = value_at(panel, path)
        step = STEP * (abs(value) or 1.0)
        above, below = (respond(with_values(panel, {path: value + side * step})) for side in (1, -1))
        slopes.append({name: (above[name] - below[name]) / (2 * step) for name in here})
    return {name: (value, np.array([slope[name] for slope in slopes])) for name, value in here.items()}


def main() -> None:
    """Compare and print the page."""
    threads = os.environ.get("OMP_NUM_THREADS", "not set")
    lines = [
        "# Derivatives",
        "",
        "Derivatives of responses by fields of layers ([responses](../responses.md#derivatives), "
        "[theory](../theory/stacks.md#derivatives)) against differences in 120 digits, and their price.",
        "",
        f"Made by `python -m validation.derivatives`, OMP_NUM_THREADS={threads}, one process, Python "
        f"{platform.python_version()}, numpy {np.__version__}.",
        "",
        "## Accuracy",
        "",
        *accuracy(),
        "",
        "## Price",
        "",
        f"Processor time, the least of {REPEATS} runs; ratios, taken in one run, are what to read. *Responses*: the "
        "price in responses of the same grid, the response itself included. *Differences*: central ones by all fields; "
        "of plane waves in batches of 16 384 points, of diffuse fields 2 n + 1 times the response; *gain*: their time "
        "over that of the derivatives.",
        "",
        *price(),
        "",
        "Differences have a price that grows with the number of fields, and lose half of the digits; the price of "
        "derivatives hardly grows. Of few points and few fields a batch of differences costs as little: fits of stacks "
        "take differences where all their points together are at most 4096, and derivatives beyond, and always of "
        "diffuse fields.",
        "",
        "## Tolerances",
        "",
        "What each tolerance [contributes](../simulation.md#tolerances) to the scatter, of all fields that are not 0: "
        f"by derivatives, by differences of two responses for each, and how far apart these are beside the largest "
        f"contribution, standard deviations of {SPREAD:.1%}; beside them the time of {SAMPLES} responses. Third "
        "octaves from 250 to 1000 Hz.",
        "",
        *tolerances(),
        "",
        "The differences of the seven layers are not straight where the gel's Poisson's ratio comes near a half.",
        "",
        "## Comparisons",
        "",
        "Which value of a single field [brings a prediction closest](../simulation.md#measured-over-predicted) to a "
        f"measurement, of a stack whose first layer is {WRONG - 1:.0%} thicker than stated: all fields searched, by "
        "exact derivatives and by central differences of responses, and how far apart the best value is by either. "
        "Third octaves from 250 to 1000 Hz. A search has one field at a time, of which a derivative costs as much as "
        "two more responses: what is gained is exactness.",
        "",
        *comparisons(),
        "",
        "## Optimisation",
        "",
        "[Searches](../tasks/optimise.md) of the best design take derivatives of all goals and limits of a point. "
        f"*Derivatives*: one point, exact; *differences*: the same, forward. *Descents*: from {STARTS} designs, the "
        "same ones, by either, and the best value of the goal at their ends. Third octaves from 100 to 5000 Hz, "
        "diffuse field.",
        "",
        *optimisation(),
        "",
        f"Up to {search.FEW_FIELDS} fields a search takes differences, which cost less; of more, derivatives. Layers "
        "of plugins without a medium of their own have differences in either.",
    ]
    print("\n".join(lines))  # noqa: T201


if __name__ == "__main__":
    main()
