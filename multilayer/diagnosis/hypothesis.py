"""A campaign under a hypothesis: one causal law, the laboratory's own uncertainties, and some unmodelled effects."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from multilayer.arrays import ComplexArray, IndexArray, Numeric, RealArray, distinct_rows, half_turn
from multilayer.diagnosis.base_hypothesis import BaseHypothesis
from multilayer.diagnosis.effects.base import BaseEffect, Chain, Effect, Setting, Values
from multilayer.diagnosis.effects.finite_size import static_factor
from multilayer.diagnosis.interface import AnyHypothesis
from multilayer.experiments.two_plate.campaign import ConfigurationData, JointProblem, Neighbourhood, whitening
from multilayer.experiments.two_plate.plane_waves import Rig
from multilayer.inference.priors import Parameter
from multilayer.measurements.description import Campaign
from multilayer.media.elastic import p_wave_modulus
from multilayer.media.laws.parameters import LawSpace
from multilayer.media.pumped_disc import pumped_disc_factor
from multilayer.media.rod import chain_transmissibility

Rod: TypeAlias = tuple[Numeric, Numeric, Numeric]  # modulus (Pa), density (kg/m3), length (m)
_TINY = 1e-200  # motions that underflow are far off, not infinitely
_STEP = 1e-3  # of ln E
_GLUE = 1e-6  # thickness by which a layer of given stiffness and mass per area is written as a rod, m
_LIGHT = 1e-9  # kg/m2: the mass of a layer that has none
_THINNED = 3  # every how many bins of a burst are kept for a first search
_FAR_OFF = 50.0  # of ln(ratio)


@dataclass(frozen=True)
class _Samples:
    """What m points of coordinates say; what configurations share of it is computed once.

    Attributes
    ----------
    space : LawSpace
    laws : array, shape (k, n_law)
        The different points of that; `like` says which of them each sample has, shape (m,).
    stiffening : float
        The sample's modulus over what its law says.
    nuisances : mapping
        Each of shape (m,).
    values : sequence of Values
        Of every effect.
    """

    space: LawSpace
    laws: RealArray
    stiffening: float
    like: IndexArray
    nuisances: Mapping[str, RealArray]
    values: Sequence[Values]
    _moduli: dict[bytes, ComplexArray] = field(default_factory=dict, repr=False, compare=False)

    def part(self, kept: IndexArray) -> _Samples:
        """Return some of the samples."""
        nuisances = {name: value[kept] for name, value in self.nuisances.items()}
        values = [{name: value[kept] for name, value in own.items()} for own in self.values]
        return replace(self, like=self.like[kept], nuisances=nuisances, values=values)

    def modulus(self, frequency: RealArray) -> ComplexArray:
        """Return the sample's modulus, Pa, shape (m, n)."""
        key = frequency.tobytes()
        if key not in self._moduli:
            self._moduli[key] = self.stiffening * self.space.modulus(self.laws, frequency)
        return np.asarray(self._moduli[key][self.like])


