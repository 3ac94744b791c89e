"""Every kind of plugin with its registry, and the origin of every registered name."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from multilayer.registry import Registry, RegistryError

# kind of plugin on the command line -> module and name of its registry, which is imported on use
_REGISTRIES = {
    "layer": ("multilayer.layers.base", "LAYERS"),
    "law": ("multilayer.media.laws.base", "LAWS"),
    "effect": ("multilayer.diagnosis.effects.base", "EFFECTS"),
    "method": ("multilayer.fits.methods", "METHODS"),
    "reader": ("multilayer.measurements.readers", "READERS"),
    "rig effect": ("multilayer.rig.effects", "EFFECTS"),
    "place": ("multilayer.diagnosis.places.base", "PLACES"),
    "place of a tube": ("multilayer.diagnosis.places.base", "TUBE_PLACES"),
    "place of a construction": ("multilayer.diagnosis.places.base", "LEVEL_PLACES"),
    "command": ("multilayer.plugins.commands", "COMMANDS"),
}
KINDS = tuple(_REGISTRIES)


def registry(kind: str) -> Registry[Any]:
    """Return the registry of a kind of plugin, one of `KINDS`."""
    from importlib import import_module

    module, name = _REGISTRIES[kind]
    of_kind: Registry[Any] = getattr(import_module(module), name)
    return of_kind


def describe_plugins() -> list[dict[str, Any]]:
    """Return kind, name and owners of everything registered, and an ``error`` where it does not load."""
    return [_described(kind, name) for kind in KINDS for name in registry(kind).names()]


def _described(kind: str, name: str) -> dict[str, Any]:
    known = registry(kind)
    origin = [asdict(owner) for owner in known.owners(name)]
    entry: dict[str, Any] = {"kind": kind, "name": name, "origin": origin}
    try:
        known[name]
    except RegistryError as error:
        entry["error"] = str(error)
    return entry
