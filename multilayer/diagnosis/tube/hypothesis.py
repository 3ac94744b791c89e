"""Stacks in a tube under a hypothesis: unknown fields, and some unmodelled effects."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.base_hypothesis import BaseHypothesis
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.effects.tube import Tube, TubeEffect, TubeSetting
from multilayer.diagnosis.tube.data import TubeData
from multilayer.errors import MultilayerError
from multilayer.experiments.stacks.unknowns import UnknownFields
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Minimum
from multilayer.paths import with_values
from multilayer.simulation.warned import collected_warnings

_WILDEST = 12.0  # coordinates are no further out: no value overflows
_AT_ONCE = 16_384  # samples times frequencies of one batched solve


@dataclass(frozen=True)
class Known:
    """A posterior as prior: coordinates ``centre + factor u`` of the unknowns, u standard normal.

    Attributes
    ----------
    centre : array, shape (d,)
    factor : array, shape (d, d)
        Factor times its transpose is the covariance.
    """

    centre: RealArray
    factor: RealArray

    @classmethod
    def of(cls, minimum: Minimum, *, correlated: bool = False) -> Known:
        """Return Laplace's approximation of a posterior, each unknown by itself unless `correlated`.

        Correlations are as sharp as the model is right, and a model that is off a little is off in another direction as
        soon as something changes: intervals with them are too narrow on measured plants, see
        ``docs/validation/diagnosis_tubes.md``.
        """
        if correlated:
            return cls(minimum.z, np.asarray(np.linalg.cholesky(minimum.covariance), dtype=float))
        return cls(minimum.z, np.diag(np.sqrt(np.diag(minimum.covariance))))

    def coordinates(self, u: RealArray) -> RealArray:
        """Return coordinates of the unknowns' own priors, shape (..., d), of u of the same shape."""
        return np.asarray(self.centre + u @ self.factor.T)