@dataclass(frozen=True)
class Hypothesis(BaseHypothesis[Effect]):
    """A `Problem`: the nominal model with effects.

    Attributes
    ----------
    campaign : Campaign
    joint : JointProblem
        Data, law and nuisances of the nominal model.
    effects : tuple of Effect
    finite : mapping
        Finite-element rigs by configuration, for effects that need them.
    seen : tuple of ConfigurationData, optional
        The data that residuals are made of; all when left out. The parameters stay the same.
    """

    campaign: Campaign
    joint: JointProblem
    effects: tuple[Effect, ...] = ()
    finite: Mapping[str, Rig] = field(default_factory=dict)
    seen: tuple[ConfigurationData, ...] | None = None

    @property
    def nominal_parameters(self) -> tuple[Parameter, ...]:
        """Law, nuisances."""
        return self.joint.parameters

    @property
    def data(self) -> tuple[ConfigurationData, ...]:
        """The data in use."""
        return tuple(self.joint.data) if self.seen is None else self.seen

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """What effects see of every configuration."""
        turns = _turns(self.campaign)
        found = []
        for data in self.data:
            order = np.array([turns[data.name, float(f)] for f in data.centres])
            found.append(Setting(self.campaign, self.campaign.configuration(data.name), data, order[data.burst]))
        return tuple(found)

    @cached_property
    def _whitening(self) -> list[RealArray]:
        return [whitening(data, self.joint.model_error) for data in self.data]

    @cached_property
    def _near(self) -> dict[str, Neighbourhood]:
        step = self.joint.known.density or 0.01
        return {name: Neighbourhood(rig, step, self.joint.known.thickness) for name, rig in self.finite.items()}

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

    def with_effects(self, *effects: Effect) -> Hypothesis:
        """Return the hypothesis of other effects."""
        return replace(self, effects=effects)

    def of(self, data: Sequence[ConfigurationData]) -> Hypothesis:
        """Return the same with residuals of some data only."""
        return replace(self, seen=tuple(data))

    @cached_property
    def _few(self) -> Hypothesis:
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
            pairs = zip(self._few.log_ratios(z), spread, strict=True)
            return np.concatenate([(_bounded(difference) / width).view(float) for difference, width in pairs], axis=-1)

        return residual

    def whitened(self, index: int, difference: ComplexArray) -> RealArray:
        """Return a difference of ln(ratio) of one configuration as independent unit normal numbers."""
        w = self._whitening[index]
        return np.concatenate([difference.real @ w.T, difference.imag @ w.T], axis=-1)

    def log_ratios(self, z: RealArray) -> list[ComplexArray]:
        """Return ln(model/measured), the phase within half a turn, shape (..., n), of every configuration."""
        return self._log_ratios(z, 1.0)

    @np.errstate(all="ignore")  # a search may try what has no response: NaN, which is no minimum
    def _log_ratios(self, z: RealArray, stiffening: float) -> list[ComplexArray]:
        rows = z.reshape(-1, z.shape[-1])
        samples = self._samples(rows, stiffening)
        n_law, n_nominal = len(self.joint.law_parameters), len(self.nominal_parameters)
        felt = np.concatenate([rows[:, :n_law], rows[:, n_nominal:]], axis=1)
        found = []
        for setting in self.settings:

            def shown(kept: IndexArray, setting: Setting = setting) -> ComplexArray:
                return np.asarray(np.log(self._predict(setting, samples.part(kept))[1] + _TINY))

            difference = self.joint.nuisances.log_ratio(samples.nuisances, setting.data, felt, shown)
            found.append(difference.reshape(*z.shape[:-1], -1))
        return found

    def law_change(self, index: int, z: RealArray, shown: Sequence[ComplexArray] | None = None) -> list[ComplexArray]:
        """Return what the law of one of the effects, wrong by its whole size, would change in `log_ratios`.

        Where it acts on the reading, what it adds over what is read: of a tenth more crosstalk c the logarithm of T + c
        feels 0.1 c/(T + c), however deep T lies below c. Of one that acts on the sample, what the change of modulus
        does that comes nearest to it, by configuration: a resonance that moves changes ln(ratio) by no factor.
        What is `Effect.aside` is as in the middle of its prior.
        """
        full = self.log_ratios(z) if shown is None else shown
        slopes = self.modulus_slopes(z, full) if self.effects[index].moves_resonances else None
        if aside := [f"{self.effects[index].name}.{name}" for name in self.effects[index].aside]:
            z = np.where(np.isin([parameter.name for parameter in self.parameters], aside), 0.0, z)
            full = self.log_ratios(z)
        others, rest = self.without(index, z)
        change = [_turned(a - b) for a, b in zip(full, others.log_ratios(rest), strict=True)]
        if slopes is None:
            # where it takes the reading away: an error of what little is left is no small one, see `model_discrepancy`
            return [1 - np.exp(-np.maximum(one.real, -1.0) - 1j * one.imag) for one in change]
        return [
            np.asarray(np.abs(_product(slope, one)) / np.maximum(_product(slope, slope).real, _TINY) * slope)
            for slope, one in zip(slopes, change, strict=True)
        ]

    def modulus_slopes(self, z: RealArray, shown: Sequence[ComplexArray] | None = None) -> list[ComplexArray]:
        """Return the derivative of `log_ratios` by ln of the sample's modulus; `shown` is `log_ratios`, where known."""
        here = self.log_ratios(z) if shown is None else shown
        stiffer = self._log_ratios(z, np.exp(_STEP))
        return [_turned(high - low) / _STEP for high, low in zip(stiffer, here, strict=True)]

    def _samples(self, z: RealArray, stiffening: float = 1.0) -> _Samples:
        """Return what coordinates of shape (m, d) say."""
        n_law = len(self.joint.law_parameters)
        kept, like = distinct_rows(z[:, :n_law])
        laws = self.joint.law_coordinates(z[kept])
        nuisances = self.joint.nuisances.priors.named(z[:, n_law : len(self.nominal_parameters)])
        return _Samples(self.joint.space, laws, stiffening, like, nuisances, self.effect_values(z))

    def predict(self, setting: Setting, z: RealArray) -> tuple[ComplexArray, ComplexArray]:
        """Return top over base in any setting, shape (..., n), as the plate moves, and as the channels show it.

        Of coordinates of shape (..., d).
        """
        moved, shown = self._predict(setting, self._samples(z.reshape(-1, z.shape[-1])))
        return moved.reshape(*z.shape[:-1], -1), shown.reshape(*z.shape[:-1], -1)

    def _predict(self, setting: Setting, samples: _Samples) -> tuple[ComplexArray, ComplexArray]:
        moved = self._motion(setting, samples)
        shown = moved
        for effect, own in zip(self.effects, samples.values, strict=True):
            shown = effect.motion(setting, shown, own)
        return moved, shown

    def _motion(self, setting: Setting, samples: _Samples) -> ComplexArray:
        """Return top over base of one configuration as the plate moves, shape (m, n)."""
        pairs = list(zip(self.effects, samples.values, strict=True))
        modulus = samples.modulus(setting.frequency)
        for effect, own in pairs:
            modulus = effect.modulus(setting, modulus, own)
        change = self.joint.nuisances.of_rig(samples.nuisances, setting.data)
        chain = Chain(
            modulus,
            self.campaign.specimen.density * (1 + change.density[..., None]),
            setting.configuration.specimen_thickness + change.thickness[..., None],
            setting.plate_mass * (1 + change.plate_mass[..., None]),
        )
        for effect, own in pairs:
            chain = effect.chain(setting, chain, own)
        ratio = self.campaign.specimen.poisson_ratio
        if any(effect.needs_finite_elements for effect in self.effects):
            return self._finite_motion(setting, chain) * _with_air(setting, chain, ratio, 1.0)
        held = held_factor(ratio)
        return self._chain_motion(setting, chain, held) * _with_air(setting, chain, ratio, held)

    def _chain_motion(self, setting: Setting, chain: Chain, stiffening: float) -> ComplexArray:
        """Return the motion of rods and masses in one dimension, exact; `stiffening` is the rods' modulus over E."""
        plate = self.campaign.top_plate
        held = stiffening * chain.modulus
        rods: list[Rod] = [(held, chain.density, chain.thickness)]
        if chain.skin is not None:
            thickness, ratio = chain.skin
            skin: Rod = (held * ratio, chain.density, thickness)
            rods = [skin, (held, chain.density, chain.thickness - 2 * thickness), skin]
        if chain.glue is not None:
            glue: Rod = (chain.glue * _GLUE, np.maximum(chain.glue_mass, _LIGHT) / _GLUE, _GLUE)
            rods = [glue, *rods, glue]
        thickness = setting.configuration.top_plate_thickness
        heavy = chain.plate_mass / (setting.area * thickness)
        top: Rod = (p_wave_modulus(plate.young_modulus, plate.poisson_ratio), heavy, thickness)
        base = self.campaign.base_plate
        below: Rod = (p_wave_modulus(base.young_modulus, base.poisson_ratio), base.density, base.thickness)
        if chain.spring is not None:
            return _beside(setting, rods, chain)
        return chain_transmissibility(setting.frequency, [below, *rods, top])

    def _is_known(self, setting: Setting) -> bool:
        return any(setting.configuration == c for c in self.campaign.configurations)

    def _finite_motion(self, setting: Setting, chain: Chain) -> ComplexArray:
        """Return the motion of the disc with its free rim; glue and skin by their compliance, glue as mass, too."""
        configuration = setting.configuration
        if not self._is_known(setting):
            # another geometry, asked for when the next experiment is planned: a rod of the static stiffness
            shape = configuration.specimen_radius / (2 * configuration.specimen_thickness)
            held = static_factor(self.campaign.specimen.poisson_ratio, round(shape, 6))
            return self._chain_motion(setting, chain, held)
        near = self._near[setting.data.name]
        modulus, height = chain.modulus, configuration.specimen_thickness
        if chain.skin is not None:
            share = 2 * chain.skin[0] / height
            modulus = modulus / (1 - share + share / chain.skin[1])
        if chain.glue is not None:
            modulus = modulus / (1 + 2 * modulus / (height * chain.glue))
        if chain.spring is not None:
            modulus = modulus + chain.spring * height / setting.area
        scale = (chain.plate_mass + chain.glue_mass * setting.area) / setting.plate_mass
        density = np.asarray(chain.density / self.campaign.specimen.density / scale - 1)
        thicker = np.asarray(chain.thickness - height)
        motion = near.log_motion(setting.frequency, modulus / scale, np.asarray(density.real), thicker.real)
        return np.asarray(np.exp(motion))


