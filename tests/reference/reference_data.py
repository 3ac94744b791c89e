"""The reference files' words for layers and air, as fields of ours."""

from typing import Any

import numpy as np

from multilayer.stack import Stack

# kind in the file -> (our type, their names of our fields)
_FRAME = {"density": "rho", "poisson_ratio": "nu"}
KINDS: dict[str, tuple[str, dict[str, str]]] = {
    "fluid": ("fluid", {"density": "rho", "sound_speed": "c"}),
    "elastic": ("elastic_solid", _FRAME),
    "plate": ("elastic_plate", _FRAME),
    "pem": (
        "poroelastic",
        {
            "porosity": "phi",
            "flow_resistivity": "sigma",
            "tortuosity": "alpha_inf",
            "viscous_length": "Lambda_v",
            "thermal_length": "Lambda_t",
            "frame_density": "rho_1",
            "poisson_ratio": "nu",
        },
    ),
}


def stack_of(air: dict[str, Any], layers: list[dict[str, Any]], backing: str) -> Stack:
    """Return the stack of some layers with a `kind` and a `thickness_m`; `backing` is 'rigid' or 'transmission'."""
    ambient = {
        "density": air["rho0_kg_m3"],
        "sound_speed": air["c0_m_s"],
        "viscosity": air["mu_Pa_s"],
        "prandtl": air["Pr"],
        "heat_capacity_ratio": air["gamma"],
        "pressure": air["P0_Pa"],
    }
    termination = {"rigid": "rigid", "transmission": "ambient"}[backing]
    data = {"ambient": ambient, "layers": [_layer(layer) for layer in layers], "termination": termination}
    return Stack.model_validate(data)


def _layer(layer: dict[str, Any]) -> dict[str, Any]:
    name, fields = KINDS[layer["kind"]]
    ours = {ours: layer[theirs] for ours, theirs in fields.items()}
    return {"type": name, "thickness": layer["thickness_m"], **ours, **_modulus(layer)}


def _modulus(layer: dict[str, Any]) -> dict[str, Any]:
    if "E" not in layer:
        return {}
    if viscosity := layer.get("eta_visc"):
        return {"young_modulus": {"law": "kelvin_voigt", "young_modulus": layer["E"], "viscosity": viscosity}}
    return {"young_modulus": layer["E"], "loss_factor": layer.get("eta") or 0.0}


def worst_error(computed: Any, expected: Any) -> float:
    """Return the largest error relative to each expected value, all of one shape."""
    computed, expected = np.asarray(computed), np.asarray(expected)
    assert computed.shape == expected.shape
    return float(np.max(np.abs(computed - expected) / np.abs(expected)))
