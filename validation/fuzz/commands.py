"""Virtual rigs, campaigns and diagnoses of tubes, spoiled: what `check` lets pass goes through `rig` or `diagnose`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from multilayer.cli.rig import _make
from multilayer.config.validate import placed_in
from multilayer.diagnosis.diagnose import chosen_effects, diagnose_campaign
from multilayer.diagnosis.tube.diagnose import diagnose_tube
from multilayer.diagnosis.tube.file import load_diagnosis
from multilayer.fits.sources import open_source
from multilayer.json_text import json_text
from multilayer.kinds import kind_of
from multilayer.rig.file import load_rig
from multilayer.rig.writer import write_campaign
from validation.fuzz.watch import PASSED, UnsoundError
from validation.fuzz.yaml_mutants import YamlTarget

MOST_BURSTS = 12  # of a virtual rig, repeats counted; what takes longer is not computed
_KINDS = ("rig", "campaign", "diagnose")
_EFFECT = "sensor_mass"  # of a campaign; all would take a minute


def command_target(files: list[Path], seed: int) -> YamlTarget:
    """Return the target of all files of a corpus that `rig` and `diagnose` take, rigs made small."""
    taken = [file for file in files if kind_of(file).name in _KINDS]
    for file in taken:
        text = file.read_text(encoding="utf-8")
        text = text.replace("[12.5 mm, 25 mm]", "[25 mm]").replace("to: 1000 Hz", "to: 400 Hz")
        file.write_text(text.replace("repeats: 3", "repeats: 2").replace("effects: all", "effects: [rear_air_gap]"))
    return YamlTarget(taken, seed, run=_run)


def _run(file: Path) -> str:
    if kind_of(file).name == "rig":
        _rig(file)
    else:
        _diagnose(file)
    return PASSED


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
            tube = load_diagnosis(source.document)
            result = diagnose_tube(tube, file.stem, tube.chosen())
        else:
            job = source.campaign_job(source.settings())
            result = diagnose_campaign(
                job.campaign, job.recordings, chosen_effects([_EFFECT]), calibration=job.calibration
            )
        json_text(result.record)
