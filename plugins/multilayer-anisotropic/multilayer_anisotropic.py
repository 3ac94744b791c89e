"""The layer types `anisotropic_solid` and `anisotropic_poroelastic`: transversely isotropic about the thickness."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from multilayer.arrays import Numeric
from multilayer.errors import ValidityWarning
from multilayer.layers import Layer
from multilayer.layers.pores import PoreLayer
from multilayer.matrix.equations import FieldEquations, slab_faces
from multilayer.matrix.faces import Faces
from multilayer.matrix.families import POROELASTIC, SOLID
from multilayer.matrix.small import Entries
from multilayer.matrix.wave import Wave
from multilayer.media.biot import biot_medium
from multilayer.media.laws import Modulus, complex_modulus
from multilayer.units import (
    DIMENSIONLESS,
    Density,
    FlowResistivity,
    Length,
    Porosity,
    Ratio,
    Tortuosity,
    Unit,
)

# of an anisotropic solid it may be above 0.5: the elastic energy sets the limits
AnyPoissonRatio = Annotated[float, Field(gt=-10, lt=10), Unit(DIMENSIONLESS)]
InPlanePoissonRatio = Annotated[float, Field(gt=-1, lt=1), Unit(DIMENSIONLESS)]
_ROUNDING = 1e-12
_FOAM = {
    "young_modulus": 1.6e5, "young_modulus_inplane": 8e4, "shear_modulus": 5e4, "poisson_ratio": 0.5,
    "poisson_ratio_inplane": 0.2, "loss_factor": 0.1,
}  # fmt: skip
_PORES = {
    "porosity": 0.98, "flow_resistivity": 2e4, "tortuosity": 1.02, "viscous_length": 8e-5, "thermal_length": 2e-4,
    "flow_resistivity_inplane": 9e3,
}  # fmt: skip


@dataclass(frozen=True)
class Stiffness:
    """What of a transversely isotropic stiffness a wave in the plane of x1 and x3 meets, Pa; axis 3 is the symmetry's.

    ``s11 = C11 e11 + C13 e33``, ``s33 = C13 e11 + C33 e33``, ``s13 = 2 C44 e13`` (``e22 = 0``).
    """

    C11: Numeric
    C13: Numeric
    C33: Numeric
    C44: Numeric

    @property
    def is_passive(self) -> bool:
        """Whether no strain sets energy free."""
        c11, c13, c33, c44 = (np.asarray(c, dtype=complex) for c in (self.C11, self.C13, self.C33, self.C44))
        slack = _ROUNDING * np.abs(c11 * c33)
        return bool(
            np.all(c11.imag >= -_ROUNDING * np.abs(c11))
            and np.all(c33.imag >= -_ROUNDING * np.abs(c33))
            and np.all(c11.imag * c33.imag - c13.imag**2 >= -slack)
            and np.all(c44.imag >= 0)
        )


class TransverselyIsotropic(Layer):
    """Fields of a transversely isotropic skeleton, the axis along the thickness.

    `young_modulus` E3 along the axis, `young_modulus_inplane` E1 across it, `shear_modulus` G13 (Pa; numbers, complex
    numbers or laws), `poisson_ratio` nu31 (of the contraction in the plane when pulled along the axis),
    `poisson_ratio_inplane` nu12, and `loss_factor` on top of all moduli.
    """

    young_modulus: Modulus
    young_modulus_inplane: Modulus
    shear_modulus: Modulus
    poisson_ratio: AnyPoissonRatio
    poisson_ratio_inplane: InPlanePoissonRatio
    loss_factor: Ratio = 0.0

    @model_validator(mode="after")
    def _damped_once(self) -> Self:
        moduli = (self.young_modulus, self.young_modulus_inplane, self.shear_modulus)
        if self.loss_factor and not all(isinstance(modulus, float | int) for modulus in moduli):
            raise ValueError("loss_factor stands beside a modulus that has losses already; give one of the two")
        return self

    @model_validator(mode="after")
    def _strains_store_energy(self) -> Self:
        along, across = (
            np.asarray(complex_modulus(modulus, 0.0, 1.0)).real
            for modulus in (self.young_modulus, self.young_modulus_inplane)
        )
        if not np.all(1 - self.poisson_ratio_inplane - 2 * self.poisson_ratio**2 * across / along > 0):
            raise ValueError(
                "no elastic solid has such Poisson's ratios: 1 - poisson_ratio_inplane must be above "
                "2 poisson_ratio^2 young_modulus_inplane / young_modulus"
            )
        return self

    def stiffness(self, wave: Wave) -> Stiffness:
        """Return the stiffness at the frequencies of `wave`; the inverse of the compliance (Lekhnitskii 1963).

        Warns (`ValidityWarning`) where moduli of different loss give a stiffness that sets energy free.
        """
        along, across, shear = (
            complex_modulus(modulus, self.loss_factor, wave.frequency)
            for modulus in (self.young_modulus, self.young_modulus_inplane, self.shear_modulus)
        )
        ratio, inplane = self.poisson_ratio, self.poisson_ratio_inplane
        rest = 1 - inplane - 2 * ratio**2 * across / along
        found = Stiffness(
            C11=(across / rest + across / (1 + inplane)) / 2,
            C13=ratio * across / rest,
            C33=along * (1 - inplane) / rest,
            C44=shear,
        )
        if not found.is_passive:
            text = f"layer {self.name or self.type}: moduli of such different losses set energy free in some strains"
            warnings.warn(text, ValidityWarning, stacklevel=2)
        return found


class AnisotropicSolid(TransverselyIsotropic):
    """A transversely isotropic solid, stiff otherwise through its thickness than along it.

    Fields: `thickness` (m), `density` (kg/m3), `young_modulus`, `young_modulus_inplane`, `shear_modulus` (Pa),
    `poisson_ratio`, `poisson_ratio_inplane`, `loss_factor`; see `TransverselyIsotropic`. State (v1, v3, s33, s13).
    """

    type: Literal["anisotropic_solid"] = "anisotropic_solid"
    thickness: Length
    density: Density

    summary: ClassVar[str] = "transversely isotropic solid, its axis along the thickness (4x4)"
    examples: ClassVar[tuple[Mapping[str, Any], ...]] = ({"thickness": 0.02, "density": 60.0, **_FOAM},)

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices, from the field equations."""
        return slab_faces(wave, self.thickness, self.field_equations(wave))

    def field_equations(self, wave: Wave) -> FieldEquations:
        """Return Hooke's law and Newton's for plane strain, stresses on the layer's planes and velocities kept."""
        x, y = _solid(wave, self.density, self.stiffness(wave))
        return FieldEquations(SOLID, x, y)


