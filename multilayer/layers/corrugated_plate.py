"""A corrugated or profiled sheet."""

from __future__ import annotations

from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from multilayer.arrays import Numeric
from multilayer.layers.base import ElasticLayer
from multilayer.layers.orthotropic_plate import Azimuth, orthotropic_faces
from multilayer.matrix.faces import Faces
from multilayer.matrix.wave import Wave
from multilayer.media.plates import Profile, corrugated, flat_resonance, sinusoidal, trapezoidal
from multilayer.media.validity import warn_outside
from multilayer.models import refuse
from multilayer.units import Density, Length


class CorrugatedPlate(ElasticLayer):
    """A thin sheet with corrugations along its axis x, sinusoidal or trapezoidal, as one orthotropic plate in bending.

    Fields: `thickness` (m, of the sheet), `density` (kg/m3, of its material), `young_modulus` (Pa), `poisson_ratio`,
    `loss_factor`, `period`, `height` (m, of the sheet's middle line), `crest_width`, `trough_width` (m, flats of
    trapezoids; a sine where `crest_width` is left out, flats of one width where `trough_width` is), `azimuth` (degrees,
    as of `orthotropic_plate`). State (p, v3): neighbours as of `elastic_plate`.

    Holds for a period below half the trace wavelength and, of trapezoids, below the first resonance of the widest flat
    (`ValidityWarning` beyond): the resonances of flats let more sound through (C. H. Hansen, Noise Control Eng. J. 40
    (1993) 187-197) and are left out, and so is the air in the corrugations.
    """

    type: Literal["corrugated_plate"] = "corrugated_plate"
    thickness: Length
    density: Density
    period: Length
    height: Length
    crest_width: Length | None = None
    trough_width: Length | None = None
    azimuth: Azimuth = 0.0

    summary: ClassVar[str] = "corrugated or profiled sheet as an orthotropic plate, solids slip on it"
    lies_on_frames: ClassVar[bool] = True
    composes: ClassVar[bool] = False
    isotropic_in_plane: ClassVar[bool] = False

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        refuse(self, self._misfit_values())
        return self

    def _misfit_values(self) -> list[tuple[tuple[str], str, Any]]:
        if self.crest_width is None:
            text = "goes with crest_width; leave both out for a sine"
            return [] if self.trough_width is None else [(("trough_width",), text, self.trough_width)]
        flats = self.crest_width + (self.crest_width if self.trough_width is None else self.trough_width)
        if flats > self.period:
            text = f"crest and trough, {1e3 * flats:g} mm together, must fit into the period, {1e3 * self.period:g} mm"
            return [(("crest_width",), text, self.crest_width)]
        return []

    @property
    def depth(self) -> Numeric:
        """Height of the corrugations, the sheet's thickness included, m."""
        return self.height + self.thickness

    @property
    def volume_per_area(self) -> Numeric:
        """Volume of the sheet over the area that it covers, m."""
        return np.asarray(self.thickness * self._profile().length)

    @property
    def mass_per_area(self) -> Numeric:
        """Mass of the sheet over the area that it covers, kg/m2."""
        return self.density * self.volume_per_area

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices; Xia, Friswell & Saavedra Flores 2012, see `media.plates.corrugated`."""
        profile, modulus = self._profile(), self.complex_modulus(wave)
        what = "the corrugated plate"
        trace = self.period * wave.kx / (2 * np.pi)
        warn_outside(what, "period / trace wavelength", trace, -np.inf, 0.5, wave.frequency)
        if self.crest_width is not None:
            flat = self._widest_flat(self.crest_width)
            ratio = wave.frequency / flat_resonance(modulus, self.poisson_ratio, self.thickness, self.density, flat)
            warn_outside(what, "frequency / resonance of the flats", ratio, -np.inf, 1, wave.frequency)
        rigidities = corrugated(modulus, self.poisson_ratio, self.thickness, profile)
        return orthotropic_faces(wave, rigidities, self.azimuth, self.mass_per_area)

    def _profile(self) -> Profile:
        if self.crest_width is None:
            return sinusoidal(self.period, self.height)
        return trapezoidal(self.period, self.height, self.crest_width, self._trough_width(self.crest_width))

    def _trough_width(self, crest: Numeric) -> Numeric:
        return crest if self.trough_width is None else self.trough_width

    def _widest_flat(self, crest: Numeric) -> Numeric:
        trough = self._trough_width(crest)
        flank = np.hypot((self.period - crest - trough) / 2, self.height)
        return np.maximum(np.maximum(crest, trough), flank)
