"""Laws of one spring: constant, with losses that do not depend on frequency, or beside a dashpot.

Constant losses: S. H. Crandall, J. Sound Vib. 11 (1970) 3-18; spring and dashpot: N. W. Tschoegl, The Phenomenological
Theory of Linear Viscoelastic Behavior, Springer 1989, ch. 3.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray
from multilayer.media.laws.base import LossModulus, ModulusLaw
from multilayer.units import Pressure, Ratio, Viscosity


def _imaginary(frequency: ArrayLike) -> ComplexArray:
    """Return i sgn(f): the imaginary part is odd in frequency, else the stress of a real strain would be complex."""
    return np.asarray(1j * np.copysign(1.0, frequency))


class Constant(ModulusLaw):
    """E = E1: no loss, no dispersion."""

    law: Literal["constant"] = "constant"
    young_modulus: Pressure

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        return np.asarray(self.young_modulus + 0j * np.asarray(frequency))


class Complex(ModulusLaw):
    """E = E1 + i E2 sgn(f), both constant.

    Not causal: a loss without dispersion answers before it is asked. Good within a band so narrow, or for a loss so
    small, that E1 hardly changes: by (2/pi) E2 ln(f2/f1) between f1 and f2 (`kramers_kronig.gross_loss_modulus`).
    """

    causal: ClassVar[bool] = False
    law: Literal["complex"] = "complex"
    storage_modulus: Pressure
    loss_modulus: LossModulus

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        return np.asarray(self.storage_modulus + self.loss_modulus * _imaginary(frequency))


class LossFactor(ModulusLaw):
    """E = E1 (1 + i eta sgn(f)): structural damping; not causal, see `Complex`."""

    causal: ClassVar[bool] = False
    law: Literal["loss_factor"] = "loss_factor"
    young_modulus: Pressure
    loss_factor: Ratio

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        return np.asarray(self.young_modulus * (1 + self.loss_factor * _imaginary(frequency)))


class KelvinVoigt(ModulusLaw):
    """E = E1 + i w eta: a spring beside a dashpot of `viscosity` eta."""

    law: Literal["kelvin_voigt"] = "kelvin_voigt"
    young_modulus: Pressure
    viscosity: Viscosity

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        return np.asarray(self.young_modulus + 2j * np.pi * np.asarray(frequency) * self.viscosity)
