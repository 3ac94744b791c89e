"""The sample and the plates of a virtual rig, as its file describes them."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ArrayLike, ComplexArray
from multilayer.media.laws import Modulus, ModulusLaw, Table
from multilayer.models import Model
from multilayer.units import (
    DIMENSIONLESS,
    Density,
    FlowResistivity,
    Length,
    PoissonRatio,
    Porosity,
    PositiveRatio,
    Pressure,
    Tortuosity,
    UnitLabel,
)

Factors = Annotated[tuple[PositiveRatio, ...], Field(min_length=2), UnitLabel(DIMENSIONLESS)]


class SkinSettings(Model):
    """Layers of the sample near both faces: `thickness` (m), and their modulus over that of the core, `ratio`."""

    thickness: Length
    ratio: PositiveRatio


class SpecimenSettings(Model):
    """True properties of the sample.

    Only `density` reaches every campaign and every signal. The other fields beside the modulus act when the effect
    that takes them is listed: `poisson_ratio` with ``finite_size``, the fields of the pores (`porosity`,
    `flow_resistivity` N s/m4, `tortuosity`, `viscous_length`, `thermal_length` m, `pore_rim`) with
    ``saturating_air``, `skin` with ``skin``, `grading` (factors on the modulus, evenly spaced from base to top) with
    ``grading``, `transverse_ratio` (E_r/E_z) with ``anisotropy``.
    """

    density: Density
    poisson_ratio: PoissonRatio = 0.0
    young_modulus: Modulus
    porosity: Porosity | None = None
    flow_resistivity: FlowResistivity | None = None
    tortuosity: Tortuosity | None = None
    viscous_length: Length | None = None
    thermal_length: Length | None = None
    pore_rim: Literal["open", "sealed"] | None = None
    skin: SkinSettings | None = None
    grading: Factors | None = None
    transverse_ratio: PositiveRatio | None = None

    def modulus(self, frequency: ArrayLike) -> ComplexArray:
        """Return E1 + i E2 of the material, Pa, at `frequency`, Hz.

        A table is held constant beyond its ends: the spectrum of a burst reaches further than its stated frequency.
        """
        f, law = np.asarray(frequency, dtype=float), self.young_modulus
        if isinstance(law, Table):
            return law(np.clip(f, law.frequency[0], law.frequency[-1]))
        return law(f) if isinstance(law, ModulusLaw) else np.full(f.shape, law, dtype=complex)


class TopPlateSettings(Model):
    """Material of the top plate, steel when left out; density in kg/m3, modulus in Pa."""

    density: Density = 7850.0
    young_modulus: Pressure = 2.1e11
    poisson_ratio: PoissonRatio = 0.3


class BasePlateSettings(Model):
    """Material and thickness (m) of the base plate, 10 mm of aluminium when left out.

    The campaign states it in any case. It deforms only with `elastic`; its lower face is what the shaker moves.
    """

    density: Density = 2700.0
    young_modulus: Pressure = 7.0e10
    poisson_ratio: PoissonRatio = 0.33
    thickness: Length = 0.010
    elastic: bool = False
