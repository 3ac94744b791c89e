"""Air in the pores."""

from __future__ import annotations

from typing import Any, Literal

from multilayer.media.gas import dry_air
from multilayer.media.pumped_air import cylindrical_length
from multilayer.rig.effect_base import Effect, Geometry, Mounting, Size
from multilayer.rig.specimen import SpecimenSettings
from multilayer.units import FlowResistivity, Length, Porosity, Tortuosity


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

    takes = (
        "porosity", "flow_resistivity", "tortuosity", "viscous_length", "thermal_length", "pore_rim",
    )  # fmt: skip
    drawn = Size("flow_resistivity", 2e3, 2e5, parameter="flow_resistivity")

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
