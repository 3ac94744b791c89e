"""An isotropic elastic or viscoelastic solid of any thickness."""

from __future__ import annotations

from typing import ClassVar, Literal

from multilayer.arrays import ComplexArray, Numeric
from multilayer.layers.base import ElasticLayer
from multilayer.matrix.faces import Faces, choose, from_propagator, from_waves, is_thin, propagator_series
from multilayer.matrix.families import SOLID
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


def solid_faces(wave: Wave, thickness: Numeric, density: Numeric, lam: Numeric, mu: Numeric) -> Faces:
    """Return the face matrices of an isotropic solid with Lame's coefficients `lam` and `mu`, Pa."""
    omega, kx = wave.omega, wave.kx
    compression, shear = omega**2 * density / (lam + 2 * mu), omega**2 * density / mu
    k13, k33 = decaying_root(compression - kx**2), decaying_root(shear - kx**2)

    def waves() -> tuple[ComplexArray, ComplexArray]:
        d1, d3 = decaying_root(compression), decaying_root(shear)
        normal, tangential = mu * (shear - 2 * kx**2) / omega, 2 * mu * kx / omega

        def states(sign: int) -> list[list[Numeric]]:
            p, s = sign * k13, sign * k33
            return [
                [kx / d1, -s / d3],
                [p / d1, kx / d3],
                [-normal / d1, -tangential * s / d3],
                [-tangential * p / d1, normal / d3],
            ]

        return from_waves(states(1), states(-1), [k13, k33], thickness)

    def series() -> tuple[ComplexArray, ComplexArray]:
        plane = 4 * mu * (lam + mu) / (lam + 2 * mu)
        ratio = lam / (lam + 2 * mu)
        x = [[1j * kx, 1j * omega / mu], [1j * omega * density, 1j * kx]]
        y = [
            [1j * kx * ratio, 1j * omega / (lam + 2 * mu)],
            [1j * (omega * density - kx**2 * plane / omega), 1j * kx * ratio],
        ]
        propagator = propagator_series(SOLID, x, y, thickness)
        return from_propagator(SOLID, propagator, wave.ambient.impedance)

    return Faces(SOLID, *choose(is_thin([k13, k33], kx, thickness), series, waves))
