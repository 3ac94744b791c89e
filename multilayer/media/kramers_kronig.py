"""Kramers-Kronig relations: the loss modulus E2 from the dispersion of E1, and a check of measured moduli.

Time exp(+i w t). Stress does not precede strain, so E1 and E2 are two views of one function; a loss without a rise of
E1 with frequency, or a fall of E1, betrays an error of the measurement or of the model behind it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import nnls
from scipy.special import ndtr, spence

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.chi2 import exceeding
from multilayer.errors import InputError
from multilayer.media.laws.spectral import step_relaxation

Verdict = Literal["consistent", "inconsistent", "cannot tell"]
_BEYOND = 4.0  # decades of spectrum on either side of the data; what lies farther is a spring or a dashpot
_PER_DECADE = 20
_TOO_GOOD = 1e-3
_REACH = np.pi * (5 / 6) ** 0.5  # in ln f, of a slope to either side: see `gross_loss_modulus`
_PARABOLA = 3  # terms, and so points at least


def gross_loss_modulus(frequency: ArrayLike, storage_modulus: ArrayLike) -> RealArray:
    """Return E2 = (pi/2) E1 d ln E1/d ln w, Pa, from the slope of E1.

    Bonfiglio & Pompoli, Polymer Testing 48 (2015) 89-96, eq. (12), after B. Gross, Mathematical Structure of the
    Theories of Viscoelasticity, Hermann 1953. The leading term of the Kramers-Kronig relation: exact where E1 is
    linear in ln w over decades to both sides. For E ~ (i w)^n it is (pi n/2)/tan(pi n/2) of the true one, 5 % low at
    n = 0.25 and 21 % at n = 0.5.

    The slope at a frequency is that of the parabola in ln w that fits ln E1 best at all frequencies from 1/18 of it
    to 18 times, at the nearest three at least. The difference of two neighbours would magnify errors of E1 many times.

    Parameters
    ----------
    frequency : array, shape (n,)
        Hz, increasing, at least two.
    storage_modulus : array, shape (n,)
        Pa.

    Notes
    -----
    The full relation is a mean of dE1/d ln w over v = ln(u/w) with the weight ln coth|v/2|, whose variance is pi^2/6.
    A parabola over -h to h takes a mean with the weight h^2 - v^2, of variance h^2/5. So with h = pi sqrt(5/6) the
    slope is taken over the same range as in the relation itself; ln 18 is about that.
    """
    x, e1 = np.log(frequency), np.asarray(storage_modulus, dtype=float)
    distance = x - x[:, np.newaxis]
    terms = min(_PARABOLA, x.size)
    nearest = np.sort(np.abs(distance), axis=-1)[:, terms - 1 : terms]
    near = np.abs(distance) <= np.maximum(nearest, _REACH)
    powers = near[..., np.newaxis] * distance[..., np.newaxis] ** np.arange(terms)
    slope = np.linalg.pinv(powers)[:, 1] @ np.log(e1)
    return np.asarray(np.pi / 2 * e1 * slope)


def kramers_kronig_loss_modulus(
    frequency: ArrayLike, storage_modulus: ArrayLike, at: ArrayLike | None = None
) -> RealArray:
    """Return E2, Pa, that the dispersion of E1 over the whole frequency axis demands.

    ``E2(w) = (1/pi) integral of dE1/d ln u  ln|(u + w)/(u - w)| d ln u``, the Kramers-Kronig relation integrated by
    parts (H. C. Booij & G. P. J. M. Thoone, Rheol. Acta 21 (1982) 15-24), exact for E1 piecewise linear in ln f. A
    dashpot in parallel, i w eta, leaves no trace in E1 and is not seen. Dispersion outside the given frequencies
    counts as none: give some decades more than E2 is wanted at, or use `check_kramers_kronig`.

    Parameters
    ----------
    frequency : array, shape (n,)
        Hz, increasing.
    storage_modulus : array, shape (n,)
        Pa.
    at : array, shape (m,), optional
        Hz, where E2 is wanted: at all frequencies when left out.
    """
    x, e1 = np.log(frequency), np.asarray(storage_modulus, dtype=float)
    wanted = x if at is None else np.log(at)
    weight = np.diff(_kernel_integral(x - wanted[:, np.newaxis]), axis=-1)
    return np.asarray(weight @ (np.diff(e1) / np.diff(x)) / np.pi)


def _kernel_integral(v: RealArray) -> RealArray:
    """Return the integral of ln coth(|t|/2) over t from 0 to v, by the dilogarithm Li2(z) = spence(1 - z)."""
    z = np.exp(-np.abs(v))
    return np.asarray(np.sign(v) * (np.pi**2 / 4 - spence(1 - z) + spence(1 + z)))


def spectrum_columns(frequency: ArrayLike, nodes: RealArray) -> ComplexArray:
    """Return the moduli of a unit spring, and of a unit rise in each step between `nodes` (Hz).

    Parameters
    ----------
    frequency : array, shape (n,)
        Hz.
    nodes : array, shape (m,)
        Hz, increasing; see `laws.FreeForm`.

    Returns
    -------
    array, shape (n, m)
        First the spring, then the steps.
    """
    f = np.asarray(frequency, dtype=float)[:, np.newaxis]
    return np.concatenate([np.ones_like(f, dtype=complex), step_relaxation(f, nodes[:-1], nodes[1:])], axis=1)


def non_negative_fit(
    columns: ComplexArray, modulus: ComplexArray, storage_std: RealArray, loss_std: RealArray
) -> tuple[RealArray, RealArray]:
    """Return the weights >= 0 that fit a modulus best by least squares: a convex problem with one minimum.

    C. L. Lawson & R. J. Hanson, Solving Least Squares Problems, Prentice-Hall 1974, chapter 23.

    Parameters
    ----------
    columns : array, shape (n, m)
    modulus : array, shape (n,)
    storage_std, loss_std : array, shape (n,)
        Standard deviations of the real and the imaginary part.

    Returns
    -------
    weights : array, shape (m,)
    residual : array, shape (2, n)
        Fit minus modulus over standard deviation, of E1 and of E2.
    """
    matrix = np.concatenate([columns.real / storage_std[:, np.newaxis], columns.imag / loss_std[:, np.newaxis]])
    wanted = np.concatenate([modulus.real / storage_std, modulus.imag / loss_std])
    size = np.linalg.norm(matrix, axis=0)
    weights = nnls(matrix / size, wanted, maxiter=30 * matrix.shape[1])[0] / size
    return weights, (matrix @ weights - wanted).reshape(2, -1)


@dataclass(frozen=True)
class KramersKronigCheck:
    """Whether measured moduli can be those of a causal, passive, relaxing material.

    Attributes
    ----------
    verdict : {'consistent', 'inconsistent', 'cannot tell'}
    reasons : tuple of str
        Sentences for the user.
    p_value : float
        Probability of a chi-square at least as large from such a material; nan without degrees of freedom.
    chi_square : float
        Sum of the squared normalised residuals.
    degrees_of_freedom : int
        Data less the elements of the best curve.
    frequency : array, shape (n,)
        Hz.
    modulus : array, shape (n,)
        The best curve, Pa.
    residual : array, shape (2, n)
        Best curve minus data over standard deviation, of E1 and E2.
    """

    verdict: Verdict
    reasons: tuple[str, ...]
    p_value: float
    chi_square: float
    degrees_of_freedom: int
    frequency: RealArray
    modulus: ComplexArray
    residual: RealArray

    @property
    def reduced_chi_square(self) -> float:
        """Chi-square over degrees of freedom, near 1 for good data with true standard deviations."""
        return self.chi_square / self.degrees_of_freedom if self.degrees_of_freedom > 0 else float("nan")

    @property
    def largest_residual(self) -> float:
        """The largest distance between curve and data, in standard deviations."""
        return float(np.max(np.abs(self.residual)))


def check_kramers_kronig(
    frequency: ArrayLike,
    modulus: ArrayLike,
    storage_std: ArrayLike,
    loss_std: ArrayLike,
    *,
    significance: float = 0.01,
    factor: float = 1.5,
) -> KramersKronigCheck:
    """Judge whether measured E1 and E2 with their standard deviations can belong together.

    The best of all causal curves is fitted: a spring, a dashpot and a non-negative relaxation spectrum, free from four
    decades below to four above the data, by non-negative least squares. Its chi-square and its largest residual then
    decide, with half the significance each. Nothing is assumed beyond the data, so a limited band is allowed, but it
    may leave E2 free: the check is repeated with E2 `factor` times larger and smaller, and the verdict is "cannot tell"
    unless both are rejected.

    Parameters
    ----------
    frequency : array, shape (n,)
        Hz.
    modulus : array, shape (n,)
        E1 + i E2, Pa.
    storage_std, loss_std : float or array
        Standard deviations of E1 and E2, Pa; errors are taken as independent and normal.
    significance : float
        Share of good data called inconsistent.
    factor : float
        The error of E2 that the data must be able to reveal.

    Returns
    -------
    KramersKronigCheck

    Raises
    ------
    InputError
        For moduli, frequencies or standard deviations that are not finite or not positive.

    Notes
    -----
    Given the elements that end up with a weight, the residual of a projection on a cone follows chi-square with as
    many degrees of freedom as there are data less elements (A. Shapiro, Int. Stat. Rev. 56 (1988) 49-62). The
    spectrum has 20 steps a decade: enough for standard deviations down to 0.1 %. Limits: errors that scale E1 and E2
    alike (a wrong thickness) pass; a medium with resonances of its own, whose E1 may fall, is causal and called
    inconsistent all the same.
    """
    f, e = np.asarray(frequency, dtype=float), np.asarray(modulus, dtype=complex)
    s1, s2 = (np.broadcast_to(np.asarray(std, dtype=float), f.shape) for std in (storage_std, loss_std))
    _refuse_bad(f, e, s1, s2)
    best = _best_curve(f, e, s1, s2)
    wrong = {k: _best_curve(f, e.real + 1j * k * e.imag, s1, s2) for k in (factor, 1 / factor)}
    missed = [k for k, curve in wrong.items() if not curve.rejected(significance)]
    verdict, reasons = _judge(f, e, best, significance, missed)
    return KramersKronigCheck(
        verdict, reasons, best.p_value, best.chi_square, best.freedom, f, best.curve, best.residual
    )


@dataclass(frozen=True)
class _Best:
    """The causal curve nearest to some data."""

    curve: ComplexArray
    residual: RealArray
    freedom: int

    @property
    def chi_square(self) -> float:
        return float(np.sum(self.residual**2))

    @property
    def p_value(self) -> float:
        return exceeding(self.chi_square, self.freedom) if self.freedom > 0 else float("nan")

    def rejected(self, significance: float) -> bool:
        """Tell whether the sum of squares, or the largest of all residuals, is too improbable."""
        outlier = self.residual.size * 2 * ndtr(-float(np.max(np.abs(self.residual))))
        return self.freedom > 0 and min(self.p_value, outlier) < significance / 2


def _best_curve(f: RealArray, e: ComplexArray, storage_std: RealArray, loss_std: RealArray) -> _Best:
    low, high = np.log10(f.min()) - _BEYOND, np.log10(f.max()) + _BEYOND
    nodes = np.logspace(low, high, int(_PER_DECADE * (high - low)) + 1)
    dashpot = 1j * (f / f.max())[:, np.newaxis]
    columns = np.concatenate([spectrum_columns(f, nodes), dashpot], axis=1)
    weights, residual = non_negative_fit(columns, e, storage_std, loss_std)
    return _Best(np.asarray(columns @ weights, dtype=complex), residual, 2 * f.size - int(np.count_nonzero(weights)))


def _judge(
    f: RealArray, e: ComplexArray, best: _Best, significance: float, missed: list[float]
) -> tuple[Verdict, tuple[str, ...]]:
    if best.freedom < 1:
        return "cannot tell", (f"{f.size} frequencies leave nothing to judge by; measure at more",)
    chance = f"chi-square {best.chi_square:.3g} for {best.freedom} degrees of freedom, p = {best.p_value:.2g}"
    if best.rejected(significance):
        part, i = np.unravel_index(int(np.argmax(np.abs(best.residual))), best.residual.shape)
        where = f"E{part + 1} at {f[i]:g} Hz"
        off = f"{abs(best.residual[part, i]):.1f} standard deviations"
        relative = float(np.mean(np.abs(best.curve / e - 1)))
        return "inconsistent", (
            f"no causal passive material has these moduli ({chance})",
            f"the nearest one is {100 * relative:.1g} % off in the mean, at most {off}, in {where}",
        )
    reasons = [f"a causal passive material has moduli as near as this ({chance})"]
    if 1 - best.p_value < _TOO_GOOD:
        reasons.append(
            "the data scatter less than their standard deviations say: those are too large, or common errors"
        )
    reasons += [
        f"E2 {factor:.2g} times as large would pass as well: widen the band or reduce the noise" for factor in missed
    ]
    return ("cannot tell" if missed else "consistent"), tuple(reasons)


def _refuse_bad(f: RealArray, e: ComplexArray, storage_std: RealArray, loss_std: RealArray) -> None:
    if f.ndim != 1 or f.shape != e.shape or f.size < 2:
        raise InputError(f"frequency {f.shape} and modulus {e.shape} must be lists of one length, at least two")
    good = np.isfinite(f) & np.isfinite(e) & (f > 0) & (e.real > 0)
    if not np.all(good):
        raise InputError(f"entry {int(np.argmin(good)) + 1}: frequency and E1 must be finite and above 0; leave it out")
    known = np.isfinite(storage_std) & np.isfinite(loss_std) & (storage_std > 0) & (loss_std > 0)
    if not np.all(known):
        where = int(np.argmin(known)) + 1
        raise InputError(
            f"entry {where}: standard deviations must be finite and above 0; state what is not known small"
        )
