"""One configuration that is not as the file says: a mislabelled plate, a bad mounting, a wrong entry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from multilayer.diagnosis.places.base import Chain, ComplexArray, Place, Setting


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

    @classmethod
    def variants(cls) -> tuple[type[OneConfiguration], ...]:
        """Return what may be another there: the sample's modulus, the plate's mass, its height, the reading."""
        return (OneConfiguration, PlateOfOne, HeightOfOne, ReadingOfOne)

    @classmethod
    def instances(cls, settings: tuple[Setting, ...]) -> list[Place]:
        """Return the places of each configuration, where there are several."""
        names = [setting.data.name for setting in settings] if len(settings) > 1 else []
        return [kind(name) for kind in cls.variants() for name in names]

    def modulus(self, setting: Setting, modulus: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the modulus, which changes in this configuration."""
        return np.asarray(modulus * np.exp(values)) if self._is_there(setting) else modulus

    def _is_there(self, setting: Setting) -> bool:
        return setting.data.name == self.configuration


class PlateOfOne(OneConfiguration):
    """The top plate of one configuration is heavier than those of all others, or lighter."""

    variant = "plate"
    title = "in the top plate of one configuration only"
    quantity = "relative change of the plate's mass in that configuration"
    terms: ClassVar = {0: ("relative change of the plate's mass", "")}

    def modulus(self, setting: Setting, modulus: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the modulus as it is."""
        return modulus

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the chain with another plate in this configuration."""
        return chain.with_(plate_mass=chain.plate_mass * (1 + values)) if self._is_there(setting) else chain


class HeightOfOne(OneConfiguration):
    """The sample of one configuration is higher than stated, or lower.

    By a share v: as a rod of the stated height whose modulus is ``E/(1 + v)`` and whose density is ``rho (1 + v)``.

    Limits: with the free rim of a sample of a Poisson's ratio its stiffness depends on its shape, too, which is left
    out: of a height that is 10 % more, S = 0.9, a tenth of the gap is left at 0.35, and two thirds at 0.45.
    """

    variant = "height"
    title = "in the sample's height in one configuration only"
    quantity = "relative change of the sample's height in that configuration"
    terms: ClassVar = {0: ("relative change of the sample's height", "")}

    def modulus(self, setting: Setting, modulus: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the modulus of the rod of the stated height."""
        return np.asarray(modulus / (1 + values)) if self._is_there(setting) else modulus

    def chain(self, setting: Setting, chain: Chain, values: ComplexArray) -> Chain:
        """Return the chain with that rod's density."""
        return chain.with_(density=chain.density * (1 + values)) if self._is_there(setting) else chain


class ReadingOfOne(OneConfiguration):
    """The reading of one configuration is another: a range or a gain that was changed, a channel that is reversed."""

    variant = "reading"
    is_reading = True
    title = "in the reading of one configuration only"
    quantity = "relative change of top/base in that configuration"
    terms: ClassVar = {0: ("relative change of top/base", ""), 1: ("relative lead of the top", "s")}
    detunes = True
    known_values = (-2 + 0j,)  # a reversed channel

    def modulus(self, setting: Setting, modulus: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the modulus as it is."""
        return modulus

    def motion(self, setting: Setting, motion: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the motion times ``1 + v`` in this configuration."""
        return np.asarray(motion * (1 + values)) if self._is_there(setting) else motion
