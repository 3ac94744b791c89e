"""Campaigns for a blind check: drawn with the virtual rig, labels apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from multilayer.rig.file import RigFile

Kind = Literal["none", "one", "two", "outside", "deleted"]
# GAP.md: no effect, one known effect, two at once, one outside of the library, one deleted from the library first
MIX: dict[Kind, float] = {"none": 0.25, "one": 0.35, "two": 0.10, "outside": 0.15, "deleted": 0.15}
_PERTURBATION = 0.3  # of the effects' laws: data and explanation do not share their formulae


@dataclass(frozen=True)
class Size:
    """How large an effect is drawn: log-uniform from invisible to obvious, with a random sign where `signed`."""

    field: str
    low: float
    high: float
    signed: bool = False
    rest: tuple[tuple[str, float], ...] = ()


# names of the rig's effects; the names in the diagnosis are the same
KNOWN: dict[str, Size | None] = {
    "finite_size": None,
    "sensor_mass": Size("mass", 5e-5, 5e-3),
    "adhesive": Size("young_modulus", 2e4, 2e6),
    "channel_gain": Size("gain", 2e-3, 0.1, signed=True),
    "channel_delay": Size("delay", 1e-6, 6e-5, signed=True),
    "high_pass": Size("cut_off", 0.3, 30.0),
    "crosstalk": Size("share", 1e-3, 0.08),
    "preload": Size("stiffening", 3e-5, 3e-3),
    "saturating_air": Size("flow_resistivity", 2e3, 2e5),
    "sensor_mount": Size("frequency", 2e3, 1.2e4),
    "rocking": Size("share", 2e-3, 0.1),
    "delamination": Size("bonded_fraction", 0.5, 0.97),
    "skin": Size("ratio", 1.2, 10.0),
    "amplitude_softening": Size("softening", 5.0, 300.0),
    "temperature_drift": Size("total", 5e-3, 0.3, signed=True),
    "flanking": Size("stiffness", 30.0, 5e3),
}
OUTSIDE: dict[str, Size | None] = {
    "clock_skew": Size("skew", 2e-5, 2e-3, signed=True),
    "cable_resonance": Size("depth", 0.01, 0.5),
    "base_tilt": Size("share", 2e-3, 0.1),
    "creep": Size("rate", 2e-3, 0.05),
    "grading": None,
}
_SPECIMEN: dict[str, dict[str, Any]] = {
    "skin": {"skin": {"thickness": 1e-3, "ratio": 3.0}},
    "grading": {"grading": [0.6, 1.4]},
}


@dataclass(frozen=True)
class Draw:
    """One campaign of a blind check.

    Attributes
    ----------
    number : int
    kind : str
    effects : tuple of str
        The label: what was added.
    deleted : tuple of str
        Effects that the diagnosis may not use.
    settings : RigFile
    seed : int
    """

    number: int
    kind: Kind
    effects: tuple[str, ...]
    deleted: tuple[str, ...]
    settings: RigFile
    seed: int


def draw(number: int, seed: int, *, several: bool = True) -> Draw:
    """Return the campaign of a number in the check of a seed; the same for the same two numbers.

    Parameters
    ----------
    number, seed : int
    several : bool
        Two heights under two top plates; one configuration otherwise.
    """
    rng = np.random.default_rng([seed, number])
    kind: Kind = rng.choice(list(MIX), p=list(MIX.values()))
    effects = _effects(kind, rng)
    settings = RigFile.model_validate(_description(effects, rng, several))
    deleted = tuple(effects) if kind == "deleted" else ()
    return Draw(number, kind, tuple(effects), deleted, settings, int(rng.integers(2**31)))


def _effects(kind: Kind, rng: np.random.Generator) -> list[str]:
    if kind == "none":
        return []
    if kind == "outside":
        return [str(rng.choice(list(OUTSIDE)))]
    chosen = rng.choice(list(KNOWN), size=2 if kind == "two" else 1, replace=False)
    return [str(name) for name in chosen]


def _description(effects: Sequence[str], rng: np.random.Generator, several: bool) -> dict[str, Any]:
    def log_uniform(low: float, high: float) -> float:
        return float(low * (high / low) ** rng.random())

    relaxed = log_uniform(5e4, 5e5)
    law = {
        "law": "fractional_zener",
        "relaxed_modulus": relaxed,
        "unrelaxed_modulus": relaxed * log_uniform(3, 15),
        "relaxation_time": log_uniform(2e-5, 1e-3),
        "order": float(rng.uniform(0.35, 0.65)),
    }
    specimen: dict[str, Any] = {"density": log_uniform(30, 250), "young_modulus": law}
    if "finite_size" in effects:
        specimen["poisson_ratio"] = float(rng.uniform(0.15, 0.4))
    for name in effects:
        specimen |= _SPECIMEN.get(name, {})
    sizes = {"thicknesses": [0.0125, 0.025], "top_plates": [0.001, 0.003]}
    single = {"thicknesses": [0.025], "top_plates": [0.001]}
    return {
        "version": 1,
        "rig": "two-plate",
        "specimen": specimen,
        "burst": {"cycles": 10, "level_rms": 5.0},
        "frequencies": [100, 200, 300, 450, 600, 800, 1000, 1300],
        "configurations": {**(sizes if several else single), "radii": [0.0225]},
        "repeats": 3,
        "noise": {"white": 0.004},
        "uncertainty": {
            "channel_gain": 0.003, "channel_delay": 1e-6, "remount_gain": 0.001, "thickness": 5e-5, "density": 0.01,
            "top_plate_mass": 0.002,
        },
        "effects": [_effect(name, specimen, rng, log_uniform) for name in effects],
    }  # fmt: skip


def _effect(name: str, specimen: dict[str, Any], rng: np.random.Generator, log_uniform: Any) -> dict[str, Any]:
    """Return the effect's entry, its size and the perturbation of its law drawn."""
    entry: dict[str, Any] = {"effect": name, "perturbation": float(rng.uniform(-_PERTURBATION, _PERTURBATION))}
    size = {**KNOWN, **OUTSIDE}[name]
    if size is None:
        return entry
    value = log_uniform(size.low, size.high)
    if size.signed and rng.random() < 0.5:
        value = -value
    if name == "skin":  # the skin is the specimen's
        specimen["skin"] = {"thickness": 1e-3, "ratio": value}
        return entry
    return entry | {size.field: value}
