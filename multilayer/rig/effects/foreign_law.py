"""A law that no library holds, at one of the places where something may act."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.models import NO_BOOL
from multilayer.rig.effect_base import GRAVITY, Effect, Geometry, Moment, Mounting, Size, above_zero
from multilayer.rig.specimen import SpecimenSettings
from multilayer.units import DIMENSIONLESS, Unit

Where = Literal[
    "top_plate", "faces", "beside", "reading", "added_reading", "sample", "sample_load", "sample_order",
    "sample_radius", "one_configuration",
]  # fmt: skip
Law = Literal["constant", "relaxation", "power", "resonance", "echo"]
# a large law at each place: kg, m/Pa, N/m, of ln(top/base), of top/base, of ln E, 1/Pa, of ln E, 1/m2, of the mass
LARGE: dict[str, float] = {
    "top_plate": 5e-3, "faces": 2e-8, "beside": 5e3, "reading": 0.1, "added_reading": 0.1, "sample": 0.5,
    "sample_load": 2e-3, "sample_order": 0.2, "sample_radius": 600.0, "one_configuration": 0.1,
}  # fmt: skip
_YIELDING = ("top_plate", "faces")  # passive laws fall with frequency and have a negative imaginary part
_FILM = 1e-4  # m: thickness of the layer at each face that has the compliance
_LIGHT = 1.0  # kg/m3: of that layer


@dataclass(frozen=True)
class LawValues:
    """A law at frequencies, Hz, or the film's modulus that it makes, Pa; a class, to go to another process."""

    law: ForeignLaw
    of_film: bool = False

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        """Return the values."""
        values = self.law.at_frequency(np.asarray(frequency, dtype=float))
        return np.asarray(_FILM / values if self.of_film else values)


class ForeignLaw(Effect):
    """A causal law, passive where a thing can be, at a place: a = size times what is large there, s = i f/f0.

    Constant: a. Relaxation: a/(1 + s^n) of a dynamic mass or a compliance, a s^n/(1 + s^n) of a stiffness or a
    modulus. Power: a s^-n and a s^n. Resonance: a/(1 - (f/f0)^2/(1 + i eta)), of a reading
    a (f/f0)^2/(1 - (f/f0)^2 + i eta f/f0). Echo: ln(1 + a exp(-i f/f0)). In one configuration only, that of a number
    from 0: its top plate is heavier than stated by the share a. Perturbed: f0 (1 + p).
    """

    effect: Literal["foreign_law"] = "foreign_law"
    at: Where = "top_plate"
    law: Law = "constant"
    size: Annotated[float, Field(ge=-2, le=2), Unit(DIMENSIONLESS)] = 0.1
    frequency: Annotated[float, Field(gt=0, le=50e3), Unit("Hz")] = 500.0
    exponent: Annotated[float, Field(ge=0, le=1), Unit(DIMENSIONLESS)] = 0.5
    loss_factor: Annotated[float, Field(gt=0, le=2), Unit(DIMENSIONLESS)] = 0.05
    number: Annotated[int, Field(ge=0), NO_BOOL, Unit(DIMENSIONLESS)] = 0

    known = False
    drawn = Size("size", 0.02, 1.0)

    def at_frequency(self, frequency: RealArray) -> ComplexArray:
        """Return the law in the place's unit at frequencies, Hz, convention exp(+i w t)."""
        a, ratio = self.size * LARGE[self.at], above_zero(frequency) / (self.frequency * (1 + self.perturbation))
        grown = (1j * ratio) ** self.exponent
        if self.law == "relaxation":
            return np.asarray(a / (1 + grown) if self.at in _YIELDING else a * grown / (1 + grown))
        if self.law == "power":
            return np.asarray(a / grown if self.at in _YIELDING else a * grown)
        if self.law == "resonance" and self.at in ("reading", "added_reading"):
            return np.asarray(a * ratio**2 / (1 - ratio**2 + 1j * self.loss_factor * ratio))
        if self.law == "resonance":
            return np.asarray(a / (1 - ratio**2 / (1 + 1j * self.loss_factor)))
        if self.law == "echo":
            return np.asarray(np.log(1 + a * np.exp(-1j * ratio)))
        return np.full(np.shape(frequency), a, dtype=complex)

    @property
    def varies(self) -> bool:  # type: ignore[override]
        """Whether the modulus differs from recording to recording."""
        return self.at == "sample_order"

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        if self.at == "top_plate":
            return {**geometry, "attached_mass": LawValues(self)}
        if self.at == "beside":
            return {**geometry, "flanking_stiffness": LawValues(self)}
        if self.at == "faces":
            film = {"thickness": _FILM, "modulus": LawValues(self, of_film=True), "density": _LIGHT, "poisson_ratio": 0}
            return {**geometry, **{f"adhesive_{name}": value for name, value in film.items()}}
        if self.at == "one_configuration" and self.number == mounting.index:
            heavier = 1 + self.size * LARGE[self.at]
            return {**geometry, "plate_density": geometry["plate_density"] * heavier}
        return geometry

    def apply_to_modulus(self, frequency: RealArray, modulus: ComplexArray, moment: Moment) -> ComplexArray:
        plate = moment.geometry
        factors = {
            "sample": 1.0,
            "sample_load": GRAVITY * plate["plate_density"] * plate["plate_thickness"],
            "sample_order": moment.elapsed / max(moment.total - 1, 1.0),
            "sample_radius": moment.mounting.radius**2,
        }
        if self.at not in factors:
            return modulus
        return np.asarray(modulus * np.exp(factors[self.at] * self.at_frequency(frequency)))

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        if self.at == "reading":
            return np.asarray(ratio * np.exp(self.at_frequency(frequency)))
        return np.asarray(ratio + self.at_frequency(frequency)) if self.at == "added_reading" else ratio
