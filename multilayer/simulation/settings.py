"""Fields of a simulation file beside its stack: frequencies, incidence, size."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    PlainSerializer,
    PlainValidator,
    Tag,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic_core import PydanticCustomError

from multilayer.arrays import RealArray
from multilayer.bounds import FREQUENCIES
from multilayer.errors import show
from multilayer.json_schema import NUMBER_TEXT, any_of
from multilayer.models import NO_BOOL, Model, mistake, refuse, refuse_unknown_keys
from multilayer.response.bands import Width
from multilayer.response.diffuse_field import WeightingName
from multilayer.response.duct import Lined
from multilayer.response.excitations import PointForce, Rain, TappingMachine, TurbulentFlow
from multilayer.units import Frequency, Length, Unit, parse_quantity


class FrequencyRange(Model, populate_by_name=True):
    """Frequencies `from` ... `to`, both included, equally spaced on a logarithmic or linear axis.

    When left out from edge to edge of the third octaves from 100 Hz to 5 kHz, which ratings need whole.
    """

    start: Annotated[Frequency, Field(alias="from")] = 89.13
    stop: Annotated[Frequency, Field(alias="to")] = 5623.0
    points: Annotated[int, Field(ge=1, le=FREQUENCIES.usual), NO_BOOL] = 200
    spacing: Literal["log", "linear"] = "log"

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        refuse_unknown_keys(cls, data, ("from", "to", "points", "spacing"), tuple(Bands.model_fields))
        return data

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if self.stop <= self.start and self.points > 1:
            text = f"{self.stop:g} Hz is not allowed: it must be above 'from', {self.start:g} Hz"
            refuse(self, [(("to",), text, self.stop)])
        return self

    def values(self) -> RealArray:
        """Return the frequencies, Hz."""
        space = np.geomspace if self.spacing == "log" else np.linspace
        return np.asarray(space(self.start, self.stop, self.points))


class Bands(Model):
    """The bands from the one that holds the first frequency to the one that holds the second, of either width."""

    model_config = ConfigDict(json_schema_extra={"oneOf": [{"required": ["third_octaves"]}, {"required": ["octaves"]}]})

    third_octaves: tuple[Frequency, Frequency] | None = None
    octaves: tuple[Frequency, Frequency] | None = None

    @property
    def width(self) -> Width:
        """Of the bands."""
        return "third octaves" if self.octaves is None else "octaves"

    @property
    def ends(self) -> tuple[float, float]:
        """A frequency in the first and one in the last band, Hz."""
        (given,) = (ends for ends in (self.third_octaves, self.octaves) if ends is not None)
        return given

    @model_validator(mode="after")
    def _one_width_that_rises(self) -> Self:
        if (self.third_octaves is None) == (self.octaves is None):
            text = "give the first and the last band either as 'third_octaves' or as 'octaves', as [100 Hz, 5 kHz]"
            refuse(self, [((), text, self.octaves)])
        low, high = self.ends
        if high < low:
            text = f"{high:g} Hz is not allowed: the last band must not lie below the first, {low:g} Hz"
            refuse(self, [((self.width.replace(" ", "_"), 1), text, high)])
        return self


def _kind_of_grid(value: Any) -> str:
    if isinstance(value, Bands) or (isinstance(value, Mapping) and not value.keys().isdisjoint(Bands.model_fields)):
        return "bands"
    return "range" if isinstance(value, FrequencyRange | Mapping) else "list"


def _listed(value: Any) -> Any:
    """Return a list of frequencies; what is none, such as ``100-5000``, is asked back with all that may be written."""
    if isinstance(value, str | int | float):
        text = f"must be a list, not {show(value)}: [100, 200, 500]; or {{from: 100 Hz, to: 5 kHz}}, or "
        text += "{third_octaves: [100 Hz, 5 kHz]}"
        raise PydanticCustomError("input", "{reason}", {"reason": text})
    return value


_ONCE = "list each frequency once, the lowest first"


def _rising(frequencies: tuple[float, ...]) -> tuple[float, ...]:
    wrong = [
        mistake("input", (i,), f"{f:g} Hz is not allowed: it must be above {before:g} Hz before it; {_ONCE}", f)
        for i, (before, f) in enumerate(pairwise(frequencies), start=1)
        if f <= before
    ]
    if wrong:
        raise ValidationError.from_exception_data("frequency", wrong)
    return frequencies


FrequencyList = Annotated[
    tuple[Frequency, ...],
    Field(min_length=1, max_length=FREQUENCIES.usual),
    BeforeValidator(_listed),
    AfterValidator(_rising),
]
FrequencyGrid = Annotated[
    Annotated[FrequencyRange, Tag("range")] | Annotated[Bands, Tag("bands")] | Annotated[FrequencyList, Tag("list")],
    Discriminator(_kind_of_grid),
]


class PlaneIncidence(Model):
    """One plane wave, `angle` degrees from the normal."""

    angle: Annotated[float, Field(ge=0, lt=90), Unit("degree")] = 0.0


class DiffuseField(Model):
    """Largest angle of a diffuse field's waves from the normal, degrees, and their intensity by angle.

    The integral stops at `max_angle`, also with a `finite_size`: 78 by custom, 90 for the whole half-space.
    """

    max_angle: Annotated[float, Field(gt=0, le=90), Unit("degree")] = 78.0
    weighting: WeightingName = "uniform"


class DiffuseIncidence(Model):
    """Waves from all directions up to a largest angle."""

    diffuse: DiffuseField = DiffuseField()


def _parse_incidence(value: Any, info: ValidationInfo) -> Any:
    if isinstance(value, PlaneIncidence | DiffuseIncidence):
        return value
    if value == "normal":
        return PlaneIncidence()
    if value == "diffuse":
        return DiffuseIncidence()
    if isinstance(value, Mapping):
        return DiffuseIncidence.model_validate(dict(value), context=info.context)
    try:
        angle = parse_quantity(value, "degree")
    except ValueError:
        raise _refused(value) from None
    if not 0 <= angle < 90:
        raise _refused(value)
    return PlaneIncidence(angle=angle)


def _refused(value: Any) -> PydanticCustomError:
    reason = (
        f"{show(value)} is not allowed; allowed: normal, an angle in degrees from 0 to below 90, diffuse, "
        "or {diffuse: {max_angle: 78, weighting: gaussian}}"
    )
    return PydanticCustomError("incidence", "{reason}", {"reason": reason})


def _plain_incidence(incidence: PlaneIncidence | DiffuseIncidence) -> Any:
    return incidence.angle if isinstance(incidence, PlaneIncidence) else incidence.model_dump()


Incidence = Annotated[
    PlaneIncidence | DiffuseIncidence,
    PlainValidator(_parse_incidence),
    PlainSerializer(_plain_incidence),
    any_of(
        {"enum": ["normal", "diffuse"]},
        {"type": ["number", "string"], "minimum": 0, "exclusiveMaximum": 90, "pattern": NUMBER_TEXT},
        DiffuseIncidence,
    ),
]


class FiniteSize(Model):
    """A panel or sample in a baffle: its two sides."""

    width: Length
    height: Length


class Duct(Model):
    """A rectangular duct that the stack lines: the height of its airway, the Mach number of a uniform flow in it."""

    height: Length
    lined: Lined = "both sides"
    mach: Annotated[float, Field(gt=-1, lt=1)] = 0.0


Excitation = Annotated[PointForce | Rain | TappingMachine | TurbulentFlow, Discriminator("type")]
