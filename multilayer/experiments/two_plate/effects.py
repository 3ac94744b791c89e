"""Unmodelled effects of the two-plate rig, and where they enter the model of a configuration."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.experiments.effects import BaseEffect, Values
from multilayer.experiments.two_plate.burst import STRETCH_POWERS
from multilayer.experiments.two_plate.ratios import ConfigurationData
from multilayer.measurements.description import Campaign, Configuration
from multilayer.media.elastic import FIRST_BENDING, flexural_rigidity
from multilayer.rig.effect_base import GRAVITY
from multilayer.rig.partly_bonded import CENTRE_DEFLECTION

_CREST = (16 / 3) ** 0.5  # crest factor of a Hann burst: peak of the envelope over rms
_ORDER = 2  # of the polynomial through the bins of a burst
# roots of shares of a burst's largest strain, at which a factor that follows the strain is taken: a polynomial of the
# root through them is summed by moments of `STRETCH_POWERS`, which are multiples of 1/2
_ROOTS = 0.5 - 0.5 * np.cos(np.pi * np.arange(len(STRETCH_POWERS) + 1) / len(STRETCH_POWERS))
_FROM_ROOTS = np.linalg.inv(np.vander(_ROOTS, increasing=True))
_EXPONENTS = np.array(STRETCH_POWERS)[:, np.newaxis]
_FOURTH = 63 / 128  # mean fourth power of the amplitude of a Hann burst, as it acts at its centre; its largest is 1
_MARGIN = 1.1  # by which amplitudes may exceed those of a Hann burst with such a mean
_PLATE_LOSS = 0.01  # loss factor of the top plate's bending
CENTRED_SENSOR = "sensor in the centre, or two opposite ones"
VACUUM = "in vacuum"
MATERIAL = "sample"  # the place of what the material's own modulus has beyond its law
SOLID = ("poisson_error", "radial_stiffness")  # parameters of an effect that gives a chain another `solid`


@dataclass(frozen=True)
class Setting:
    """One configuration of a campaign, as effects see it.

    Attributes
    ----------
    campaign : Campaign
    configuration : Configuration
    data : ConfigurationData
    order : array, shape (n,)
        When the burst of each datum was measured: 0 for the first of the campaign to 1 for the last.
    """

    campaign: Campaign
    configuration: Configuration
    data: ConfigurationData
    order: RealArray

    @property
    def frequency(self) -> RealArray:
        """Frequencies of the data, Hz."""
        return self.data.frequency

    def at(self, frequency: RealArray, burst: NDArray[np.intp]) -> Setting:
        """Return the setting at other frequencies, Hz, of bursts by their indices: without what is measured at bins."""
        order = self.order[np.searchsorted(self.data.burst, burst)]
        return replace(self, data=replace(self.data, frequency=frequency, burst=burst, ends={}), order=order)

    @property
    def is_described(self) -> bool:
        """Whether the campaign has this configuration, rather than a planned one."""
        return any(self.configuration == described for described in self.campaign.configurations)

    @property
    def from_first_to_last(self) -> float:
        """Place of the configuration among all of the campaign, -1 for the first to 1 for the last; 0 of one alone."""
        names = [configuration.name for configuration in self.campaign.configurations]
        return 2 * names.index(self.configuration.name) / (len(names) - 1) - 1 if len(names) > 1 else 0.0

    @property
    def omega(self) -> RealArray:
        """Angular frequencies of the data, rad/s."""
        return 2 * np.pi * self.data.frequency

    @cached_property
    def since_mounting(self) -> RealArray:
        """Bursts measured since the sample was mounted, shape (n,): configurations follow one another.

        All that the campaign describes, in use here or not; of a configuration that is planned its own.
        """
        if not self.is_described:
            return np.unique(self.order, return_inverse=True)[1].astype(float)
        described = self.campaign.configurations
        before = sum(len(c.bursts) for c in described[: described.index(self.configuration)])
        total = sum(len(c.bursts) for c in described)
        return np.round(self.order * max(total - 1, 1)) - before

    @cached_property
    def area(self) -> float:
        """Area of the sample's face, m2."""
        return float(np.pi * self.configuration.specimen_radius**2)

    @cached_property
    def shape(self) -> float:
        """S = radius / (2 thickness) of the sample, to six digits: as many discs are solved as there are shapes."""
        return round(self.configuration.specimen_radius / (2 * self.configuration.specimen_thickness), 6)

    @cached_property
    def plate_mass(self) -> float:
        """Mass of the top plate, kg."""
        return self.campaign.top_plate.density * self.configuration.top_plate_thickness * self.area

    @cached_property
    def bending_stiffness(self) -> float:
        """Bending stiffness of the top plate, N m."""
        plate, thickness = self.campaign.top_plate, self.configuration.top_plate_thickness
        return flexural_rigidity(plate.young_modulus, plate.poisson_ratio, thickness)

    @cached_property
    def first_bending(self) -> float:
        """Frequency of the first bending mode of the top plate as a free disc, Hz."""
        per_area = self.plate_mass / self.area
        turn = FIRST_BENDING / self.configuration.specimen_radius**2
        return float(turn * np.sqrt(self.bending_stiffness / per_area) / (2 * np.pi))

    def bending_gain(self, frequency: RealArray) -> ComplexArray:
        """Return by how much that mode amplifies the static bending of the top plate at frequencies, Hz."""
        return np.asarray(1 / (1 - (frequency / self.first_bending) ** 2 + 1j * _PLATE_LOSS))

    def bending_compliance(self, frequency: RealArray) -> ComplexArray:
        """Return the unit of `partly_bonded.deflection`, ``R^2 / (8 pi D)``, with that gain, m/N."""
        static = self.configuration.specimen_radius**2 / (8 * np.pi * self.bending_stiffness)
        return np.asarray(static * self.bending_gain(frequency))

    def at_centre(self, dynamic_mass: Numeric, share: Numeric) -> tuple[ComplexArray, ComplexArray]:
        """Return what a thing in the centre of the top plate does, which bends the plate.

        Its force moves the centre by C beyond the plate's mean, so that the centre, and with it the thing and the
        accelerometer, follows the mean by ``1/(1 - omega^2 mu C)``; C is that of a force on a free plate whose inertia
        is spread over its area (`partly_bonded.deflection`), amplified by the first bending mode. The sample must be
        soft beside the plate: its modulus over its height, beside 81 D/R^4, is the share of C that is lacking then.

        Parameters
        ----------
        dynamic_mass : array, shape (..., n)
            mu, force over acceleration, kg.
        share : float or array
            Of C: below 1 for a thing with a footprint.

        Returns
        -------
        array, array, shape (..., n)
            The dynamic mass on a rigid plate that acts alike, kg, and the motion of the centre over the mean.
        """
        compliance = CENTRE_DEFLECTION * self.bending_compliance(self.frequency)
        bent = share * self.omega**2 * dynamic_mass * compliance
        return np.asarray(dynamic_mass / (1 - bent)), np.asarray(1 / (1 - bent))

    @cached_property
    def strain_nodes(self) -> RealArray:
        """Amplitudes of strain in each burst at which `by_strain` takes a factor, shape (n_bursts, k)."""
        return self._largest_strain[:, np.newaxis] * _ROOTS**2

    def by_strain(self, factor: RealArray | ComplexArray) -> ComplexArray:
        """Return what a factor on the stress does to each bin that follows the amplitude of the strain at once.

        From the channels, at the level of the campaign; where these are not given, those of a steady tone with the peak
        amplitude of a Hann burst. The factor is a polynomial of the amplitude's root: one that falls to a third, as
        ``1 / (1 + a)``, is met to 1e-4, and so are powers of 0.7 and more.

        Parameters
        ----------
        factor : array, shape (..., n_bursts, k)
            At `strain_nodes`.

        Returns
        -------
        complex array, shape (..., n)
        """
        return np.asarray(np.sum(factor[..., self.data.burst, :] * self._of_nodes, axis=-1))

    @cached_property
    def _of_nodes(self) -> ComplexArray:
        """Weights of a factor at the `strain_nodes` at each bin, shape (n, k)."""
        moments = self._strain_moments / self._largest_strain[self.data.burst] ** _EXPONENTS
        return np.asarray(np.concatenate([np.ones((1, moments.shape[1])), moments]).T @ _FROM_ROOTS)

    @cached_property
    def _largest_strain(self) -> RealArray:
        """Largest amplitude of strain in each burst, shape (n_bursts,), from the fourth moment nearest its centre."""
        fourth = np.abs(self._strain_moments[STRETCH_POWERS.index(4.0)])
        return np.asarray(_MARGIN * (fourth[self.nearest] / _FOURTH) ** 0.25)

    @cached_property
    def nearest(self) -> NDArray[np.intp]:
        """The bin nearest the centre of each burst, shape (n_bursts,)."""
        away = np.abs(self.frequency - self.data.centres[:, np.newaxis])
        others = self.data.burst != np.arange(len(away))[:, np.newaxis]
        return np.asarray(np.argmin(np.where(others, np.inf, away), axis=1))

    @cached_property
    def _strain_moments(self) -> ComplexArray:
        """Means of the powers `STRETCH_POWERS` of the strain's amplitude as they act on each bin, shape (k, n)."""
        if self.data.stretch_moments is not None:
            moments = self.data.stretch_moments
        else:
            centre = self.data.centres[self.data.burst]
            stretch = np.abs(self.data.ratio - 1) * self._peak_base / (2 * np.pi * centre) ** 2
            moments = stretch.astype(complex) ** _EXPONENTS
        return np.asarray(moments / self.configuration.specimen_thickness**_EXPONENTS)

    @cached_property
    def burst_strain(self) -> RealArray:
        """Strain amplitude of a steady tone at the burst's centre, with the burst's peak amplitude, shape (n,)."""
        ratios = [self._ratio_at(index) for index in range(len(self.data.centres))]
        stretch = np.abs(np.array(ratios) - 1) * self._peak_base / (2 * np.pi * self.data.centres) ** 2
        return np.asarray(stretch[self.data.burst] / self.configuration.specimen_thickness)

    def _ratio_at(self, burst: int) -> complex:
        """Return the measured ratio at the centre of a burst, between its bins.

        Its reciprocal, ``cos kh - m kh sin kh`` of a rod, has no resonance: a parabola through the bins of a burst
        differs from one of the third order by 0.1 % of the strain, where straight lines between the logarithms of the
        ratio miss 6 % at a resonance.
        """
        bins = self.data.burst == burst
        centre, inverse = self.data.centres[burst], 1 / self.data.ratio[bins]
        away = (self.frequency[bins] - centre) / centre
        return complex(1 / np.polyfit(away, inverse, min(_ORDER, len(away) - 1))[-1])

    @property
    def _peak_base(self) -> float:
        """Peak acceleration of the base, m/s2."""
        return self.campaign.burst.level_rms * float(_CREST)

    @cached_property
    def static_stress(self) -> float:
        """Weight of the top plate over the sample's face, Pa."""
        return GRAVITY * self.plate_mass / self.area


