"""Time-temperature superposition: how far the modulus of a polymer moves along frequency when its temperature changes.

A thermorheologically simple material has ``E(f, T) = b_T E(a_T f, T0)``: at another temperature all relaxation times
are multiplied by `a_T`, the modulus by `b_T`. Here are the usual formulae for both, and their fits;
`multilayer_campaigns.master_curve` (a plugin) finds the shifts themselves from moduli.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.constants import R
from scipy.optimize import least_squares

from multilayer.arrays import ArrayLike, RealArray
from multilayer.errors import InputError

_OFF_THE_POLE = 1.0  # K
_SMALLEST = 1e-12  # of the largest variance: what is below is rounding


def wlf_log_shift(temperature: ArrayLike, reference: float, c1: float, c2: float) -> RealArray:
    """Return log10 a_T = -c1 (T - T0)/(c2 + T - T0), after Williams, Landel and Ferry.

    M. L. Williams, R. F. Landel & J. D. Ferry, J. Am. Chem. Soc. 77 (1955) 3701-3707. Made for amorphous polymers from
    the glass transition to some 100 K above; below it the glass is out of equilibrium and shifts less.

    Parameters
    ----------
    temperature : array
        K.
    reference : float
        T0, K.
    c1 : float
        Decades.
    c2 : float
        K.

    Raises
    ------
    InputError
        At and below T0 - c2, where the formula has its pole.
    """
    difference = np.asarray(temperature, dtype=float) - reference
    if np.any(difference <= -c2):
        raise InputError(f"WLF has its pole at {reference - c2:g} K; stay above it, or take Arrhenius' law")
    return np.asarray(-c1 * difference / (c2 + difference))


def wlf_of_reference(reference: float, c1: float, c2: float, new_reference: float) -> tuple[float, float]:
    """Return c1 (decades) and c2 (K) of the same WLF shifts for another reference temperature (both in K).

    J. D. Ferry, Viscoelastic Properties of Polymers, 3rd ed., Wiley 1980, ch. 11.
    """
    moved = c2 + new_reference - reference
    return c1 * c2 / moved, moved


def arrhenius_log_shift(temperature: ArrayLike, reference: float, activation_energy: float) -> RealArray:
    """Return log10 a_T = Ea/(R ln 10) (1/T - 1/T0): a thermally activated process.

    J. D. Ferry, Viscoelastic Properties of Polymers, 3rd ed., Wiley 1980, ch. 11. For secondary relaxations, glasses
    below and melts far above the glass transition; across it the apparent energy changes.

    Parameters
    ----------
    temperature : array
        K.
    reference : float
        T0, K.
    activation_energy : float
        Ea, J/mol.
    """
    return np.asarray(activation_energy / (R * np.log(10)) * (1 / np.asarray(temperature, dtype=float) - 1 / reference))


def entropic_shift(temperature: ArrayLike, reference: float, expansion: float = 0.0) -> RealArray:
    """Return b_T = T rho/(T0 rho0), the vertical shift of rubber elasticity, which is of entropy.

    J. D. Ferry, Viscoelastic Properties of Polymers, 3rd ed., Wiley 1980, ch. 11. For the rubbery state
    and the transition; the stiffness of a glass does not grow with temperature.

    Parameters
    ----------
    temperature : array
        K.
    reference : float
        T0, K.
    expansion : float
        Volumetric thermal expansion, 1/K: rho/rho0 = 1/(1 + expansion (T - T0)).
    """
    t = np.asarray(temperature, dtype=float)
    return np.asarray(t / reference / (1 + expansion * (t - reference)))


def matching_log_shift(
    frequency: RealArray, storage_modulus: RealArray, other_frequency: RealArray, other_storage_modulus: RealArray
) -> float:
    """Return by how many decades the other curve of E1 must move up in frequency to match the first.

    The mean distance along log frequency over all values of E1 that both curves take; where there are none, that of
    their nearest ends.

    Parameters
    ----------
    frequency, other_frequency : array
        Hz, in any order.
    storage_modulus, other_storage_modulus : array
        Pa; what noise makes fall with frequency is held level.
    """
    x, y = _rising(frequency, storage_modulus)
    x_other, y_other = _rising(other_frequency, other_storage_modulus)
    low, high = max(y[0], y_other[0]), min(y[-1], y_other[-1])
    heights = np.linspace(low, high, 50) if low < high else np.array([(low + high) / 2])
    return float(np.mean(np.interp(heights, y, x) - np.interp(heights, y_other, x_other)))


def _rising(frequency: RealArray, storage_modulus: RealArray) -> tuple[RealArray, RealArray]:
    """Return log10 f and the logarithm of E1, neither falling."""
    order = np.argsort(frequency)
    return np.log10(frequency[order]), np.maximum.accumulate(np.log(storage_modulus[order]))


@dataclass(frozen=True)
class ShiftFit:
    """A formula fitted to shifts.

    Attributes
    ----------
    name : {'wlf', 'arrhenius'}
    parameters, std : dict
        ``c1`` (decades) and ``c2`` (K), or ``activation_energy`` (J/mol); the standard deviations NaN where there are
        as many parameters as shifts whose own errors are not known.
    residual : array
        Shift minus formula at each temperature, decades.
    """

    name: str
    parameters: dict[str, float]
    std: dict[str, float]
    residual: RealArray

    @property
    def rms(self) -> float:
        """Root mean square of the residual, decades."""
        return float(np.sqrt(np.mean(self.residual**2)))


def fit_wlf(
    temperature: ArrayLike, log_shift: ArrayLike, reference: float, covariance: ArrayLike | None = None
) -> ShiftFit:
    """Fit c1 and c2 of Williams, Landel and Ferry to shifts log10 a_T, by generalised least squares.

    Parameters
    ----------
    temperature : array, shape (m,)
        K.
    log_shift : array, shape (m,)
        Decades.
    reference : float
        K; the shift there is 0 and no datum.
    covariance : array, shape (m, m), optional
        Of the shifts, decades squared. Standard deviations follow from it, widened by the root of chi-square per degree
        of freedom where the formula misses by more; without it all shifts count alike, as uncertain as their residual.
    """
    t, wanted = np.asarray(temperature, dtype=float), np.asarray(log_shift, dtype=float)
    pole = max(reference - float(t.min()), 0.0) + _OFF_THE_POLE
    whiten = _whitening(t, reference, covariance)

    def residual(x: RealArray) -> RealArray:
        return wanted - wlf_log_shift(t, reference, x[0], x[1])

    def whitened(x: RealArray) -> RealArray:
        return np.asarray(whiten @ residual(x))

    fit = least_squares(whitened, [10.0, pole + 50.0], bounds=([0.0, pole], [np.inf, np.inf]), x_scale=[1.0, 10.0])
    std = _std(fit.fun, np.asarray(fit.jac), covariance is not None)
    return _shift_fit("wlf", ("c1", "c2"), fit.x, std, residual(fit.x))


def fit_arrhenius(
    temperature: ArrayLike, log_shift: ArrayLike, reference: float, covariance: ArrayLike | None = None
) -> ShiftFit:
    """Fit an activation energy to shifts log10 a_T; parameters as for `fit_wlf`."""
    t, wanted = np.asarray(temperature, dtype=float), np.asarray(log_shift, dtype=float)
    per_joule = arrhenius_log_shift(t, reference, 1.0)
    whiten = _whitening(t, reference, covariance)
    slope, target = whiten @ per_joule, whiten @ wanted
    energy = float(slope @ target / (slope @ slope))
    std = _std(target - energy * slope, slope[:, np.newaxis], covariance is not None)
    return _shift_fit("arrhenius", ("activation_energy",), np.array([energy]), std, wanted - energy * per_joule)


def _whitening(temperature: RealArray, reference: float, covariance: ArrayLike | None) -> RealArray:
    """Return the map of shifts to independent numbers of one variance, 1 by the covariance, without the reference's."""
    others: RealArray = np.eye(temperature.size)[temperature != reference]
    if covariance is None:
        return others
    variance, directions = np.linalg.eigh(others @ np.asarray(covariance, dtype=float) @ others.T)
    return np.asarray((directions / np.sqrt(np.maximum(variance, _SMALLEST * variance[-1]))).T @ others)


def _std(residual: RealArray, jacobian: RealArray, stated: bool) -> RealArray:
    """Return the standard deviations of parameters by whitened residual and Jacobian; of variance 1 where stated."""
    freedom = residual.size - jacobian.shape[1]
    variance = float(residual @ residual) / freedom if freedom > 0 else float("nan")
    widened = np.fmax(variance, 1.0) if stated else variance
    return np.asarray(np.sqrt(widened * np.diag(np.linalg.pinv(jacobian.T @ jacobian))))


def _shift_fit(name: str, names: tuple[str, ...], x: RealArray, std: RealArray, residual: RealArray) -> ShiftFit:
    parameters, spreads = (dict(zip(names, values.tolist(), strict=True)) for values in (x, std))
    return ShiftFit(name, parameters, spreads, residual)
