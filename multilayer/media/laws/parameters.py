"""The parameters of a law as numbers for a fit: logarithms within bounds, such that every point is a passive law."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import log
from typing import Any

import numpy as np
from pydantic import ValidationError, create_model

from multilayer.arrays import BoolArray, ComplexArray, RealArray
from multilayer.errors import InputError, suggest
from multilayer.media.laws.base import ModulusLaw
from multilayer.models import Model
from multilayer.units import field_bounds, field_unit

Bounds = Mapping[str, tuple[float, float]]
_WIDE = 1e3  # how far, as a factor, plateaus and times are sought beyond the data
_ON_BOUND = 1e-4
_ROUNDING = 1e-12


@dataclass(frozen=True)
class _Unknown:
    """A free parameter: a field, or entry `index` of one, with its bounds as natural logarithms."""

    field: str
    index: int | None
    guess: float
    low: float
    high: float


@dataclass(frozen=True)
class _Tie:
    """A `Limit`: the logarithm of its product is ``known + powers . logs``; it replaces the parameter `last`."""

    last: int
    powers: RealArray
    known: float
    message: str
    product: str

    @cached_property
    def others(self) -> RealArray:
        """Powers of all but the last."""
        return np.where(np.arange(self.powers.size) == self.last, 0.0, self.powers)


@dataclass(frozen=True)
class LawSpace:
    """The unknowns of a law as a vector z within bounds: logarithms of parameters, or of the products of its limits.

    Attributes
    ----------
    template : ModulusLaw
        A law with as many elements as the fitted one.
    known : mapping
        Values of the fields that are not fitted.
    unknowns, ties : tuple
        The free parameters, and the limits that tie them together.
    low, high : array, shape (n,)
        Bounds of z.
    """

    template: ModulusLaw
    known: Mapping[str, Any]
    unknowns: tuple[_Unknown, ...]
    ties: tuple[_Tie, ...]
    low: RealArray
    high: RealArray

    @classmethod
    def of(
        cls, template: ModulusLaw, fixed: Mapping[str, Any], bounds: Bounds, f: RealArray, e: ComplexArray
    ) -> LawSpace:
        """Return the space for data `f` (Hz) and `e` (Pa); fields are free unless they are `fixed` or a grid.

        Raises
        ------
        InputError
            For unknown fields, bounds that are not in order, or more unknowns than data.
        """
        fields = [name for name in type(template).model_fields if name != "law"]
        for name in (*fixed, *bounds):
            if name not in fields:
                raise InputError(f"{type(template).__name__} has no field '{name}'; {suggest(name, fields)}")
        known = {name: getattr(template, name) for name in template.grid} | _parsed(type(template), fixed)
        ranges = _ranges(f, e)
        free = [name for name in fields if name not in known]
        unknowns = tuple(u for name in free for u in _unknowns(template, name, bounds.get(name), ranges))
        if not unknowns or len(unknowns) > 2 * f.size:
            raise InputError(
                f"{f.size} moduli, {len(unknowns)} parameters to find; fix fewer or more, or change elements"
            )
        low, high = np.array([(u.low, u.high) for u in unknowns]).T.copy()
        ties = tuple(_ties(template, known, unknowns))
        for tie in ties:
            _tighten(low, high, tie)
            low[tie.last], high[tie.last] = min(_least(low, high, tie).sum() + tie.known, -1.0), 0.0
        return cls(template, known, unknowns, ties, low, high)

    @property
    def names(self) -> list[str]:
        """Names of the unknowns, entries of lists as ``relaxation_time.0``."""
        return [u.field if u.index is None else f"{u.field}.{u.index}" for u in self.unknowns]

    @property
    def coordinates(self) -> list[str]:
        """The quantity whose logarithm each entry of z is: an unknown, or a product as ``relaxed_modulus/order^2``."""
        products = {tie.last: tie.product for tie in self.ties}
        return [products.get(index, name) for index, name in enumerate(self.names)]

    @property
    def units(self) -> list[str]:
        """Units of the unknowns."""
        return [_unit(self.template, u.field) for u in self.unknowns]

    def logs(self, z: RealArray) -> RealArray:
        """Return the logarithms of the parameters, shape of z."""
        y = np.array(z, dtype=float)
        for tie in self.ties:
            unknown, power = self.unknowns[tie.last], tie.powers[tie.last]
            others = y @ tie.others + tie.known
            y[..., tie.last] = np.clip((z[..., tie.last] - others) / power, unknown.low, unknown.high)
        return y

    def _fields(self, logs: Any) -> dict[str, Any]:
        """Return fields by name; `logs` holds one entry per unknown."""
        fields = dict(self.known)
        for unknown, value in zip(self.unknowns, np.exp(logs), strict=True):
            fields[unknown.field] = value if unknown.index is None else (*fields.get(unknown.field, ()), value)
        return fields

    def modulus(self, z: RealArray, f: RealArray) -> ComplexArray:
        """Return E1 + i E2, Pa, of each point z of shape (..., n)."""
        logs = np.moveaxis(self.logs(z), -1, 0)[..., np.newaxis]
        return type(self.template).model_construct(**self._fields(logs))(f)

    @cached_property
    def scale(self) -> int | None:
        """Place of the entry of z whose change by 1 multiplies the modulus by e, whatever the others are; None if none.

        A modulus is in proportion to all quantities in Pa together: the entry must move all of them, and these only.
        """
        in_pascal = np.array([unit.startswith("Pa") for unit in self.units], dtype=float)
        if any(_unit(self.template, name).startswith("Pa") for name in self.known):
            return None
        changes = np.eye(len(self.unknowns))
        for tie in self.ties:
            changes[tie.last] = (np.eye(len(self.unknowns))[tie.last] - tie.others @ changes) / tie.powers[tie.last]
        places = np.flatnonzero(np.all(changes == in_pascal[:, None], axis=0))
        return int(places[0]) if places.size else None

    def law(self, z: RealArray) -> ModulusLaw:
        """Return the law at a point."""
        fields = {name: _plain(value) for name, value in self._fields(self.logs(z)).items()}
        return type(self.template).model_validate(fields)

    def first(self, f: RealArray, e: ComplexArray) -> RealArray:
        """Return the template's point, its moduli scaled to the mean of the data."""
        guess = self.template.model_construct(**{**dict(self.template), **self.known})
        scale = float(np.mean(np.log(np.abs(e)) - np.log(np.abs(guess(f)))))
        shift = [scale if _unit(self.template, u.field).startswith("Pa") else 0.0 for u in self.unknowns]
        z = np.array([u.guess for u in self.unknowns]) + shift
        for tie in self.ties:
            z[tie.last] = tie.known + tie.powers @ z
        return z

    def points(self, count: int, rng: np.random.Generator) -> RealArray:
        """Return a Latin hypercube of points, shape (count, n)."""
        cells = rng.permuted(np.tile(np.arange(count), (self.low.size, 1)), axis=1).T
        return np.asarray(self.low + (cells + rng.random(cells.shape)) / count * (self.high - self.low))

    def on_bound(self, z: RealArray) -> BoolArray:
        """Return which unknowns lie on a bound, of z or of the parameter itself."""
        y, low, high = self.logs(z), *np.array([(u.low, u.high) for u in self.unknowns]).T
        of_box = np.minimum(z - self.low, self.high - z) < _ON_BOUND * (self.high - self.low)
        return np.asarray(of_box | (np.minimum(y - low, high - y) < _ON_BOUND * (high - low)))


