"""Tube measurements with a known effect, simulated."""

import numpy as np

from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.effects.tube import Tube, TubeSetting
from multilayer.diagnosis.file import diagnosis_file
from multilayer.stack import Stack

F = np.geomspace(200.0, 2000.0, 28)
FOAM = {
    "type": "equivalent_fluid", "name": "foam", "thickness": 0.03, "porosity": 0.97, "flow_resistivity": 1.2e4,
    "tortuosity": 1.3, "viscous_length": 1e-4, "thermal_length": 2e-4,
}  # fmt: skip
FRAME = {"type": "poroelastic", "frame_density": 30.0, "young_modulus": 1.2e5, "poisson_ratio": 0.3, "loss_factor": 0.1}
ELASTIC = FOAM | FRAME
PRIORS = {
    "layers.foam.flow_resistivity": {"lognormal": [1.1e4, 0.1]},
    "layers.foam.tortuosity": {"normal": [1.32, 0.05]},
}
NOISE = 0.002
CASES = {
    "rear_air_gap": {"depth": 0.008},
    "lateral_air_gap": {"width": 1e-3},
    "edge_constraint": {"frequency": 600.0, "frame_density": 12.0, "loss_factor": 0.06},
    "frame_motion": {"young_modulus": 1.5e5, "frame_density": 25.0, "loss_factor": 0.1},
    "facing": {"flow_resistance": 150.0, "surface_density": 0.08},
    "sample_position": {"distance": 4e-3},
    "microphone_gain": {"gain": 0.03},
    "microphone_phase": {"phase": 0.03},
    "temperature": {"difference": 9.0},
    "thickness_error": {"relative": -0.15},
}


def reflection(thickness, effects, frequency=F, layer=FOAM):
    """Return R of a foam as a tube with some effects (values by name) reports it."""
    stack = Stack.model_validate(foam(thickness, layer))
    setting = TubeSetting("tube", frequency, 0.0, stack, Tube())
    acting = [
        (EFFECTS[name](), {key: np.array([[v]]) for key, v in values.items()}) for name, values in effects.items()
    ]
    for effect, values in acting:
        stack = effect.stack(setting, stack, values)
    r = np.atleast_2d(setting.reflection(stack))
    for effect, values in acting:
        r = effect.surface(setting, stack, r, values)
    for effect, values in acting:
        r = effect.reading(setting, r, values)
    return np.broadcast_to(r, (1, len(frequency)))[0]


def foam(thickness, layer=FOAM):
    return {"version": 1, "layers": [layer | {"thickness": thickness}]}


def with_modulus(law):
    """Return the elastic foam with a modulus that varies with frequency."""
    return {name: value for name, value in ELASTIC.items() if name != "loss_factor"} | {"young_modulus": law}


def table(r, frequency=F):
    rows = "".join(f"{f!r},{x.real!r},{x.imag!r}\n" for f, x in zip(frequency.tolist(), r.tolist(), strict=True))
    return f"frequency_hz,reflection_re,reflection_im\n{rows}"


def measured(folder, acting, thicknesses=(0.03, 0.06), seed=1, smooth=0.0, layer=FOAM, nominal=None, **more):
    """Write measurements of some thicknesses with noise and smooth errors, and return their diagnosis file.

    The file holds the `nominal` layer where it is not the one that was measured.
    """
    rng = np.random.default_rng(seed)
    distance = np.abs(np.subtract.outer(np.log(F), np.log(F)))
    factor = smooth * np.linalg.cholesky(np.exp(-distance / 0.3))
    measurements, stacks = [], {}
    for thickness in thicknesses:
        name = f"mm{1e3 * thickness:.0f}"
        r = reflection(thickness, acting, layer=layer)
        r = r + NOISE * (rng.standard_normal(r.shape) + 1j * rng.standard_normal(r.shape))
        r = r + factor @ (rng.standard_normal(r.shape) + 1j * rng.standard_normal(r.shape))
        (folder / f"{name}.csv").write_text(table(r))
        noise = {"absolute": NOISE}
        measurements.append({"kind": "reflection", "name": name, "file": f"{name}.csv", "stack": name, "noise": noise})
        stacks[name] = foam(thickness, nominal or layer)
    search = {"starts": 1, "candidates": 8}
    data = {"stacks": stacks, "measurements": measurements, "unknowns": PRIORS, "search": search, **more}
    return diagnosis_file(folder, **data)
