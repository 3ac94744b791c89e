"""Air in narrow spaces, with viscosity and heat conduction."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from multilayer.arrays import Numeric
from multilayer.layers.base import Layer
from multilayer.layers.fluid import fluid_faces
from multilayer.matrix.faces import Faces
from multilayer.matrix.wave import Wave
from multilayer.media.narrow import narrow_gas
from multilayer.media.validity import warn_outside
from multilayer.units import DIMENSIONLESS, Length, Unit

_TITLE = "the visco-thermal fluid"
OpenArea = Annotated[float, Field(gt=0, le=1), Unit(DIMENSIONLESS)]


class ViscothermalFluid(Layer):
    """The ambient gas between rigid, isothermal walls, at low reduced frequencies.

    Fields: `thickness` (m); for walls across the layer `tube_radius` or `slit_width` (m, the full width) and
    `open_area` (of the faces): a honeycomb, a bundle of tubes, a stack of slats, in which nothing flows along the
    layer. With neither the layer itself is the gap, between two impervious neighbours at its faces: a film of air that
    is pumped along them. State (p, v3).

    Holds for half widths above 10 um and below 1e4 m s^(-3/2) / f^(3/2) (Stinson), tubes and slits narrower than half a
    wavelength (`ValidityWarning` beyond).
    """

    type: Literal["viscothermal_fluid"] = "viscothermal_fluid"
    thickness: Length
    tube_radius: Length | None = None
    slit_width: Length | None = None
    open_area: OpenArea = 1.0

    summary: ClassVar[str] = "air with viscous and thermal losses: in tubes, in slits, or as a thin gap"
    stands_still: ClassVar[bool] = True
    composes: ClassVar[bool] = False  # two gaps have four walls

    @model_validator(mode="after")
    def _one_geometry(self) -> Self:
        if self.tube_radius is not None and self.slit_width is not None:
            raise ValueError("tube_radius and slit_width exclude each other")
        if self.open_area < 1 and self.tube_radius is None and self.slit_width is None:
            raise ValueError("open_area goes with tube_radius or slit_width; a gap is open over all its area")
        return self

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices.

        Allard & Atalla 2009, sections 4.2-4.5; W. M. Beltman, J. Sound Vib. 227 (1999) 555-586, for the gap.
        """
        if self.tube_radius is not None:
            return self._across(wave, "tube", self.tube_radius)
        if self.slit_width is not None:
            return self._across(wave, "slit", self.slit_width / 2)
        _check(wave, self.thickness / 2)
        density, bulk = narrow_gas(wave.omega, "slit", self.thickness / 2, wave.ambient)
        free = wave.ambient.density  # normal to the walls the gas moves with them
        return fluid_faces(wave, self.thickness, free, bulk, lateral=free / density)

    def _across(self, wave: Wave, shape: str, half_width: Numeric) -> Faces:
        _check(wave, half_width)
        width = 2 * half_width * wave.frequency / wave.ambient.sound_speed
        warn_outside(_TITLE, f"width of a {shape} / wavelength", width, -np.inf, 0.5, wave.frequency)
        density, bulk = narrow_gas(wave.omega, shape, half_width, wave.ambient)
        return fluid_faces(wave, self.thickness, density / self.open_area, bulk / self.open_area, lateral=0.0)


def _check(wave: Wave, half_width: Numeric) -> None:
    warn_outside(_TITLE, "half widths (m)", half_width, 1e-5, np.inf)
    reduced = half_width * wave.frequency**1.5
    warn_outside(_TITLE, "half width f^(3/2) (m s^(-3/2))", reduced, -np.inf, 1e4, wave.frequency)