def _solid(wave: Wave, density: Numeric, c: Stiffness) -> tuple[Entries, Entries]:
    w, kx = wave.omega, wave.kx
    ratio, plane = c.C13 / c.C33, c.C11 - c.C13**2 / c.C33
    x: Entries = [[1j * kx, 1j * w / c.C44], [1j * w * density, 1j * kx]]
    y: Entries = [[1j * kx * ratio, 1j * w / c.C33], [1j * (w * density - kx**2 * plane / w), 1j * kx * ratio]]
    return x, y


class AnisotropicPoroelastic(TransverselyIsotropic, PoreLayer):
    """A poroelastic material (Biot) with a transversely isotropic frame and pores.

    Fields: those of `poroelastic` with the moduli of `anisotropic_solid` for the frame in vacuo; and
    `flow_resistivity_inplane` (N s/m4), `tortuosity_inplane`, `viscous_length_inplane` (m), each that through the
    thickness where left out. The frame's own material is stiff beside the frame, so that the pressure in the pores acts
    alike along all axes. State (v1s, v3s, v3f, s33s, s13s, s33f).
    """

    type: Literal["anisotropic_poroelastic"] = "anisotropic_poroelastic"
    model: Literal["jca", "jcal", "jcapl"] = "jca"
    porosity: Porosity
    flow_resistivity: FlowResistivity
    tortuosity: Tortuosity
    viscous_length: Length
    thermal_length: Length
    frame_density: Density
    flow_resistivity_inplane: FlowResistivity | None = None
    tortuosity_inplane: Tortuosity | None = None
    viscous_length_inplane: Length | None = None

    summary: ClassVar[str] = "porous material with a transversely isotropic frame and pores (Biot 6x6)"
    examples: ClassVar[tuple[Mapping[str, Any], ...]] = ({"thickness": 0.04, "frame_density": 40.0, **_FOAM, **_PORES},)

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices, from the field equations."""
        return slab_faces(wave, self.thickness, self.field_equations(wave))

    def field_equations(self, wave: Wave) -> FieldEquations:
        """Return Biot's equations of plane strain, the fluid's velocity along the layer eliminated."""
        x, y = _poroelastic(wave, self.stiffness(wave), *(self._pores(wave, layer) for layer in (self.inplane, self)))
        return FieldEquations(POROELASTIC, x, y, self.porosity)

    @property
    def inplane(self) -> Self:
        """The same material with the pores that the fluid meets on its way along the layer."""
        return self.model_copy(update=dict(self._inplane_fields()))

    def _inplane_fields(self) -> Iterator[tuple[str, Any]]:
        for field in ("flow_resistivity", "tortuosity", "viscous_length"):
            value = getattr(self, f"{field}_inplane")
            if value is not None:
                yield field, value

    def _pores(self, wave: Wave, layer: Self) -> _Pores:
        density, bulk = layer.pore_fluid(wave)
        # the frame's moduli do not matter for what is taken from it
        medium = biot_medium(1.0, 0.0, self.frame_density, self.porosity, density, bulk, wave.ambient.density)
        return _Pores(medium.rho11, medium.rho12, medium.rho22, medium.Q, medium.R)


@dataclass(frozen=True)
class _Pores:
    """Biot's densities along one axis, kg/m3, and the coefficients of the fluid, Pa."""

    rho11: Numeric
    rho12: Numeric
    rho22: Numeric
    Q: Numeric
    R: Numeric


