"""Tolerances of fields, and samples drawn within them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ValidationError

from multilayer.arrays import BoolArray, RealArray
from multilayer.errors import InputError, Problem, show
from multilayer.paths import Located, locate, with_values
from multilayer.simulation.sweep import place
from multilayer.stack import Stack
from multilayer.units import parse_quantity

_FORMS = "'5 %', a quantity such as '1 mm', {normal: '5 %'}, {normal: [mean, std]} or {uniform: [low, high]}"
_MOST_ROUNDS = 50
# round after which nine draws of ten that are still refused, and so many of them, will not all be allowed by the last
_HOPELESS, _MANY = 10, 100
_ASKED = 20  # refused draws that are asked why


@dataclass(frozen=True)
class Tolerance:
    """The distribution of a field's value.

    Attributes
    ----------
    shape : {"uniform", "normal"}
        Anywhere within ± `width`, or normal with `width` as its standard deviation.
    centre : float or None
        None for the nominal value of the field.
    width : float
        In SI, or as a fraction of the nominal value where `relative`.
    relative : bool
    """

    shape: Literal["uniform", "normal"]
    centre: float | None
    width: float
    relative: bool = False

    def values(self, nominal: Any, standard: RealArray) -> Any:
        """Return samples from `standard` ones: uniform in [-1, 1], or normal with mean 0 and variance 1."""
        if self.relative:
            return nominal * (1 + self.width * standard)
        return (nominal if self.centre is None else self.centre) + self.width * standard


def parse_tolerance(written: Any, field: Located) -> Tolerance:
    """Return the tolerance of a field from an input.

    Raises
    ------
    InputError
        When it is no tolerance, or its unit does not fit the field.
    """
    if field.value is None:
        raise InputError("a tolerance needs a nominal value, and this field is left to its default; write it out")
    if field.unit is None or not isinstance(field.value, int | float | complex) or isinstance(field.value, bool):
        raise InputError(f"a tolerance needs a number, and the nominal value is {show(_shown(field.value))}")
    try:
        return _parse(written, field)
    except ValueError as error:
        raise InputError(str(error)) from None


def _shown(value: Any) -> Any:
    return f"{type(value).__name__}(...)" if isinstance(value, BaseModel) else value


def _parse(written: Any, field: Located) -> Tolerance:
    assert field.unit is not None
    if not isinstance(written, Mapping):
        return _about("uniform", field.value, written, field.unit)
    if len(written) != 1 or next(iter(written)) not in ("normal", "uniform"):
        raise ValueError(f"{show(dict(written))} is no tolerance; write {_FORMS}")
    (shape, given), *_ = written.items()
    if not isinstance(given, list | tuple):
        return _about(shape, field.value, given, field.unit)
    if len(given) != 2 or isinstance(field.value, complex):
        about = "a complex value scatters by a share, as '5 %'" if len(given) == 2 else "two values are needed"
        raise ValueError(f"{show(list(given))} is no tolerance here: {about}")
    first = _finite(given[0], field.unit)
    if shape == "uniform":
        last = _finite(given[1], field.unit)
        return Tolerance("uniform", (first + last) / 2, _positive((last - first) / 2, "high must lie above low"))
    about_mean = _about("normal", first, given[1], field.unit)
    width = about_mean.width * abs(first) if about_mean.relative else about_mean.width
    return Tolerance("normal", first, width)


def _about(shape: Literal["uniform", "normal"], centre: complex, written: Any, unit: str) -> Tolerance:
    """Return a tolerance about the nominal value, from its half width or standard deviation about `centre`."""
    if isinstance(written, str) and written.strip().endswith("%"):
        if centre == 0:
            raise ValueError(f"{written.strip()} of 0 is 0; write an absolute one{f' in {unit}' if unit else ''}")
        return Tolerance(shape, None, _positive(parse_quantity(written, ""), "it must be above 0 %"), relative=True)
    if not isinstance(written, str | int | float) or isinstance(written, bool):
        raise ValueError(f"{show(written)} is no tolerance; write {_FORMS}")
    return Tolerance(shape, None, _positive(_difference(written, unit), "it must be above 0"))


def _difference(written: str | float, unit: str) -> float:
    """Return a difference in SI; one of temperatures must be in K, since 2 degC would be read as 275.15 K."""
    if isinstance(written, str) and unit == "K" and not written.rstrip().endswith("K"):
        raise ValueError(f"{show(written)} is no difference of temperatures; write it in K, as '2 K'")
    return _finite(written, unit)


def _finite(written: Any, unit: str) -> float:
    value = parse_quantity(written, unit)
    if not np.isfinite(value):
        raise ValueError(f"{show(written)} is not finite")
    return value


def _positive(width: float, otherwise: str) -> float:
    if not (np.isfinite(width) and width > 0):
        raise ValueError(f"a tolerance of {width:g} is not allowed: {otherwise}")
    return width


def draw(model: BaseModel, tolerances: Mapping[str, Tolerance], samples: int, seed: int) -> dict[str, Any]:
    """Return `samples` values of each field within its tolerance, independent of each other.

    Values that the model refuses, such as a porosity above 1, or a patch larger than its wall, are drawn again.

    Parameters
    ----------
    model : BaseModel
        Holds the fields, with their nominal values.
    tolerances : mapping
        By path.
    samples : int
    seed : int
        The same seed gives the same draws, wherever results are computed from them.

    Raises
    ------
    InputError
        When hardly any draw is allowed.
    """
    rng = np.random.default_rng(seed)
    fields = {path: locate(model, path) for path in tolerances}
    drawn = _draw(fields, tolerances, samples, rng)
    bad = np.ones(samples, dtype=bool)
    for number in range(_MOST_ROUNDS):
        bad[bad] = ~allowed(fields, {path: values[bad] for path, values in drawn.items()}, model)
        if not bad.any():
            return drawn
        if number == _HOPELESS and np.count_nonzero(bad) > max(0.9 * samples, _MANY):
            break
        for path, values in _draw(fields, tolerances, int(bad.sum()), rng).items():
            drawn[path][bad] = values
    refused = {path: values[bad][:_ASKED] for path, values in drawn.items()}
    text = f"of {', '.join(tolerances)} hardly any draw is allowed ({_why_refused(fields, refused, model)})"
    raise InputError(Problem(f"{text}; narrow the tolerances, or move their means", "tolerances"))


def _why_refused(fields: Mapping[str, Located], drawn: Mapping[str, Any], model: BaseModel) -> str:
    """Return what is wrong with one of some draws, of those that get farthest."""
    left, why = [*range(len(next(iter(drawn.values()))))], ""
    for holder, inside in _holders(fields, drawn, model):
        told = {i: _refusal(holder, _row(inside, i)) for i in left}
        why = next(filter(None, told.values()), why)
        left = [i for i in left if not told[i]]
    return why


def _draw(
    fields: Mapping[str, Located], tolerances: Mapping[str, Tolerance], n: int, rng: np.random.Generator
) -> dict[str, Any]:
    def standard(shape: str) -> RealArray:
        return rng.uniform(-1, 1, n) if shape == "uniform" else rng.standard_normal(n)

    return {
        path: tolerance.values(fields[path].value, standard(tolerance.shape)) for path, tolerance in tolerances.items()
    }


def allowed(fields: Mapping[str, Located], drawn: Mapping[str, Any], model: BaseModel | None = None) -> BoolArray:
    """Return which draws are valid for every model that holds one of the fields.

    Parameters
    ----------
    fields : mapping
        By path.
    drawn : mapping
        Values by path, arrays of one length.
    model : BaseModel, optional
        From which the paths lead: what lies between, as the layer whose patches have shares, must be valid, too.
    """
    good = np.ones(len(next(iter(drawn.values()))), dtype=bool)
    for holder, inside in _holders(fields, drawn, model):
        left = {path: values[good] for path, values in inside.items()}
        n = int(good.sum())
        if n and not _all_fit(holder, left, n):
            good[good] = [_fits(holder, _row(left, i)) for i in range(n)]
    return good


def _row(drawn: Mapping[str, Any], i: int) -> dict[str, Any]:
    return {path: values[i].item() for path, values in drawn.items()}


def _holders(
    fields: Mapping[str, Located], drawn: Mapping[str, Any], model: BaseModel | None
) -> list[tuple[BaseModel, dict[str, Any]]]:
    """Return the models that hold fields, the innermost first, each with what is drawn by the paths from there."""
    if model is None:
        owners = {id(field.owner): (field.owner, dict[str, Any]()) for field in fields.values()}
        for path, field in fields.items():
            owners[id(field.owner)][1][field.field] = drawn[path]
        return list(owners.values())
    found: dict[tuple[str, ...], tuple[BaseModel, dict[str, Any]]] = {}
    for path, values in drawn.items():
        item: Any = model
        tokens = place(model, path)
        for i, token in enumerate(tokens):
            if isinstance(item, BaseModel):
                if type(item) is not Stack:  # whose own rules are of names and contacts
                    found.setdefault(tokens[:i], (item, {}))[1][".".join(tokens[i:])] = values
                item = getattr(item, token)
            else:
                item = item[int(token)]
    return [found[at] for at in sorted(found, key=len, reverse=True)]


def _all_fit(holder: BaseModel, drawn: Mapping[str, Any], n: int) -> bool:
    """Return whether every corner of the box that draws span is valid, where that is quicker to tell than each draw.

    Then so is what lies between: a rule of a model bounds a field or compares fields, is monotone in each or convex
    (positive definite stiffness), and so holds in a box where it holds at its corners.
    """
    if 2 ** len(drawn) >= n:
        return False
    corners = product(*(_extremes(values) for values in drawn.values()))
    return all(_fits(holder, dict(zip(drawn, corner, strict=True))) for corner in corners)


def _extremes(values: Any) -> tuple[Any, Any]:
    """Return the lowest and highest value; complex ones lie on a line through zero."""
    along = (values * np.conj(values[0])).real if np.iscomplexobj(values) else values
    return values[np.argmin(along)].item(), values[np.argmax(along)].item()


def _fits(holder: BaseModel, values: Mapping[str, Any]) -> bool:
    return not _refusal(holder, values)


def _refusal(holder: BaseModel, values: Mapping[str, Any]) -> str:
    """Return what is wrong with a model that has other values at some paths; nothing if it is valid."""
    deeper = {path: value for path, value in values.items() if "." in path}
    own = {name: value for name, value in values.items() if name not in deeper}  # in a dict, which is faster
    try:
        type(holder).model_validate({**dict(with_values(holder, deeper)), **own})
    except ValidationError as error:
        return error.errors(include_url=False)[0]["msg"].removeprefix("Value error, ")
    return ""
