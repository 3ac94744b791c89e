"""Effects of the mechanical rig: plates, glue, accelerometer, paths around the sample."""
# ruff: noqa: D102 -- the hooks are documented once, on the base class

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ArrayLike, ComplexArray
from multilayer.errors import suggest
from multilayer.rig.effect_base import Effect, Geometry, Mistake, Mounting, Surroundings, power_law
from multilayer.rig.specimen import SpecimenSettings
from multilayer.units import DIMENSIONLESS, NonNegative, Unit

_RIGID_ABOVE = 50e3  # Hz: where a plate that is to be rigid bends first; ten times that of 1 mm of steel
_USUAL_THICKNESS = 25e-3  # m


def rigid_modulus(radius: float, thickness: float, density: float, modulus: float, poisson_ratio: float) -> float:
    """Return the modulus, Pa, of a top plate that is to be rigid: its own, or more.

    The first mode of a free disc, ``9.08 / (2 pi R^2) sqrt(D / (rho h))``, comes to lie at 50 kHz. Much stiffer plates
    would cost the finite elements their digits; so the transmissibility of a rod is met to 4e-5.

    Parameters
    ----------
    radius, thickness, density, modulus, poisson_ratio : float
        Of the plate, SI.
    """
    bending = density * thickness * (2 * np.pi * radius**2 * _RIGID_ABOVE / 9.08) ** 2
    return float(max(modulus, 12 * (1 - poisson_ratio**2) / thickness**3 * bending))


class SensorMass(Effect):
    """The accelerometer loads the top plate with `mass`, kg, its centre `radius`, m, from the axis.

    It reads where it sits. Without ``plate_flexure`` the plate is rigid and only the mass counts. Perturbed: the
    accelerometer is moved out by abs(p) times the way to the rim, on a plate of its real stiffness.
    """

    effect: Literal["sensor_mass"] = "sensor_mass"
    mass: Annotated[float, Field(ge=0, le=0.1), Unit("kg")] = 1e-3
    radius: Annotated[float, NonNegative, Unit("m")] = 0.0
    footprint: Annotated[float, Field(gt=0, le=0.05), Unit("m")] = 3e-3

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


@dataclass(frozen=True)
class GlueModulus:
    """E (1 + i eta) (i f / 500 Hz)^exponent, Pa, at `frequency`, Hz; a class, so that it can go to another process."""

    young_modulus: float
    loss_factor: float
    exponent: float

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        """Return the modulus."""
        growth = power_law(np.asarray(frequency, dtype=float), self.exponent)
        return np.asarray(self.young_modulus * (1 + 1j * self.loss_factor) * growth)


class Adhesive(Effect):
    """A layer of glue of `thickness`, m, at each face of the sample, of modulus E (1 + i eta), Pa.

    Perturbed: E (1 + i eta) (i f / 500 Hz)^abs(p), a glue that stiffens with frequency.
    """

    effect: Literal["adhesive"] = "adhesive"
    thickness: Annotated[float, Field(gt=0, le=0.01), Unit("m")] = 0.2e-3
    young_modulus: Annotated[float, Field(ge=1e3, le=1e11), Unit("Pa")] = 2e5
    loss_factor: Annotated[float, Field(ge=0, le=2), Unit(DIMENSIONLESS)] = 0.3
    density: Annotated[float, Field(ge=1, le=1e4), Unit("kg/m^3")] = 1000.0
    poisson_ratio: Annotated[float, Field(ge=0, lt=0.5), Unit(DIMENSIONLESS)] = 0.0

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        if 2 * self.thickness >= around.thinnest:
            text = (
                f"{1e3 * self.thickness:g} mm of glue at both faces are not thinner than the thinnest sample, "
                f"{1e3 * around.thinnest:g} mm; give the thickness of one layer, below {500 * around.thinnest:g} mm"
            )
            yield ("thickness",), text, self.thickness

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        glue = GlueModulus(self.young_modulus, self.loss_factor, abs(self.perturbation))
        return {
            **geometry,
            "adhesive_thickness": self.thickness,
            "adhesive_modulus": glue,
            "adhesive_density": self.density,
            "adhesive_poisson_ratio": self.poisson_ratio,
        }


class PlateFlexure(Effect):
    """The top plate bends; without this effect it is stiffened, see `rigid_modulus`.

    Its first mode as a free disc is at ``9.08 / (2 pi R^2) sqrt(D / (rho h))``. The motion is read at `radius`, m, or
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


class Delamination(Effect):
    """Only a share of each face, about the axis, is bonded; in the named configurations, or in all.

    Perturbed: the open share 1 - b is (1 + p) times as large in the first of them, (1 - p) times in the last.
    """

    effect: Literal["delamination"] = "delamination"
    bonded_fraction: Annotated[float, Field(gt=0.1, le=1), Unit(DIMENSIONLESS)] = 0.85
    configurations: tuple[str, ...] | None = None

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        names = [mounting.name for mounting in around.mountings]
        for i, name in enumerate(self.configurations or ()):
            if name not in names:
                yield ("configurations", i), f"there is no configuration '{name}'; {suggest(name, names)}", name

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        if self.configurations is not None and mounting.name not in self.configurations:
            return geometry
        place = 2 * mounting.index / max(mounting.count - 1, 1) - 1
        open_share = (1 - self.bonded_fraction) * (1 - self.perturbation * place)
        return {**geometry, "bonded_fraction": max(1 - open_share, 0.05)}


class Flanking(Effect):
    """A path beside the sample, from the base to the rim of the top plate: k (1 + i eta), k in N/m.

    Perturbed: k (h / 25 mm)^(-p), a skirt that is stretched with the sample's thickness h for p = 1.
    """

    effect: Literal["flanking"] = "flanking"
    stiffness: Annotated[float, Field(ge=0, le=1e9), Unit("N/m")] = 500.0
    loss_factor: Annotated[float, Field(ge=0, le=2), Unit(DIMENSIONLESS)] = 0.1

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        scale = (mounting.thickness / _USUAL_THICKNESS) ** -self.perturbation
        return {**geometry, "flanking_stiffness": self.stiffness * scale * (1 + 1j * self.loss_factor)}
