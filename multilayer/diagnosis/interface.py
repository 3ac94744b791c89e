"""What the diagnosis knows of a model under hypotheses: the two-plate rig and the tube are two of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol, Self

from multilayer.arrays import ComplexArray, IndexArray, RealArray
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.inference.priors import Parameter


class AnyData(Protocol):
    """Measured complex values of one configuration."""

    @property
    def name(self) -> str:
        """Of the configuration."""

    @property
    def frequency(self) -> RealArray:
        """Hz, shape (n,)."""

    @property
    def burst(self) -> IndexArray:
        """To which group each value belongs, shape (n,): what is left out together."""

    @property
    def centres(self) -> RealArray:
        """Frequencies of the groups, Hz, shape (n_groups,)."""

    def part(self, kept: IndexArray) -> Self:
        """Return the data of some groups only, numbered anew."""


class AnyHypothesis(Protocol):
    """A `Problem`: a nominal model with effects."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects."""

    @property
    def effects(self) -> tuple[BaseEffect, ...]:
        """The effects."""

    @property
    def effect_parameters(self) -> tuple[Parameter, ...]:
        """Their parameters, as ``sensor_mass.mass``."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The nominal model's unknowns, then those of the effects."""

    @property
    def data(self) -> tuple[AnyData, ...]:
        """What residuals are made of."""

    @property
    def quantities(self) -> tuple[str, str]:
        """What real and imaginary part of `log_ratios` are."""

    @property
    def blocks(self) -> int:
        """In how many pieces the data of a single configuration are left out, one after the other."""

    @property
    def held_out_decides(self) -> bool:
        """Whether errors of left-out data are their own, so that what foretells these tells causes apart."""

    def admits(self, effect: BaseEffect) -> bool:
        """Tell whether an effect can act here at all."""

    def with_effects(self, *effects: Any) -> Self:
        """Return the hypothesis of other effects, of the kind it admits."""

    def without(self, index: int, z: RealArray) -> tuple[Self, RealArray]:
        """Return the hypothesis without one of its effects, and the coordinates, shape (..., d), that are left."""

    def of(self, data: Sequence[Any]) -> Self:
        """Return the same with residuals of some data only."""

    def residual(self, z: RealArray) -> RealArray:
        """Return whitened residuals, shape (..., n_data)."""

    def roughly(self, size: float) -> Callable[[RealArray], RealArray]:
        """Return residuals for a first search, each datum being allowed to be off by `size` more, relative."""

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual and derivative."""

    def whitened(self, index: int, difference: ComplexArray) -> RealArray:
        """Return a complex difference of one configuration, shape (..., n), as independent unit normal numbers."""

    def log_ratios(self, z: RealArray) -> list[ComplexArray]:
        """Return modelled minus measured, shape (..., n), of every configuration, in the quantity that is fitted.

        That is ln(ratio) of the rig, and the reflection coefficient itself of a tube, which may be 0.
        """

    def law_change(self, index: int, z: RealArray, shown: Sequence[ComplexArray] | None = None) -> list[ComplexArray]:
        """Return what the law of one of the effects, wrong by its whole size, would change in `log_ratios`.

        Of coordinates of shape (..., d); `shown` are the `log_ratios` there where they are known already.
        """


__all__ = ["AnyData", "AnyHypothesis"]
