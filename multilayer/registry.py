"""Registries fed by entry points: how layers, modulus laws, effects and readers are found, the built-in ones included.

Nothing is imported until its name is asked for, so a plugin that fails on import cannot stop the rest. Looking up a
name gives its object or raises a `RegistryError`; `Registry.working` goes through all names, leaves broken plugins out
and warns of each.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar

from multilayer.errors import MultilayerError, PluginWarning, suggest

T = TypeVar("T")


class RegistryError(MultilayerError):
    """A name defined twice, an unknown name, or a plugin that does not load."""


@dataclass(frozen=True)
class Origin:
    """Where an object of a registry comes from.

    Attributes
    ----------
    value : str
        ``module:name``, or a file.
    package, version : str
        Of the distribution that brings it; empty for an object that was added by `Registry.register`.
    """

    value: str
    package: str = ""
    version: str = ""

    def __str__(self) -> str:
        return f"{self.value} (package {self.package} {self.version})" if self.package else self.value


def _origin(entry: EntryPoint) -> Origin:
    dist = entry.dist
    return Origin(entry.value, dist.name, dist.version) if dist is not None else Origin(entry.value)


class Registry(Generic[T]):
    """Objects by name, from one entry-point group and from `register`.

    Parameters
    ----------
    group : str
        Entry-point group, as ``multilayer.layers``.
    kind : str
        What the objects are, for messages, as ``layer``.
    fault : callable, optional
        Called with a name and the object registered under it; returns what is wrong with it, or an empty text.
    """

    def __init__(self, group: str, kind: str, fault: Callable[[str, Any], str] | None = None) -> None:
        self.group, self.kind = group, kind
        self._fault = fault
        self._local: dict[str, tuple[T, Origin]] = {}
        self._failed: dict[str, RegistryError] = {}
        # a package's metadata is read and parsed whenever it is asked for, and a stack looks up each of its layers
        self._origins: dict[str, list[Origin]] = {}

    @cached_property
    def _entries(self) -> dict[str, list[EntryPoint]]:
        entries: dict[str, list[EntryPoint]] = {}
        for entry in entry_points(group=self.group):
            # an editable install may list the same entry twice: only different targets are two
            if all(other.value != entry.value for other in entries.setdefault(entry.name, [])):
                entries[entry.name].append(entry)
        return entries

    def register(self, name: str, item: T, origin: str = "") -> T:
        """Add an object under a name.

        Raises
        ------
        RegistryError
            When the name is taken, naming both owners, or the object is of the wrong kind.
        """
        place = Origin(origin or f"{getattr(item, '__module__', '?')}:{getattr(item, '__qualname__', item)}")
        owners = self.origins(name)
        if owners:
            raise RegistryError(self._taken(name, [*owners, str(place)]))
        self._refuse_faulty(name, item, place)
        self._local[name] = (item, place)
        return item

    def unregister(self, name: str) -> None:
        """Remove what `register` added."""
        self._local.pop(name, None)

    def owners(self, name: str) -> list[Origin]:
        """Return where a name comes from: empty when it is unknown, several when it is defined more than once."""
        local = [self._local[name][1]] if name in self._local else []
        if name in self._entries and name not in self._origins:
            self._origins[name] = [_origin(entry) for entry in self._entries[name]]
        return self._origins.get(name, []) + local

    def origins(self, name: str) -> list[str]:
        """Return the `owners` as text."""
        return [str(owner) for owner in self.owners(name)]

    def names(self) -> list[str]:
        """Return all names, sorted."""
        return sorted({*self._entries, *self._local})

    def chosen(self, names: Sequence[str] | None = None) -> list[str]:
        """Return some names as given, or all of them.

        Raises
        ------
        RegistryError
            For an unknown name, with the nearest.
        """
        for name in names or ():
            if name not in self:
                raise RegistryError(f"no {self.kind} is called '{name}'; {suggest(name, self.names())}")
        return list(names) if names else self.names()

    def working(self) -> Iterator[tuple[str, T]]:
        """Give all names with their objects; a broken plugin is left out with a `PluginWarning`."""
        for name in self.names():
            try:
                item = self[name]
            except RegistryError as error:
                warnings.warn(f"left out: {error}", PluginWarning, stacklevel=2)
            else:
                yield name, item

    def __contains__(self, name: object) -> bool:
        # an input may hold anything here, unhashable lists too
        return isinstance(name, str) and (name in self._entries or name in self._local)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def __getitem__(self, name: str) -> T:
        owners = self.origins(name)
        if len(owners) > 1:
            raise RegistryError(self._taken(name, owners))
        if name in self._local:
            return self._local[name][0]
        if name not in self._entries:
            raise RegistryError(f"no {self.kind} is called '{name}'; {suggest(name, self.names())}")
        if name in self._failed:  # once is enough: a plugin may take its time to fail
            raise self._failed[name]
        try:
            return self._load(self._entries[name][0])
        except RegistryError as error:
            self._failed[name] = error
            raise

    def _load(self, entry: EntryPoint) -> T:
        try:
            loaded: Any = entry.load()
        except (Exception, SystemExit) as error:  # a plugin may fail in any way; it is named and the rest goes on
            what = f"{self.kind} '{entry.name}' of {self.owners(entry.name)[0]}"
            raise RegistryError(f"{what} does not load: {type(error).__name__}: {error}") from error
        self._refuse_faulty(entry.name, loaded, self.owners(entry.name)[0])
        item: T = loaded
        return item

    def _refuse_faulty(self, name: str, item: Any, origin: Origin) -> None:
        fault = self._fault(name, item) if self._fault is not None else ""
        if fault:
            raise RegistryError(f"{self.kind} '{name}' of {origin} cannot be used: {fault}")

    def _taken(self, name: str, owners: list[str]) -> str:
        by = " and by ".join(owners)
        return f"{self.kind} '{name}' is defined twice, by {by}; rename or remove one of them"


def subclass_fault(base: type, field: str) -> Callable[[str, Any], str]:
    """Return a check that a plugin is a subclass of `base` which states its own name in `field`.

    Parameters
    ----------
    base : type
        A pydantic model, whose field has the name as its default, or a class with an attribute.
    field : str
    """

    def fault(name: str, item: Any) -> str:
        from pydantic import BaseModel  # heavy

        if not (isinstance(item, type) and issubclass(item, base)):
            return f"it is {item!r}, not a subclass of {base.__module__}.{base.__name__}"
        missing: frozenset[str] = getattr(item, "__abstractmethods__", frozenset())
        if missing:
            return f"it defines no {', '.join(sorted(missing))}"
        if issubclass(item, BaseModel):
            try:
                item.model_rebuild()
            except Exception as error:  # whatever its fields' types and bounds make pydantic say
                return f"its fields make no model: {' '.join(str(error).split())}"
        fields: dict[str, Any] = getattr(item, "model_fields", {})
        stated = fields[field].default if field in fields else getattr(item, field, None)
        return "" if stated == name else f"its '{field}' is {stated!r}; it must be {name!r}, the name it is found under"

    return fault
