"""All bursts of a campaign at once: one causal modulus law, and what the laboratory does not know of its rig.

With E1 and E2 free at every burst a model swallows almost any effect. One law for all bursts and configurations leaves
it no such freedom: what it cannot explain shows.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import ComplexArray, IndexArray, RealArray, distinct_rows, half_turn
from multilayer.experiments.effects import BaseEffect, Values
from multilayer.experiments.hypothesis import Hypothesis, values_of
from multilayer.experiments.two_plate.effects import Chain, Effect, Setting
from multilayer.experiments.two_plate.law_deviation import LawDeviation
from multilayer.experiments.two_plate.motion import Neighbourhood, top_over_base
from multilayer.experiments.two_plate.nuisances import Nuisances
from multilayer.experiments.two_plate.plane_waves import Rig
from multilayer.experiments.two_plate.ratios import ConfigurationData
from multilayer.inference.derivative import Stencil
from multilayer.inference.priors import Parameter, Prior, Priors
from multilayer.inference.problem import Experiment, Points
from multilayer.inference.whitening import Whitening
from multilayer.measurements.description import Campaign, Uncertainty
from multilayer.media.laws.parameters import LawSpace

MODEL_ERROR = 0.002  # relative, of a solver and of the plates' idealisation: one standard deviation
_DENSITY_STEP = 0.01
_TINY = 1e-200  # motions that underflow are far off, not infinitely
_STEP = 1e-3  # of ln E
_THINNED = 3  # every how many bins of a burst are kept for a first search
_FAR_OFF = 50.0  # of ln(ratio)


@dataclass(frozen=True, eq=False)
class Material:
    """The sample's modulus: a law, and how far the material departs from it.

    Attributes
    ----------
    space : LawSpace
        The law's parameters; its coordinates are uniform within the space's box.
    deviation : LawDeviation, optional
        Not at all when left out.
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
        """Return the modulus, shape (k, n), at k of some points: of each different law computed once."""

        def distinct() -> tuple[ComplexArray, IndexArray]:
            first, like = distinct_rows(points.z[:, : len(self.parameters)])
            return self.modulus(points.z[first], frequency), like

        moduli, like = points.shared((id(self), frequency.tobytes()), distinct)
        return np.asarray(moduli[like[kept]])


