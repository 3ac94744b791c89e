"""The tube file: the tube, its microphones, and the files of raw data; format version 1."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from multilayer.config.validate import validate
from multilayer.config.yaml12 import Document, read_yaml
from multilayer.errors import InputError, Problem, show
from multilayer.files import exists
from multilayer.measurements.leaves import leaves
from multilayer.models import Model, refuse
from multilayer.stack import Ambient
from multilayer.units import Duration, Frequency, Length, Unit, asked_back

FILE_NAME = "tube.yaml"
Position = Annotated[float, Unit("m")]
_FARTHEST = 5.0  # m, from a sample to its microphones
_METHODS = "two_microphones, four_microphones"


class Source(Model):
    """Transfer functions of one measurement: from a table, or from signals over time.

    Attributes
    ----------
    file : Path, optional
        A table, as text or in another format with a reader of `multilayer.readers`, with `frequency_hz` and, for two
        microphones, `h12_re` and `h12_im`: channel 2 over channel 1, that is the pressure at the microphone nearer to
        the sample over that at the farther one, and where they are exchanged the farther over the nearer one; for four,
        `h1_re`, `h1_im` to `h4_im`, over any common reference (without `h1` that is the first microphone).
    recording : Path, optional
        A file that a reader of `multilayer.readers` takes.
    channels : tuple of str
        Of a recording, one for each microphone: from the source to the sample and beyond; for a calibration, and where
        microphones are exchanged, the same channels in the same order as for the measurement.
    segment : float
        Of Welch's method, s: 1/segment is the step in frequency.
    sampling_rate : float, optional
        Of a recording that does not say, Hz.
    """

    file: Path | None = None
    recording: Path | None = None
    channels: tuple[str, ...] = ()
    segment: Duration = 0.2
    sampling_rate: Frequency | None = None

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if (self.file is None) == (self.recording is None):
            refuse(
                self, [((), "give either 'file', a table of transfer functions, or 'recording' and 'channels'", None)]
            )
        if self.recording is not None and not self.channels:
            text = "a recording needs 'channels': one for each microphone, source side first"
            refuse(self, [((), f"{text}; of exchanged microphones in the same order as before", None)])
        return self


class Section(Model):
    """The tube's cross section, and the attenuation of waves along it.

    Attributes
    ----------
    diameter : float, optional
        Of a circular tube, m.
    width, height : float, optional
        Of a rectangular one, m.
    attenuation : {"none", "iso", "kirchhoff"}
        None, that of ISO 10534-2, or that of viscosity and heat at the wall.
    """

    diameter: Length | None = None
    width: Length | None = None
    height: Length | None = None
    attenuation: Literal["none", "iso", "kirchhoff"] = "none"

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        rectangular = (self.width is not None, self.height is not None)
        if (self.diameter is not None) == any(rectangular) or any(rectangular) != all(rectangular):
            refuse(self, [((), "give the 'diameter' of a circular tube, or 'width' and 'height' of another", None)])
        return self

    @property
    def widest(self) -> float:
        """Diameter or longer side, m."""
        return self.diameter if self.diameter is not None else max(self.width or 0.0, self.height or 0.0)

    @property
    def hydraulic_diameter(self) -> float:
        """Four times the area over the perimeter, m."""
        if self.diameter is not None:
            return self.diameter
        width, height = self.width or 0.0, self.height or 0.0
        return 2 * width * height / (width + height)


class TubeFile(Model):
    """Fields that both methods share.

    Attributes
    ----------
    start, to : float, optional
        First (`from`) and last frequency wanted, Hz.
    keep_outside : bool
        Whether frequencies outside of the working range are kept; a column `in_range` tells them.
    """

    version: Literal[1]
    ambient: Ambient = Ambient()
    tube: Section
    start: Annotated[Frequency | None, Field(alias="from")] = None
    to: Frequency | None = None
    keep_outside: bool = False

    @model_validator(mode="after")
    def _rising(self) -> Self:
        if self.start is not None and self.to is not None and self.start > self.to:
            text = f"the last frequency wanted, {self.to:g} Hz, lies below the first, 'from', {self.start:g} Hz"
            refuse(self, [(("to",), f"{text}; exchange them", self.to)])
        return self

    def implausible(self) -> Iterator[tuple[tuple[str | int, ...], str]]:
        """Give path and text of values that are allowed, and hardly ever meant."""
        for field, text in self.ambient.implausible():
            yield ("ambient", field), text


class Switched(Model):
    """A calibration made once: the same sample, with the microphones at their places and exchanged.

    Attributes
    ----------
    straight, exchanged : Source
        The same channels in the same order as in the measurement: a microphone keeps its channel.
    """

    straight: Source
    exchanged: Source

    @model_validator(mode="after")
    def _same_order(self) -> Self:
        refuse(self, _turned(("exchanged",), self.exchanged, "straight", self.straight))
        return self


def _turned(path: tuple[str, ...], source: Source, named: str, first: Source) -> list[tuple[Any, str, Any]]:
    """Return the mistake of channels that are those of another source the other way round, if it is made."""
    if source.channels == first.channels or source.channels != first.channels[::-1]:
        return []
    order = f"write the same order, {show(list(first.channels))}: a microphone keeps its channel when it changes places"
    text = f"these are the channels of '{named}' the other way round; {order}"
    return [((*path, "channels"), text, source.channels)]


class TwoMicrophones(TubeFile):
    """Reflection by ISO 10534-2.

    Attributes
    ----------
    spacing : float
        Between the microphones, m.
    distance : float
        From the sample's face to the nearer microphone, m.
    measurement : Source
    exchanged : Source, optional
        The same measurement with the two microphones exchanged: the same channels in the same order.
    calibration : Switched, optional
        In place of `exchanged`.
    """

    method: Literal["two_microphones"]
    spacing: Length
    distance: Length
    measurement: Source
    exchanged: Source | None = None
    calibration: Switched | None = None

    def implausible(self) -> Iterator[tuple[tuple[str | int, ...], str]]:
        """Give path and text of values that are allowed, and hardly ever meant."""
        yield from super().implausible()
        if self.distance > _FARTHEST:
            yield ("distance",), asked_back("a distance", self.distance, "m", "mm")

    @model_validator(mode="after")
    def _one_calibration(self) -> Self:
        if self.exchanged is not None and self.calibration is not None:
            refuse(self, [(("calibration",), "give either 'exchanged' or 'calibration': each removes the same", None)])
        return self

    @model_validator(mode="after")
    def _same_order(self) -> Self:
        if self.exchanged is not None:
            refuse(self, _turned(("exchanged",), self.exchanged, "measurement", self.measurement))
        if self.calibration is not None:
            straight = self.calibration.straight
            refuse(self, _turned(("calibration", "straight"), straight, "measurement", self.measurement))
        return self


class FourMicrophones(TubeFile):
    """Transmission by ASTM E2611.

    Attributes
    ----------
    positions : tuple of 4 float
        Of the microphones, m from the sample's front face: two negative ones, two behind the sample.
    thickness : float
        Of the sample, m.
    loads : tuple of Source
        One, for a sample that looks the same from both sides, or two, with different terminations of the tube.
    calibration : Source, optional
        Transfer functions of the microphones at one place, over the same reference: the same channels in the same
        order as in `loads`.
    """

    method: Literal["four_microphones"]
    positions: tuple[Position, Position, Position, Position]
    thickness: Length
    loads: Annotated[tuple[Source, ...], Field(min_length=1, max_length=2)]
    calibration: Source | None = None

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        a, b, c, d = self.positions
        if not (a < b <= 0 and self.thickness <= c < d):
            wanted = "two rising positions ahead of the front face (negative), two rising ones behind the thickness"
            refuse(self, [(("positions",), f"{show(list(self.positions))} is not allowed; write {wanted}", None)])
        return self


TubeMeasurement = Annotated[TwoMicrophones | FourMicrophones, Field(discriminator="method")]
_MODELS: dict[Any, type[TwoMicrophones] | type[FourMicrophones]] = {
    "two_microphones": TwoMicrophones,
    "four_microphones": FourMicrophones,
}


def tube_file(source: Path) -> Path:
    """Return the path of a tube file: the source itself, or the ``tube.yaml`` of a folder."""
    return source / FILE_NAME if source.is_dir() else source


def load_tube(path: Path) -> TwoMicrophones | FourMicrophones:
    """Read a tube file; of its data only whether they are there.

    Raises
    ------
    InputError
        With every mistake, at its line and column.
    """
    document = read_yaml(path, keep_problems=True)
    data = document.data
    method = data.get("method") if isinstance(data, dict) else "two_microphones"  # whatever it lacks, `validate` says
    if not isinstance(method, str) or method not in _MODELS:
        message = f"{show(method)} is not allowed; allowed: {_METHODS}"
        raise InputError(Problem(message, "method", path, *document.position(("method",))))
    file = validate(document, _MODELS[method], "tube")
    if gone := list(_gone(file, document)):
        raise InputError(gone)
    return file


def _gone(file: TubeFile, document: Document) -> Iterator[Problem]:
    """Give a problem for every file of data that is not there."""
    for path, named in leaves(file):
        if isinstance(named, Path) and not exists(there := document.file.parent / named):
            text = f"{there}: there is no such file; the path is relative to this file"
            yield Problem(text, ".".join(map(str, path)), document.file, *document.position(path))
