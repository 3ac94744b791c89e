"""Priors in the units of the fields they are for, truncated at the limits of these fields."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import ValidationError

from multilayer.errors import show
from multilayer.inference.priors import Prior
from multilayer.paths import Located
from multilayer.units import Unit, UnitLabel, annotated_with, field_limits, parse_quantity

_FAR = 6.0  # standard deviations: the probability beyond is negligible
Place = tuple[str | int, ...]
Limits = tuple[float, float]


class MistakeError(Exception):
    """A mistake in a part of a file: its place, the message with a remedy, and the value that was written."""

    def __init__(self, place: Place, text: str, value: Any) -> None:
        super().__init__(text)
        self.place, self.text, self.value = place, text, value


def is_modulus(field: Located) -> bool:
    """Tell whether a field takes a modulus: a number or a law."""
    info = type(field.owner).model_fields[field.field]
    labels = [item for item in annotated_with(info) if isinstance(item, UnitLabel)]
    return any(label.symbol == "Pa" and not isinstance(label, Unit) for label in labels)


def limits_of(field: Located) -> Limits:
    """Return the limits of a field, which of a modulus are at least 0; the ends may be excluded."""
    low, high = field_limits(type(field.owner).model_fields[field.field])
    return max(low, 0.0) if is_modulus(field) else low, high


def pair(place: Place, written: Any, unit: str) -> tuple[float, float]:
    """Return two values in SI.

    Raises
    ------
    MistakeError
        When these are not two finite numbers of that unit.
    """
    if not isinstance(written, list | tuple) or len(written) != 2:
        raise MistakeError(place, f"two values are needed, not {show(written)}", written)
    first, second = (_value((*place, i), value, unit) for i, value in enumerate(written))
    return first, second


def _value(place: Place, written: Any, unit: str) -> float:
    try:
        value = parse_quantity(written, unit)
    except ValueError as error:
        raise MistakeError(place, str(error), written) from None
    if not np.isfinite(value):
        raise MistakeError(place, f"{show(written)} is not finite", written)
    return value


def _spread(place: Place, written: Any, mean: float, unit: str) -> float:
    """Return a standard deviation: a difference, or a share of the mean."""
    if isinstance(written, str) and written.strip().endswith("%"):
        return _value(place, written, "") * abs(mean)
    if isinstance(written, str) and unit == "K" and not written.rstrip().endswith("K"):
        raise MistakeError(place, f"{show(written)} is no difference of temperatures; write it in K", written)
    return _value(place, written, unit)


def prior_of(entry: Any, unit: str, limits: Limits) -> Prior:
    """Return the prior of a field as a file states it.

    A normal or lognormal prior that reaches beyond the field's limits is truncated there.

    Parameters
    ----------
    entry : UnknownFile
    unit : str
        Unit of the field.
    limits : (low, high)
        Limits of the field.

    Raises
    ------
    MistakeError
        When the values are not numbers, in another unit, or outside the limits.
    """
    kind = entry.kind
    numbers = _numbers(kind, getattr(entry, kind), unit)
    ends = numbers if kind in ("uniform", "loguniform") else numbers[:1]
    _refuse_outside((kind,), ends, limits)
    bounds = None
    if entry.bounds is not None:
        bounds = pair(("bounds",), entry.bounds, unit)
        _refuse_outside(("bounds",), bounds, limits)
    elif len(ends) == 1:
        bounds = _cut(kind, numbers, limits)
    try:
        return Prior.model_validate({kind: numbers, "bounds": bounds})
    except ValidationError as error:
        raise MistakeError((kind,), "; ".join(str(item["msg"]) for item in error.errors()), numbers) from None


def _numbers(kind: str, written: Any, unit: str) -> tuple[float, float]:
    if kind in ("uniform", "loguniform"):
        return pair((kind,), written, unit)
    first = _value((kind, 0), written[0], unit)
    second = written[1]
    return first, _value((kind, 1), second, "") if kind == "lognormal" else _spread((kind, 1), second, first, unit)


def _refuse_outside(place: Place, values: tuple[float, ...], limits: Limits) -> None:
    for i, value in enumerate(values):
        if not limits[0] <= value <= limits[1]:
            allowed = f"from {limits[0]:g}" if np.isinf(limits[1]) else f"from {limits[0]:g} to {limits[1]:g}"
            raise MistakeError((*place, i), f"{value:g} is not allowed: the field may be {allowed}", value)


def _cut(kind: str, numbers: tuple[float, float], limits: Limits) -> Limits | None:
    """Return bounds where the field's limits truncate the prior."""
    centre, reach = numbers[0], _FAR * numbers[1]
    low, high = centre - reach, centre + reach
    if kind == "lognormal":
        with np.errstate(over="ignore"):  # no bound, then
            low, high = centre * np.exp(-reach), centre * np.exp(reach)
    if low >= limits[0] and high <= limits[1]:
        return None
    return max(float(low), limits[0]), min(float(high), limits[1])
