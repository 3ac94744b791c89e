"""The list of effects that a diagnosis knows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.table import Table
from rich.text import Text

from multilayer.diagnosis.effects.base import EFFECTS
from multilayer.registry import RegistryError
from multilayer.report.console import console


def describe_effects(names: Sequence[str] | None = None) -> list[dict[str, Any]]:
    """Return what is known of every registered effect, or of some; of one that cannot be loaded, why."""
    found: list[dict[str, Any]] = []
    for name in EFFECTS.chosen(names):
        try:
            effect = EFFECTS[name]
        except RegistryError as error:
            found.append({"name": name, "problem": str(error)})
            continue
        parameters = [
            {"name": p.name, "unit": p.unit, "prior": p.prior.model_dump(exclude_none=True)} for p in effect.parameters
        ]
        found.append(
            {
                "name": name,
                "kind": effect.kind,
                "law": effect.law,
                "parameters": parameters,
                "separated_by": effect.separated_by,
                "source": effect.source,
            }
        )
    return sorted(found, key=lambda one: one.get("kind", ""), reverse=True)  # names stay sorted within each kind


def effect_table(described: Sequence[dict[str, Any]]) -> None:
    """Print one row per effect."""
    table = Table(box=None, pad_edge=False)
    for heading in ("effect", "of", "law", "parameters", "separated by"):
        table.add_column(heading, overflow="fold")
    for effect in described:
        if "problem" in effect:
            table.add_row(effect["name"], "", Text(effect["problem"], style="red"))
            continue
        parameters = ", ".join(f"{p['name']} ({p['unit']})" if p["unit"] else p["name"] for p in effect["parameters"])
        table.add_row(
            effect["name"], effect["kind"], Text(effect["law"]), parameters or "none", Text(effect["separated_by"])
        )
    console().print(table)
