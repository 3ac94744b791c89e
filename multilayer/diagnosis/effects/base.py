"""The registry of unmodelled effects, and the names that modules of effects import."""

from __future__ import annotations

from typing import Any

from multilayer.experiments.effects import BaseEffect, Values
from multilayer.experiments.two_plate.effects import CENTRED_SENSOR, VACUUM, Chain, Effect, Setting
from multilayer.inference.priors import Parameter, Prior
from multilayer.registry import Registry, subclass_fault

_is_effect = subclass_fault(BaseEffect, "name")


def _effect_fault(name: str, item: Any) -> str:
    silent = [field for field in ("kind", "law", "separated_by") if not getattr(item, field, "")]
    return _is_effect(name, item) or (f"it says no {', '.join(silent)}" if silent else "")


EFFECTS: Registry[type[BaseEffect]] = Registry("multilayer.effects", "effect", _effect_fault)


def positive(
    name: str, median: float, spread: float, unit: str = "", bounds: tuple[float, float] | None = None
) -> Parameter:
    """Return a parameter above 0 with a lognormal prior, which may be cut at `bounds`."""
    return Parameter(name=name, prior=Prior(lognormal=(median, spread), bounds=bounds), unit=unit)


def signed(name: str, spread: float, unit: str = "") -> Parameter:
    """Return a parameter of either sign with a normal prior about 0."""
    return Parameter(name=name, prior=Prior(normal=(0.0, spread)), unit=unit)


def between(name: str, low: float, high: float, unit: str = "") -> Parameter:
    """Return a parameter with a uniform prior."""
    return Parameter(name=name, prior=Prior(uniform=(low, high)), unit=unit)


__all__ = [
    "CENTRED_SENSOR",
    "EFFECTS",
    "VACUUM",
    "BaseEffect",
    "Chain",
    "Effect",
    "Setting",
    "Values",
    "between",
    "positive",
    "signed",
]
