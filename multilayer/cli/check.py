"""``multilayer check``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def check(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="Stack, campaign, fit, rig or tube files, or folders.")
    ],
) -> None:
    """Read files without running anything, and report every mistake with its line and column.

    Signals of campaigns are read and checked as well. Exit status 2 when anything is wrong.

    Example: multilayer check examples/three_layers.yaml examples/foam_b
    """
    from multilayer.errors import InputError, Problem

    problems: list[str | Problem] = []
    for file in files:
        try:
            kind = _read(file)
        except InputError as error:
            problems += error.problems
        else:
            typer.echo(f"{file}: a {kind} without mistakes")
    if problems:
        raise InputError(problems)


def _read(source: Path) -> str:
    """Read any input file or folder and say what it is."""
    from multilayer.config.yaml12 import read_yaml
    from multilayer.inverse.sources import is_stack_fit, read_fit
    from multilayer.measurements.campaign import load_calibration
    from multilayer.simulation.file import load_simulation
    from multilayer.stack import SIMULATION_KEYS, load_stack
    from multilayer.tube.file import is_tube

    if is_tube(source) or is_stack_fit(source):
        return _tube(source) if is_tube(source) else _stacks(source)
    data = read_yaml(source, keep_problems=True).data if source.is_file() else None
    if isinstance(data, dict) and "layers" in data:
        if SIMULATION_KEYS.isdisjoint(data):
            load_stack(source)
            return "stack"
        cases = len(load_simulation(source).cases)
        return "simulation of one case" if cases == 1 else f"simulation of {cases} cases"
    rig = data.get("rig") if isinstance(data, dict) else None
    if rig == "calibration":
        load_calibration(source)
        return "calibration"
    if rig == "two-plate":
        from multilayer.rig.file import load_rig  # heavy: finite elements

        return f"virtual rig of {len(load_rig(source).mountings)} configurations"
    return f"campaign of {len(read_fit(source).recordings)} bursts"


def _tube(source: Path) -> str:
    """Read a tube file and its data."""
    from multilayer.tube.evaluate import evaluate

    return f"tube measurement at {len(evaluate(source).frequency)} frequencies"


def _stacks(source: Path) -> str:
    """Read a file about stacks and what was measured of them."""
    from multilayer.diagnosis.tube.file import is_diagnosis, load_diagnosis
    from multilayer.inverse.stack_file import load_stack_fit

    kind, load = ("diagnosis", load_diagnosis) if is_diagnosis(source) else ("stack fit", load_stack_fit)
    n = len(load(source).measurements)
    return f"{kind} of one measurement" if n == 1 else f"{kind} of {n} measurements"
