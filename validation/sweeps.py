"""What sweeps gain where cases are computed together: ``docs/validation/sweeps.md``.

Run it as ``OMP_NUM_THREADS=1 python -m validation.sweeps > docs/validation/sweeps.md``; it takes about a minute.
Times are processor time, the least of some repeats, side by side in one run.
"""

from __future__ import annotations

import os
import platform
from typing import Any
from unittest.mock import patch

import numpy as np

from multilayer.response import plane_wave
from multilayer.simulation.batches import Batch, batches, run_batch
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.result import SimulationResult
from multilayer.simulation.run import cases_at_once, plan, run
from tests.analytic.materials import AIR, ALUMINIUM, FOAM, stack
from validation.timing import least_seconds

CASES, REPEATS = 1000, 2
WOOL = {
    "type": "equivalent_fluid", "porosity": 0.95, "flow_resistivity": 1e4, "tortuosity": 1.1, "viscous_length": 1e-4,
    "thermal_length": 2e-4,
}  # fmt: skip
WALL = ((ALUMINIUM, 1e-3), (FOAM, 0.05), (AIR, 0.02), (ALUMINIUM, 1e-3))
STACKS = {
    "wool before a wall": stack((WOOL, 0.05), termination="rigid"),
    "foam before a wall": stack((FOAM, 0.05), termination="rigid"),
    "aluminium, foam, air, aluminium": stack(*WALL),
}
SWEPT = {"wool before a wall": 0, "foam before a wall": 0, "aluminium, foam, air, aluminium": 2}
FREQUENCIES: dict[str, Any] = {
    "20 lines": np.geomspace(100.0, 5000.0, 20).tolist(),
    "100 lines": np.geomspace(100.0, 5000.0, 100).tolist(),
    "18 third octaves": {"third_octaves": [100, 5000]},
}


def row(name: str, grid: str) -> str:
    """Return the row of one stack and its frequencies."""
    layer = SWEPT[name]
    thickness = STACKS[name].layers[layer].depth
    file = SimulationFile.model_validate({
        **STACKS[name].to_dict(), "frequency": FREQUENCIES[grid],
        "sweep": {f"layers.{layer}.thickness": (thickness * np.linspace(0.5, 1.5, CASES)).tolist()},
    })  # fmt: skip
    planned = plan(file)
    paths, many = [*file.cases[0].values], cases_at_once(planned)

    def responses(size: int) -> list[Batch]:
        made = batches(planned.tasks, paths, size)
        for batch in made:
            run_batch(batch)
        return made

    def simulated(size: int) -> SimulationResult:
        with patch("multilayer.simulation.run.cases_at_once", lambda _: size):
            return run(planned)

    apart, _ = least_seconds(lambda: responses(1), REPEATS)
    together, _ = least_seconds(lambda: responses(many), REPEATS)
    whole_apart, one = least_seconds(lambda: simulated(1), REPEATS)
    whole, other = least_seconds(lambda: simulated(many), REPEATS)
    pairs = zip(one.cases, other.cases, strict=True)
    off = max(float(np.max(np.abs(a.quantities["absorption"] - b.quantities["absorption"]))) for a, b in pairs)
    times = [f"{1e3 * t / CASES:.3f}" for t in (apart, together, whole_apart, whole)]
    gains = f"{apart / together:.1f}", f"{whole_apart / whole:.1f}"
    return f"| {name} | {grid} | {' | '.join([*times[:2], gains[0], *times[2:], gains[1]])} | {off:.0e} |"


def like_layers(pairs: int) -> str:
    """Return the row of a stack of so many like pairs of layers."""
    made = stack(*[layer for _ in range(pairs) for layer in ((FOAM, 0.01), (ALUMINIUM, 1e-3))])
    frequency = np.linspace(100.0, 5000.0, 300)
    together, one = least_seconds(lambda: plane_wave(made, frequency, 45.0), REPEATS)
    with patch("multilayer.response.system._all_but_name", id):
        apart, other = least_seconds(lambda: plane_wave(made, frequency, 45.0), REPEATS)
    off = float(np.max(np.abs(one.absorption - other.absorption)))
    return f"| {2 * pairs} | {1e3 * apart:.0f} | {1e3 * together:.0f} | {apart / together:.1f} | {off:.0e} |"


def main() -> None:
    """Measure and print the page."""
    threads = os.environ.get("OMP_NUM_THREADS", "not set")
    heads = ["responses apart, ms", "together, ms", "gain", "simulation apart, ms", "together, ms", "gain"]
    lines = [
        "# Sweeps",
        "",
        f"{CASES} thicknesses of one layer, plane waves at normal incidence: each case by itself, and up to 50 cases "
        "at a time, whose thickness is an array. Media are evaluated once for all cases of a batch, but for the layer "
        "of which a property is swept.",
        "",
        f"Made by `python -m validation.sweeps`, OMP_NUM_THREADS={threads}, one process, Python "
        f"{platform.python_version()}, numpy {np.__version__}. Processor time for each case, the least of {REPEATS} "
        "runs; ratios, taken in one run, are what to read. *Responses*: from the stacks to all quantities over "
        "frequency; *simulation*: with ratings and the result. *Difference*: the largest of the "
        "absorption.",
        "",
        "| stack | frequencies | " + " | ".join(heads) + " | difference |",
        "|---" * 9 + "|",
        *(row(name, grid) for name in STACKS for grid in FREQUENCIES),
        "",
        "What is left of responses of many frequencies (a third octave has 21) is the arithmetic of every point, and "
        "of simulations what each case has of its own: ratings and text.",
        "",
        "## Layers that are alike",
        "",
        "Foam of 10 mm and aluminium of 1 mm in turns, a plane wave at 45 degrees, 300 frequencies: the matrices of "
        "like layers made once, and of each by itself.",
        "",
        "| layers | apart, ms | once, ms | gain | difference |",
        "|---|---|---|---|---|",
        *(like_layers(pairs) for pairs in (1, 2, 5, 20, 100)),
    ]
    print("\n".join(lines))  # noqa: T201


if __name__ == "__main__":
    main()
