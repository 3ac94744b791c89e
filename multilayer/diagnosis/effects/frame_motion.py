"""A moving frame where the nominal one is at rest.

M. A. Biot, J. Acoust. Soc. Am. 28 (1956) 168-191; limp frames: R. Panneton, J. Acoust. Soc. Am. 122 (2007) EL217-EL222.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from multilayer.diagnosis.effects.base import Values, positive
from multilayer.diagnosis.effects.tube import TubeEffect, TubeSetting, sample_index, with_layer
from multilayer.layers.equivalent_fluid import EquivalentFluid
from multilayer.layers.poroelastic import Poroelastic
from multilayer.stack import Stack

_MODELS = ("jca", "jcal", "jcapl")


class FrameMotion(TubeEffect):
    """A Biot frame in place of a rigid one: limp where it is soft, with a resonance where it is stiffer.

    It is glued to the layer behind it. Normal incidence depends on the modulus of uniaxial compression only, which is E
    for the Poisson's ratio of 0 taken here.
    """

    name = "frame_motion"
    law = "rigid frame -> Biot: density, modulus, losses; limp where the modulus is small"
    separated_by = "another thickness (resonance ~ 1/h); needles or a grid that hold the frame; a modulus measured"
    source = "foams and fibres: 8 to 150 kg/m3, 5 kPa (limp) to 2 MPa; R. Panneton, JASA 122 (2007) EL217 for limp"
    parameters = (
        positive("young_modulus", 1e5, 1.8, "Pa"),
        positive("frame_density", 40.0, 0.8, "kg/m^3"),
        positive("loss_factor", 0.1, 0.7),
    )
    absent: ClassVar[Mapping[str, float]] = {"young_modulus": 1e13}  # rigid
    law_error = 0.1
    # close enough not to miss a resonance, of light frames and of heavy ones
    starts = tuple((float(x), y, 0.0) for y in (0.0, 1.0) for x in np.linspace(-2.5, 2.5, 51))

    def applies(self, setting: TubeSetting) -> bool:
        """Tell whether the nominal frame is rigid, with a model of pores that a poroelastic layer has as well."""
        index = sample_index(setting.stack)
        layer = None if index is None else setting.stack.layers[index]
        return isinstance(layer, EquivalentFluid) and layer.model in _MODELS

    def stack(self, setting: TubeSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with the same pores in an elastic frame."""
        index = sample_index(stack)
        assert index is not None
        layer = stack.layers[index]
        pores = {name: getattr(layer, name) for name in type(layer).model_fields if name in Poroelastic.model_fields}
        frame = {"type": "poroelastic", "poisson_ratio": 0.0, **values}
        return with_layer(stack, index, Poroelastic.model_construct(**{**pores, **frame}))
