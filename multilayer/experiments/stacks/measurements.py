"""Measurements as a stack-fit file describes them: the quantity, where its values are, and their noise."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self, TypeAlias

from pydantic import BeforeValidator, Field, PlainSerializer, PlainValidator, ValidationInfo, model_validator
from pydantic_core import PydanticCustomError

from multilayer.errors import show
from multilayer.json_schema import COMPLEX_TEXT, QUANTITY_TEXT, Written, any_of
from multilayer.models import Model, refuse
from multilayer.response.bands import Width
from multilayer.simulation.settings import DiffuseField, DiffuseIncidence, FiniteSize, Incidence, PlaneIncidence
from multilayer.units import Frequency, Length, PositiveRatio, Ratio, parse_complex_quantity, parse_quantity

COMPLEX, POLAR, REAL = ("real", "imag"), ("amplitude", "phase"), ("value",)
SPREADS = ("std", "std_real", "std_imag")
NOISE_ESTIMATED = "noise_estimated"  # key of a validation context: noise that is not stated will be estimated
_NOISE = "write a share, as 0.02 or '2 %', or {relative: 0.02, absolute: ...}"


class Spread(NamedTuple):
    """Standard deviations of each part of a measured value: relative to its modulus, and absolute; independent."""

    relative: float
    absolute: float


class ModelError(Model):
    """Standard deviation of the model's error, relative to the values, and its correlation length in ln f."""

    relative: Ratio
    length: PositiveRatio = 0.3


def _parse_model_error(value: Any) -> Any:
    return value if value is None or isinstance(value, Mapping | ModelError) else {"relative": value}


class Measurement(Model, populate_by_name=True):
    """Fields that all measurements have.

    Attributes
    ----------
    kind : str
    name : str, optional
        For tables and figures; made from kind and file when left out.
    stack : str, optional
        Name of its stack, where the file has several.
    file : Path, optional
        A table with named columns, as text or in another format with a reader, relative to the fit file.
    columns : mapping
        By role, the column's name in the header, with a unit in brackets where the header has none.
    rows : mapping
        By column, the text that selects rows.
    start, to : float, optional
        First (`from`) and last frequency, Hz.
    noise : optional
        See `spread`.
    model_error : optional
    """

    is_complex: ClassVar[bool] = True
    in_db: ClassVar[bool] = False
    roles: ClassVar[Mapping[str, tuple[str, ...]]] = {}  # usual names of columns, where `columns` gives none

    kind: str
    name: str | None = Field(default=None, min_length=1)
    stack: str | None = None
    file: Path | None = None
    columns: dict[str, str] = Field(default_factory=dict)
    rows: dict[str, str] = Field(default_factory=dict)
    start: Annotated[Frequency | None, Field(alias="from")] = None
    to: Frequency | None = None
    noise: Any = None
    model_error: Annotated[
        ModelError | None,
        BeforeValidator(_parse_model_error),
        any_of({"type": ["number", "string", "null"], "minimum": 0, "pattern": QUANTITY_TEXT}, ModelError),
    ] = None

    def implausible(self) -> Iterator[tuple[str, str]]:
        """Give field and text of what is allowed, and hardly ever meant."""
        yield from ()

    @model_validator(mode="after")
    def _usable(self, info: ValidationInfo) -> Self:
        needs_noise = not (info.context or {}).get(NOISE_ESTIMATED, False)
        refuse(self, [*self._wrong_noise(needs_noise), *self._wrong_columns(), *self._wrong_band()])
        return self

    def _wrong_noise(self, needed: bool) -> list[tuple[tuple[str, ...], str, Any]]:
        try:
            spread = self.spread
        except ValueError as error:
            return [(("noise",), str(error), self.noise)]
        if needed and not any(spread) and not set(SPREADS) & {*self.columns, *self.roles}:
            text = f"without noise nothing can be weighed; {_NOISE}, or name a column 'std'"
            return [((), f"noise: {text}", None)]
        return []

    def _wrong_columns(self) -> list[tuple[tuple[str, ...], str, Any]]:
        allowed = ["frequency", *((*COMPLEX, *POLAR, *SPREADS) if self.is_complex else (*REAL, "std"))]
        return [
            (("columns", role, "[key]"), f"there is no such column here; allowed: {', '.join(allowed)}", role)
            for role in self.columns
            if role not in allowed
        ]

    def _wrong_band(self) -> list[tuple[tuple[str, ...], str, Any]]:
        if self.start is None or self.to is None or self.start <= self.to:
            return []
        return [(("to",), f"{self.to:g} Hz is not allowed: it must not lie below 'from', {self.start:g} Hz", self.to)]

    @property
    def unit(self) -> str:
        """Unit of the values, SI; ``dB`` of levels, empty for pure numbers."""
        return "dB" if self.in_db else ""

    @property
    def default_name(self) -> str:
        """Name of the measurement where the file gives none."""
        name = self.kind if self.file is None else f"{self.kind} {self.file.stem}"
        return ", ".join([name, *self.rows.values()])

    @property
    def spread(self) -> Spread:
        """Standard deviations from `noise`: a relative one (of levels in dB, an absolute one), or both by name.

        Raises
        ------
        ValueError
            When `noise` is not a standard deviation.
        """
        given = self.noise
        if given is None:
            return Spread(0.0, 0.0)
        if not isinstance(given, Mapping):
            return Spread(0.0, _amount(given, self.unit)) if self.in_db else Spread(_amount(given, ""), 0.0)
        unknown = set(given) - {"relative", "absolute"}
        if unknown or not given or (self.in_db and "relative" in given):
            wanted = "the noise of what is in dB is {absolute: 1}, in dB" if self.in_db else _NOISE
            raise ValueError(f"{show(dict(given))} is no noise; {wanted}")
        return Spread(_amount(given.get("relative", 0.0), ""), _amount(given.get("absolute", 0.0), self.unit))


