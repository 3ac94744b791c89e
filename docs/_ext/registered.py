"""What registries hold, written when the pages are made: no list has to be kept.

``rig-effects`` is the table of the virtual rig's effects, ``registered-classes`` the docstrings of a group's classes.
"""

from __future__ import annotations

from collections.abc import Iterator
from inspect import getdoc
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.typing import ExtensionMetadata

from multilayer.media.laws import LAWS
from multilayer.registry import Registry
from multilayer.rig.effect_base import PERTURBED, Effect
from multilayer.rig.effects import EFFECTS
from multilayer.rig.specimen import SpecimenSettings
from multilayer.units import field_unit

CLASSES: dict[str, Registry[Any]] = {"modulus_laws": LAWS}
HEADING = ["| effect | fields (defaults) | law | perturbed |", "|---|---|---|---|"]
PLAIN = SpecimenSettings(density=80.0, young_modulus=1e5)


def built_in(registry: Registry[Any]) -> Iterator[tuple[str, Any]]:
    """Give name and object of what this package registers itself."""
    for name in registry.names():
        if [owner.package for owner in registry.owners(name)] == ["multilayer"]:
            yield name, registry[name]


def rows(known: bool) -> Iterator[str]:
    """Give a row for each built-in effect that a diagnosis knows, or does not."""
    for name, kind in built_in(EFFECTS):
        if kind.known == known:
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


class RegisteredClasses(SphinxDirective):
    """The docstrings of all classes of a group, as ``modulus_laws``."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return them."""
        classes = [kind for _, kind in built_in(CLASSES[self.arguments[0]])]
        lines = [line for kind in classes for line in (f".. autoclass:: {kind.__module__}.{kind.__qualname__}", "")]
        return self.parse_text_to_nodes("\n".join(lines))


def setup(app: Sphinx) -> ExtensionMetadata:
    """Register the directives."""
    app.add_directive("rig-effects", RigEffects)
    app.add_directive("registered-classes", RegisteredClasses)
    return {"version": "1", "parallel_read_safe": True}
