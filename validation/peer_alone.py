"""What the speed comparison asks of multilayer alone; one question per process.

- ``reference``: the diffuse field of (b) by a quadrature far finer than needed;
- ``solve``: the whole solution of (b) beside a bare `numpy.linalg.solve` of as large a system;
- ``layers``: the time of a stack against its number of layers;
- ``memory``: the peak memory of many points at once;
- ``cores``: two threads, or two processes, against one.
"""

from __future__ import annotations

import argparse
import inspect
import json
import math
import resource
import sys
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from peer_case import ANGLES, MAX_ANGLE, Grid, seconds
from peer_multilayer import LAYER_TYPES, alternating, diffuse_solver, partition

from multilayer.response import plane_wave
from multilayer.stack import Stack

SIZES = {"thin plate": 14, "elastic solid": 18}  # 1 + the states of the four layers + 1
LAYER_COUNTS = (5, 20, 50, 200)
PANELS, NODES = 60, 16  # of the reference quadrature
MEMORY_LIMIT = 8 * 1024**3  # bytes; more than this is not tried
WORKERS = 2


def reference(frequency: Any, _repeats: int) -> dict[str, Any]:
    """Return the diffuse transmission loss of (b), dB, and how much it changes with half the angles."""
    found = {}
    for kind in LAYER_TYPES:
        fine, coarse = (diffuse_loss(partition(kind), frequency, nodes) for nodes in (NODES, NODES // 2))
        change = float(np.max(np.abs(fine - coarse)))
        found[kind] = {"values": fine.tolist(), "angles": PANELS * NODES, "change": change}
    return found


def diffuse_loss(stack: Stack, frequency: Any, nodes: int) -> Any:
    """Return the transmission loss for a diffuse field by Gauss's rule on many panels of the angle."""
    x, weights = np.polynomial.legendre.leggauss(nodes)
    width = MAX_ANGLE / PANELS
    angle = (width * (np.arange(PANELS)[:, None] + (1 + x) / 2)).ravel()
    weights = np.tile(weights, PANELS) * np.sin(2 * np.deg2rad(angle))
    blocks = np.array_split(frequency, max(1, len(frequency) // 20))
    loss = np.concatenate([plane_wave(stack, block, angle).transmission_loss for block in blocks])
    return -10 * np.log10(10 ** (-loss / 10) @ weights / weights.sum())


def solve(frequency: Any, repeats: int) -> dict[str, Any]:
    """Return the time per frequency, s, of a solution of (b) and of `numpy.linalg.solve` with matrices at hand."""
    found = {}
    for kind, size in SIZES.items():
        stack, (matrix, right) = partition(kind), _random_system(len(frequency), size)
        actions = {
            "bare": lambda matrix=matrix, right=right: np.linalg.solve(matrix, right),
            "whole": lambda stack=stack: plane_wave(stack, frequency, ANGLES[-1]),
        }
        times = least(actions, repeats)
        found[kind] = {"size": size} | {name: value / len(frequency) for name, value in times.items()}
    return found


def _random_system(count: int, size: int) -> tuple[Any, Any]:
    random = np.random.default_rng(1)
    parts = random.standard_normal((2, count, size, size + 1))
    system = parts[0] + 1j * parts[1]
    return np.ascontiguousarray(system[..., :-1]), np.ascontiguousarray(system[..., -1:])


def layers(frequency: Any, repeats: int) -> dict[str, Any]:
    """Return the time per frequency and layer, s, by the number of layers."""
    stacks = {count: alternating(count) for count in LAYER_COUNTS}
    actions = {
        str(count): lambda stack=stack: plane_wave(stack, frequency, ANGLES[-1]) for count, stack in stacks.items()
    }
    times = least(actions, repeats)
    return {name: value / len(frequency) / int(name) for name, value in times.items()}


def memory(frequency: Any, _repeats: int) -> dict[str, Any]:
    """Return the peak memory, bytes, before and after as many angles as frequencies meet (b) with its solids."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, MEMORY_LIMIT))
    stack, angle = partition("elastic solid"), np.linspace(0, MAX_ANGLE, len(frequency))
    before = _peak_memory()
    try:
        result = plane_wave(stack, frequency, angle)
    except MemoryError:
        return {"points": len(frequency) ** 2, "before": before, "peak": None, "limit": MEMORY_LIMIT}
    assert result.reflection.shape == (len(frequency), len(angle))
    return {"points": len(frequency) ** 2, "before": before, "peak": _peak_memory(), "limit": MEMORY_LIMIT}


def _peak_memory() -> int:
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


def cores(frequency: Any, repeats: int) -> dict[str, Any]:
    """Return the time, s, of (b) at 50 angles on one core and by every way to use two that there is."""
    stack, angle = partition("elastic solid"), np.linspace(0, MAX_ANGLE, 50)
    spawn = get_context("spawn")
    with ThreadPoolExecutor(WORKERS) as threads, ProcessPoolExecutor(WORKERS, mp_context=spawn) as processes:
        actions = {
            "one": lambda: plane_wave(stack, frequency, angle),
            "two threads of the caller, half of the frequencies each": lambda: halves(threads, stack, frequency, angle),
            "two processes of the caller, the same": lambda: halves(processes, stack, frequency, angle),
        }
        return least(actions | own_ways(stack, frequency, angle), repeats)


def halves(pool: Executor, stack: Stack, frequency: Any, angle: Any) -> list[Any]:
    """Return the responses to each worker's share of the frequencies."""
    shares = np.array_split(frequency, WORKERS)
    return list(pool.map(plane_wave, [stack] * WORKERS, shares, [angle] * WORKERS))


def own_ways(stack: Stack, frequency: Any, angle: Any) -> dict[str, Callable[[], object]]:
    """Return multilayer's own ways to use two cores; none as long as its solvers take no ``workers``."""
    found: dict[str, Callable[[], object]] = {}
    if "workers" in inspect.signature(plane_wave).parameters:
        found["plane_wave(..., workers=2)"] = lambda: plane_wave(stack, frequency, angle, workers=WORKERS)
    diffuse = diffuse_solver()
    if diffuse and "workers" in inspect.signature(diffuse).parameters:
        found["one: diffuse_field"] = lambda: diffuse(stack, frequency, max_angle=MAX_ANGLE)
        found["diffuse_field(..., workers=2)"] = lambda: diffuse(stack, frequency, max_angle=MAX_ANGLE, workers=WORKERS)
    return found


def least(actions: dict[str, Callable[[], object]], repeats: int) -> dict[str, float]:
    """Return the least time of every action, s; they take turns, and the first turn is not timed."""
    best = dict.fromkeys(actions, math.inf)
    for turn in range(repeats + 1):
        for name, action in actions.items():
            taken = seconds(action)
            best[name] = min(best[name], taken) if turn else math.inf
    return best


def main() -> None:
    """Answer the question on the command line."""
    questions = {action.__name__: action for action in (reference, solve, layers, memory, cores)}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path)
    parser.add_argument("question", choices=questions)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--frequencies", type=int, default=1000)
    options = parser.parse_args()
    frequency = np.array(Grid.even(options.frequencies, 2).frequency)
    options.output.write_text(json.dumps(questions[options.question](frequency, options.repeats)))


if __name__ == "__main__":
    main()
