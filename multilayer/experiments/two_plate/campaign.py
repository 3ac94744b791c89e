"""All bursts of a campaign as one problem: one causal modulus law, and the stated uncertainties of the rig.

With E1 and E2 free at every burst a model absorbs almost any unmodelled effect. One law for all bursts and
configurations does not: effects that it cannot explain show in the residuals.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import BoolArray, ComplexArray, IndexArray, RealArray, distinct_rows, half_turn, logarithm
from multilayer.experiments.effects import BaseEffect, Values
from multilayer.experiments.hypothesis import Hypothesis, Part, parameters_of, values_of
from multilayer.experiments.places import DrawnLaw, LawAtPlace
from multilayer.experiments.two_plate.effects import MATERIAL, Chain, Effect, Setting
from multilayer.experiments.two_plate.law_deviation import LawDeviation
from multilayer.experiments.two_plate.modulus_at import AmountAt, ModulusAt
from multilayer.experiments.two_plate.motion import Neighbourhood, top_over_base
from multilayer.experiments.two_plate.nuisances import Nuisances
from multilayer.experiments.two_plate.plane_waves import Rig
from multilayer.experiments.two_plate.ratios import ConfigurationData
from multilayer.inference.derivative import Stencil
from multilayer.inference.priors import Parameter, Prior, Priors
from multilayer.inference.problem import Experiment, Points
from multilayer.inference.reparameterisation import Reparameterisation
from multilayer.inference.whitening import Whitening
from multilayer.measurements.description import Campaign, Uncertainty
from multilayer.media.laws.parameters import LawSpace
from multilayer.units import DB_PER_NEPER

Acting: TypeAlias = Effect | LawAtPlace
MODEL_ERROR = 0.002  # relative standard deviation, of solvers and of the plates' idealisation
_DENSITY_STEP = 0.01
_TINY = 1e-200  # added to motions: the logarithm of one that underflows stays finite
_STEP = 1e-3  # of ln E
_THINNED = 3  # one in so many bins of a burst is used in a first search
_FAR_OFF = 50.0  # of ln(ratio)
# what a problem computes once, the same with any effects
_WITHOUT_EFFECTS = ("nuisances", "material", "given_parameters", "nominal_parameters", "_settings", "_near", "_middle")


@dataclass(frozen=True, eq=False)
class Material:
    """The sample's modulus: a law, and how far the material departs from it.

    Attributes
    ----------
    space : LawSpace
        The law's parameters; its coordinates are uniform within the space's box.
    deviation : LawDeviation, optional
        None when left out.
    """

    space: LawSpace
    deviation: LawDeviation | None = None

    @cached_property
    def law_parameters(self) -> tuple[Parameter, ...]:
        """Natural logarithms of the law's unknowns, or of their products; `LawSpace.coordinates`."""
        boxes = zip(self.space.coordinates, self.space.low, self.space.high, strict=True)
        return tuple(
            Parameter(name=f"ln {name}", prior=Prior(uniform=(float(low), float(high)))) for name, low, high in boxes
        )

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Law, then its deviation."""
        return self.law_parameters + (() if self.deviation is None else self.deviation.parameters)

    @cached_property
    def _priors(self) -> Priors:
        return Priors.of(self.law_parameters)

    def reparameterisation(self, z: RealArray, frequency: float, *, far: bool) -> Reparameterisation | None:
        """Return `ModulusAt` a frequency, Hz, or `AmountAt`; None for a law that no unknown scales."""
        if self.space.scale is None:
            return None
        kind = AmountAt if far or len(self.law_parameters) < 2 else ModulusAt
        return kind(self.space, self._priors, frequency, z[: len(self.law_parameters)])

    def law_coordinates(self, z: RealArray) -> RealArray:
        """Return the point of the law's space, shape (..., n_law), of coordinates of all unknowns, the law's first."""
        return self._priors.values(z[..., : len(self.law_parameters)])

    def modulus(self, z: RealArray, frequency: RealArray) -> ComplexArray:
        """Return E1 + i E2, Pa, shape (..., n_frequency), the deviation from the law included."""
        modulus = self.space.modulus(self.law_coordinates(z), frequency)
        if self.deviation is None:
            return modulus
        heights = z[..., len(self.law_parameters) : len(self.parameters)]
        return np.asarray(modulus * self.deviation.factor(heights, frequency))

    def at(self, points: Points, kept: IndexArray, frequency: RealArray) -> ComplexArray:
        """Return the modulus, shape (k, n), at k of the points; it is computed once for each distinct law."""

        def distinct() -> tuple[ComplexArray, IndexArray]:
            first, like = distinct_rows(points.z[:, : len(self.parameters)])
            return self.modulus(points.z[first], frequency), like

        moduli, like = points.shared((id(self), frequency.tobytes()), distinct)
        return np.asarray(moduli[like[kept]])


@dataclass(frozen=True, eq=False)
class EndEffect:
    """The change of ln(ratio) by the records' ends, to first order about a point.

    Attributes
    ----------
    z : array, shape (n_parameters,)
    change : mapping
        By configuration, shape (n,).
    slope : mapping
        Derivative of that, shape (n, n_parameters).
    """

    z: RealArray
    change: Mapping[str, ComplexArray]
    slope: Mapping[str, ComplexArray]

    def at(self, name: str, z: RealArray) -> ComplexArray:
        """Return the change at coordinates of shape (..., n_parameters)."""
        return np.asarray(self.change[name] + (z - self.z) @ self.slope[name].T)

    @property
    def is_finite(self) -> bool:
        """Whether all its values are finite."""
        return all(np.all(np.isfinite(values)) for part in (self.change, self.slope) for values in part.values())


@dataclass(frozen=True, eq=False)
class RigExperiment(Experiment):
    """One configuration: ln(top/base) at the bins of its bursts.

    Attributes
    ----------
    setting : Setting
        The configuration, its data, and when they were measured.
    material : Material
        Its parameters are the first unknowns.
    nuisances : Nuisances
    near : Neighbourhood
        The rig, and rigs near it.
    model_error : float
        Standard deviation of the model's relative error.
    effects : tuple of Effect
        Their parameters are the last unknowns.
    end_effect : EndEffect, optional
        The change by the ends of the records; computed anew at every point, at many times the cost, when left out.
    """

    setting: Setting
    material: Material
    nuisances: Nuisances
    near: Neighbourhood
    model_error: float
    effects: tuple[Acting, ...] = ()
    end_effect: EndEffect | None = None

    @property
    def data(self) -> ConfigurationData:
        """Ratios of spectra."""
        return self.setting.data

    @cached_property
    def whitening(self) -> Whitening:
        """Of each part of ln(ratio); only residuals ask for it, and a hypothesis may be asked for differences alone."""
        return Whitening.of_parts(self.data.covariance(self.model_error))

    def whiten(self, difference: NDArray[Any]) -> RealArray:
        """Return differences of ln(ratio) as independent unit normal numbers, real parts first, shape (..., 2 n)."""
        return self.whitening(np.asarray(difference, dtype=complex))

    def difference(self, points: Points) -> ComplexArray:
        """Return ln(model/measured), the phase wrapped to half a turn, shape (m, n).

        Most points of a derivative differ only in parameters of the channels or of another configuration: the motion
        that they share is computed once.
        """
        first, last = len(self.material.parameters), sum(len(effect.parameters) for effect in self.effects)
        z = points.z
        parts = self.nuisances.of_rig(points.named, self.data).parts
        kept, place = distinct_rows(z[:, :first], z[:, z.shape[1] - last :], *parts)
        logarithms = self._log_shown(points, kept)
        difference = (logarithms - self.data.target)[place] + self.nuisances.of_channels(points.named, self.data)
        if self.end_effect is not None and self.data.ends:
            difference = difference + self.end_effect.at(self.data.name, z)
        return _wrapped(difference)

    def log_motion(self, points: Points, frequency: RealArray, burst: IndexArray) -> ComplexArray:
        """Return ln(top/base) as the channels show it, shape (m, n), at any frequencies.

        Without effects that need what was measured at the bins (`BaseEffect.acts_by_bin`).

        Parameters
        ----------
        points : Points
        frequency : array, shape (n,)
            Hz.
        burst : array of int, shape (n,)
            Index of the burst of each.
        """
        setting = self.setting.at(frequency, burst)
        acting = [pair for pair in self._acting(points) if not pair[0].acts_by_bin]
        moved = self._motion(points, np.arange(len(points.z)), setting, acting)
        return logarithm(_as_shown(moved, setting, acting))

    @np.errstate(all="ignore")  # a search may try points without a response: NaN, which is no minimum
    def motions(self, points: Points) -> tuple[ComplexArray, ComplexArray]:
        """Return top over base, shape (m, n), as the plate moves, and as the channels show it under the effects."""
        return self._motions(points, np.arange(len(points.z)))

    def _motions(self, points: Points, kept: IndexArray) -> tuple[ComplexArray, ComplexArray]:
        acting = self._acting(points)
        if len(kept) < len(points.z):
            acting = [(effect, {name: column[kept] for name, column in values.items()}) for effect, values in acting]
        moved = self._motion(points, kept, self.setting, acting)
        return moved, _as_shown(moved, self.setting, acting)

    def _acting(self, points: Points) -> list[tuple[Acting, Values]]:
        """Return the effects with their parameters at all points."""
        return list(zip(self.effects, values_of(self.effects, points), strict=True))

    @np.errstate(all="ignore")
    def _log_shown(self, points: Points, kept: IndexArray) -> ComplexArray:
        """Return ln(top/base) at some of the points, truncated as the records are, without errors of the channels."""
        logarithms = logarithm(self._motions(points, kept)[1] + _TINY)
        if self.data.ends and self.end_effect is None:
            motion = np.exp(self.log_motion(points, self.data.needed, self.data.needed_burst))[kept]
            logarithms += logarithm(self.data.cut(motion) / motion[:, : len(self.data.frequency)])
        return logarithms

    def _motion(
        self, points: Points, kept: IndexArray, setting: Setting, acting: Sequence[tuple[Acting, Values]]
    ) -> ComplexArray:
        """Return top over base as the plate moves, shape (k, n), at some of the points and a setting's frequencies."""
        campaign, frequency = setting.campaign, setting.frequency
        modulus = self.material.at(points, kept, frequency)
        for effect, parameters in acting:
            modulus = effect.modulus(setting, modulus, parameters)
        parts = self.nuisances.of_rig(points.named, self.data).parts
        density, thickness, mass = ((part[kept] if part.ndim else part)[..., None] for part in parts)
        chain = Chain(
            modulus,
            campaign.specimen.density * (1 + density),
            setting.configuration.specimen_thickness + thickness,
            setting.plate_mass * (1 + mass),
        )
        for effect, parameters in acting:
            chain = effect.chain(setting, chain, parameters)
        return top_over_base(self.near, setting, frequency, chain)


