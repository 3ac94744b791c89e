"""Laws of many elements: generalised Maxwell, and the free form, a relaxation spectrum of steps."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from multilayer.arrays import ArrayLike, ComplexArray, Numeric, RealArray
from multilayer.media.laws.base import LossModulus, ModulusLaw
from multilayer.media.laws.relaxing import relaxation
from multilayer.units import Duration, Frequency, Pressure

_MARGIN = 10.0  # relaxations up to a decade outside the data still show in them


class Maxwell(ModulusLaw):
    """E = E0 + sum over k of E_k i w tau_k/(1 + i w tau_k): generalised Maxwell, a Prony series in time.

    A spring beside springs in series with dashpots: `branch_modulus` E_k and `relaxation_time` tau_k, one entry a
    branch. N. W. Tschoegl, The Phenomenological Theory of Linear Viscoelastic Behavior, Springer 1989, ch. 3. Causal
    and passive for E_k >= 0. With fewer than about one branch a decade E2 ripples; far outside the relaxation times
    there is no loss.
    """

    law: Literal["maxwell"] = "maxwell"
    relaxed_modulus: Pressure
    branch_modulus: Annotated[tuple[LossModulus, ...], Field(min_length=1)]
    relaxation_time: Annotated[tuple[Duration, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _paired(self) -> Self:
        if len(self.branch_modulus) != len(self.relaxation_time):
            raise ValueError(
                f"branch_modulus has {len(self.branch_modulus)} entries and relaxation_time "
                f"{len(self.relaxation_time)}; give one of each per branch"
            )
        return self

    @classmethod
    def spread(cls, elements: int, low: float, high: float) -> Self:
        times = (1 / (2 * np.pi * np.geomspace(low, high, elements))).tolist()
        return cls(relaxed_modulus=1.0, branch_modulus=(1.0,) * elements, relaxation_time=tuple(times))

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        branches = zip(self.branch_modulus, self.relaxation_time, strict=True)
        return np.asarray(sum((e * relaxation(frequency, tau) for e, tau in branches), self.relaxed_modulus + 0j))


class FreeForm(ModulusLaw):
    """E of any shape along log frequency that is causal and passive: a relaxation spectrum of steps.

    Between the nodes f_k and f_(k+1) of `frequency` the relaxation spectrum is constant over ln f, such that E1 rises
    by `rise` g_k >= 0 in all:
    ``E = E0 + sum over k of g_k ln((1 + i f/f_k)/(1 + i f/f_(k+1)))/ln(f_(k+1)/f_k)``, with one rise fewer than nodes.

    Free are rises, not values of E at the nodes: E1 and E2 are one function, and values chosen one by one would
    contradict the Kramers-Kronig relations, while every set of rises obeys them. It is linear in them (a fit has one
    minimum, found without a start). Steps instead of the lines of `Maxwell` leave no ripple however far apart the
    nodes, and their integral is elementary (that of ``i w tau/(1 + i w tau)`` over ln tau). Below a step E2 falls as f
    and above as 1/f, so the nodes should reach about a decade beyond the frequencies of interest; finer than about
    three a decade, no data tell neighbours apart.
    """

    grid: ClassVar[tuple[str, ...]] = ("frequency",)
    law: Literal["free_form"] = "free_form"
    relaxed_modulus: Pressure
    frequency: Annotated[tuple[Frequency, ...], Field(min_length=2)]
    rise: Annotated[tuple[LossModulus, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if len(self.rise) != len(self.frequency) - 1:
            raise ValueError(
                f"{len(self.frequency)} frequencies bound {len(self.frequency) - 1} steps; "
                f"rise has {len(self.rise)} entries"
            )
        if any(b <= a for a, b in pairwise(self.frequency)):
            raise ValueError("the frequencies of the nodes must increase")
        return self

    @classmethod
    def spread(cls, elements: int, low: float, high: float) -> Self:
        nodes = np.geomspace(low / _MARGIN, high * _MARGIN, elements + 1).tolist()
        return cls(relaxed_modulus=1.0, frequency=tuple(nodes), rise=(1.0,) * elements)

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        steps = zip(self.rise, pairwise(self.frequency), strict=True)
        return np.asarray(sum((g * step_relaxation(frequency, *ends) for g, ends in steps), self.relaxed_modulus + 0j))


def step_relaxation(frequency: ArrayLike, low: Numeric, high: Numeric) -> ComplexArray:
    """Return the modulus over its rise of a relaxation spectrum that is constant over ln f between two frequencies.

    The mean of ``i f/fr/(1 + i f/fr)`` over ln fr from `low` to `high`, which is
    ``ln((1 + i f/low)/(1 + i f/high))/ln(high/low)``; by parts that neither cancel nor let the loss turn negative.

    Parameters
    ----------
    frequency, low, high : array
        Hz, with high > low; they broadcast.
    """
    f: RealArray = np.asarray(frequency, dtype=float)
    a, b = np.asarray(f / low, dtype=float), np.asarray(f / high, dtype=float)
    storage = np.log1p((a - b) * (a + b) / (1 + b * b)) / 2
    loss = np.arctan((a - b) / (1 + a * b))
    return np.asarray((storage + 1j * loss) / np.log(high / low))
