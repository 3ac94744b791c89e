"""The registry of places, and the names that modules of places import."""

from __future__ import annotations

from typing import Any

from multilayer.arrays import ComplexArray
from multilayer.experiments.two_plate.effects import Chain, Setting
from multilayer.experiments.two_plate.places import Place
from multilayer.registry import Registry, subclass_fault

_is_place = subclass_fault(Place, "name")


def _place_fault(name: str, item: Any) -> str:
    silent = [field for field in ("title", "quantity") if not getattr(item, field, "")]
    return _is_place(name, item) or (f"it says no {', '.join(silent)}" if silent else "")


PLACES: Registry[type[Place]] = Registry("multilayer.places", "place", _place_fault)

__all__ = ["PLACES", "Chain", "ComplexArray", "Place", "Setting"]