class _Stiffer(Effect):
    """A modulus that is a little larger, for derivatives."""

    name = "stiffer"

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        return np.asarray(modulus * np.exp(_STEP))


@dataclass(frozen=True)
class CampaignProblem(Hypothesis):
    """A campaign as one inverse problem, with unmodelled effects or without.

    Attributes
    ----------
    campaign : Campaign
    configurations : sequence of ConfigurationData
        All data; the unknowns are those of all configurations, whichever data are in use.
    rigs : mapping
        The model of every configuration, by name.
    space : LawSpace
        The law's parameters.
    known : Uncertainty
        Uncertainties that the laboratory states.
    model_error : float
        Standard deviation of the model's relative error, smooth in ln f.
    deviation : LawDeviation, optional
        How far the material may depart from the law; none when left out.
    end_effect : EndEffect, optional
        The change by the ends of the records near a solution; computed anew at every point when left out.
    effects : tuple of Effect
    given : tuple of Effect
        Effects of the nominal model: they act ahead of `effects`, and their parameters are nominal ones.
    finite : mapping
        Finite-element rigs by configuration, for effects that need them.
    used : tuple of ConfigurationData, optional
        The data that residuals are made of; all when left out.
    unstated : str
        As of `Nuisances`.
    """

    kind = Effect.kind

    campaign: Campaign
    configurations: Sequence[ConfigurationData]
    rigs: Mapping[str, Rig]
    space: LawSpace
    known: Uncertainty = field(default_factory=Uncertainty)
    model_error: float = MODEL_ERROR
    deviation: LawDeviation | None = None
    end_effect: EndEffect | None = None
    effects: tuple[Acting, ...] = ()
    given: tuple[Acting, ...] = ()
    finite: Mapping[str, Rig] = field(default_factory=dict)
    used: tuple[ConfigurationData, ...] | None = None
    unstated: str = ""

    @property
    def data(self) -> tuple[ConfigurationData, ...]:
        """The data in use."""
        return tuple(self.configurations) if self.used is None else self.used

    @cached_property
    def nuisances(self) -> Nuisances:
        """Uncertain quantities of the rig and the channels."""
        configurations = tuple(self.campaign.configuration(data.name) for data in self.configurations)
        return Nuisances(self.known, configurations, self.unstated)

    @property
    def pieces(self) -> dict[str, dict[str, str]]:
        """Samples and top plates that several configurations share."""
        return {"sample": self.nuisances.samples, "top plate": self.nuisances.top_plates}

    @cached_property
    def material(self) -> Material:
        """The sample's modulus."""
        return Material(self.space, self.deviation)

    def reparameterisation(self, z: RealArray, *, far: bool = False) -> Reparameterisation | None:
        """Return the modulus in the middle of the data's frequencies in place of two of the law's unknowns."""
        return self.material.reparameterisation(z, self._middle, far=far)

    @cached_property
    def _middle(self) -> float:
        """Geometric mean of the frequencies of all data, Hz."""
        frequency = np.concatenate([data.frequency for data in self.configurations])
        return float(np.exp(np.mean(np.log(frequency))))

    @property
    def law_parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the law."""
        return self.material.law_parameters

    @property
    def modulus_parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the modulus: law, then its deviation."""
        return self.material.parameters

    @cached_property
    def given_parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the effects of the nominal model, named as ``sensor_mass.mass``."""
        return parameters_of(self.given)

    @cached_property
    def nominal_parameters(self) -> tuple[Parameter, ...]:
        """Law, its deviation, nuisances, effects that are given."""
        return (*self.material.parameters, *self.nuisances.parameters, *self.given_parameters)

    def law_coordinates(self, z: RealArray) -> RealArray:
        """Return the point of the law's space, shape (..., n_law)."""
        return self.material.law_coordinates(z)

    def modulus(self, z: RealArray, frequency: RealArray) -> ComplexArray:
        """Return E1 + i E2, Pa, shape (..., n_frequency), the deviation from the law included."""
        return self.material.modulus(z, frequency)

    def own_modulus(self, z: RealArray, frequency: RealArray) -> ComplexArray:
        """Return E1 + i E2 of the sample's material, Pa, shape (..., n_frequency): its law, and what changes that.

        Of the effects and laws those at the place of the sample itself (`MATERIAL`): a load, a drift, a strain change
        what the rig does to the material. Of samples that differ it is the mean, of ln E.
        """
        own = [effect for effect in self._acting if _place_of(effect) == MATERIAL]
        if not own:
            return self.modulus(z, frequency)
        points = self.points(np.atleast_2d(z))
        every = []
        for setting, data in zip(self.settings, self.data, strict=True):
            here, modulus = (
                setting.at(frequency, np.full(len(frequency), data.burst[0])),
                self.modulus(points.z, frequency),
            )
            for effect, values in zip(own, values_of(own, points), strict=True):
                modulus = effect.modulus(here, modulus, values)
            every.append(np.log(modulus))
        return np.asarray(np.exp(np.mean(every, axis=0)).reshape(*z.shape[:-1], -1))

    def modulus_scale(self, z: RealArray, frequency: float) -> float:
        """Return the amount of the sample's modulus at a frequency, Hz, in Pa."""
        return float(abs(self.modulus(z, np.array([frequency]))[0]))

    @property
    def settings(self) -> tuple[Setting, ...]:
        """Every configuration in use, as effects see it."""
        return self._settings

    @cached_property
    def _settings(self) -> tuple[Setting, ...]:
        order = _measurement_order(self.campaign)
        return tuple(
            Setting(
                self.campaign,
                self.campaign.configuration(data.name),
                data,
                np.array([order[data.name, float(f)] for f in data.centres])[data.burst],
            )
            for data in self.data
        )

    @cached_property
    def experiments(self) -> tuple[RigExperiment, ...]:
        """An experiment for each configuration in use."""
        acting = self._acting
        near = self._near[any(effect.needs_finite_elements for effect in acting)]
        return tuple(
            RigExperiment(
                setting,
                self.material,
                self.nuisances,
                near[setting.data.name],
                self.model_error,
                acting,
                self.end_effect,
            )
            for setting in self.settings
        )

    def predict(self, setting: Setting, z: RealArray) -> tuple[ComplexArray, ComplexArray]:
        """Return top over base in any setting, as the plate moves, and as the channels show it under the effects.

        Both of shape (..., n), at coordinates of shape (..., d). The setting may be a planned one, of another size,
        level or order than measured.
        """
        described = next(e for e in self.experiments if e.data.name == setting.data.name)
        moved, shown = replace(described, setting=setting).motions(self.points(z))
        return moved.reshape(*z.shape[:-1], -1), shown.reshape(*z.shape[:-1], -1)

    @cached_property
    def _near(self) -> tuple[dict[str, Neighbourhood], dict[str, Neighbourhood]]:
        """Of the rigs, and of those in finite elements, by configuration."""
        plane, finite = ({name: self._around(rig) for name, rig in rigs.items()} for rigs in (self.rigs, self.finite))
        return plane, finite

    def _around(self, rig: Rig) -> Neighbourhood:
        mass_step = 0.0 if rig.scales else self.known.top_plate_mass
        return Neighbourhood(rig, self.known.density or _DENSITY_STEP, self.known.thickness, mass_step)

    @property
    def quantities(self) -> tuple[str, str]:
        """Quantities in the real and in the imaginary part of ln(ratio)."""
        return ("level", "phase")

    @property
    def shown_as(self) -> tuple[Part, ...]:
        """Level and phase of the ratio."""
        return Part("level", "dB", DB_PER_NEPER), Part("phase", "degrees", 180 / np.pi)

    @property
    def spreads(self) -> list[list[RealArray]]:
        """Standard deviations of both parts of ln(ratio), of noise and model error."""
        return [[np.sqrt(np.diag(data.covariance(self.model_error)))] * 2 for data in self.data]

    @property
    def blocks(self) -> int:
        """Each fold leaves out a third of a single configuration's bursts."""
        return 3

    @property
    def held_out_decides(self) -> bool:
        """True: every configuration is mounted and every burst recorded anew."""
        return True

    def admits(self, effect: BaseEffect) -> bool:
        """Tell whether an effect can act besides in this campaign: it must be one of the rig, and not be given."""
        is_new = effect.name not in [known.name for known in self.given]
        return isinstance(effect, Effect) and is_new and effect.applies(self.campaign)

    def with_effects(self, *effects: Acting) -> CampaignProblem:
        """Return the hypothesis with these effects instead, and what is known of the rest."""
        other = replace(self, effects=effects)
        vars(other).update({name: vars(self)[name] for name in _WITHOUT_EFFECTS if name in vars(self)})
        return other

    def with_data(self, data: Sequence[ConfigurationData]) -> CampaignProblem:
        """Return the hypothesis with residuals of these data only."""
        return replace(self, used=tuple(data))

    @cached_property
    def _thinned(self) -> CampaignProblem:
        return self.with_data([data.thinned(_THINNED) for data in self.data])

    def inflated_residual(self, size: float) -> Callable[[RealArray], RealArray]:
        """Return residuals of some bins of each burst, shape (..., n), with an additional relative error of `size`.

        Where that is not 0 they are ``2 (a - b)/(|a| + |b|)`` over the standard deviation, of modelled a and measured
        b: bounded, and smooth where the phase wraps.
        """
        if not size:
            return self._thinned.residual
        spread = [np.sqrt(data.variance + size**2) for data in self._thinned.data]

        def residual(z: RealArray) -> RealArray:
            pairs = zip(self._thinned.differences(z), spread, strict=True)
            return np.concatenate([(_bounded(difference) / width).view(float) for difference, width in pairs], axis=-1)

        return residual

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual and derivative; that by a drawn law's nodes from one derivative by the law.

        The law acts frequency by frequency: the derivative by a node is that by the law times what the node adds to it.
        """
        if not self._drawn_laws:
            return super().linearised(z)
        hypothesis, is_node, is_offset = self._with_offsets
        wide = np.zeros(is_offset.size)
        wide[~is_offset] = z
        stencil = self.stencil(wide, partial(Stencil.forward, along=np.eye(wide.size)[~is_node]))
        differences = hypothesis.differences(stencil.points)
        slopes = [_wrapped(part[1:] - part[0]) / stencil.step for part in differences]
        by_law, by_node = is_offset[~is_node], is_node[~is_offset]
        jacobian = np.empty((self._n_residuals, z.size))
        jacobian[:, ~by_node] = stencil.by_axes(self.whitened([part[~by_law] for part in slopes]).T)
        columns = np.split(np.flatnonzero(by_node), np.cumsum([len(law.parameters) for law in self._drawn_laws])[:-1])
        for law, offset, places in zip(self._drawn_laws, np.flatnonzero(by_law), columns, strict=True):
            by_parameters = [law.by_parameters(setting, z[places]).T for setting in self.settings]
            parts = [part[offset] * change for part, change in zip(slopes, by_parameters, strict=True)]
            jacobian[:, places] = self.whitened(parts).T
        return self.whitened([part[0] for part in differences]), jacobian

    @cached_property
    def _drawn_laws(self) -> list[DrawnLaw]:
        return [effect for effect in self._acting if isinstance(effect, DrawnLaw)]

    @property
    def _acting(self) -> tuple[Acting, ...]:
        """Effects in the order of their parameters."""
        return (*self.given, *self.effects)

    @cached_property
    def _with_offsets(self) -> tuple[CampaignProblem, BoolArray, BoolArray]:
        """The hypothesis with offsets of its drawn laws, and which of its unknowns are nodes, and which offsets."""
        acting = [effect.with_offset if isinstance(effect, DrawnLaw) else effect for effect in self._acting]
        count = len(self.nominal_parameters) - len(self.given_parameters)
        is_node, is_offset = [False] * count, [False] * count
        for effect, shifted in zip(self._acting, acting, strict=True):
            count, more = len(effect.parameters), len(shifted.parameters) - len(effect.parameters)
            is_node += [more > 0] * count + [False] * more
            is_offset += [False] * count + [True] * more
        given, effects = tuple(acting[: len(self.given)]), acting[len(self.given) :]
        return replace(self, given=given).with_effects(*effects), np.array(is_node), np.array(is_offset)

    @cached_property
    def _n_residuals(self) -> int:
        return 2 * sum(len(data.frequency) for data in self.data)

    def law_change(
        self, index: int, z: RealArray, differences: Sequence[ComplexArray] | None = None
    ) -> list[ComplexArray]:
        """Return the change of `differences` for a relative error of 1 in the law of one of the effects.

        Of an effect on the reading it is what the effect adds, over the reading: with a tenth more crosstalk c,
        ln(T + c) changes by 0.1 c/(T + c), however small T is beside c. Of an effect on the sample, whose resonance
        moves, it is the nearest change (least squares, by configuration) that a change of modulus makes. Parameters in
        `Effect.aside` are at the centre of their priors.
        """
        full = self.differences(z) if differences is None else differences
        slopes = self.modulus_slopes(z, full) if self.effects[index].moves_resonances else None
        if aside := [f"{self.effects[index].name}.{name}" for name in self.effects[index].aside]:
            z = np.where(np.isin([parameter.name for parameter in self.parameters], aside), 0.0, z)
            full = self.differences(z)
        others, rest = self.without(index, z)
        changes = [_wrapped(a - b) for a, b in zip(full, others.differences(rest), strict=True)]
        if slopes is None:
            # bounded where the effect nearly cancels the reading: such an error is not small, see `model_discrepancy`
            return [1 - np.exp(-np.maximum(change.real, -1.0) - 1j * change.imag) for change in changes]
        return [
            np.asarray(np.abs(_product(slope, change)) / np.maximum(_product(slope, slope).real, _TINY) * slope)
            for slope, change in zip(slopes, changes, strict=True)
        ]

    def modulus_slopes(self, z: RealArray, differences: Sequence[ComplexArray] | None = None) -> list[ComplexArray]:
        """Return the derivative of `differences`, which may be given, by the logarithm of the sample's modulus."""
        here = self.differences(z) if differences is None else differences
        pairs = zip(self._stiffer.differences(z), here, strict=True)
        return [_wrapped(high - low) / _STEP for high, low in pairs]

    @cached_property
    def _stiffer(self) -> CampaignProblem:
        return self.with_effects(_Stiffer(), *self.effects)

    def without_ends(self) -> CampaignProblem:
        """Return the problem as if all ring-downs were over."""
        return replace(self, configurations=[replace(d, ends={}) for d in self.configurations], end_effect=None)

    def end_effect_at(self, z: RealArray) -> EndEffect:
        """Return the change by the ends of the records near a point."""
        stencil = Stencil.forward(z)
        points = self.points(stencil.points)
        change, slope = {}, {}
        for experiment in self.experiments:
            data = experiment.data
            if data.ends:
                with np.errstate(all="ignore"):  # a law far from the sample's may have no finite one: `is_finite`
                    motion = experiment.log_motion(points, data.needed, data.needed_burst)
                    shown = np.log(data.cut(np.exp(motion))) - motion[:, : len(data.frequency)]
                shown.imag = half_turn(shown.imag)
                change[data.name], slope[data.name] = stencil.linearised(shown)
        return EndEffect(z, change, slope)


