"""A porous material with an elastic frame (Biot)."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.layers.base import ElasticLayer
from multilayer.layers.pores import StructuredPoreLayer
from multilayer.matrix.equations import FieldEquations
from multilayer.matrix.faces import Faces, FacesOf
from multilayer.matrix.families import POROELASTIC, Family
from multilayer.matrix.slab import Slab
from multilayer.matrix.small import Entries
from multilayer.matrix.wave import Wave
from multilayer.media.biot import BiotMedium, biot_medium, compressional_waves, shear_wave
from multilayer.media.elastic import decaying_root
from multilayer.media.pore_models import FramedPoreModelName
from multilayer.units import Density, Porosity


class Poroelastic(StructuredPoreLayer, ElasticLayer):
    """Isotropic poroelastic material: Biot's frame, pores filled with the ambient gas.

    Fields: `thickness` (m), `porosity`, `frame_density` (kg/m3, of the frame per volume of material), `young_modulus`
    (Pa, in vacuo), `poisson_ratio`, `loss_factor`; `model` of the pores: `jca` (Johnson-Champoux-Allard) with
    `flow_resistivity` (N s/m4), `tortuosity`, `viscous_length`, `thermal_length` (m), `jcal` with
    `thermal_permeability` (m2), `jcapl` with `static_viscous_tortuosity` and `static_thermal_tortuosity` besides; or
    `fibres`, `open_cells`, `grains` with the fields that they take in `equivalent_fluid`. State (v1s, v3s, v3f, s33s,
    s13s, s33f). Warns (`ValidityWarning`) where pores are not small beside the wavelength.
    """

    type: Literal["poroelastic"] = "poroelastic"
    model: FramedPoreModelName = "jca"
    porosity: Porosity
    frame_density: Density

    summary: ClassVar[str] = "porous material with an elastic frame (Biot 6x6)"

    def medium(self, wave: Wave) -> BiotMedium:
        """Return the Biot coefficients at the frequencies of `wave`."""
        density, bulk = self.pore_fluid(wave)
        modulus, gas = self.complex_modulus(wave), wave.ambient
        return biot_medium(modulus, self.poisson_ratio, self.frame_density, self.porosity, density, bulk, gas.density)

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices; Allard & Atalla 2009, sections 6.5 and 11.3.3."""
        return FacesOf(BiotSlab(wave, self.thickness, self.medium(wave)), self.porosity)

    def field_equations(self, wave: Wave) -> FieldEquations:
        """Return Biot's equations of plane strain."""
        return FieldEquations(POROELASTIC, *_equations(wave.omega, wave.kx, self.medium(wave)), self.porosity)


