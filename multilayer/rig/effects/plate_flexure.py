"""A top plate that bends."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from multilayer.rig.effect_base import Effect, Geometry, Mistake, Mounting, Surroundings
from multilayer.rig.specimen import SpecimenSettings
from multilayer.units import NonNegative, Unit


class PlateFlexure(Effect):
    """The top plate bends; without this effect it is stiffened, see `rigid_modulus`.

    Its first mode as a free disc is at ``9.003 / (2 pi R^2) sqrt(D / (rho h))``. The motion is read at `radius`, m, or
    where the accelerometer sits. Perturbed: its modulus is (1 + p) times the stated one.
    """

    effect: Literal["plate_flexure"] = "plate_flexure"
    radius: Annotated[float, NonNegative, Unit("m")] | None = None

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        if self.radius is not None and self.radius > around.slimmest:
            text = f"{1e3 * self.radius:g} mm is off the plate, whose radius is {1e3 * around.slimmest:g} mm"
            yield ("radius",), text, self.radius

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        read = {} if self.radius is None else {"reading_radius": self.radius}
        return {**geometry, **read, "plate_modulus": geometry["real_plate_modulus"] * (1 + self.perturbation)}
