"""Air between the sample's edge and the tube.

D. Pilon, R. Panneton & F. Sgard, J. Acoust. Soc. Am. 116 (2004) 344-356. Parallel assembly: K. Verdière, R. Panneton,
S. Elkoun, T. Dupont & P. Leclaire, J. Acoust. Soc. Am. 134 (2013) 4648-4658.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Values, positive
from multilayer.diagnosis.effects.tube import TubeEffect, TubeSetting, sample_index, thickness_of, with_layers
from multilayer.layers.viscothermal_fluid import ViscothermalFluid
from multilayer.stack import Stack

_MOST = 0.9  # largest share of the cross-section


class LateralAirGap(TubeEffect):
    """A slit along the sample's edge, in parallel to the sample: admittances weighted by area add up."""

    name = "lateral_air_gap"
    place = "beside"
    law = "Y = (1 - s) Y_sample + s Y_slit, s = 4 w/D"
    separated_by = "sealing the edge; a tube of another diameter; a resistivity measured by itself"
    source = "samples are cut 0 to 1 mm too small; K. Hong & J. S. Bolton, Inter-Noise 2008, for two tube diameters"
    parameters = (positive("width", 4e-4, 1.0, "m"),)
    law_error = 0.3  # pressure also spreads sideways from the slit into the sample

    def applies(self, setting: TubeSetting) -> bool:
        """Tell whether there is a sample."""
        return sample_index(setting.stack) is not None

    def surface(self, setting: TubeSetting, stack: Stack, reflection: ComplexArray, values: Values) -> ComplexArray:
        """Return the reflection of the sample in parallel to a slit as long as all layers."""
        width = values["width"]
        # layers of a batch hold arrays, which have no truth value
        lengths = [getattr(layer, "thickness") for layer in stack.layers if thickness_of(layer) > 0]  # noqa: B009
        if not lengths:  # another effect has taken all of it away
            return np.full_like(reflection, np.nan)
        slit = ViscothermalFluid(thickness=1.0, slit_width=1e-3)
        slit = slit.model_copy(update={"thickness": sum(lengths[1:], lengths[0]), "slit_width": width})
        beside = setting.reflection(with_layers(stack, (slit,)))
        share = np.minimum(4 * width / setting.tube.diameter, _MOST)
        admittance = (1 - share) * _admittance(reflection) + share * _admittance(beside)
        return np.asarray((1 - admittance) / (1 + admittance))


def _admittance(reflection: ComplexArray) -> ComplexArray:
    return np.asarray((1 - reflection) / (1 + reflection))
