"""Places of an impedance tube: before the sample, behind it, beside it, in its layers, and in the reading.

Surface impedances: J.-F. Allard & N. Atalla, Propagation of Sound in Porous Media, 2nd ed., Wiley 2009, ch. 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.places.base import TubePlace, TubeSetting
from multilayer.experiments.stacks.places import (
    before_backing,
    elastic_layers,
    pore_fluid,
    pore_layers,
    skeleton_modulus,
    with_factors,
)
from multilayer.stack import Stack


class InFront(TubePlace):
    """Something in front of the sample, through which the air flows: an impedance in series, Z = Z_sample + z."""

    name = "in_front"
    title = "in front of the sample"
    quantity = "series impedance"
    unit = "Pa s/m"
    passive_sign, passive_part = 1, "real"
    terms: ClassVar = {
        0: ("resistance", "Pa s/m"), 1: ("mass per area", "kg/m2"), -1: ("spring", "Pa/m"),
        "resonance": ("impedance with a resonance", "Pa s/m"),
    }  # fmt: skip

    def scale(self, settings: tuple[TubeSetting, ...], modulus: float) -> float:
        """Return the impedance of air."""
        gas = settings[0].gas
        return float(gas.density * gas.sound_speed)

    def surface(
        self, setting: TubeSetting, stack: Stack, reflection: ComplexArray, values: ComplexArray
    ) -> ComplexArray:
        """Return the reflection with the impedance in series: that of the air before it is rho c over the cosine."""
        relative = values * np.cos(np.deg2rad(setting.angle)) / self.scale((setting,), 1.0)
        return np.asarray((2 * reflection + relative * (1 - reflection)) / (2 + relative * (1 - reflection)))


class Behind(TubePlace):
    """What backs the stack instead of the rigid wall, by ln of its reflection coefficient r in air.

    0 is the wall; air of depth d before it is ``-2 i k d``, in proportion to frequency without a resonance. A passive
    backing has a real part of at most 0.
    """

    name = "behind"
    title = "behind the sample"
    quantity = "ln of the backing's reflection"
    passive_sign, passive_part = -1, "real"
    terms: ClassVar = {1: ("lead of the reflected wave", "s")}

    @classmethod
    def instances(cls, settings: tuple[TubeSetting, ...]) -> list[TubePlace]:
        """Return the place where all stacks end at a rigid wall."""
        return [cls()] if all(setting.stack.termination == "rigid" for setting in settings) else []

    def scale(self, settings: tuple[TubeSetting, ...], modulus: float) -> float:
        """Return a whole turn of the reflected wave: air of half a wavelength."""
        return float(2 * np.pi)

    def surface(
        self, setting: TubeSetting, stack: Stack, reflection: ComplexArray, values: ComplexArray
    ) -> ComplexArray:
        """Return the reflection of the stack before that backing."""
        return before_backing(setting, stack, reflection, np.exp(values))


class BesideTheSample(TubePlace):
    """A path beside the sample: an admittance in parallel, over that of air."""

    name = "beside"
    title = "beside the sample"
    quantity = "admittance in parallel, over that of air"
    passive_sign, passive_part = 1, "real"
    terms: ClassVar = {
        0: ("leak", ""), 1: ("compliance times rho c", "s"), -1: ("rho c over a mass per area", "1/s"),
        "resonance": ("resonator", ""),
    }  # fmt: skip

    def surface(
        self, setting: TubeSetting, stack: Stack, reflection: ComplexArray, values: ComplexArray
    ) -> ComplexArray:
        """Return the reflection with the admittance in parallel."""
        return np.asarray((2 * reflection - values * (1 + reflection)) / (2 + values * (1 + reflection)))


@dataclass(frozen=True)
class InLayer(TubePlace):
    """The air in the pores of a layer, by a factor exp(law) on one of its two properties, in every stack that has it.

    Attributes
    ----------
    configuration : str
        The layer's name, or its position in the stack.
    """

    configuration: str = ""

    @classmethod
    def instances(cls, settings: tuple[TubeSetting, ...]) -> list[Self]:
        """Return a place for each layer with pores."""
        names = [name for setting in settings for _, name in pore_layers(setting.stack)]
        return [cls(name) for name in dict.fromkeys(names)]


class LayerDensity(InLayer):
    """The effective density of the air in a layer's pores: its inertia and its friction at the frame."""

    name = "layer_density"
    title = "in a layer, by the density of the air in its pores"
    quantity = "change of ln density"
    passive_sign = -1

    def departs_from(self, setting: TubeSetting, frequency: RealArray) -> ComplexArray | None:
        """Return ln of the nominal density."""
        fluid = pore_fluid(setting, self.configuration, frequency)
        return None if fluid is None else np.log(fluid[0])

    def stack(self, setting: TubeSetting, stack: Stack, values: ComplexArray) -> Stack:
        """Return the stack with another density in that layer's pores."""
        return with_factors(stack, self.configuration, density=np.exp(values))


