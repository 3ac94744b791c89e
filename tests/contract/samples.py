"""Sample fields of every layer type and modulus law: name -> (what it is, fields, does it lose no energy)."""

from typing import Any

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

LAYER_SAMPLES: dict[str, list[Sample]] = {
    "fluid": [
        ("ambient gap", {"thickness": 0.1}, True),
        ("film of water", {"thickness": 1e-5, "density": 1000.0, "sound_speed": 1480.0}, True),
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


def samples_of(kind: str, name: str, table: dict[str, Any]) -> Any:
    """Return the samples of one registered name, or say where they belong."""
    assert name in table, f"the {kind} '{name}' has no sample fields: add some to tests/contract/samples.py"
    return table[name]
