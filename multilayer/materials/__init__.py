"""Materials by name: a built-in library from the literature, and one of the user beside it.

A library file is YAML::

    kind: library
    version: 1
    materials:
      our_foam:
        source: measured in 2024, lot 7        # `source` and `note` are text for the reader
        type: poroelastic                      # the layer type, unless a layer says another
        porosity: 0.98
        flow_resistivity: 12 kN s/m^4
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ValidationError

from multilayer.config.validate import read
from multilayer.errors import InputError, suggest
from multilayer.layers.base import LAYERS
from multilayer.models import Model, mistake

BUILT_IN = Path(__file__).with_name("library.yaml")
TEXTS = ("source", "note")  # for the reader; no fields of a layer
_OTHER = {*TEXTS, "type"}


def _known_fields() -> set[str]:
    """Return the fields of all layer types, a plugin that does not load left out."""
    return {field for _, kind in LAYERS.working() for field in kind.model_fields} - {"name"}


def _check_names(material: dict[str, Any]) -> dict[str, Any]:
    known = _known_fields() | _OTHER
    problems = [
        mistake("extra_forbidden", (name,), f"no layer has such a field; {suggest(name, known)}", value)
        for name, value in material.items()
        if name not in known
    ]
    if problems:
        raise ValidationError.from_exception_data("material", problems)
    return material


class Library(Model):
    """The contents of a library file."""

    version: Literal[1] = 1
    materials: dict[str, Annotated[dict[str, Any], AfterValidator(_check_names)]]


def load_library(path: str | Path | None = None) -> dict[str, dict[str, Any]]:
    """Read a library of materials.

    Parameters
    ----------
    path : path, optional
        A library file; the built-in library when left out.

    Returns
    -------
    dict
        Fields by the material's name, as they stand in the file.

    Raises
    ------
    InputError
        With every mistake in the file, each with its line and column.
    """
    return read(BUILT_IN if path is None else Path(path), Library, "library").materials


def material(name: str, user_library: str | Path | None = None) -> dict[str, Any]:
    """Return the fields of a material, looked up in the user's library before the built-in one.

    Parameters
    ----------
    name : str
    user_library : path, optional
        A library file.

    Raises
    ------
    InputError
        When a library cannot be read or neither has the material, with the nearest names.
    """
    return find_material(name, {} if user_library is None else load_library(user_library))


def find_material(name: str, user_library: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Return the fields of a material from the user's library, read before, or from the built-in one.

    Raises
    ------
    InputError
        When neither has it, with the nearest names.
    """
    built_in = _built_in()
    if name not in user_library and name not in built_in:
        raise InputError(f"there is no material '{name}'; {_nearest(name, [*user_library, *built_in])}")
    return dict(user_library[name] if name in user_library else built_in[name])


@cache
def _built_in() -> dict[str, dict[str, Any]]:
    return load_library()


def _nearest(name: str, names: list[str]) -> str:
    """Return a suggestion; a part of a name, as ``melamine``, counts as near to the names that hold it."""
    holding = [known for known in names if name.casefold() in known.casefold()]
    return f"did you mean {' or '.join(repr(known) for known in holding)}?" if holding else suggest(name, names)


__all__ = ["BUILT_IN", "Library", "find_material", "load_library", "material"]
