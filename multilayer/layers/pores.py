"""Fields of the fluid in the pores, shared by the layers that have some."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Annotated, Any, ClassVar, Self, get_args

from pydantic import Field, model_validator

from multilayer.arrays import ComplexArray
from multilayer.layers.field_sets import FieldSets
from multilayer.matrix.wave import Wave
from multilayer.media.pore_models import PORE_MODELS
from multilayer.units import (
    DIMENSIONLESS,
    Area,
    Duration,
    FlowResistivity,
    Length,
    Porosity,
    Ratio,
    Tortuosity,
    Unit,
)

_ROUNDING = 1.001  # of two lengths that are meant to be the same
StaticTortuosity = Annotated[float, Field(gt=1), Unit(DIMENSIONLESS)]

Orientation = Annotated[float, Field(ge=0, le=1), Unit(DIMENSIONLESS)]


class PoreLayer(FieldSets):
    """A slab with pores; the field `model` says which of the others it takes (see `media.pore_models`).

    A subclass narrows `model` to a `Literal`. Fields: `thickness` (m), `model`, `porosity`, `flow_resistivity` (N
    s/m4), `tortuosity`, `viscous_length`, `thermal_length` (m), `thermal_permeability` (m2),
    `static_viscous_tortuosity`, `static_thermal_tortuosity`.
    """

    thickness: Length
    model: str = "jca"
    porosity: Porosity | None = None
    flow_resistivity: FlowResistivity | None = None
    tortuosity: Tortuosity | None = None
    viscous_length: Length | None = None
    thermal_length: Length | None = None
    thermal_permeability: Area | None = None
    static_viscous_tortuosity: StaticTortuosity | None = None
    static_thermal_tortuosity: StaticTortuosity | None = None

    chooser: ClassVar[str] = "model"
    always: ClassVar[tuple[str, ...]] = ()  # fields that the layer itself needs, whatever the model

    @classmethod
    def field_sets(cls, data: Mapping[str, Any]) -> tuple[str, tuple[tuple[str, ...], ...]]:
        """Return the sets of fields of the model that `data` names."""
        choice = cls.model_fields["model"]
        name = data.get("model", choice.default)
        sets = PORE_MODELS[name].field_sets if name in get_args(choice.annotation) else ()
        return f"model '{name}'", tuple(tuple(dict.fromkeys((*cls.always, *fields))) for fields in sets)

    @classmethod
    def governed_fields(cls) -> frozenset[str]:
        """Return every field that some model takes, those excepted that all models of this layer take."""
        return _governed(cls)

    @model_validator(mode="after")
    def _static_above_dynamic(self) -> Self:
        static, dynamic = self.static_viscous_tortuosity, self.tortuosity
        if static is not None and dynamic is not None and static <= dynamic:
            raise ValueError("static_viscous_tortuosity must be above tortuosity, its limit at high frequencies")
        return self

    def implausible(self) -> Iterator[tuple[str, str]]:
        """Give field and text of values that are allowed, and hardly ever meant."""
        yield from super().implausible()
        viscous, thermal = self.viscous_length, self.thermal_length
        if isinstance(viscous, float) and isinstance(thermal, float) and viscous > _ROUNDING * thermal:
            text = (
                f"{1e6 * viscous:g} um is above thermal_length, {1e6 * thermal:g} um, which no pores have: exchanged?"
            )
            yield "viscous_length", text

    def pore_fluid(self, wave: Wave) -> tuple[ComplexArray, ComplexArray]:
        """Return effective density, kg/m3, and bulk modulus, Pa, of the ambient gas in the pores of a rigid frame.

        Per unit volume of material. Warns (`ValidityWarning`) where the model does not hold.
        """
        return PORE_MODELS[self.model].fluid(wave.omega, wave.ambient, dict(self))


class StructuredPoreLayer(PoreLayer):
    """A slab with pores that may be given by what is around them (see `media.structures`).

    Further fields: `fibre_diameter` (m), `fibre_orientation` (mean squared cosine to the normal), `cell_size`,
    `grain_diameter` (m).
    """

    fibre_diameter: Length | None = None
    fibre_orientation: Orientation | None = None
    cell_size: Length | None = None
    grain_diameter: Length | None = None


class AnyPoreLayer(StructuredPoreLayer):
    """A slab with pores by any of the models.

    Further fields: `vorticity_time`, `entropy_time` (s), `median_pore_size` (m), `pore_size_deviation`.
    """

    vorticity_time: Duration | None = None
    entropy_time: Duration | None = None
    median_pore_size: Length | None = None
    pore_size_deviation: Ratio | None = None


@cache  # asked for at every draw of a tolerance
def _governed(layer: type[PoreLayer]) -> frozenset[str]:
    some = {name for model in PORE_MODELS.values() for fields in model.field_sets for name in fields}
    return frozenset(name for name in some & set(layer.model_fields) if not layer.model_fields[name].is_required())
