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

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, ValidationError, ValidationInfo
from pydantic_core import InitErrorDetails

from multilayer.config.kinds import KEY
from multilayer.config.validate import read
from multilayer.errors import InputError, suggest
from multilayer.layers.base import LAYERS, Layer, layer_type
from multilayer.models import Model, as_mistakes, mistake

BUILT_IN = Path(__file__).with_name("library.yaml")
TEXTS = ("source", "note")  # for the reader; no fields of a layer
_OTHER = {*TEXTS, "type"}


def known_fields() -> set[str]:
    """Return the fields of all layer types, a plugin that does not load left out."""
    return {field for _, kind in LAYERS.working() for field in kind.model_fields} - {"name"}


def _check_names(material: dict[str, Any]) -> dict[str, Any]:
    return _sound(material, _wrong_names(material))


def _check_values(material: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
    return _sound(material, [*_wrong_names(material), *_wrong_values(material, info.context)])


def _sound(material: dict[str, Any], problems: list[InitErrorDetails]) -> dict[str, Any]:
    if problems:
        raise ValidationError.from_exception_data("material", problems)
    return material


def _wrong_names(material: Mapping[str, Any]) -> list[InitErrorDetails]:
    known = known_fields() | _OTHER
    return [
        mistake("extra_forbidden", (name,), f"no layer has such a field; {suggest(name, known)}", value)
        for name, value in material.items()
        if name not in known
    ]


def _wrong_values(material: Mapping[str, Any], context: Any) -> list[InitErrorDetails]:
    """Return what does not fit the fields of the material's type; a layer may give what is missing, and its type.

    Without a type, what fits none of the layers that have such a field.
    """
    try:
        kinds = [layer_type(material["type"])] if "type" in material else [kind for _, kind in LAYERS.working()]
    except InputError as error:
        return [mistake("input", ("type",), str(error), material["type"])]
    checked = [_checked(kind, material, context) for kind in kinds]
    problems: list[InitErrorDetails] = []
    for name in material:
        by_kind = [mistakes[name] for mistakes in checked if name in mistakes]
        if by_kind and all(by_kind):
            problems += by_kind[0]
    return problems


def _checked(kind: type[Layer], material: Mapping[str, Any], context: Any) -> dict[str, list[InitErrorDetails]]:
    """Return the mistakes in each value of a material that a layer type takes."""
    taken = kind.fields_taken(material)
    mistakes: dict[str, list[InitErrorDetails]] = {name: [] for name in material if name in taken}
    try:
        kind.model_validate({name: material[name] for name in mistakes}, context=context)
    except ValidationError as error:
        for one in error.errors(include_url=False):
            if one["loc"] and one["loc"][0] in mistakes:
                mistakes[str(one["loc"][0])] += as_mistakes([one])
    return mistakes


class Library(Model):
    """The contents of a library file."""

    also_written: ClassVar[tuple[str, ...]] = (KEY,)

    version: Literal[1] = 1
    materials: dict[str, Annotated[dict[str, Any], AfterValidator(_check_names)]]


class _CheckedLibrary(Library):
    """A library whose values are checked, too, those of materials that nobody asks for among them."""

    materials: dict[str, Annotated[dict[str, Any], AfterValidator(_check_values)]]


def load_library(path: str | Path | None = None) -> dict[str, dict[str, Any]]:
    """Read a library of materials.

    Parameters
    ----------
    path : path, optional
        A library file; the built-in library when left out.

    Returns
    -------
    dict
        Fields by the material's name, as they stand in the file; files that they name are looked for beside it.

    Raises
    ------
    InputError
        With every mistake in the file, each with its line and column; values are left to the layers made of them.
    """
    file = BUILT_IN if path is None else Path(path)
    materials = read(file, Library, "library").materials
    return {name: _with_files_in(file.absolute().parent, fields) for name, fields in materials.items()}


def _with_files_in(folder: Path, written: Any) -> Any:
    """Return what stands in a material, the files that it names by whole paths."""
    if isinstance(written, list):
        return [_with_files_in(folder, value) for value in written]
    if not isinstance(written, dict):
        return written
    return {
        key: str(folder / value) if key == "file" and isinstance(value, str) else _with_files_in(folder, value)
        for key, value in written.items()
    }


def check_library(path: str | Path) -> int:
    """Read a library of materials, each value as the field of the material's type, and return how many there are.

    Parameters
    ----------
    path : path

    Raises
    ------
    InputError
        With every mistake in the file, each with its line and column.
    """
    file = Path(path)
    return len(read(file, _CheckedLibrary, "library", {"folder": file.parent}).materials)


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


__all__ = ["BUILT_IN", "Library", "check_library", "find_material", "known_fields", "load_library", "material"]
