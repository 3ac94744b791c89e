"""Cases of the speed comparison in phonometry: the absorber (a) alone, for it has no elastic plates."""

from __future__ import annotations

from typing import Any

import numpy as np
from peer_case import AIR, ANGLES, FOAM, FOAM_THICKNESS, Case, Grid, main
from phonometry.fluids import Fluid
from phonometry.materials.absorbers.biot import biot_surface_impedance, biot_waves
from phonometry.materials.absorbers.layered import PoroelasticLayer, layered_absorber
from phonometry.materials.absorbers.porous import PorousMediumResult, johnson_champoux_allard

AIR_OF_IT = Fluid(
    temperature_c=20.0,
    static_pressure_pa=AIR["pressure"],
    composition={},
    model="as in the other programs",
    validity="",
    properties={
        "speed_of_sound": AIR["sound_speed"],
        "density": AIR["density"],
        "viscosity": AIR["viscosity"],
        "heat_capacity_ratio": AIR["heat_capacity_ratio"],
        "prandtl_number": AIR["prandtl"],
    },
)
FRAME = {
    "porosity": FOAM["porosity"],
    "tortuosity": FOAM["tortuosity"],
    "frame_density": FOAM["frame_density"],
    "shear_modulus": FOAM["young_modulus"] * (1 + 1j * FOAM["loss_factor"]) / (2 * (1 + FOAM["poisson_ratio"])),
    "poisson_ratio": FOAM["poisson_ratio"],
}


def cases(grid: Grid) -> dict[str, Case]:
    """Return the cases by name."""
    frequency = np.array(grid.frequency)
    found: dict[str, Case] = {f"a {angle:.0f}": lambda angle=angle: reflection(frequency, angle) for angle in ANGLES}
    return found | {"a 0 closed form": lambda: closed_form(frequency)}


def pores(frequency: Any) -> PorousMediumResult:
    """Return the fluid in the pores, which phonometry wants at the frequencies beforehand."""
    names = ("porosity", "tortuosity", "viscous_length", "thermal_length")
    return johnson_champoux_allard(
        frequency, FOAM["flow_resistivity"], fluid=AIR_OF_IT, **{name: FOAM[name] for name in names}
    )


def reflection(frequency: Any, angle: float) -> Any:
    """Return the reflection of (a) by the general solution of layered absorbers."""
    layer = PoroelasticLayer(FOAM_THICKNESS, pores(frequency), **FRAME)
    return layered_absorber(frequency, [layer], angle_rad=float(np.deg2rad(angle)), fluid=AIR_OF_IT).reflection


def closed_form(frequency: Any) -> Any:
    """Return the reflection of (a) at normal incidence by the formula for this one arrangement."""
    impedance = biot_surface_impedance(biot_waves(pores(frequency), **FRAME), FOAM_THICKNESS)
    air = AIR["density"] * AIR["sound_speed"]
    return (impedance - air) / (impedance + air)


if __name__ == "__main__":
    main(["phonometry"], cases)