_MOST_NOISE = 1e100  # its square is still a number


def _amount(written: Any, unit: str) -> float:
    value = parse_quantity(written, unit)
    if not 0 <= value < _MOST_NOISE:
        raise ValueError(f"{show(written)} is no standard deviation: it must be at least 0 and below {_MOST_NOISE:g}")
    return value


class _FromFile(Measurement):
    file: Path


class _PlaneWave(_FromFile):
    incidence: Incidence = PlaneIncidence()

    @model_validator(mode="after")
    def _plane(self) -> Self:
        if isinstance(self.incidence, DiffuseIncidence):
            refuse(self, [(("incidence",), f"a {self.kind} is that of one plane wave: normal, or an angle", None)])
        return self

    @property
    def angle(self) -> float:
        """Degrees from the normal."""
        assert isinstance(self.incidence, PlaneIncidence)
        return self.incidence.angle


class Reflection(_PlaneWave):
    """Reflection coefficient of a plane wave."""

    roles: ClassVar[Mapping[str, tuple[str, ...]]] = {"real": ("reflection_re",), "imag": ("reflection_im",)}
    kind: Literal["reflection"] = "reflection"


class SurfaceImpedance(_PlaneWave):
    """Pressure over normal velocity at the front face, over rho c of the ambient gas if `normalised`, else Pa s/m."""

    roles: ClassVar[Mapping[str, tuple[str, ...]]] = {
        "real": ("normalised_impedance_re", "surface_impedance_re"),
        "imag": ("normalised_impedance_im", "surface_impedance_im"),
    }
    kind: Literal["surface_impedance"] = "surface_impedance"
    normalised: bool

    @property
    def unit(self) -> str:
        """Unit of the values."""
        return "" if self.normalised else "Pa*s/m"


def _parse_bands(value: Any) -> Any:
    if value in ("third octaves", "octaves", None):
        return value
    reason = f"{show(value)} is not allowed; allowed: third octaves, octaves"
    raise PydanticCustomError("bands", "{reason}", {"reason": reason})


Bandwidth: TypeAlias = Annotated[
    Width | None,
    PlainValidator(_parse_bands),
    PlainSerializer(lambda bands: bands),
    Written({"enum": ["third octaves", "octaves", None]}),
]


class _Energy(_FromFile):
    """A measurement without phase; `bands` where each value is a mean over a band."""

    is_complex: ClassVar[bool] = False
    quantity: ClassVar[Literal["absorption", "transmission_loss"]]
    incidence: Incidence = PlaneIncidence()
    finite_size: FiniteSize | None = None
    bands: Bandwidth = None


class Absorption(_Energy):
    """Absorption coefficient."""

    quantity = "absorption"
    roles: ClassVar[Mapping[str, tuple[str, ...]]] = {"value": ("absorption", "alpha")}
    kind: Literal["absorption"] = "absorption"


