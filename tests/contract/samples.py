"""Sample fields of every layer type and modulus law: name -> (what it is, fields, does it lose no energy)."""

from typing import Any

from multilayer.layers import LAYERS
from multilayer.media.laws import LAWS
from multilayer.registry import Registry, RegistryError

Sample = tuple[str, dict[str, Any], bool]

_STEEL = {"density": 7800.0, "young_modulus": 2.1e11, "poisson_ratio": 0.3}
_RUBBER = {"density": 242.0, "young_modulus": 806919 + 363114j, "poisson_ratio": 0.3}
_ZENER = {
    "law": "fractional_zener",
    "relaxed_modulus": 1e5,
    "unrelaxed_modulus": 1e7,
    "relaxation_time": 1e-4,
    "order": 0.6,
}
_MELAMINE = {
    "porosity": 0.99,
    "flow_resistivity": 1e4,
    "tortuosity": 1.01,
    "viscous_length": 1e-4,
    "thermal_length": 2e-4,
    "frame_density": 9.0,
    "young_modulus": 1.6e5,
    "poisson_ratio": 0.4,
    "loss_factor": 0.1,
}
_DENSE_FOAM = {
    "porosity": 0.9,
    "flow_resistivity": 8e5,
    "tortuosity": 2.5,
    "viscous_length": 1e-5,
    "thermal_length": 5e-5,
    "frame_density": 120.0,
    "young_modulus": 8e5,
    "poisson_ratio": 0.0,
    "loss_factor": 0.3,
}

_PORE_FIELDS = ("porosity", "flow_resistivity", "tortuosity", "viscous_length", "thermal_length")
_PORES = {name: _MELAMINE[name] for name in _PORE_FIELDS}
_DENSE_PORES = {name: _DENSE_FOAM[name] for name in _PORE_FIELDS}
_JCAL = {"model": "jcal", "thermal_permeability": 6e-9}
_JCAPL = {**_JCAL, "model": "jcapl", "static_viscous_tortuosity": 1.3, "static_thermal_tortuosity": 1.4}
_WILSON = {"porosity": 0.98, "tortuosity": 1.05}
_MICRO = {"model": "maa", "thickness": 2e-4, "hole_radius": 1e-4, "perforation": 0.01}
_FELT = {"model": "fibres", "porosity": 0.9, "fibre_diameter": 2e-5, "fibre_orientation": 1 / 3}
_RIBS = {"rib_height": 0.02, "rib_width": 3e-3, "rib_spacing": 0.1}
_WOOD = {
    "thickness": 0.01,
    "density": 450.0,
    "young_modulus_x": 11e9,
    "young_modulus_y": 5e8,
    "poisson_ratio_xy": 0.4,
    "shear_modulus_xy": 7e8,
}

