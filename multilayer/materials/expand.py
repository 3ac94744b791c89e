"""`material: NAME` in a layer of a stack file, replaced by the material's fields."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from pydantic_core import ErrorDetails, InitErrorDetails

from multilayer.errors import InputError, show
from multilayer.layers.base import layer_type
from multilayer.materials import TEXTS, find_material, known_fields, load_library
from multilayer.models import misspelt, mistake


@dataclass
class Expanded:
    """A stack's data without `library` and `material`.

    Attributes
    ----------
    data : Any
        For the validation.
    problems : list
        Libraries and materials that are missing, and these keys misspelt.
    lost : set of int
        Layers whose material is missing: further mistakes in them follow from that, and are left out.
    borrowed : dict
        By layer, the material's name and the fields that come from it.
    """

    data: Any
    problems: list[InitErrorDetails] = field(default_factory=list)
    lost: set[int] = field(default_factory=set)
    borrowed: dict[int, tuple[str, set[str]]] = field(default_factory=dict)

    def relocated(self, error: ErrorDetails) -> InitErrorDetails | None:
        """Return a mistake in `data` as it reads in the file, naming the material; None in a lost layer."""
        place, reason = error["loc"], error["msg"].removeprefix("Value error, ")  # of validators of whole models
        index = place[1] if len(place) > 1 and place[0] == "layers" and isinstance(place[1], int) else None
        if index in self.lost:
            return None
        if index in self.borrowed:
            name, fields = self.borrowed[index]
            if len(place) > 2 and place[2] in fields:
                reason = f"{place[2]} of its material '{name}': {reason}"
            elif len(place) == 2:  # of several fields together
                reason = f"with what its material '{name}' gives: {reason}"
        return mistake(error["type"], place, reason, error["input"])


def expand_materials(data: Any, folder: Path) -> Expanded:
    """Replace the materials of a stack's data.

    Parameters
    ----------
    data : Any
        What stands in a stack file, not validated: ``library`` names a library file, a layer may have a ``material``.
    folder : Path
        To which paths in the data are relative.
    """
    if not isinstance(data, Mapping):
        return Expanded(data)
    problems: list[InitErrorDetails] = []
    data = _spelt(data, "library", (), problems)
    layers = data.get("layers")
    if isinstance(layers, list | tuple):
        layers = [_spelt(layer, "material", ("layers", i), problems) for i, layer in enumerate(layers)]
    if "library" not in data and not _uses_materials(layers):
        return Expanded(data)
    result = Expanded({key: value for key, value in data.items() if key != "library"}, problems)
    user_library = _user_library(data["library"], folder, problems) if "library" in data else {}
    if isinstance(layers, list):
        result.data["layers"] = [_layer(layer, i, user_library, result) for i, layer in enumerate(layers)]
    return result


def _spelt(data: Any, key: str, place: tuple[str | int, ...], problems: list[InitErrorDetails]) -> Any:
    """Return a mapping whose `key` is spelt right: where it is not, that is a mistake, and what follows is read on."""
    if not isinstance(data, Mapping) or key in data:
        return data
    alike = [str(name) for name in data if str(name)[:1].casefold() == key[0]]  # few: comparing takes time
    near = next((name for name in get_close_matches(key, alike) if name not in known_fields()), None)
    if near is None:
        return data
    problems.append(misspelt((*place, near), key))
    return {key if name == near else name: value for name, value in data.items()}


def _uses_materials(layers: Any) -> bool:
    return isinstance(layers, list) and any(isinstance(layer, Mapping) and "material" in layer for layer in layers)


def _user_library(written: Any, folder: Path, problems: list[InitErrorDetails]) -> dict[str, dict[str, Any]] | None:
    """Return the user's library, or None when it cannot be read."""
    try:
        if not isinstance(written, str):
            raise InputError(f"must be the path of a library file, not {show(written)}")
        return load_library(folder / written)
    except InputError as error:
        problems.append(mistake("library", ("library",), str(error), written))
        return None


def _layer(layer: Any, index: int, user_library: dict[str, dict[str, Any]] | None, result: Expanded) -> Any:
    """Return a layer with the fields of its material, where the layer does not set them itself."""
    if not isinstance(layer, Mapping) or "material" not in layer:
        return layer
    name = layer["material"]
    rest = {key: value for key, value in layer.items() if key != "material"}
    try:
        if not isinstance(name, str):
            raise InputError(f"must be the name of a material, not {show(name)}")
        fields = find_material(name, user_library or {})
    except InputError as error:
        if user_library is not None:  # else the library is to blame
            result.problems.append(mistake("material", ("layers", index, "material"), str(error), name))
        result.lost.add(index)
        return rest
    merged = {**{key: value for key, value in fields.items() if key not in TEXTS}, **rest}
    taken = _fields_taken(merged)
    result.borrowed[index] = name, {key for key in merged if key not in rest and key in taken}
    return {key: value for key, value in merged.items() if key in rest or key in taken}


def _fields_taken(data: Mapping[str, Any]) -> frozenset[str]:
    """Return the fields that a layer's type has; all when there is no such type, which its validation refuses."""
    try:
        return layer_type(data.get("type")).fields_taken(data)
    except InputError:
        return frozenset(data)
