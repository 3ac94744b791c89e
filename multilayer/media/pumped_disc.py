"""Motion of a mass on a glued porous disc whose air is pumped to an open rim, while waves run along its axis."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.media.bessel_ratio import bessel_ratio
from multilayer.media.pumped_frame import pumped_frame_stiffness

_MODES = 3  # of the axial motion: with 16 the answer is the same within two thousandths


def dynamic_resistivity(omega: RealArray, flow_resistivity: Numeric, gas_density: float) -> ComplexArray:
    """Return pressure gradient over velocity of gas in pores at rest, N s/m4: viscous, then inertial.

    Johnson, Koplik & Dashen 1987 for cylindrical pores, porosity and tortuosity near 1; Allard & Atalla 2009, chapter
    5.

    Parameters
    ----------
    omega : array
        rad/s.
    flow_resistivity : array
        N s/m4.
    gas_density : float
        kg/m3.
    """
    inertia = 1j * omega * gas_density
    return np.asarray(flow_resistivity * np.sqrt(1 + inertia / (2 * flow_resistivity)) + inertia)


def pumped_disc_factor(
    omega: RealArray,
    frame: ComplexArray,
    flow_resistivity: Numeric,
    *,
    radius: float,
    thickness: Numeric,
    density: Numeric,
    mass_per_area: Numeric,
    poisson_ratio: float = 0.0,
    held: float = 1.0,
    gas_density: float = 1.2,
    pore_modulus: float = 101325.0,
) -> ComplexArray:
    """Return the factor by which air in the pores changes top over base motion of a disc under a rigid mass.

    Parameters
    ----------
    omega : array, shape (n,)
        rad/s, above 0.
    frame : complex array, shape (..., n)
        Young's modulus of the frame, Pa.
    flow_resistivity : array, shape (..., 1) or ()
        N s/m4.
    radius, thickness : float
        m.
    density : float
        Of the frame, kg/m3.
    mass_per_area : array
        Of the plate on it, kg/m2.
    poisson_ratio : float
        Of the frame.
    held : float
        Axial stiffness over Young's modulus.
    gas_density : float
        kg/m3.
    pore_modulus : float
        Of the air over the porosity, Pa: atmospheric pressure for isothermal air and a porosity near 1.

    Notes
    -----
    Axial motion ``u = 1 + d z/h + sum a_n sin(n pi z/h)`` above a base that moves by 1. The gas is driven along the
    axis by frame and pressure, ``W = (w^2 rho0 u - p')/(i w s)`` relative to the frame, s the dynamic resistivity, and
    leaves sideways (`pumped_frame_stiffness` for the uniform compression, K0). The mean pressure of the n-th mode is
    ``-K_n (a_n - beta U_n) n pi/h cos``, with

        K_n = (i w s/q^2) (1 - 2 I1(q R)/(q R I0(q R))),  q^2 = (n pi/h)^2 + i w s/K,
        beta = i w rho0/s,  U_n the n-th coefficient of all of u.

    That is Biot's theory with a frame that gives way sideways in uniform compression only; Allard & Atalla 2009,
    chapter 6. Unlike a stiffness added to the frame's it holds beyond the first resonance of the sample. Against
    finite elements of a Biot disc of 12 to 40 mm, 45 mm across: below that resonance right to 0.1 % of the
    transmissibility; beyond it to a tenth of the largest effect up to 6e4 N s/m4, and to a third of it at 2e5.
    """
    s = dynamic_resistivity(omega, flow_resistivity, gas_density)
    slip = 1j * omega * gas_density / s
    stiffness = held * frame
    uniform = pumped_frame_stiffness(
        omega, frame, s, radius=radius, thickness=thickness, density=density,
        poisson_ratio=poisson_ratio, pore_modulus=pore_modulus,
    )  # fmt: skip

    without = _motion(omega, stiffness, density, thickness, mass_per_area)
    heavier = density + gas_density
    drag = _of_modes(omega, flow_resistivity, gas_density, radius, float(np.mean(np.asarray(thickness))), pore_modulus)
    with_air = _motion(
        omega, stiffness, heavier, thickness, mass_per_area,
        uniform=uniform, modes=drag, gas_density=gas_density, slip=slip,
    )  # fmt: skip
    return np.asarray(with_air / without)


def _of_modes(
    omega: RealArray,
    flow_resistivity: Numeric,
    gas_density: float,
    radius: float,
    thickness: float,
    pore_modulus: float,
) -> list[ComplexArray]:
    """Return K_n of every mode, each of shape (..., n), for the mean thickness of all samples."""
    resistivity = np.atleast_1d(np.asarray(flow_resistivity))
    # Bessel functions are slow, and among the samples of a derivative only few differ in resistivity
    values, place = np.unique(resistivity, return_inverse=True)
    s = dynamic_resistivity(omega, values[:, None], gas_density)
    back = place.reshape(resistivity.shape)[..., 0]
    stiffnesses = []
    for n in range(1, _MODES + 1):
        q2 = (n * np.pi / thickness) ** 2 + 1j * omega * s / pore_modulus
        x = np.asarray(np.sqrt(q2) * radius, dtype=complex)
        stiffnesses.append((1j * omega * s / q2 * (1 - 2 * bessel_ratio(x) / x))[back])
    return stiffnesses


def _motion(
    omega: RealArray,
    stiffness: ComplexArray,
    density: Numeric,
    thickness: Numeric,
    mass: Numeric,
    *,
    uniform: Numeric = 0.0,
    modes: list[ComplexArray] | None = None,
    gas_density: float = 0.0,
    slip: Numeric = 0.0,
) -> ComplexArray:
    """Return top over base motion from the stationary sum of energies, the modes' amplitudes eliminated.

    ``gas`` below is w^2 rho0 beta, by which the slip of the gas reduces the inertia; `modes` are the K_n.
    """
    w2, h = omega**2, thickness
    gas = w2 * gas_density * slip
    inertia = w2 * density - gas
    of_d = (stiffness + uniform) / h - w2 * density * h / 3 - w2 * mass
    of_base = -w2 * density * h / 2 - w2 * mass
    for n in range(1, _MODES + 1):
        k = n * np.pi / h
        air = 0.0 if modes is None else modes[n - 1] * k**2
        amplitude = (inertia + air * slip * (1 - slip)) / (stiffness * k**2 + air * (1 - slip) ** 2 - inertia)
        pull = gas * (1 + amplitude) - air * slip * ((1 - slip) * amplitude - slip) - w2 * density * amplitude
        share = h * (-1) ** (n + 1) / (n * np.pi)  # of z/h in the mode, and below of a motion all alike
        whole = h * (1 - (-1) ** n) / (n * np.pi)
        of_d = of_d + 2 / h * pull * share**2
        of_base = of_base + 2 / h * pull * share * whole
    return np.asarray(1 - of_base / of_d)
