"""Places at the sample's faces, and beside it."""

from __future__ import annotations

from typing import ClassVar

from multilayer.diagnosis.places.base import Chain, ComplexArray, Place, Setting

_STIFF = 1e-18  # m/Pa, added to the compliance: a layer may not be rigid


class Faces(Place):
    """The sample's faces: a compliance per area in series with it at both, whatever its height; negative for a skin."""

    name = "faces"
    title = "at the faces of the sample"
    quantity = "compliance per area of each face"
    unit = "m/Pa"
    passive_sign = -1
    terms: ClassVar = {0: ("compliance", "m/Pa"), "resonance": ("compliance with a resonance", "m/Pa")}

    def scale(self, settings: tuple[Setting, ...], modulus: float) -> float:
        """Return the compliance per area of the thinnest sample."""
        return min(setting.configuration.specimen_thickness for setting in settings) / modulus

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the chain with a layer without mass at each face."""
        return chain.glued(1 / (values + _STIFF))


class Beside(Place):
    """A path beside the sample: a dynamic stiffness between base and top plate."""

    name = "beside"
    title = "beside the sample"
    quantity = "dynamic stiffness"
    unit = "N/m"
    passive_sign = 1
    terms: ClassVar = {0: ("spring", "N/m"), 1: ("damper", "N s/m"), "resonance": ("spring with a resonance", "N/m")}

    def scale(self, settings: tuple[Setting, ...], modulus: float) -> float:
        """Return the stiffness of the softest sample."""
        return modulus * min(s.area / s.configuration.specimen_thickness for s in settings)

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the chain with a spring beside the sample."""
        return chain.with_(spring=values if chain.spring is None else chain.spring + values)
