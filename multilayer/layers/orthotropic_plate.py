"""A thin orthotropic plate in bending."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from multilayer.arrays import Numeric
from multilayer.layers.base import Layer
from multilayer.layers.elastic_plate import bending_faces
from multilayer.matrix.faces import Faces
from multilayer.matrix.wave import Wave
from multilayer.media.laws import Modulus, ModulusLaw, complex_modulus
from multilayer.media.plates import Rigidities
from multilayer.media.validity import warn_thick_plate
from multilayer.units import DIMENSIONLESS, Density, Length, Ratio, Unit

MajorPoissonRatio = Annotated[float, Unit(DIMENSIONLESS)]
Azimuth = Annotated[float, Unit("degree")]


class OrthotropicPlate(Layer):
    """A thin (Kirchhoff) plate with two axes of symmetry in its plane: wood, fibre composites, smeared ribs.

    Fields: `thickness` (m), `density` (kg/m3), `young_modulus_x`, `young_modulus_y`, `shear_modulus_xy` (Pa; numbers,
    complex numbers or laws), `poisson_ratio_xy` (of contraction along y under tension along x), `loss_factor` (of all
    moduli), `azimuth` (degrees, from the axis x of the plate to the plane of incidence of a single wave; in a diffuse
    field, which is averaged over all planes of incidence, the plate's orientation beside other layers'). State (p, v3):
    a solid neighbour slips on it; a poroelastic one meets it across a thin film of air, as `elastic_plate`. Holds while
    bending waves are longer than six thicknesses (`ValidityWarning` beyond, of oblique waves that bend it).
    """

    type: Literal["orthotropic_plate"] = "orthotropic_plate"
    thickness: Length
    density: Density
    young_modulus_x: Modulus
    young_modulus_y: Modulus
    poisson_ratio_xy: MajorPoissonRatio
    shear_modulus_xy: Modulus
    loss_factor: Ratio = 0.0
    azimuth: Azimuth = 0.0

    summary: ClassVar[str] = "thin orthotropic plate in bending (Kirchhoff), solids slip on it"
    lies_on_frames: ClassVar[bool] = True
    composes: ClassVar[bool] = False  # two plates bend more easily than one of their joint thickness
    isotropic_in_plane: ClassVar[bool] = False

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        moduli = (self.young_modulus_x, self.young_modulus_y, self.shear_modulus_xy)
        if self.loss_factor and not all(isinstance(modulus, float | int) for modulus in moduli):
            raise ValueError("loss_factor stands beside a modulus that has losses already; give one of the two")
        along, across = self.young_modulus_x, self.young_modulus_y
        if isinstance(along, ModulusLaw) or isinstance(across, ModulusLaw):
            return self
        if self.poisson_ratio_xy**2 * across.real >= along.real:
            raise ValueError("poisson_ratio_xy^2 must be below young_modulus_x / young_modulus_y: energy is negative")
        return self

    def stiffness(self, wave: Wave) -> Numeric:
        """Return the bending stiffness in the plane of incidence, N m; see `media.plates.Rigidities.at`."""
        return self._rigidities(wave).at(np.deg2rad(self.azimuth + np.asarray(wave.azimuth)))

    def _rigidities(self, wave: Wave) -> Rigidities:
        moduli = (self.young_modulus_x, self.young_modulus_y, self.shear_modulus_xy)
        ex, ey, g = (complex_modulus(modulus, self.loss_factor, wave.frequency) for modulus in moduli)
        nu_yx = self.poisson_ratio_xy * ey / ex
        inertia = self.thickness**3 / 12
        plane = inertia / (1 - self.poisson_ratio_xy * nu_yx)
        return Rigidities(ex * plane, ey * plane, nu_yx * ex * plane + 2 * g * inertia)

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices."""
        mass, stiffness = self.density * self.thickness, self.stiffness(wave)
        warn_thick_plate("orthotropic_plate", self.thickness, stiffness, mass, wave.kx, wave.omega)
        return bending_faces(wave, stiffness, mass)


def orthotropic_faces(wave: Wave, rigidities: Rigidities, azimuth: Numeric, surface_density: Numeric) -> Faces:
    """Return the face matrices of a thin plate that bends more easily one way than the other.

    Parameters
    ----------
    wave : Wave
    rigidities : Rigidities
        N m.
    azimuth : float or array
        Of axis x, degrees; added to that of the wave.
    surface_density : float or array
        kg/m2.
    """
    return bending_faces(wave, rigidities.at(np.deg2rad(azimuth + np.asarray(wave.azimuth))), surface_density)
