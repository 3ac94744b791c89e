"""One configuration that is not as the file says: a mislabelled plate, a bad mounting, a wrong entry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from multilayer.diagnosis.places.base import ComplexArray, Place, Setting


@dataclass(frozen=True)
class OneConfiguration(Place):
    """The sample of one configuration departs from that of all others.

    Attributes
    ----------
    configuration : str
        Its name.
    """

    configuration: str = ""

    name = "one_configuration"
    title = "in one configuration only"
    quantity = "change of ln E in that configuration"
    terms: ClassVar = {0: ("factor", "")}

    @classmethod
    def instances(cls, settings: tuple[Setting, ...]) -> list[Place]:
        """Return a place for each configuration, where there are several."""
        return [cls(setting.data.name) for setting in settings] if len(settings) > 1 else []

    def modulus(self, setting: Setting, modulus: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the modulus, which changes in this configuration."""
        return np.asarray(modulus * np.exp(values)) if setting.data.name == self.configuration else modulus
