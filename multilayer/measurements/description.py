"""What ``campaign.yaml`` says of a campaign on the two-plate rig, or of a calibration: format version 1."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, PrivateAttr, model_validator

from multilayer.errors import InputError, Problem
from multilayer.measurements.implausible import implausible_fields
from multilayer.models import Model, refuse
from multilayer.units import (
    Acceleration,
    Density,
    Frequency,
    Length,
    NonNegative,
    PoissonRatio,
    PositiveRatio,
    Pressure,
    Ratio,
    Unit,
)

FILE_NAME = "campaign.yaml"
FILL_IN = "FILL_IN"  # stands where an imported campaign still lacks what the experimenter knows

DataPath = tuple[str | int, ...]


def _inside_folder(name: str) -> str:
    posix, windows = PurePosixPath(name), PureWindowsPath(name)
    if posix.is_absolute() or windows.drive or windows.root or ".." in windows.parts:
        raise ValueError(f"'{name}' leads out of the campaign's folder; write a path relative to it, without '..'")
    if not windows.parts:
        raise ValueError("the name of a file is missing")
    return name


DataFile = Annotated[str, AfterValidator(_inside_folder)]
TimeDeviation = Annotated[float, NonNegative, Unit("s")]
LengthDeviation = Annotated[float, NonNegative, Unit("m")]


class Specimen(Model):
    """What is known of the foam: density and Poisson's ratio."""

    density: Density
    poisson_ratio: PoissonRatio


class TopPlate(Model):
    """Material of the top plate; its radius is the specimen's, its thickness the configuration's."""

    density: Density
    young_modulus: Pressure
    poisson_ratio: PoissonRatio


class BasePlate(TopPlate):
    """The support plate: its material and thickness."""

    thickness: Length


class Uncertainty(Model):
    """Standard deviations that the laboratory states for its own measurement.

    `channel_gain`, `remount_gain`, `density` and `top_plate_mass` are relative; `channel_delay` in s,
    `thickness` in m. Samples and plates are measured piece by piece: each sample, by its height and radius, and each
    top plate, by its thickness and radius, has an error of its own; so has each mounting.
    """

    channel_gain: Ratio = 0.0
    channel_delay: TimeDeviation = 0.0
    remount_gain: Ratio = 0.0
    thickness: LengthDeviation = 0.0
    density: Ratio = 0.0
    top_plate_mass: Ratio = 0.0

    @property
    def unstated(self) -> tuple[str, ...]:
        """Names of what is not stated, not even as 0."""
        return tuple(name for name in type(self).model_fields if name not in self.model_fields_set)


# of a careful laboratory: what a diagnosis takes for what a campaign does not state
USUAL_UNCERTAINTY = Uncertainty(
    channel_gain=0.003, channel_delay=1e-6, remount_gain=0.001, thickness=5e-5, density=0.01, top_plate_mass=0.002
)


class BurstShape(Model):
    """The excitation: cycles under a window, and the base's rms acceleration over the burst's duration."""

    cycles: PositiveRatio
    window: Literal["hann"] = "hann"
    level_rms: Acceleration


class Burst(Model):
    """One burst: its frequency and the file of its recording, relative to the campaign's folder."""

    frequency: Frequency
    file: DataFile


class Configuration(Model):
    """One mounting: thickness and radius of the specimen, thickness of the top plate, and its bursts."""

    name: Annotated[str, Field(min_length=1)]
    specimen_thickness: Length
    top_plate_thickness: Length
    specimen_radius: Length
    bursts: Annotated[tuple[Burst, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _no_frequency_twice(self) -> Self:
        refuse(self, _twice([burst.frequency for burst in self.bursts], "bursts", "frequency", " Hz"))
        return self


class Description(Model):
    """What both kinds of campaign share: a file in a folder, a sampling rate, and the shape of the bursts."""

    version: Literal[1]
    sampling_rate: Frequency
    burst: BurstShape
    _file: Path = PrivateAttr(default=Path(FILE_NAME))

    def placed(self, file: Path) -> Self:
        """Return the same description, read from `file`."""
        copy = self.model_copy()
        copy._file = file
        return copy

    @property
    def file(self) -> Path:
        """The YAML file the campaign was read from."""
        return self._file

    @property
    def folder(self) -> Path:
        """The folder that data files are relative to."""
        return self._file.parent


class Campaign(Description):
    """A campaign on the two-plate rig, as the experimenter describes it."""

    rig: Literal["shaker-two-plate"]
    specimen: Specimen
    top_plate: TopPlate
    base_plate: BasePlate
    uncertainty: Uncertainty = Uncertainty()
    configurations: Annotated[tuple[Configuration, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = _twice([configuration.name for configuration in self.configurations], "configurations", "name")
        lists = [(("configurations", i), c.bursts) for i, c in enumerate(self.configurations)]
        refuse(self, [*names, *_too_fast(self.sampling_rate, lists)])
        return self

    def implausible(self) -> Iterator[tuple[DataPath, str]]:
        """Give path and text of values that are allowed, and hardly ever meant."""
        yield from implausible_fields(self)

    def configuration(self, name: str) -> Configuration:
        """Return the configuration of that name.

        Raises
        ------
        InputError
            When there is none; the message lists those there are.
        """
        for configuration in self.configurations:
            if configuration.name == name:
                return configuration
        names = ", ".join(configuration.name for configuration in self.configurations)
        raise InputError(Problem(f"there is no configuration '{name}'; there are: {names}", file=self.file))


class CalibrationCampaign(Description):
    """Bursts with both accelerometers at one spot of the support plate."""

    rig: Literal["calibration"]
    bursts: Annotated[tuple[Burst, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        twice = _twice([burst.frequency for burst in self.bursts], "bursts", "frequency", " Hz")
        refuse(self, [*twice, *_too_fast(self.sampling_rate, [((), self.bursts)])])
        return self


def _twice(values: Sequence[Any], field: str, part: str, unit: str = "") -> Iterator[tuple[DataPath, str, Any]]:
    seen = set[Any]()
    for i, value in enumerate(values):
        if value in seen:
            shown = f"{value:g}{unit}" if isinstance(value, float) else f"'{value}'"
            yield (field, i, part), f"{shown} is there twice; each {part} of {field} must be another", value
        seen.add(value)


def _too_fast(
    sampling_rate: float, lists: Iterable[tuple[DataPath, tuple[Burst, ...]]]
) -> Iterator[tuple[DataPath, str, Any]]:
    for path, bursts in lists:
        for i, burst in enumerate(bursts):
            if burst.frequency >= 0.5 * sampling_rate:
                text = f"{burst.frequency:g} Hz is not below half of the sampling_rate of {sampling_rate:g} Hz"
                yield (*path, "bursts", i, "frequency"), text, burst.frequency
