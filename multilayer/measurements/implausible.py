"""Numbers of campaign, fit and rig files that are allowed, and hardly ever meant: another unit was."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

from multilayer.measurements.leaves import Path, leaves
from multilayer.models import Model
from multilayer.units import asked_back

_LENGTH = (0.0, 1.0, "a length", "m", "mm")
_PORES = (0.0, 0.01, "pores", "m", "um")
_OF_FOAM = (1.0, inf, "a density", "kg/m3", "g/cm3")
_OF_PLATE = (10.0, inf, "a density", "kg/m3", "g/cm3")
_STIFF = (1e6, inf, "a Young's modulus", "Pa", "GPa")
_SOFT = (1e3, inf, "a modulus", "Pa", "kPa")
_RESISTIVITY = (50.0, inf, "a flow resistivity", "N s/m4", "kN s/m4")

# least, and what all are below, by the path of a field without the numbers of entries
_HARDLY = {
    "specimen.density": _OF_FOAM,
    "specimen.young_modulus": _SOFT,
    "specimen.flow_resistivity": _RESISTIVITY,
    "specimen.viscous_length": _PORES,
    "specimen.thermal_length": _PORES,
    "specimen.skin.thickness": _LENGTH,
    **{f"{plate}.density": _OF_PLATE for plate in ("top_plate", "base_plate")},
    **{f"{plate}.young_modulus": _STIFF for plate in ("top_plate", "base_plate")},
    "base_plate.thickness": _LENGTH,
    **{f"configurations.{name}": _LENGTH for name in ("specimen_thickness", "top_plate_thickness", "specimen_radius")},
    **{f"configurations.{name}": _LENGTH for name in ("thickness", "top_plate", "radius")},
    **{f"configurations.{name}": _LENGTH for name in ("thicknesses", "top_plates", "radii")},
    "bounds.storage_modulus": _SOFT,
    "quasi_static.storage_modulus": _SOFT,
    "pores.flow_resistivity": _RESISTIVITY,
    "pores.viscous_length": _PORES,
    "pores.thermal_length": _PORES,
    "sensor_mass": (0.0, 0.1, "a mass", "kg", "g"),
}


def implausible_fields(model: Model) -> Iterator[tuple[Path, str]]:
    """Give path and text of values of a campaign, a fit or a rig file that are hardly ever meant.

    Parameters
    ----------
    model : Model
    """
    for path, value in leaves(model):
        field = ".".join(part for part in path if isinstance(part, str))
        if isinstance(value, float) and field in _HARDLY:
            least, below, what, unit, other = _HARDLY[field]
            if not least <= value < below:
                yield path, asked_back(what, value, unit, other)
