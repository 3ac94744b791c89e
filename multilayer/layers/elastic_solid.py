"""An isotropic elastic or viscoelastic solid of any thickness."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.layers.base import ElasticLayer
from multilayer.matrix.equations import FieldEquations
from multilayer.matrix.faces import Faces, choose, from_propagator, from_waves, is_thin, propagator_series
from multilayer.matrix.families import SOLID
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
    compression, shear = wave.omega**2 * density / (lam + 2 * mu), wave.omega**2 * density / mu
    k3 = [decaying_root(square - wave.kx**2) for square in (compression, shear)]
    arguments = (wave.omega, wave.kx, thickness, density, lam, mu, *k3, wave.ambient.impedance)
    return Faces(SOLID, *choose(is_thin(k3, wave.kx, thickness, shear), _series, _waves, arguments))


def _waves(
    omega: Numeric, kx: Numeric, thickness: Numeric, density: Numeric, lam: Numeric, mu: Numeric,
    k13: Numeric, k33: Numeric, _impedance: float,
) -> tuple[ComplexArray, ComplexArray]:  # fmt: skip
    """Return the face matrices from compression and shear waves of unit velocity."""
    d1, d3 = (omega * np.sqrt(np.abs(density / modulus)) for modulus in (lam + 2 * mu, mu))
    normal, tangential = density * omega - 2 * mu * kx**2 / omega, 2 * mu * kx / omega
    states = [
        [kx / d1, -k33 / d3],
        [k13 / d1, kx / d3],
        [-normal / d1, -tangential * k33 / d3],
        [-tangential * k13 / d1, normal / d3],
    ]
    return from_waves(SOLID, states, [k13, k33], thickness)


def _series(
    omega: Numeric, kx: Numeric, thickness: Numeric, density: Numeric, lam: Numeric, mu: Numeric,
    _k13: Numeric, _k33: Numeric, impedance: float,
) -> tuple[ComplexArray, ComplexArray]:  # fmt: skip
    """Return the face matrices from the field equations of plane strain."""
    x, y = _equations(omega, kx, density, lam, mu)
    return from_propagator(SOLID, propagator_series(SOLID, x, y, thickness), impedance)


def _equations(omega: Numeric, kx: Numeric, density: Numeric, lam: Numeric, mu: Numeric) -> tuple[Entries, Entries]:
    plane, ratio = 4 * mu * (lam + mu) / (lam + 2 * mu), lam / (lam + 2 * mu)
    x: Entries = [[1j * kx, 1j * omega / mu], [1j * omega * density, 1j * kx]]
    y: Entries = [
        [1j * kx * ratio, 1j * omega / (lam + 2 * mu)],
        [1j * (omega * density - kx**2 * plane / omega), 1j * kx * ratio],
    ]
    return x, y
