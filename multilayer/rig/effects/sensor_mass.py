"""An accelerometer that loads the top plate."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from multilayer.rig.effect_base import Effect, Geometry, Mistake, Mounting, Size, Surroundings
from multilayer.rig.specimen import SpecimenSettings
from multilayer.units import NonNegative, Unit


class SensorMass(Effect):
    """The accelerometer loads the top plate with `mass`, kg, its centre `radius`, m, from the axis.

    It reads where it sits. Without ``plate_flexure`` the plate is rigid and only the mass counts. Perturbed: the
    accelerometer is moved out by abs(p) times the way to the rim, on a plate of its real stiffness.
    """

    effect: Literal["sensor_mass"] = "sensor_mass"
    mass: Annotated[float, Field(ge=0, le=0.1), Unit("kg")] = 1e-3
    radius: Annotated[float, NonNegative, Unit("m")] = 0.0
    footprint: Annotated[float, Field(gt=0, le=0.05), Unit("m")] = 3e-3

    drawn = Size("mass", 5e-5, 5e-3, parameter="mass")

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        plate = around.slimmest
        if self.footprint >= plate:
            text = (
                f"a footprint of {1e3 * self.footprint:g} mm is not allowed: the plate's radius is {1e3 * plate:g} mm"
            )
            yield ("footprint",), text, self.footprint
        elif self.radius + self.footprint > plate * (1 + 1e-9):
            text = (
                f"{1e3 * self.radius:g} mm puts the accelerometer off the plate of radius {1e3 * plate:g} mm; with its "
                f"footprint of {1e3 * self.footprint:g} mm it must be at most {1e3 * (plate - self.footprint):g} mm"
            )
            yield ("radius",), text, self.radius

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        moved = self.radius + abs(self.perturbation) * (mounting.radius - self.footprint - self.radius)
        stiff = {"plate_modulus": geometry["real_plate_modulus"]} if self.perturbation else {}
        sensor = {"sensor_mass": self.mass, "sensor_radius": moved, "sensor_footprint": self.footprint}
        return {**geometry, **sensor, **stiff}
