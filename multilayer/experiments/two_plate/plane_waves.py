"""The two-plate rig as a stack of plane layers: support plate, sample, top plate, and what lies above.

P. Bonfiglio & F. Pompoli, Polymer Testing 48 (2015) 89-96.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol, cast

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, Numeric
from multilayer.experiments.two_plate.pores import Pores, PumpedAir
from multilayer.layers.elastic_solid import ElasticSolid
from multilayer.measurements.description import Campaign, Configuration
from multilayer.media.elastic import p_wave_modulus
from multilayer.media.rod import chain_transmissibility
from multilayer.response import base_motion
from multilayer.stack import Ambient, Stack

SPECIMEN = "specimen"
Uncertain = Literal["thickness", "density", "top_plate_mass"]
_FIELDS: dict[str, tuple[str, str]] = {
    "thickness": (SPECIMEN, "thickness"),
    "density": (SPECIMEN, "density"),
    "top_plate_mass": ("top_plate", "density"),
}
_POROUS_DENSITY = "frame_density"  # a campaign's density is that of the frame: the air weighs a thousandth of it


class Rig(Protocol):
    """A model of the rig, as inverse problems need it."""

    @property
    def reach(self) -> tuple[float, float]:
        """Lowest and highest frequency it answers for, relative to a burst's."""

    def transmissibility(self, frequency: ArrayLike, modulus: ArrayLike) -> ComplexArray:
        """Return top over base motion, for frequencies (n,) in Hz and moduli (..., n) in Pa."""

    @property
    def scales(self) -> bool:
        """Whether all masses and moduli of sample and plate times one factor leave the motion unchanged."""

    @property
    def is_chain(self) -> bool:
        """Whether it is a chain of rods with a mass on top, to which rods and springs may be added."""

    @property
    def sensor_mass(self) -> float:
        """Mass of the accelerometer on the top plate, kg."""

    @property
    def takes_arrays(self) -> bool:
        """Whether an uncertain quantity may be shifted by arrays, of shape (..., 1)."""

    def shifted(self, quantity: Uncertain, amount: Numeric, *, relative: bool) -> Rig:
        """Return the rig with an uncertain quantity changed by `amount`."""


