"""How far a material may depart from a modulus law: a causal, smooth deviation whose size is stated.

No polymer follows a law of four parameters exactly. A fit of such a law gives intervals of the law, not of the
material: they narrow with more data, while the law's error stays. Relaxation steps: C. Zener, Elasticity and
Anelasticity of Metals, Univ. of Chicago Press 1948; loss as the slope of ln E: H. C. Booij &
G. P. J. M. Thoone, Rheol. Acta 21 (1982) 15-24.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.inference.priors import Parameter, Prior

PER_DECADE = 3  # a step is 1.14 decades wide: more of them cannot be distinguished
_MARGIN = 10.0  # factor beyond the data on either side: steps there change the slope within the band


@dataclass(frozen=True, eq=False)
class LawDeviation:
    """A factor ``exp(d(f))`` on a law, d a sum of relaxation steps of either sign with independent normal heights.

    ``d(f) = share eta sum_k a_k i w t_k / (1 + i w t_k)``, a_k standard normal, the times t_k evenly spaced in their
    logarithm. ln E of a passive law is analytic in the half-plane where E is, for E vanishes nowhere in it, and so is
    every step: the product obeys the Kramers-Kronig relations like the law. The real part of d walks at random along
    ln f, smoothed over a decade; the imaginary part is its slope times pi/2.

    Attributes
    ----------
    share : float
        Relative departure of the material's relaxation from the law's; its loss factor departs by about as much.
    loss : float
        The law's loss factor eta, a mean over the data: a material of little relaxation departs little.
    times : array, shape (n,)
        Relaxation times, s.
    """

    share: float
    loss: float
    times: RealArray

    @classmethod
    def over(cls, frequency: RealArray, share: float, loss: float) -> LawDeviation:
        """Return the deviation for data at some frequencies, Hz."""
        low, high = np.min(frequency) / _MARGIN, np.max(frequency) * _MARGIN
        count = 1 + int(np.ceil(PER_DECADE * np.log10(high / low)))
        return cls(share, loss, 1 / (2 * np.pi * np.geomspace(low, high, count)))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The heights of the steps, as nuisances."""
        standard = Prior(normal=(0.0, 1.0))
        return tuple(
            Parameter(name=f"law_deviation[{1 / (2 * np.pi * t):.3g} Hz]", prior=standard, nuisance=True)
            for t in self.times
        )

    def factor(self, heights: RealArray, frequency: RealArray) -> ComplexArray:
        """Return ``exp(d(f))``, shape (..., n_frequency), for standard normal heights of shape (..., n)."""
        s = 2j * np.pi * np.asarray(frequency) * self.times[:, None]
        # relative to the middle of each step, or the law's moduli would be collinear with the sum of the steps
        return np.asarray(np.exp(self.share * self.loss * (heights @ (s / (1 + s) - 0.5))))
