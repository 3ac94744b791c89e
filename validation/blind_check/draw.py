"""Campaigns for a blind check: drawn with the virtual rig, labels apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from multilayer.rig.effect_base import Size
from multilayer.rig.effects import EFFECTS
from multilayer.rig.file import RigFile

Kind = Literal["none", "one", "two", "outside", "deleted"]
# shares of campaigns: no effect, one known effect, two at once, one outside of the library, one deleted from it first
MIX: dict[Kind, float] = {"none": 0.25, "one": 0.35, "two": 0.10, "outside": 0.15, "deleted": 0.15}
_PERTURBATION = 0.3  # of the effects' laws: data and explanation do not share their formulae


# the order in which the first effects were drawn: campaigns of a number stay what they were, later effects follow
_FIRST = (
    "finite_size", "sensor_mass", "adhesive", "channel_gain", "channel_delay", "high_pass", "crosstalk", "preload",
    "saturating_air", "sensor_mount", "rocking", "delamination", "skin", "amplitude_softening", "temperature_drift",
    "flanking", "clock_skew", "cable_resonance", "base_tilt", "creep", "grading",
)  # fmt: skip


def _drawn(*, known: bool) -> dict[str, Size | None]:
    """Return the effects that are drawn, of those that a diagnosis knows or of others; None for one without a size."""
    drawn = {name: kind.drawn for name, kind in EFFECTS.working() if kind.known == known and kind.drawn is not None}
    order = sorted(drawn, key=lambda name: _FIRST.index(name) if name in _FIRST else len(_FIRST))
    return {name: drawn[name] if drawn[name].field else None for name in order}


# names of the rig's effects; the names in the diagnosis are the same
KNOWN, OUTSIDE = _drawn(known=True), _drawn(known=False)
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