def _turned(difference: ComplexArray) -> ComplexArray:
    """Return a difference of ln(ratio), its phase within half a turn."""
    return np.asarray(difference.real + 1j * half_turn(difference.imag))


def _product(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    """Return the inner product over the last axis, which stays with length 1."""
    return np.asarray(np.sum(a.conj() * b, axis=-1, keepdims=True))


def rig_hypothesis(hypothesis: AnyHypothesis) -> Hypothesis:
    """Return a hypothesis that is known to be one of the two-plate rig.

    Raises
    ------
    TypeError
        When it is of something else.
    """
    if not isinstance(hypothesis, Hypothesis):
        raise TypeError(f"{type(hypothesis).__name__} is no hypothesis of the two-plate rig")
    return hypothesis


def held_factor(poisson_ratio: float) -> float:
    """Return the modulus of laterally held compression over Young's."""
    return float(np.real(np.asarray(p_wave_modulus(1.0, poisson_ratio))))


def _turns(campaign: Campaign) -> dict[tuple[str, float], float]:
    """Return when each burst was measured, from 0 to 1, in the order of the campaign."""
    keys = [(c.name, float(burst.frequency)) for c in campaign.configurations for burst in c.bursts]
    return {key: number / max(len(keys) - 1, 1) for number, key in enumerate(keys)}


def _with_air(setting: Setting, chain: Chain, poisson_ratio: float, held: float) -> Numeric:
    """Return what the air in the sample's pores, if any, multiplies the motion by."""
    if chain.resistivity is None:
        return 1.0
    return pumped_disc_factor(
        setting.omega,
        chain.modulus,
        chain.resistivity,
        radius=setting.configuration.specimen_radius,
        thickness=chain.thickness,
        density=chain.density,
        mass_per_area=chain.plate_mass / setting.area,
        poisson_ratio=poisson_ratio,
        held=held,
    )


def _beside(setting: Setting, rods: Sequence[Rod], chain: Chain) -> ComplexArray:
    """Return the motion of a plate on rods with a spring beside them.

    The rods push a plate with the force ``b u0 - c u1``, so that ``1/T = p - w^2 M q`` with ``p = c/b``, ``q = 1/b``:
    two masses tell both. A spring k then makes ``T = (1 + k q)/(p - w^2 M q + k q)``.
    """
    omega2 = setting.omega**2
    mass = np.asarray(chain.plate_mass)
    light, heavy = (_loaded(setting, rods, m) for m in (0.5 * mass, mass))
    q = (1 / light - 1 / heavy) / (omega2 * 0.5 * mass)
    p = 1 / heavy + omega2 * mass * q
    spring = np.asarray(chain.spring)
    return np.asarray((1 + spring * q) / (p - omega2 * mass * q + spring * q))


def _loaded(setting: Setting, rods: Sequence[Rod], mass: RealArray) -> ComplexArray:
    """Return the motion of a rigid mass on rods."""
    thin = 1e-6
    plate: Rod = (1e14, mass / (setting.area * thin), thin)
    return chain_transmissibility(setting.frequency, [*rods, plate])


def _bounded(difference: ComplexArray) -> ComplexArray:
    """Return ``2 (a - b)/(|a| + |b|)`` for a difference of ln a and ln b."""
    real = np.clip(difference.real, -_FAR_OFF, _FAR_OFF)
    return np.asarray(2 * (np.exp(real + 1j * difference.imag) - 1) / (np.exp(real) + 1))
