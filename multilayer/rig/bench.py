"""One configuration on the virtual rig: its geometry, its response, and what the channels do to the signals."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from multilayer.arrays import BoolArray, ComplexArray, RealArray
from multilayer.errors import InputError, MultilayerError, Problem
from multilayer.media.elastic import FIRST_BENDING
from multilayer.rig.draws import Errors
from multilayer.rig.effect_base import Geometry, Moment, Mounting
from multilayer.rig.excitation import Timing
from multilayer.rig.file import RigFile
from multilayer.rig.specimen import TopPlateSettings
from multilayer.signals.spectra import frequencies

_RIGID_ABOVE = 50e3  # Hz: first bending mode of a plate that counts as rigid; ten times that of 1 mm of steel


@dataclass(frozen=True)
class Bench:
    """A configuration with its errors and effects.

    Attributes
    ----------
    settings : RigFile
    errors : Errors
    mounting : Mounting
    """

    settings: RigFile
    errors: Errors
    mounting: Mounting

    @cached_property
    def timing(self) -> Timing:
        """How the bursts are sampled."""
        return self.settings.timing(self.mounting)

    @cached_property
    def bins(self) -> RealArray:
        """Frequencies of the spectra, Hz, from 0."""
        return frequencies(self.timing.n_fft, self.settings.sampling_rate)

    @cached_property
    def geometry(self) -> Geometry:
        """What stands on the rig, the effects included; see `effect_base.Geometry`."""
        geometry = self._plain_geometry()
        for effect in self.settings.effects:
            geometry = effect.apply_to_geometry(geometry, self.mounting, self.settings.specimen)
        return geometry

    def _plain_geometry(self) -> Geometry:
        settings, mounting, errors = self.settings, self.mounting, self.errors
        plate, base = settings.top_plate, settings.base_plate
        elastic = {
            "base_thickness": base.thickness,
            "base_density": base.density,
            "base_modulus": base.young_modulus,
            "base_poisson_ratio": base.poisson_ratio,
        }
        return {
            "radius": mounting.radius,
            "thickness": mounting.thickness + errors.thickness[mounting.thickness],
            "density": settings.specimen.density * (1 + errors.density),
            "poisson_ratio": 0.0,
            "plate_thickness": mounting.top_plate,
            "plate_density": plate.density * (1 + errors.top_plate_mass[mounting.top_plate]),
            "plate_modulus": _rigid(plate, mounting),
            "real_plate_modulus": plate.young_modulus,
            "plate_poisson_ratio": plate.poisson_ratio,
            "resolution": settings.resolution,
            **(elastic if base.elastic else {}),
        }

    def moment(self, frequency: float, repeat: int) -> Moment:
        """Return where and when a burst is recorded.

        Bursts follow each other, each with all its repeats; a sample that is remounted for each repeat goes through
        all its bursts in between.
        """
        n, repeats = len(self.mounting.frequencies), self.settings.repeats
        burst = self.mounting.frequencies.index(frequency)
        remounted = self.settings.remount is not None
        elapsed = (repeat * n + burst) / repeats if remounted else burst + repeat / repeats
        since = float(burst) if remounted else elapsed
        before, total = self.mounting.index * n, float(self.mounting.count * n)
        return Moment(self.mounting, self.geometry, frequency, repeat, before + elapsed, total, since)

    def modulus(self, frequency: RealArray, moment: Moment) -> ComplexArray:
        """Return the sample's modulus at a moment, Pa, at frequencies, Hz, above 0."""
        modulus = self.settings.specimen.modulus(frequency)
        for effect in self.settings.effects:
            modulus = effect.apply_to_modulus(frequency, modulus, moment)
        return modulus * (1 + self.errors.repeat_stiffness[self.mounting.name][moment.repeat])

    @property
    def varies(self) -> bool:
        """Whether the modulus differs from recording to recording."""
        remount = self.settings.remount
        return any(e.varies for e in self.settings.effects) or (remount is not None and remount.stiffness > 0)

    def response(self, moment: Moment) -> ComplexArray:
        """Return top over base motion at the bins, before the channels change it.

        Beyond the band of the bursts, where they have no energy, it is continued as the response of a mass on a spring.
        """
        inside = self._inside(moment)
        f, known = self.bins[inside], self._known[self._key(moment)]
        below, above = self.bins < f[0], self.bins > f[-1]
        ratio = np.empty(self.bins.shape, dtype=complex)
        ratio[inside] = known
        ratio[below] = 1 + (known[0] - 1) * (self.bins[below] / f[0]) ** 2
        ratio[above] = known[-1] * (f[-1] / self.bins[above]) ** 2
        return ratio

    def _key(self, moment: Moment) -> tuple[float, int] | None:
        return (moment.frequency, moment.repeat) if self.varies else None

    def _inside(self, moment: Moment) -> BoolArray:
        low, high = self.timing.band((moment.frequency,) if self.varies else self.mounting.frequencies)
        return np.asarray((self.bins >= low) & (self.bins <= high) & (self.bins > 0))

    @cached_property
    def _known(self) -> dict[tuple[float, int] | None, ComplexArray]:
        """The transmissibility within the bands, computed in one call, which the reduced basis makes fast."""
        repeats = range(self.settings.repeats)
        moments = [self.moment(f, repeat) for f in self.mounting.frequencies for repeat in repeats]
        distinct = {self._key(moment): moment for moment in moments}
        f = [self.bins[self._inside(moment)] for moment in distinct.values()]
        moduli = [self.modulus(at, moment) for at, moment in zip(f, distinct.values(), strict=True)]
        ratios = self._transmissibility(np.concatenate(f), np.concatenate(moduli))
        ends = np.cumsum([len(at) for at in f])[:-1]
        return dict(zip(distinct, np.split(ratios, ends), strict=True))

    def _transmissibility(self, frequency: RealArray, modulus: ComplexArray) -> ComplexArray:
        from multilayer.rig.two_plate import TwoPlateRig  # heavy: SciPy's and scikit-fem's meshes

        arguments: dict[str, Any] = {k: v for k, v in self.geometry.items() if k != "real_plate_modulus"}
        try:
            return TwoPlateRig(**arguments).transmissibility(frequency, modulus)
        except MultilayerError as error:
            reasons = error.problems if isinstance(error, InputError) else [error]
            problems = [
                Problem(f"configuration '{self.mounting.name}': {reason}", "configurations") for reason in reasons
            ]
            raise InputError(problems) from None

    def chain(self, repeat: int) -> tuple[ComplexArray, ComplexArray]:
        """Return the factors of top and of base motion in the top channel's signal, at the bins, in one repeat."""
        offset = self._shown(np.zeros(self.bins.shape, dtype=complex))
        factor = self._shown(np.ones(self.bins.shape, dtype=complex)) - offset
        errors, name = self.errors, self.mounting.name
        gain = (1 + errors.channel_gain) * (1 + errors.remount_gain[name]) * (1 + errors.repeat_gain[name][repeat])
        drawn = gain * np.exp(-2j * np.pi * self.bins * errors.channel_delay)
        return factor * drawn, offset * drawn

    def _shown(self, ratio: ComplexArray) -> ComplexArray:
        for effect in self.settings.effects:
            ratio = effect.apply_to_response(self.bins, ratio, self.mounting)
        return ratio


def _rigid(plate: TopPlateSettings, mounting: Mounting) -> float:
    return rigid_modulus(mounting.radius, mounting.top_plate, plate.density, plate.young_modulus, plate.poisson_ratio)


def rigid_modulus(radius: float, thickness: float, density: float, modulus: float, poisson_ratio: float) -> float:
    """Return the modulus, Pa, of a top plate that is to act as rigid: the given one, or more.

    The first axisymmetric mode of a free disc, ``9.003 / (2 pi R^2) sqrt(D / (rho h))`` (A. W. Leissa, Vibration of
    Plates, NASA SP-160, 1969, chapter 2), is raised to 50 kHz at least. Much stiffer plates would make the finite
    elements' equations badly conditioned; with this modulus the transmissibility of a rod is met to 4e-5.

    Parameters
    ----------
    radius, thickness, density, modulus, poisson_ratio : float
        Of the plate, SI.
    """
    bending = density * thickness * (2 * np.pi * radius**2 * _RIGID_ABOVE / FIRST_BENDING) ** 2
    return float(max(modulus, 12 * (1 - poisson_ratio**2) / thickness**3 * bending))