@dataclass(frozen=True)
class PlaneWaveRig:
    """The model of Bonfiglio & Pompoli 2015: three solid layers of infinite extent in plane motion.

    The sample's free rim is not modelled: with a Poisson's ratio above 0 the modulus comes out too low.

    Attributes
    ----------
    stack : Stack
        With a poroelastic sample in place of the elastic solid where pores are given.
    pumped : PumpedAir, optional
        Air that leaves through an open rim, as a stiffness in parallel to that of an elastic sample: a first guess for
        finite elements.
    sensor_mass : float
        Mass of the accelerometer, kg, which is contained in the top plate's density.
    """

    stack: Stack
    pumped: PumpedAir | None = None
    sensor_mass: float = 0.0

    @property
    def reach(self) -> tuple[float, float]:
        """All frequencies."""
        return 0.0, math.inf

    @property
    def scales(self) -> bool:
        """Without air, masses and moduli times one factor leave the motion unchanged."""
        return self.pumped is None and not self._porous

    @property
    def is_chain(self) -> bool:
        """Without air, three solids at normal incidence are a chain of rods."""
        return self.stack.termination == "free" and self.scales

    @property
    def _porous(self) -> bool:
        return self.stack.layers[self.stack.index(SPECIMEN)].type == "poroelastic"

    @classmethod
    def of(
        cls,
        campaign: Campaign,
        configuration: Configuration,
        termination: Literal["free", "ambient"] = "free",
        ambient: Ambient | None = None,
        pores: Pores | None = None,
        *,
        open_rim: bool = False,
        sensor_mass: float = 0.0,
    ) -> PlaneWaveRig:
        """Return the rig of one configuration of a campaign.

        Parameters
        ----------
        campaign : Campaign
        configuration : Configuration
        termination : {'free', 'ambient'}
            What lies above the top plate.
        ambient : Ambient, optional
            There, and in pores.
        pores : Pores, optional
            Of the sample, whose stated density then is that of its frame.
        open_rim : bool
            Whether the pores' air leaves through the rim, see `PumpedAir`, or is confined laterally as the sample.
        sensor_mass : float
            Mass of the accelerometer, kg, spread over the top plate.
        """
        base, top, gas = campaign.base_plate, campaign.top_plate, (ambient or Ambient()).gas
        area = math.pi * configuration.specimen_radius**2
        pumped = PumpedAir(pores, configuration.specimen_radius, gas) if pores and open_rim else None
        layers = [
            {
                "type": "elastic_solid",
                "name": "base_plate",
                "thickness": base.thickness,
                "density": base.density,
                "young_modulus": base.young_modulus,
                "poisson_ratio": base.poisson_ratio,
            },
            _specimen(campaign, configuration, None if pumped or not pores else pores.fields(gas)),
            {
                "type": "elastic_solid",
                "name": "top_plate",
                "thickness": configuration.top_plate_thickness,
                "density": top.density + sensor_mass / (area * configuration.top_plate_thickness),
                "young_modulus": top.young_modulus,
                "poisson_ratio": top.poisson_ratio,
            },
        ]
        data = {"ambient": ambient or Ambient(), "layers": layers, "termination": termination}
        return cls(Stack.model_validate(data), pumped, sensor_mass)

    def transmissibility(self, frequency: ArrayLike, modulus: ArrayLike) -> ComplexArray:
        """Return top over base motion.

        Parameters
        ----------
        frequency : array, shape (n_frequency,)
            Hz.
        modulus : complex array, shape (..., n_frequency) or broadcastable to it
            Young's modulus E1 + i E2 of the sample, or of its frame where it has pores, Pa.
        """
        if self.stack.termination == "free" and not self._porous:
            return self._chain(frequency, modulus)
        stack = self.stack.replaced({f"layers.{SPECIMEN}.young_modulus": modulus})
        return base_motion(stack, frequency).transmissibility

    def _chain(self, frequency: ArrayLike, modulus: ArrayLike) -> ComplexArray:
        """Return top over base motion in closed form: at normal incidence three solids are a chain of rods."""
        f, sample = np.asarray(frequency, dtype=float), np.asarray(modulus, dtype=complex)
        chain = []
        for layer in self.stack.layers:
            solid = cast("ElasticSolid", layer)
            young = sample if solid.name == SPECIMEN else cast("float", solid.young_modulus)
            stiffness = p_wave_modulus(young, solid.poisson_ratio)
            if solid.name == SPECIMEN and self.pumped is not None:
                stiffness = stiffness + self.pumped.stiffness(f)
            chain.append((stiffness, solid.density, solid.thickness))
        return chain_transmissibility(f, chain)

    @property
    def takes_arrays(self) -> bool:
        """True, as any stack takes a number per sample."""
        return True

    def shifted(self, quantity: Uncertain, amount: Numeric, *, relative: bool) -> PlaneWaveRig:
        """Return the rig with an uncertain quantity changed by `amount`."""
        layer, field = _FIELDS[quantity]
        if quantity == "density" and self._porous:
            field = _POROUS_DENSITY
        value = getattr(self.stack.layers[self.stack.index(layer)], field)
        changed = value * (1 + amount) if relative else value + amount
        return replace(self, stack=self.stack.replaced({f"layers.{layer}.{field}": changed}))


def _specimen(campaign: Campaign, configuration: Configuration, pores: dict[str, Any] | None) -> dict[str, Any]:
    """Return the sample's layer: an elastic solid, or with the fields of its pores a poroelastic one."""
    layer = {
        "name": SPECIMEN,
        "thickness": configuration.specimen_thickness,
        "young_modulus": 1e5,  # replaced by every candidate
        "poisson_ratio": campaign.specimen.poisson_ratio,
    }
    if pores is None:
        return {"type": "elastic_solid", "density": campaign.specimen.density, **layer}
    return {"type": "poroelastic", _POROUS_DENSITY: campaign.specimen.density, **layer, **pores}