@dataclass(frozen=True)
class TubeHypothesis(UnknownFields, BaseHypothesis[TubeEffect]):
    """A `Problem`: nominal stacks with unknown fields, and effects; what is compared is the reflection coefficient.

    Attributes
    ----------
    measurements : tuple of TubeData
    tube : Tube
    effects : tuple of TubeEffect
    known : Known, optional
        What an earlier fit says of the unknowns, in place of their own priors.
    seen : tuple of TubeData, optional
        The data that residuals are made of; all when left out.
    """

    measurements: tuple[TubeData, ...]
    tube: Tube = field(default_factory=Tube)
    effects: tuple[TubeEffect, ...] = ()
    known: Known | None = None
    seen: tuple[TubeData, ...] | None = None

    @property
    def quantities(self) -> tuple[str, str]:
        """What the parts of R are called."""
        return ("real", "imag")

    @property
    def nominal_parameters(self) -> tuple[Parameter, ...]:
        """Coordinates of the unknowns."""
        return self.field_parameters

    @cached_property
    def start(self) -> RealArray:
        """Coordinates of the unknowns near the nominal values, or at what is known of them."""
        if self.known is not None:
            return np.zeros(len(self.nominal_parameters))
        return self.nominal_start

    def own_coordinates(self, z: RealArray) -> RealArray:
        """Return coordinates of the unknowns in their own priors, shape (..., d), of all coordinates."""
        u = z[..., : len(self.nominal_parameters)]
        return u if self.known is None else self.known.coordinates(u)

    @property
    def data(self) -> tuple[TubeData, ...]:
        """The data in use."""
        return self.measurements if self.seen is None else self.seen

    @cached_property
    def settings(self) -> tuple[TubeSetting, ...]:
        """What effects see of every measurement."""
        return tuple(
            TubeSetting(data.name, data.frequency, data.angle, self.stacks[data.stack], self.tube) for data in self.data
        )

    @property
    def blocks(self) -> int:
        """A sixth of the band of a single measurement is left out at a time."""
        return 6

    @property
    def held_out_decides(self) -> bool:
        """What tube and mounting do wrong is smooth in frequency, and common to the data kept and left out."""
        return False

    def admits(self, effect: BaseEffect) -> bool:
        """Tell whether an effect can act in some measurement: only one of tubes can."""
        return isinstance(effect, TubeEffect) and any(effect.applies(setting) for setting in self.settings)

    def with_effects(self, *effects: TubeEffect) -> TubeHypothesis:
        """Return the hypothesis of other effects."""
        return replace(self, effects=effects)

    def roughly(self, size: float) -> Callable[[RealArray], RealArray]:
        """Return residuals, shape (..., n), each part of a reflection coefficient being allowed to be off by `size`."""
        if not size:
            return self.residual
        spread = [np.stack(data.spread, axis=-1) for data in self.data]
        widths = [np.sqrt(both**2 + size**2).reshape(-1) for both in spread]

        def residual(z: RealArray) -> RealArray:
            pairs = zip(self.log_ratios(z), widths, strict=True)
            return np.concatenate([difference.view(float) / width for difference, width in pairs], axis=-1)

        return residual

    def of(self, data: Sequence[TubeData]) -> TubeHypothesis:
        """Return the same with residuals of some data only."""
        return replace(self, seen=tuple(data))

    def whitened(self, index: int, difference: ComplexArray) -> RealArray:
        """Return a difference of R of one measurement as independent unit normal numbers, shape (..., 2 n)."""
        return self.data[index].whitening(np.asarray(difference, dtype=complex))

    def log_ratios(self, z: RealArray) -> list[ComplexArray]:
        """Return R modelled minus measured, shape (..., n), of every measurement."""
        return [r - data.reflection for r, data in zip(self.reflections(z), self.data, strict=True)]

    def reflections(self, z: RealArray) -> list[ComplexArray]:
        """Return R as the tube would report it, shape (..., n), of every measurement."""
        return [self.predict(setting, data.stack, z) for setting, data in zip(self.settings, self.data, strict=True)]

    def predict(self, setting: TubeSetting, stack: str, z: RealArray) -> ComplexArray:
        """Return R of a stack in any setting, shape (..., n), of coordinates of shape (..., d)."""
        flat = np.clip(z, -_WILDEST, _WILDEST).reshape(math.prod(z.shape[:-1]), z.shape[-1])
        step = max(1, _AT_ONCE // len(setting.frequency))
        # a search leaves the range of formulae, and of numbers
        with collected_warnings(), np.errstate(all="ignore"):
            pieces = [self._batch(setting, stack, flat[i : i + step]) for i in range(0, len(flat), step)]
        return np.concatenate(pieces).reshape(*z.shape[:-1], -1)

    def _batch(self, setting: TubeSetting, stack: str, z: RealArray) -> ComplexArray:
        """Return R, shape (m, n), of coordinates of shape (m, d); NaN where there is none."""
        samples = self._samples(stack, z)
        acting = [effect.changes_gas for effect in self.effects if effect.applies(setting)]
        if not any(acting) and all(path.startswith("layers.") for path in samples):
            try:
                return self._respond(setting, stack, z)
            except MultilayerError:  # one sample without a response spoils the batch
                pass
        return np.concatenate([self._respond_or_not(setting, stack, one[None]) for one in z])

    def _respond_or_not(self, setting: TubeSetting, stack: str, z: RealArray) -> ComplexArray:
        try:
            return self._respond(setting, stack, z)
        except MultilayerError:
            return np.full((1, len(setting.frequency)), np.nan + 0j)

    def _respond(self, setting: TubeSetting, stack: str, z: RealArray) -> ComplexArray:
        samples = self._samples(stack, z)
        # the gas takes no arrays: a single sample is written as numbers
        alone = {path: column.item() for path, column in samples.items()} if len(z) == 1 else {}
        sample = with_values(self.stacks[stack], alone or {path: c[:, None] for path, c in samples.items()})
        values = self.effect_values(z)
        acting = [pair for pair in zip(self.effects, values, strict=True) if pair[0].applies(setting)]
        for effect, own in acting:
            sample = effect.stack(setting, sample, own)
        reflection = np.array(np.broadcast_to(setting.reflection(sample), (len(z), len(setting.frequency))))
        for effect, own in acting:
            reflection = effect.surface(setting, sample, reflection, own)
        for effect, own in acting:
            reflection = effect.reading(setting, reflection, own)
        return np.broadcast_to(reflection, (len(z), len(setting.frequency)))

    def _samples(self, stack: str, z: RealArray) -> dict[str, RealArray]:
        """Return by path the values, shape (m,), of the unknown fields of a stack."""
        return self.samples(self.own_coordinates(z))[stack]
