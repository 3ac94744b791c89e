"""Changes of a stack's data that concern more than one value: layers added, removed, moved, made of something else.

Contacts, sweeps and tolerances name layers by name or index; they follow the layers they mean.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from multilayer.errors import InputError, suggest
from multilayer.explore.starting import completed, refused_fields
from multilayer.materials import TEXTS, find_material, load_library
from multilayer.paths import index_of

_OVER_PATHS = ("sweep", "tolerances")


@dataclass
class Edited:
    """Data after an edit, and what the user should know of it.

    Attributes
    ----------
    data : dict
    layer : int
        The layer to look at now.
    notices : list of str
        What was taken away beside what was asked for.
    """

    data: dict[str, Any]
    layer: int
    notices: list[str] = field(default_factory=list)


def edited(data: Mapping[str, Any], edit: Mapping[str, Any], folder: Path) -> Edited:
    """Return data with one edit.

    Parameters
    ----------
    data : mapping
        As a file has them.
    edit : mapping
        ``do`` (one of `EDITS`), mostly ``layer``, the layer's index, and what the edit takes.
    folder : Path
        To which the path of the user's library is relative.

    Raises
    ------
    InputError
        When there is no such edit, layer, type or material.
    """
    name = str(edit.get("do"))
    if name not in EDITS:
        raise InputError(f"there is no edit '{name}'; {suggest(name, EDITS)}")
    layers = data.get("layers")
    if not isinstance(layers, list) or not all(isinstance(layer, dict) for layer in layers):
        raise InputError("'layers' must be a list of layers; correct the file")
    return EDITS[name](dict(data), edit, folder)


def _layer(data: Mapping[str, Any], edit: Mapping[str, Any], key: str = "layer", beyond: int = 0) -> int:
    index, count = edit.get(key), len(data["layers"])
    if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < count + beyond:
        raise InputError(f"there is no layer {index!r} among {count}")
    return index


def _add(data: dict[str, Any], edit: Mapping[str, Any], folder: Path) -> Edited:
    at = _layer(data, edit, "at", beyond=1)
    chosen = {key: str(edit[key]) for key in ("material", "type") if edit.get(key)}
    return _with_new(data, at, completed(chosen, borrowed_fields(data, chosen, folder)))


def _copy(data: dict[str, Any], edit: Mapping[str, Any], folder: Path) -> Edited:
    del folder
    i = _layer(data, edit)
    return _with_new(data, i + 1, {key: value for key, value in data["layers"][i].items() if key != "name"})


def _with_new(data: dict[str, Any], at: int, layer: dict[str, Any]) -> Edited:
    n = len(data["layers"])
    return _reordered(data, [*range(at), None, *range(at, n)], at, layer)


def _remove(data: dict[str, Any], edit: Mapping[str, Any], folder: Path) -> Edited:
    del folder
    i, n = _layer(data, edit), len(data["layers"])
    if n == 1:
        raise InputError("a stack needs a layer: add another one before this one is removed")
    return _reordered(data, [j for j in range(n) if j != i], min(i, n - 2))


def _move(data: dict[str, Any], edit: Mapping[str, Any], folder: Path) -> Edited:
    del folder
    i, to = _layer(data, edit), _layer(data, edit, "to")
    order: list[int | None] = [j for j in range(len(data["layers"])) if j != i]
    return _reordered(data, [*order[:to], i, *order[to:]], to)


def _become(data: dict[str, Any], edit: Mapping[str, Any], folder: Path) -> Edited:
    """Make a layer of another material, type or model; what it has and the new one takes, as it stands, stays."""
    i = _layer(data, edit)
    before = data["layers"][i]
    field_name, value = str(edit.get("field")), edit.get("value")
    if field_name == "material":
        kept = {key: before[key] for key in ("name", "thickness") if key in before}
        chosen = {"material": str(value), **kept} if value else {**borrowed_fields(data, before, folder), **before}
        if not value:
            chosen.pop("material", None)
    else:
        chosen = {**before, field_name: value}
    borrowed = borrowed_fields(data, chosen, folder)
    layer = completed(chosen, borrowed)
    while refused := refused_fields(layer, borrowed) & {*borrowed, *chosen} - {field_name, "type", "material", "name"}:
        if not refused <= {*chosen} and field_name != "material":  # of its material, which another type may not take
            chosen, borrowed = {key: value for key, value in {**borrowed, **chosen}.items() if key != "material"}, {}
        kept = {key: value for key, value in chosen.items() if key not in refused}
        if kept == chosen:
            break
        chosen, layer = kept, completed(kept, borrowed)
    return Edited({**data, "layers": [*data["layers"][:i], layer, *data["layers"][i + 1 :]]}, i)


def borrowed_fields(data: Mapping[str, Any], layer: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the fields of a layer's material; none of a layer without one.

    Raises
    ------
    InputError
        When there is no such material, or the user's library cannot be read.
    """
    if "material" not in layer:
        return {}
    library = load_library(folder / str(data["library"])) if "library" in data else {}
    found = find_material(str(layer["material"]), library)
    return {key: value for key, value in found.items() if key not in TEXTS}


