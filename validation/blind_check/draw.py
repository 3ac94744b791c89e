"""Campaigns for a blind check: drawn with the virtual rig, labels apart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from multilayer.rig.file import RigFile

Kind = Literal["none", "one", "two", "outside", "deleted"]
# shares of campaigns: no effect, one known effect, two at once, one outside of the library, one deleted from it first
MIX: dict[Kind, float] = {"none": 0.25, "one": 0.35, "two": 0.10, "outside": 0.15, "deleted": 0.15}
_PERTURBATION = 0.3  # of the effects' laws: data and explanation do not share their formulae


@dataclass(frozen=True)
class Size:
    """How large an effect is drawn: log-uniform from invisible to obvious, with a random sign where `signed`.

    Attributes
    ----------
    field : str
        Of the rig's effect.
    low, high : float
        SI; the effect of `high` is the smaller one where that is below `low`.
    signed : bool
    parameter : str
        Of the diagnosis, where there is one that says the same.
    of : callable
        That parameter's value from the field's.
    """

    field: str
    low: float
    high: float
    signed: bool = False
    parameter: str = ""
    of: Callable[[float], float] = float

    def place(self, value: float) -> float:
        """Return where a size lies between the smallest that is drawn, 0, and the largest, 1."""
        return float(np.log(abs(value) / self.low) / np.log(self.high / self.low))


_GLUE = 2e-4  # thickness of each layer of glue, m: the default of the rig's `adhesive`

# names of the rig's effects; the names in the diagnosis are the same
KNOWN: dict[str, Size | None] = {
    "finite_size": None,
    "sensor_mass": Size("mass", 5e-5, 5e-3, parameter="mass"),
    "adhesive": Size("young_modulus", 2e6, 2e4, parameter="compliance", of=lambda modulus: _GLUE / modulus),
    "channel_gain": Size("gain", 2e-3, 0.1, signed=True, parameter="gain"),
    "channel_delay": Size("delay", 1e-6, 6e-5, signed=True, parameter="delay"),
    "high_pass": Size("cut_off", 0.3, 30.0, parameter="cut_off"),
    "crosstalk": Size("share", 1e-3, 0.08, parameter="share"),
    "preload": Size("stiffening", 3e-5, 3e-3, parameter="stiffening"),
    "saturating_air": Size("flow_resistivity", 2e3, 2e5, parameter="flow_resistivity"),
    "sensor_mount": Size("frequency", 1.2e4, 2e3, parameter="frequency"),
    "rocking": Size("share", 2e-3, 0.1, parameter="share"),
    "delamination": Size("bonded_fraction", 0.97, 0.5),
    "skin": Size("ratio", 1.2, 10.0, parameter="ratio"),
    "amplitude_softening": Size("softening", 5.0, 300.0, parameter="softening"),
    "temperature_drift": Size("total", 5e-3, 0.3, signed=True, parameter="total"),
    "flanking": Size("stiffness", 30.0, 5e3, parameter="stiffness"),
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

    @property
    def several(self) -> bool:
        """Whether there is more than one configuration."""
        return len(self.settings.mountings) > 1

    @property
    def label(self) -> str:
        """The label in a word."""
        return "none" if not self.effects else " and ".join(self.effects)

    @property
    def place(self) -> float:
        """How large the effect is, from 0 (invisible) to 1 (obvious); NaN where there are none, two, or no size."""
        sizes = self._sizes()
        return sizes[0][1].place(sizes[0][2]) if len(self.effects) == 1 and sizes else float("nan")

    @property
    def truth(self) -> dict[str, float]:
        """True values of the diagnosis' parameters that have one, as ``sensor_mass.mass``."""
        return {f"{name}.{size.parameter}": size.of(value) for name, size, value in self._sizes() if size.parameter}

    def _sizes(self) -> list[tuple[str, Size, float]]:
        found = []
        for entry in self.settings.effects:
            size = {**KNOWN, **OUTSIDE}[entry.effect]
            if size is not None:
                skin = self.settings.specimen.skin
                value = skin.ratio if entry.effect == "skin" and skin is not None else getattr(entry, size.field)
                found.append((entry.effect, size, float(value)))
        return found


def draw(number: int, seed: int) -> Draw:
    """Return the campaign of a number in the check of a seed; the same for the same two numbers.

    Parameters
    ----------
    number, seed : int
        Even numbers have two heights under two top plates, odd ones a single configuration.
    """
    rng = np.random.default_rng([seed, number])
    kinds: list[Kind] = list(MIX)
    kind = kinds[int(rng.choice(len(kinds), p=list(MIX.values())))]
    effects = _effects(kind, rng)
    settings = RigFile.model_validate(_description(effects, rng, several=number % 2 == 0))
    deleted = tuple(effects) if kind == "deleted" else ()
    return Draw(number, kind, tuple(effects), deleted, settings, int(rng.integers(2**31)))


def _effects(kind: Kind, rng: np.random.Generator) -> list[str]:
    if kind == "none":
        return []
    if kind == "outside":
        return [str(rng.choice(list(OUTSIDE)))]
    chosen = rng.choice(list(KNOWN), size=2 if kind == "two" else 1, replace=False)
    return [str(name) for name in chosen]


def _description(effects: Sequence[str], rng: np.random.Generator, *, several: bool) -> dict[str, Any]:
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
