"""What of a stack may vary: fields between bounds, choices, the order of layers, layers that may be left out."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from math import log, prod
from typing import Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError, show, suggest
from multilayer.models import Model
from multilayer.paths import index_of, locate, token_of, value_at, with_entry
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.sweep import set_twice, texts, value_mistakes
from multilayer.stack import Stack
from multilayer.units import parse_quantity

ORDER, OPTIONAL, AMONG = "order", "optional", "among"
_CHOSEN = ("layers", "contacts", "termination")  # what choices may be made of
_WIDE = 10.0  # bounds whose ratio is larger are searched on a logarithmic axis
_FORMS = "two bounds, as [10 mm, 50 mm], or {among: [A, B]}"
Mistake = tuple[tuple[str | int, ...], str, Any]
Key = tuple[int, ...]


@dataclass(frozen=True)
class Range:
    """A field that may take any value between two bounds.

    Attributes
    ----------
    path : str
        As in the file; in a variant that of the layer where it stands there.
    low, high : float
        SI.
    unit : str
    name : str
        The path in the file, without ``layers.``.
    """

    path: str
    low: float
    high: float
    unit: str
    name: str

    @property
    def is_logarithmic(self) -> bool:
        """Whether equal ratios, not equal differences, are equally far apart in the search."""
        return self.low > 0 and self.high > _WIDE * self.low

    def values(self, coordinate: RealArray) -> RealArray:
        """Return values, SI, of coordinates from 0 to 1."""
        if self.is_logarithmic:
            between = self.low * np.exp(np.asarray(coordinate) * log(self.high / self.low))
        else:
            between = self.low + (self.high - self.low) * np.asarray(coordinate)
        return np.clip(between, self.low, self.high)  # rounding must not lead out

    def slope(self, coordinate: float) -> float:
        """Return the derivative of the value, SI, by the coordinate."""
        if self.is_logarithmic:
            return float(self.values(np.asarray(coordinate))) * log(self.high / self.low)
        return self.high - self.low

    def coordinate(self, value: float) -> float:
        """Return the coordinate of a value, that of the nearer bound where it lies outside."""
        value = min(max(value, self.low), self.high)
        if self.is_logarithmic:
            return log(value / self.low) / log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


@dataclass(frozen=True)
class Variant:
    """A design in which all choices are made: only fields between bounds are left.

    Attributes
    ----------
    key : tuple of int
        Of its choices.
    shown : mapping
        The choices as text, by name.
    simulation : SimulationFile
        What is simulated, the fields between bounds as the file has them.
    ranges : tuple of Range
        Those whose layer is there.
    materials : tuple of str or None
        Of the library, by layer.
    """

    key: Key
    shown: Mapping[str, str]
    simulation: SimulationFile
    ranges: tuple[Range, ...]
    materials: tuple[str | None, ...]

    @cached_property
    def stack(self) -> Stack:
        """The stack alone, the fields between bounds as the file has them."""
        return self.simulation.stack

    @cached_property
    def identity(self) -> str:
        """What tells it from variants of other choices: those alike in this are the same designs.

        The simulation holds the fields of materials, not their names, by which a catalogue has prices.
        """
        between = sorted((item.path, item.low, item.high) for item in self.ranges)
        return repr((self.simulation.to_dict(), self.materials, between))

    @property
    def label(self) -> str:
        """The choices as text."""
        return ", ".join(f"{name} = {text}" for name, text in self.shown.items())

    def values(self, x: RealArray) -> dict[str, RealArray]:
        """Return values by path of coordinates, shape (..., n_ranges)."""
        return {item.path: item.values(x[..., i]) for i, item in enumerate(self.ranges)}

    def slopes(self, x: RealArray) -> RealArray:
        """Return the derivatives of the values by their coordinates, both of shape (n_ranges,)."""
        return np.array([item.slope(float(x[i])) for i, item in enumerate(self.ranges)])

    @property
    def written(self) -> RealArray:
        """Coordinates of the values in the file, or of the middle where it has none."""
        there = [value_at(self.simulation, item.path) for item in self.ranges]
        pairs = zip(self.ranges, there, strict=True)
        return np.array([item.coordinate(value) if isinstance(value, int | float) else 0.5 for item, value in pairs])


@dataclass(frozen=True)
class Space:
    """All designs.

    Attributes
    ----------
    data : mapping
        The simulation as it stands in the file.
    ranges : tuple of Range
    choices : mapping
        Values as written, by path.
    order, optional : tuple of int
        Positions of layers that may change places, and that may be left out.
    validated : callable
        From data to a SimulationFile.
    """

    data: Mapping[str, Any]
    ranges: tuple[Range, ...]
    choices: Mapping[str, tuple[Any, ...]]
    order: tuple[int, ...]
    optional: tuple[int, ...]
    validated: Callable[[Any], SimulationFile] = field(compare=False)

    @property
    def axes(self) -> Key:
        """How many alternatives there are of each choice.

        Those of an order are which of the layers left comes next: every combination is an order.
        """
        turns = range(len(self.order), 1, -1)
        return (*(len(values) for values in self.choices.values()), *(2 for _ in self.optional), *turns)

    @property
    def count(self) -> int:
        """Combinations of choices; some may be the same design."""
        return prod(self.axes)

    @property
    def keys(self) -> list[Key]:
        """All combinations of choices."""
        return [*product(*map(range, self.axes))]

    @cached_property
    def _texts(self) -> dict[str, list[str]]:
        """The choices as text by path, no two of a path alike."""
        return {path: texts(values, None) for path, values in self.choices.items()}

    @cached_property
    def _made(self) -> dict[Key, Variant | InputError]:
        return {}

    def variants(self, keys: Iterable[Key] | None = None) -> list[Variant]:
        """Return the variants of some keys, all when left out, that are allowed and differ."""
        different: dict[str, Variant] = {}
        for key in self.keys if keys is None else keys:
            if (variant := self.allowed(key)) is not None:
                different.setdefault(variant.identity, variant)
        return list(different.values())

    def allowed(self, key: Key) -> Variant | None:
        """Return the variant of some choices, None when these are not allowed together."""
        with suppress(InputError):
            return self.variant(key)
        return None

    def variant(self, key: Key) -> Variant:
        """Return the variant of some choices.

        Raises
        ------
        InputError
            When these are not allowed together, even if each is.
        """
        if key not in self._made:
            try:
                self._made[key] = self._variant(key)
            except InputError as error:
                self._made[key] = error
        made = self._made[key]
        if isinstance(made, InputError):
            raise InputError(made.problems)
        return made

    def _variant(self, key: Key) -> Variant:
        n, m = len(self.choices), len(self.optional)
        data, shown = dict(self.data), {}
        for (path, values), i in zip(self.choices.items(), key[:n], strict=True):
            data = with_entry(data, path, values[i])
            shown[path.removeprefix("layers.")] = self._texts[path][i]
        places = [*range(len(data["layers"]))]
        left = [*self.order]
        sequence = [left.pop(turn) for turn in (*key[n + m :], 0)] if left else []
        for place, i in zip(self.order, sequence, strict=True):
            places[place] = i
        without = {i for i, absent in zip(self.optional, key[n : n + m], strict=True) if absent}
        places = [i for i in places if i not in without]
        if not places:  # there must be one
            places = [self.optional[0]]
        if self.order:
            shown[ORDER] = ", ".join(self._name(i) for i in places if i in self.order)
        if without:
            shown["without"] = ", ".join(self._name(i) for i in sorted(without - set(places)))
        layers = data["layers"]
        data["layers"] = [layers[i] for i in places]
        if data.get("contacts"):
            data["contacts"] = [*self._contacts(data["contacts"], layers, places)]
        try:
            simulation = self.validated(data)
        except ValueError as error:  # of pydantic
            reasons = [f"{'.'.join(map(str, each['loc']))}: {each['msg']}" for each in getattr(error, "errors", list)()]
            label = ", ".join(f"{name} = {text}" for name, text in shown.items())
            raise InputError([f"{label}: {reason}" for reason in reasons] or str(error)) from None
        ranges = [self._moved(item, layers, places, simulation) for item in self.ranges]
        materials = tuple(layers[i].get("material") if isinstance(layers[i], Mapping) else None for i in places)
        return Variant(key, shown, simulation, tuple(item for item in ranges if item is not None), materials)

    def _name(self, i: int) -> str:
        layer = self.data["layers"][i]
        name = layer.get("name") if isinstance(layer, Mapping) else getattr(layer, "name", None)
        return str(name or i)

    @staticmethod
    def _moved(item: Range, layers: Any, places: list[int], simulation: SimulationFile) -> Range | None:
        """Return a range where its layer now stands; None where it is left out, or has no such field."""
        _, token, *rest = item.path.split(".")
        i = index_of(layers, token, "layers")
        if i not in places:
            return None
        path = ".".join(["layers", token_of(simulation.stack.layers, places.index(i)), *rest])
        try:
            locate(simulation, path)
        except InputError:
            return None
        return replace(item, path=path)

    @staticmethod
    def _contacts(contacts: Any, layers: Any, places: list[int]) -> Iterator[dict[str, Any]]:
        """Give the contacts of layers that are still neighbours."""
        for contact in contacts:
            ends = [
                len(places) if end == "termination" else _place(index_of(layers, end, "layers"), places)
                for end in contact["between"]
            ]
            if None not in ends and abs(ends[0] - ends[1]) == 1:
                yield {**contact, "between": ["termination" if end == len(places) else end for end in ends]}


def _place(i: int, places: list[int]) -> Any:
    return places.index(i) if i in places else None


def space_of(
    design: Mapping[str, Any], data: Mapping[str, Any], model: SimulationFile, validated: Callable[[Any], Any]
) -> tuple[Space, list[Mistake]]:
    """Return the space of a design and what is wrong with it.

    Parameters
    ----------
    design : mapping
        As it stands in the file.
    data : mapping
        The simulation as it stands there.
    model : SimulationFile
        The same, read.
    validated : callable
        From data to the model; raises ValidationError for data with mistakes.
    """
    ranges: list[Range] = []
    choices: dict[str, tuple[Any, ...]] = {}
    listed: dict[str, tuple[int, ...]] = {ORDER: (), OPTIONAL: ()}
    mistakes: list[Mistake] = []
    for path, entry in design.items():
        place = ("design", path)
        if path in listed:
            listed[path] = tuple(_layers_named(place, entry, data, mistakes))
        elif isinstance(entry, Mapping) and [*entry] == [AMONG]:
            choices[path] = tuple(_choices(place, path, entry[AMONG], data, validated, mistakes))
        elif isinstance(entry, list | tuple):
            ranges += _range(place, path, entry, data, model, validated, mistakes)
        else:
            mistakes.append((place, f"{show(entry)} says not what may vary; write {_FORMS}", entry))
    made = [*choices, *(item.path for item in ranges)]  # in this order
    mistakes += [(("design", path, "[key]"), text, path) for path, text in set_twice(data, made)]
    if len(listed[ORDER]) == 1:
        mistakes.append((("design", ORDER), "one layer alone has no order; name two or more", design[ORDER]))
    space = Space(data, tuple(ranges), choices, listed[ORDER], listed[OPTIONAL], validated)
    if not mistakes and not ranges and space.count == 1:
        text = "nothing may vary, there is nothing to choose; give a field two bounds, as layers.foam.thickness: "
        mistakes.append((("design",), f"{text}[10 mm, 50 mm]", dict(design)))
    return space, mistakes


def _layers_named(place: tuple[str, ...], entry: Any, data: Any, mistakes: list[Mistake]) -> Iterator[int]:
    if not isinstance(entry, list | tuple):
        mistakes.append((place, f"must be a list of layers, not {show(entry)}", entry))
        return
    seen = set[int]()
    for k, name in enumerate(entry):
        try:
            i = index_of(data["layers"], name if isinstance(name, int) else str(name), "layers")
        except InputError as error:
            mistakes.append(((*place, k), str(error), name))
            continue
        if i in seen:
            mistakes.append(((*place, k), "stands here a second time", name))
        seen.add(i)
        yield i


def _choices(
    place: tuple[str, ...], path: str, values: Any, data: Any, validated: Callable[[Any], Any], mistakes: list[Mistake]
) -> Iterator[Any]:
    if path.partition(".")[0] not in _CHOSEN:
        text = f"leads to nothing that can be chosen; {suggest(path.partition('.')[0], _CHOSEN)}"
        mistakes.append(((*place, "[key]"), text, path))
    elif not isinstance(values, list | tuple) or not values:
        mistakes.append(
            ((*place, AMONG), f"must be a list of what there is to choose from, not {show(values)}", values)
        )
    else:
        for i, value in enumerate(values):
            wrong = [*value_mistakes(data, path, value, validated)]
            mistakes += [((*place, *(("[key]",) if at_key else (AMONG, i))), text, value) for at_key, text in wrong]
            if value in values[:i]:
                mistakes.append(((*place, AMONG, i), "stands here a second time", value))
            yield value


def _range(
    place: tuple[str, ...],
    path: str,
    ends: Any,
    data: Any,
    model: Model,
    validated: Callable[[Any], Any],
    mistakes: list[Mistake],
) -> Iterator[Range]:
    try:
        if not path.startswith("layers."):
            raise InputError("leads to no field of a layer; write layers.NAME.FIELD")
        there = locate(model, path)
        if there.unit is None or isinstance(there.value, bool) or not isinstance(there.value, int | float | None):
            raise InputError(f"bounds need a field that holds a number; here it holds {show(there.value)}")
    except InputError as error:
        mistakes.append(((*place, "[key]"), str(error), path))
        return
    if len(ends) != 2:
        mistakes.append((place, f"{len(ends)} bounds are not understood; write {_FORMS}", ends))
        return
    numbers, before = [], len(mistakes)
    for i, end in enumerate(ends):
        try:
            numbers.append(parse_quantity(end, there.unit))
        except ValueError as error:
            mistakes.append(((*place, i), str(error), end))
            continue
        mistakes += [((*place, i), text, end) for _, text in value_mistakes(data, path, end, validated)]
    if len(mistakes) > before:
        return
    if not numbers[0] < numbers[1]:
        text = f"the lower bound, {show(ends[0])}, must lie below the upper one, {show(ends[1])}; it comes first"
        mistakes.append((place, text, ends))
        return
    yield Range(path, numbers[0], numbers[1], there.unit, path.removeprefix("layers."))
