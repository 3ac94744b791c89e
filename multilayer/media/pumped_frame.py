"""Air pumped through the pores of a glued disc whose frame is moved sideways by it."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.media.bessel_ratio import bessel_ratio

# means over the thickness of u = 4 z (h - z)/h^2, of its square, and of (h du/dz)^2: the frame, glued at both faces
_U, _U2, _DU2 = 2 / 3, 8 / 15, 16 / 3


def pumped_frame_stiffness(
    omega: RealArray,
    frame: ComplexArray,
    flow_resistivity: Numeric,
    *,
    radius: float,
    thickness: Numeric,
    density: Numeric,
    poisson_ratio: float = 0.0,
    pore_modulus: float = 101325.0,
) -> ComplexArray:
    """Return the contribution of air in the pores to the stiffness of a disc between glued, sealed plates, Pa.

    The rim is open.

    Parameters
    ----------
    omega : array, shape (n,)
        rad/s, above 0.
    frame : complex array, shape (..., n)
        Young's modulus of the frame, Pa.
    flow_resistivity : array
        N s/m4.
    radius, thickness : float
        m.
    density : float
        Of the frame, kg/m3.
    poisson_ratio : float
        Of the frame.
    pore_modulus : float
        Of the air over the porosity, Pa: atmospheric pressure for isothermal air and a porosity near 1.

    Notes
    -----
    Uniform compression e along the axis drives air outwards (Darcy) and the frame with it, which is glued at both
    faces and so moves as ``U(r) 4 z (h - z)/h^2``. Averaged over the thickness (Galerkin), M the modulus of a P wave,
    mu that in shear, D = U' + U/r::

        M <u2> D' - (mu <u'2> - rho w^2 <u2>) U = <u> p'
        (p'' + p'/r)/sigma = i w (e + <u> D + p/K)

    with no pressure and no radial stress of the frame at the rim: two modified Bessel functions. For a stiff frame
    this is `media.pumped_air` without inertia and heat. Against finite elements of a Biot disc the effect on the
    transmissibility is right to some 5 % while the sample is short beside the wavelength, and to some 30 % up to its
    first resonance. Biot's equations: Allard & Atalla 2009, chapter 6.
    """
    shear = frame / (2 * (1 + poisson_ratio))
    wave = frame * (1 - poisson_ratio) / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))
    held = shear * _DU2 / thickness**2 - density * omega**2 * _U2
    # k^4 a + k^2 b + c = 0
    a = wave * _U2 / flow_resistivity
    b = -(1j * omega * (wave * _U2 / pore_modulus + _U**2) + held / flow_resistivity)
    c = held * 1j * omega / pore_modulus
    root = np.sqrt(b * b - 4 * a * c)
    q = -0.5 * (b + np.where((np.conj(b) * root).real < 0, -root, root))  # no cancellation
    squares = np.stack(np.broadcast_arrays(q / a, c / q))
    k = np.sqrt(squares)
    x = k * radius
    ratio = bessel_ratio(x)  # of I1 to I0, the unknown amplitudes being those at the rim
    pressure = (wave * _U2 * squares - held) / (_U * k)
    stress = _U2 * (wave * k * (1 - ratio / x) + (wave - 2 * shear) * ratio / radius)
    determinant = pressure[0] * stress[1] - pressure[1] * stress[0]
    first, second = stress[1] / determinant, -stress[0] / determinant
    mean = pressure * ratio / x
    return np.asarray(pore_modulus * (1 - 2 * (first * mean[0] + second * mean[1])))
