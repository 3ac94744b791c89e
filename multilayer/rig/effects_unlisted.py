"""Effects that no table lists: whoever diagnoses a campaign made with one of these should say "unknown"."""
# ruff: noqa: D102 -- the hooks are documented once, on the base class

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field
from scipy.interpolate import make_interp_spline

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.effect_base import Effect, Geometry, Mistake, Moment, Mounting, Surroundings, above_zero
from multilayer.rig.effects_reading import resonance
from multilayer.rig.specimen import Factors, SpecimenSettings
from multilayer.signals.spectra import padded_length, to_signal, to_spectrum
from multilayer.units import DIMENSIONLESS, Unit

_OVERSAMPLING = 8


class ClockSkew(Effect):
    """The top channel's converter has a clock of its own, too fast by `skew`: top(t (1 + skew)), t from the trigger.

    The delay thus grows over each record. Perturbed: top(t (1 + skew) + p skew t^2 / 0.1 s), a clock that drifts.
    """

    effect: Literal["clock_skew"] = "clock_skew"
    skew: Annotated[float, Field(ge=-0.01, le=0.01), Unit(DIMENSIONLESS)] = 200e-6

    known: ClassVar[bool] = False

    def apply_to_signals(
        self, base: RealArray, top: RealArray, sampling_rate: float, moment: Moment
    ) -> tuple[RealArray, RealArray]:
        time = np.arange(top.size) / sampling_rate
        read_at = time * (1 + self.skew * (1 + self.perturbation * time / 0.1))
        return base, resampled(top, read_at * sampling_rate)


def resampled(signal: RealArray, index: RealArray) -> RealArray:
    """Return a band-limited signal at fractional indices; 0 beyond its ends.

    It is padded with zeros, oversampled by its Fourier series, and read by splines of fifth order.
    """
    n_fft = padded_length(signal.size)
    dense = _OVERSAMPLING * to_signal(to_spectrum(signal, n_fft), _OVERSAMPLING * n_fft, _OVERSAMPLING * signal.size)
    spline = make_interp_spline(np.arange(dense.size) / _OVERSAMPLING, dense, k=5)
    inside = (index >= 0) & (index <= signal.size - 1)
    return np.asarray(np.where(inside, spline(np.clip(index, 0, signal.size - 1)), 0.0))


class CableResonance(Effect):
    """The accelerometer's cable swings and takes the motion away about its own frequency, a notch of a certain depth.

    T (f0^2 - f^2 + i (1 - d) eta f0 f) / (f0^2 - f^2 + i eta f0 f): T (1 - d) at f0. Perturbed: f0 is (1 + p k) times
    as high in configuration k, k from 0 to 1: the cable hangs otherwise after each mounting.
    """

    effect: Literal["cable_resonance"] = "cable_resonance"
    frequency: Annotated[float, Field(ge=10, le=20e3), Unit("Hz")] = 350.0
    loss_factor: Annotated[float, Field(gt=0, le=2), Unit(DIMENSIONLESS)] = 0.3
    depth: Annotated[float, Field(ge=0, le=1), Unit(DIMENSIONLESS)] = 0.1

    known: ClassVar[bool] = False

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        own = self.frequency * (1 + self.perturbation * mounting.index / max(mounting.count - 1, 1))
        undamped, loss = own**2 - frequency**2, 1j * self.loss_factor * own * frequency
        return np.asarray(ratio * (undamped + (1 - self.depth) * loss) / (undamped + loss))


class BaseTilt(Effect):
    """The base plate tilts about its own resonance, and its accelerometer, off the axis, reads the tilt too.

    T / (1 + s f^2 / (f0^2 - f^2 + i eta f0 f)). Perturbed: s (f / f0)^p.
    """

    effect: Literal["base_tilt"] = "base_tilt"
    share: Annotated[float, Field(ge=-0.5, le=0.5), Unit(DIMENSIONLESS)] = 0.02
    frequency: Annotated[float, Field(ge=10, le=20e3), Unit("Hz")] = 900.0
    loss_factor: Annotated[float, Field(gt=0, le=2), Unit(DIMENSIONLESS)] = 0.1

    known: ClassVar[bool] = False

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        share = self.share * (above_zero(frequency) / self.frequency) ** self.perturbation
        return np.asarray(ratio / (1 + share * resonance(frequency, self.frequency, self.loss_factor)))


class Creep(Effect):
    """The sample settles after each mounting: E (1 + c ln(1 + k)), k the bursts since then.

    Perturbed: k^(1 + p).
    """

    effect: Literal["creep"] = "creep"
    rate: Annotated[float, Field(ge=-0.2, le=0.2), Unit(DIMENSIONLESS)] = 0.02

    known: ClassVar[bool] = False
    varies: ClassVar[bool] = True

    def apply_to_modulus(self, frequency: RealArray, modulus: ComplexArray, moment: Moment) -> ComplexArray:
        return np.asarray(modulus * (1 + self.rate * np.log1p(moment.since_mounting ** (1 + self.perturbation))))


class Grading(Effect):
    """The modulus varies over the thickness: factors, evenly spaced from base to top, linear between.

    Left out, they are those of ``specimen.grading``, or else 0.8 at the base and 1.2 at the top. Perturbed: factors to
    the power 1 + p.
    """

    effect: Literal["grading"] = "grading"
    factors: Factors | None = None

    known: ClassVar[bool] = False

    def parameters(self, specimen: SpecimenSettings) -> dict[str, Any]:
        return {"factors": list(self.factors or specimen.grading or (0.8, 1.2))}

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        factors = [factor ** (1 + self.perturbation) for factor in self.parameters(specimen)["factors"]]
        return {**geometry, "modulus_profile": tuple(factors)}


class Anisotropy(Effect):
    """The sample is stiffer or softer across than along its axis, by E_r/E_z; it shows through Poisson's ratio only.

    Left out, the ratio is that of the specimen, or else 0.6. Perturbed: the shear modulus too is (1 + p) times as high.
    """

    effect: Literal["anisotropy"] = "anisotropy"
    transverse_ratio: Annotated[float, Field(gt=0, le=100), Unit(DIMENSIONLESS)] | None = None

    known: ClassVar[bool] = False

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        if "finite_size" not in around.effects:
            text = "anisotropy shows through Poisson's ratio only; list {effect: finite_size} too"
            yield ("effect",), text, None

    def parameters(self, specimen: SpecimenSettings) -> dict[str, Any]:
        return {"transverse_ratio": self.transverse_ratio or specimen.transverse_ratio or 0.6}

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        ratio = self.parameters(specimen)["transverse_ratio"] * geometry.get("transverse_ratio", 1.0)
        return {**geometry, "transverse_ratio": ratio, "shear_ratio": 1 + self.perturbation}
