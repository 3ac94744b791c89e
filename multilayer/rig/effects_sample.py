"""Effects of the sample itself: its rim, its pores, its skin, and a modulus that is not the same everywhere."""
# ruff: noqa: D102 -- the hooks are documented once, on the base class

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from multilayer.arrays import ComplexArray, RealArray
from multilayer.media.gas import dry_air
from multilayer.media.pumped_air import cylindrical_length
from multilayer.models import refuse
from multilayer.rig.effect_base import GRAVITY, Effect, Geometry, Mistake, Moment, Mounting, Surroundings, power_law
from multilayer.rig.specimen import SkinSettings, SpecimenSettings
from multilayer.units import DIMENSIONLESS, FlowResistivity, Length, Porosity, Tortuosity, Unit

_USUAL_STRESS = 100.0  # Pa, below a steel plate of 1.3 mm


class FiniteSize(Effect):
    """The sample has its true Poisson's ratio, and a free rim: it bulges.

    Without this effect it has the ratio 0, in the finite elements and in ``campaign.yaml``, and is a rod. It presses
    unevenly against the top plate, which therefore has its true stiffness. Perturbed: its modulus along the radius is
    (1 + p) times that along the axis.
    """

    effect: Literal["finite_size"] = "finite_size"

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        if around.specimen.poisson_ratio == 0:
            yield (), "finite_size needs a specimen.poisson_ratio other than 0; give it, or remove the effect", None

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        ratio = geometry.get("transverse_ratio", 1.0) * (1 + self.perturbation)
        uneven = {"poisson_ratio": specimen.poisson_ratio, "plate_modulus": geometry["real_plate_modulus"]}
        return {**geometry, **uneven, "transverse_ratio": ratio}


class Preload(Effect):
    """What lies on the sample stiffens it: E (1 + b s), s the weight of plate and accelerometer over the area, Pa.

    The loss factor is kept. Perturbed: b s (s / 100 Pa)^p.
    """

    effect: Literal["preload"] = "preload"
    stiffening: Annotated[float, Field(ge=-1e-3, le=0.05), Unit("1/Pa")] = 5e-4

    def apply_to_modulus(self, frequency: RealArray, modulus: ComplexArray, moment: Moment) -> ComplexArray:
        stress = static_stress(moment.geometry)
        return np.asarray(modulus * (1 + self.stiffening * stress * (stress / _USUAL_STRESS) ** self.perturbation))


def static_stress(geometry: Geometry) -> float:
    """Return the weight of top plate and accelerometer over the area of the sample, Pa."""
    plate = geometry["plate_density"] * geometry["plate_thickness"]
    return float(GRAVITY * (plate + geometry.get("sensor_mass", 0.0) / (np.pi * geometry["radius"] ** 2)))


class SaturatingAir(Effect):
    """Air in the pores, sealed by the plates and open at the rim: Biot's equations, pores after Johnson and Champoux.

    Each field left out is that of the specimen, or else porosity 0.97, 20 kN s/m4, tortuosity 1 and the lengths of
    cylindrical pores, ``sqrt(8 eta tortuosity / (porosity resistivity))`` and twice that (Allard & Atalla 2009, chapter
    5). Perturbed: both lengths are 1/(1 + p) of that, pores of another section.
    """

    effect: Literal["saturating_air"] = "saturating_air"
    porosity: Porosity | None = None
    flow_resistivity: FlowResistivity | None = None
    tortuosity: Tortuosity | None = None
    viscous_length: Length | None = None
    thermal_length: Length | None = None
    pore_rim: Literal["open", "sealed"] | None = None

    def parameters(self, specimen: SpecimenSettings) -> dict[str, Any]:
        pores: dict[str, Any] = {"porosity": 0.97, "flow_resistivity": 2e4, "tortuosity": 1.0, "pore_rim": "open"}
        for source in (specimen, self):
            given = {name: getattr(source, name) for name in (*pores, "viscous_length", "thermal_length")}
            pores |= {name: value for name, value in given.items() if value is not None}
        tube = cylindrical_length(pores["porosity"], pores["flow_resistivity"], pores["tortuosity"], dry_air())
        viscous = pores.get("viscous_length", tube)
        lengths = {
            "viscous_length": viscous,
            "thermal_length": pores.get("thermal_length", max(2 * tube, viscous)),
        }
        return {**pores, **{name: length / (1 + self.perturbation) for name, length in lengths.items()}}

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        return {**geometry, **self.parameters(specimen)}


class Dispersion(Effect):
    """The modulus varies within the band of a burst more than the nominal law says: no change of the data.

    It names what a law such as ``fractional_zener`` does to a model of constant modulus. Perturbed: E (i f / 500 Hz)^p,
    p at most a tenth of what is written.
    """

    effect: Literal["dispersion"] = "dispersion"

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        f = np.array([frequency for mounting in around.mountings for frequency in mounting.frequencies])
        size = np.abs(around.specimen.modulus(np.array([f.min() / 2, f.max()])))
        if self.perturbation == 0 and size[1] < 1.01 * size[0]:
            text = "dispersion needs a young_modulus that varies with frequency, such as {law: fractional_zener, ...}"
            yield (), text, None

    def apply_to_modulus(self, frequency: RealArray, modulus: ComplexArray, moment: Moment) -> ComplexArray:
        return np.asarray(modulus * power_law(frequency, 0.1 * abs(self.perturbation)))