@dataclass(frozen=True, eq=False)
class EndEffect:
    """What the records' ends change in ln(ratio), to first order about a point.

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
        """Whether all of it is."""
        return all(np.all(np.isfinite(values)) for part in (self.change, self.slope) for values in part.values())


@dataclass(frozen=True, eq=False)
class RigExperiment(Experiment):
    """One configuration: ln(top/base) at the bins of its bursts.

    Attributes
    ----------
    setting : Setting
        The configuration, its data, and when they were measured.
    material : Material
        Its parameters are the first of the points'.
    nuisances : Nuisances
    near : Neighbourhood
        The rig, and others near it.
    whitening : Whitening
    effects : tuple of Effect
        Their parameters are the last of the points'.
    end_effect : EndEffect, optional
        What the ends of the records change; computed anew at every point, at many times the cost, when left out.
    """

    setting: Setting
    material: Material
    nuisances: Nuisances
    near: Neighbourhood
    whitening: Whitening
    effects: tuple[Effect, ...] = ()
    end_effect: EndEffect | None = None

    @property
    def data(self) -> ConfigurationData:
        """Ratios of spectra."""
        return self.setting.data

    def whiten(self, difference: NDArray[Any]) -> RealArray:
        """Return differences of ln(ratio) as independent unit normal numbers, real parts first, shape (..., 2 n)."""
        return self.whitening(np.asarray(difference, dtype=complex))

    def difference(self, points: Points) -> ComplexArray:
        """Return ln(model/measured), the phase within half a turn, shape (m, n).

        Most samples of a derivative differ only in the channels, or in another configuration: the motion that they
        share is computed once.
        """
        first, last = len(self.material.parameters), sum(len(effect.parameters) for effect in self.effects)
        z = points.z
        parts = self.nuisances.of_rig(points.named, self.data).parts
        kept, place = distinct_rows(z[:, :first], z[:, z.shape[1] - last :], *parts)
        moved = self._log_shown(points, kept)
        difference = (moved - self.data.log_ratio)[place] + self.nuisances.of_channels(points.named, self.data)
        if self.end_effect is not None and self.data.ends:
            difference = difference + self.end_effect.at(self.data.name, z)
        return _turned(difference)

    def log_shown(self, points: Points) -> ComplexArray:
        """Return ln(top/base) as the channels show it, shape (m, n)."""
        return np.asarray(self.difference(points) + self.data.log_ratio)

    def log_motion(self, points: Points, frequency: RealArray) -> ComplexArray:
        """Return ln(top/base) as the plate moves, shape (m, n), at frequencies (n,) in Hz; no effects."""
        return np.asarray(np.log(self._motion(points, np.arange(len(points.z)), frequency, [])))

    @np.errstate(all="ignore")  # a search may try what has no response: NaN, which is no minimum
    def motions(self, points: Points) -> tuple[ComplexArray, ComplexArray]:
        """Return top over base, shape (m, n), as the plate moves, and as effects on the reading show it."""
        return self._motions(points, np.arange(len(points.z)))

    def _motions(self, points: Points, kept: IndexArray) -> tuple[ComplexArray, ComplexArray]:
        values = [{name: column[kept] for name, column in own.items()} for own in values_of(self.effects, points)]
        moved = self._motion(points, kept, self.setting.frequency, values)
        shown = moved
        for effect, own in zip(self.effects, values, strict=True):
            shown = effect.motion(self.setting, shown, own)
        return moved, shown

    @np.errstate(all="ignore")
    def _log_shown(self, points: Points, kept: IndexArray) -> ComplexArray:
        """Return ln(top/base) of some of the points, cut where the records are, without the channels' errors."""
        if self.data.ends and self.end_effect is None:
            motion = self._motion(points, kept, self.data.needed, [])
            return np.asarray(np.log(self.data.cut(motion)))
        return np.asarray(np.log(self._motions(points, kept)[1] + _TINY))

    def _motion(self, points: Points, kept: IndexArray, frequency: RealArray, values: Sequence[Values]) -> ComplexArray:
        """Return top over base as the plate moves, shape (k, n), of some of the points."""
        setting, campaign = self.setting, self.setting.campaign
        acting = list(zip(self.effects, values, strict=False))
        modulus = self.material.at(points, kept, frequency)
        for effect, own in acting:
            modulus = effect.modulus(setting, modulus, own)
        change = self.nuisances.of_rig({name: column[kept] for name, column in points.named.items()}, self.data)
        density, thickness, mass = (part[..., None] for part in change.parts)
        chain = Chain(
            modulus,
            campaign.specimen.density * (1 + density),
            setting.configuration.specimen_thickness + thickness,
            setting.plate_mass * (1 + mass),
        )
        for effect, own in acting:
            chain = effect.chain(setting, chain, own)
        return top_over_base(self.near, setting, frequency, chain)


