"""Laws that relax from one plateau to another: springs and dashpots in chains, fractional or not.

All have a non-negative relaxation spectrum, ``E = E0 + integral of H(tau) i w tau/(1 + i w tau) d ln tau``: they are
causal, passive, and their E1 never falls as frequency rises.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ArrayLike, ComplexArray, Numeric, RealArray
from multilayer.media.laws.base import Limit, ModulusLaw
from multilayer.units import DIMENSIONLESS, Duration, PositiveRatio, Pressure, Unit

Order = Annotated[float, Field(gt=0, le=1), Unit(DIMENSIONLESS)]

RISES = Limit(
    {"relaxed_modulus": 1, "unrelaxed_modulus": -1},
    "unrelaxed_modulus must be at least relaxed_modulus, or the law creates energy",
)


class Zener(ModulusLaw):
    """E = E0 + (Einf - E0) i w tau/(1 + i w tau): the standard linear solid.

    A spring beside a spring and dashpot in series; `relaxation_time` tau is that at constant strain. C. Zener,
    Elasticity and Anelasticity of Metals, Chicago 1948; N. W. Tschoegl, The Phenomenological Theory of Linear
    Viscoelastic Behavior, Springer 1989, ch. 3. Causal and passive for Einf >= E0. E2 has one peak, 1.14 decades wide
    at half its height: narrower than that of any polymer.
    """

    limits: ClassVar[tuple[Limit, ...]] = (RISES,)
    law: Literal["zener"] = "zener"
    relaxed_modulus: Pressure
    unrelaxed_modulus: Pressure
    relaxation_time: Duration

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        rise = self.unrelaxed_modulus - self.relaxed_modulus
        return np.asarray(self.relaxed_modulus + rise * relaxation(frequency, self.relaxation_time))


class FractionalZener(ModulusLaw):
    """E = (E0 + Einf s)/(1 + s), s = (i w tau)^alpha.

    Four-parameter fractional standard solid: T. Pritz, J. Sound Vib. 195 (1996) 103-115. Causal and passive for
    0 < alpha <= 1 and Einf >= E0.
    """

    limits: ClassVar[tuple[Limit, ...]] = (RISES,)
    law: Literal["fractional_zener"] = "fractional_zener"
    relaxed_modulus: Pressure
    unrelaxed_modulus: Pressure
    relaxation_time: Duration
    order: Order

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        inverse = (2j * np.pi * np.asarray(frequency) * self.relaxation_time) ** -self.order
        rise = self.unrelaxed_modulus - self.relaxed_modulus
        return np.asarray(self.relaxed_modulus + rise / (1 + inverse))  # rounding cannot make Im(E) negative


class HavriliakNegami(ModulusLaw):
    """E = Einf + (E0 - Einf)/(1 + (i w tau)^alpha)^beta.

    Five parameters, the loss peak being skewed by `asymmetry` beta: E2 rises as f^alpha below the peak and falls as
    f^(-alpha beta) above. S. Havriliak & S. Negami, Polymer 8 (1967) 161-210; of moduli: B. Hartmann, G. F. Lee &
    J. D. Lee, J. Acoust. Soc. Am. 95 (1994) 226-233. With beta = 1 it is `FractionalZener`, with alpha = beta = 1
    `Zener`.

    Allowed are Einf >= E0, 0 < alpha <= 1 and 0 < alpha beta <= 1, just where the relaxation spectrum is nowhere
    negative (E. Capelas de Oliveira, F. Mainardi & J. Vaz, Eur. Phys. J. Spec. Top. 193 (2011) 161-171). Up to
    alpha beta = 2 energy would still be lost at every frequency, but a strained sample at rest would see its stress
    rise again.
    """

    limits: ClassVar[tuple[Limit, ...]] = (
        RISES,
        Limit(
            {"order": 1, "asymmetry": 1},
            "order times asymmetry must be at most 1, or the relaxation spectrum turns negative",
        ),
    )
    law: Literal["havriliak_negami"] = "havriliak_negami"
    relaxed_modulus: Pressure
    unrelaxed_modulus: Pressure
    relaxation_time: Duration
    order: Order
    asymmetry: PositiveRatio

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        s = (2j * np.pi * np.asarray(frequency) * self.relaxation_time) ** self.order
        fall = self.unrelaxed_modulus - self.relaxed_modulus
        return np.asarray(self.unrelaxed_modulus - fall * (1 + s) ** -self.asymmetry)


def relaxation(frequency: ArrayLike, time: Numeric) -> ComplexArray:
    """Return i x/(1 + i x), x = w tau, by its parts: rounding cannot make the loss negative.

    Parameters
    ----------
    frequency : array
        Hz.
    time : float or array
        Relaxation time tau, s.
    """
    x: RealArray = np.asarray(2 * np.pi * np.asarray(frequency) * time, dtype=float)
    return np.asarray((x + 1j) * (x / (1 + x * x)))