@dataclass(frozen=True)
class SoftEdge:
    """Factor on the modulus over z/h: `ratio` at the faces, 1 in the core, the edge as wide as `width` times `depth`.

    Lengths over the sample's thickness.
    """

    depth: float
    ratio: float
    width: float

    def __call__(self, height: RealArray) -> RealArray:
        """Return the factor at z/h."""
        inside = np.minimum(height, 1 - height) - self.depth
        return np.asarray(1 + (self.ratio - 1) * 0.5 * (1 - np.tanh(2 * inside / (self.width * self.depth))))


class Skin(Effect):
    """Layers of `thickness`, m, at both faces of the sample whose modulus is `ratio` times that of the core.

    Fields left out are those of ``specimen.skin``. Perturbed: the step of the modulus is a smooth edge, 2 abs(p) times
    as wide as the skin.
    """

    effect: Literal["skin"] = "skin"
    thickness: Annotated[float, Field(gt=0, le=0.1), Unit("m")] | None = None
    ratio: Annotated[float, Field(gt=0, le=1000), Unit(DIMENSIONLESS)] | None = None

    def _skin(self, specimen: SpecimenSettings) -> SkinSettings:
        own = specimen.skin or SkinSettings(thickness=1e-3, ratio=3.0)
        return SkinSettings(thickness=self.thickness or own.thickness, ratio=self.ratio or own.ratio)

    def parameters(self, specimen: SpecimenSettings) -> dict[str, Any]:
        return self._skin(specimen).model_dump()

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        skin = self._skin(around.specimen).thickness
        if 2 * skin >= around.thinnest:
            text = f"{1e3 * skin:g} mm of skin at both faces leave no core in {1e3 * around.thinnest:g} mm"
            yield ("thickness",), f"{text}; make it thinner", skin

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        skin = self._skin(specimen)
        if not self.perturbation:
            return {**geometry, "skin_thickness": skin.thickness, "skin_ratio": skin.ratio}
        depth = skin.thickness / geometry["thickness"]
        return {**geometry, "modulus_profile": SoftEdge(depth, skin.ratio, 2 * abs(self.perturbation))}


class TemperatureDrift(Effect):
    """The modulus changes with the order of the recordings: E (1 + d u), u from 0 at the first to 1 at the last.

    Give `total` = d (-0.1 when left out), or the `rate` per burst. Perturbed: u (1 + p (u - 1)), a change that speeds
    up or slows down.
    """

    effect: Literal["temperature_drift"] = "temperature_drift"
    total: Annotated[float, Field(gt=-0.9, le=2), Unit(DIMENSIONLESS)] | None = None
    rate: Annotated[float, Field(ge=-0.1, le=0.1), Unit(DIMENSIONLESS)] | None = None

    varies: ClassVar[bool] = True

    @model_validator(mode="before")
    @classmethod
    def _usual(cls, data: Any) -> Any:
        given = isinstance(data, Mapping) and any(data.get(name) is not None for name in ("total", "rate"))
        return {**data, "total": -0.1} if isinstance(data, Mapping) and not given else data

    @model_validator(mode="after")
    def _one_of_them(self) -> Self:
        if self.total is not None and self.rate is not None:
            refuse(self, [(("rate",), "rate stands beside total; give one of the two", self.rate)])
        return self

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        bursts = sum(len(mounting.frequencies) for mounting in around.mountings)
        if self.rate is not None and not -0.9 < self.rate * bursts <= 2:
            text = (
                f"{self.rate:g} per burst is a change by {self.rate * bursts:.3g} over {bursts} bursts; make it smaller"
            )
            yield ("rate",), text, self.rate

    def apply_to_modulus(self, frequency: RealArray, modulus: ComplexArray, moment: Moment) -> ComplexArray:
        change = self.total if self.rate is None else self.rate * moment.total
        u = moment.elapsed / moment.total
        return modulus * (1 + (change or 0.0) * u * (1 + self.perturbation * (u - 1)))


class AmplitudeSoftening(Effect):
    """The modulus falls with the dynamic strain: the stress is that of a linear sample of strain e / (1 + b abs(e)).

    So E1 and E2 fall alike, by about 0.85 b times the strain's amplitude, and odd harmonics appear. Made by integrating
    the equations of motion in time, see `multilayer.rig.softening`. Perturbed: b abs(e) (abs(e) / 1e-3)^p in place of b
    abs(e), with n = 1 + p there.
    """

    effect: Literal["amplitude_softening"] = "amplitude_softening"
    softening: Annotated[float, Field(ge=0, le=1e4), Unit(DIMENSIONLESS)] = 50.0
