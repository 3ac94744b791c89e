"""Paths into a model: from ``layers.foam.thickness`` to the field it names, and back with another value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, log10
from typing import Any, TypeVar

from pydantic import BaseModel

from multilayer.bounds import magnitudes
from multilayer.errors import InputError, show, suggest
from multilayer.units import field_unit

M = TypeVar("M", bound=BaseModel)


@dataclass(frozen=True)
class Located:
    """A field of a model: the model inside which it stands, its name, its value, and its unit."""

    owner: BaseModel
    field: str
    value: Any
    unit: str | None


def locate(model: BaseModel, path: str) -> Located:
    """Return the field that a dotted path names.

    Parameters
    ----------
    model : BaseModel
        Layers are named by their `name` or index.
    path : str
        As ``layers.foam.thickness`` or ``layers.foam.young_modulus.order``.

    Raises
    ------
    InputError
        When the path leads nowhere, with the nearest that does.
    """
    item, field, value = _found(model, path)
    return Located(item, field, value, field_unit(type(item).model_fields[field]))


def value_at(model: BaseModel, path: str) -> Any:
    """Return the value of the field that a dotted path names; see `locate`, of which this is the faster half."""
    return _found(model, path)[2]


def _found(model: BaseModel, path: str) -> tuple[BaseModel, str, Any]:
    *parents, field = path.split(".")
    item: Any = model
    for done, token in enumerate(parents):
        item = _child(item, token, ".".join(parents[:done]))
    value = _child(item, field, ".".join(parents))
    if not isinstance(item, BaseModel):
        raise InputError(f"leads to no single value; {_inside(value)}")
    return item, field, value


def unit_of(model: BaseModel, path: str) -> str | None:
    """Return the unit of the field at a path; None where there is none, or no single field."""
    try:
        return locate(model, path).unit
    except InputError:
        return None


def extremes(model: BaseModel) -> list[tuple[str, str, float]]:
    """Return the fields of a model that hold quantities, the most extreme first.

    Parameters
    ----------
    model : BaseModel

    Returns
    -------
    list of (str, str, float)
        Path, value with its unit, and how many decades it lies from what is usual (`bounds.MAGNITUDES`). Arrays and
        zeros are left out.
    """
    return sorted(_quantities(model, ()), key=lambda found: -found[2])


def _quantities(item: Any, path: tuple[str, ...]) -> Iterator[tuple[str, str, float]]:
    if isinstance(item, tuple):
        for i, inner in enumerate(item):
            yield from _quantities(inner, (*path, str(i)))
    if not isinstance(item, BaseModel):
        return
    for name, info in type(item).model_fields.items():
        value, unit = getattr(item, name), field_unit(info)
        if unit is None or not isinstance(value, int | float | complex):
            yield from _quantities(value, (*path, name))
        elif isfinite(abs(value)) and value:
            decades = abs(log10(abs(value) / magnitudes(unit).usual))
            yield ".".join((*path, name)), f"{value:g} {unit}".rstrip(), decades


def _inside(value: Any) -> str:
    names = sorted(type(value).model_fields) if isinstance(value, BaseModel) else []
    return f"name one of its fields: {', '.join(names)}" if names else "name one of its fields"


def _child(item: Any, token: str, where: str) -> Any:
    if isinstance(item, tuple):
        return item[index_of(item, token, where)]
    if not isinstance(item, BaseModel):
        raise InputError(f"leads nowhere: {where} is {show(item)}, which has no fields")
    if token not in type(item).model_fields:
        raise InputError(f"leads nowhere: there is no '{token}'; {suggest(token, type(item).model_fields)}")
    return getattr(item, token)


def positions(items: Sequence[Any]) -> dict[str | int, int]:
    """Return where models or mappings stand in a list, by what they may be called.

    A number is a position; a text is a name and, where nothing has that name, a position.
    """
    known: dict[str | int, int] = {}
    for i in range(len(items)):
        known[i] = known[str(i)] = i
    known.update((str(name), i) for i, item in enumerate(items) if (name := _name(item)) is not None)
    return known


def index_of(items: Sequence[Any], token: str | int, where: str) -> int:
    """Return the position that a name or an index has in a list of models or mappings; see `positions`.

    Raises
    ------
    InputError
        When there is none, with the nearest name.
    """
    known = positions(items)
    if token in known:
        return known[token]
    texts = [name for name in known if isinstance(name, str)]
    remedy = suggest(str(token), [name for name in texts if not name.isdecimal()] or texts)
    if dotted := next((name for name in texts if name.startswith(f"{token}.")), ""):
        remedy = f"a path cannot hold the point in the name '{dotted}': write its index, {known[dotted]}"
    raise InputError(f"leads nowhere: there is no '{token}' in {where}; {remedy}")


def token_of(items: Sequence[Any], i: int) -> str:
    """Return what stands for an item in a path: its name, or its index where it has none that a path can hold."""
    name = _name(items[i])
    return str(name) if name and "." not in str(name) else str(i)


def _name(item: Any) -> Any:
    return item.get("name") if isinstance(item, Mapping) else getattr(item, "name", None)


def with_values(model: M, values: Mapping[str, Any]) -> M:
    """Return a copy of `model` with some fields changed, not validated: arrays may stand where numbers do.

    Parameters
    ----------
    model : BaseModel
    values : mapping
        By dotted path, as for `locate`.
    """
    for path, value in values.items():
        model = _changed(model, path.split("."), value)
    return model


def _changed(item: Any, tokens: Sequence[str], value: Any) -> Any:
    if not tokens:
        return value
    head, rest = tokens[0], tokens[1:]
    if isinstance(item, tuple):
        i = index_of(item, head, "")
        return (*item[:i], _changed(item[i], rest, value), *item[i + 1 :])
    return item.model_copy(update={head: _changed(getattr(item, head), rest, value)})


def with_entry(data: Any, path: str, value: Any) -> Any:
    """Return a copy of plain data, as YAML holds it, with one entry changed or added.

    Parameters
    ----------
    data : dict or list
    path : str
        As for `locate`.
    value : object

    Raises
    ------
    InputError
        When the path leads through a value that has no entries.
    """
    return _with_entry(data, path.split("."), value, [])


def _with_entry(data: Any, tokens: Sequence[str], value: Any, done: list[str]) -> Any:
    if not tokens:
        return value
    head, rest, where = tokens[0], tokens[1:], ".".join(done)
    if isinstance(data, list | tuple):
        i = index_of(data, head, where)
        return [*data[:i], _with_entry(data[i], rest, value, [*done, head]), *data[i + 1 :]]
    if isinstance(data, BaseModel):  # a model written in Python
        data = data.model_dump(mode="json", by_alias=True, exclude_none=True)
    if data is not None and not isinstance(data, Mapping):
        raise InputError(f"leads nowhere: {where} is {show(data)}, which has no fields")
    data = data or {}
    return {**data, head: _with_entry(data.get(head), rest, value, [*done, head])}