def _rename(data: dict[str, Any], edit: Mapping[str, Any], folder: Path) -> Edited:
    del folder
    i, name = _layer(data, edit), str(edit.get("name", "")).strip()
    layer = {key: value for key, value in data["layers"][i].items() if key != "name"}
    named = {"type": layer.pop("type"), "name": name} if "type" in layer else {"name": name}
    changed = {**named, **layer} if name else {**{k: v for k, v in named.items() if k != "name"}, **layer}
    return _reordered(data, list(range(len(data["layers"]))), i, changed, changed_at=i)


def _contact(data: dict[str, Any], edit: Mapping[str, Any], folder: Path) -> Edited:
    """Say how the layer and what lies behind it touch."""
    del folder
    i, kind = _layer(data, edit), str(edit.get("kind"))
    kinds = contacts_behind(data)
    kinds[i] = kind
    return Edited(_with_contacts(data, {j: one for j, one in kinds.items() if one != "bonded"}), i)


EDITS: dict[str, Callable[[dict[str, Any], Mapping[str, Any], Path], Edited]] = {
    "add": _add,
    "copy": _copy,
    "remove": _remove,
    "move": _move,
    "become": _become,
    "rename": _rename,
    "contact": _contact,
}


def contacts_behind(data: Mapping[str, Any]) -> dict[int, str]:
    """Return the stated contacts by the layer in front of them; those that name no neighbours are left out."""
    n, kinds = len(data["layers"]), dict[int, str]()
    written = data.get("contacts")
    for contact in written if isinstance(written, list) else []:
        between = contact.get("between") if isinstance(contact, dict) else None
        if isinstance(between, list) and len(between) == 2:
            ends = sorted(place for end in between if (place := _place(data["layers"], end, n)) is not None)
            if len(ends) == 2 and ends[1] - ends[0] == 1:
                kinds[ends[0]] = str(contact.get("kind"))
    return kinds


def _place(layers: Sequence[Any], end: Any, n: int) -> int | None:
    if end == "termination":
        return n
    try:
        return index_of(layers, end if isinstance(end, int) else str(end), "layers")
    except InputError:
        return None


def _with_contacts(data: Mapping[str, Any], kinds: Mapping[int, str]) -> dict[str, Any]:
    n = len(data["layers"])
    ends = [*(_called(layer, i) for i, layer in enumerate(data["layers"])), "termination"]
    contacts = [{"between": [ends[i], ends[i + 1]], "kind": kind} for i, kind in sorted(kinds.items()) if i < n]
    rest = {key: value for key, value in data.items() if key != "contacts"}
    return {**rest, "contacts": contacts} if contacts else rest


def _called(layer: Mapping[str, Any], index: int) -> Any:
    return layer.get("name") or index


def _reordered(
    data: Mapping[str, Any],
    order: Sequence[int | None],
    look_at: int,
    new: dict[str, Any] | None = None,
    *,
    changed_at: int | None = None,
) -> Edited:
    """Return data with the layers in another order, None being the new one; all that names layers follows."""
    before, n = data["layers"], len(data["layers"])
    layers = [new if i is None or i == changed_at else before[i] for i in order]
    now = {i: place for place, i in enumerate(order) if i is not None} | {n: len(layers)}
    result, notices = Edited({**data, "layers": layers}, look_at), list[str]()
    kinds = {
        now[i]: kind for i, kind in contacts_behind(data).items() if i in now and now.get(i + 1) == now[i] + 1
    }  # of those that are neighbours still
    if lost := len(contacts_behind(data)) - len(kinds):
        notices.append(f"{lost} contact{'s' if lost > 1 else ''} of layers that are no neighbours any more taken away")
    result.data = _with_contacts(result.data, kinds)
    for key in _OVER_PATHS:
        if isinstance(data.get(key), dict):
            moved = {_moved(path, before, layers, now): value for path, value in data[key].items()}
            if None in moved:
                notices.append(f"the {key} of the layer taken away, too")
            kept = {path: value for path, value in moved.items() if path is not None}
            result.data = {k: v for k, v in result.data.items() if k != key} | ({key: kept} if kept else {})
    result.notices = notices
    return result


def _moved(path: str, before: Sequence[Any], layers: Sequence[Any], now: Mapping[int, int]) -> str | None:
    """Return a path to the same layer where that is now; None where it is gone."""
    tokens = path.split(".")
    if tokens[0] != "layers" or len(tokens) < 2:
        return path
    i = _place(before, tokens[1], len(before))
    if i is None:
        return path
    if i not in now:
        return None
    return ".".join(["layers", str(_called(layers[now[i]], now[i])), *tokens[2:]])