class _Stiffer(Effect):
    """A modulus that is larger by a little, for derivatives."""

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
        All data; the unknowns are those of all configurations.
    rigs : mapping
        The model of every configuration, by name.
    space : LawSpace
        The law's parameters.
    known : Uncertainty
        What the laboratory states of itself.
    model_error : float
        Standard deviation of the model's own relative error, smooth in ln f.
    deviation : LawDeviation, optional
        How far the material may depart from the law; not at all when left out.
    end_effect : EndEffect, optional
        What the ends of the records change near a solution; computed anew at every point when left out.
    effects : tuple of Effect
    finite : mapping
        Finite-element rigs by configuration, for effects that need them.
    seen : tuple of ConfigurationData, optional
        The data that residuals are made of; all when left out.
    """

    campaign: Campaign
    configurations: Sequence[ConfigurationData]
    rigs: Mapping[str, Rig]
    space: LawSpace
    known: Uncertainty = field(default_factory=Uncertainty)
    model_error: float = MODEL_ERROR
    deviation: LawDeviation | None = None
    end_effect: EndEffect | None = None
    effects: tuple[Effect, ...] = ()
    finite: Mapping[str, Rig] = field(default_factory=dict)
    seen: tuple[ConfigurationData, ...] | None = None

    @property
    def data(self) -> tuple[ConfigurationData, ...]:
        """The data in use."""
        return tuple(self.configurations) if self.seen is None else self.seen

    @cached_property
    def nuisances(self) -> Nuisances:
        """What is uncertain of the rig and the channels."""
        names = tuple(data.name for data in self.configurations)
        return Nuisances(self.known, names, tuple(data.thickness for data in self.configurations))

    @cached_property
    def material(self) -> Material:
        """The sample's modulus."""
        return Material(self.space, self.deviation)

    @property
    def law_parameters(self) -> tuple[Parameter, ...]:
        """Those of the law."""
        return self.material.law_parameters

    @property
    def modulus_parameters(self) -> tuple[Parameter, ...]:
        """What the modulus depends on: law, then its deviation."""
        return self.material.parameters

    @cached_property
    def nominal_parameters(self) -> tuple[Parameter, ...]:
        """Law, its deviation, nuisances."""
        return (*self.material.parameters, *self.nuisances.parameters)

    def law_coordinates(self, z: RealArray) -> RealArray:
        """Return the point of the law's space, shape (..., n_law)."""
        return self.material.law_coordinates(z)

    def modulus(self, z: RealArray, frequency: RealArray) -> ComplexArray:
        """Return E1 + i E2, Pa, shape (..., n_frequency), the deviation from the law included."""
        return self.material.modulus(z, frequency)

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """What effects see of every configuration."""
        turns = _turns(self.campaign)
        return tuple(
            Setting(
                self.campaign,
                self.campaign.configuration(data.name),
                data,
                np.array([turns[data.name, float(f)] for f in data.centres])[data.burst],
            )
            for data in self.data
        )

    @cached_property
    def experiments(self) -> tuple[RigExperiment, ...]:
        """One of each configuration in use."""
        rigs = self.finite if any(effect.needs_finite_elements for effect in self.effects) else self.rigs
        return tuple(
            RigExperiment(
                setting,
                self.material,
                self.nuisances,
                self._near(rigs[setting.data.name]),
                Whitening.of_parts(setting.data.covariance(self.model_error)),
                self.effects,
                self.end_effect,
            )
            for setting in self.settings
        )

    def predict(self, setting: Setting, z: RealArray) -> tuple[ComplexArray, ComplexArray]:
        """Return top over base in any setting, shape (..., n), as the plate moves, and as effects on the reading show.

        Of coordinates of shape (..., d). The setting may be planned: of another size, level or order than measured.
        """
        described = next(e for e in self.experiments if e.data.name == setting.data.name)
        moved, shown = replace(described, setting=setting).motions(self.points(z))
        return moved.reshape(*z.shape[:-1], -1), shown.reshape(*z.shape[:-1], -1)

    def _near(self, rig: Rig) -> Neighbourhood:
        mass_step = 0.0 if rig.scales else self.known.top_plate_mass
        return Neighbourhood(rig, self.known.density or _DENSITY_STEP, self.known.thickness, mass_step)

    @property
    def quantities(self) -> tuple[str, str]:
        """What real and imaginary part of ln(ratio) are."""
        return ("level", "phase")

    @property
    def blocks(self) -> int:
        """A third of a single configuration's bursts is left out at a time."""
        return 3

    @property
    def held_out_decides(self) -> bool:
        """Every configuration is mounted and every burst recorded anew."""
        return True

    def admits(self, effect: BaseEffect) -> bool:
        """Tell whether an effect can act in this campaign: only one of the rig can."""
        return isinstance(effect, Effect) and effect.applies(self.campaign)

    def with_effects(self, *effects: Effect) -> CampaignProblem:
        """Return the hypothesis of other effects."""
        return replace(self, effects=effects)

    def of(self, data: Sequence[ConfigurationData]) -> CampaignProblem:
        """Return the same with residuals of some data only."""
        return replace(self, seen=tuple(data))

    @cached_property
    def _few(self) -> CampaignProblem:
        return self.of([data.thinned(_THINNED) for data in self.data])

    def roughly(self, size: float) -> Callable[[RealArray], RealArray]:
        """Return residuals of some bins of each burst, shape (..., n), each being allowed to be off by `size` more.

        Where that is not 0 they are ``2 (a - b)/(|a| + |b|)`` over the standard deviation, of modelled a and measured
        b: smooth where the phase turns over.
        """
        if not size:
            return self._few.residual
        spread = [np.sqrt(data.variance + size**2) for data in self._few.data]

        def residual(z: RealArray) -> RealArray:
            pairs = zip(self._few.differences(z), spread, strict=True)
            return np.concatenate([(_bounded(difference) / width).view(float) for difference, width in pairs], axis=-1)

        return residual

    def law_change(self, index: int, z: RealArray, shown: Sequence[ComplexArray] | None = None) -> list[ComplexArray]:
        """Return what the law of one of the effects, wrong by its whole size, would change in `differences`.

        Where it acts on the reading, what it adds over what is read: of a tenth more crosstalk c the logarithm of T + c
        feels 0.1 c/(T + c), however deep T lies below c. Of one that acts on the sample, what the change of modulus
        does that comes nearest to it, by configuration: a resonance that moves changes ln(ratio) by no factor.
        What is `Effect.aside` is as in the middle of its prior.
        """
        full = self.differences(z) if shown is None else shown
        slopes = self.modulus_slopes(z, full) if self.effects[index].moves_resonances else None
        if aside := [f"{self.effects[index].name}.{name}" for name in self.effects[index].aside]:
            z = np.where(np.isin([parameter.name for parameter in self.parameters], aside), 0.0, z)
            full = self.differences(z)
        others, rest = self.without(index, z)
        changes = [_turned(a - b) for a, b in zip(full, others.differences(rest), strict=True)]
        if slopes is None:
            # where it takes the reading away: an error of what little is left is no small one, see `model_discrepancy`
            return [1 - np.exp(-np.maximum(change.real, -1.0) - 1j * change.imag) for change in changes]
        return [
            np.asarray(np.abs(_product(slope, change)) / np.maximum(_product(slope, slope).real, _TINY) * slope)
            for slope, change in zip(slopes, changes, strict=True)
        ]

    def modulus_slopes(self, z: RealArray, shown: Sequence[ComplexArray] | None = None) -> list[ComplexArray]:
        """Return the derivative of `differences` by ln of the sample's modulus; `shown` is that, where known."""
        here = self.differences(z) if shown is None else shown
        stiffer = self.with_effects(_Stiffer(), *self.effects).differences(z)
        return [_turned(high - low) / _STEP for high, low in zip(stiffer, here, strict=True)]

    def without_ends(self) -> CampaignProblem:
        """Return the problem as if all ring-downs were over."""
        return replace(self, configurations=[replace(d, ends={}) for d in self.configurations], end_effect=None)

    def end_effect_at(self, z: RealArray) -> EndEffect:
        """Return what the ends of the records change near a point."""
        stencil = Stencil.forward(z)
        points = self.points(stencil.points)
        change, slope = {}, {}
        for experiment in self.experiments:
            data = experiment.data
            if data.ends:
                with np.errstate(all="ignore"):  # a law that is not the sample's may have none: `is_finite`
                    motion = experiment.log_motion(points, data.needed)
                    shown = np.log(data.cut(np.exp(motion))) - motion[:, : len(data.frequency)]
                shown.imag = half_turn(shown.imag)
                change[data.name], slope[data.name] = stencil.linearised(shown)
        return EndEffect(z, change, slope)


def _turns(campaign: Campaign) -> dict[tuple[str, float], float]:
    """Return when each burst was measured, from 0 to 1, in the order of the campaign."""
    keys = [(c.name, float(burst.frequency)) for c in campaign.configurations for burst in c.bursts]
    return {key: number / max(len(keys) - 1, 1) for number, key in enumerate(keys)}


def _turned(difference: ComplexArray) -> ComplexArray:
    """Return a difference of ln(ratio), its phase within half a turn."""
    return np.asarray(difference.real + 1j * half_turn(difference.imag))


def _product(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    """Return the inner product over the last axis, which stays with length 1."""
    return np.asarray(np.sum(a.conj() * b, axis=-1, keepdims=True))


def _bounded(difference: ComplexArray) -> ComplexArray:
    """Return ``2 (a - b)/(|a| + |b|)`` for a difference of ln a and ln b."""
    real = np.clip(difference.real, -_FAR_OFF, _FAR_OFF)
    return np.asarray(2 * (np.exp(real + 1j * difference.imag) - 1) / (np.exp(real) + 1))
