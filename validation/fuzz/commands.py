"""Spoiled files whose commands take long: what `check` lets pass goes through `rig`, `diagnose` or `optimise`.

What of stacks and simulations passes goes through `export`, as one of the tables or as cards.
"""

from __future__ import annotations

from pathlib import Path
from zlib import crc32

import numpy as np

from multilayer.cli.rig import _make
from multilayer.config.validate import placed_in, validate
from multilayer.config.yaml12 import parse_yaml
from multilayer.diagnosis.diagnose import chosen_effects, diagnose_campaign
from multilayer.diagnosis.file import load_diagnosis
from multilayer.diagnosis.levels.diagnose import diagnose_levels
from multilayer.diagnosis.tube.diagnose import diagnose_tube
from multilayer.exchange.nastran import FRAME_DENSITIES, poroelastic_cards
from multilayer.exchange.quantities import KINDS, Wanted, export
from multilayer.fits.sources import open_source
from multilayer.json_text import json_text
from multilayer.kinds import kind_of
from multilayer.optimisation.file import SearchSettings, load_optimisation
from multilayer.optimisation.run import optimise
from multilayer.rig.file import load_rig
from multilayer.rig.writer import write_campaign
from multilayer.simulation.bands import grid_of
from multilayer.simulation.file import SimulationFile, load_simulation
from multilayer.simulation.run import plan
from multilayer.stack import load_stack
from validation.fuzz.watch import PASSED, UnsoundError
from validation.fuzz.yaml_mutants import MOST_POINTS, YamlTarget

MOST_BURSTS = 12  # of a virtual rig, repeats counted; what takes longer is not computed
MOST_VARIANTS, MOST_DESIGN_POINTS = 8, 12  # of an optimisation, likewise
_KINDS = ("rig", "campaign", "diagnose", "optimisation")
_EXPORTED = ("stack", "simulation")
_EFFECT = "sensor_mass"  # of a campaign; all would take a minute


def command_target(files: list[Path], seed: int, deep: float = 1.0) -> YamlTarget:
    """Return the target of all files of a corpus that these commands take, rigs made small."""
    taken = [file for file in files if kind_of(file).name in (*_KINDS, *_EXPORTED)]
    for file in taken:
        text = file.read_text(encoding="utf-8")
        text = text.replace("[12.5 mm, 25 mm]", "[25 mm]").replace("to: 1000 Hz", "to: 400 Hz")
        file.write_text(text.replace("repeats: 3", "repeats: 2").replace("effects: all", "effects: [rear_air_gap]"))
    return YamlTarget(taken, seed, deep, run=_run)


def _run(file: Path) -> str:
    kind = kind_of(file).name
    if kind == "rig":
        _rig(file)
    elif kind == "optimisation":
        _optimise(file)
    elif kind in _EXPORTED:
        _export(file)
    else:
        _diagnose(file)
    return PASSED


def _optimise(file: Path) -> None:
    read = load_optimisation(file).model_copy(update={"search": SearchSettings(starts=1)})
    if read.space.count > MOST_VARIANTS or np.ravel(grid_of(read.frequency).points).size > MOST_DESIGN_POINTS:
        return
    with placed_in(file):
        result = optimise(read, name=file.stem)
        for design in result.designs:
            if not np.isfinite(design.goals).all():
                raise UnsoundError("a goal of a design is no number")
        result.to_csv()
        json_text(result.to_dict())
        for text in result.files.values():  # what is written must be a simulation again
            validate(parse_yaml(text, file), SimulationFile, "simulation", context={"folder": file.parent})


def _export(file: Path) -> None:
    """Export as one of the kinds: which one depends on the text."""
    kinds = (*KINDS, *FRAME_DENSITIES)
    kind = kinds[crc32(file.read_bytes()) % len(kinds)]
    with placed_in(file):
        if kind in FRAME_DENSITIES:
            poroelastic_cards(load_stack(file), kind, name=file.stem)
            return
        simulation = load_simulation(file).cases[0].simulation
        if sum(task.frequency.size * len(task.stack.layers) for task in plan(simulation).tasks) > MOST_POINTS:
            return
        table = export(simulation, Wanted(kind), file.stem)
        for suffix in (".csv", ".mat", ".h5", ".uff"):
            table.content(file.with_suffix(suffix))


def _rig(file: Path) -> None:
    settings = load_rig(file)
    if len(settings.mountings) * len(settings.burst_frequencies) * settings.repeats > MOST_BURSTS:
        return
    with placed_in(file):
        made = _make(file, settings, None, 1)
        for recording in made.recordings.values():
            if not (np.isfinite(recording.base).all() and np.isfinite(recording.top).all()):
                raise UnsoundError("a sample is no number")
        write_campaign(made, file.with_suffix(""), quiet=False)


def _diagnose(file: Path) -> None:
    with placed_in(file):
        source = open_source(file)
        if source.of_stacks:
            stacks = load_diagnosis(source.document)
            diagnose = diagnose_levels if stacks.of_levels else diagnose_tube
            result = diagnose(stacks, file.stem, stacks.chosen())
        else:
            job = source.campaign_job(source.settings())
            result = diagnose_campaign(
                job.campaign, job.recordings, chosen_effects([_EFFECT]), calibration=job.calibration
            )
        json_text(result.record)
