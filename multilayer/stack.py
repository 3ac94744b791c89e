"""A stack: the ambient gas, the layers, their contacts, and the termination."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    Field,
    GetJsonSchemaHandler,
    ModelWrapValidatorHandler,
    PlainSerializer,
    PlainValidator,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError

from multilayer.arrays import Numeric
from multilayer.bounds import CONTACTS, LAYERS
from multilayer.config.kinds import KEY, OF_A_SIMULATION
from multilayer.config.validate import validate
from multilayer.config.yaml12 import Document, read_yaml
from multilayer.errors import InputError, Problem, show, suggest
from multilayer.frames import html_table
from multilayer.json_schema import any_of
from multilayer.layers.base import Layer, LayerField
from multilayer.materials.expand import expand_materials
from multilayer.materials.written import with_materials_written
from multilayer.matrix.couplings import Contact
from multilayer.media.gas import Gas, dry_air
from multilayer.media.humid_air import humid_air
from multilayer.models import InWords, Model, refuse
from multilayer.paths import locate, positions, with_values
from multilayer.units import (
    DIMENSIONLESS,
    Density,
    PositiveRatio,
    Pressure,
    Speed,
    Temperature,
    Unit,
    Viscosity,
    asked_back,
)

_BEHIND = "termination"  # in contacts
_COLDEST, _THINNEST = 180.0, 1e4  # K, Pa: air where hardly anybody measures
_IN_KILOPASCAL = 200.0  # what is above is one atmosphere in hPa
_ANOTHER_GAS = 0.03  # relative difference of its stiffness at rest and in pores: round numbers of air differ by 2 %
_OF_A_WALL = ("beside", "links")  # what makes a wall of a stack


class Ambient(Model):
    """The gas on the excitation side, which also fills the pores.

    Dry air, an ideal gas, at `temperature` and `pressure`; with `relative_humidity` (of saturation, 0 to 1) humid air
    by the formulae of `media.humid_air`. Every further field given replaces the value that follows from these.
    """

    temperature: Temperature = 293.15
    pressure: Pressure = 101325.0
    relative_humidity: Annotated[float, Field(ge=0, le=1), Unit(DIMENSIONLESS)] | None = None
    density: Density | None = None
    sound_speed: Speed | None = None
    viscosity: Viscosity | None = None
    prandtl: PositiveRatio | None = None
    heat_capacity_ratio: Annotated[float, Field(gt=1), Unit(DIMENSIONLESS)] | None = None

    @model_validator(mode="after")
    def _is_a_gas(self) -> Self:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of validity: they come when something is computed
            try:
                gas = self.gas
            except (ArithmeticError, ValueError):  # of formulae far outside of their range
                gas = None
        if gas is None or not all(
            0 < value < math.inf for name, value in vars(gas).items() if name != "relative_humidity"
        ):
            text = "no air has these properties: density, sound speed and viscosity must follow above 0; correct "
            text += "temperature, pressure or relative_humidity, or give the properties themselves"
            refuse(self, [((), text, None)])
        return self

    def implausible(self) -> Iterator[tuple[str, str]]:
        """Give field and text of values that are allowed, and hardly ever meant."""
        if self.temperature < _COLDEST:
            yield "temperature", asked_back("a temperature", self.temperature, "K", "degC")
        if self.pressure < _THINNEST:
            other = "hPa" if self.pressure > _IN_KILOPASCAL else "kPa"
            yield "pressure", asked_back("a pressure", self.pressure, "Pa", other)
        gas = self.gas
        free, narrow = gas.impedance * gas.sound_speed, gas.heat_capacity_ratio * gas.pressure
        given = next((name for name in ("density", "sound_speed") if getattr(self, name) is not None), "")
        if given and abs(free / narrow - 1) > _ANOTHER_GAS:
            text = (
                f"density sound_speed^2 is {free:.4g} Pa, heat_capacity_ratio times pressure {narrow:.4g} Pa, which is "
            )
            yield given, text + "that of pores and narrow gaps; give heat_capacity_ratio and pressure of this gas, too"

    @property
    def gas(self) -> Gas:
        """The gas these fields describe."""
        given = self.model_dump(exclude_none=True, exclude={"temperature", "pressure", "relative_humidity"})
        return replace(self._air, **given)

    @property
    def _air(self) -> Gas:
        if self.relative_humidity is None:
            return dry_air(self.temperature, self.pressure)
        return humid_air(self.temperature, self.pressure, self.relative_humidity)

    def unlike_air(self) -> str:
        """Return what is stated of another gas than air at this temperature, pressure and humidity; empty of air."""
        for name in ("density", "sound_speed", "heat_capacity_ratio"):
            stated, usual = getattr(self, name), getattr(self._air, name)
            if stated is not None and abs(stated / usual - 1) > _ANOTHER_GAS:
                return f"ambient.{name} is {stated:.4g}, of such air {usual:.4g}"
        return ""


class FluidHalfSpace(Model):
    """A fluid that fills the space behind the stack; the ambient gas where a field is left out."""

    type: Literal["fluid"] = "fluid"
    density: Density | None = None
    sound_speed: Speed | None = None


class LayerContact(Model):
    """How two neighbours touch where it is not the default; each is a layer's name or index, or ``termination``.

    A number is an index; a text is a name and, where no layer has that name, an index.
    """

    between: tuple[str | int, str | int]
    kind: Contact


def _parse_termination(value: Any, info: ValidationInfo) -> Any:
    if isinstance(value, FluidHalfSpace) or value in ("rigid", "ambient", "free"):
        return value
    if isinstance(value, Mapping):
        return FluidHalfSpace.model_validate(dict(value), context=info.context)
    reason = f"{value!r} is not allowed; allowed: rigid, ambient, free, or {{type: fluid, density: ...}}"
    raise PydanticCustomError("termination", "{reason}", {"reason": reason})


Termination = Annotated[
    Literal["rigid", "ambient", "free"] | FluidHalfSpace,
    PlainValidator(_parse_termination),
    PlainSerializer(lambda t: t if isinstance(t, str) else t.model_dump(exclude_none=True)),
    any_of({"enum": ["rigid", "ambient", "free"]}, FluidHalfSpace),
]


def lets_through(termination: Termination) -> bool:
    """Tell whether sound leaves through a termination, a half-space; none does through a wall or a free face."""
    return termination not in ("rigid", "free")


class Stack(Model, metaclass=InWords):
    """Layers from the excitation to the termination; immutable.

    Read one with `load_stack`, change one with `replaced`.
    """

    also_written: ClassVar[tuple[str, ...]] = (KEY, "library")

    version: Literal[1] = 1
    ambient: Ambient = Ambient()
    layers: Annotated[tuple[LayerField, ...], Field(min_length=1, max_length=LAYERS.usual)]
    contacts: Annotated[tuple[LayerContact, ...], Field(max_length=CONTACTS.usual)] = ()
    termination: Termination = "rigid"

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        reference = handler(core)
        with_materials_written(handler.resolve_ref_schema(reference)["properties"], handler)
        return reference

    @model_validator(mode="wrap")
    @classmethod
    def _with_materials(cls, data: Any, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo) -> Self:
        expanded = expand_materials(data, Path((info.context or {}).get("folder", Path())))
        try:
            stack = handler(expanded.data)
        except ValidationError as error:
            reworded = [expanded.relocated(details) for details in error.errors(include_url=False)]
            problems = [*expanded.problems, *(details for details in reworded if details is not None)]
        else:
            problems = expanded.problems
        if problems:
            raise ValidationError.from_exception_data(cls.__name__, problems)
        return stack

    @model_validator(mode="after")
    def _names_and_contacts(self) -> Self:
        refuse(self, [*self._unfit_names(), *self._unfit_contacts()])
        return self

    def _unfit_names(self) -> Iterator[tuple[tuple[str | int, ...], str, Any]]:
        seen = set[str]()
        nameless = {str(i) for i, layer in enumerate(self.layers) if not layer.name}
        for i, layer in enumerate(self.layers):
            if (name := layer.name) is None:
                continue
            place = ("layers", i, "name")
            if name == _BEHIND:
                yield place, f"'{name}' is what contacts call the wall behind; give the layer another name", name
            elif name in nameless:
                yield place, f"layer {name} has no name and goes by its index; give that one a name, too", name
            elif name in seen:
                yield place, f"another layer is called '{name}' already; names must differ", name
            seen.add(name)

    def _unfit_contacts(self) -> Iterator[tuple[tuple[str | int, ...], str, Any]]:
        known, taken = positions(self.layers), dict[int, int]()
        for i, contact in enumerate(self.contacts):
            try:
                place = self._place(contact, known)
            except InputError as error:
                yield ("contacts", i, "between"), str(error), contact.between
                continue
            if taken.setdefault(place, i) != i:
                front, back = contact.between
                text = f"{front} and {back} have a contact already, in contacts.{taken[place]}; keep one of the two"
                yield ("contacts", i), text, contact.between

    def implausible(self) -> Iterator[tuple[tuple[str | int, ...], str]]:
        """Give path and text of values that are allowed, and hardly ever meant."""
        for field, text in self.ambient.implausible():
            yield ("ambient", field), text
        for i, layer in enumerate(self.layers):
            for field, text in layer.implausible():
                yield ("layers", i, field), text
            if getattr(layer, "losses", None) == "air" and (unlike := self.ambient.unlike_air()):
                text = f"the losses are those of air at the ambient temperature and pressure, and {unlike}: leave out "
                yield ("layers", i, "losses"), text + "'losses' of another gas, or give temperature and pressure of air"

    def __repr__(self) -> str:
        layers = [f"  {i}: {layer!r}" for i, layer in enumerate(self.layers)]
        return "\n".join([self._headline, *layers, f"  behind: {self.termination}"])

    @property
    def _headline(self) -> str:
        n = len(self.layers)
        return f"{type(self).__name__} of {n} layer{'s' if n > 1 else ''}, in {self.ambient!r}"

    def _repr_html_(self) -> str:
        fields = [", ".join(f"{k} {v}" for k, v in layer.__repr_args__() if k != "name") for layer in self.layers]
        rows = [(str(i), layer.name or "", layer.type, fields[i]) for i, layer in enumerate(self.layers)]
        table = [*rows, ("", "", "behind", str(self.termination))]
        return html_table(("", "name", "type", "fields"), table, self._headline)

    def index(self, key: str | int) -> int:
        """Return the position of a layer from its name or index.

        Raises
        ------
        InputError
            When there is no such layer.
        """
        return _found(key, positions(self.layers))

    def _place(self, contact: LayerContact, known: Mapping[str | int, int]) -> int:
        """Return the index of a contact's interface; 1 lies behind the first layer."""
        n = len(self.layers)
        ends = sorted(n if end == _BEHIND else _found(end, known) for end in contact.between)
        if ends[1] - ends[0] != 1:
            raise InputError(f"{contact.between[0]} and {contact.between[1]} are no neighbours")
        return ends[1]

    @property
    def interfaces(self) -> tuple[Contact, ...]:
        """Contact at every interface: excitation to first layer, between layers, last layer to termination."""
        kinds: list[Contact] = ["bonded"] * (len(self.layers) + 1)
        known = positions(self.layers)
        for contact in self.contacts:
            kinds[self._place(contact, known)] = contact.kind
        return tuple(kinds)

    @property
    def lets_through(self) -> bool:
        """Whether sound leaves through the termination."""
        return lets_through(self.termination)

    @property
    def isotropic_in_plane(self) -> bool:
        """Whether the azimuth of a wave makes no difference to any layer."""
        return all(layer.isotropic_in_plane for layer in self.layers)

    def at_rest(self, *, on_base: bool = False) -> tuple[Layer, ...]:
        """Return the layers as they are under the static weight of those that lie on them.

        Parameters
        ----------
        on_base : bool
            Whether the stack stands on its front face, on a shaken base, rather than on its termination.
        """
        return tuple(
            layer.under(self.layers[i + 1 :] if on_base else self.layers[:i][::-1])
            for i, layer in enumerate(self.layers)
        )

    def replaced(self, values: Mapping[str, Numeric | Any]) -> Stack:
        """Return a copy with some fields changed.

        Parameters
        ----------
        values : mapping
            Dotted paths to values, as ``{"layers.foam.thickness": 0.05}``; a layer goes by its name or index. Values
            are SI and are not validated; arrays broadcast against (frequency, angle) in the responses.

        Raises
        ------
        InputError
            When a path leads nowhere, naming the nearest, and for a text in place of a number.
        """
        for path, value in values.items():
            try:
                found = locate(self, path)
            except InputError as error:
                raise InputError(f"'{path}' {error}") from None
            if isinstance(value, str) and isinstance(found.value, int | float):
                raise InputError(f"'{path}' holds a number, and {show(value)} is a text; give a number in SI units")
        return with_values(self, values)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data that a stack file can hold; `Stack.model_validate` reads it back."""
        return self.model_dump(mode="json", by_alias=True, exclude_none=True)


def _found(key: str | int, known: Mapping[str | int, int]) -> int:
    if key not in known:
        raise InputError(f"there is no layer {show(str(key))}; {suggest(str(key), {str(name) for name in known})}")
    return known[key]


def load_stack(path: str | Path) -> Stack:
    """Read a stack file, or the stack of a simulation file.

    Parameters
    ----------
    path : path
        A YAML file as described in ``docs/stack-files.md``.

    Raises
    ------
    InputError
        With every mistake in the file, each with its line and column.
    """
    file = Path(path)
    return _stack_of(read_yaml(file, keep_problems=True), file)


def _stack_of(document: Document, file: Path) -> Stack:
    if isinstance(document.data, dict):
        kept = {key: value for key, value in document.data.items() if key not in OF_A_SIMULATION}
        document = replace(document, data=kept)
    return validate(document, Stack, "stack", context={"folder": file.parent})


def _parse_stack(value: Any, info: ValidationInfo) -> Stack:
    if isinstance(value, Stack):
        return value
    if isinstance(value, Mapping):
        return Stack.model_validate(value, context=info.context)
    file = Path((info.context or {}).get("folder", Path())) / str(value)
    try:
        document = read_yaml(file, keep_problems=True)
        _refuse_wall(document)
        return _stack_of(document, file)
    except InputError as error:
        reason = f"{error}; the path is relative to this file" if "no such file" in str(error) else str(error)
        raise PydanticCustomError("reference", "{reason}", {"reason": reason}) from None


def _refuse_wall(document: Document) -> None:
    """Refuse a file whose links or paths beside would be left out without a word."""
    written = document.data if isinstance(document.data, dict) else {}
    wrong = [key for key in _OF_A_WALL if written.get(key)]
    if wrong:
        text = (
            "belongs to a wall, and only the layers of this file count here; name a file without 'beside' and 'links'"
        )
        problems = [Problem(text, key, document.file, *document.position((key,))) for key in wrong]
        raise InputError([*document.problems, *problems])


StackField = Annotated[
    Stack, PlainValidator(_parse_stack), PlainSerializer(Stack.to_dict), any_of({"type": "string"}, Stack)
]
"""A stack inside another file: the path of its own file, relative to that one, or its fields; no wall with links."""
