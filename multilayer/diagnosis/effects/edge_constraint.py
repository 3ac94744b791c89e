"""A frame that is held at the tube's wall.

B. H. Song, J. S. Bolton & Y. J. Kang, J. Acoust. Soc. Am. 110 (2001) 2902-2916; D. Pilon, R. Panneton & F. Sgard, J.
Acoust. Soc. Am. 114 (2003) 1980-1987.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from multilayer.diagnosis.effects.base import Values, positive
from multilayer.diagnosis.effects.tube import TubeEffect, TubeSetting, sample_index, with_layer
from multilayer.layers.limp import Limp
from multilayer.layers.pores import PoreLayer
from multilayer.stack import Stack


class EdgeConstraint(TubeEffect):
    """The frame is attached to the tube's wall: at rest below its resonance, free to move above.

    A frame held all around moves as a membrane whose tension is its shear stiffness (Rayleigh, The Theory of Sound,
    vol. 1, 2nd ed., Macmillan 1894, ch. IX), of which the lowest mode is used:
    ``rho1 -> rho1 (1 - (f0/f)^2 (1 + i eta))`` in the limp or elastic model, ``f0 = 2.405/(pi D) sqrt(N/rho1)`` of a
    round sample (N its shear modulus).
    """

    name = "edge_constraint"
    in_tubes_only = True
    law = "frame on springs from the tube's wall: rho1 (1 - (f0/f)^2 (1 + i eta))"
    separated_by = "a tube of another diameter (f0 ~ 1/D); a sample cut smaller, its edge sealed softly"
    source = "B. H. Song, J. S. Bolton & Y. J. Kang, J. Acoust. Soc. Am. 110 (2001) 2902: some hundred hertz"
    parameters = (
        positive("frequency", 400.0, 0.8, "Hz"),
        positive("frame_density", 40.0, 0.8, "kg/m^3"),
        positive("loss_factor", 0.15, 0.7),
    )
    absent: ClassVar[Mapping[str, float]] = {"frequency": 1e6}  # held so firmly that the frame is at rest
    law_error = 0.3
    starts = tuple((float(x), 0.0, 0.0) for x in np.linspace(-2.5, 2.5, 11))

    def applies(self, setting: TubeSetting) -> bool:
        """Tell whether the sample has a porosity, which a moving frame needs."""
        index = sample_index(setting.stack)
        return index is not None and getattr(setting.stack.layers[index], "porosity", None) is not None

    def stack(self, setting: TubeSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with the frame's density reduced by the spring's force over its acceleration."""
        index = sample_index(stack)
        assert index is not None
        layer = stack.layers[index]
        spring = (values["frequency"] / setting.frequency) ** 2 * (1 + 1j * values["loss_factor"])
        if "frame_density" in type(layer).model_fields:
            density = getattr(layer, "frame_density")  # noqa: B009
            return with_layer(stack, index, layer.model_copy(update={"frame_density": density * (1 - spring)}))
        assert isinstance(layer, PoreLayer)
        return with_layer(stack, index, as_limp(layer, values["frame_density"] * (1 - spring)))


def as_limp(layer: PoreLayer, frame_density: np.ndarray) -> Limp:
    """Return a limp layer with the same pores, and a frame of some density, kg/m3."""
    pores = {name: getattr(layer, name) for name in type(layer).model_fields if name in Limp.model_fields}
    return Limp.model_construct(**{**pores, "type": "limp", "frame_density": frame_density})
