"""Time-temperature superposition: one master curve from moduli measured at several temperatures."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.errors import InputError, ValidityWarning
from multilayer.inference.least_squares import trust_region
from multilayer.media.kramers_kronig import non_negative_fit, spectrum_columns
from multilayer.media.laws import FreeForm
from multilayer.media.superposition import ShiftFit, entropic_shift, fit_arrhenius, fit_wlf, matching_log_shift

Vertical = Literal["none", "entropic", "free"]
IndexArray: TypeAlias = NDArray[np.intp]
_STEPS_PER_DECADE = 3
_BEYOND = 1.5  # decades of spectrum beyond the reduced frequencies
_DECADE = np.log(10)
_STEP = 1e-4
_LEAST_SPRING = 1e-9


@dataclass(frozen=True)
class MasterCurve:
    """Moduli of several temperatures, brought to one.

    Attributes
    ----------
    reference : float
        Its temperature, K.
    temperature : array, shape (m,)
        The temperatures measured at, K, increasing.
    log_shift : array, shape (m,)
        log10 a_T.
    log_shift_covariance : array, shape (m, m)
        Its covariance; zero for the reference.
    vertical : array, shape (m,)
        b_T.
    index : array of int, shape (n,)
        To which of the temperatures each datum belongs.
    frequency : array, shape (n,)
        Reduced frequency a_T f, Hz, in the order of the data.
    modulus : array, shape (n,)
        Reduced modulus E/b_T, Pa.
    law : FreeForm
        The relaxation spectrum behind the curve.
    """

    reference: float
    temperature: RealArray
    log_shift: RealArray
    log_shift_covariance: RealArray = field(repr=False)
    vertical: RealArray
    index: IndexArray = field(repr=False)
    frequency: RealArray = field(repr=False)
    modulus: ComplexArray = field(repr=False)
    law: FreeForm = field(repr=False)

    @property
    def log_shift_std(self) -> RealArray:
        """Standard deviation of log10 a_T."""
        return np.asarray(np.sqrt(np.diag(self.log_shift_covariance)))

    @property
    def relative_error(self) -> RealArray:
        """``|E_law - E|/|E|`` of each datum."""
        return np.abs(self.law(self.frequency) / self.modulus - 1)

    @property
    def error_by_temperature(self) -> RealArray:
        """Mean relative error of each temperature's data: high where a curve does not fit in with the others."""
        return np.bincount(self.index, self.relative_error) / np.bincount(self.index)

    @property
    def gaps(self) -> RealArray:
        """Decades of reduced frequency between the data of each temperature and the next; negative for an overlap."""
        x = [np.log10(self.frequency[self.index == k]) for k in range(self.temperature.size)]
        return np.array([colder.min() - warmer.max() for colder, warmer in pairwise(x)])

    def wlf(self, above: float = 0.0) -> ShiftFit:
        """Return Williams, Landel and Ferry's formula fitted to the shifts `above` a temperature (K).

        It holds from the glass transition up; see `superposition.wlf_log_shift`. By the covariance of the shifts: one
        across a gap counts little, and errors that all beyond it share are known as such.
        """
        return self._shift_fit(fit_wlf, above)

    def arrhenius(self, above: float = 0.0) -> ShiftFit:
        """Return Arrhenius' law fitted to the shifts `above` a temperature (K)."""
        return self._shift_fit(fit_arrhenius, above)

    def _shift_fit(self, fit: Callable[[RealArray, RealArray, float, RealArray], ShiftFit], above: float) -> ShiftFit:
        chosen = self.temperature >= above
        if np.count_nonzero(chosen) < 4:
            raise InputError(
                f"{np.count_nonzero(chosen)} temperatures lie above {above:g} K: four are needed for a fit"
            )
        covariance = self.log_shift_covariance[np.ix_(chosen, chosen)]
        return fit(self.temperature[chosen], self.log_shift[chosen], self.reference, covariance)


