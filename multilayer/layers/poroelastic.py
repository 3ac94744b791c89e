"""A porous material with an elastic frame (Biot)."""

from __future__ import annotations

from typing import ClassVar, Literal

from multilayer.arrays import ComplexArray, Numeric
from multilayer.layers.base import ElasticLayer
from multilayer.matrix.faces import Faces, choose, from_propagator, from_waves, is_thin, propagator_series
from multilayer.matrix.families import POROELASTIC
from multilayer.matrix.wave import Wave
from multilayer.media.biot import BiotMedium, biot_medium, compressional_waves, shear_wave
from multilayer.media.elastic import decaying_root
from multilayer.media.porous import champoux_allard_modulus, johnson_density
from multilayer.units import (
    Density,
    FlowResistivity,
    Length,
    Porosity,
    Tortuosity,
)


class Poroelastic(ElasticLayer):
    """Isotropic poroelastic material: Biot's frame, Johnson-Champoux-Allard pores filled with the ambient gas.

    Fields: `thickness` (m), `porosity`, `flow_resistivity` (N s/m4), `tortuosity`, `viscous_length`,
    `thermal_length` (m), `frame_density` (kg/m3, of the frame per volume of material), `young_modulus` (Pa, in vacuo),
    `poisson_ratio`, `loss_factor`. State (v1s, v3s, v3f, s33s, s13s, s33f).
    """

    type: Literal["poroelastic"] = "poroelastic"
    thickness: Length
    porosity: Porosity
    flow_resistivity: FlowResistivity
    tortuosity: Tortuosity
    viscous_length: Length
    thermal_length: Length
    frame_density: Density

    summary: ClassVar[str] = "porous material with an elastic frame (Biot 6x6, Johnson-Champoux-Allard pores)"

    def medium(self, wave: Wave) -> BiotMedium:
        """Return the Biot coefficients at the frequencies of `wave`."""
        gas, omega = wave.ambient, wave.omega
        density = johnson_density(
            omega, self.porosity, self.flow_resistivity, self.tortuosity, self.viscous_length, gas
        )
        bulk = champoux_allard_modulus(omega, self.porosity, self.thermal_length, gas)
        modulus = self.complex_modulus(wave)
        return biot_medium(modulus, self.poisson_ratio, self.frame_density, self.porosity, density, bulk, gas.density)

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices; Allard & Atalla 2009, sections 6.5 and 11.3.3."""
        a, b = poroelastic_faces(wave, self.thickness, self.medium(wave))
        return Faces(POROELASTIC, a, b, self.porosity)


def poroelastic_faces(wave: Wave, thickness: Numeric, medium: BiotMedium) -> tuple[ComplexArray, ComplexArray]:
    """Return the face matrices (A, B) of a Biot medium."""
    compression = compressional_waves(wave.omega, medium)
    shear_square, shear_ratio = shear_wave(wave.omega, medium)
    squares = [compression[0][0], compression[1][0], shear_square]
    k3 = [decaying_root(square - wave.kx**2) for square in squares]

    def waves() -> tuple[ComplexArray, ComplexArray]:
        forward, backward = (
            _wave_states(wave, medium, compression, (shear_square, shear_ratio), [sign * k for k in k3])
            for sign in (1, -1)
        )
        return from_waves(forward, backward, k3, thickness)

    def series() -> tuple[ComplexArray, ComplexArray]:
        propagator = propagator_series(POROELASTIC, *_field_equations(wave, medium), thickness)
        return from_propagator(POROELASTIC, propagator, wave.ambient.impedance)

    return choose(is_thin(k3, wave.kx, thickness), series, waves)


def _wave_states(
    wave: Wave,
    medium: BiotMedium,
    compression: tuple[tuple[ComplexArray, ComplexArray, ComplexArray], ...],
    shear: tuple[ComplexArray, ComplexArray],
    k3: list[ComplexArray],
) -> list[list[Numeric]]:
    """Return the states of the three waves exp(-i k3 x3), one column each, of unit velocity."""
    m, omega, kx = medium, wave.omega, wave.kx
    columns = []
    for (square, frame, fluid), q in zip(compression, k3, strict=False):
        k = decaying_root(square)
        dilatation = frame * square
        columns.append(
            [
                frame * kx / k,
                frame * q / k,
                fluid * q / k,
                -((m.P - 2 * m.N) * dilatation + m.Q * fluid * square + 2 * m.N * frame * q**2) / (omega * k),
                -2 * m.N * frame * kx * q / (omega * k),
                -(m.Q * frame + m.R * fluid) * square / (omega * k),
            ]
        )
    (square, ratio), q = shear, k3[2]
    k = decaying_root(square)
    twist, bend = m.N * (q**2 - kx**2) / (omega * k), -2 * m.N * q * kx / (omega * k)
    columns.append([-q / k, kx / k, ratio * kx / k, bend, twist, 0 * twist])
    return [list(row) for row in zip(*columns, strict=True)]


def _field_equations(wave: Wave, medium: BiotMedium) -> tuple[list[list[Numeric]], list[list[Numeric]]]:
    """Return (X, Y): d(v1s, s33s, s33f)/dx3 = X (v3s, v3f, s13s) and d(v3s, v3f, s13s)/dx3 = Y (v1s, s33s, s33f).

    Biot's equations with x1-dependence exp(-i kx x1), the tangential fluid velocity eliminated.
    """
    m, w, kx = medium, wave.omega, wave.kx
    x: list[list[Numeric]] = [
        [1j * kx, 0, 1j * w / m.N],
        [1j * w * m.rho11, 1j * w * m.rho12, 1j * kx],
        [1j * w * m.rho12, 1j * w * m.rho22, 0],
    ]
    slip = m.rho12 / m.rho22
    # rate of the frame's dilatation, i w e_s, as a row over (v1s, s33s, s33f)
    dilatation = [-2j * m.N * kx / m.P_drained, 1j * w / m.P_drained, -1j * w * m.Q / (m.R * m.P_drained)]
    coupling = m.Q / m.R
    fluid = [-coupling * entry for entry in dilatation]
    tension = 2 * m.N * kx / w  # 2 N kx / w times the dilatation rate, from the tangential normal stress
    y: list[list[Numeric]] = [
        [dilatation[0] + 1j * kx, dilatation[1], dilatation[2]],
        [fluid[0] - 1j * kx * slip, fluid[1], fluid[2] + 1j * w / m.R - 1j * kx**2 / (w * m.rho22)],
        [
            1j * w * (m.rho11 - m.rho12 * slip) - 4j * m.N * kx**2 / w - tension * dilatation[0],
            1j * kx - tension * dilatation[1],
            -1j * kx * slip - tension * dilatation[2],
        ],
    ]
    return x, y
