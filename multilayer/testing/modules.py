"""A plugin's module under test, installed or not."""

from __future__ import annotations

from types import ModuleType

from multilayer.plugins.files import definitions


def use_module(module: ModuleType) -> None:
    """Register the layers, laws, effects, places, methods, readers and commands that a module defines.

    Those that are there already stay.

    To be called in a plugin's ``conftest.py``: its tests then run before it is installed, and after.

    Raises
    ------
    RegistryError
        When something else has one of the names.
    """
    for registry, name, item in definitions(module):
        if name not in registry or registry[name] is not item:
            registry.register(name, item)
