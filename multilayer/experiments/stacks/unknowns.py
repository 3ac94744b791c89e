"""The unknowns of a stack fit: the fields of stacks that they are, and their values at coordinates."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from multilayer.arrays import RealArray
from multilayer.errors import InputError, MultilayerError, suggest
from multilayer.experiments.stacks.field_priors import MistakeError, is_modulus, limits_of, pair, prior_of
from multilayer.inference.priors import Parameter, Prior, Priors
from multilayer.json_schema import Written, any_of
from multilayer.media.laws import LAWS, ModulusLaw, complex_modulus
from multilayer.media.laws.parameters import LawSpace
from multilayer.media.laws.template import law_template
from multilayer.models import NO_BOOL, Model, refuse
from multilayer.paths import Located, locate, unit_of, with_values
from multilayer.stack import Stack

KINDS = ("normal", "lognormal", "uniform", "loguniform")
_NEAR = 2.0  # largest coordinate of a start: further out uniform priors hardly change


class UnknownFile(Model):
    """An unknown as a file states it, with units.

    Attributes
    ----------
    paths : tuple of str
        The fields that share it; the unknown's own name is the path where it is left out.
    normal, lognormal, uniform, loguniform : pair, optional
        Exactly one of these, see `Prior`, or `law`.
    bounds : pair, or mapping of pairs
        Limits at which a normal or lognormal prior is truncated; with `law`, ranges in which its fields are sought.
    law : str, optional
        Name of a modulus law that takes the place of a modulus.
    elements : int, optional
        Number of elements, of a law with lists of entries.
    fixed : mapping, optional
        Fields of the law that are known.
    nuisance : bool
        Whether it is not of interest in itself.
    """

    model_config = ConfigDict(json_schema_extra={"oneOf": [{"required": [kind]} for kind in (*KINDS, "law")]})

    paths: Annotated[
        tuple[str, ...],
        BeforeValidator(lambda v: (v,) if isinstance(v, str) else v),
        any_of({"type": "string"}, {"type": "array", "items": {"type": "string"}}),
    ] = ()
    normal: tuple[Any, Any] | None = None
    lognormal: tuple[Any, Any] | None = None
    uniform: tuple[Any, Any] | None = None
    loguniform: tuple[Any, Any] | None = None
    bounds: Any = None
    law: Annotated[str | None, Written(lambda _: {"enum": [*LAWS.names(), None]})] = None
    elements: Annotated[int, Field(ge=1), NO_BOOL] | None = None
    fixed: dict[str, Any] = Field(default_factory=dict)
    nuisance: bool = False

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        given = [kind for kind in (*KINDS, "law") if getattr(self, kind) is not None]
        if len(given) != 1:
            text = f"give exactly one of {', '.join(KINDS)}, or a law; given: {', '.join(given) or 'none'}"
            refuse(self, [((), text, None)])
        if self.law is None and (self.fixed or self.elements is not None):
            refuse(self, [((), "'fixed' and 'elements' go with a law; a known value stands in the stack file", None)])
        return self

    @property
    def kind(self) -> str:
        """Name of the prior's kind, or ``law``."""
        return next(kind for kind in (*KINDS, "law") if getattr(self, kind) is not None)


class Target(NamedTuple):
    """A field: the name of its stack, and its path there."""

    stack: str
    path: str


