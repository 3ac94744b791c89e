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
    large = b + np.where(np.real(np.conj(b) * root) >= 0, root, -root)
    w2 = np.asarray(omega) ** 2
    waves = []
    for square in (w2 * 2 * c / large, w2 * large / (2 * a)):
        frame_row = (P * square - w2 * m.rho11, Q * square - w2 * m.rho12)
        fluid_row = (Q * square - w2 * m.rho12, R * square - w2 * m.rho22)
        waves.append((square, *_null_vector(frame_row, fluid_row)))
    return tuple(waves)


def shear_wave(omega: Numeric, medium: BiotMedium) -> tuple[ComplexArray, ComplexArray]:
    """Return the squared wavenumber of the shear wave and its ratio of fluid to frame motion; eqs. (6.83)-(6.84)."""
    m = medium
    ratio = np.asarray(-m.rho12 / m.rho22, dtype=complex)
    square = np.asarray(omega) ** 2 / m.N * (m.rho11 + m.rho12 * ratio)
    return square, ratio


def _null_vector(first: tuple[Numeric, Numeric], second: tuple[Numeric, Numeric]) -> tuple[ComplexArray, ComplexArray]:
    """Return the vector that both (parallel) rows annihilate, taken from the better scaled row, largest entry 1."""
    a, b = (np.asarray(entry, dtype=complex) for entry in first)
    c, d = (np.asarray(entry, dtype=complex) for entry in second)
    scale = max_abs(a, b, c, d)
    use_first = np.maximum(np.abs(a), np.abs(b)) >= np.maximum(np.abs(c), np.abs(d))
    x = np.where(use_first, -b, -d) / scale
    y = np.where(use_first, a, c) / scale
    size = np.where(np.abs(x) >= np.abs(y), x, y)
    return x / size, y / size


def max_abs(*arrays: ComplexArray) -> ComplexArray:
    """Return the elementwise largest modulus of several broadcast arrays."""
    largest = np.abs(arrays[0])
    for array in arrays[1:]:
        largest = np.maximum(largest, np.abs(array))
    return largest
