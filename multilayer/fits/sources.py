"""From what a user names on the command line to a fit that can run: everything is read before anything is computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from pydantic import ValidationError

from multilayer.config.kinds import FIT_FILE, TITLES, fit_file, kind_of_data
from multilayer.config.validate import read
from multilayer.config.yaml12 import read_yaml
from multilayer.errors import InputError, Problem, suggest
from multilayer.fits.settings import FitSettings, Method, RigModel
from multilayer.measurements.campaign import load_calibration, load_campaign, load_recordings
from multilayer.measurements.description import Campaign
from multilayer.signals.calibration import Calibration
from multilayer.signals.recording import Recording

_OF_STACKS = ("stack-fit", "diagnose")
_CHOICES = {"method": get_args(Method), "model": get_args(RigModel)}


@dataclass(frozen=True)
class FitJob:
    """A fit with all its input."""

    campaign: Campaign
    recordings: Mapping[tuple[str, float], Recording]
    settings: FitSettings
    calibration: Calibration | None


def read_fit(source: Path, method: str | None = None, model: str | None = None) -> FitJob:
    """Read a fit file, a campaign folder or a campaign file, and all signals.

    Parameters
    ----------
    source : Path
        A folder is taken by its ``fit.yaml`` where it has one, otherwise by its ``campaign.yaml``.
    method, model : str, optional
        In place of those in the fit file.

    Raises
    ------
    InputError
        With every mistake found.
    """
    settings, campaign_path = _settings(source)
    settings = _with_options(settings, {"method": method, "model": model})
    campaign = load_campaign(campaign_path)
    calibration = None
    if settings.calibration is not None:
        calibration = load_calibration(_beside(fit_file(source), "calibration", settings.calibration))
    return FitJob(campaign, load_recordings(campaign), settings, calibration)


def _with_options(settings: FitSettings, options: Mapping[str, str | None]) -> FitSettings:
    """Return the settings with those of the command line in their place."""
    given = {name: value for name, value in options.items() if value is not None}
    for name, value in given.items():
        if value not in _CHOICES[name]:
            raise InputError(f"--{name}: there is no {name} '{value}'; {suggest(value, _CHOICES[name])}")
    try:
        return FitSettings.model_validate({**settings.model_dump(), **given})
    except ValidationError as error:
        places = [".".join(map(str, e["loc"])) for e in error.errors()]
        told = [f"--{place}" if place in given else place for place in places]
        raise InputError([f"{t}: {e['msg']}" for t, e in zip(told, error.errors(), strict=True)]) from None


def is_stack_fit(source: Path) -> bool:
    """Tell whether a file, or the ``fit.yaml`` of a folder, is about stacks and not about a campaign."""
    file = fit_file(source)
    if file.suffix not in (".yaml", ".yml") or not file.is_file():
        return False
    try:
        return kind_of_data(read_yaml(file, keep_problems=True).data) in _OF_STACKS
    except InputError:
        return False  # told by whoever reads it next


def _beside(file: Path, field: str, named: Path) -> Path:
    """Return a path that a fit file names; an error that points into the file when there is nothing."""
    path = file.parent / named
    if not path.exists():
        line, column = read_yaml(file).position((field,))
        raise InputError(Problem(f"there is no {path}; the path is relative to this file", field, file, line, column))
    return path


def _settings(source: Path) -> tuple[FitSettings, Path]:
    if not source.exists():
        raise InputError(f"{source}: there is no such file or folder; name a folder, or a stack, campaign or fit file")
    if source.is_dir():
        if not (source / FIT_FILE).is_file():
            return FitSettings(), source
        source = source / FIT_FILE
    if source.suffix not in (".yaml", ".yml"):
        raise InputError(f"{source}: this is no YAML file; name a campaign folder, its campaign.yaml, or a fit file")
    kind = kind_of_data(read_yaml(source, keep_problems=True).data)
    if kind in ("campaign", "calibration", "rig"):
        return FitSettings(), source
    if kind in ("stack", "simulation"):
        raise InputError(f"{source}: this is a {TITLES[kind]}; a fit needs a campaign folder or a fit file")
    if kind in _OF_STACKS:
        raise InputError(f"{source}: this is a stack-fit file; fit it by itself, without campaigns beside it")
    settings = read(source, FitSettings, "fit")
    return settings, _beside(source, "campaign", settings.campaign)
