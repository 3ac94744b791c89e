"""The list of effects that a diagnosis knows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from multilayer.diagnosis.effects.base import EFFECTS
from multilayer.inference.priors import Parameter
from multilayer.registry import RegistryError
from multilayer.report.listing import Listing, Tinted
from multilayer.report.report import Report, Section


def effects_report(names: Sequence[str] | None = None) -> Report:
    """Return the effects that a diagnosis knows, all or some; of one that cannot be loaded, why."""
    described = sorted(map(_effect, EFFECTS.chosen(names)), key=lambda entry: entry.get("kind", ""), reverse=True)
    columns: dict[str, Callable[[dict[str, Any]], str]] = {
        "effect": lambda effect: effect["name"],
        "of": lambda effect: effect.get("kind", ""),
        "law": lambda effect: effect["law"] if "law" in effect else Tinted(effect["problem"], "red"),
        "parameters": _cell,
        "separated by": lambda effect: effect.get("separated_by", ""),
    }
    listing = Listing.of(described, columns)
    return Report(kind="effects", sections=(Section("", listings=(listing,)),), record=described)


def _effect(name: str) -> dict[str, Any]:
    try:
        effect = EFFECTS[name]
    except RegistryError as error:
        return {"name": name, "problem": str(error)}
    finer = effect().finer()
    return {
        "name": name,
        "kind": effect.kind,
        "law": effect.law,
        "parameters": _described(effect.parameters),
        **({"finer_parameters": _described(finer.parameters[len(effect.parameters) :])} if finer else {}),
        "separated_by": effect.separated_by,
        "source": effect.source,
    }


def _described(parameters: Sequence[Parameter]) -> list[dict[str, Any]]:
    return [{"name": p.name, "unit": p.unit, "prior": p.prior.model_dump(exclude_none=True)} for p in parameters]


def _cell(effect: dict[str, Any]) -> str:
    """Return the names of an effect's parameters, those of its finer law behind them."""
    if "parameters" not in effect:
        return ""
    named = _named(effect["parameters"]) or "none"
    return f"{named}; finer law: {_named(effect['finer_parameters'])}" if "finer_parameters" in effect else named


def _named(parameters: Sequence[dict[str, Any]]) -> str:
    return ", ".join(f"{p['name']} ({p['unit']})" if p["unit"] else p["name"] for p in parameters)
