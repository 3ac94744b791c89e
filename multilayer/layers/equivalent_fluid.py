"""A porous material whose frame does not move."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from multilayer.layers.fluid import fluid_equations, fluid_faces
from multilayer.layers.pores import AnyPoreLayer
from multilayer.matrix.equations import FieldEquations
from multilayer.matrix.faces import Faces
from multilayer.matrix.wave import Wave
from multilayer.media.pore_models import RigidPoreModelName
from multilayer.units import DIMENSIONLESS, Length, Unit

OpenArea = Annotated[float, Field(gt=0, lt=1), Unit(DIMENSIONLESS)]


class EquivalentFluid(AnyPoreLayer):
    """Pores in a rigid, motionless frame, filled with the ambient gas: a fluid with losses.

    Fields: `thickness` (m), `model`, and what the model takes. State (p, v3). Warns (`ValidityWarning`) outside the
    range of a model.

    ===================== ==============================================================================================
    `delany_bazley`       flow_resistivity (N s/m4)
    `miki`                flow_resistivity
    `jca`                 porosity, flow_resistivity, tortuosity, viscous_length, thermal_length (m)
    `jcal`                those of `jca` and thermal_permeability (m2)
    `jcapl`               those of `jcal` and static_viscous_tortuosity, static_thermal_tortuosity
    `wilson`              porosity, tortuosity, and flow_resistivity or vorticity_time, entropy_time (s)
    `horoshenkov_swift`   porosity, median_pore_size (m), pore_size_deviation (of its logarithm to base 2)
    `fibres`              porosity, fibre_diameter (m); fibre_orientation (0 in the plane of the layer, 1/3 random)
    `open_cells`          porosity, cell_size (m)
    `grains`              porosity, grain_diameter (m)
    `double_porosity`     those of `jca` of the material between holes, perforation, hole_radius or slit_width (m)
    ===================== ==============================================================================================
    """

    type: Literal["equivalent_fluid"] = "equivalent_fluid"
    model: RigidPoreModelName = "jca"
    perforation: OpenArea | None = None
    hole_radius: Length | None = None
    slit_width: Length | None = None

    summary: ClassVar[str] = "porous material with a rigid frame, by one of many pore models"
    stands_still: ClassVar[bool] = True

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices; Allard & Atalla 2009, sections 5.4, 5.5 and 11.3.1."""
        return fluid_faces(wave, self.thickness, *self.pore_fluid(wave))

    def field_equations(self, wave: Wave) -> FieldEquations:
        """Return the field equations."""
        return fluid_equations(wave, *self.pore_fluid(wave))
