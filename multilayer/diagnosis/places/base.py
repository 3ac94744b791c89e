"""The registry of places, and the names that modules of places import."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from multilayer.arrays import ComplexArray
from multilayer.experiments.levels.places import LevelPlace
from multilayer.experiments.places import BasePlace
from multilayer.experiments.stacks.effects import TubeSetting
from multilayer.experiments.stacks.places import TubePlace
from multilayer.experiments.two_plate.effects import Chain, Setting
from multilayer.experiments.two_plate.places import Place
from multilayer.registry import Registry, subclass_fault


def _fault_of(base: type[BasePlace]) -> Callable[[str, Any], str]:
    is_place = subclass_fault(base, "name")

    def fault(name: str, item: Any) -> str:
        silent = [field for field in ("title", "quantity") if not getattr(item, field, "")]
        return is_place(name, item) or (f"it says no {', '.join(silent)}" if silent else "")

    return fault


PLACES: Registry[type[Place]] = Registry("multilayer.places", "place", _fault_of(Place))
TUBE_PLACES: Registry[type[TubePlace]] = Registry("multilayer.tube_places", "place of a tube", _fault_of(TubePlace))
LEVEL_PLACES: Registry[type[LevelPlace]] = Registry(
    "multilayer.level_places", "place of a construction", _fault_of(LevelPlace)
)


def places_of(kind: str) -> dict[str, type[BasePlace]]:
    """Return the places of a rig, of a tube or of a construction, by name, as `BasePlace.kind` says which."""
    known: dict[str, Registry[Any]] = {Place.kind: PLACES, TubePlace.kind: TUBE_PLACES, LevelPlace.kind: LEVEL_PLACES}
    return {str(name): place for name, place in known[kind].working()}


__all__ = [
    "LEVEL_PLACES", "PLACES", "TUBE_PLACES", "BasePlace", "Chain", "ComplexArray", "LevelPlace", "Place", "Setting",
    "TubePlace", "TubeSetting", "places_of",
]  # fmt: skip