def master_curve(
    temperature: ArrayLike,
    frequency: ArrayLike,
    modulus: ArrayLike,
    *,
    reference: float | None = None,
    vertical: Vertical = "none",
    expansion: float = 0.0,
    vertical_std: float = 0.05,
) -> MasterCurve:
    """Shift moduli of several temperatures along log frequency until they make one curve.

    The curve and the shifts are sought together: for given shifts the best causal curve (a free-form law, three steps
    a decade) follows by non-negative least squares of the relative error (E_law - E)/E; the shifts minimise what is
    left, by Gauss-Newton with the curve projected out (variable projection: G. H. Golub & V. Pereyra, Inverse Problems
    19 (2003) R1-R26, with Kaufman's Jacobian). E1, E2 and their Kramers-Kronig relation all take part. The start
    matches E1 of neighbours.

    Parameters
    ----------
    temperature, frequency, modulus : array, shape (n,)
        K, Hz and E1 + i E2 in Pa, one entry per datum, in any order.
    reference : float, optional
        K, one of the temperatures; by default the middle one.
    vertical : {'none', 'entropic', 'free'}
        b_T = 1, b_T = T rho/(T0 rho0), or sought as well.
    expansion : float
        Volumetric thermal expansion for 'entropic', 1/K.
    vertical_std : float
        Standard deviation of ln b_T expected of 'free'. Where E is a power of frequency both shifts do the same, and
        data alone cannot tell them apart.

    Returns
    -------
    MasterCurve

    Raises
    ------
    InputError
        For data that are no moduli, a single temperature, or a reference not measured at.

    Notes
    -----
    Assumes a thermorheologically simple material: one mechanism, no melting or curing within the temperatures. Look at
    `MasterCurve.error_by_temperature` to see whether it is. The standard deviations take errors as independent. Over a
    gap in reduced frequency many curves are causal: shifts beyond it are guesses, for which a `ValidityWarning` stands.
    """
    t, f, e = _checked(temperature, frequency, modulus)
    levels, index = np.unique(t, return_inverse=True)
    middle = _reference_index(levels, reference)
    known = entropic_shift(levels, levels[middle], expansion) if vertical == "entropic" else np.ones(levels.size)
    e = e / known[index]
    start = _matched(index, f, e.real, middle)
    moved = np.delete(np.arange(levels.size), middle)
    problem = _Superposition(f, e, index, moved, _nodes(f * np.exp(start[index])))
    x, covariance = problem.solve(start[moved])
    if vertical == "free":
        noise = float(np.sqrt(np.mean(problem.residual(x) ** 2)))
        problem = replace(problem, prior=noise / vertical_std)
        x, covariance = problem.solve(np.concatenate([x, np.zeros_like(x)]))
    return _warned(problem.result(x, covariance, levels, float(levels[middle]), known))


def _warned(curve: MasterCurve) -> MasterCurve:
    levels = [f"{t:g}" for t in curve.temperature]
    pairs = ", ".join(f"{levels[k]} and {levels[k + 1]} K" for k in np.flatnonzero(curve.gaps > 0))
    if pairs:
        text = f"the data of {pairs} do not overlap: the shift between them, and its std, is a guess"
        warnings.warn(f"{text}; measure in between, or over more frequencies", ValidityWarning, stacklevel=3)
    return curve


def _checked(
    temperature: ArrayLike, frequency: ArrayLike, modulus: ArrayLike
) -> tuple[RealArray, RealArray, ComplexArray]:
    t, f, e = np.asarray(temperature, float), np.asarray(frequency, float), np.asarray(modulus, complex)
    if t.ndim != 1 or not t.shape == f.shape == e.shape or not t.size:
        raise InputError(
            f"temperature {t.shape}, frequency {f.shape} and modulus {e.shape} must be lists of one length"
        )
    good = np.isfinite(t) & np.isfinite(f) & np.isfinite(e) & (t > 0) & (f > 0) & (e.real > 0)
    if not np.all(good):
        where = int(np.argmin(good)) + 1
        raise InputError(f"entry {where}: temperature (K), frequency and E1 must be finite and above 0; leave it out")
    if np.min(np.bincount(np.unique(t, return_inverse=True)[1])) < 2:
        raise InputError(
            "every temperature needs moduli at two frequencies or more; round temperatures to nominal ones"
        )
    return t, f, e