def _poroelastic(wave: Wave, c: Stiffness, along: _Pores, through: _Pores) -> tuple[Entries, Entries]:
    """Return X and Y; Biot 1962 with a drained frame that is anisotropic, the densities of each axis its own."""
    w, kx = wave.omega, wave.kx
    ratio, plane = c.C13 / c.C33, c.C11 - c.C13**2 / c.C33
    pressed, slip = through.Q / through.R, along.rho12 / along.rho22
    x: Entries = [
        [1j * kx, 0, 1j * w / c.C44],
        [1j * w * through.rho11, 1j * w * through.rho12, 1j * kx],
        [1j * w * through.rho12, 1j * w * through.rho22, 0],
    ]
    # d(v3s)/dx3 as a row over (v1s, s33s, s33f), and the frame's dilatation by it
    stretch = [1j * kx * ratio, 1j * w / c.C33, -1j * w * pressed / c.C33]
    dilatation = [stretch[0] - 1j * kx, stretch[1], stretch[2]]
    y: Entries = [
        stretch,
        [
            -pressed * dilatation[0] - 1j * kx * slip,
            -pressed * dilatation[1],
            -pressed * dilatation[2] + 1j * w / through.R - 1j * kx**2 / (w * along.rho22),
        ],
        [
            1j * w * (along.rho11 - along.rho12 * slip) - 1j * kx**2 * plane / w,
            1j * kx * ratio,
            1j * kx * (pressed * (1 - ratio) - slip),
        ],
    ]
    return x, y
