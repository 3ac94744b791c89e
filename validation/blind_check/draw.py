"""Campaigns for a blind check: drawn with the virtual rig, labels apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.effects.base import EFFECTS as DIAGNOSED
from multilayer.rig.bench import Bench
from multilayer.rig.draws import draw_errors
from multilayer.rig.effect_base import Effect, Size
from multilayer.rig.effects import EFFECTS
from multilayer.rig.effects.foreign_law import ForeignLaw
from multilayer.rig.file import RigFile

Shape = tuple[float, float, float]  # height, top plate, radius, m
_SINGLE: tuple[Shape, ...] = ((0.025, 0.001, 0.0225),)
_SEVERAL: tuple[Shape, ...] = tuple((h, t, 0.0225) for h in (0.0125, 0.025) for t in (0.001, 0.003))
_SLIM: tuple[Shape, ...] = (*_SEVERAL, (0.025, 0.001, 0.012))
_FINE = 1.5  # resolution of the mesh: every interval shorter by this factor than that of fits with finite elements
Kind = Literal["none", "one", "two", "outside", "deleted"]
# shares of campaigns: no effect, one known effect, two at once, one outside of the library, one deleted from it first
MIX: dict[Kind, float] = {"none": 0.25, "one": 0.35, "two": 0.10, "outside": 0.15, "deleted": 0.15}
_POINTS = 200  # frequencies at which a sample's modulus is looked at
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
FOREIGN_LAW = "foreign_law"  # drawn anew in every campaign, at any place
_NEW = 0.7  # share of effects of no library that are such
# laws that are drawn at each place: what is passive and causal there, and no law of the library
_LAWS: dict[str, tuple[str, ...]] = {
    "top_plate": ("relaxation", "power", "resonance"),
    "faces": ("relaxation", "power", "resonance"),
    "beside": ("relaxation", "power"),
    "reading": ("resonance", "echo"),
    "added_reading": ("power", "echo"),  # a resonance is what rocking adds
    "sample_load": ("relaxation", "power"),
    "sample_order": ("relaxation", "power"),
    "sample_radius": ("relaxation", "power"),
    "one_configuration": ("constant",),
}
_OF_SEVERAL = ("sample_load", "sample_radius", "one_configuration")
_EITHER_SIGN = ("reading", "added_reading", "one_configuration")
# where effects of the rig act that no diagnosis knows; anisotropy and grading are at no place
_PLACE = {"clock_skew": "reading", "cable_resonance": "reading", "base_tilt": "reading", "creep": "sample_order"}
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
    def places(self) -> tuple[str, ...]:
        """Where the effects act, by the names of the diagnosis's places; empty strings where that is none of them."""
        return tuple(_place_of(entry) for entry in self.settings.effects)

    def true_law(self, frequency: RealArray) -> ComplexArray | None:
        """Return the law at its place, in the place's unit, at frequencies, Hz; None where there is none to compare."""
        if self.effects != (FOREIGN_LAW,) or self.places[0] == "one_configuration":
            return None
        law: ForeignLaw = self.settings.effects[0]  # type: ignore[assignment]
        return law.at_frequency(frequency)

    @property
    def true_form(self) -> str:
        """The kind of the simple form that the law is; empty where it is none."""
        if self.effects != (FOREIGN_LAW,):
            return ""
        entry: ForeignLaw = self.settings.effects[0]  # type: ignore[assignment]
        if entry.law == "resonance":
            return "" if entry.at in ("reading", "added_reading") else "resonance"
        return {"constant": "power", "power": "fractional"}.get(entry.law, "")

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


def _place_of(entry: Effect) -> str:
    if isinstance(entry, ForeignLaw):
        return entry.at
    if entry.effect in _PLACE or not entry.known:
        return _PLACE.get(entry.effect, "")
    return str(getattr(DIAGNOSED[entry.effect], "place", ""))