def _reference_index(levels: RealArray, reference: float | None) -> int:
    if levels.size < 2:
        raise InputError(f"all data are at {levels[0]:g} K: a master curve needs two temperatures or more")
    wanted = levels[levels.size // 2] if reference is None else reference
    nearest = int(np.argmin(np.abs(levels - wanted)))
    if abs(levels[nearest] - wanted) > 1e-6 * wanted:
        raise InputError(
            f"nothing was measured at the reference of {wanted:g} K; the nearest is {levels[nearest]:.6g} K"
        )
    return nearest


def _matched(index: IndexArray, f: RealArray, storage: RealArray, middle: int) -> RealArray:
    """Return ln a_T by which the E1 of neighbouring temperatures match; of the reference 0."""
    curves = [(f[index == k], storage[index == k]) for k in range(int(index.max()) + 1)]
    steps = [_DECADE * matching_log_shift(*one, *other) for one, other in pairwise(curves)]
    shifts = np.concatenate([[0.0], np.cumsum(steps)])
    return np.asarray(shifts - shifts[middle])


def _nodes(f: RealArray) -> RealArray:
    low, high = np.log10(f.min()) - _BEYOND, np.log10(f.max()) + _BEYOND
    return np.logspace(low, high, int(_STEPS_PER_DECADE * (high - low)) + 1)


@dataclass(frozen=True)
class _Superposition:
    """The least-squares problem: x holds ln a_T of the moved temperatures and, with a prior, ln b_T behind them.

    `prior` is what one unit of ln b_T counts as residual; None leaves b_T = 1.
    """

    frequency: RealArray
    modulus: ComplexArray
    index: IndexArray
    moved: IndexArray
    nodes: RealArray
    prior: float | None = None

    def shifts(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return ln a_T and ln b_T at every temperature."""
        a, b = np.zeros((2, self.moved.size + 1))
        a[self.moved] = x[: self.moved.size]
        b[self.moved] = x[self.moved.size :] if self.prior is not None else 0.0
        return a, b

    def reduced(self, x: RealArray) -> tuple[RealArray, ComplexArray]:
        """Return a_T f and E/b_T of all data."""
        a, b = self.shifts(x)
        return self.frequency * np.exp(a[self.index]), self.modulus / np.exp(b[self.index])

    def weights(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return spring and rises of the best curve, and its residual, shape (2, n)."""
        f, e = self.reduced(x)
        return non_negative_fit(spectrum_columns(f, self.nodes), e, np.abs(e), np.abs(e))

    def residual(self, x: RealArray) -> RealArray:
        b = self.shifts(x)[1]
        # from their mean, not from 1: the reference may be off like any other
        prior = () if self.prior is None else self.prior * (b - b.mean())
        return np.concatenate([self.weights(x)[1].ravel(), prior])

    def jacobian(self, x: RealArray) -> RealArray:
        """Return the derivative of the residual, the curve following the shifts (without Kaufman's small term)."""
        f, e = self.reduced(x)
        weights = self.weights(x)[0]
        columns = spectrum_columns(f, self.nodes)
        up, down = (spectrum_columns(f * np.exp(step), self.nodes) @ weights for step in (_STEP, -_STEP))
        own = (self.index == self.moved[:, np.newaxis]).T / np.abs(e)[:, np.newaxis]
        changes = [own * ((up - down) / (2 * _STEP))[:, np.newaxis]]
        if self.prior is not None:
            changes.append(own * (columns @ weights)[:, np.newaxis])
        active = columns[:, weights > 0] / np.abs(e)[:, np.newaxis]
        return self._with_prior(_projected(np.concatenate(changes, axis=1), active))

    def _with_prior(self, jacobian: RealArray) -> RealArray:
        if self.prior is None:
            return jacobian
        levels = self.moved.size + 1
        from_mean = self.prior * (np.eye(levels) - 1 / levels)[:, self.moved]
        return np.concatenate([jacobian, np.concatenate([np.zeros_like(from_mean), from_mean], axis=1)])

    def solve(self, start: RealArray) -> tuple[RealArray, RealArray]:
        """Return the best shifts and their covariance."""
        found = trust_region(lambda x: (self.residual(x), self.jacobian(x)), start)
        active = int(np.count_nonzero(self.weights(found.z)[0]))
        freedom = max(2 * self.frequency.size - active - start.size, 1)
        covariance = found.misfit / freedom * np.linalg.pinv(found.jacobian.T @ found.jacobian)
        return found.z, np.asarray(covariance, dtype=float)

    def result(
        self, x: RealArray, covariance: RealArray, levels: RealArray, reference: float, known: RealArray
    ) -> MasterCurve:
        """Return the master curve of the shifts x; `known` is the vertical shift already taken out."""
        (a, b), (f, e) = self.shifts(x), self.reduced(x)
        spread = np.zeros((levels.size, levels.size))
        spread[np.ix_(self.moved, self.moved)] = covariance[: self.moved.size, : self.moved.size] / _DECADE**2
        spring, *rises = self.weights(x)[0].tolist()
        least = _LEAST_SPRING * float(np.min(np.abs(e)))  # a liquid's spring is 0, which no solid's law may have
        law = FreeForm(relaxed_modulus=max(spring, least), frequency=tuple(self.nodes.tolist()), rise=tuple(rises))
        return MasterCurve(reference, levels, a / _DECADE, spread, known * np.exp(b), self.index, f, e, law)


def _projected(changes: ComplexArray, columns: ComplexArray) -> RealArray:
    """Return what of the changes, by real and imaginary parts, the columns cannot make up for."""
    of_changes, of_columns = (np.concatenate([values.real, values.imag]) for values in (changes, columns))
    basis = np.linalg.qr(of_columns)[0]
    return np.asarray(of_changes - basis @ (basis.T @ of_changes))
