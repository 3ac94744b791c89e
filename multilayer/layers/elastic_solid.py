"""An isotropic elastic or viscoelastic solid of any thickness."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.layers.base import ElasticLayer
from multilayer.matrix.equations import FieldEquations
from multilayer.matrix.faces import Faces, FacesOf
from multilayer.matrix.families import SOLID, Family
from multilayer.matrix.slab import Slab
from multilayer.matrix.small import Entries
from multilayer.matrix.wave import Wave
from multilayer.media.elastic import decaying_root, lame
from multilayer.units import Density, Length


class ElasticSolid(ElasticLayer):
    """A solid that carries compression and shear waves: thick plates, rubbers, foams taken as one phase.

    Fields: `thickness` (m), `density` (kg/m3), `young_modulus` (Pa; number, complex number or law), `poisson_ratio`,
    `loss_factor`. State (v1, v3, s33, s13).
    """

    type: Literal["elastic_solid"] = "elastic_solid"
    thickness: Length
    density: Density

    summary: ClassVar[str] = "isotropic elastic or viscoelastic solid, any thickness (4x4)"

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices; Allard & Atalla 2009, section 11.3.2; Bonfiglio & Pompoli 2015, eqs. (5)-(8)."""
        modulus = self.complex_modulus(wave)
        lam, mu = lame(modulus, self.poisson_ratio)
        return solid_faces(wave, self.thickness, self.density, lam, mu)

    def field_equations(self, wave: Wave) -> FieldEquations:
        """Return the field equations of plane strain."""
        lam, mu = lame(self.complex_modulus(wave), self.poisson_ratio)
        return FieldEquations(SOLID, *_equations(wave.omega, wave.kx, self.density, lam, mu))


def solid_faces(wave: Wave, thickness: Numeric, density: Numeric, lam: Numeric, mu: Numeric) -> Faces:
    """Return the face matrices of an isotropic solid with Lame's coefficients `lam` and `mu`, Pa."""
    return FacesOf(SolidSlab(wave, thickness, density, lam, mu))


@dataclass(frozen=True, eq=False)
class SolidSlab(Slab):
    """A slab of an isotropic solid; see `solid_faces`."""

    family: ClassVar[Family] = SOLID

    density: Numeric
    lam: Numeric
    mu: Numeric

    @property
    def coefficients(self) -> tuple[Numeric, ...]:
        """Thickness, density and Lame's coefficients."""
        return self.thickness, self.density, self.lam, self.mu

    @cached_property
    def constants(self) -> tuple[Numeric, ...]:
        """What `equations` and `waves` take."""
        squares = self.wave.omega**2 * self.density / (self.lam + 2 * self.mu), self.shear
        k3 = [decaying_root(square - self.wave.kx**2) for square in squares]
        return self.wave.omega, self.wave.kx, self.density, self.lam, self.mu, *k3

    @property
    def shear(self) -> Numeric:
        """Squared wavenumber of the shear wave."""
        return self.wave.omega**2 * self.density / self.mu

    @staticmethod
    def equations(*constants: Numeric) -> tuple[Entries, Entries]:
        """Return the field equations of plane strain."""
        return _equations(*constants[:5])

    @staticmethod
    def waves(*constants: Numeric) -> Entries:
        """Return compression and shear waves of unit velocity."""
        omega, kx, density, lam, mu, k13, k33 = constants
        d1, d3 = (omega * np.sqrt(np.abs(density / modulus)) for modulus in (lam + 2 * mu, mu))
        normal, tangential = density * omega - 2 * mu * kx**2 / omega, 2 * mu * kx / omega
        return [
            [kx / d1, -k33 / d3],
            [k13 / d1, kx / d3],
            [-normal / d1, -tangential * k33 / d3],
            [-tangential * k13 / d1, normal / d3],
        ]

    def by_medium(self, x: ComplexArray, y: ComplexArray) -> tuple[Numeric, ...]:
        """Return derivatives by density and Lame's coefficients; see `_equations`."""
        omega, kx, lam, mu = self.wave.omega, self.wave.kx, self.lam, self.mu
        constrained = lam + 2 * mu
        across, diagonal, plane = 1j * omega * y[0, 1], 1j * kx * (y[0, 0] + y[1, 1]), -1j * kx**2 / omega * y[1, 0]
        by_lam = (2 * mu * diagonal + 4 * mu**2 * plane - across) / constrained**2
        by_mu = (
            (4 - 8 * mu * (lam + mu) / constrained**2) * plane
            - (2 * lam * diagonal + 2 * across) / constrained**2
            - 1j * omega / mu**2 * x[0, 1]
        )
        return 1j * omega * (x[1, 0] + y[1, 0]), by_lam, by_mu


def _equations(omega: Numeric, kx: Numeric, density: Numeric, lam: Numeric, mu: Numeric) -> tuple[Entries, Entries]:
    plane, ratio = 4 * mu * (lam + mu) / (lam + 2 * mu), lam / (lam + 2 * mu)
    x: Entries = [[1j * kx, 1j * omega / mu], [1j * omega * density, 1j * kx]]
    y: Entries = [
        [1j * kx * ratio, 1j * omega / (lam + 2 * mu)],
        [1j * (omega * density - kx**2 * plane / omega), 1j * kx * ratio],
    ]
    return x, y
