"""YAML 1.2 to plain data that knows its positions, and plain data to YAML.

Scalars follow the core schema: ``1e4`` is a number; ``no``, ``1:30`` and dates are text.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from yaml.error import Mark
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from multilayer.bounds import NUMBER_CHARACTERS, YAML_BYTES
from multilayer.config.compose import (
    BOOL,
    FLOAT,
    INT,
    MAP,
    NULL,
    SEQ,
    STR,
    Place,
    compose,
    core_tag,
    place_in,
    place_of,
)
from multilayer.errors import InputError, Problem, show
from multilayer.files import refuse_endless
from multilayer.writing.manifest import note_input

DataPath = tuple[str | int, ...]


@dataclass(frozen=True)
class Document:
    """The plain data of one file, and where each value stands.

    Attributes
    ----------
    file : Path
        From which it was read.
    data : dict, list, str, int, float, bool or None
        The contents.
    places, key_places : mapping
        Line and column of values and of keys, by path.
    problems : tuple of Problem
        Mistakes that leave the data readable, kept for `validate`; see `parse_yaml`.
    """

    file: Path
    data: Any
    places: Mapping[DataPath, Place] = field(default_factory=dict, repr=False, compare=False)
    key_places: Mapping[DataPath, Place] = field(default_factory=dict, repr=False, compare=False)
    problems: tuple[Problem, ...] = ()

    def position(self, path: DataPath) -> Place:
        """Return line and column, from 1, of the value at `path`, or of its deepest ancestor that exists.

        An aliased value stands where its anchor is.
        """
        while path and path not in self.places:
            path = path[:-1]
        return self.places.get(path, (1, 1))

    def value(self, path: DataPath) -> Any:
        """Return the value at `path`, which must exist."""
        data = self.data
        for step in path:
            data = data[step]
        return data

    def key_position(self, path: DataPath) -> Place:
        """Return line and column of the key that names `path`; of the value where no key does."""
        return self.key_places.get(path) or self.position(path)


def read_yaml(path: Path | str, *, keep_problems: bool = False) -> Document:
    """Read a YAML file.

    Parameters
    ----------
    path : Path or str
        A UTF-8 file.
    keep_problems : bool
        See `parse_yaml`.

    Raises
    ------
    InputError
        When the file cannot be read or is refused, see `parse_yaml`.
    """
    file, most = Path(path), YAML_BYTES.most
    refuse_endless(file)
    try:
        with file.open("rb") as stream:
            raw = stream.read(most + 1)  # its size need not be known: it may be a pipe
    except (OSError, ValueError) as error:
        raise InputError(Problem(_unreadable(file, error), file=file)) from None
    if len(raw) > most:
        raise YAML_BYTES.refusal(len(raw), file, "keep long tables in files of their own")
    note_input(file)
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = raw[: error.start].decode("utf-8-sig")
        message = f"is no UTF-8 text (byte 0x{raw[error.start]:02x}); save the file as UTF-8"
        raise InputError(Problem(message, "", file, *place_in(before, len(before)))) from None
    return parse_yaml(text, file, keep_problems=keep_problems)


def _unreadable(file: Path, error: OSError | ValueError) -> str:
    if isinstance(error, FileNotFoundError):
        return "there is no such file"
    if isinstance(error, IsADirectoryError | PermissionError) and file.is_dir():
        return "is a folder; a file is wanted"
    return f"cannot be read: {getattr(error, 'strerror', None) or error}"


def parse_yaml(text: str, file: Path, *, keep_problems: bool = False) -> Document:
    """Parse YAML text.

    Parameters
    ----------
    text : str
        One document.
    file : Path
        Named in messages.
    keep_problems : bool
        Leave duplicates, keys and tags in `Document.problems` for `validate`, which reports them with its own.

    Raises
    ------
    InputError
        For text that is no YAML or is empty, more than one document, duplicate keys, keys that are no text, tags
        beyond the core schema, merge keys, recursive or exploding aliases, data nested more than 64 deep, and more
        values than `bounds.YAML_VALUES`. Duplicates, keys and tags are reported all at once.
    """
    root = compose(text, file)
    if root is None:
        raise InputError(Problem("is empty", file=file))
    builder = _Builder(file)
    data = builder.build(root, ())
    problems = tuple(problem for _, problem in sorted(builder.problems.items()))
    if problems and not keep_problems:
        raise InputError(problems)
    return Document(file, data, builder.places, builder.key_places, problems)


def _integer(text: str) -> int:
    return int(text, {"0o": 8, "0x": 16}.get(text[:2], 10))


def _float(text: str) -> float:
    return float(text.lower().replace(".inf", "inf").replace(".nan", "nan"))


_SCALARS: dict[str, tuple[set[str], Callable[[str], Any]]] = {  # tag -> tags that its text may resolve to, its value
    NULL: ({NULL}, lambda text: None),
    BOOL: ({BOOL}, lambda text: text.lower() == "true"),
    INT: ({INT}, _integer),
    FLOAT: ({INT, FLOAT}, _float),
}
_TAG_PREFIX = STR.removesuffix("str")


class _Builder:
    """Nodes to plain data; aliased nodes give equal data, not the same object."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.places: dict[DataPath, Place] = {}
        self.key_places: dict[DataPath, Place] = {}
        self.problems: dict[Place, Problem] = {}

    def build(self, node: Node, path: DataPath) -> Any:
        self.places[path] = place_of(node.start_mark)
        if isinstance(node, MappingNode) and node.tag == MAP:
            return self._mapping(node, path)
        if isinstance(node, SequenceNode) and node.tag == SEQ:
            return [self.build(child, (*path, index)) for index, child in enumerate(node.value)]
        if isinstance(node, ScalarNode):
            return self._scalar(node, path)
        return self._wrong_tag(node, path)

    def _mapping(self, node: MappingNode, path: DataPath) -> dict[str, Any]:
        data: dict[str, Any] = {}
        for key_node, value_node in node.value:
            key = self._key(key_node, path)
            inner = (*path, key)
            if key in data:  # the first one stays, with its places
                line = self.key_places[inner][0]
                self._problem(key_node.start_mark, inner, f"stands here a second time; it is in line {line} too")
                continue
            self.key_places[inner] = place_of(key_node.start_mark)
            data[key] = self.build(value_node, inner)
        return data

    def _key(self, node: Node, path: DataPath) -> str:
        if not isinstance(node, ScalarNode):
            self._problem(node.start_mark, path, "a key must be text; put text that starts with '[' or '{' in quotes")
            return ""
        if not node.style and node.value == "<<":
            remedy = "write the fields out, or give a whole value by an alias ('*name')"
            self._problem(node.start_mark, path, f"the merge key '<<' is not part of YAML 1.2; {remedy}")
        elif node.tag in (NULL, BOOL):
            what = show(node.value or None)
            self._problem(node.start_mark, path, f"a key must be text, not {what}; put it in quotes")
        else:
            self._scalar(node, path)
        return str(node.value)

    def _scalar(self, node: ScalarNode, path: DataPath) -> Any:
        if node.tag == STR:
            return node.value
        looks, construct = _SCALARS.get(node.tag, (set(), str))
        if core_tag(node.value) not in looks:
            return self._wrong_tag(node, path)
        if len(node.value) > NUMBER_CHARACTERS.most:
            return self._problem(node.start_mark, path, f"{show(node.value)} has too many digits")
        return construct(node.value)

    def _wrong_tag(self, node: Node, path: DataPath) -> None:
        tag = node.tag.replace(_TAG_PREFIX, "!!", 1)
        known = node.tag in (STR, SEQ, MAP, *_SCALARS)
        why = "does not fit this value" if known else "is not allowed: files hold plain data"
        self._problem(node.start_mark, path, f"the tag '{tag}' {why}; remove it")

    def _problem(self, mark: Mark, path: DataPath, message: str) -> None:
        # by place: what an alias repeats is one mistake
        place = place_of(mark)
        self.problems.setdefault(place, Problem(message, ".".join(map(str, path)), self.file, *place))


