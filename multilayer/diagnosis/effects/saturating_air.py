"""Air pumped through an open-pored sample to its open rim."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, positive
from multilayer.media.pumped_frame import pumped_frame_stiffness


class SaturatingAir(Effect):
    """Pores sealed by the plates and open at the rim: the air's stiffness, as far as it cannot escape."""

    name = "saturating_air"
    law = "E + K (1 - mean of p/p0), p: Darcy flow to the rim through a frame that gives way; K = P0, isothermal"
    separated_by = "another radius; vacuum"
    source = "open-cell foams and fibres: 1e3 to 1e6 N s/m4; isothermal air, porosity near 1"
    moves_resonances = True
    law_error = 0.4  # the closed form beside finite elements: 5 % below the first resonance, as large as itself above
    parameters = (positive("flow_resistivity", 3e4, 1.5, "N s/m4"),)

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """The frame's modulus and the air's."""
        specimen, configuration = setting.campaign.specimen, setting.configuration
        air = pumped_frame_stiffness(
            setting.omega,
            modulus,
            values["flow_resistivity"],
            radius=configuration.specimen_radius,
            thickness=configuration.specimen_thickness,
            density=specimen.density,
            poisson_ratio=specimen.poisson_ratio,
        )
        return np.asarray(modulus + air)
