"""A fluid: air gap, water, any homogeneous fluid."""

from __future__ import annotations

from typing import ClassVar, Literal

from multilayer.arrays import ComplexArray, Numeric
from multilayer.layers.base import Layer
from multilayer.matrix.equations import FieldEquations
from multilayer.matrix.faces import Faces, choose, from_propagator, from_waves, is_thin, propagator_series
from multilayer.matrix.families import FLUID
from multilayer.matrix.small import Entries
from multilayer.matrix.wave import Wave
from multilayer.media.elastic import decaying_root
from multilayer.units import Density, Length, Speed


class Fluid(Layer):
    """A fluid at rest; the ambient gas where density and sound speed are left out.

    Fields: `thickness` (m), `density` (kg/m3), `sound_speed` (m/s). No viscosity, no heat conduction.
    """

    type: Literal["fluid"] = "fluid"
    thickness: Length
    density: Density | None = None
    sound_speed: Speed | None = None

    summary: ClassVar[str] = "fluid at rest; the ambient gas by default"

    @property
    def mass_per_area(self) -> Numeric:
        """Mass over area, kg/m2, of a fluid whose density is stated; the ambient gas counts for nothing."""
        return 0.0 if self.density is None else self.density * self.thickness

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices; Allard & Atalla 2009, section 11.3.1."""
        return fluid_faces(wave, self.thickness, *self._medium(wave))

    def field_equations(self, wave: Wave) -> FieldEquations:
        """Return the field equations."""
        return fluid_equations(wave, *self._medium(wave))

    def _medium(self, wave: Wave) -> tuple[Numeric, Numeric]:
        """Return density and bulk modulus."""
        density = wave.ambient.density if self.density is None else self.density
        speed = wave.ambient.sound_speed if self.sound_speed is None else self.sound_speed
        return density, density * speed**2


def fluid_equations(wave: Wave, density: Numeric, bulk_modulus: Numeric) -> FieldEquations:
    """Return the field equations of any fluid by density, kg/m3, and bulk modulus, Pa."""
    square = wave.omega**2 * density / bulk_modulus - wave.kx**2
    return FieldEquations(FLUID, *_equations(wave.omega, density, square))


def fluid_faces(
    wave: Wave, thickness: Numeric, density: Numeric, bulk_modulus: Numeric, lateral: Numeric = 1.0
) -> Faces:
    """Return the face matrices of any fluid, equivalent ones included.

    Parameters
    ----------
    wave : Wave
    thickness : float or array
        m.
    density, bulk_modulus : complex or array
        kg/m3 and Pa, per unit volume of material.
    lateral : complex or array
        `density` over the density that counts along the layer: 0 where nothing flows along it.
    """
    omega = wave.omega
    square = omega**2 * density / bulk_modulus - lateral * wave.kx**2
    k3 = decaying_root(square)
    arguments = (omega, density, square, k3, thickness, wave.ambient.impedance)
    # its equations know k3 only: the series serves thick layers too where the waves run along them and merge
    return Faces(FLUID, *choose(is_thin([k3], 0 * wave.kx, thickness), _series, _waves, arguments))


def _waves(
    omega: Numeric, density: Numeric, _square: Numeric, k3: Numeric, thickness: Numeric, _impedance: float
) -> tuple[ComplexArray, ComplexArray]:
    return from_waves(FLUID, [[1.0], [k3 / (omega * density)]], [k3], thickness)


def _series(
    omega: Numeric, density: Numeric, square: Numeric, _k3: Numeric, thickness: Numeric, impedance: float
) -> tuple[ComplexArray, ComplexArray]:
    x, y = _equations(omega, density, square)
    return from_propagator(FLUID, propagator_series(FLUID, x, y, thickness), impedance)


def _equations(omega: Numeric, density: Numeric, square: Numeric) -> tuple[Entries, Entries]:
    return [[-1j * omega * density]], [[-1j * square / (omega * density)]]
