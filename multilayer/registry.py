"""Registries fed by entry points: how layers, modulus laws and readers are found, the built-in ones included.

Nothing is imported until its name is asked for, so a plugin that fails on import cannot stop the rest.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar

from multilayer.errors import MultilayerError, suggest

T = TypeVar("T")


class RegistryError(MultilayerError):
    """A name taken twice, a name nobody knows, or a plugin that does not load."""


def _origin(entry: EntryPoint) -> str:
    dist = entry.dist
    return f"{entry.value} (package {dist.name} {dist.version})" if dist is not None else entry.value


class Registry(Generic[T]):
    """Objects by name, from one entry-point group and from `register`.

    Parameters
    ----------
    group : str
        Entry-point group, as ``multilayer.layers``.
    kind : str
        What is in it, for messages.
    """

    def __init__(self, group: str, kind: str) -> None:
        self.group, self.kind = group, kind
        self._local: dict[str, tuple[T, str]] = {}

    @cached_property
    def _entries(self) -> dict[str, list[EntryPoint]]:
        found: dict[str, list[EntryPoint]] = {}
        for entry in entry_points(group=self.group):
            # an editable install may list the same entry twice: only different targets are two
            if all(other.value != entry.value for other in found.setdefault(entry.name, [])):
                found[entry.name].append(entry)
        return found

    def register(self, name: str, item: T, origin: str = "") -> T:
        """Add an object under a name.

        Raises
        ------
        RegistryError
            When the name is taken, naming both owners.
        """
        origin = origin or f"{getattr(item, '__module__', '?')}:{getattr(item, '__qualname__', item)}"
        owners = self.origins(name)
        if owners:
            raise RegistryError(self._taken(name, [*owners, origin]))
        self._local[name] = (item, origin)
        return item

    def unregister(self, name: str) -> None:
        """Remove what `register` added."""
        self._local.pop(name, None)

    def origins(self, name: str) -> list[str]:
        """Return where a name comes from: empty when unknown, more than one when it is taken twice."""
        local = [self._local[name][1]] if name in self._local else []
        return [_origin(entry) for entry in self._entries.get(name, [])] + local

    def names(self) -> list[str]:
        """Return all names, sorted."""
        return sorted({*self._entries, *self._local})

    def chosen(self, names: Sequence[str] | None = None) -> list[str]:
        """Return some names as given, or all of them.

        Raises
        ------
        RegistryError
            For one that nobody knows, with the nearest.
        """
        for name in names or ():
            if name not in self:
                raise RegistryError(f"no {self.kind} is called '{name}'; {suggest(name, self.names())}")
        return list(names) if names else self.names()

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
        return self._load(self._entries[name][0])

    def _load(self, entry: EntryPoint) -> T:
        try:
            loaded: Any = entry.load()
        except Exception as error:  # a plugin may fail in any way; it is named and the rest goes on
            what = f"{self.kind} '{entry.name}' of {_origin(entry)}"
            raise RegistryError(f"{what} does not load: {type(error).__name__}: {error}") from error
        item: T = loaded
        return item

    def _taken(self, name: str, owners: list[str]) -> str:
        by = " and by ".join(owners)
        return f"{self.kind} '{name}' is defined twice, by {by}; rename or remove one of them"