def _as_shown(moved: ComplexArray, setting: Setting, acting: Sequence[tuple[Acting, Values]]) -> ComplexArray:
    """Return the motion as the channels show it under some effects."""
    shown = moved
    for effect, parameters in acting:
        shown = effect.motion(setting, shown, parameters)
    return shown


def _place_of(effect: Acting) -> str:
    """Return the name of the place of an effect, or of a law at a place."""
    return str(effect.at_place.name) if isinstance(effect, LawAtPlace) else effect.place


def _measurement_order(campaign: Campaign) -> dict[tuple[str, float], float]:
    """Return when each burst was measured, from 0 for the first to 1 for the last, in the order of the campaign."""
    keys = [(c.name, float(burst.frequency)) for c in campaign.configurations for burst in c.bursts]
    return {key: number / max(len(keys) - 1, 1) for number, key in enumerate(keys)}


def _wrapped(difference: ComplexArray) -> ComplexArray:
    """Return a difference of ln(ratio), its phase wrapped to half a turn."""
    return np.asarray(difference.real + 1j * half_turn(difference.imag))


def _product(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    """Return the inner product over the last axis, which is kept with length 1."""
    return np.asarray(np.sum(a.conj() * b, axis=-1, keepdims=True))


@np.errstate(all="ignore")  # a search may try points without a response: NaN, which is no minimum
def _bounded(difference: ComplexArray) -> ComplexArray:
    """Return ``2 (a - b)/(|a| + |b|)`` for a difference of ln a and ln b."""
    real = np.clip(difference.real, -_FAR_OFF, _FAR_OFF)
    return np.asarray(2 * (np.exp(real + 1j * difference.imag) - 1) / (np.exp(real) + 1))
