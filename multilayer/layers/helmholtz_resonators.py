"""An array of Helmholtz resonators."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from multilayer.arrays import ComplexArray, Numeric
from multilayer.layers.base import Layer
from multilayer.layers.fluid import FluidSlab
from multilayer.matrix.faces import Faces, FacesOf, LayerField, Origin
from multilayer.matrix.families import FLUID, Family
from multilayer.matrix.small import multiply, stack_entries
from multilayer.matrix.wave import Wave
from multilayer.media.narrow import narrow_gas
from multilayer.media.perforations import duct_end_length, end_friction, end_length, sheet_impedance
from multilayer.media.validity import warn_outside
from multilayer.models import refuse
from multilayer.units import Length

_ROUNDING = 1.001  # of cavities that are meant to fill their pitch
_WIDE = 0.9  # of neck over cavity: the end correction inside vanishes there


class HelmholtzResonators(Layer):
    """Resonators side by side in a square array: necks in the front face, a cavity behind each.

    Fields: `neck_radius`, `neck_length`, `pitch` (m, between the axes of neighbours), `cavity_depth`, `cavity_radius`
    (m, round, or that of a circle of the same area; cavities that fill the pitch where it is left out). The cavities'
    floor is what lies behind, a rigid termination as a rule. State (p, v3). Nothing flows along the layer.

    Viscosity and heat conduction act in neck and cavity, friction and mass at both ends of the neck. Holds for a pitch
    below half a wavelength, necks shorter than a tenth of it and at most 0.9 as wide as the cavity
    (`ValidityWarning` beyond), low sound levels, no mean flow.
    """

    type: Literal["helmholtz_resonators"] = "helmholtz_resonators"
    neck_radius: Length
    neck_length: Length
    pitch: Length
    cavity_depth: Length
    cavity_radius: Length | None = None

    summary: ClassVar[str] = "array of Helmholtz resonators, their floor the next layer or the termination"
    stands_still: ClassVar[bool] = True
    composes: ClassVar[bool] = False  # necks and cavities
    vanishes: ClassVar[bool] = False

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        refuse(self, self._misfit_values())
        return self

    def _misfit_values(self) -> list[tuple[tuple[str], str, Any]]:
        fitting = self.pitch / math.sqrt(math.pi)
        radius = self._cavity_radius()
        if radius > _ROUNDING * fitting:
            text = f"cavities of {1e3 * radius:g} mm do not fit a pitch of {1e3 * self.pitch:g} mm: at most"
            return [(("cavity_radius",), f"{text} {1e3 * fitting:.4g} mm, of the same area as the square", radius)]
        if self.neck_radius >= radius:
            text = f"{1e3 * self.neck_radius:g} mm is not allowed: it must be below the cavity's, {1e3 * radius:.4g} mm"
            return [(("neck_radius",), text, self.neck_radius)]
        return []

    def _cavity_radius(self) -> Any:
        return self.pitch / math.sqrt(math.pi) if self.cavity_radius is None else self.cavity_radius

    @property
    def depth(self) -> Numeric:
        """Necks and cavities behind each other, m."""
        return self.neck_length + self.cavity_depth

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices: a sheet before a duct; U. Ingard, J. Acoust. Soc. Am. 25 (1953) 1037-1061."""
        self._check(wave)
        cell, radius = self.pitch**2, self._cavity_radius()
        share = math.pi * radius**2 / cell
        density, bulk = narrow_gas(wave.omega, "tube", radius, wave.ambient)
        cavity = FluidSlab(wave, self.cavity_depth, density / share, bulk / share, lateral=0.0)
        return FacesOf(NeckAndCavity(self._neck_impedance(wave), cavity))

    def _neck_impedance(self, wave: Wave) -> Numeric:
        """Return the pressure difference over the mean velocity of the front face, Pa s/m."""
        perforation = math.pi * self.neck_radius**2 / self.pitch**2
        ends = end_length(self.neck_radius, perforation) + duct_end_length(self.neck_radius, self._cavity_radius())
        friction = end_friction(wave.omega, "tube", wave.ambient)
        hole = sheet_impedance(wave.omega, "tube", self.neck_radius, self.neck_length, ends, friction, wave.ambient)
        return hole / perforation

    def _check(self, wave: Wave) -> None:
        what, waves = "the array of resonators", wave.frequency / wave.ambient.sound_speed
        warn_outside(what, "pitch / wavelength", self.pitch * waves, -np.inf, 0.5, wave.frequency)
        warn_outside(what, "neck_length / wavelength", self.neck_length * waves, -np.inf, 0.1, wave.frequency)
        warn_outside(what, "neck_radius / cavity_radius", self.neck_radius / self._cavity_radius(), -np.inf, _WIDE)


@dataclass(frozen=True, eq=False)
class NeckAndCavity(Origin):
    """A sheet before a slab of fluid.

    Attributes
    ----------
    neck : complex or array
        Impedance of the sheet, Pa s/m.
    cavity : FluidSlab
    """

    family: ClassVar[Family] = FLUID

    neck: Numeric
    cavity: FluidSlab

    @property
    def coefficients(self) -> tuple[Numeric, ...]:
        """The sheet's impedance and the coefficients of the slab."""
        return self.neck, *self.cavity.coefficients

    def matrices(self) -> tuple[ComplexArray, ComplexArray]:
        """Return the face matrices."""
        front, back = self.cavity.matrices()
        return multiply(stack_entries([[1.0, self.neck], [0.0, 1.0]]), front), back

    def gradient(self, field: LayerField) -> tuple[Numeric, ...]:
        """Return derivatives by the coefficients, those of the slab from the field behind the sheet."""
        (pressure, velocity), (by_pressure, by_velocity) = field.front, field.adjoint_front
        behind = np.array([pressure - self.neck * velocity, velocity])
        adjoint = np.array([by_pressure, self.neck * by_pressure + by_velocity])
        inside = replace(field, front=behind, adjoint_front=adjoint)
        return -by_pressure * velocity, *self.cavity.gradient(inside)
