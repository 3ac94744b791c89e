"""Layers to begin with: typical values for what a type or a model of it needs and nobody has given yet."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from multilayer.layers.base import LAYERS, Layer
from multilayer.layers.field_sets import FieldSets
from multilayer.registry import RegistryError

# a soft foam, an aluminium sheet and their like: no more than where a slider stands before anybody moves it
_TYPICAL: dict[str, Any] = {
    "thickness": "25 mm",
    "porosity": 0.95,
    "flow_resistivity": "10 kN s/m^4",
    "flow_resistance": "200 N s/m^3",
    "tortuosity": 1.1,
    "viscous_length": "100 um",
    "thermal_length": "200 um",
    "thermal_permeability": "2e-9 m^2",
    "static_viscous_tortuosity": 1.4,
    "static_thermal_tortuosity": 1.5,
    "vorticity_time": "10 us",
    "entropy_time": "20 us",
    "median_pore_size": "150 um",
    "pore_size_deviation": 0.3,
    "fibre_diameter": "8 um",
    "fibre_orientation": 0.0,
    "cell_size": "500 um",
    "grain_diameter": "2 mm",
    "frame_density": "30 kg/m^3",
    "density": "2700 kg/m^3",
    "surface_density": "1 kg/m^2",
    "young_modulus": "70 GPa",
    "young_modulus_inplane": "70 GPa",
    "young_modulus_x": "11 GPa",
    "young_modulus_y": "0.5 GPa",
    "shear_modulus": "26 GPa",
    "shear_modulus_xy": "0.7 GPa",
    "poisson_ratio": 0.3,
    "poisson_ratio_inplane": 0.3,
    "poisson_ratio_xy": 0.4,
    "sound_speed": "343 m/s",
    "tension": "100 N/m",
    "period": "80 mm",
    "height": "20 mm",
    "rib_height": "20 mm",
    "rib_width": "3 mm",
    "rib_spacing": "100 mm",
    "hole_radius": "0.5 mm",
    "slit_width": "0.5 mm",
    "perforation": 0.02,
    "open_area": 0.5,
    "tube_radius": "0.5 mm",
    "neck_radius": "3 mm",
    "neck_length": "5 mm",
    "pitch": "50 mm",
    "patches": [
        {"share": 0.5, "layers": [{"type": "fluid", "thickness": "25 mm"}]},
        {
            "share": 0.5,
            "layers": [
                {"type": "equivalent_fluid", "model": "miki", "thickness": "25 mm", "flow_resistivity": "10 kN s/m^4"}
            ],
        },
    ],
    "cavity_depth": "40 mm",
}
_SOFT = {"young_modulus": "120 kPa", "young_modulus_inplane": "120 kPa", "shear_modulus": "50 kPa"}  # of a frame
_THIN: dict[str, str] = {  # layers that are sheets
    "elastic_plate": "1 mm",
    "corrugated_plate": "0.7 mm",
    "ribbed_plate": "3 mm",
    "perforated_plate": "1 mm",
    "elastic_solid": "10 mm",
    "orthotropic_plate": "10 mm",
}


def completed(written: Mapping[str, Any], borrowed: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return a layer's data with all that its type needs, and nothing that it does not take.

    Parameters
    ----------
    written : mapping
        The layer as a file has it, with its ``type`` or ``material``.
    borrowed : mapping, optional
        Fields that come from its material.

    Returns
    -------
    dict
        What is missing is typical of such layers: where a slider begins, no recommendation. Of a type that is not
        known, the data as they are.
    """
    merged = {**(borrowed or {}), **written}
    try:
        kind = LAYERS[str(merged.get("type"))]
    except RegistryError:
        return dict(written)
    taken = kind.fields_taken({key: value for key, value in merged.items() if key != "material"})
    kept = {key: value for key, value in written.items() if key in taken or key == "material"}
    missing = [name for name in _needed(kind, merged) if merged.get(name) is None]
    return kept | {name: value for name in missing if (value := _typical(kind, name)) is not None}


def refused_fields(written: Mapping[str, Any], borrowed: Mapping[str, Any]) -> set[str]:
    """Return the fields of a layer that its type refuses as they stand: out of bounds, or not beside the others.

    Parameters
    ----------
    written : mapping
        The layer as a file has it.
    borrowed : mapping
        Fields that come from its material.
    """
    merged = {key: value for key, value in {**borrowed, **written}.items() if key != "material"}
    try:
        kind = LAYERS[str(merged.get("type"))]
        taken = kind.fields_taken(merged)
        kind.model_validate({key: value for key, value in merged.items() if key in taken or key in written})
    except RegistryError:
        return set()
    except ValidationError as error:
        return {str(each["loc"][0]) for each in error.errors() if each["loc"]}
    return set()


def _needed(kind: type[Layer], data: Mapping[str, Any]) -> list[str]:
    """Return the fields without which a layer is none: required ones, and those of one of its sets."""
    required = [name for name, info in kind.model_fields.items() if info.is_required() and name != "type"]
    if not issubclass(kind, FieldSets):
        return required
    _, sets = kind.field_sets(data)
    given = {name for name, value in data.items() if value is not None}
    nearest = min(sets, key=lambda fields: len(set(fields) - given), default=())
    return [*required, *(name for name in nearest if name not in required)]


def _typical(kind: type[Layer], name: str) -> Any:
    if kind.examples and name in kind.examples[0]:  # a plugin knows better
        value = kind.examples[0][name]
        return f"{value:g}" if isinstance(value, complex) else value  # as a file has it
    type_name = str(kind.model_fields["type"].default)
    if name == "thickness" and type_name in _THIN:
        return _THIN[type_name]
    if name in _SOFT and "porosity" in kind.model_fields:
        return _SOFT[name]
    return _TYPICAL.get(name)
