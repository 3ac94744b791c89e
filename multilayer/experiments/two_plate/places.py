"""Places of the two-plate rig at which something unmodelled may act."""

from __future__ import annotations

from multilayer.arrays import ComplexArray
from multilayer.experiments.places import BasePlace
from multilayer.experiments.two_plate.effects import Chain, Effect, Setting


class Place(BasePlace):
    """Where something may act on the two-plate rig; override the hook through which it enters the model."""

    kind = Effect.kind

    def modulus(self, setting: Setting, modulus: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the sample's modulus, Pa, shape (..., n)."""
        return modulus

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the rods and masses."""
        return chain

    def motion(self, setting: Setting, motion: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return top over base as the channels show it, shape (..., n)."""
        return motion
