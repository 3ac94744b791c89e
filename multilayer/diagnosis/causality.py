"""Whether a drawn law can be that of a passive thing, and of a causal one.

Convention exp(+i w t). A passive thing takes power: of a dynamic mass m = F/a the mean of F v is
``-|a|^2 Im(m)/(2 w)``, so Im(m) <= 0; of a stiffness Im(k) >= 0, of a compliance Im(c) <= 0.

Causal laws have real and imaginary parts that belong together (Kramers & Kronig). Over a limited band anything may be
continued causally, if by large terms outside; so the law is compared with a random causal law of its own size:
relaxations and damped resonances spread over the band and a decade beyond either end, with real amplitudes. J. S. Toll,
Phys. Rev. 104 (1956) 1760-1770.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.chi2 import exceeding
from multilayer.diagnosis.place_fits import PlaceFit

_LEAST_P = 0.001  # probability below which a law is told to be none
_SURE = 3.3  # standard deviations with that probability
_BEYOND = 10.0  # factor on the ends of the band within which poles lie
_PER_DECADE = 6
_DAMPING = 0.7  # loss factors of the resonances: broader than a smooth law is


def is_passive(fit: PlaceFit) -> bool | None:
    """Tell whether the law drawn at a place can be passive; None where the question makes no sense.

    False only where it is active beyond its uncertainty at some frequency.
    """
    sign = fit.place.passive_sign
    if not sign:
        return None
    low, high = fit.band(_SURE)
    return bool(np.all((high.imag if sign > 0 else -low.imag) >= 0))


def is_causal(fit: PlaceFit) -> bool:
    """Tell whether the law drawn at a place can be causal; False only where that has the probability 0.001.

    A resonance is causal by its form.
    """
    if fit.resonance is not None:
        return True
    drawn = fit.drawn
    frequency, count = np.exp(drawn.nodes), 2 * len(drawn.nodes)
    basis = drawn.size * drawn.basis(frequency)
    z = fit.fitted.minimum.z[-count:]
    both = np.kron(np.eye(2), basis)
    covariance = both @ fit.fitted.minimum.covariance[-count:, -count:] @ both.T
    return causal_p_value(frequency, drawn.drawn(z, frequency), covariance) >= _LEAST_P


def causal_p_value(frequency: RealArray, law: ComplexArray, covariance: RealArray) -> float:
    """Return the probability of a law as far from a causal one.

    Parameters
    ----------
    frequency : array, shape (n,)
        Hz.
    law : complex array, shape (n,)
    covariance : array, shape (2 n, 2 n)
        Of its real and then its imaginary parts.
    """
    terms = causal_terms(frequency)
    size = np.sqrt(np.mean(np.abs(law) ** 2))
    columns = size * np.concatenate([terms.real, terms.imag])
    whole = covariance + columns @ columns.T
    values = np.concatenate([law.real, law.imag])
    return exceeding(float(values @ np.linalg.solve(whole, values)), len(values))


def causal_terms(frequency: RealArray) -> ComplexArray:
    """Return laws that are real in time, shape (n, k): 1, i f, 1/(i f), relaxations, and resonances.

    Each is 1 in amount at the band's centre, or at most 1 near it.
    """
    low, high = frequency.min(), frequency.max()
    turn = 1j * frequency / np.sqrt(low * high)
    count = int(np.ceil(_PER_DECADE * np.log10(_BEYOND**2 * high / low))) + 1
    ratio = frequency[:, None] / np.geomspace(low / _BEYOND, high * _BEYOND, count)
    relaxations = 1 / (1 + 1j * ratio)
    resonances = _DAMPING / (1 - ratio**2 + 1j * _DAMPING * ratio)
    powers = np.stack([np.ones_like(turn), turn, 1 / turn], axis=-1)
    return np.concatenate([powers, relaxations, resonances, 1j * ratio * resonances], axis=-1)
