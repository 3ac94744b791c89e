"""Porous materials with holes or slits cut through them: double porosity, with diffusion of pressure into the pores.

X. Olny & C. Boutin, J. Acoust. Soc. Am. 114 (2003) 73-89; N. Atalla, R. Panneton, F. C. Sgard & X. Olny, J. Sound Vib.
243 (2001) 659-678; F. C. Sgard, X. Olny, N. Atalla & F. Castel, Appl. Acoust. 66 (2005) 625-651. Flow goes through the
holes (p) and the microporous material (m) side by side; the pressure of the holes diffuses into the material between
them, at a rate that makes it share in the compression at low frequencies only:

    1 / density = 1 / density_p + (1 - share) / density_m
    1 / K = 1 / K_p + (1 - share) F / K_m,  F = mean pressure in the material over that in the holes

Per unit volume of the whole, time exp(+i w t). Where pores and holes are of like permeability F is 1 wherever the
holes are close beside the wavelength, and this is the model of low contrast.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.media.gas import Gas
from multilayer.media.porous import champoux_allard_modulus, johnson_density, lafarge_modulus


def annular_permeability(radius: Numeric, share: Numeric) -> Numeric:
    """Return the mean over an annulus and its core, m2, of T with ``laplacian T = -1``, 0 on the core's face.

    ``b^2 / 4 (-ln s - 3/2 + 2 s - s^2 / 2)``, b^2 = radius^2 / s, s the core's share of the area; nothing passes the
    outer face (J. Happel, AIChE J. 5 (1959) 174-177: the flow along parallel cylinders). Olny & Boutin 2003 take it
    for holes in a square array.
    """
    mean: Numeric = radius**2 / (4 * share) * (-np.log(share) - 1.5 + 2 * share - share**2 / 2)
    return mean


def holed(
    omega: Numeric, gas: Gas, *, porosity: Numeric, flow_resistivity: Numeric, tortuosity: Numeric,
    viscous_length: Numeric, thermal_length: Numeric, perforation: Numeric, hole_radius: Numeric,
) -> tuple[ComplexArray, ComplexArray]:  # fmt: skip
    """Return density, kg/m3, and bulk modulus, Pa, of a porous material with round holes in a square array.

    Parameters
    ----------
    omega : array
        rad/s.
    gas : Gas
    porosity, flow_resistivity, tortuosity, viscous_length, thermal_length : float or array
        Of the material between the holes; N s/m4, m.
    perforation : float or array
        Area of the holes over area of the layer.
    hole_radius : float or array
        m.
    """
    material = (porosity, flow_resistivity, tortuosity, viscous_length, thermal_length)
    diffusion = annular_permeability(hole_radius, perforation) / (1 - perforation)
    depth = hole_radius * (1 - perforation) / perforation
    return _double(omega, gas, material, perforation, perforation * hole_radius**2 / 8, hole_radius, diffusion, depth)


def slitted(
    omega: Numeric, gas: Gas, *, porosity: Numeric, flow_resistivity: Numeric, tortuosity: Numeric,
    viscous_length: Numeric, thermal_length: Numeric, perforation: Numeric, slit_width: Numeric,
) -> tuple[ComplexArray, ComplexArray]:  # fmt: skip
    """Return density, kg/m3, and bulk modulus, Pa, of a porous material with parallel slits of a width in m.

    Parameters are those of `holed` otherwise.
    """
    material = (porosity, flow_resistivity, tortuosity, viscous_length, thermal_length)
    depth = slit_width * (1 - perforation) / perforation
    permeability = perforation * slit_width**2 / 12
    return _double(omega, gas, material, perforation, permeability, slit_width, depth**2 / 12, depth)


def pressure_ratio(
    omega: Numeric, porosity: Numeric, flow_resistivity: Numeric, diffusion: Numeric, depth: Numeric, gas: Gas
) -> ComplexArray:
    """Return F, the mean pressure in the material between holes over that in the holes.

    Olny & Boutin 2003, in the form of Lafarge's thermal permeability: ``F = s / (x + s)``, ``x = i w / w_d``,
    ``s = sqrt(1 + M x / 2)``; w_d = pressure / (porosity flow_resistivity diffusion), M = 8 diffusion / depth^2.

    Parameters
    ----------
    omega : array
        rad/s.
    porosity, flow_resistivity : float or array
        Of the material, N s/m4.
    diffusion : float or array
        Mean over the material of T with ``laplacian T = -1``, 0 at the holes, m2.
    depth : float or array
        Twice the volume of the material over its surface at the holes, m.
    gas : Gas
    """
    rate = 1j * omega * porosity * flow_resistivity * diffusion / gas.pressure
    root = np.sqrt(1 + 4 * diffusion / depth**2 * rate)
    return np.asarray(root / (rate + root))


def _double(
    omega: Numeric, gas: Gas, material: tuple[Numeric, ...], share: Numeric, permeability: Numeric, length: Numeric,
    diffusion: Numeric, depth: Numeric,
) -> tuple[ComplexArray, ComplexArray]:  # fmt: skip
    porosity, flow_resistivity, tortuosity, viscous_length, thermal_length = material
    through = johnson_density(omega, share, gas.viscosity / permeability, 1.0, length, gas)
    within = johnson_density(omega, porosity, flow_resistivity, tortuosity, viscous_length, gas)
    density = 1 / (1 / through + (1 - share) / within)
    ratio = pressure_ratio(omega, porosity, flow_resistivity, diffusion, depth, gas)
    holes = lafarge_modulus(omega, share, length, permeability, gas)
    pores = champoux_allard_modulus(omega, porosity, thermal_length, gas)
    return density, 1 / (1 / holes + (1 - share) * ratio / pores)
