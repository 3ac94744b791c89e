"""Cases of the speed comparison in pymls, which has elastic solids and no thin plates, and no diffuse field."""

from __future__ import annotations

from typing import Any

import numpy as np
import pymls.layers.elastic
from mediapack import PEM, Air, Elastic, Fluid
from peer_case import (
    AIR,
    ALUMINIUM,
    ANGLES,
    FOAM,
    FOAM_THICKNESS,
    GAP_THICKNESS,
    PLATE_THICKNESS,
    Case,
    Grid,
    main,
)
from pymls import Layer, Solver, backing

# 1.8.1 prints a matrix for every elastic layer and frequency; without that it is faster
pymls.layers.elastic.print = lambda *_: None

ALMOST_NORMAL = 1e-6  # degrees; at exactly normal incidence it meets a singular matrix

PORES_AND_FRAME = {
    "phi": "porosity",
    "sigma": "flow_resistivity",
    "alpha": "tortuosity",
    "Lambda": "viscous_length",
    "Lambda_prime": "thermal_length",
    "rho_1": "frame_density",
    "E": "young_modulus",
    "nu": "poisson_ratio",
    "eta": "loss_factor",
}
SOLID = {"rho": "density", "E": "young_modulus", "nu": "poisson_ratio", "eta": "loss_factor"}


def cases(grid: Grid) -> dict[str, Case]:
    """Return the cases by name."""
    assert abs(Air.rho - AIR["density"]) + abs(Air.c - AIR["sound_speed"]) < 1e-9, "pymls has another air built in"
    wall, sheet = Solver(layers=[poroelastic()], backing=backing.rigid), partition()
    found: dict[str, Case] = {
        f"a {angle:.0f}": lambda angle=angle: wall.solve(grid.frequency, [max(angle, ALMOST_NORMAL)])["R"]
        for angle in ANGLES
    }
    return found | {"b elastic solid": lambda: transmission_loss(sheet, grid.frequency, ANGLES[-1])}


def poroelastic() -> Layer:
    """Return the foam."""
    values = {theirs: FOAM[ours] for theirs, ours in PORES_AND_FRAME.items()}
    return Layer(PEM(loss_type="structural", **values), FOAM_THICKNESS)


def partition() -> Solver:
    """Return the stack of (b)."""
    aluminium = Elastic(**{theirs: ALUMINIUM[ours] for theirs, ours in SOLID.items()})
    gap = Layer(Fluid(rho=AIR["density"], c=AIR["sound_speed"]), GAP_THICKNESS)
    plate = Layer(aluminium, PLATE_THICKNESS)
    return Solver(layers=[plate, poroelastic(), gap, plate], backing=backing.transmission)


def transmission_loss(solver: Solver, frequency: list[float], angle: float) -> Any:
    """Return the transmission loss for a plane wave, dB."""
    return -20 * np.log10(np.abs(solver.solve(frequency, [angle])["T"]))


if __name__ == "__main__":
    main(["pymls", "mediapack"], cases)
