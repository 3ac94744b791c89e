"""Air pumped through an open-pored sample to its open rim."""

from __future__ import annotations

import numpy as np
from scipy.special import ive

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, positive

_PRESSURE = 101325.0  # Pa


class SaturatingAir(Effect):
    """Pores sealed by the plates and open at the rim: the air's stiffness, as far as it cannot escape."""

    name = "saturating_air"
    law = "E + (P0/phi) (1 - 2 I1(x)/(x I0(x))), x = R sqrt(i w sigma phi/P0)"
    separated_by = "another radius; vacuum"
    source = "open-cell foams and fibres: 1e3 to 1e6 N s/m4; isothermal air, porosity near 1"
    parameters = (positive("flow_resistivity", 3e4, 1.5, "N s/m4"),)

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """Darcy flow across a compressed disc, averaged over it: radial diffusion of pressure."""
        x = setting.configuration.specimen_radius * np.sqrt(1j * setting.omega * values["flow_resistivity"] / _PRESSURE)
        # scaled Bessel functions: their exponentials cancel in the ratio
        trapped = 1 - 2 * ive(1, x) / (x * ive(0, x))
        return np.asarray(modulus + _PRESSURE * trapped)
