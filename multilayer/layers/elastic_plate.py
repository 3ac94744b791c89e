"""A thin plate in bending."""

from __future__ import annotations

from typing import ClassVar, Literal

from multilayer.layers.base import ElasticLayer
from multilayer.matrix.faces import Faces, sheet_faces
from multilayer.matrix.wave import Wave
from multilayer.media.elastic import flexural_rigidity
from multilayer.units import Density, Length


class ElasticPlate(ElasticLayer):
    """A thin (Kirchhoff) plate: a mass with bending stiffness and no thickness of its own in the kinematics.

    Fields: `thickness` (m), `density` (kg/m3), `young_modulus` (Pa), `poisson_ratio`, `loss_factor`. State (p, v3): a
    solid neighbour slips on it; a poroelastic one meets it across a thin film of air, or with a contact `slip` carries
    it on its frame; glued to that, use `elastic_solid`. Holds while bending waves are longer than about six
    thicknesses; use `elastic_solid` beyond.
    """

    type: Literal["elastic_plate"] = "elastic_plate"
    thickness: Length
    density: Density

    summary: ClassVar[str] = "thin plate in bending (Kirchhoff), solids slip on it"
    lies_on_frames: ClassVar[bool] = True
    composes: ClassVar[bool] = False  # two plates bend more easily than one of their joint thickness

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices; Allard & Atalla 2009, section 11.3.5: p(front) - p(back) = Z v3."""
        stiffness = flexural_rigidity(self.complex_modulus(wave), self.poisson_ratio, self.thickness)
        mass = 1j * wave.omega * self.density * self.thickness
        impedance = mass + stiffness * wave.kx**4 / (1j * wave.omega)
        return sheet_faces(wave, impedance)
