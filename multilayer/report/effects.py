"""The list of effects that a diagnosis knows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from multilayer.diagnosis.effects.base import EFFECTS
from multilayer.registry import RegistryError
from multilayer.report.listing import Listing, Tinted
from multilayer.report.report import Report, Section


def effects_report(names: Sequence[str] | None = None) -> Report:
    """Return the effects that a diagnosis knows, all or some; of one that cannot be loaded, why."""
    described = sorted(map(_effect, EFFECTS.chosen(names)), key=lambda entry: entry.get("kind", ""), reverse=True)
    rows = tuple(map(_effect_row, described))
    listing = Listing(("effect", "of", "law", "parameters", "separated by"), rows)
    return Report(kind="effects", sections=(Section("", listings=(listing,)),), record=described)


def _effect(name: str) -> dict[str, Any]:
    try:
        effect = EFFECTS[name]
    except RegistryError as error:
        return {"name": name, "problem": str(error)}
    return {
        "name": name,
        "kind": effect.kind,
        "law": effect.law,
        "parameters": [
            {"name": p.name, "unit": p.unit, "prior": p.prior.model_dump(exclude_none=True)} for p in effect.parameters
        ],
        "separated_by": effect.separated_by,
        "source": effect.source,
    }


def _effect_row(effect: dict[str, Any]) -> tuple[str, ...]:
    if "problem" in effect:
        return effect["name"], "", Tinted(effect["problem"], "red"), "", ""
    parameters = ", ".join(f"{p['name']} ({p['unit']})" if p["unit"] else p["name"] for p in effect["parameters"])
    return effect["name"], effect["kind"], effect["law"], parameters or "none", effect["separated_by"]