def _parsed(kind: type[ModulusLaw], fixed: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of fields as an input would give them, each validated alone."""
    fields: dict[str, Any] = {name: (kind.model_fields[name].annotation, kind.model_fields[name]) for name in fixed}
    try:
        return dict(create_model("Fixed", __base__=Model, **fields).model_validate(dict(fixed)))
    except ValidationError as error:
        messages = (f"{'.'.join(map(str, item['loc']))}: {item['msg']}" for item in error.errors())
        raise InputError(list(messages)) from None


def _plain(value: Any) -> Any:
    return tuple(map(float, value)) if isinstance(value, tuple | list) else float(value)


def _unit(template: ModulusLaw, name: str) -> str:
    return field_unit(type(template).model_fields[name]) or ""


def _ranges(f: RealArray, e: ComplexArray) -> dict[str, tuple[float, float]]:
    """Return the default bounds of free parameters by unit, from the moduli and frequencies of the data."""
    size, omega = np.abs(e), 2 * np.pi * f
    return {
        "Pa": (size.min() / _WIDE, size.max() * _WIDE),
        "Pa*s": (size.min() / omega.max() / _WIDE, size.max() / omega.min() * _WIDE),
        "s": (1 / omega.max() / _WIDE, _WIDE / omega.min()),
        "": (1e-3, 1e2),
    }


def _unknowns(
    template: ModulusLaw, name: str, bounds: tuple[float, float] | None, ranges: Mapping[str, tuple[float, float]]
) -> Iterator[_Unknown]:
    unit = _unit(template, name)
    if bounds is None and unit not in ranges:
        raise InputError(f"{name} is in {unit}: say within which `bounds` to seek it, or fix it")
    low, high = ranges[unit] if bounds is None else bounds
    bounded = field_bounds(type(template).model_fields[name])  # open ends, as 0, are no bounds of a logarithm
    most = min([high, *(end for side, end in bounded if side == "le")])
    low = max([low, *(end * (1 + _ROUNDING) for side, end in bounded if side == "ge")])
    if not 0 < low < most:
        raise InputError(
            f"{name}: bounds {low:g} and {most:g} must be above 0 and in order; fix it where they are equal"
        )
    value = getattr(template, name)
    entries = list(enumerate(value)) if isinstance(value, tuple) else [(None, value)]
    for index, entry in entries:
        yield _Unknown(name, index, log(max(entry, low * 1e-9)), log(low), log(most))


def _ties(template: ModulusLaw, known: Mapping[str, Any], unknowns: tuple[_Unknown, ...]) -> Iterator[_Tie]:
    for limit in template.limits:
        powers = np.array([limit.powers.get(unknown.field, 0) for unknown in unknowns], dtype=float)
        constant = sum(power * log(known[name]) for name, power in limit.powers.items() if name in known)
        if not powers.any() and constant > _ROUNDING:
            raise InputError(limit.message)
        if powers.any():
            yield _Tie(int(np.flatnonzero(powers)[-1]), powers, constant, limit.message, _product(limit.powers))


def _product(powers: Mapping[str, float]) -> str:
    """Return a product of powers as text."""
    parts = [(name if abs(power) == 1 else f"{name}^{abs(power):g}", power > 0) for name, power in powers.items()]
    above = "*".join(text for text, over in parts if over) or "1"
    return "/".join([above, *(text for text, over in parts if not over)])


def _least(low: RealArray, high: RealArray, tie: _Tie) -> RealArray:
    """Return the smallest contribution of each unknown to a tie."""
    return np.minimum(tie.powers * low, tie.powers * high)


def _tighten(low: RealArray, high: RealArray, tie: _Tie) -> None:
    """Narrow the bounds of a tie's unknowns to values for which the others can still keep the limit."""
    least = _least(low, high, tie)
    if least.sum() + tie.known > 0:
        raise InputError(f"{tie.message}: the bounds and fixed values leave no such law")
    for i in np.flatnonzero(tie.powers):
        most = (least[i] - least.sum() - tie.known) / tie.powers[i]
        low[i], high[i] = (low[i], min(high[i], most)) if tie.powers[i] > 0 else (max(low[i], most), high[i])
