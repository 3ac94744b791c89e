"""Pores from the geometry of what is around them: fibres, grains, the struts of open cells.

Each gives the parameters of Johnson, Champoux, Allard & Lafarge by cell models: one fibre or grain in the middle of a
cell of fluid of the material's porosity. The permeabilities are those of the cell, the tortuosity is Maxwell's for
cylinders or spheres as far apart as in it, and the viscous length follows from the tortuosity F porosity, F that of a
material whose walls grow (D. L. Johnson, J. Koplik & L. M. Schwartz, Phys. Rev. Lett. 57 (1986) 2564-2567):
``2 / Lambda = d ln F / d growth``, F = tortuosity / porosity. Fibres and grains are alike and evenly spread. Real ones
stand closer here and farther there, and let more through: see each model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.media.double_porosity import annular_permeability
from multilayer.media.gas import Gas
from multilayer.media.porous import johnson_density, lafarge_modulus


@dataclass(frozen=True)
class Pores:
    """What geometry alone says of pores.

    Attributes
    ----------
    permeability : float or array
        Static and viscous, m2; the flow resistivity is the gas's viscosity over it.
    tortuosity : float or array
        High-frequency limit.
    viscous_length, thermal_length : float or array
        m.
    thermal_permeability : float or array
        m2.
    """

    permeability: Numeric
    tortuosity: Numeric
    viscous_length: Numeric
    thermal_length: Numeric
    thermal_permeability: Numeric

    def fluid(self, omega: Numeric, porosity: Numeric, gas: Gas) -> tuple[ComplexArray, ComplexArray]:
        """Return effective density, kg/m3, and bulk modulus, Pa, at omega, rad/s; see `media.porous`."""
        resistivity = gas.viscosity / self.permeability
        density = johnson_density(omega, porosity, resistivity, self.tortuosity, self.viscous_length, gas)
        return density, lafarge_modulus(omega, porosity, self.thermal_length, self.thermal_permeability, gas)


def fibres(porosity: Numeric, fibre_diameter: Numeric, fibre_orientation: Numeric = 0.0) -> Pores:
    """Return the pores between long, thin fibres.

    Along fibres J. Happel, AIChE J. 5 (1959) 174-177, across them S. Kuwabara, J. Phys. Soc. Japan 14 (1959) 527-532,
    half of that: the regular arrays of V. Tarnow, J. Acoust. Soc. Am. 100 (1996) 3706-3713. Of others the drag is the
    mean of both, by the share of fibres in each direction, and so is what the flow of an ideal fluid feels. The thermal
    permeability is that along fibres, whatever their direction.

    Parameters
    ----------
    porosity : float or array
        Holds from about 0.7.
    fibre_diameter : float or array
        m.
    fibre_orientation : float or array
        Mean squared cosine of the angle between fibres and the normal of the layer: 0 in its plane, 1/3 in all
        directions, 1 across the layer.

    Notes
    -----
    Fibres that are not evenly spread let more through: random ones in all directions 1.2 to 1.5 times as much (G. W.
    Jackson & D. F. James, Can. J. Chem. Eng. 64 (1986) 364-374), filters of fibres in the plane 1.4 to 2 times (C. N.
    Davies, Proc. Inst. Mech. Eng. B1 (1952) 185-213), glass wool about 4 times (D. A. Bies & C. H. Hansen, Appl.
    Acoust. 13 (1980) 357-391). A measured flow resistivity goes before these: use `jcal`.
    """
    radius, solid, across = fibre_diameter / 2, 1 - porosity, 1 - fibre_orientation
    along = annular_permeability(radius, solid)
    thermal_length = radius * porosity / solid
    tortuosity = 1 + solid * across
    return Pores(along / (1 + across), tortuosity, thermal_length * tortuosity / (1 + across), thermal_length, along)


def open_cells(porosity: Numeric, cell_size: Numeric) -> Pores:
    """Return the pores of an open-cell foam of thin round struts.

    The struts are the edges of tetrakaidecahedra (Lord Kelvin's cells), 12 of length L for each cell of the volume
    8 sqrt(2) L^3 (L. J. Gibson & M. F. Ashby, Cellular Solids, 2nd ed. 1997, section 2), and make fibres in all
    directions, see `fibres`. No membranes, no thickening where struts meet.

    Parameters
    ----------
    porosity : float or array
        Holds from about 0.95.
    cell_size : float or array
        Distance between opposite square faces of a cell, 2 sqrt(2) L, m.
    """
    edge = cell_size / np.sqrt(8)
    diameter = 2 * edge * np.sqrt(2 * np.sqrt(2) * (1 - porosity) / (3 * np.pi))
    return fibres(porosity, diameter, 1 / 3)


def grains(porosity: Numeric, grain_diameter: Numeric) -> Pores:
    """Return the pores between round grains of one size.

    C. Boutin & C. Geindreau, Phys. Rev. E 82 (2010) 036313, estimates of the cell with no shear at its face (J. Happel,
    AIChE J. 4 (1958) 197-201) and no heat through it; T. G. Zielinski, J. Appl. Phys. 116 (2014) 034905, compares such
    values with beads.

    Parameters
    ----------
    porosity : float or array
        Holds from 0.26, that of the densest packing.
    grain_diameter : float or array
        m.
    """
    a, solid = grain_diameter / 2, 1 - porosity
    b = np.cbrt(solid)  # radius of the grain over that of the cell
    viscous = (2 - 3 * b + 3 * b**5 - 2 * b**6) / (3 * b**3 * (3 + 2 * b**5))
    thermal = (5 - 9 * b + 5 * b**3 - b**6) / (15 * b**3)
    length = 2 * a * porosity / (3 * solid)
    tortuosity = 1 + solid / 2
    return Pores(viscous * a**2, tortuosity, length * tortuosity * 2 / 3, length, thermal * a**2)
