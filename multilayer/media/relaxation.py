"""Wilson's relaxation model: two relaxation times, of vorticity and of entropy.

Per unit volume of material, time exp(+i w t), as in `media.porous`.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.media.gas import Gas


def wilson(
    omega: Numeric,
    gas: Gas,
    *,
    porosity: Numeric,
    tortuosity: Numeric,
    vorticity_time: Numeric,
    entropy_time: Numeric,
) -> tuple[ComplexArray, ComplexArray]:
    """Return density, kg/m3, and bulk modulus, Pa, of Wilson.

    D. K. Wilson, J. Acoust. Soc. Am. 94 (1993) 1136-1145; Allard & Atalla 2009, section 5.5.3. The limits at
    high frequencies are tortuosity gas density / porosity and gamma P0 / porosity. Matched to pores of any shape
    around w tau = 1, where relaxation takes place; at low frequencies Re(density) is 1.5 times its high limit.

    Parameters
    ----------
    omega : array
        rad/s.
    gas : Gas
    porosity, tortuosity : float or array
    vorticity_time, entropy_time : float or array
        Relaxation times of the viscous and of the thermal waves, s.
    """
    viscous, thermal = (np.sqrt(1 + 1j * omega * time) for time in (vorticity_time, entropy_time))
    # 1 - 1/sqrt(1 + x) without the cancellation at small x
    lag = 1j * omega * vorticity_time / (viscous * (viscous + 1))
    density = tortuosity * gas.density / porosity / lag
    ratio = gas.heat_capacity_ratio
    return np.asarray(density), np.asarray(ratio * gas.pressure / porosity / (1 + (ratio - 1) / thermal))


def wilson_of_resistivity(
    omega: Numeric, gas: Gas, *, porosity: Numeric, tortuosity: Numeric, flow_resistivity: Numeric
) -> tuple[ComplexArray, ComplexArray]:
    """Return density and bulk modulus of Wilson with relaxation times that follow from the flow resistivity.

    D. K. Wilson, Applied Acoustics 50 (1997) 171-188: the vorticity time such that the low-frequency limit is
    Darcy's law, the entropy time that times the Prandtl number (pores of one shape).
    """
    time = 2 * gas.density * tortuosity / (flow_resistivity * porosity)
    return wilson(
        omega, gas, porosity=porosity, tortuosity=tortuosity, vorticity_time=time, entropy_time=gas.prandtl * time
    )
