"""Layers that the analytic tests share, as fields without their thickness."""

from typing import Any

from multilayer.stack import Stack

AIR = {"type": "fluid"}
WATER = {"type": "fluid", "density": 1000.0, "sound_speed": 1480.0}
ALUMINIUM = {"type": "elastic_solid", "density": 2700.0, "young_modulus": 70e9, "poisson_ratio": 0.33}
BORON_CARBIDE = {"type": "elastic_solid", "density": 2500.0, "young_modulus": 4.5e11, "poisson_ratio": 0.17}
RUBBER = {"type": "elastic_solid", "density": 242.0, "young_modulus": 806919 + 363114j, "poisson_ratio": 0.3}
GEL = {"type": "elastic_solid", "density": 1000.0, "young_modulus": 2e4, "poisson_ratio": 0.499, "loss_factor": 0.05}
SHEET = {
    "type": "elastic_plate", "density": 2700.0, "young_modulus": 70e9, "poisson_ratio": 0.33, "loss_factor": 0.003,
}  # fmt: skip
FOAM = {
    "type": "poroelastic", "porosity": 0.97, "flow_resistivity": 87e3, "tortuosity": 2.52, "viscous_length": 36e-6,
    "thermal_length": 118e-6, "frame_density": 31.0, "young_modulus": 143e6, "poisson_ratio": 0.3,
    "loss_factor": 0.055,
}  # fmt: skip
FOAM2 = {
    "type": "poroelastic", "porosity": 0.98, "flow_resistivity": 15e3, "tortuosity": 1.05, "viscous_length": 100e-6,
    "thermal_length": 250e-6, "frame_density": 25.0, "young_modulus": 140e3, "poisson_ratio": 0.3,
    "loss_factor": 0.1,
}  # fmt: skip


def stack(*layers: tuple[dict[str, Any], float], termination: Any = "ambient", slip: tuple[Any, ...] = ()) -> Stack:
    """Return a stack of (fields, thickness); `slip` holds the pairs of neighbours that slip."""
    contacts = [{"between": pair, "kind": "slip"} for pair in slip]
    slabs = [{**fields, "thickness": thickness} for fields, thickness in layers]
    return Stack.model_validate({"layers": slabs, "contacts": contacts, "termination": termination})
