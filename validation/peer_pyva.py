"""Cases of the speed comparison in pyva, which has thin plates and elastic solids."""

from __future__ import annotations

from typing import Any

import numpy as np
from peer_case import (
    AIR,
    ALUMINIUM,
    ANGLES,
    FOAM,
    FOAM_THICKNESS,
    GAP_THICKNESS,
    MAX_ANGLE,
    PLATE_THICKNESS,
    Case,
    Grid,
    main,
)
from pyva.models import TMmodel
from pyva.properties.materialClasses import Fluid, IsoMat, PoroElasticMat
from pyva.properties.structuralPropertyClasses import PlateProp
from pyva.systems.infiniteLayers import FluidLayer, PlateLayer, PoroElasticLayer, SolidLayer

HEAT_CAPACITY = 1005.1  # J/(kg K); pyva takes the Prandtl number from it and the heat conductivity
GAS = {
    "c0": AIR["sound_speed"],
    "rho0": AIR["density"],
    "dynamic_viscosity": AIR["viscosity"],
    "kappa": AIR["heat_capacity_ratio"],
    "Cp": HEAT_CAPACITY,
    "heat_conductivity": HEAT_CAPACITY * AIR["viscosity"] / AIR["prandtl"],
}
FLUID = Fluid(eta=0.0, **GAS)
# With thin plates its time grows with the square of the number of frequencies; this many at a time are the fastest
SHARE = 20


class Model(TMmodel):
    """A stack between half-spaces of the same air.

    The diffuse field of 1.3.1 hands the fluids over in the place of another argument and gets pyva's default air.
    """

    def transmission_allard(self, omega: Any, kx: Any = 0.0, *_: Any, **options: Any) -> Any:
        """Return the transmitted power for a plane wave."""
        return super().transmission_allard(omega, kx, **{**options, "fluids": (FLUID, FLUID)})


def cases(grid: Grid) -> dict[str, Case]:
    """Return the cases by name."""
    omega, few = 2 * np.pi * np.array(grid.frequency), 2 * np.pi * np.array(grid.few)
    foam = Model([poroelastic()])
    found: dict[str, Case] = {f"a {angle:.0f}": lambda angle=angle: reflection(foam, omega, angle) for angle in ANGLES}
    for name, kind in (("thin plate", PlateLayer), ("elastic solid", SolidLayer)):
        model = partition(kind)
        share = SHARE if kind is PlateLayer else len(omega)
        found[f"b {name}"] = lambda model=model, share=share: transmission_loss(model, omega, ANGLES[-1], share)
        found[f"c {name}"] = lambda model=model: diffuse_loss(model, few)
    return found


def poroelastic() -> PoroElasticLayer:
    """Return the foam."""
    frame = IsoMat(FOAM["young_modulus"], FOAM["frame_density"], FOAM["poisson_ratio"], FOAM["loss_factor"])
    # 1.3.1 leaves the density out of Johnson's shape factor, which asks for density / viscous_length**2
    viscous_length = FOAM["viscous_length"] / np.sqrt(AIR["density"])
    pores = [FOAM[name] for name in ("flow_resistivity", "porosity", "tortuosity")]
    medium = PoroElasticMat(frame, *pores, viscous_length, FOAM["thermal_length"], **GAS)
    return PoroElasticLayer(medium, FOAM_THICKNESS)


def partition(kind: type) -> Model:
    """Return the stack of (b), its plates of one kind."""
    aluminium = IsoMat(*(ALUMINIUM[name] for name in ("young_modulus", "density", "poisson_ratio", "loss_factor")))
    plate = PlateProp(PLATE_THICKNESS, aluminium)
    return Model([kind(plate), poroelastic(), FluidLayer(GAP_THICKNESS, FLUID), kind(plate)])


def reflection(model: Model, omega: Any, angle: float) -> Any:
    """Return the reflection of a stack on a wall."""
    impedance = model.impedance_allard(omega, _trace(omega, angle), boundary_condition="fixed", signal=False)
    air = AIR["density"] * AIR["sound_speed"] / np.cos(np.deg2rad(angle))
    return (impedance - air) / (impedance + air)


def transmission_loss(model: Model, omega: Any, angle: float, share: int) -> Any:
    """Return the transmission loss for a plane wave, dB, solved `share` frequencies at a time."""
    parts = [omega[i : i + share] for i in range(0, len(omega), share)]
    power = [model.transmission_allard(w, _trace(w, angle), signal=False) for w in parts]
    return -10 * np.log10(np.concatenate(power))


def diffuse_loss(model: Model, omega: Any) -> Any:
    """Return the transmission loss for a diffuse field, dB, at pyva's own angles."""
    power = model.transmission_diffuse(
        omega, theta_max=np.deg2rad(MAX_ANGLE), fluids=(FLUID, FLUID), signal=False, allard=True
    )
    return -10 * np.log10(power)


def _trace(omega: Any, angle: float) -> Any:
    return omega / AIR["sound_speed"] * np.sin(np.deg2rad(angle))


if __name__ == "__main__":
    main(["pyva-toolbox"], cases)