@dataclass(frozen=True, eq=False)
class BiotSlab(Slab):
    """A slab of a Biot medium."""

    family: ClassVar[Family] = POROELASTIC

    medium: BiotMedium

    @property
    def coefficients(self) -> tuple[Numeric, ...]:
        """Thickness and the coefficients of the medium; P follows from the others."""
        m = self.medium
        return self.thickness, m.N, m.P_drained, m.Q, m.R, m.rho11, m.rho12, m.rho22

    @cached_property
    def _types(self) -> tuple[tuple[ComplexArray, ...], ...]:
        """Biot's three waves."""
        return *compressional_waves(self.wave.omega, self.medium), shear_wave(self.wave.omega, self.medium)

    @cached_property
    def constants(self) -> tuple[Numeric, ...]:
        """What `equations` and `waves` take."""
        coefficients = (getattr(self.medium, field.name) for field in fields(self.medium))
        amplitudes = (value for each in self._types for value in each)
        k3 = (decaying_root(square - self.wave.kx**2) for square, *_ in self._types)
        return self.wave.omega, self.wave.kx, *coefficients, *amplitudes, *k3

    @property
    def shear(self) -> Numeric:
        """Squared wavenumber of the shear wave."""
        return self._types[2][0]

    @staticmethod
    def equations(*constants: Numeric) -> tuple[Entries, Entries]:
        """Return Biot's equations of plane strain."""
        omega, kx, *coefficients = constants[:10]
        return _equations(omega, kx, BiotMedium(*coefficients))

    @staticmethod
    def waves(*constants: Numeric) -> Entries:
        """Return the states of Biot's three waves, scaled to velocities of about 1."""
        omega, kx, *_ = constants
        m, amplitudes, k3 = BiotMedium(*constants[2:10]), constants[10:18], constants[18:]
        period = 1 / omega  # of a radian
        shearing = 2 * m.N * kx * period
        columns = []
        for q, (square, frame, fluid) in zip(k3, (amplitudes[:3], amplitudes[3:6]), strict=False):
            scale = 1 / np.sqrt(np.abs(square))
            moved, flowed, rate = scale * frame, scale * fluid, square * period
            along, across = moved * kx, moved * q
            frame_stress = shearing * along - (m.P * moved + m.Q * flowed) * rate
            fluid_stress = -(m.Q * moved + m.R * flowed) * rate
            columns.append([along, across, flowed * q, frame_stress, -shearing * across, fluid_stress])
        square, ratio = amplitudes[6:]
        q, scale = k3[2], 1 / np.sqrt(np.abs(square))
        along, across = -scale * q, scale * kx
        twist = m.N * (q**2 - kx**2) * (scale * period)
        columns.append([along, across, ratio * across, shearing * along, twist, 0.0])
        return [list(row) for row in zip(*columns, strict=True)]

    def by_medium(self, x: ComplexArray, y: ComplexArray) -> tuple[Numeric, ...]:
        """Return derivatives by the coefficients of the medium: `_equations` backwards."""
        w, kx, m = self.wave.omega, self.wave.kx, self.medium
        slip, coupling, tension = m.rho12 / m.rho22, m.Q / m.R, 2 * m.N * kx / w
        dilatation = [-2j * m.N * kx / m.P_drained, 1j * w / m.P_drained, -1j * w * coupling / m.P_drained]
        by_dilatation = [y[0, i] - coupling * y[1, i] - tension * y[2, i] for i in range(3)]
        by_coupling, by_tension = (-sum(dilatation[i] * y[row, i] for i in range(3)) for row in (1, 2))
        by_slip = -1j * (kx * (y[1, 0] + y[2, 2]) + w * m.rho12 * y[2, 0])
        by_coupling = by_coupling - 1j * w / m.P_drained * by_dilatation[2]
        compressed = 1j * w / m.R**2 * y[1, 2]
        return (
            -1j * w / m.N**2 * x[0, 2]
            - 2j * kx / m.P_drained * by_dilatation[0]
            + 2 * kx / w * by_tension
            - 4j * kx**2 / w * y[2, 0],
            -sum(dilatation[i] * by_dilatation[i] for i in range(3)) / m.P_drained,
            by_coupling / m.R,
            -coupling / m.R * by_coupling - compressed,
            1j * w * (x[1, 0] + y[2, 0]),
            1j * w * (x[1, 1] + x[2, 0] - slip * y[2, 0]) + by_slip / m.rho22,
            1j * w * x[2, 1] + 1j * kx**2 / (w * m.rho22**2) * y[1, 2] - slip / m.rho22 * by_slip,
        )


def _equations(w: Numeric, kx: Numeric, m: BiotMedium) -> tuple[Entries, Entries]:
    """Return Biot's equations, the tangential fluid velocity eliminated.

    ``d(v1s, s33s, s33f)/dx3 = X (v3s, v3f, s13s)`` and ``d(v3s, v3f, s13s)/dx3 = Y (v1s, s33s, s33f)``.
    """
    x: Entries = [
        [1j * kx, 0, 1j * w / m.N],
        [1j * w * m.rho11, 1j * w * m.rho12, 1j * kx],
        [1j * w * m.rho12, 1j * w * m.rho22, 0],
    ]
    slip = m.rho12 / m.rho22
    # rate of the frame's dilatation, i w e_s, as a row over (v1s, s33s, s33f)
    dilatation = [-2j * m.N * kx / m.P_drained, 1j * w / m.P_drained, -1j * w * m.Q / (m.R * m.P_drained)]
    coupling = m.Q / m.R
    fluid = [-coupling * entry for entry in dilatation]
    tension = 2 * m.N * kx / w  # from the tangential normal stress
    y: Entries = [
        [dilatation[0] + 1j * kx, dilatation[1], dilatation[2]],
        [fluid[0] - 1j * kx * slip, fluid[1], fluid[2] + 1j * w / m.R - 1j * kx**2 / (w * m.rho22)],
        [
            1j * w * (m.rho11 - m.rho12 * slip) - 4j * m.N * kx**2 / w - tension * dilatation[0],
            1j * kx - tension * dilatation[1],
            -1j * kx * slip - tension * dilatation[2],
        ],
    ]
    return x, y
