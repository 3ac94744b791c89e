"""Places in the sample: its modulus, and what that depends on besides frequency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from multilayer.diagnosis.places.base import ComplexArray, Place, Setting
from multilayer.experiments.two_plate.motion import constrained_modulus_ratio
from multilayer.rig.shape_factor import static_shape_factor

_POISSON_RATIO = 0.3  # where none is stated: how a free rim acts on shapes depends little on it
_RESOLUTION = 0.5  # of the mesh


class Sample(Place):
    """The sample of all configurations: the modulus departs from the nominal law."""

    name = "sample"
    title = "in the sample"
    quantity = "change of ln E"
    usual_factor = 0.0

    def factor(self, setting: Setting) -> Any:
        """Return what the law is multiplied by in a configuration: ln E per law."""
        return 1.0

    def scale(self, settings: tuple[Setting, ...], modulus: float) -> float:
        """Return the law that changes ln E by 1 where the factor is largest."""
        factors: list[float] = [float(np.max(np.abs(self.factor(setting)))) for setting in settings]
        return 1 / max(factors)

    def modulus(self, setting: Setting, modulus: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the modulus times ``exp(law factor)``."""
        return np.asarray(modulus * np.exp(values * self.factor(setting)))


class SampleLoad(Sample):
    """The sample under load: ln E changes in proportion to the static stress."""

    name = "sample_load"
    title = "in the sample, by its load"
    quantity = "change of ln E per static stress"
    unit = "1/Pa"
    differs_already = True

    def factor(self, setting: Setting) -> Any:
        """Return the static stress, Pa."""
        return setting.static_stress


class SampleStrain(Sample):
    """The sample under strain: E becomes ``E / (1 - v e)``, v the law and e the amplitude of the dynamic strain.

    The modulus is the same throughout a burst, as of filled rubbers.
    """

    name = "sample_strain"
    title = "in the sample, by its dynamic strain"
    quantity = "change of ln E per strain"
    acts_by_bin = True
    differs_already = True

    @classmethod
    def variants(cls) -> tuple[type[SampleStrain], ...]:
        """Return both kinds of softening."""
        return (SampleStrain, SampleStrainAtOnce)

    def factor(self, setting: Setting) -> Any:
        """Return the amplitude of the burst's strain."""
        return setting.burst_strain

    def modulus(self, setting: Setting, modulus: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the modulus at that strain."""
        return np.asarray(modulus / (1 - values * self.factor(setting)))


class SampleStrainAtOnce(SampleStrain):
    """The sample under strain, its modulus following the strain at once."""

    variant = "at_once"

    def factor(self, setting: Setting) -> Any:
        """Return the amplitude of the strain as it acts on each bin."""
        return setting.by_strain(setting.strain_nodes)


class SampleOrder(Sample):
    """The sample over time: ln E changes from the first recording to the last."""

    name = "sample_order"
    title = "in the sample, in the order of measurement"
    quantity = "change of ln E from first to last recording"
    differs_already = True

    @classmethod
    def variants(cls) -> tuple[type[SampleOrder], ...]:
        """Return what goes on throughout, and what begins anew with each mounting."""
        return (SampleOrder, SampleOrderInMounting)

    @classmethod
    def instances(cls, settings: tuple[Setting, ...]) -> list[Place]:
        """Return the places, if there is an order: one recording alone has none."""
        places = super().instances(settings)
        return [place for place in places if any(np.any(place.factor(setting)) for setting in settings)]

    def factor(self, setting: Setting) -> Any:
        """Return the place in the order, 0 to 1."""
        return setting.order


class SampleOrderInMounting(SampleOrder):
    """The sample over time since its mounting: ln E changes in proportion to ``ln(1 + k)``, k the bursts since then.

    As a sample creeps under the weight of its plate, or recovers from being glued.
    """

    variant = "since_mounting"
    title = "in the sample, by the time since its mounting"
    quantity = "change of ln E per logarithm of the bursts since its mounting"

    def factor(self, setting: Setting) -> Any:
        """Return ``ln(1 + k)``."""
        return np.log1p(setting.since_mounting)


@dataclass(frozen=True)
class SampleShape(Sample):
    """The sample's free rim: ln E changes as a glued disc of that shape is softer than one that is held at its rim.

    The factor is ``ln g(nu, S)/g(nu, infinity)`` of slow compression, negative; see `rig.shape_factor`.

    Attributes
    ----------
    needs_finite_elements : bool
        Whether the rim is free in finite elements, and the law what is left beyond these.
    """

    needs_finite_elements: bool = False

    name = "sample_shape"
    title = "in the sample, by its shape"
    quantity = "change of ln E by a free rim, over that of slow compression"
    differs_already = True
    terms: ClassVar = {0: ("change of ln E over that by a free rim in slow compression", "")}

    @property
    def modelled(self) -> str:
        """With finite elements a free rim."""
        return "a free rim of the sample" if self.needs_finite_elements else ""

    def factor(self, setting: Setting) -> Any:
        """Return what a free rim does to ln E."""
        ratio = setting.campaign.specimen.poisson_ratio
        ratio = ratio if ratio > 0 else _POISSON_RATIO
        shape = setting.configuration.specimen_radius / (2 * setting.configuration.specimen_thickness)
        free = static_shape_factor(ratio, round(shape, 6), resolution=_RESOLUTION)
        return float(np.log(free / constrained_modulus_ratio(ratio)))


class SampleRadius(Sample):
    """The sample's radius: ln E changes in proportion to its square, as by what flows to the rim."""

    name = "sample_radius"
    title = "in the sample, by its radius"
    quantity = "change of ln E per squared radius"
    unit = "1/m2"
    differs_already = True

    def factor(self, setting: Setting) -> Any:
        """Return the squared radius, m2."""
        return setting.configuration.specimen_radius**2