def draw(number: int, seed: int) -> Draw:
    """Return the campaign of a number in the check of a seed; the same for the same two numbers.

    Parameters
    ----------
    number, seed : int
        Even numbers have two heights under two top plates, every other of them a slimmer sample besides; odd ones a
        single configuration.
    """
    rng = np.random.default_rng([seed, number])
    kinds: list[Kind] = list(MIX)
    kind = kinds[int(rng.choice(len(kinds), p=list(MIX.values())))]
    effects = _effects(kind, rng)
    shapes = [_SINGLE, _SLIM if number % 4 == 0 else _SEVERAL][number % 2 == 0]
    settings = RigFile.model_validate(_description(effects, rng, shapes))
    while not _is_passive(settings):  # a law drawn for the sample may be more than its own losses allow
        settings = RigFile.model_validate(_description(effects, rng, shapes))
    deleted = tuple(effects) if kind == "deleted" else ()
    return Draw(number, kind, tuple(effects), deleted, settings, int(rng.integers(2**31)))


def _is_passive(settings: RigFile) -> bool:
    """Tell whether the sample's modulus, at the end of each configuration, is one that the rig can have."""
    errors = draw_errors(settings, settings.seed)
    for mounting in settings.mountings:
        bench = Bench(settings, errors, mounting)
        band = np.geomspace(*bench.timing.band(mounting.frequencies), _POINTS)
        modulus = bench.modulus(band, bench.moment(mounting.frequencies[-1], settings.repeats - 1))
        if np.any(modulus.real <= 0) or np.any(modulus.imag < 0):
            return False
    return True


def _effects(kind: Kind, rng: np.random.Generator) -> list[str]:
    if kind == "none":
        return []
    if kind == "outside":
        old = [name for name in OUTSIDE if name != FOREIGN_LAW]
        return [FOREIGN_LAW if rng.random() < _NEW else str(rng.choice(old))]
    chosen = rng.choice(list(KNOWN), size=2 if kind == "two" else 1, replace=False)
    return [str(name) for name in chosen]


def _description(effects: Sequence[str], rng: np.random.Generator, shapes: Sequence[Shape]) -> dict[str, Any]:
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
    return {
        "version": 1,
        "rig": "two-plate",
        "specimen": specimen,
        "burst": {"cycles": 10, "level_rms": 5.0},
        "frequencies": [100, 200, 300, 450, 600, 800, 1000, 1300],
        "configurations": [{"thickness": h, "top_plate": t, "radius": r} for h, t, r in shapes],
        "repeats": 3,
        "noise": {"white": 0.004},
        "uncertainty": {
            "channel_gain": 0.003, "channel_delay": 1e-6, "remount_gain": 0.001, "thickness": 5e-5, "density": 0.01,
            "top_plate_mass": 0.002,
        },
        "resolution": _FINE,
        "effects": [_effect(name, specimen, rng, log_uniform, len(shapes)) for name in effects],
    }  # fmt: skip


def _effect(
    name: str, specimen: dict[str, Any], rng: np.random.Generator, log_uniform: Any, configurations: int
) -> dict[str, Any]:
    """Return the effect's entry, its size and the perturbation of its law drawn."""
    if name == FOREIGN_LAW:
        return _foreign_law(rng, log_uniform, configurations)
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


def _foreign_law(rng: np.random.Generator, log_uniform: Any, configurations: int) -> dict[str, Any]:
    """Return a law that no library holds: place, kind, size, frequencies and losses drawn."""
    at = str(rng.choice(list(_LAWS if configurations > 1 else [at for at in _LAWS if at not in _OF_SEVERAL])))
    size = log_uniform(0.02, 1.0)
    if at in _EITHER_SIGN and rng.random() < 0.5:
        size = -size
    return {
        "effect": FOREIGN_LAW,
        "at": at,
        "law": str(rng.choice(list(_LAWS[at]))),
        "size": size,
        "frequency": log_uniform(150.0, 1200.0),
        "exponent": float(rng.uniform(0.2, 1.0)),
        "loss_factor": log_uniform(0.02, 0.5),
        "number": int(rng.integers(configurations)),
    }
