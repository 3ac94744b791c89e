"""A perforated or micro-perforated plate."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from multilayer.layers.base import Layer
from multilayer.layers.fluid import fluid_faces
from multilayer.matrix.faces import Faces, from_series_impedance
from multilayer.matrix.families import FLUID
from multilayer.matrix.wave import Wave
from multilayer.media.perforations import end_length, hole_pitch, maa_impedance
from multilayer.media.porous import champoux_allard_modulus, johnson_density
from multilayer.media.validity import warn_outside
from multilayer.units import DIMENSIONLESS, Length, Tortuosity, Unit

Perforation = Annotated[float, Field(gt=0, lt=math.pi / 4), Unit(DIMENSIONLESS)]


class PerforatedPlate(Layer):
    """A rigid plate that does not move, with round holes of any size.

    Fields: `thickness` (m), `hole_radius` (m; the radius, not the diameter), `perforation` (area of the holes over area
    of the plate, below pi/4, where holes in a square array touch), `front_tortuosity`, `back_tortuosity` (of a porous
    material that touches that face: the air pulsing out of the holes enters it), `model`: `atalla_sgard`, a porous
    material of straight pores whose tortuosity holds the mass outside, or `maa`, the exact viscous flow in
    micro-perforations with Maa's end corrections. State (p, v3). Nothing flows along the plate.

    Holds for a pitch of the holes below half a wavelength (`ValidityWarning` beyond), low sound levels, no mean flow.
    """

    type: Literal["perforated_plate"] = "perforated_plate"
    model: Literal["atalla_sgard", "maa"] = "atalla_sgard"
    thickness: Length
    hole_radius: Length
    perforation: Perforation
    front_tortuosity: Tortuosity = 1.0
    back_tortuosity: Tortuosity = 1.0

    summary: ClassVar[str] = "rigid plate with round holes, perforated or micro-perforated"
    composes: ClassVar[bool] = False  # the air outside the holes belongs to it
    vanishes: ClassVar[bool] = False  # and stays, however thin the plate

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices; Atalla & Sgard 2007, or Maa 1998, see `media.perforations`."""
        pitch = hole_pitch(self.hole_radius, self.perforation) * wave.frequency / wave.ambient.sound_speed
        warn_outside("the perforated plate", "pitch of the holes / wavelength", pitch, -np.inf, 0.5, wave.frequency)
        return self._as_porous(wave) if self.model == "atalla_sgard" else self._as_sheet(wave)

    def _as_porous(self, wave: Wave) -> Faces:
        """Return the faces of straight pores: sigma = 8 eta / (phi r^2), both lengths r, alpha_inf = 1 + ends / h."""
        gas, phi, r = wave.ambient, self.perforation, self.hole_radius
        ends = end_length(r, phi) * (self.front_tortuosity + self.back_tortuosity)
        resistivity, tortuosity = 8 * gas.viscosity / (phi * r**2), 1 + ends / self.thickness
        density = johnson_density(wave.omega, phi, resistivity, tortuosity, r, gas)
        bulk = champoux_allard_modulus(wave.omega, phi, r, gas)
        return fluid_faces(wave, self.thickness, density, bulk, lateral=0.0)

    def _as_sheet(self, wave: Wave) -> Faces:
        """Return the faces of a sheet, thin beside the wavelength."""
        ends = (self.front_tortuosity + self.back_tortuosity) / 2
        impedance = maa_impedance(wave.omega, self.thickness, self.hole_radius, self.perforation, ends, wave.ambient)
        return Faces(FLUID, *from_series_impedance(impedance, wave.ambient.impedance))
