"""The two-plate rig as a stack of plane layers: support plate, sample, top plate, and what lies above."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, Protocol, cast

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray
from multilayer.layers.elastic_solid import ElasticSolid
from multilayer.measurements.description import Campaign, Configuration
from multilayer.media.elastic import p_wave_modulus
from multilayer.media.rod import chain_transmissibility
from multilayer.response import base_motion
from multilayer.stack import Ambient, Stack

SPECIMEN = "specimen"
Uncertain = Literal["thickness", "density", "top_plate_mass"]
_FIELDS: dict[str, str] = {
    "thickness": f"layers.{SPECIMEN}.thickness",
    "density": f"layers.{SPECIMEN}.density",
    "top_plate_mass": "layers.top_plate.density",
}


class Rig(Protocol):
    """What an inverse problem asks of a model of the rig."""

    @property
    def reach(self) -> tuple[float, float]:
        """Lowest and highest frequency it answers for, relative to a burst's."""

    def transmissibility(self, frequency: ArrayLike, modulus: ArrayLike) -> ComplexArray:
        """Return top over base motion, for frequencies (n,) in Hz and moduli (..., n) in Pa."""

    def shifted(self, quantity: Uncertain, amount: float, *, relative: bool) -> Rig:
        """Return the rig with an uncertain quantity changed by `amount`."""


@dataclass(frozen=True)
class PlaneWaveRig:
    """The model of Bonfiglio & Pompoli 2015: three solid layers of infinite extent in plane motion.

    The sample's free rim is not in it: with a Poisson's ratio above 0 its apparent modulus comes out too low.
    """

    stack: Stack

    @property
    def reach(self) -> tuple[float, float]:
        """All frequencies."""
        return 0.0, math.inf

    @classmethod
    def of(
        cls,
        campaign: Campaign,
        configuration: Configuration,
        termination: Literal["free", "ambient"] = "free",
        ambient: Ambient | None = None,
    ) -> PlaneWaveRig:
        """Return the rig of one configuration of a campaign."""
        base, top, specimen = campaign.base_plate, campaign.top_plate, campaign.specimen
        layers = [
            {
                "name": "base_plate",
                "thickness": base.thickness,
                "density": base.density,
                "young_modulus": base.young_modulus,
                "poisson_ratio": base.poisson_ratio,
            },
            {
                "name": SPECIMEN,
                "thickness": configuration.specimen_thickness,
                "density": specimen.density,
                "young_modulus": 1e5,  # replaced by every candidate
                "poisson_ratio": specimen.poisson_ratio,
            },
            {
                "name": "top_plate",
                "thickness": configuration.top_plate_thickness,
                "density": top.density,
                "young_modulus": top.young_modulus,
                "poisson_ratio": top.poisson_ratio,
            },
        ]
        solids = [{"type": "elastic_solid", **layer} for layer in layers]
        return cls(
            Stack.model_validate({"ambient": ambient or Ambient(), "layers": solids, "termination": termination})
        )

    def transmissibility(self, frequency: ArrayLike, modulus: ArrayLike) -> ComplexArray:
        """Return top over base motion.

        Parameters
        ----------
        frequency : array, shape (n_frequency,)
            Hz.
        modulus : complex array, shape (..., n_frequency) or broadcastable to it
            Young's modulus E1 + i E2 of the sample, Pa.
        """
        if self.stack.termination == "free":
            return self._chain(frequency, modulus)
        stack = self.stack.replaced({f"layers.{SPECIMEN}.young_modulus": modulus})
        return base_motion(stack, frequency).transmissibility

    def _chain(self, frequency: ArrayLike, modulus: ArrayLike) -> ComplexArray:
        """Return the same in closed form: at normal incidence three solids are a chain of compression waves."""
        f, sample = np.asarray(frequency, dtype=float), np.asarray(modulus, dtype=complex)
        chain = []
        for layer in self.stack.layers:
            solid = cast("ElasticSolid", layer)
            young = sample if solid.name == SPECIMEN else cast("float", solid.young_modulus)
            chain.append((p_wave_modulus(young, solid.poisson_ratio), solid.density, solid.thickness))
        return chain_transmissibility(f, chain)

    def shifted(self, quantity: Uncertain, amount: float, *, relative: bool) -> PlaneWaveRig:
        """Return the rig with an uncertain quantity changed by `amount`."""
        _, layer, field = _FIELDS[quantity].split(".")
        value = getattr(self.stack.layers[self.stack.index(layer)], field)
        changed = value * (1 + amount) if relative else value + amount
        return PlaneWaveRig(self.stack.replaced({_FIELDS[quantity]: changed}))
