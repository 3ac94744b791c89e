"""How far a glued disc with a free rim moves as a rod."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from multilayer.errors import InputError
from multilayer.fits.classical.rod_branches import QUARTER
from multilayer.rig.shape_factor import dynamic_shape_factor, static_shape_factor
from multilayer.rig.two_plate import TwoPlateRig

_MOST = 0.1  # relative error of the modulus that is let pass
_THIN = 0.1  # thickness over wavelength at which the error is looked at: small, and well above the elements' own


@lru_cache(maxsize=256)
def rim_inertia(poisson_ratio: float, shape: float) -> float:
    """Return c in the relative error c (h/lambda)^2 of the modulus that a rod would show.

    While a disc glued at both faces is compressed, its rim swells and has inertia, as in Rayleigh's correction for long
    rods. To leading order that acts with the square of frequency. The factor comes from finite elements of a disc a
    tenth of the wavelength thick.

    Parameters
    ----------
    poisson_ratio : float
        -0.5 < nu < 0.5; the sign does not count.
    shape : float
        S = radius/(2 thickness).

    Raises
    ------
    InputError
        For values out of range.
    """
    nu = abs(poisson_ratio)
    if nu == 0:
        return 0.0
    thickness, density, modulus = 0.02, 100.0, 1e5 * (1 + 0.2j)
    static = static_shape_factor(nu, shape)
    frequency = _THIN / np.real(np.sqrt(density / (static * modulus))) / thickness
    disc = TwoPlateRig(2 * shape * thickness, thickness, density, nu, 1e-3)
    factor = complex(dynamic_shape_factor(disc, frequency, modulus)[0])
    if not np.isfinite(factor):
        raise InputError(f"poisson_ratio: {poisson_ratio:g} with S = {shape:.3g}: no rod moves as this disc does")
    return float(abs(factor / static - 1) / _THIN**2)


def rod_error(inertia: float, wavelengths: float) -> float:
    """Return by how much a rod's modulus may be off for the rim's inertia, relative: c (h/lambda)^2."""
    return inertia * wavelengths**2


def longest_rod(inertia: float) -> float:
    """Return the thickness over wavelength up to which the rod is to be believed.

    A quarter: beyond it several moduli have one transmissibility, and the sample itself resonates; less where the rim's
    inertia makes 10 % before.
    """
    return float(min(QUARTER, np.sqrt(_MOST / inertia))) if inertia > 0 else QUARTER