class ReverberationAbsorption(Absorption):
    """Absorption coefficient of a sample in a reverberation room (ISO 354), in third octaves unless said otherwise.

    Waves come from the whole half-space, and the sample takes more than falls on its area (`finite_size`): coefficients
    may be above 1.
    """

    roles: ClassVar[Mapping[str, tuple[str, ...]]] = {"value": ("alpha_s", "absorption", "alpha")}
    kind: Literal["reverberation_absorption"] = "reverberation_absorption"  # type: ignore[assignment]
    incidence: Incidence = DiffuseIncidence(diffuse=DiffuseField(max_angle=90.0))
    finite_size: FiniteSize
    bands: Bandwidth = "third octaves"

    @model_validator(mode="after")
    def _diffuse(self) -> Self:
        if isinstance(self.incidence, PlaneIncidence):
            text = "waves of a reverberation room come from everywhere; leave it out, or write {diffuse: {...}}"
            refuse(self, [(("incidence",), text, None)])
        return self


class TransmissionLoss(_Energy):
    """Transmission loss, dB."""

    quantity = "transmission_loss"
    in_db: ClassVar[bool] = True
    roles: ClassVar[Mapping[str, tuple[str, ...]]] = {"value": ("transmission_loss", "tl", "stl")}
    kind: Literal["transmission_loss"] = "transmission_loss"

    def implausible(self) -> Iterator[tuple[str, str]]:
        """Give field and text of what is allowed, and hardly ever meant."""
        if self.bands is not None and "incidence" not in self.model_fields_set:
            text = f"a transmission loss in {self.bands} is taken at normal incidence, since incidence is left out"
            yield "bands", f"{text}; between rooms it is 'incidence: diffuse'"


class Transmissibility(_FromFile):
    """Motion of the back face over that of the shaken front face."""

    roles: ClassVar[Mapping[str, tuple[str, ...]]] = {
        "real": ("transmissibility_re",),
        "imag": ("transmissibility_im",),
    }
    kind: Literal["transmissibility"] = "transmissibility"


class DynamicModulus(_FromFile):
    """Young's modulus E1 + i E2 of a layer, Pa, as a dynamic mechanical analyser or another fit gives it."""

    roles: ClassVar[Mapping[str, tuple[str, ...]]] = {
        "real": ("e1", "storage_modulus"), "imag": ("e2", "loss_modulus"),
        "std_real": ("e1_std",), "std_imag": ("e2_std",),
    }  # fmt: skip
    kind: Literal["modulus"] = "modulus"
    layer: str

    @property
    def unit(self) -> str:
        """Unit of the values."""
        return "Pa"


def _parse_stiffness(value: Any) -> Any:
    try:
        number = parse_complex_quantity(value, "N/m")
    except ValueError as error:
        raise PydanticCustomError("stiffness", "{reason}", {"reason": str(error)}) from None
    if not number.real > 0 or number.imag < 0:
        reason = f"{show(value)} is no stiffness: its real part must be above 0 and its imaginary part at least 0"
        raise PydanticCustomError("stiffness", "{reason}", {"reason": reason})
    return number


class Stiffness(Measurement):
    """Force over shortening of a disc of a layer's material glued between rigid plates, in slow compression, N/m.

    Real, or complex with its losses; `stiffness` and `frequency` here, or a file with several.
    """

    roles: ClassVar[Mapping[str, tuple[str, ...]]] = {"real": ("stiffness", "stiffness_re"), "imag": ("stiffness_im",)}
    kind: Literal["stiffness"] = "stiffness"
    layer: str
    radius: Length
    thickness: Length | None = None
    frequency: Frequency | None = None
    stiffness: Annotated[
        Any,
        PlainValidator(_parse_stiffness),
        Written({"type": ["number", "string"], "exclusiveMinimum": 0, "pattern": COMPLEX_TEXT}),
    ] = None

    @property
    def unit(self) -> str:
        """Unit of the values."""
        return "N/m"

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if (self.file is None) == (self.stiffness is None) or (self.stiffness is None) != (self.frequency is None):
            refuse(self, [((), "give either a file, or 'stiffness' and 'frequency'", None)])
        return self


MeasurementField: TypeAlias = Annotated[
    SurfaceImpedance
    | Reflection
    | Absorption
    | ReverberationAbsorption
    | TransmissionLoss
    | Transmissibility
    | DynamicModulus
    | Stiffness,
    Field(discriminator="kind"),
]
