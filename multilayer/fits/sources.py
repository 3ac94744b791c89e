"""From what a user names to a job that can run: files are opened once, all is read before anything is computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from pydantic import ValidationError

from multilayer.config.kinds import FIT_FILE, TITLES, kind_of_data
from multilayer.config.validate import validate
from multilayer.config.yaml12 import Document, read_yaml
from multilayer.errors import InputError, Problem, suggest
from multilayer.files import exists
from multilayer.fits.methods import METHODS
from multilayer.fits.settings import FitSettings, RigModel
from multilayer.measurements.campaign import campaign_file, load_calibration, load_campaign, load_recordings
from multilayer.measurements.description import FILE_NAME, Campaign
from multilayer.signals.calibration import Calibration
from multilayer.signals.recording import Recording

if TYPE_CHECKING:
    from multilayer.experiments.stacks.file import StackFitFile
    from multilayer.experiments.two_plate.burst import BurstData

_OF_STACKS = ("stack-fit", "diagnose")
_OF_CAMPAIGNS = ("campaign", "fit", "calibration", "rig")


@dataclass(frozen=True)
class FitJob:
    """A campaign to fit, with all input."""

    campaign: Campaign
    recordings: Mapping[tuple[str, float], Recording]
    settings: FitSettings
    calibration: Calibration | None

    @property
    def name(self) -> str:
        """Name of the campaign: that of its folder."""
        return self.campaign.folder.resolve().name

    @cached_property
    def bursts(self) -> list[BurstData]:
        """The measured signals, averaged over repeats and calibrated, in the order of the campaign."""
        from multilayer.fits.burst.fit import burst_data

        return burst_data(self.campaign, self.recordings, self.calibration)

    def plain_settings(self) -> dict[str, Any]:
        """Return the settings as plain data, for results."""
        return self.settings.model_dump(mode="json", exclude_none=True)


@dataclass(frozen=True)
class StackJob:
    """Stacks, their measurements and unknowns, and what the fit is called."""

    name: str
    file: StackFitFile


@dataclass(frozen=True)
class Source:
    """A folder or a file that a user names, opened.

    Attributes
    ----------
    path : Path
        As it is named.
    document : Document
        What the file holds; of a folder its ``fit.yaml``, or else its ``campaign.yaml``.
    kind : str
        Of that file, see `multilayer.config.kinds`; empty where nothing tells.
    """

    path: Path
    document: Document
    kind: str

    @property
    def of_stacks(self) -> bool:
        """Whether it is about stacks, and not about a campaign."""
        return self.kind in _OF_STACKS

    @property
    def is_measured(self) -> bool:
        """Whether it is a campaign, or stacks with their measurements: not a stack or a simulation."""
        return self.kind in (*_OF_STACKS, *_OF_CAMPAIGNS)

    def settings(self, options: Mapping[str, str | None] | None = None) -> FitSettings:
        """Return the settings of a fit of a campaign.

        Parameters
        ----------
        options : mapping, optional
            `method` and `model` in place of those in the fit file, unless None.

        Raises
        ------
        InputError
            With every mistake found.
        """
        if self.kind in ("stack", "simulation"):
            text = (
                f"this is a {TITLES[self.kind]}; a fit needs a campaign folder or a fit file, a diagnosis one of these "
            )
            text += "or stacks with their measurements, as examples/foam_tube; `multilayer simulate` takes this one"
            raise InputError(f"{self.document.file}: {text}")
        if self.of_stacks:
            text = "this is a stack-fit file; fit it by itself, without campaigns beside it"
            raise InputError(f"{self.document.file}: {text}")
        settings = FitSettings() if self._is_described else validate(self.document, FitSettings, "fit")
        return _with_options(settings, options or {})

    def campaign_job(self, settings: FitSettings) -> FitJob:
        """Read a campaign with all its signals, and what else the settings name.

        Raises
        ------
        InputError
            With every mistake found.
        """
        described = self.document if self._is_described else self._beside("campaign", settings.campaign)
        campaign = load_campaign(described)
        calibration = None
        if settings.calibration is not None:
            calibration = load_calibration(self._beside("calibration", settings.calibration))
        return FitJob(campaign, load_recordings(campaign), settings, calibration)

    def stack_job(self) -> StackJob:
        """Read stacks and their measurements.

        Raises
        ------
        InputError
            With every mistake found.
        """
        from multilayer.experiments.stacks.file import load_stack_fit, name_of

        return StackJob(name_of(self.path), load_stack_fit(self.document))

    @property
    def _is_described(self) -> bool:
        """Whether it describes the campaign itself, without settings of a fit."""
        return self.kind in ("campaign", "calibration", "rig")

    def _beside(self, field: str, named: Path) -> Path:
        """Return a path that a fit file names; an error that points into the file when there is nothing."""
        file = self.document.file
        path = file.parent / named
        if not exists(path):
            text = f"there is no {path}; the path is relative to this file"
            raise InputError(Problem(text, field, file, *self.document.position((field,))))
        try:
            return campaign_file(path)
        except InputError as error:
            place = self.document.position((field,))
            raise InputError(Problem(str(error), field, file, *place)) from None


def open_source(path: Path) -> Source:
    """Open a fit file, a campaign folder, a campaign file or a stack-fit file.

    Parameters
    ----------
    path : Path
        A folder is taken by its ``fit.yaml`` where it has one, otherwise by its ``campaign.yaml``.

    Raises
    ------
    InputError
        When there is nothing, or it cannot be read.
    """
    if not exists(path):
        raise InputError(f"{path}: there is no such file or folder; name a folder, or a stack, campaign or fit file")
    if path.is_dir() and not (path / FIT_FILE).is_file():
        if not (path / FILE_NAME).is_file():
            raise InputError(Problem(f"holds no {FILE_NAME} and no {FIT_FILE}; name a folder that does", file=path))
        return Source(path, read_yaml(campaign_file(path), keep_problems=True), "campaign")
    file = path / FIT_FILE if path.is_dir() else path
    if file.suffix.lower() not in (".yaml", ".yml"):
        text = "this is no YAML file; name the stack, campaign or fit file that refers to it, or a campaign's folder"
        raise InputError(f"{file}: {text}")
    document = read_yaml(file, keep_problems=True)
    return Source(path, document, kind_of_data(document.data))


def read_fit(source: Path, method: str | None = None, model: str | None = None) -> FitJob:
    """Read a fit file, a campaign folder or a campaign file, and all signals.

    Parameters
    ----------
    source : Path
        See `open_source`.
    method, model : str, optional
        In place of those in the fit file.

    Raises
    ------
    InputError
        With every mistake found.
    """
    opened = open_source(source)
    return opened.campaign_job(opened.settings({"method": method, "model": model}))


def _with_options(settings: FitSettings, options: Mapping[str, str | None]) -> FitSettings:
    """Return the settings with those of the command line in their place."""
    given = {name: value for name, value in options.items() if value is not None}
    choices = {"method": METHODS.names(), "model": get_args(RigModel)}
    for name, value in given.items():
        if value not in choices[name]:
            raise InputError(f"--{name}: there is no {name} '{value}'; {suggest(value, choices[name])}")
    try:
        return settings.changed(**given) if given else settings
    except ValidationError as error:
        places = [".".join(map(str, e["loc"])) for e in error.errors()]
        told = [f"--{place}" if place in given else place for place in places]
        raise InputError([f"{t}: {e['msg']}" for t, e in zip(told, error.errors(), strict=True)]) from None