class LayerBulkModulus(InLayer):
    """The effective bulk modulus of the air in a layer's pores: compression, and heat that it gives the frame."""

    name = "layer_bulk_modulus"
    title = "in a layer, by the bulk modulus of the air in its pores"
    quantity = "change of ln bulk modulus"
    passive_sign = 1

    def departs_from(self, setting: TubeSetting, frequency: RealArray) -> ComplexArray | None:
        """Return ln of the nominal bulk modulus."""
        fluid = pore_fluid(setting, self.configuration, frequency)
        return None if fluid is None else np.log(fluid[1])

    def stack(self, setting: TubeSetting, stack: Stack, values: ComplexArray) -> Stack:
        """Return the stack with another bulk modulus in that layer's pores."""
        return with_factors(stack, self.configuration, bulk_modulus=np.exp(values))


@dataclass(frozen=True)
class LayerModulus(TubePlace):
    """Young's modulus of a layer's skeleton, by a factor exp(law), in every stack that has it; Poisson's ratio stays.

    Attributes
    ----------
    configuration : str
        The layer's name, or its position in the stack.
    """

    configuration: str = ""

    name = "layer_modulus"
    title = "in a layer, by the modulus of its skeleton"
    quantity = "change of ln E"
    detunes = True
    passive_sign = 1

    @classmethod
    def instances(cls, settings: tuple[TubeSetting, ...]) -> list[Self]:
        """Return a place for each isotropic elastic or poroelastic layer."""
        names = [name for setting in settings for _, name in elastic_layers(setting.stack)]
        return [cls(name) for name in dict.fromkeys(names)]

    def scale(self, settings: tuple[TubeSetting, ...], modulus: float) -> float:
        """Return 2: laws of standard deviation 0.6, a factor of 1.8, as laboratories differ.

        P. Bonfiglio et al., J. Sound Vib. 428 (2018) 26-43, find that moduli of frames are poorly reproducible.
        """
        return 2.0

    def departs_from(self, setting: TubeSetting, frequency: RealArray) -> ComplexArray | None:
        """Return ln of the nominal modulus."""
        modulus = skeleton_modulus(setting, self.configuration, frequency)
        return None if modulus is None else np.log(modulus)

    def stack(self, setting: TubeSetting, stack: Stack, values: ComplexArray) -> Stack:
        """Return the stack with another modulus of that layer."""
        return with_factors(stack, self.configuration, young_modulus=np.exp(values))


class TubeReading(TubePlace):
    """The microphones and where they stand: the logarithm of every reflection coefficient changes alike."""

    name = "reading"
    is_reading = True
    title = "in the reading"
    quantity = "change of ln R"
    terms: ClassVar = {0: ("change of ln gain", ""), 1: ("lead", "s")}

    def reading(self, setting: TubeSetting, reflection: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the reflection times ``exp(law)``."""
        return np.asarray(reflection * np.exp(values))


@dataclass(frozen=True)
class OneMeasurement(TubePlace):
    """One measurement that is not like the others: a bad mounting, another sample, a wrong entry.

    Attributes
    ----------
    configuration : str
        Its name.
    """

    configuration: str = ""

    name = "one_measurement"
    title = "in one measurement only"
    quantity = "change of ln R in that measurement"
    terms: ClassVar = {0: ("change of ln gain", ""), 1: ("lead", "s")}

    @classmethod
    def instances(cls, settings: tuple[TubeSetting, ...]) -> list[TubePlace]:
        """Return a place for each measurement, where there are several."""
        return [cls(setting.name) for setting in settings] if len(settings) > 1 else []

    def reading(self, setting: TubeSetting, reflection: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the reflection, which changes in this measurement."""
        return np.asarray(reflection * np.exp(values)) if setting.name == self.configuration else reflection