LAYER_SAMPLES: dict[str, list[Sample]] = {
    "fluid": [
        ("ambient gap", {"thickness": 0.1}, True),
        ("film of water", {"thickness": 1e-5, "density": 1000.0, "sound_speed": 1480.0}, True),
        ("air of a deep cavity", {"thickness": 1.0, "losses": "air"}, False),
        ("hydrogen", {"thickness": 2.0, "density": 0.08, "sound_speed": 1300.0}, True),
    ],
    "elastic_solid": [
        ("steel", {"thickness": 1e-3, **_STEEL}, True),
        ("foil", {"thickness": 1e-6, **_STEEL}, True),
        ("wall", {"thickness": 0.3, **_STEEL, "loss_factor": 0.01}, False),
        ("rubber", {"thickness": 0.026, **_RUBBER}, False),
        ("auxetic", {"thickness": 0.01, **_RUBBER, "poisson_ratio": -0.5}, False),
        ("by a law", {"thickness": 0.026, **_RUBBER, "young_modulus": _ZENER}, False),
        ("nearly incompressible", {"thickness": 0.01, **_RUBBER, "poisson_ratio": 0.499}, False),
    ],
    "elastic_plate": [
        ("steel", {"thickness": 1e-3, **_STEEL}, True),
        ("board", {"thickness": 0.02, **_RUBBER, "young_modulus": 3e9, "loss_factor": 0.03}, False),
        ("by a law", {"thickness": 2e-3, **_RUBBER, "young_modulus": _ZENER}, False),
    ],
    "poroelastic": [
        ("melamine", {"thickness": 0.03, **_MELAMINE}, False),
        ("undamped frame", {"thickness": 0.03, **_MELAMINE, "loss_factor": 0.0}, False),
        ("dense foam", {"thickness": 0.01, **_DENSE_FOAM}, False),
        ("very thick", {"thickness": 1.5, **_DENSE_FOAM}, False),
        ("by a law", {"thickness": 0.05, **_MELAMINE, "young_modulus": _ZENER, "loss_factor": 0.0}, False),
        ("thermal permeability", {"thickness": 0.03, **_MELAMINE, **_JCAL}, False),
        ("static tortuosities", {"thickness": 0.03, **_MELAMINE, **_JCAPL}, False),
        (
            "felt",
            {"thickness": 0.02, **_FELT, "frame_density": 120.0, "young_modulus": 1e5 + 1e4j, "poisson_ratio": 0.0},
            False,
        ),
    ],
    "equivalent_fluid": [
        ("johnson-champoux-allard", {"thickness": 0.05, **_PORES}, False),
        ("dense", {"thickness": 0.02, **_DENSE_PORES}, False),
        ("lafarge", {"thickness": 0.05, **_PORES, **_JCAL}, False),
        ("pride-lafarge", {"thickness": 0.05, **_PORES, **_JCAPL}, False),
        ("wilson", {"model": "wilson", "thickness": 0.05, **_WILSON, "flow_resistivity": 1e4}, False),
        (
            "wilson by its times",
            {"model": "wilson", "thickness": 0.05, **_WILSON, "vorticity_time": 1e-4, "entropy_time": 2e-4},
            False,
        ),
        ("fibres", {"model": "fibres", "thickness": 0.05, "porosity": 0.97, "fibre_diameter": 1e-5}, False),
        (
            "random fibres",
            {**_FELT, "thickness": 0.02},
            False,
        ),
        ("cells", {"model": "open_cells", "thickness": 0.05, "porosity": 0.98, "cell_size": 6e-4}, False),
        ("gravel", {"model": "grains", "thickness": 0.1, "porosity": 0.4, "grain_diameter": 5e-3}, False),
        (
            "holes in wool",
            {
                **{"model": "double_porosity", "thickness": 0.1, "perforation": 0.1, "hole_radius": 5e-3},
                **{**_PORES, "flow_resistivity": 1e5},
            },
            False,
        ),
        (
            "slits in a foam",
            {"model": "double_porosity", "thickness": 0.1, "perforation": 0.2, "slit_width": 4e-3, **_DENSE_PORES},
            False,
        ),
        (
            "horoshenkov-swift",
            {
                "model": "horoshenkov_swift",
                "thickness": 0.05,
                "porosity": 0.4,
                "median_pore_size": 1e-4,
                "pore_size_deviation": 0.4,
            },
            False,
        ),
    ],
    "limp": [
        ("johnson-champoux-allard", {"thickness": 0.05, **_PORES, "frame_density": 30.0}, False),
        ("dense", {"thickness": 0.02, **_DENSE_PORES, "frame_density": 600.0}, False),
        ("lafarge", {"thickness": 0.05, **_PORES, **_JCAL, "frame_density": 9.0}, False),
        ("felt", {"thickness": 0.02, **_FELT, "frame_density": 120.0}, False),
    ],
    "screen": [
        ("held still", {"flow_resistance": 400.0}, False),
        ("free to move", {"flow_resistivity": 1e6, "thickness": 5e-4, "surface_density": 0.2}, False),
    ],
    "membrane": [
        ("septum", {"surface_density": 5.0}, True),
        ("film", {"surface_density": 0.02, "tension": 1000.0}, True),
        ("damped", {"surface_density": 0.3, "tension": 5000.0, "loss_factor": 0.1}, False),
    ],
    "orthotropic_plate": [
        ("wood", {**_WOOD, "loss_factor": 0.02, "azimuth": 30.0}, False),
        ("along the grain", _WOOD, True),
        ("by a law", {**_WOOD, "young_modulus_x": _ZENER, "poisson_ratio_xy": 0.0}, False),
    ],
    "corrugated_plate": [
        ("roof", {"thickness": 6e-4, **_STEEL, "period": 0.076, "height": 0.018}, True),
        (
            "deck",
            {
                **{"thickness": 7e-4, **_STEEL, "loss_factor": 0.01, "azimuth": 20.0},
                **{"period": 0.2, "height": 0.04, "crest_width": 0.03, "trough_width": 0.12},
            },
            False,
        ),
    ],
    "ribbed_plate": [
        ("stiffened steel", {"thickness": 2e-3, **_STEEL, **_RIBS}, True),
        ("damped", {"thickness": 5e-3, **_STEEL, **_RIBS, "loss_factor": 0.05, "azimuth": 70.0}, False),
    ],
    "perforated_plate": [
        ("perforated", {"thickness": 1e-3, "hole_radius": 5e-4, "perforation": 0.05}, False),
        ("on a foam", {"thickness": 2e-3, "hole_radius": 1e-3, "perforation": 0.3, "back_tortuosity": 1.5}, False),
        ("maa", {**_MICRO}, False),
        ("slits", {"thickness": 2e-3, "slit_width": 1e-3, "perforation": 0.1}, False),
        ("slits after maa", {"model": "maa", "thickness": 5e-4, "slit_width": 1e-4, "perforation": 0.02}, False),
        ("moving foil", {**_MICRO, "density": 1400.0}, False),
        (
            "gypsum",
            {
                "thickness": 0.0125,
                "hole_radius": 3e-3,
                "perforation": 0.15,
                "density": 700.0,
                "young_modulus": 2e9,
                "poisson_ratio": 0.3,
                "loss_factor": 0.01,
            },
            False,
        ),
        ("loud", {**_MICRO, "hole_velocity": 5.0, "discharge_coefficient": 0.8}, False),
        ("in a flow", {**_MICRO, "bias_velocity": 2.0, "grazing_mach": 0.1, "density": 1400.0}, False),
    ],
    "helmholtz_resonators": [
        (
            "bottles",
            {"neck_radius": 5e-3, "neck_length": 0.02, "pitch": 0.1, "cavity_depth": 0.1, "cavity_radius": 0.04},
            False,
        ),
        ("honeycomb", {"neck_radius": 5e-4, "neck_length": 1e-3, "pitch": 0.01, "cavity_depth": 0.04}, False),
    ],
    "patches": [
        (
            "resonators beside wool",
            {
                "period": 0.02,
                "patches": [
                    {"share": 0.3, "closed": True, "layers": [{"type": "fluid", "thickness": 0.1}]},
                    {
                        "share": 0.7,
                        "layers": [
                            {"type": "screen", "flow_resistance": 300.0},
                            {"type": "viscothermal_fluid", "thickness": 0.03, "slit_width": 3e-4},
                        ],
                    },
                ],
            },
            False,
        ),
    ],
    "viscothermal_fluid": [
        ("gap", {"thickness": 1e-4}, False),
        ("honeycomb", {"thickness": 0.03, "tube_radius": 3e-4, "open_area": 0.8}, False),
        ("slats", {"thickness": 0.03, "slit_width": 3e-4}, False),
    ],
}

