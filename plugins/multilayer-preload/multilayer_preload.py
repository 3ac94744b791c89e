"""The layer type `preloaded_solid`: a solid that stiffens under the weight of what lies on it."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field
from scipy.constants import g as GRAVITY  # noqa: N812

from multilayer.arrays import Numeric
from multilayer.errors import InputError, ValidityWarning
from multilayer.layers import Layer
from multilayer.layers.elastic_solid import ElasticSolid
from multilayer.layers.fluid import Fluid
from multilayer.layers.viscothermal_fluid import ViscothermalFluid
from multilayer.matrix.wave import Wave
from multilayer.units import Unit

PerPascal = Annotated[float, Unit("1/Pa")]
StaticStress = Annotated[float, Field(ge=0), Unit("Pa")]


class PreloadedSolid(ElasticSolid):
    """A viscoelastic solid whose modulus depends on its static stress s, ``E1 (1 + b s)`` and ``E2/E1 (1 + d s)``.

    Fields: those of `elastic_solid`, its modulus without any load; `stiffening` b and `damping` d (1/Pa), slopes as
    `multilayer preload` finds them. The stress is the weight of the layers that lie on this one, in a horizontal stack
    that stands on its termination, or on the shaken base: those towards the sound, or away from the base. Nothing
    beyond a gap of fluid lies on it. `static_stress` (Pa) takes the place of that weight. The layer's own weight is
    left out, as in the fits.

    Raises `InputError` where a modulus would not stay above 0: the line is extrapolated too far.
    """

    type: Literal["preloaded_solid"] = "preloaded_solid"  # type: ignore[assignment]
    stiffening: PerPascal
    damping: PerPascal = 0.0
    static_stress: StaticStress | None = None

    summary: ClassVar[str] = "elastic or viscoelastic solid that stiffens under the weight of what lies on it"
    examples: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"thickness": 0.025, "density": 60.0, "young_modulus": 2e5 + 6e4j, "poisson_ratio": 0.1, "stiffening": 5e-4},
    )
    composes: ClassVar[bool] = False  # its upper part lies on its lower one

    def under(self, above: Sequence[Layer]) -> Layer:
        """Return the layer with the static stress of the layers above, the nearest first."""
        if self.static_stress is not None:
            return self
        return self.model_copy(update={"static_stress": static_stress(above)})

    def sliced(self, n: int) -> tuple[Layer, ...]:
        """Return slices of the same stress."""
        return (self.model_copy(update={"thickness": self.thickness / n}),) * n

    def complex_modulus(self, wave: Wave) -> Numeric:
        """Return E1 + i E2, Pa, under the static stress."""
        stress: Any = 0.0 if self.static_stress is None else self.static_stress
        stiffer, lossier = 1 + self.stiffening * stress, 1 + self.damping * stress
        if not (np.all(stiffer > 0) and np.all(lossier >= 0)):
            slopes = f"stiffening {self.stiffening:g}/Pa, damping {self.damping:g}/Pa"
            raise InputError(f"layer {self.name or self.type}: no modulus is left at {np.max(stress):g} Pa ({slopes})")
        unloaded = np.asarray(super().complex_modulus(wave), dtype=complex)
        return np.asarray(stiffer * (unloaded.real + 1j * lossier * unloaded.imag))


def static_stress(above: Sequence[Layer]) -> Numeric:
    """Return the weight per area, Pa, of layers that lie on a surface, the nearest first, up to a gap of fluid.

    Warns (`ValidityWarning`) of a layer whose mass its fields do not tell; it counts as weightless.
    """
    mass: Any = 0.0
    for layer in above:
        if isinstance(layer, Fluid | ViscothermalFluid):
            break
        mass = mass + _mass_per_area(layer)
    weight: Numeric = GRAVITY * mass
    return weight


def _mass_per_area(layer: Layer) -> Any:
    fields: dict[str, Any] = dict(layer)
    density = fields.get("density", fields.get("frame_density"))
    if fields.get("surface_density") is not None:
        return fields["surface_density"]
    if density is None or fields.get("thickness") is None:
        text = f"the mass of layer {layer.name or layer.type} is not known: its weight is left out of the static stress"
        warnings.warn(text, ValidityWarning, stacklevel=2)
        return 0.0
    return density * fields["thickness"]
