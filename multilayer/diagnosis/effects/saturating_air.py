"""Air pumped through an open-pored sample to its open rim."""

from __future__ import annotations

from multilayer.diagnosis.effects.base import VACUUM, Chain, Effect, Setting, Values, positive


class SaturatingAir(Effect):
    """Pores sealed by the plates and open at the rim: stiffness and drag of air that cannot escape.

    See `media.pumped_disc` for the equations and their sources.
    """

    name = "saturating_air"
    place = "sample_radius"
    acts_through_place = False
    law = "Biot sample, pores sealed by the plates, Darcy flow to the rim; axial waves, a frame that gives way sideways"
    separated_by = "another radius; vacuum"
    source = "open-cell foams and fibres: 1e3 to 1e6 N s/m4; isothermal air, porosity near 1"
    absent_in = VACUUM
    moves_resonances = True
    is_slow = True
    size_error = 0.1  # `media.pumped_disc` beside finite elements
    parameters = (positive("flow_resistivity", 3e4, 1.5, "N*s/m^4"),)

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """Return the chain with the flow resistivity of the sample's pores."""
        return chain.with_(resistivity=values["flow_resistivity"])
