"""A frame that is held at the tube's wall."""

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
    """The frame is sprung from the tube's wall: at rest below its resonance, free to move above.

    A frame held all around moves as a membrane of its own shear stiffness, of which the lowest mode is kept:
    ``rho1 -> rho1 (1 - (f0/f)^2 (1 + i eta))`` in the limp or elastic model, ``f0 = 2.405/(pi D) sqrt(N/rho1)`` of a
    round sample (N its shear modulus).
    """

    name = "edge_constraint"
    law = "frame on springs from the tube's wall: rho1 (1 - (f0/f)^2 (1 + i eta))"
    separated_by = "a tube of another diameter (f0 ~ 1/D); a sample cut smaller, its edge sealed softly"
    source = "B. H. Song, J. S. Bolton & Y. J. Kang, J. Acoust. Soc. Am. 110 (2001) 2902: some hundred hertz"
    parameters = (
        positive("frequency", 400.0, 0.8, "Hz"),
        positive("frame_density", 40.0, 0.8, "kg/m^3"),
        positive("loss_factor", 0.15, 0.7),
    )
    absent: ClassVar[Mapping[str, float]] = {"frequency": 1e6}  # held so firmly that nothing moves
    law_error = 0.3
    starts = tuple((float(x), 0.0, 0.0) for x in np.linspace(-2.5, 2.5, 11))

    def applies(self, setting: TubeSetting) -> bool:
        """The nominal frame must be known well enough to be let go of: a porosity is needed."""
        index = sample_index(setting.stack)
        return index is not None and getattr(setting.stack.layers[index], "porosity", None) is not None

    def stack(self, setting: TubeSetting, stack: Stack, values: Values) -> Stack:
        """The frame's mass with the spring's force over its acceleration."""
        index = sample_index(stack)
        assert index is not None
        layer = stack.layers[index]
        spring = (values["frequency"] / setting.frequency) ** 2 * (1 + 1j * values["loss_factor"])
        if "frame_density" in type(layer).model_fields:
            own = getattr(layer, "frame_density")  # noqa: B009
            return with_layer(stack, index, layer.model_copy(update={"frame_density": own * (1 - spring)}))
        assert isinstance(layer, PoreLayer)
        return with_layer(stack, index, as_limp(layer, values["frame_density"] * (1 - spring)))


def as_limp(layer: PoreLayer, frame_density: np.ndarray) -> Limp:
    """Return the same pores in a frame that has a mass, kg/m3."""
    own = {name: getattr(layer, name) for name in type(layer).model_fields if name in Limp.model_fields}
    return Limp.model_construct(**{**own, "type": "limp", "frame_density": frame_density})