_TABLE = {
    "frequency": (1.0, 100.0, 1e4, 5e4),
    "storage_modulus": (1e5, 2e5, 5e5, 6e5),
    "loss_modulus": (0.0, 4e4, 1e5, 5e4),
}
LAW_SAMPLES: dict[str, list[dict[str, Any]]] = {
    "constant": [{"young_modulus": 7e10}],
    "complex": [{"storage_modulus": 1e5, "loss_modulus": 2e4}, {"storage_modulus": 1e5, "loss_modulus": 0.0}],
    "loss_factor": [{"young_modulus": 1e5, "loss_factor": 0.3}],
    "kelvin_voigt": [{"young_modulus": 1e5, "viscosity": 12.0}],
    "fractional_zener": [
        {key: value for key, value in _ZENER.items() if key != "law"},
        {"relaxed_modulus": 1e5, "unrelaxed_modulus": 1e5, "relaxation_time": 1e-3, "order": 1.0},
    ],
    "table": [_TABLE],
}


def layer_samples(name: str) -> list[Sample]:
    """Return the samples of a layer type: those of the table, or what a plugin's class says itself."""
    return LAYER_SAMPLES.get(name) or [(f"example {i}", dict(fields), False) for i, fields in _examples(LAYERS, name)]


def law_samples(name: str, table: dict[str, list[dict[str, Any]]]) -> list[dict[str, Any]]:
    """Return the samples of a modulus law, likewise."""
    return table.get(name) or [dict(fields) for _, fields in _examples(LAWS, name)]


def _examples(registry: Registry[Any], name: str) -> list[tuple[int, Any]]:
    try:
        return list(enumerate(registry[name].examples))
    except RegistryError:  # a broken plugin has none, and its own test fails
        return []
