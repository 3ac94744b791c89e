"""Tables of the virtual rig's effects, made of their classes when the pages are made: ``rig-effects`` and no list."""

from __future__ import annotations

from collections.abc import Iterator
from inspect import getdoc
from typing import ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.typing import ExtensionMetadata

from multilayer.rig.effect_base import PERTURBED, Effect
from multilayer.rig.effects import EFFECTS
from multilayer.rig.specimen import SpecimenSettings
from multilayer.units import field_unit

HEADING = ["| effect | fields (defaults) | law | perturbed |", "|---|---|---|---|"]
PLAIN = SpecimenSettings(density=80.0, young_modulus=1e5)


def rows(known: bool) -> Iterator[str]:
    """Give a row for each built-in effect that a diagnosis knows, or does not."""
    for name in EFFECTS.names():
        kind = EFFECTS[name]
        if kind.known == known and [owner.package for owner in EFFECTS.owners(name)] == ["multilayer"]:
            law, _, perturbed = " ".join((getdoc(kind) or "").replace("``", "`").split()).partition(PERTURBED)
            yield f"| `{name}` | {', '.join(fields(kind))} | {law.strip()} | {perturbed.strip().rstrip('.')} |"


def fields(kind: type[Effect]) -> Iterator[str]:
    """Give the fields with the values in force where neither the effect nor the specimen states one."""
    used = kind().parameters(PLAIN)
    for name, field in kind.model_fields.items():
        if name in ("effect", "perturbation"):
            continue
        value, unit = used.get(name, field.default), field_unit(field) or ""
        shown = f"{value:.4g}" if isinstance(value, float) else "" if value is None else str(value)
        yield f"`{name}` {shown} {unit if shown else ''}".strip()


class RigEffects(SphinxDirective):
    """A table of effects; with ``:unknown:`` those that no diagnosis knows."""

    option_spec: ClassVar = {"unknown": directives.flag}

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        lines = [*HEADING, *rows(known="unknown" not in self.options)]
        container = nodes.container()
        self.state.nested_parse(StringList(lines, EFFECTS.group), self.content_offset, container)
        return container.children


def setup(app: Sphinx) -> ExtensionMetadata:
    """Register the directive."""
    app.add_directive("rig-effects", RigEffects)
    return {"version": "1", "parallel_read_safe": True}
