"""Places of the two-plate rig at which something unmodelled may act."""

from __future__ import annotations

from typing import Any, ClassVar

from multilayer.arrays import ComplexArray
from multilayer.experiments.places import BasePlace, changes_nothing
from multilayer.experiments.two_plate.effects import Chain, Effect, Setting


class Place(BasePlace):
    """Where something may act on the two-plate rig; override the hook through which it enters the model.

    Attributes
    ----------
    needs : str
        Name of a field of `ConfigurationData` without which there is no such place; empty where it needs none.
    """

    kind = Effect.kind
    needs: ClassVar[str] = ""

    @classmethod
    def instances(cls, settings: tuple[Setting, ...]) -> list[Any]:
        """Return the places of this kind in a campaign, where all configurations have what they need."""
        places = super().instances(settings)
        return [each for each in places if not each.needs or all(_has(setting, each.needs) for setting in settings)]

    @changes_nothing
    def modulus(self, setting: Setting, modulus: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the sample's modulus, Pa, shape (..., n)."""
        return modulus

    @changes_nothing
    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the rods and masses."""
        return chain

    @changes_nothing
    def motion(self, setting: Setting, motion: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return top over base as the channels show it, shape (..., n)."""
        return motion


def _has(setting: Setting, field: str) -> bool:
    return getattr(setting.data, field) is not None