class _Dumper(yaml.SafeDumper):
    """Represents plain data only, in full and without aliases."""

    def ignore_aliases(self, data: Any) -> bool:
        return True

    def resolve(self, kind: type[Node], value: Any, implicit: tuple[bool, bool]) -> Any:
        # text stays unquoted where neither YAML 1.2 nor 1.1, which others read, takes it for anything else
        yaml11: Any = super()
        tag = yaml11.resolve(kind, value, implicit)
        return core_tag(value) if tag == STR and kind is ScalarNode and implicit[0] else tag

    def represent_text(self, text: str) -> ScalarNode:
        return self.represent_scalar(STR, text, style=None if text.isprintable() else '"')

    def represent_fields(self, data: dict[Any, Any]) -> MappingNode:
        for key in data:
            if type(key) is not str:
                raise TypeError(f"a key must be text, not {key!r}")
        return self.represent_dict(data)

    def refuse(self, data: Any) -> Node:
        raise TypeError(f"{type(data).__name__} is no plain data: {data!r}")


_PLAIN: dict[Any, Any] = {
    type(None): _Dumper.represent_none,
    bool: _Dumper.represent_bool,
    int: _Dumper.represent_int,
    float: _Dumper.represent_float,
    str: _Dumper.represent_text,
    list: _Dumper.represent_list,
    tuple: _Dumper.represent_list,
    dict: _Dumper.represent_fields,
    None: _Dumper.refuse,
}
_Dumper.yaml_representers, _Dumper.yaml_multi_representers = _PLAIN, {}


def dump_yaml(data: Any) -> str:
    """Return YAML text that `parse_yaml` reads back as the same data, floats bit by bit and as floats.

    Parameters
    ----------
    data : dict, list, str, int, float, bool or None
        Plain data, keys being text; a tuple is written as a list. Order is kept.

    Raises
    ------
    TypeError
        For anything else, NumPy scalars included.
    """
    text: str = yaml.dump(data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, default_flow_style=None, width=110)
    return text
