"""A perforated or micro-perforated plate, held still or free to move."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from multilayer.arrays import ComplexArray, Numeric
from multilayer.layers.field_sets import FieldSets
from multilayer.layers.fluid import fluid_faces
from multilayer.matrix.faces import Faces, sheet_faces
from multilayer.matrix.wave import Wave
from multilayer.media.elastic import flexural_rigidity
from multilayer.media.laws import Modulus, complex_modulus
from multilayer.media.perforations import (
    DISCHARGE,
    end_length,
    grazing_mass,
    grazing_resistance,
    hole_pitch,
    jet_resistance,
    maa_impedance,
    maa_slit_impedance,
    slit_end_length,
)
from multilayer.media.porous import johnson_density, lafarge_modulus, limp_density
from multilayer.media.validity import warn_outside
from multilayer.models import refuse
from multilayer.units import DIMENSIONLESS, Density, Length, NonNegative, PoissonRatio, Ratio, Tortuosity, Unit

Perforation = Annotated[float, Field(gt=0, lt=1), Unit(DIMENSIONLESS)]
Discharge = Annotated[float, Field(gt=0, le=1), Unit(DIMENSIONLESS)]
Mach = Annotated[float, Field(ge=0, lt=1), Unit(DIMENSIONLESS)]
FlowSpeed = Annotated[float, NonNegative, Unit("m/s")]
_TOUCHING = math.pi / 4  # perforation at which round holes in a square array touch
_GRAZING = 0.5  # Mach number: the flows Guess compared his formula with


class PerforatedPlate(FieldSets):
    """A plate with round holes or slits of any size, held still, or free to move and bend.

    Fields: `thickness` (m), `hole_radius` (m; the radius, not the diameter) or `slit_width` (m, the full width),
    `perforation` (area of the holes over area of the plate; below pi/4, where round holes in a square array touch),
    `front_tortuosity`, `back_tortuosity` (of a porous material that touches that face: the air pulsing out of the holes
    enters it), `model`: `atalla_sgard`, a porous material of straight pores whose tortuosity holds the mass outside, or
    `maa`, the exact viscous flow in micro-perforations with Maa's end corrections. State (p, v3). Nothing flows along
    the plate.

    The plate moves if its material's `density` (kg/m3) is given, and bends with `young_modulus` (Pa; of the plate as
    perforated, below that of its material), `poisson_ratio` and `loss_factor` as well.

    Loud sound: `hole_velocity` (m/s, rms, of the sound in the holes; not known to the layer, as it depends on the
    stack). A steady flow through the holes: `bias_velocity` (m/s in the holes, faster than the sound's). Both with
    `discharge_coefficient`. A turbulent flow along the plate: `grazing_mach` (Mach number); the convection of sound by
    that flow is left out.

    Holds for a pitch of the holes below half a wavelength and Mach numbers up to 0.5 (`ValidityWarning` beyond).
    """

    type: Literal["perforated_plate"] = "perforated_plate"
    model: Literal["atalla_sgard", "maa"] = "atalla_sgard"
    thickness: Length
    hole_radius: Length | None = None
    slit_width: Length | None = None
    perforation: Perforation
    front_tortuosity: Tortuosity = 1.0
    back_tortuosity: Tortuosity = 1.0
    density: Density | None = None
    young_modulus: Modulus | None = None
    poisson_ratio: PoissonRatio | None = None
    loss_factor: Ratio = 0.0
    hole_velocity: FlowSpeed = 0.0
    bias_velocity: FlowSpeed = 0.0
    grazing_mach: Mach = 0.0
    discharge_coefficient: Discharge = DISCHARGE

    summary: ClassVar[str] = "plate with round holes or slits, perforated or micro-perforated, held still or moving"
    stands_still: ClassVar[bool] = True
    composes: ClassVar[bool] = False  # the air outside the holes belongs to it
    vanishes: ClassVar[bool] = False  # and stays, however thin the plate

    @classmethod
    def field_sets(cls, data: Mapping[str, Any]) -> tuple[str, tuple[tuple[str, ...], ...]]:
        """Return the two shapes of holes."""
        return "a perforated plate", (("hole_radius",), ("slit_width",))

    @classmethod
    def governed_fields(cls) -> frozenset[str]:
        """Return the fields of the shapes."""
        return frozenset(("hole_radius", "slit_width"))

    @model_validator(mode="after")
    def _goes_together(self) -> Self:
        refuse(self, self._misfit_values())
        return self

    def _misfit_values(self) -> list[tuple[tuple[str], str, Any]]:
        wrong: list[tuple[tuple[str], str, Any]] = []
        if self.hole_radius is not None and self.perforation >= _TOUCHING:
            text = f"{self.perforation:g} is not allowed: it must be below {_TOUCHING:.6g}, where the holes touch"
            wrong.append((("perforation",), text, self.perforation))
        modulus = self.young_modulus
        if modulus is not None and (self.density is None or self.poisson_ratio is None):
            text = "goes with density and poisson_ratio: give both, or leave it out for a plate that does not bend"
            wrong.append((("young_modulus",), text, modulus))
        if self.poisson_ratio is not None and modulus is None:
            text = "goes with young_modulus: give both, or neither for a plate that does not bend"
            wrong.append((("poisson_ratio",), text, self.poisson_ratio))
        if self.loss_factor and not isinstance(modulus, float | int):
            text = "goes with a young_modulus that has no losses yet: give one, or leave loss_factor out"
            wrong.append((("loss_factor",), text, self.loss_factor))
        if self.hole_velocity and self.bias_velocity:
            text = "stands beside bias_velocity; give that alone where it is faster than the sound, this where slower"
            wrong.append((("hole_velocity",), text, self.hole_velocity))
        return wrong

    @property
    def mass_per_area(self) -> Numeric | None:
        """Mass over area of the plate without its holes, kg/m2; None where its density is left out."""
        return None if self.density is None else (1 - self.perforation) * self.density * self.thickness

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices; Atalla & Sgard 2007, or Maa 1998 and 2000, see `media.perforations`."""
        pitch = self._pitch() * wave.frequency / wave.ambient.sound_speed
        warn_outside("the perforated plate", "pitch of the holes / wavelength", pitch, -np.inf, 0.5, wave.frequency)
        warn_outside("the perforated plate", "grazing_mach", self.grazing_mach, -np.inf, _GRAZING)
        if self.model == "maa":
            density = self._as_moving(wave, self._sheet_density(wave))
            impedance = 1j * wave.omega * self.thickness * density
            return sheet_faces(wave, impedance)
        pores, bulk = self._pores(wave)
        return fluid_faces(wave, self.thickness, self._as_moving(wave, pores), bulk, lateral=0.0)

    def _pitch(self) -> Numeric:
        if self.slit_width is not None:
            return self.slit_width / self.perforation
        assert self.hole_radius is not None  # validated
        return hole_pitch(self.hole_radius, self.perforation)

    def _pores(self, wave: Wave) -> tuple[ComplexArray, ComplexArray]:
        """Return density and bulk modulus of straight pores, alpha_inf = 1 + ends / h.

        Round: permeability phi r^2 / 8, both lengths r. Slits: phi w^2 / 12, both lengths w.
        """
        gas, phi = wave.ambient, self.perforation
        if self.slit_width is not None:
            length, permeability = self.slit_width, phi * self.slit_width**2 / 12
            end = slit_end_length(self.slit_width, phi)
        else:
            assert self.hole_radius is not None  # validated
            length, permeability = self.hole_radius, phi * self.hole_radius**2 / 8
            end = end_length(self.hole_radius, phi)
        tortuosity = 1 + 2 * end * self._end_factor() / self.thickness
        density = johnson_density(wave.omega, phi, gas.viscosity / permeability, tortuosity, length, gas)
        return density, lafarge_modulus(wave.omega, phi, length, permeability, gas)

    def _sheet_density(self, wave: Wave) -> ComplexArray:
        """Return the density of a layer that resists as Maa's sheet, thin beside the wavelength."""
        others = (self.perforation, self._end_factor(), wave.ambient)
        if self.slit_width is not None:
            impedance = maa_slit_impedance(wave.omega, self.thickness, self.slit_width, *others)
        else:
            assert self.hole_radius is not None  # validated
            impedance = maa_impedance(wave.omega, self.thickness, self.hole_radius, *others)
        return np.asarray(impedance / (1j * wave.omega * self.thickness))

    def _end_factor(self) -> Numeric:
        """Return the factor of the mass outside: mean tortuosity, less what a grazing flow sweeps away."""
        return (self.front_tortuosity + self.back_tortuosity) / 2 * grazing_mass(self.grazing_mach)

    def _as_moving(self, wave: Wave, density: ComplexArray) -> ComplexArray:
        """Return the density, kg/m3, with the resistance of flows, and of holes in a plate that gives way.

        The plate is a limp frame. Of the air in a hole ``dp = z u + i w density h v``, v the plate's velocity and u
        that of the air relative to it; of all that moves ``dp = Z v + perforation i w density h (v + u)``, Z the
        plate's impedance in vacuum; v + perforation u goes on. That is plate and holes in parallel, as Y. Y. Lee, E. W.
        M. Lee & C. F. Ng, J. Sound Vib. 287 (2005) 227-243 have it, and the air's share of momentum. D. Takahashi & M.
        Tanaka, J. Acoust. Soc. Am. 112 (2002) 1456-1464 let the resistance alone act on u; here the reactance does so
        too, as it follows from the equations of a viscous gas between moving walls.
        """
        gas, phi = wave.ambient, self.perforation
        resistance = jet_resistance(self.hole_velocity, self.bias_velocity, phi, self.discharge_coefficient, gas)
        resistance = resistance + grazing_resistance(self.grazing_mach, phi, gas)
        density = density + resistance / (1j * wave.omega * phi * self.thickness)
        if self.density is None:
            return density
        frame = (1 - phi) * self.density - self._stiffness(wave) * wave.kx**4 / (wave.omega**2 * self.thickness)
        return limp_density(density, phi, frame, gas)

    def _stiffness(self, wave: Wave) -> Numeric:
        if self.young_modulus is None:
            return 0.0
        assert self.poisson_ratio is not None  # validated
        modulus = complex_modulus(self.young_modulus, self.loss_factor, wave.frequency)
        return flexural_rigidity(modulus, self.poisson_ratio, self.thickness)