@dataclass(frozen=True)
class OpenRim:
    """A rim of the sample's faces that is not bonded.

    Attributes
    ----------
    width : array
        As a share of the radius.
    at_base : array
        Where it is open: 0 at the upper face, 1 at both, 2 at the lower face, or a value between.
    depth : array or None
        What is worn away of it at the upper face, as a share of the height.
    gain : complex array, shape (..., n), or None
        Factor on what it changes of the forces on the plates; 1 where left out.
    """

    width: RealArray
    at_base: RealArray
    depth: RealArray | None = None
    gain: ComplexArray | None = None


@dataclass(frozen=True)
class Chain:
    """The rig in plane motion: rods from base to top, masses, and parallel paths.

    Attributes
    ----------
    modulus : complex array
        Young's modulus of the sample, Pa.
    density, thickness : array
        Of the sample, kg/m3 and m.
    plate_mass : array
        kg.
    compliances : tuple of complex array or None
        Per area, of what is between sample and plates at the lower face and at the upper one, m/Pa.
    glue_mass : array
        Mass per area of what is at each face, kg/m2.
    skin : tuple of array or None
        Thickness (m) of a layer at each face, and its modulus over that of the core.
    spring : complex array or None
        Stiffness of a path parallel to the sample, N/m.
    resistivity : array or None
        Flow resistivity of the sample's pores, N s/m4.
    open_rim : OpenRim or None
    solid : tuple of array or None
        Relative error of the stated Poisson's ratio, and E_r/E_z, of a disc with a free rim; the modulus is times its
        static stiffness over that of the stated one.
    """

    modulus: ComplexArray
    density: Numeric
    thickness: Numeric
    plate_mass: Numeric
    compliances: tuple[Numeric, Numeric] | None = None
    glue_mass: Numeric = 0.0
    skin: tuple[Numeric, Numeric] | None = None
    spring: Numeric | None = None
    resistivity: Numeric | None = None
    open_rim: OpenRim | None = None
    solid: tuple[RealArray, RealArray] | None = None

    def with_(self, **changes: object) -> Chain:
        """Return a chain with other values."""
        return replace(self, **changes)  # type: ignore[arg-type]

    def glued(self, stiffness: Numeric, mass: Numeric = 0.0) -> Chain:
        """Return a chain with a further layer at each face: its stiffness, Pa/m, and mass, kg/m2, per area."""
        softer = self.softer_at(lower=1 / stiffness, upper=1 / stiffness)
        return replace(softer, glue_mass=self.glue_mass + mass)

    def softer_at(self, *, lower: Numeric = 0.0, upper: Numeric = 0.0) -> Chain:
        """Return a chain with a further compliance per area, m/Pa, at the sample's lower and at its upper face."""
        before = self.compliances or (0.0, 0.0)
        return replace(self, compliances=(before[0] + lower, before[1] + upper))


class Effect(BaseEffect):
    """An unmodelled effect of the two-plate rig; subclass it and override what it changes.

    The model of a datum is computed in this order: the law's modulus (`modulus`), the rods and masses (`chain`), the
    motion of the top plate over the base (`motion`). Every hook returns its argument where the effect does not act.

    Attributes
    ----------
    moves_resonances : bool
        Whether it acts as a change of the sample's modulus does, rather than on the reading.
    place : str
        Name of a `places.Place` of the rig.
    absent_in : str
        ``CENTRED_SENSOR`` or ``VACUUM``.
    """

    kind = "two-plate rig"
    law_error = 0.1  # seeds 1008, 1009: 52 right names fit as with 0.15, of 20 wrong ones 5 more do not
    size_error = 0.15
    moves_resonances: ClassVar[bool] = False

    def applies(self, campaign: Campaign) -> bool:
        """Tell whether the effect can act in a campaign at all."""
        return True

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """Return the sample's modulus, Pa, shape (..., n)."""
        return modulus

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """Return the rods and masses."""
        return chain

    def motion(self, setting: Setting, motion: ComplexArray, values: Values) -> ComplexArray:
        """Return top over base as the channels show it, shape (..., n)."""
        return motion
