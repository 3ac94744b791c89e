"""Validation of a document by a model: every mistake at its line and column."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar
from warnings import warn

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from multilayer.config.kinds import without_kind
from multilayer.config.yaml12 import DataPath, Document, read_yaml
from multilayer.errors import InputError, MultilayerError, PlausibilityWarning, Problem, show

M = TypeVar("M", bound=BaseModel)


def read(path: Path | str, model: type[M], kind: str = "", context: dict[str, Any] | None = None) -> M:
    """Read a YAML file into a model.

    Parameters
    ----------
    path : Path or str
        A UTF-8 file.
    model : type
        A pydantic model; a file format states its version by a field ``version: Literal[1]``.
    kind : str
        The only value of the file's ``kind`` that is allowed, if it has that field; see `multilayer.config.kinds`.
    context : dict, optional
        Handed to the validators of the model.

    Raises
    ------
    InputError
        When the file cannot be read, is refused, or does not fit the model.
    """
    return validate(read_yaml(path, keep_problems=True), model, kind, context=context)


@contextmanager
def placed_in(source: Path) -> Iterator[None]:
    """Give every mistake that is told meanwhile a place in a file, where it has none.

    Parameters
    ----------
    source : Path
        The YAML file that a command was given; its lines are looked up for mistakes that know their field. Of anything
        else mistakes get the name alone.

    Raises
    ------
    InputError
    """
    try:
        yield
    except MultilayerError as error:
        problems = error.problems if isinstance(error, InputError) else [Problem(str(error))]
        if all(_has_place(problem, source) for problem in problems):
            raise
        raise InputError([_found_in(source, problem) for problem in problems]) from error


def _has_place(problem: Problem, source: Path) -> bool:
    return problem.file is not None or problem.message.startswith(("--", f"{source}:"))


def _found_in(source: Path, problem: Problem) -> Problem:
    if _has_place(problem, source):
        return problem
    try:
        document = read_yaml(source, keep_problems=True)
    except InputError:  # a folder, or a file that has gone since
        return problem.at(source)
    path = _walked(document.data, tuple(int(p) if p.isdecimal() else p for p in problem.path.split(".")))
    return problem.at(source, *document.position(path)) if path else problem.at(source)


def validate(document: Document, model: type[M], kind: str = "", *, context: dict[str, Any] | None = None) -> M:
    """Return `document` as a model.

    Parameters
    ----------
    document : Document
        From `read_yaml` or `parse_yaml`.
    model : type
        A pydantic model.
    kind : str
        The only value of the document's ``kind`` that is allowed; when left out, `kind` is a field like any other.
    context : dict, optional
        Handed to the validators of the model.

    Raises
    ------
    InputError
        With every mistake the model finds, in the order of the file.

    Warns
    -----
    PlausibilityWarning
        Of every value that is hardly meant, where the model's method ``implausible`` gives path and text of such.
    """
    if not isinstance(document.data, dict):
        raise InputError([*document.problems, _not_a_mapping(document)])
    if kind:
        document = without_kind(document, kind)
    problems = list(document.problems)
    try:
        valid = model.model_validate(document.data, context=context)
    except ValidationError as error:
        reported = {(problem.line, problem.column) for problem in problems}
        placed = [_placed(document, details) for details in error.errors(include_url=False)]
        problems += [problem for problem in placed if (problem.line, problem.column) not in reported]
    else:
        if not problems:
            for path, text in getattr(valid, "implausible", tuple)():
                place = document.position(path)
                problem = Problem(text, ".".join(map(str, path)), document.file, *place)
                warn(str(problem), PlausibilityWarning, stacklevel=2)
            return valid
    problems.sort(key=lambda problem: (problem.line or 0, problem.column or 0))
    raise InputError(dict.fromkeys(problems))


def _not_a_mapping(document: Document) -> Problem:
    hint = "; is there a space after each ':'?" if isinstance(document.data, str) else ""
    message = f"must hold fields, 'name: value', not {show(document.data)}{hint}"
    return Problem(message, "", document.file, *document.position(()))


def _placed(document: Document, error: ErrorDetails) -> Problem:
    kind, tokens = error["type"], error["loc"]
    end = len(tokens) - (kind == "missing")  # the name of a missing field is not in the data, and is kept
    path = (*_walked(document.data, tokens[:end]), *tokens[end:])
    at_key = kind == "extra_forbidden" or tokens[-1:] == ("[key]",)
    place = document.key_position(path) if at_key else document.position(path)
    # validators of a whole model stand outside of the rewording in `Model`
    message = error["msg"].removeprefix("Value error, ")
    return Problem(message, ".".join(map(str, path)), document.file, *place)


def _walked(data: Any, tokens: DataPath) -> DataPath:
    """Return the tokens that lead through the data; pydantic puts names of validators and tags between them."""
    path: list[str | int] = []
    for token in tokens:
        inside = isinstance(data, dict) and token in data
        if inside or (isinstance(data, list) and isinstance(token, int) and token < len(data)):
            data = data[token]
            path.append(token)
    return tuple(path)
