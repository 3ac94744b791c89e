"""YAML text to a graph of nodes: PyYAML's parser, the core schema of YAML 1.2, bounds, errors in plain words.

Nothing of PyYAML's construction of objects is used, so a file can name no class and run no code.

Events come from libyaml, where PyYAML was built with it, in a quarter of the time. PyYAML's own parser reads what
libyaml refuses, so that a mistake is told in the same words everywhere, and the few texts that they read differently.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any, NoReturn, cast

import yaml
from yaml.composer import Composer
from yaml.error import Mark, MarkedYAMLError, YAMLError
from yaml.events import AliasEvent, ScalarEvent
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from yaml.parser import Parser
from yaml.reader import Reader, ReaderError
from yaml.scanner import Scanner

from multilayer.bounds import YAML_NAMES, YAML_VALUES
from multilayer.errors import InputError, Problem

Place = tuple[int, int]

_LIBYAML: Any = getattr(yaml, "CBaseLoader", None)  # only its events are taken
_HALF = re.compile("[\ud800-\udfff]")
# a tab or a '?' between values stops PyYAML's own parser and not libyaml; of the others they count lines differently
_DISPUTED = re.compile("[\t?\x85\u2028\u2029\ufeff]|" + Reader.NON_PRINTABLE.pattern)

DEEPEST = 64  # the parser recurses

STR, INT, FLOAT, BOOL, NULL, SEQ, MAP = (
    f"tag:yaml.org,2002:{name}" for name in ("str", "int", "float", "bool", "null", "seq", "map")
)
# YAML 1.2.2, section 10.3.2
_CORE_SCHEMA = {
    NULL: re.compile(r"null|Null|NULL|~|"),
    BOOL: re.compile(r"true|True|TRUE|false|False|FALSE"),
    INT: re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+"),
    FLOAT: re.compile(
        r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)"
    ),
}
_FIRST = frozenset("nNtTfF~.+-0123456789")  # characters that something else than text begins with


def core_tag(text: str) -> str:
    """Return the tag of a plain scalar."""
    if text and text[0] not in _FIRST:  # most texts
        return STR
    return next((tag for tag, pattern in _CORE_SCHEMA.items() if pattern.fullmatch(text)), STR)


def place_of(mark: Mark) -> Place:
    """Return line and column, from 1."""
    return mark.line + 1, mark.column + 1


def place_in(text: str, index: int) -> Place:
    """Return line and column, from 1, of a character of `text`."""
    return text.count("\n", 0, index) + 1, index - text.rfind("\n", 0, index)


@lru_cache(maxsize=1)  # its kind is told from a file first, then it is read: parsing takes longer than all that follows
def compose(text: str, file: Path) -> Node | None:
    """Return the root node of the one document in `text`, or None for an empty one; nobody may change it.

    Raises
    ------
    InputError
        For text that is no YAML, a second document, recursive or exploding aliases, and data nested too deeply: only
        the first mistake, as later ones may follow from it.
    """
    if _LIBYAML and not _DISPUTED.search(text):
        try:
            composer = _Composer(_LIBYAML(text))
            root = composer.get_single_node()
            if not composer.has_empty:  # where nothing stands, they do not agree where that is
                return root
        except (YAMLError, ValueError, OverflowError) as error:  # told below
            if isinstance(error, _RefusedError):
                message, mark = _in_words(error)
                raise InputError(Problem(message, "", file, *place_of(mark))) from None
    try:
        parser = _Parser(text)
    except ReaderError as error:
        character = f"U+{ord(text[error.position]):04X}"
        message = f"the character {character} is not allowed; is this a text file?"
        raise InputError(Problem(message, "", file, *place_in(text, error.position))) from None
    try:
        return _Composer(parser).get_single_node()
    except MarkedYAMLError as error:
        message, mark = _in_words(error)
    except (ValueError, OverflowError):  # of PyYAML's own chr and int: "\UFFFFFFFF"
        message, mark = "this number is out of range", parser.get_mark()
    raise InputError(Problem(message, "", file, *place_of(mark)))


class _RefusedError(MarkedYAMLError):
    """A mistake that PyYAML would let pass; worded for the user."""


def _refuse(message: str, mark: Any) -> NoReturn:
    raise _RefusedError(problem=message, problem_mark=mark)


class _Parser(Reader, Scanner, Parser):
    def __init__(self, text: str) -> None:
        Reader.__init__(self, text)
        Scanner.__init__(self)
        Parser.__init__(self)


class _Composer(Composer):
    def __init__(self, parser: Any) -> None:
        super().__init__()
        self.check_event, self.peek_event, self.get_event = parser.check_event, parser.peek_event, parser.get_event
        self.has_empty = False  # a value of which nothing is written
        self.depth = self.values = 0  # values with those that aliases repeat: ten short lines can stand for billions
        self.most = YAML_VALUES.most
        self.sizes: dict[int, int] = {}  # values in a finished node, those of aliases counted each time

    # PyYAML's resolver, in three methods; the core schema does not depend on where a value stands

    def descend_resolver(self, parent: Node | None, index: Any) -> None:
        pass

    def ascend_resolver(self) -> None:
        pass

    def resolve(self, kind: type[Node], value: Any, implicit: tuple[bool, bool]) -> str:
        if kind is ScalarNode:
            return core_tag(value) if implicit[0] else STR
        return SEQ if kind is SequenceNode else MAP

    def compose_node(self, parent: Node | None, index: Any) -> Node | None:
        event = self.peek_event()
        if isinstance(event, AliasEvent):
            return self._aliased(self.get_event())
        if self.depth == DEEPEST:
            _refuse(f"this is nested more than {DEEPEST} deep", event.start_mark)
        if isinstance(event, ScalarEvent):
            self.has_empty |= not event.value and not event.style
            event.value = _whole(event)
            if event.tag == "!":
                event.implicit = (False, True)  # a lone "!" asks for text
        self.depth += 1
        node = cast(Node, super().compose_node(parent, index))
        self.depth -= 1
        self._count(1, event.start_mark)
        if isinstance(node, MappingNode) and len(node.value) > YAML_NAMES.most:
            _refuse(str(YAML_NAMES.refusal(len(node.value))), event.start_mark)
        self.sizes[id(node)] = 1 + sum(self.sizes[id(child)] for child in _children(node))
        return node

    def _aliased(self, event: AliasEvent) -> Node:
        name, mark = event.anchor, event.start_mark
        if name not in self.anchors:
            _refuse(f"no '&{name}' stands above this '*{name}'; put text that starts with '*' in quotes", mark)
        node = self.anchors[name]
        if id(node) not in self.sizes:
            _refuse(f"'*{name}' stands inside its own '&{name}'; data cannot hold itself", mark)
        self._count(self.sizes[id(node)], mark)
        return node

    def _count(self, more: int, mark: Any) -> None:
        self.values += more
        if self.values > self.most:
            _refuse(str(YAML_VALUES.refusal(self.values, remedy="keep long tables in files of their own")), mark)


def _whole(event: ScalarEvent) -> str:
    """Return a text in which characters that JSON writes as two halves are put together."""
    text: str = event.value
    if text.isascii() or not (half := _HALF.search(text)):
        return text
    try:
        return text.encode("utf-16", "surrogatepass").decode("utf-16")
    except UnicodeDecodeError:
        _refuse(f"U+{ord(half[0]):04X} is half a character, and stands alone", event.start_mark)


def _children(node: Node) -> Iterator[Node]:
    if isinstance(node, SequenceNode):
        yield from node.value
    elif isinstance(node, MappingNode):
        for pair in node.value:
            yield from pair


# PyYAML's message -> ours; {0} is the pattern's group, {line} where the construct began
_SYNTAX = (
    (r"found character '\\t'", "a tab stands here; use spaces"),
    (r"found character ('.+') that", "{0} cannot start a value; put the text in quotes"),
    (
        r"(?:mapping values|mapping keys) are",
        "':' cannot stand here; check the indentation, or put the text in quotes",
    ),
    (r"sequence entries are", "'- ' cannot stand here; start the list on a line of its own"),
    (r"found unknown escape character '(.+)'", "'\\{0}' means nothing in double quotes; use single quotes"),
    (r"expected escape sequence", "a character number in hexadecimal digits is expected here"),
    (
        r"expected <block end>",
        "this does not fit what began in line {line}; check the indentation and the quotes",
    ),
    (r"expected ',' or '(.)'", "',' or '{0}' is expected here; what was opened in line {line} is not closed"),
    (r"expected the node content", "a value is expected here"),
    (r"expected '<document start>'", "this does not belong to what stands above; check the indentation"),
    (r"but found another document", "a second document starts here; a file holds one"),
    (r"second occurrence", "this '&' name is taken in line {line} already"),
    (
        r"expected chomping|expected indentation|expected a comment",
        "put text that starts with '>' or '|' in quotes",
    ),
    (r"expected alphabetic", "put text that starts with '*', '&' or '%' in quotes"),
    (r"found undefined tag handle '(.*)'", "the tag '{0}' is not allowed; files hold plain data"),
)
# mistakes that are better placed at the beginning of the construct than where PyYAML notices them
_UNFINISHED = (
    (r"could not find expected ':'", "a ':' is missing after this; write 'name: value'"),
    (r"found unexpected (?:end of stream|document separator)", "this quote is not closed"),
)


def _in_words(error: MarkedYAMLError) -> tuple[str, Mark]:
    problem, mark, began = error.problem or "", error.problem_mark, error.context_mark
    if isinstance(error, _RefusedError):
        return problem, cast(Mark, mark)
    for pattern, words in _UNFINISHED:
        if began and re.match(pattern, problem):
            return words, began
    line = began.line + 1 if began else 1
    for pattern, words in _SYNTAX:
        if match := re.match(pattern, problem):
            return words.format(*match.groups(), line=line), cast(Mark, mark)
    return f"this is no valid YAML: {problem}", cast(Mark, mark)
