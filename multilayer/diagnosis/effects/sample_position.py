"""A sample whose face is not where the evaluation supposes it.

B. F. G. Katz, J. Acoust. Soc. Am. 108 (2000) 2231-2237.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Values, signed
from multilayer.diagnosis.effects.tube import TubeEffect, TubeSetting


class SamplePosition(TubeEffect):
    """The reflection coefficient is that of a plane before (d > 0) or behind the sample's face."""

    name = "sample_position"
    place = "reading"
    law = "R exp(-2 i k d)"
    separated_by = "the empty tube with its wall at the sample's place; a sample pushed by a known way"
    source = "1 to 2 mm of a soft face; Katz 2000: positions of sample and microphones make about 3 % of R"
    parameters = (signed("distance", 1.5e-3, "m"),)
    law_error = 0.01

    def reading(self, setting: TubeSetting, reflection: ComplexArray, values: Values) -> ComplexArray:
        """Return the reflection with the phase of the way to the face and back."""
        return np.asarray(reflection * np.exp(-2j * setting.wavenumber * values["distance"]))
