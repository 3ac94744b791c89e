"""A thin resistive screen."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from multilayer.layers.field_sets import FieldSets
from multilayer.matrix.faces import Faces, sheet_faces
from multilayer.matrix.wave import Wave
from multilayer.units import FlowResistivity, Length, Positive, Unit

FlowResistance = Annotated[float, Positive, Unit("N*s/m^3")]
SurfaceDensity = Annotated[float, Positive, Unit("kg/m^2")]


class Screen(FieldSets):
    """A fabric or wire mesh, thin beside its flow resistance; held still, or free to move with a mass.

    Fields: `flow_resistance` (N s/m3), or `flow_resistivity` (N s/m4) and `thickness` (m); `surface_density` (kg/m2)
    where the screen moves, held still without it. State (p, v3): a solid or poroelastic neighbour slips on it. The air
    in the screen has no mass and no compressibility: it holds while thickness times frequency is small; use
    `equivalent_fluid` or `limp` beyond.
    """

    type: Literal["screen"] = "screen"
    thickness: Length | None = None
    flow_resistance: FlowResistance | None = None
    flow_resistivity: FlowResistivity | None = None
    surface_density: SurfaceDensity | None = None

    summary: ClassVar[str] = "thin resistive screen, held still or free to move"
    stands_still: ClassVar[bool] = True
    composes: ClassVar[bool] = False  # its mass does not follow its thickness

    @classmethod
    def field_sets(cls, data: Mapping[str, Any]) -> tuple[str, tuple[tuple[str, ...], ...]]:
        """Return the two ways to give the resistance."""
        return "a screen", (("flow_resistance",), ("flow_resistivity", "thickness"))

    @classmethod
    def governed_fields(cls) -> frozenset[str]:
        """Return the fields of the resistance."""
        return frozenset(("flow_resistance", "flow_resistivity", "thickness"))

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices: p(front) - p(back) = Z v3.

        Resistance and mass are in parallel, as the pressure difference drives both the flow through the screen and
        the screen: ``1/Z = 1/R + 1/(i w m)``; Allard & Atalla 2009, section 11.3.6 for R alone.
        """
        resistance = self._resistance()
        if self.surface_density is None:
            impedance = resistance + 0j * wave.omega
        else:
            inertia = 1j * wave.omega * self.surface_density
            impedance = resistance * inertia / (resistance + inertia)
        return sheet_faces(wave, np.asarray(impedance))

    def _resistance(self) -> float:
        if self.flow_resistance is not None:
            return self.flow_resistance
        assert self.flow_resistivity is not None  # validated
        assert self.thickness is not None
        return self.flow_resistivity * self.thickness
