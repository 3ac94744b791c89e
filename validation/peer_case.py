"""What every program of the speed comparison solves, and the clock they share.

Each ``peer_*.py`` script runs in the environment of its own program, started by `validation.peers`, so this file
needs nothing but the standard library. Frequencies are in Hz, everything else in SI.
"""

from __future__ import annotations

import argparse
import json
import math
import platform
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

# Air as pymls has it built in; the other programs are given the same
AIR: dict[str, float] = {
    "density": 1.213,
    "sound_speed": math.sqrt(1.4 * 101325.0 / 1.213),
    "viscosity": 1.839e-5,
    "prandtl": 0.71,
    "heat_capacity_ratio": 1.4,
    "pressure": 101325.0,
}
FOAM: dict[str, float] = {
    "porosity": 0.98,
    "flow_resistivity": 15e3,
    "tortuosity": 1.05,
    "viscous_length": 100e-6,
    "thermal_length": 250e-6,
    "frame_density": 25.0,
    "young_modulus": 140e3,
    "poisson_ratio": 0.3,
    "loss_factor": 0.1,
}
ALUMINIUM: dict[str, float] = {"density": 2700.0, "young_modulus": 7e10, "poisson_ratio": 0.3, "loss_factor": 0.01}
FOAM_THICKNESS, GAP_THICKNESS, PLATE_THICKNESS = 50e-3, 20e-3, 1e-3
ANGLES = (0.0, 45.0)  # degrees, of case (a); case (b) takes the last
MAX_ANGLE = 78.0  # degrees, of the diffuse field

Case = Callable[[], Sequence[Any]]


@dataclass(frozen=True)
class Grid:
    """The frequencies: all of them, and the few for a program whose diffuse field takes long."""

    frequency: list[float]
    few: list[float]

    @classmethod
    def even(cls, count: int, few: int) -> Grid:
        """Return `count` frequencies from 100 to 5000 Hz, and `few` spread over them."""
        frequency = [100 + 4900 * i / (count - 1) for i in range(count)]
        return cls(frequency, [frequency[round(i * (count - 1) / (few - 1))] for i in range(few)])


def main(packages: Sequence[str], cases: Callable[[Grid], Mapping[str, Case]]) -> None:
    """Solve and time the cases of one program as the command line asks, and write what came out as JSON."""
    parser = argparse.ArgumentParser()
    parser.add_argument("output", type=Path)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--frequencies", type=int, default=1000)
    parser.add_argument("--few", type=int, default=20)
    options = parser.parse_args()
    found = time_cases(cases(Grid.even(options.frequencies, options.few)), options.repeats)
    versions = {name: version(name) for name in (*packages, "numpy")}
    options.output.write_text(json.dumps({"python": platform.python_version(), "versions": versions, "cases": found}))


def time_cases(cases: Mapping[str, Case], repeats: int) -> dict[str, dict[str, Any]]:
    """Return the results of every case and its least time per frequency, s; the first run is not timed.

    The cases take turns, so that a slow moment of the machine does not fall on one of them alone.
    """
    results = {name: list(case()) for name, case in cases.items()}
    least = dict.fromkeys(cases, math.inf)
    for _ in range(repeats):
        for name, case in cases.items():
            least[name] = min(least[name], seconds(case))
    return {
        name: {"seconds": least[name] / len(values), "values": [_plain(value) for value in values]}
        for name, values in results.items()
    }


def seconds(action: Callable[[], object]) -> float:
    """Return how long `action` takes, s."""
    start = time.perf_counter()
    action()
    return time.perf_counter() - start


def _plain(value: complex) -> list[float]:
    return [complex(value).real, complex(value).imag]
