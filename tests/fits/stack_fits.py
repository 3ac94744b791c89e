"""Stacks, measurements simulated from them, and fit files of these."""

import numpy as np

from multilayer.config import dump_yaml
from multilayer.experiments.stacks.file import load_stack_fit
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.paths import with_values
from multilayer.response import base_motion, diffuse_field, plane_wave
from multilayer.stack import Stack

F = np.geomspace(200.0, 4000.0, 40)
ZENER = {
    "law": "fractional_zener", "relaxed_modulus": 8e4, "unrelaxed_modulus": 9e5, "relaxation_time": 3e-5, "order": 0.4,
}  # fmt: skip
WOOL = {
    "type": "equivalent_fluid", "name": "wool", "thickness": 0.04, "porosity": 0.97, "flow_resistivity": 1.2e4,
    "tortuosity": 1.2, "viscous_length": 9e-5, "thermal_length": 2e-4,
}  # fmt: skip
FOAM = {
    "type": "elastic_solid", "name": "foam", "thickness": 0.03, "density": 80.0, "young_modulus": ZENER,
    "poisson_ratio": 0.3,
}  # fmt: skip
PLATE = {
    "type": "elastic_solid", "name": "plate", "thickness": 1e-3, "density": 7800.0, "young_modulus": 2e11,
    "poisson_ratio": 0.3,
}  # fmt: skip
PANEL = {
    "type": "elastic_plate", "name": "panel", "thickness": 2e-3, "density": 2700.0, "young_modulus": 7e10,
    "poisson_ratio": 0.3, "loss_factor": 0.05,
}  # fmt: skip


def stack(*layers, termination="rigid", **more):
    return Stack.model_validate({"layers": list(layers), "termination": termination, **more})


def table(header, *columns):
    rows = [",".join(repr(float(value)) for value in row) for row in zip(*columns, strict=True)]
    return "\n".join([header, *rows, ""])


def parts(header, frequency, values):
    """Return the table of complex values."""
    return table(header, frequency, values.real, values.imag)


def polar(values):
    return np.abs(values), np.rad2deg(np.angle(values))


def noisy(values, size, seed=0):
    rng = np.random.default_rng(seed)
    return values + size * (rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape))


def changed(truth, **fields):
    """Return a stack with other values, as the nominal one."""
    return with_values(truth, {f"layers.{path.replace('__', '.')}": value for path, value in fields.items()})


def write(folder, nominal, tables, measurements, unknowns, **more):
    """Write a fit file with its stacks and tables, and return its path."""
    stacks = nominal if isinstance(nominal, dict) else {"nominal": nominal}
    for name, one in stacks.items():
        (folder / f"{name}.yaml").write_text(dump_yaml(one.to_dict()))
    for name, text in tables.items():
        (folder / name).write_text(text)
    named = (
        {"stacks": {name: f"{name}.yaml" for name in stacks}}
        if isinstance(nominal, dict)
        else {"nominal": "nominal.yaml"}
    )
    data = {"version": 1, **named, "measurements": measurements, "unknowns": unknowns, **more}
    (folder / "fit.yaml").write_text(dump_yaml(data))
    return folder / "fit.yaml"


def problem(folder, *arguments, **more):
    return StackProblem.of_file(load_stack_fit(write(folder, *arguments, **more)))


IN_A_TUBE = stack(WOOL)
ON_A_SHAKER = stack(FOAM, PLATE, termination="free")
IN_A_WALL = stack(
    PANEL, {"type": "fluid", "thickness": 0.05}, {**PANEL, "name": "back", "thickness": 1e-3}, termination="ambient"
)


Z0 = IN_A_TUBE.ambient.gas.impedance
IMPEDANCE = {
    "kind": "surface_impedance", "normalised": True, "file": "tube.csv", "columns": {"real": "re", "imag": "im"},
    "noise": 0.02,
}  # fmt: skip
PORES = {
    "layers.wool.flow_resistivity": {"lognormal": ["10 kN s/m^4", 0.5]},
    "layers.wool.tortuosity": {"uniform": [1, 2]},
    "layers.wool.viscous_length": {"lognormal": ["100 um", 0.7]},
    "layers.wool.thermal_length": {"lognormal": ["200 um", 0.7]},
}


def tube_table(truth, frequency=F, size=0.0, seed=0):
    z = plane_wave(truth, frequency).surface_impedance / Z0
    return parts("f_hz,re,im", frequency, z if size == 0 else z + size * np.abs(z) * noisy(0 * z, 1.0, seed))


def of_every_kind():
    """Return by kind: truth, table, measurement, unknowns."""
    wave, oblique = plane_wave(IN_A_TUBE, F), plane_wave(IN_A_TUBE, F, 40.0)
    z0, wool = IN_A_TUBE.ambient.gas.impedance, {"layers.wool.flow_resistivity": {"lognormal": [1e4, 0.5]}}
    thickness = {"layers.panel.thickness": {"normal": ["2 mm", "10 %"]}}
    some = np.array([250.0, 500.0, 1000.0])
    diffuse = diffuse_field(IN_A_TUBE, some, 78.0).absorption
    order = {"layers.foam.young_modulus.order": {"uniform": [0.2, 0.9]}}
    modulus = ON_A_SHAKER.layers[0].young_modulus
    return {
        "impedance": (IN_A_TUBE, parts("f_hz,re,im", F, wave.surface_impedance / z0),
                      {"kind": "surface_impedance", "normalised": True, "columns": {"real": "re", "imag": "im"}}, wool),
        "impedance in Pa s/m": (IN_A_TUBE, parts("f [kHz],surface_impedance_re [Pa s/m],surface_impedance_im [Pa s/m]",
                                                 F, oblique.surface_impedance).replace("kHz", "Hz"),
                                {"kind": "surface_impedance", "normalised": False, "incidence": 40}, wool),
        "reflection": (IN_A_TUBE, parts("frequency_hz,reflection_re,reflection_im", F, oblique.reflection),
                       {"kind": "reflection", "incidence": "40 deg"}, wool),
        "amount and phase": (IN_A_TUBE, table("f_hz,size,phi_deg", F, *polar(wave.reflection)),
                             {"kind": "reflection", "columns": {"amplitude": "size", "phase": "phi_deg"}}, wool),
        "absorption": (IN_A_TUBE, table("f_hz,alpha [%]", F, 100 * wave.absorption), {"kind": "absorption"}, wool),
        "diffuse absorption": (IN_A_TUBE, table("f_hz,absorption", some, diffuse),
                               {"kind": "absorption", "incidence": "diffuse"}, wool),
        "transmission loss": (IN_A_WALL, table("f_hz,tl_db", F, plane_wave(IN_A_WALL, F, 30.0).transmission_loss),
                              {"kind": "transmission_loss", "incidence": 30, "noise": "0.5 dB"}, thickness),
        "transmissibility": (ON_A_SHAKER, parts("f_hz,transmissibility_re,transmissibility_im", F,
                                                base_motion(ON_A_SHAKER, F).transmissibility),
                             {"kind": "transmissibility"}, order),
        "modulus": (ON_A_SHAKER, parts("frequency_hz,E1_kpa,E2 [kPa]", F, modulus(F) / 1e3),
                    {"kind": "modulus", "layer": "foam"}, order),
    }  # fmt: skip