@dataclass(frozen=True)
class Unknown:
    """A parameter shared by some fields, or all parameters of a law shared by some moduli.

    Attributes
    ----------
    name : str
    targets : tuple of Target
    parameters : tuple of Parameter
        The coordinates that are sought.
    names, units : tuple of str
        Of the quantities that follow from the coordinates.
    start : array
        Coordinates near the nominal values.
    space : LawSpace, optional
        Parameters of a law.
    """

    name: str
    targets: tuple[Target, ...]
    parameters: tuple[Parameter, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    start: RealArray
    space: LawSpace | None = None

    @cached_property
    def _priors(self) -> Priors:
        return Priors.of(self.parameters)

    def values(self, z: RealArray) -> RealArray:
        """Return the quantities, SI, of coordinates, both of shape (..., n)."""
        box = self._priors.values(z)
        return box if self.space is None else np.exp(self.space.logs(box))

    @property
    def fields(self) -> tuple[Target, ...]:
        """The fields that take the quantities, all of a target one after the other."""
        inside = [""] if self.space is None else [f".{name}" for name in self.space.names]
        return tuple(Target(target.stack, target.path + field) for target in self.targets for field in inside)

    def columns(self, z: RealArray) -> Iterator[tuple[Target, RealArray]]:
        """Yield the fields and their values, shape (m,), of coordinates of shape (m, n)."""
        values = np.moveaxis(self.values(z), -1, 0)
        yield from zip(self.fields, [*values] * len(self.targets), strict=True)

    def placed(self, stacks: Mapping[str, Stack]) -> dict[Target, Any]:
        """Return laws, by field, that must be put into the nominal stacks before their fields can be set."""
        if self.space is None:
            return {}
        middle = 0.5 * (self.space.low + self.space.high)
        return dict.fromkeys(self.targets, self.space.law(middle))


@dataclass(frozen=True)
class UnknownFields:
    """Stacks and unknown fields of these: values of the fields at coordinates.

    Attributes
    ----------
    stacks : mapping
        By name, with nominal values.
    unknowns : tuple of Unknown
    """

    stacks: Mapping[str, Stack]
    unknowns: tuple[Unknown, ...]

    @cached_property
    def field_parameters(self) -> tuple[Parameter, ...]:
        """The unknowns' coordinates, one unknown after the other."""
        return tuple(parameter for unknown in self.unknowns for parameter in unknown.parameters)

    @cached_property
    def nominal_start(self) -> RealArray:
        """Coordinates near the nominal values."""
        return np.concatenate([np.empty(0), *(unknown.start for unknown in self.unknowns)])

    def parts(self, z: RealArray) -> Iterator[tuple[Unknown, RealArray]]:
        """Yield every unknown with its coordinates, shape (..., n)."""
        first = 0
        for unknown in self.unknowns:
            yield unknown, z[..., first : first + len(unknown.parameters)]
            first += len(unknown.parameters)

    def samples(self, z: RealArray) -> dict[str, dict[str, RealArray]]:
        """Return by stack and path the values, shape (m,), of coordinates of shape (m, n)."""
        values: dict[str, dict[str, RealArray]] = {name: {} for name in self.stacks}
        for unknown, coordinates in self.parts(z):
            for (stack, path), column in unknown.columns(coordinates):
                values[stack][path] = column
        return values

    def field_values(self, z: RealArray) -> dict[str, tuple[float, str]]:
        """Return values and units by name, of coordinates of shape (n,)."""
        by_name: dict[str, tuple[float, str]] = {}
        for unknown, coordinates in self.parts(z):
            values = zip(unknown.values(coordinates).tolist(), unknown.units, strict=True)
            by_name |= dict(zip(unknown.names, values, strict=True))
        return by_name


def placed(stacks: Mapping[str, Stack], unknowns: Sequence[Unknown]) -> dict[str, Stack]:
    """Return the stacks with laws in place of the moduli whose laws are unknown."""
    changed = dict(stacks)
    for unknown in unknowns:
        for (name, path), value in unknown.placed(changed).items():
            changed[name] = with_values(changed[name], {path: value})
    return changed


def resolve(
    name: str, entry: UnknownFile, stacks: Mapping[str, Stack], frequencies: Mapping[str, RealArray]
) -> Unknown:
    """Return an unknown with its fields located and its numbers in SI.

    Parameters
    ----------
    name : str
    entry : UnknownFile
    stacks : mapping
        By name.
    frequencies : mapping
        By stack, those of all its measurements, Hz.

    Raises
    ------
    MistakeError
        With the first mistake, at its place within the unknown's entry.
    """
    targets = _targets(name, entry, stacks)
    fields = [_located(stacks[target.stack], target, i, entry) for i, target in enumerate(targets)]
    if len({field.unit for field in fields}) > 1:
        units = " and ".join(sorted({str(field.unit or "1") for field in fields}))
        raise MistakeError(("paths",), f"these fields are in {units}; one value cannot be all of them", entry.paths)
    if entry.law is not None:
        return _law(name, entry, targets, stacks, frequencies)
    limits = np.array([limits_of(field) for field in fields])
    prior = prior_of(entry, fields[0].unit or "", (float(limits[:, 0].max()), float(limits[:, 1].min())))
    parameter = Parameter(name=name, prior=prior, unit=fields[0].unit or "", nuisance=entry.nuisance)
    start = np.clip(prior.coordinate([float(fields[0].value)]), -_NEAR, _NEAR)
    return Unknown(name, targets, (parameter,), (name,), (parameter.unit,), start)


def _targets(name: str, entry: UnknownFile, stacks: Mapping[str, Stack]) -> tuple[Target, ...]:
    targets: list[Target] = []
    for path in entry.paths or (name,):
        head, _, rest = path.partition(".")
        of_path = [Target(head, rest)] if head in stacks and rest else [Target(stack, path) for stack in stacks]
        targets += [target for target in of_path if target not in targets]
    return tuple(targets)


def _located(stack: Stack, target: Target, index: int, entry: UnknownFile) -> Located:
    place = ("paths", min(index, len(entry.paths) - 1)) if entry.paths else ("[key]",)
    try:
        field = locate(stack, target.path)
    except InputError as error:
        hint = "" if entry.paths or target.path.startswith("layers.") else "; or give its fields by 'paths'"
        raise MistakeError(place, f"{target.path}: {error}{hint}", target.path) from None
    if problem := _no_number(field) if entry.law is None else _no_modulus(field):
        raise MistakeError(place, f"{target.path}: {problem}", target.path)
    return field


def _no_number(field: Located) -> str:
    """Return why a field cannot be an unknown; empty when it can."""
    if field.value is None:
        return "this field is left to its default; write a value into the stack file to start from"
    if isinstance(field.value, ModulusLaw):
        inside = [name for name in type(field.value).model_fields if name != "law"]
        return f"holds a law; name one of its fields ({', '.join(inside)}), or say 'law: {field.value.law}' here"
    if isinstance(field.value, complex):
        return "holds a complex number; write {law: loss_factor, ...} there and name its fields"
    if field.unit is None or isinstance(field.value, bool) or not isinstance(field.value, int | float):
        return "is no number, and only numbers can be unknown"
    return ""


def _no_modulus(field: Located) -> str:
    if not is_modulus(field):
        return "a law takes the place of a modulus, and this field is none"
    if getattr(field.owner, "loss_factor", 0.0):
        return "a law has losses of its own; remove the 'loss_factor' beside it from the stack file"
    return ""


def _law(
    name: str,
    entry: UnknownFile,
    targets: tuple[Target, ...],
    stacks: Mapping[str, Stack],
    frequencies: Mapping[str, RealArray],
) -> Unknown:
    assert entry.law is not None
    f, moduli = _nominal_moduli(targets, stacks, frequencies)
    try:
        template = law_template(entry.law, entry.elements, f)
        space = LawSpace.of(template, entry.fixed, _law_bounds(template, entry), f, moduli)
    except MultilayerError as error:
        raise MistakeError(("law",), "; ".join(str(error).splitlines()), entry.law) from None
    boxes = zip(space.coordinates, space.low.tolist(), space.high.tolist(), strict=True)
    parameters = tuple(
        Parameter(name=f"ln {name}.{field}", prior=Prior(uniform=(low, high)), nuisance=entry.nuisance)
        for field, low, high in boxes
    )
    first = space.first(f, moduli)
    start = np.array([float(p.prior.coordinate(x)) for p, x in zip(parameters, first, strict=True)])
    names = tuple(f"{name}.{field}" for field in space.names)
    units = tuple(unit_of(template, field.split(".")[0]) or "" for field in space.names)
    return Unknown(name, targets, parameters, names, units, np.clip(start, -_NEAR, _NEAR), space)


def _nominal_moduli(
    targets: tuple[Target, ...], stacks: Mapping[str, Stack], frequencies: Mapping[str, RealArray]
) -> tuple[RealArray, Any]:
    """Return frequencies, Hz, and the moduli of the stack files there, Pa, around which a law is sought."""
    parts = []
    for target in targets:
        field = locate(stacks[target.stack], target.path)
        f = frequencies[target.stack]
        try:
            parts.append((f, np.asarray(complex_modulus(field.value, 0.0, f) + 0j * f)))
        except InputError as error:
            raise MistakeError(("law",), f"{target.path}: {error}", target.path) from None
    f, moduli = (np.concatenate(column) for column in zip(*parts, strict=True))
    return f, moduli


def _law_bounds(template: ModulusLaw, entry: UnknownFile) -> dict[str, tuple[float, float]]:
    if entry.bounds is None:
        return {}
    if not isinstance(entry.bounds, Mapping):
        raise MistakeError(("bounds",), "the bounds of a law are a mapping, as {order: [0.2, 0.8]}", entry.bounds)
    bounds = {}
    for name, written in entry.bounds.items():
        if name not in type(template).model_fields:
            raise MistakeError(("bounds", name, "[key]"), suggest(str(name), type(template).model_fields), name)
        bounds[name] = pair(("bounds", name), written, unit_of(template, name) or "")
    return bounds
