"""A plate stiffened by ribs."""

from __future__ import annotations

from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from multilayer.arrays import Numeric
from multilayer.layers.base import ElasticLayer
from multilayer.layers.orthotropic_plate import Azimuth, orthotropic_faces
from multilayer.matrix.faces import Faces
from multilayer.matrix.wave import Wave
from multilayer.media.plates import flat_resonance, ribbed
from multilayer.media.validity import warn_outside
from multilayer.models import refuse
from multilayer.units import Density, Length


class RibbedPlate(ElasticLayer):
    """A thin plate with equal, rectangular ribs of its own material along its axis x, as one orthotropic plate.

    Fields: `thickness` (m, of the plate), `density` (kg/m3), `young_modulus` (Pa), `poisson_ratio`, `loss_factor`,
    `rib_height` (m, beyond the plate's face), `rib_width`, `rib_spacing` (m, between their middles), `azimuth`
    (degrees, as of `orthotropic_plate`). State (p, v3): neighbours as of `elastic_plate`.

    Holds for a spacing below half the trace wavelength, and below the first resonance of the plate between two ribs
    (`ValidityWarning` beyond), from where on plate and ribs no longer move as one.
    """

    type: Literal["ribbed_plate"] = "ribbed_plate"
    thickness: Length
    density: Density
    rib_height: Length
    rib_width: Length
    rib_spacing: Length
    azimuth: Azimuth = 0.0

    summary: ClassVar[str] = "plate with ribs on one face as an orthotropic plate, solids slip on it"
    lies_on_frames: ClassVar[bool] = True
    composes: ClassVar[bool] = False
    vanishes: ClassVar[bool] = False  # the ribs stay, however thin the plate
    isotropic_in_plane: ClassVar[bool] = False

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        refuse(self, self._misfit_values())
        return self

    def _misfit_values(self) -> list[tuple[tuple[str], str, Any]]:
        if self.rib_width < self.rib_spacing:
            return []
        text = (
            f"{1e3 * self.rib_width:g} mm is not allowed: it must be below rib_spacing, {1e3 * self.rib_spacing:g} mm"
        )
        return [(("rib_width",), text, self.rib_width)]

    @property
    def depth(self) -> Numeric:
        """Plate and ribs, m."""
        return self.thickness + self.rib_height

    @property
    def volume_per_area(self) -> Numeric:
        """Volume of plate and ribs over area, m."""
        return self.thickness + self.rib_height * self.rib_width / self.rib_spacing

    @property
    def mass_per_area(self) -> Numeric:
        """Mass of plate and ribs over area, kg/m2."""
        return self.density * self.volume_per_area

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices; Timoshenko & Woinowsky-Krieger 1959, see `media.plates.ribbed`."""
        modulus, what = self.complex_modulus(wave), "the ribbed plate"
        trace = self.rib_spacing * wave.kx / (2 * np.pi)
        warn_outside(what, "rib_spacing / trace wavelength", trace, -np.inf, 0.5, wave.frequency)
        bay = self.rib_spacing - self.rib_width
        ratio = wave.frequency / flat_resonance(modulus, self.poisson_ratio, self.thickness, self.density, bay)
        warn_outside(what, "frequency / resonance between ribs", ratio, -np.inf, 1, wave.frequency)
        ribs = (self.rib_height, self.rib_width, self.rib_spacing)
        rigidities = ribbed(modulus, self.poisson_ratio, self.thickness, *ribs)
        return orthotropic_faces(wave, rigidities, self.azimuth, self.mass_per_area)
