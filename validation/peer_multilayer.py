"""Cases of the speed comparison in multilayer."""

from __future__ import annotations

from collections.abc import Callable
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

import multilayer.response
from multilayer.response import plane_wave
from multilayer.stack import Stack

LAYER_TYPES = {"thin plate": "elastic_plate", "elastic solid": "elastic_solid"}


def cases(grid: Grid) -> dict[str, Case]:
    """Return the cases by name."""
    frequency, wall = np.array(grid.frequency), absorber()
    found: dict[str, Case] = {
        f"a {angle:.0f}": lambda angle=angle: plane_wave(wall, frequency, angle).reflection for angle in ANGLES
    }
    for name in LAYER_TYPES:
        stack = partition(name)
        found[f"b {name}"] = lambda stack=stack: plane_wave(stack, frequency, ANGLES[-1]).transmission_loss
        if diffuse := diffuse_solver():
            found[f"c {name}"] = lambda stack=stack: diffuse(stack, frequency, max_angle=MAX_ANGLE).transmission_loss
    return found


def diffuse_solver() -> Callable[..., Any] | None:
    """Return the solver of diffuse fields."""
    return getattr(multilayer.response, "diffuse_field", None)


def absorber() -> Stack:
    """Return the stack of (a)."""
    return _stack([_foam()], "rigid")


def partition(kind: str) -> Stack:
    """Return the stack of (b), its plates of one kind."""
    return _stack([_plate(kind), _foam(), _gap(), _plate(kind)], "ambient")


def alternating(count: int) -> Stack:
    """Return a stack of `count` layers: foam, air and aluminium in turn."""
    return _stack([(_foam(), _gap(), _plate("elastic solid"))[i % 3] for i in range(count)], "ambient")


def _stack(layers: list[dict[str, Any]], termination: str) -> Stack:
    return Stack.model_validate({"ambient": AIR, "layers": layers, "termination": termination})


def _foam() -> dict[str, Any]:
    return {"type": "poroelastic", "thickness": FOAM_THICKNESS, **FOAM}


def _gap() -> dict[str, Any]:
    return {"type": "fluid", "thickness": GAP_THICKNESS}


def _plate(kind: str) -> dict[str, Any]:
    return {"type": LAYER_TYPES[kind], "thickness": PLATE_THICKNESS, **ALUMINIUM}


if __name__ == "__main__":
    main(["multilayer"], cases)
