"""Probabilities of chi-square: M. Abramowitz & I. A. Stegun, Handbook of Mathematical Functions, 1964, section 26.4."""

from __future__ import annotations

from scipy.special import chdtrc, chdtri  # not scipy.stats, which gives the same but is slow to import


def exceeding(chi_square: float, degrees: float) -> float:
    """Return the probability that chi-square with `degrees` of freedom (above 0, not only whole) is larger."""
    return float(chdtrc(degrees, max(chi_square, 0.0)))  # rounding may have made it negative


def exceeded(probability: float, degrees: float) -> float:
    """Return the value that chi-square exceeds with a probability: the inverse of `exceeding`."""
    return float(chdtri(degrees, probability))
