"""Air in the pores of the sample, as a fit file states it.

D. L. Johnson, J. Koplik & R. Dashen, J. Fluid Mech. 176 (1987) 379-402; Y. Champoux & J.-F. Allard, J. Appl. Phys. 70
(1991) 1975-1979. The formulae stand in `media.porous` and `media.pumped_air`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.media.gas import Gas
from multilayer.media.porous import champoux_allard_modulus, johnson_density
from multilayer.media.pumped_air import cylindrical_length, pumped_air_stiffness
from multilayer.models import Model
from multilayer.units import FlowResistivity, Length, Porosity, Tortuosity


class Pores(Model):
    """Pores of a sample whose faces the plates seal: Biot's frame, Johnson-Champoux-Allard pores.

    Attributes
    ----------
    porosity : float
    flow_resistivity : float
        N s/m4.
    tortuosity : float
    viscous_length, thermal_length : float, optional
        m. When left out: the length of cylindrical pores, and for the thermal length twice that or, if larger, the
        viscous length.
    rim : {'open', 'sealed'} or None
        Whether air passes through the sample's rim; by default ``open`` with finite elements and ``sealed`` with plane
        waves, which have no rim.
    """

    porosity: Porosity
    flow_resistivity: FlowResistivity
    tortuosity: Tortuosity = 1.0
    viscous_length: Length | None = None
    thermal_length: Length | None = None
    rim: Literal["open", "sealed"] | None = None

    def fields(self, gas: Gas) -> dict[str, Any]:
        """Return the fields of a poroelastic layer, and of `rig.two_plate.TwoPlateRig`, SI."""
        tube = cylindrical_length(self.porosity, self.flow_resistivity, self.tortuosity, gas)
        viscous = self.viscous_length or tube
        return {
            "porosity": self.porosity,
            "flow_resistivity": self.flow_resistivity,
            "tortuosity": self.tortuosity,
            "viscous_length": viscous,
            "thermal_length": self.thermal_length or max(2 * tube, viscous),
        }


@dataclass(frozen=True)
class PumpedAir:
    """The stiffness that air leaving through an open rim adds to a disc in a plane-wave model.

    A first guess for the finite elements: the sample is compressed uniformly, and constrained at its rim.

    Attributes
    ----------
    pores : Pores
    radius : float
        m.
    gas : Gas
    """

    pores: Pores
    radius: float
    gas: Gas

    def stiffness(self, frequency: RealArray) -> ComplexArray:
        """Return the additional modulus, Pa, at frequencies in Hz."""
        fields = self.pores.fields(self.gas)
        omega = 2 * np.pi * np.maximum(frequency, np.finfo(float).tiny)
        thermal = fields.pop("thermal_length")
        density = johnson_density(omega, **fields, gas=self.gas)
        return pumped_air_stiffness(
            omega, self.radius, density, champoux_allard_modulus(omega, self.pores.porosity, thermal, self.gas)
        )
