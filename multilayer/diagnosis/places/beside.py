"""Places at the sample's faces, and beside it."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np

from multilayer.diagnosis.places.base import Chain, ComplexArray, Place, Setting
from multilayer.experiments.two_plate.effects import OpenRim
from multilayer.number_text import percent
from multilayer.rig.partly_bonded import WIDEST_RIM

_BOTH = 0.5  # share of a rim that is open at the lower face, above which both are said to be
_WORN = 0.005  # share of the height: what is worn away by less is not told


class Faces(Place):
    """The sample's faces: a compliance per area in series with it at both, whatever its height; negative for a skin."""

    name = "faces"
    title = "at the faces of the sample"
    quantity = "compliance per area of each face"
    unit = "m/Pa"
    passive_sign = -1
    terms: ClassVar = {
        0: ("compliance", "m/Pa"), -1: ("mobility", "m/(Pa s)"), "resonance": ("compliance with a resonance", "m/Pa"),
    }  # fmt: skip

    def scale(self, settings: tuple[Setting, ...], modulus: float) -> float:
        """Return the compliance per area of the thinnest sample."""
        return min(setting.configuration.specimen_thickness for setting in settings) / modulus

    @classmethod
    def variants(cls) -> tuple[type[Faces], ...]:
        """Return layers that are alike at both faces, and a layer at one of them."""
        return (Faces, LowerFace, UpperFace)

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the chain with a layer without mass at each face."""
        return chain.softer_at(lower=values, upper=values)


class LowerFace(Faces):
    """The sample's lower face alone."""

    variant = "lower"
    title = "at the lower face of the sample"
    quantity = "compliance per area of the lower face"

    def scale(self, settings: tuple[Setting, ...], modulus: float) -> float:
        """Return what does as much as layers at both faces."""
        return 2 * super().scale(settings, modulus)

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the chain with a layer without mass at the lower face."""
        return chain.softer_at(lower=values)


class UpperFace(LowerFace):
    """The sample's upper face alone, as under a plate that is bent."""

    variant = "upper"
    title = "at the upper face of the sample"
    quantity = "compliance per area of the upper face"

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the chain with a layer without mass at the upper face."""
        return chain.softer_at(upper=values)


@dataclass(frozen=True)
class OpenFaces(Faces):
    """The sample's faces with open rims: by how much more they change the forces on the plates than open rims do.

    No compliance per area acts as an open rim on samples of several heights; see `rig.partly_bonded`.

    Attributes
    ----------
    width : float
        Of the open rim, as a share of the radius, in the middle of the configurations.
    trend : float
        ln of the width in the last configuration over that.
    at_base : float
        Where it is open: 0 at the upper face, 1 at both, 2 at the lower one, or between.
    depth : float
        What is worn away of it, as a share of the height.
    """

    width: float
    trend: float = 0.0
    at_base: float = 0.0
    depth: float = 0.0

    quantity = "relative change of what open rims do"
    unit = ""
    passive_sign = 0
    terms: ClassVar = {0: ("relative change", "")}

    @classmethod
    def variants(cls) -> tuple[type[Faces], ...]:
        """Return these alone: whatever is at the faces beyond open rims acts as they do."""
        return (OpenFaces,)

    @property
    def modelled(self) -> str:
        """The open rims."""
        faces = (
            "the upper face"
            if self.at_base <= _BOTH
            else "both faces"
            if self.at_base < 2 - _BOTH
            else "the lower face"
        )
        worn = f", worn away to {percent(self.depth)} of the height" if self.depth > _WORN else ""
        return f"an open rim of {faces}, {percent(self.width)} of the radius{worn}"

    @property
    def entry(self) -> dict[str, Any]:
        """Its fields."""
        return {**super().entry, "open_rim": asdict(self)}

    def scale(self, settings: tuple[Setting, ...], modulus: float) -> float:
        """Return 1."""
        return 1.0

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the chain with open rims that do more than such rims do."""
        width = np.clip(self.width * np.exp(setting.from_first_to_last * self.trend), 0.0, WIDEST_RIM)
        rim = np.full((len(values), 1), width)
        at_base, depth = (np.full_like(rim, share) for share in (self.at_base, self.depth))
        return chain.with_(open_rim=OpenRim(rim, at_base, depth if self.depth else None, 1 + values))


class Beside(Place):
    """A path beside the sample: a dynamic stiffness between base and top plate."""

    name = "beside"
    title = "beside the sample"
    quantity = "dynamic stiffness"
    unit = "N/m"
    passive_sign = 1
    terms: ClassVar = {
        0: ("spring", "N/m"), 1: ("damper", "N s/m"), 2: ("inertia", "kg"),
        "resonance": ("spring with a resonance", "N/m"),
    }  # fmt: skip

    def scale(self, settings: tuple[Setting, ...], modulus: float) -> float:
        """Return the stiffness of the softest sample."""
        return modulus * min(s.area / s.configuration.specimen_thickness for s in settings)

    @classmethod
    def variants(cls) -> tuple[type[Beside], ...]:
        """Return a linear path, and one of dry friction."""
        return (Beside, Friction)

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the chain with a spring beside the sample."""
        return chain.with_(spring=values if chain.spring is None else chain.spring + values)


class Friction(Beside):
    """Dry friction beside the sample, as of a guide: a force of constant amplitude against the relative velocity.

    As `BurstData.friction` has it, by the motion that was measured; a law with an imaginary part leads the velocity.
    """

    variant = "friction"
    title = "beside the sample, by dry friction"
    quantity = "friction force"
    unit = "N"
    passive_part = "real"
    acts_by_bin = True
    needs = "friction"
    terms: ClassVar = {0: ("dry friction", "N")}

    def scale(self, settings: tuple[Setting, ...], modulus: float) -> float:
        """Return the force that does as much as the softest sample at half of the data."""
        every = np.concatenate([np.abs(_friction(each)) for each in settings])
        return super().scale(settings, modulus) / float(np.median(every))

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the chain with that force, over the stretch."""
        return super().chain(setting, chain, values * _friction(setting))


def _friction(setting: Setting) -> ComplexArray:
    if setting.data.friction is None:
        raise ValueError("without the signals nothing is known of friction")
    return setting.data.friction
