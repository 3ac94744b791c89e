"""Skeletons of new plugins: packages of one module each, filled in from templates."""

from __future__ import annotations

import re
import sys
from importlib.util import find_spec
from keyword import iskeyword

from multilayer.errors import InputError
from multilayer.plugins.commands import BUILT_IN
from multilayer.plugins.listing import registry

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9]*([-_][A-Za-z0-9]+)*")
_LONGEST = 60
_GROUPS = {
    "layer": "layers",
    "law": "modulus_laws",
    "effect": "effects",
    "method": "methods",
    "reader": "readers",
    "command": "commands",
}
_PREFIXES = {"reader": "read_", "command": "command_"}  # of functions; others are classes


class Skeleton:
    """A new package.

    Parameters
    ----------
    name : str
        Of the package, as ``my-foam``.
    kind : str
        ``layer``, ``law``, ``effect``, ``method``, ``reader`` or ``command``.

    Raises
    ------
    InputError
        When it is no name for a package, or is taken.
    """

    def __init__(self, name: str, kind: str) -> None:
        if not _NAME.fullmatch(name) or len(name) > _LONGEST:
            raise InputError(
                f"'{name}' is no name for a package: write letters and digits, parts joined by single hyphens, a "
                f"letter first, {_LONGEST} characters at most, as my-foam"
            )
        self.name, self.kind = name, kind
        self.module = re.sub("[-_]", "_", name).lower()
        self.entry = self.module.replace("_", "-") if kind == "command" else self.module
        self.title = "".join(part.capitalize() for part in self.module.split("_"))
        self.object = f"{prefix}{self.module}" if (prefix := _PREFIXES.get(kind)) else self.title
        reason = self._taken()
        if reason:
            raise InputError(f"'{name}' cannot be the package's name: {reason}; choose another one")

    def _taken(self) -> str:
        if iskeyword(self.module):
            return f"'{self.module}' is a word of Python's grammar"
        if self.module in sys.stdlib_module_names or self.module == "tests":
            return f"Python has a module '{self.module}' already"
        installed = find_spec(self.module)
        if installed is not None and installed.origin is not None:
            return f"a module '{self.module}' is installed already"
        if self.kind == "command" and self.entry in BUILT_IN:
            return f"'{self.entry}' is a built-in command"
        if re.search(rf"^from .* import .*\b{self.object}\b", self.files()[f"{self.module}.py"], re.MULTILINE):
            return f"its class would be called '{self.object}', as something that its module imports"
        owners = registry(self.kind).origins(self.entry)
        return f"{self.kind} '{self.entry}' is there already, by {owners[0]}" if owners else ""

    def files(self) -> dict[str, str]:
        """Return the texts of all files by their paths inside the package's folder."""
        from jinja2 import Environment, PackageLoader, StrictUndefined  # heavy

        environment = Environment(
            loader=PackageLoader("multilayer.plugins"), undefined=StrictUndefined, keep_trailing_newline=True
        )  # of program text, where nothing is to be escaped
        values = {
            "name": self.name,
            "kind": self.kind,
            "module": self.module,
            "entry": self.entry,
            "title": self.title,
            "group": _GROUPS[self.kind],
            "object": self.object,
        }
        sources = {
            "pyproject.toml": "pyproject.toml.jinja",
            "README.md": f"{self.kind}/README.md.jinja",
            f"{self.module}.py": f"{self.kind}/module.py.jinja",
            "tests/conftest.py": "conftest.py.jinja",
            f"tests/test_{self.module}.py": f"{self.kind}/test.py.jinja",
        }
        return {path: environment.get_template(source).render(values) for path, source in sources.items()}
