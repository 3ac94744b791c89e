"""A fluid: air gap, water, any homogeneous fluid."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Literal, Self

from pydantic import model_validator

from multilayer.arrays import ComplexArray, Numeric
from multilayer.layers.base import Layer
from multilayer.matrix.equations import FieldEquations
from multilayer.matrix.faces import Faces, FacesOf
from multilayer.matrix.families import FLUID, Family
from multilayer.matrix.slab import Slab
from multilayer.matrix.small import Entries
from multilayer.matrix.wave import Wave
from multilayer.media.elastic import decaying_root
from multilayer.media.humid_air import air_absorption
from multilayer.models import refuse
from multilayer.units import Density, Length, Speed


class Fluid(Layer):
    """A fluid at rest; the ambient gas where density and sound speed are left out.

    Fields: `thickness` (m), `density` (kg/m3), `sound_speed` (m/s), `losses`: those of ``air`` are what free air
    absorbs at the ambient gas' temperature, pressure and humidity (ISO 9613-1; 50 % where the stack states no
    humidity), and go with neither density nor sound speed. No friction at walls: of narrow spaces see
    `viscothermal_fluid`.
    """

    type: Literal["fluid"] = "fluid"
    thickness: Length
    density: Density | None = None
    sound_speed: Speed | None = None
    losses: Literal["air"] | None = None

    summary: ClassVar[str] = "fluid at rest; the ambient gas by default"
    stands_still: ClassVar[bool] = True

    @model_validator(mode="after")
    def _loses_as_air_where_it_is_air(self) -> Self:
        stated = [name for name in ("density", "sound_speed") if getattr(self, name) is not None]
        if self.losses == "air" and stated:
            text = f"'air' is what the ambient gas loses, and this fluid states {' and '.join(stated)}: leave out "
            text += f"'losses', or, where it is air, {' and '.join(stated)}, and describe the air in 'ambient'"
            refuse(self, [(("losses",), text, self.losses)])
        return self

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
        """Return density and bulk modulus; relaxation is of compression, so that losses are in the latter."""
        gas = wave.ambient
        density = gas.density if self.density is None else self.density
        speed: Numeric = gas.sound_speed if self.sound_speed is None else self.sound_speed
        if self.losses == "air":
            absorbed = air_absorption(wave.frequency, gas.temperature, gas.pressure, gas.relative_humidity)
            speed = speed / (1 - 1j * absorbed * speed / wave.omega)  # of the wavenumber w/c - i alpha
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
    return FacesOf(FluidSlab(wave, thickness, density, bulk_modulus, lateral))


@dataclass(frozen=True, eq=False)
class FluidSlab(Slab):
    """A slab of any fluid; see `fluid_faces`."""

    family: ClassVar[Family] = FLUID

    density: Numeric
    bulk_modulus: Numeric
    lateral: Numeric = 1.0

    @property
    def coefficients(self) -> tuple[Numeric, ...]:
        """Thickness, density, bulk modulus, and the density over that along the layer."""
        return self.thickness, self.density, self.bulk_modulus, self.lateral

    @cached_property
    def constants(self) -> tuple[Numeric, ...]:
        """What `equations` and `waves` take."""
        omega = self.wave.omega
        square = omega**2 * self.density / self.bulk_modulus - self.lateral * self.wave.kx**2
        return omega, self.density, square, decaying_root(square)

    @property
    def trace(self) -> Numeric:
        """None: the equations know k3 only. The series serves thick layers too where waves run along them and merge."""
        return 0 * self.wave.kx

    @staticmethod
    def equations(*constants: Numeric) -> tuple[Entries, Entries]:
        """Return the field equations."""
        return _equations(*constants[:3])

    @staticmethod
    def waves(*constants: Numeric) -> Entries:
        """Return the wave of unit pressure."""
        omega, density, _, k3 = constants
        return [[1.0], [k3 / (omega * density)]]

    def by_medium(self, x: ComplexArray, y: ComplexArray) -> tuple[Numeric, ...]:
        """Return derivatives by density, bulk modulus and the ratio of densities; see `_equations`."""
        omega, density = self.wave.omega, self.density
        along = 1j * self.wave.kx**2 / (omega * density) * y[0, 0]
        by_density = -1j * omega * x[0, 0] - self.lateral / density * along
        return by_density, 1j * omega / self.bulk_modulus**2 * y[0, 0], along


def _equations(omega: Numeric, density: Numeric, square: Numeric) -> tuple[Entries, Entries]:
    return [[-1j * omega * density]], [[-1j * square / (omega * density)]]
