"""Ratio of modified Bessel functions, which fits of air that is pumped through a disc need by the million."""

from __future__ import annotations

import numpy as np
from scipy.special import ive

from multilayer.arrays import ComplexArray

_LARGEST, _TERMS = 50.0, 25  # argument up to which the fraction pays, and its terms beyond the argument


def bessel_ratio(x: ComplexArray) -> ComplexArray:
    """Return ``I1(x) / I0(x)``.

    Parameters
    ----------
    x : complex array
        Not 0, with a real part that is not below 0.

    Notes
    -----
    The continued fraction of I. A. Stegun & M. Abramowitz, Handbook of Mathematical Functions (1964), 9.1.73, from its
    end; beside `scipy.special`, which takes five times as long below 20, and is left the large arguments, right to some
    1e-15.
    """
    is_small = np.abs(x) <= _LARGEST
    ratio = np.empty(x.shape, dtype=complex)
    ratio[~is_small] = ive(1, x[~is_small]) / ive(0, x[~is_small])
    step = 2 / x[is_small]
    terms = int(2 / np.min(np.abs(step), initial=2.0)) + _TERMS
    tail = 1 / (terms * step)
    for n in range(terms - 1, 0, -1):
        tail = 1 / (n * step + tail)
    ratio[is_small] = tail
    return ratio
