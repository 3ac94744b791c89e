"""Nuisance parameters: the uncertainties that a laboratory states of its rig and of its channels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.experiments.two_plate.ratios import ConfigurationData
from multilayer.inference.priors import Parameter, Prior
from multilayer.measurements.description import FILE_NAME, USUAL_UNCERTAINTY, Campaign, Configuration, Uncertainty

_MISTAKE = 0.2  # relative standard deviation of what is stated wrongly
_UNITS = {"channel_delay": "s", "thickness": "m"}  # of uncertainties; the others are relative


@dataclass(frozen=True)
class RigChange:
    """How a rig differs from its description: density and plate mass relative, thickness in m."""

    density: RealArray
    thickness: RealArray
    plate_mass: RealArray

    @property
    def parts(self) -> tuple[RealArray, RealArray, RealArray]:
        """Density, thickness, plate mass."""
        return self.density, self.thickness, self.plate_mass


@dataclass(frozen=True)
class Nuisances:
    """The laboratory's stated uncertainties as parameters, and what they do to ln(ratio).

    What is measured piece by piece has an error for each piece: `samples` and `top_plates`.

    Attributes
    ----------
    known : Uncertainty
    configurations : tuple of Configuration
        Those whose pieces are uncertain.
    unstated : str
        Name of a parameter of which what is stated does not count: it may be a mistake.
    """

    known: Uncertainty
    configurations: tuple[Configuration, ...]
    unstated: str = ""

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Gain and delay of the channels, density, mass of each plate, each height, gain of each remounting."""
        known = self.known
        named = {
            "channel_gain": known.channel_gain,
            "channel_delay": known.channel_delay,
            "density": known.density,
        }
        named |= dict.fromkeys(sorted({*self.top_plates.values()}), known.top_plate_mass)
        named |= dict.fromkeys(sorted({*self.samples.values()}), known.thickness)
        named |= {f"remount_gain[{c.name}]": known.remount_gain for c in self.configurations}
        if self.unstated:
            named[self.unstated] = _MISTAKE * self._heights.get(self.unstated, 1.0)
        return tuple(
            Parameter(
                name=name, prior=Prior(normal=(0.0, spread)), unit=_UNITS.get(name.split("[")[0], ""), nuisance=True
            )
            for name, spread in named.items()
            if spread > 0
        )

    @property
    def of_pieces(self) -> tuple[str, ...]:
        """Names of the parameters of density, heights and masses."""
        names = {"density", *self.samples.values(), *self.top_plates.values()}
        return tuple(parameter.name for parameter in self.parameters if parameter.name in names)

    @property
    def _heights(self) -> dict[str, float]:
        """The height of each sample, m, by the name of its parameter."""
        return {self.samples[c.name]: c.specimen_thickness for c in self.configurations}

    @cached_property
    def samples(self) -> dict[str, str]:
        """The stated height of the sample in each configuration, as parameters have it: those alike are one sample."""
        return self._pieces("thickness", [c.specimen_thickness for c in self.configurations])

    @cached_property
    def top_plates(self) -> dict[str, str]:
        """The stated mass of the top plate in each configuration, as parameters have it: those alike are one plate."""
        return self._pieces("top_plate_mass", [c.top_plate_thickness for c in self.configurations])

    def _pieces(self, quantity: str, thicknesses: Sequence[float]) -> dict[str, str]:
        """Return the piece in each configuration; of another radius it is another, which its name then says."""
        names: dict[str, str] = {}
        radii: dict[float, float] = {}
        for configuration, thickness in zip(self.configurations, thicknesses, strict=True):
            radius = configuration.specimen_radius
            usual = radii.setdefault(thickness, radius)
            of_radius = "" if radius == usual else f", radius {radius:g}"
            names[configuration.name] = f"{quantity}[{thickness:g}{of_radius}]"
        return names

    def of_rig(self, values: Mapping[str, RealArray], data: ConfigurationData) -> RigChange:
        """Return the changes of the rig in one configuration."""
        names = ("density", self.samples[data.name], self.top_plates[data.name])
        return RigChange(*(values.get(name, np.zeros(())) for name in names))

    def of_channels(self, values: Mapping[str, RealArray], data: ConfigurationData) -> ComplexArray:
        """Return what errors of the channels add to ln(ratio), shape (..., n)."""
        zero = np.zeros(())
        gain = values.get("channel_gain", zero) + values.get(f"remount_gain[{data.name}]", zero)
        delay = values.get("channel_delay", zero)
        return np.asarray(gain[..., None] - 2j * np.pi * data.frequency * delay[..., None])


def with_usual_uncertainty(campaign: Campaign) -> tuple[Campaign, list[str]]:
    """Return a campaign that states all uncertainties, and warnings of what it did not state: that is taken as usual.

    Nobody knows gains, heights and masses exactly: taken as exact, their errors would be told as a gap of the model.
    """
    usual = {name: getattr(USUAL_UNCERTAINTY, name) for name in campaign.uncertainty.unstated}
    if not usual:
        return campaign, []
    stated = Uncertainty(**(campaign.uncertainty.model_dump() | usual))
    values = ", ".join(f"{name} {value:g} {_UNITS.get(name, '')}".rstrip() for name, value in usual.items())
    text = f"{FILE_NAME}: uncertainty: not stated, so taken as usual of a careful laboratory: {values}"
    remedy = "state what yours is, 0 where a value is exact"
    return campaign.model_copy(update={"uncertainty": stated}), [f"{text}; {remedy}"]
