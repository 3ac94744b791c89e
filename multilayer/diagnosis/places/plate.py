"""Places at the top plate."""

from __future__ import annotations

from typing import ClassVar

from multilayer.diagnosis.places.base import Chain, ComplexArray, Place, Setting

# of the bending under a point: 0.92 and 0.89 of a footprint of 3 mm on steel of 1 mm, radius 22.5 and 12 mm, beside
# finite elements; 0.81 of one of 6 mm
_BENDING = 0.92


class TopPlate(Place):
    """Something on the top plate, the same on every plate: it adds a dynamic mass, force over acceleration."""

    name = "top_plate"
    title = "on the top plate"
    quantity = "dynamic mass"
    unit = "kg"
    passive_sign = -1
    terms: ClassVar = {
        0: ("mass", "kg"), -1: ("damper to the ground", "N s/m"), -2: ("spring to the ground", "N/m"),
        "resonance": ("mass on a spring", "kg"),
    }  # fmt: skip

    @classmethod
    def variants(cls) -> tuple[type[TopPlate], ...]:
        """Return what is spread over the plate, and what stands in its centre."""
        return (TopPlate, InCentre)

    def scale(self, settings: tuple[Setting, ...], modulus: float) -> float:
        """Return the mass of the lightest plate."""
        return min(setting.plate_mass for setting in settings)

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the chain with a dynamic mass on the plate."""
        return chain.with_(plate_mass=chain.plate_mass + values)


class InCentre(TopPlate):
    """Something in the centre of the top plate, which bends the plate under the accelerometer."""

    variant = "in_centre"
    title = "in the centre of the top plate"

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the chain with the dynamic mass that acts alike on a rigid plate."""
        return super().chain(setting, chain, setting.at_centre(values, _BENDING)[0])

    def motion(self, setting: Setting, motion: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the motion of the plate's centre."""
        return motion * setting.at_centre(values, _BENDING)[1]


class Plate(Place):
    """The top plate itself: its mass changes by a share that is the same for every plate."""

    name = "plate"
    title = "in the top plate itself"
    quantity = "relative change of its mass"
    passive_sign = -1
    terms: ClassVar = {2: ("bending", "s2")}

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the chain with another plate."""
        return chain.with_(plate_mass=chain.plate_mass * (1 + values))
