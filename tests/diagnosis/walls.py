"""Walls and absorbers with a known effect, simulated."""

import numpy as np

from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.file import diagnosis_file
from multilayer.response.bands import band_centres

BANDS = band_centres(100, 3150)
BOARD = {
    "type": "elastic_plate", "name": "board", "thickness": 0.0125, "density": 700.0, "young_modulus": 2.5e9,
    "poisson_ratio": 0.3, "loss_factor": 0.02,
}  # fmt: skip
GLASS = BOARD | {"name": "pane", "thickness": 0.004, "density": 2500.0, "young_modulus": 7e10, "poisson_ratio": 0.22}
WOOL = {"type": "equivalent_fluid", "name": "wool", "thickness": 0.05, "model": "miki", "flow_resistivity": 8e3}
WALLS = {"board": [BOARD], "pane": [GLASS]}
DOUBLE = [BOARD, WOOL, BOARD | {"name": "second"}]
NOISE = 0.3  # dB
UNKNOWN = {"density": {"paths": ["board.layers.board.density"], "normal": [700.0, 7.0]}}


def described(walls=None, unknowns=None, kind="transmission_loss", **more):
    walls = WALLS if walls is None else walls
    end = "ambient" if kind == "transmission_loss" else "rigid"
    measurement = {"kind": kind, "incidence": "diffuse", "bands": "third octaves"}
    if kind == "reverberation_absorption":
        measurement = {"kind": kind, "finite_size": {"width": 3.0, "height": 3.6}}
    return {
        "stacks": {name: {"version": 1, "layers": layers, "termination": end} for name, layers in walls.items()},
        "measurements": [measurement | {"name": name, "stack": name, "file": f"{name}.csv"} for name in walls],
        "unknowns": UNKNOWN if unknowns is None else unknowns,
        "search": {"starts": 1, "candidates": 4},
    } | more


def measured(folder, acting, *, noise=NOISE, seed=1, kind="transmission_loss", walls=None, **more):
    """Write measurements of walls with effects (values by name) and noise; return their diagnosis file."""
    data = described(walls, kind=kind, **more)
    names = [*data["stacks"]]
    write(folder, kind, {name: np.full(len(BANDS), 30.0 if kind == "transmission_loss" else 0.5) for name in names})
    effects = [EFFECTS[name]() for name in acting]
    problem = diagnosis_file(folder, **data).hypothesis.with_effects(*effects)
    sizes = [
        float(p.prior.coordinate(values[p.name])) for effect, values in zip(effects, acting.values(), strict=True)
        for p in effect.parameters
    ]  # fmt: skip
    z = np.concatenate([problem.start, sizes])
    rng = np.random.default_rng(seed)
    levels = [level + noise * rng.standard_normal(len(BANDS)) for level in problem.predict(z)]
    write(folder, kind, dict(zip(names, levels, strict=True)))
    return diagnosis_file(folder, **data)


def write(folder, kind, levels):
    head = "transmission_loss_db" if kind == "transmission_loss" else "absorption"
    for name, values in levels.items():
        rows = "".join(f"{f!r},{v!r}\n" for f, v in zip(BANDS.tolist(), values.tolist(), strict=True))
        (folder / f"{name}.csv").write_text(f"frequency_hz,{head}\n{rows}")
