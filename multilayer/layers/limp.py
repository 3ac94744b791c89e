"""A porous material whose frame has mass but no stiffness."""

from __future__ import annotations

from typing import ClassVar, Literal

from multilayer.layers.fluid import fluid_faces
from multilayer.layers.pores import AnyPoreLayer
from multilayer.matrix.faces import Faces
from multilayer.matrix.wave import Wave
from multilayer.media.pore_models import PoreModelName
from multilayer.media.porous import limp_density
from multilayer.units import Density


class Limp(AnyPoreLayer):
    """Pores in a frame that the gas drags along: soft fibrous blankets.

    Fields: those of `equivalent_fluid` for the same `model`, always `porosity`, and `frame_density` (kg/m3, of the
    frame per volume of material). State (p, v3). Holds while the frame's own stiffness is small beside that of the air
    in it, and not where the frame is bonded to something that holds or drives it.
    """

    type: Literal["limp"] = "limp"
    model: PoreModelName = "jca"
    frame_density: Density

    summary: ClassVar[str] = "porous material with a frame of mass and no stiffness (Panneton)"
    always: ClassVar[tuple[str, ...]] = ("porosity",)

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices; Panneton 2007, see `media.porous.limp_density`."""
        density, bulk = self.pore_fluid(wave)
        assert self.porosity is not None  # validated
        limp = limp_density(density, self.porosity, self.frame_density, wave.ambient)
        return fluid_faces(wave, self.thickness, limp, bulk)
