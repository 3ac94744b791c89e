"""Biot's isotropic poroelasticity: elastic coefficients, densities and the three waves.

Symbols are those of Allard & Atalla 2009, chapter 6. No checks here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multilayer.arrays import ComplexArray, Numeric


@dataclass(frozen=True)
class BiotMedium:
    """Coefficients of a poroelastic medium; every attribute broadcasts over frequency and samples.

    Attributes
    ----------
    N, P, Q, R : complex
        Shear modulus and elastic coefficients, Pa; eqs. (6.3), (6.26)-(6.28) for a frame material much stiffer
        than the frame.
    P_drained : complex
        P - Q^2/R, the longitudinal modulus of the frame in vacuo, Pa.
    rho11, rho12, rho22 : complex
        Densities with viscous interaction, kg/m3; eq. (6.58).
    """

    N: Numeric
    P: Numeric
    Q: Numeric
    R: Numeric
    P_drained: Numeric
    rho11: Numeric
    rho12: Numeric
    rho22: Numeric


def biot_medium(
    young_modulus: Numeric,
    poisson_ratio: Numeric,
    frame_density: Numeric,
    porosity: Numeric,
    pore_density: Numeric,
    pore_modulus: Numeric,
    fluid_density: float,
) -> BiotMedium:
    """Return the Biot coefficients of a frame whose own material is incompressible beside the frame.

    Parameters
    ----------
    young_modulus : complex
        Of the frame in vacuo, Pa.
    poisson_ratio : float
    frame_density : float
        Mass of the frame per volume of material, kg/m3.
    porosity : float
    pore_density, pore_modulus : complex
        Equivalent-fluid density and bulk modulus per volume of material; see `media.porous`.
    fluid_density : float
        Of the saturating fluid at rest, kg/m3.
    """
    N = young_modulus / (2 * (1 + poisson_ratio))
    P_drained = 2 * N * (1 - poisson_ratio) / (1 - 2 * poisson_ratio)
    Kf = porosity * pore_modulus
    Q = (1 - porosity) * Kf
    rho22 = porosity**2 * pore_density
    rho12 = porosity * fluid_density - rho22
    return BiotMedium(
        N=N,
        P=P_drained + (1 - porosity) ** 2 * Kf / porosity,
        Q=Q,
        R=porosity * Kf,
        P_drained=P_drained,
        rho11=frame_density - rho12,
        rho12=rho12,
        rho22=rho22,
    )


def compressional_waves(
    omega: Numeric, medium: BiotMedium
) -> tuple[tuple[ComplexArray, ComplexArray, ComplexArray], ...]:
    """Return the two compressional waves as (squared wavenumber, frame amplitude, fluid amplitude).

    Eqs. (6.67)-(6.71); the amplitudes are an eigenvector rather than the ratio mu of eq. (6.71), which has a pole
    where the frame stands still. The larger of the two is 1.
    """
    m = medium
    P, Q, R = m.P, m.Q, m.R
    a = m.P_drained * R  # = P R - Q^2, without the cancellation
    b = P * m.rho22 + R * m.rho11 - 2 * Q * m.rho12
    c = m.rho11 * m.rho22 - m.rho12**2
    root = np.sqrt(np.asarray(b * b - 4 * a * c, dtype=complex))
    # the root of larger modulus by addition, the other by the product of the roots: no cancellation
    large = b + root * np.where(np.real(np.conj(b) * root) >= 0, 1, -1)
    w2 = np.asarray(omega) ** 2
    inertia11, inertia12, inertia22 = w2 * m.rho11, w2 * m.rho12, w2 * m.rho22
    waves = []
    for square in (2 * w2 * c / large, w2 * large / (2 * a)):
        frame, both, fluid = P * square - inertia11, Q * square - inertia12, R * square - inertia22
        waves.append((square, *_null_vector(frame, both, fluid)))
    return tuple(waves)


def shear_wave(omega: Numeric, medium: BiotMedium) -> tuple[ComplexArray, ComplexArray]:
    """Return the squared wavenumber of the shear wave and its ratio of fluid to frame motion; eqs. (6.83)-(6.84)."""
    m = medium
    ratio = np.asarray(-m.rho12 / m.rho22, dtype=complex)
    square = np.asarray(omega) ** 2 * (m.rho11 + m.rho12 * ratio) / m.N
    return np.asarray(square), ratio


def _null_vector(frame: Numeric, both: Numeric, fluid: Numeric) -> tuple[ComplexArray, ComplexArray]:
    """Return the vector that [[frame, both], [both, fluid]], a singular matrix, annihilates; its larger entry is 1.

    ``frame fluid = both^2``: the row of the larger diagonal entry is the better scaled one, and its other entry the
    smaller of the two.
    """
    fluid_moves = np.abs(frame) >= np.abs(fluid)
    ratio = -both / np.where(fluid_moves, frame, fluid)
    return np.where(fluid_moves, ratio, 1), np.where(fluid_moves, 1, ratio)
