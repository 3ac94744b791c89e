"""A thin plate in bending."""

from __future__ import annotations

from typing import ClassVar, Literal

from multilayer.arrays import Numeric
from multilayer.layers.base import ElasticLayer
from multilayer.matrix.faces import Faces, sheet_faces
from multilayer.matrix.wave import Wave
from multilayer.media.elastic import flexural_rigidity
from multilayer.media.validity import warn_thick_plate
from multilayer.units import Density, Length

_TITLE = "elastic_plate (elastic_solid beyond)"


class ElasticPlate(ElasticLayer):
    """A thin (Kirchhoff) plate: a mass with bending stiffness and no thickness of its own in the kinematics.

    Fields: `thickness` (m), `density` (kg/m3), `young_modulus` (Pa), `poisson_ratio`, `loss_factor`. State (p, v3): a
    solid neighbour slips on it; a poroelastic one meets it across a thin film of air, or with a contact `slip` carries
    it on its frame; glued to that, use `elastic_solid`. Holds while bending waves are longer than six thicknesses
    (`ValidityWarning` beyond, of oblique waves that bend it); use `elastic_solid` there.
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
        mass = self.density * self.thickness
        warn_thick_plate(_TITLE, self.thickness, stiffness, mass, wave.kx, wave.omega)
        return bending_faces(wave, stiffness, mass)


def bending_faces(wave: Wave, stiffness: Numeric, surface_density: Numeric) -> Faces:
    """Return the face matrices of a thin plate: p(front) - p(back) = (i w m + D kx^4 / (i w)) v3.

    Parameters
    ----------
    wave : Wave
    stiffness : complex or array
        D in the plane of incidence, N m.
    surface_density : float or array
        m, kg/m2.
    """
    return sheet_faces(wave, 1j * wave.omega * surface_density + stiffness * wave.kx**4 / (1j * wave.omega))
