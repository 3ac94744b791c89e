"""Whether a drawn law can be that of a passive thing, and of a causal one.

Convention exp(+i w t). A passive thing takes power: of a dynamic mass m = F/a the mean of F v is
``-|a|^2 Im(m)/(2 w)``, so Im(m) <= 0; of a stiffness Im(k) >= 0, of a compliance Im(c) <= 0. Of an acoustic impedance
or admittance the real part is at least 0, of ln of a reflection coefficient at most 0. Of a change of ln E, or of ln of
a bulk modulus, the loss angle of the changed modulus tells: Im(ln E) + Im(law) >= 0; of a density that is at most 0.

Causal: real and imaginary part of a response that begins with its cause belong together (H. M. Nussenzveig, Causality
and Dispersion Relations, Academic Press 1972, ch. 1). In a band alone they may be off by what lies beyond it; so the
law is compared with sums of responses that are causal, with poles in the band and beyond, rather than with an integral.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri

from multilayer.arrays import ComplexArray, RealArray
from multilayer.chi2 import exceeding
from multilayer.diagnosis.place_fits import PlaceFit
from multilayer.diagnosis.thresholds import NOT_CAUSAL_P, NOT_PASSIVE_P

_POWERS = (-2, -1, 0, 1, 2)  # of i w
_RELAXATIONS = (3, 10.0)  # poles per decade, and the factor by which they lie beyond the band
_RESONANCES = (8, 2.0)
_DAMPING = 0.4  # loss factor of the resonances; a drawn law is hardly sharper


def is_passive(fit: PlaceFit) -> bool | None:
    """Tell whether the law drawn at a place can be passive; None where the question makes no sense.

    False only where the band of the part that tells (`BasePlace.passive_part`) excludes passivity at some frequency; it
    is widened so that this happens to a law on the edge of passivity, as a mass, in one of ten campaigns. None of a
    mass, stiffness or compliance that is negative throughout: something is missing there, which need not give power
    for that; nor of a law whose factors in the configurations are of both signs.
    """
    sign, part = fit.place.passive_sign, fit.place.passive_part
    changed = fit.departs_from() if sign else None
    if any(factor < 0 for factor in fit.place.factors.values()):
        return None
    if not sign or (changed is None and part == "imag" and np.all(fit.law().real < 0)):
        return None
    low, high = fit.band(float(ndtri(1 - NOT_PASSIVE_P / len(fit.drawn.nodes))))
    edge = sign * getattr((high if sign > 0 else low) + (0.0 if changed is None else changed), part)
    return bool(np.all(edge >= 0))


def is_causal(fit: PlaceFit) -> bool | None:
    """Tell whether the law drawn at a place can be causal; False only where that has the probability 0.001.

    A resonance is causal by its form. None of a real law, in a reading, which may as well be ahead of another channel,
    and of a law that is multiplied by what was measured, as a strain: the amplitude of a harmonic response that is not
    linear in it obeys no such relation.
    """
    if fit.place.is_real or fit.place.is_reading or fit.place.acts_by_bin:
        return None
    if fit.is_resonant:
        return True
    drawn = fit.drawn
    frequency, count = np.exp(drawn.nodes), 2 * len(drawn.nodes)
    basis = drawn.size * drawn.basis(frequency)
    z = fit.fitted.minimum.z[-count:]
    both = np.kron(np.eye(2), basis)
    covariance = both @ fit.fitted.minimum.covariance[-count:, -count:] @ both.T
    return causal_p_value(frequency, drawn.drawn(z, frequency), covariance) >= NOT_CAUSAL_P


def causal_p_value(frequency: RealArray, law: ComplexArray, covariance: RealArray) -> float:
    """Return the probability that a causal law is as far from values known with a covariance.

    The causal laws: sums, with real coefficients, of powers -2 to 2 of i w, of relaxations ``1/(1 + i f/fc)``, poles up
    to ten times beyond the band, and of resonances ``1/(1 + i eta f/f0 - (f/f0)^2)`` and their rates, up to twice
    beyond. Each of these families is a Gaussian process as large as the law's root mean square, so that chi-square has
    as many degrees of freedom as values. Limits: a constant loss angle of the wrong sign is not told from what lies
    beyond the band.

    Parameters
    ----------
    frequency : array, shape (n,)
        Hz.
    law : complex array, shape (n,)
    covariance : array, shape (2 n, 2 n)
        Of its real and then its imaginary parts.
    """
    values = np.concatenate([law.real, law.imag])
    columns = float(np.sqrt(2 * np.mean(values**2))) * _causal_laws(frequency)
    return exceeding(float(values @ np.linalg.solve(covariance + columns @ columns.T, values)), len(values))


def _causal_laws(frequency: RealArray) -> RealArray:
    """Return causal laws as columns, each family of a variance of 1 in sum: real parts, then imaginary parts."""
    x = 1j * frequency / np.sqrt(frequency.min() * frequency.max())
    rates = [1j * frequency / pole for pole in _poles(frequency, *_RESONANCES)]
    resonances = [1 / (1 + _DAMPING * rate + rate**2) for rate in rates]
    families: list[list[ComplexArray]] = [[np.asarray(x**power)] for power in _POWERS]
    families += [
        [1 / (1 + 1j * frequency / pole) for pole in _poles(frequency, *_RELAXATIONS)],
        resonances,
        [rate * resonance for rate, resonance in zip(rates, resonances, strict=True)],
    ]
    return np.concatenate([_scaled(family) for family in families], axis=1)


def _poles(frequency: RealArray, per_decade: int, beyond: float) -> RealArray:
    low, high = float(frequency.min()) / beyond, float(frequency.max()) * beyond
    return np.geomspace(low, high, int(np.ceil(per_decade * np.log10(high / low))) + 1)


def _scaled(family: list[ComplexArray]) -> RealArray:
    laws = np.stack(family, axis=-1)
    parts = np.concatenate([laws.real, laws.imag])
    return np.asarray(parts / np.sqrt(2 * len(family) * np.mean(parts**2, axis=0)))
