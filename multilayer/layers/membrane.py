"""An impervious membrane, film or septum."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from multilayer.layers.base import Layer
from multilayer.matrix.faces import Faces, sheet_faces
from multilayer.matrix.wave import Wave
from multilayer.units import NonNegative, Positive, Ratio, Unit

SurfaceDensity = Annotated[float, Positive, Unit("kg/m^2")]
Tension = Annotated[float, NonNegative, Unit("N/m")]


class Membrane(Layer):
    """An impervious sheet without bending stiffness; without tension, a septum or heavy layer.

    Fields: `surface_density` (kg/m2), `tension` (N/m, isotropic), `loss_factor` (of the tension). State (p, v3): a
    solid neighbour slips on it; a poroelastic one meets it across a thin film of air, or with a contact `slip` carries
    it on its frame; glued to that, use `elastic_solid`. Bending stiffness is left out: use `elastic_plate`
    where it counts.
    """

    type: Literal["membrane"] = "membrane"
    surface_density: SurfaceDensity
    tension: Tension = 0.0
    loss_factor: Ratio = 0.0

    summary: ClassVar[str] = "impervious film or septum: mass and tension, no bending stiffness"
    lies_on_frames: ClassVar[bool] = True

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices: p(front) - p(back) = (i w m + T kx^2 / (i w)) v3; Allard & Atalla 2009, 11.3.6."""
        stiffness = self.tension * (1 + 1j * self.loss_factor) * wave.kx**2
        impedance = 1j * wave.omega * self.surface_density + stiffness / (1j * wave.omega)
        return sheet_faces(wave, impedance)
