"""A thin orthotropic plate in bending."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from multilayer.arrays import ComplexArray
from multilayer.layers.base import Layer
from multilayer.matrix.faces import Faces, from_series_impedance
from multilayer.matrix.families import FLUID
from multilayer.matrix.wave import Wave
from multilayer.media.laws import Modulus, ModulusLaw, complex_modulus
from multilayer.units import DIMENSIONLESS, Density, Length, Ratio, Unit

MajorPoissonRatio = Annotated[float, Unit(DIMENSIONLESS)]
Azimuth = Annotated[float, Unit("degree")]


class OrthotropicPlate(Layer):
    """A thin (Kirchhoff) plate with two axes of symmetry in its plane: wood, fibre composites, smeared ribs.

    Fields: `thickness` (m), `density` (kg/m3), `young_modulus_x`, `young_modulus_y`, `shear_modulus_xy` (Pa; numbers,
    complex numbers or laws), `poisson_ratio_xy` (of contraction along y under tension along x), `loss_factor` (of all
    moduli), `azimuth` (degrees, from the axis x of the plate to the plane of incidence of a single wave; in a diffuse
    field, which is averaged over all planes of incidence, the plate's orientation beside other layers'). State (p, v3):
    a solid or poroelastic neighbour slips on it. Holds while bending waves are longer than about six thicknesses.
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

    summary: ClassVar[str] = "thin orthotropic plate in bending (Kirchhoff), neighbours slip on it"
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

    def stiffness(self, wave: Wave) -> ComplexArray:
        """Return the bending stiffness in the plane of incidence, N m.

        ``D = Dx cos^4 + 2 (nu_yx Dx + G h^3 / 6) cos^2 sin^2 + Dy sin^4``: S. P. Timoshenko & S. Woinowsky-Krieger,
        Theory of Plates and Shells, 2nd ed. (1959), section 85; M. Heckl, Acustica 10 (1960) 109-115.
        """
        moduli = (self.young_modulus_x, self.young_modulus_y, self.shear_modulus_xy)
        ex, ey, g = (complex_modulus(modulus, self.loss_factor, wave.frequency) for modulus in moduli)
        nu_yx = self.poisson_ratio_xy * ey / ex
        angle = np.deg2rad(self.azimuth + np.asarray(wave.azimuth))
        along, across = np.cos(angle) ** 2, np.sin(angle) ** 2
        plane = 1 - self.poisson_ratio_xy * nu_yx
        bending = (ex * along**2 + ey * across**2 + 2 * nu_yx * ex * along * across) / plane
        return np.asarray((bending + 4 * g * along * across) * self.thickness**3 / 12)

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices: p(front) - p(back) = (i w m + D kx^4 / (i w)) v3."""
        mass = 1j * wave.omega * self.density * self.thickness
        impedance = mass + self.stiffness(wave) * wave.kx**4 / (1j * wave.omega)
        return Faces(FLUID, *from_series_impedance(impedance, wave.ambient.impedance))
