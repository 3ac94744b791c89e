"""From a sweep to its cases: every combination of the values, each checked as if it stood in the file."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from math import prod
from typing import Any, TypeVar

from pydantic import ValidationError
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from multilayer.errors import InputError, show, suggest
from multilayer.paths import with_entry

T = TypeVar("T")
SWEPT = ("ambient", "layers", "contacts", "termination", "incidence", "finite_size")
MOST_CASES = 10_000


def mistake(path: tuple[str | int, ...], text: str, written: Any) -> InitErrorDetails:
    """Return what a ValidationError tells: what is wrong with what was written where."""
    return InitErrorDetails(type=PydanticCustomError("input", "{reason}", {"reason": text}), loc=path, input=written)


def again(problem: ErrorDetails) -> InitErrorDetails:
    """Return a mistake that was told once, to tell it with others."""
    kind: Any = problem["type"]
    message = PydanticCustomError(kind, "{reason}", {"reason": problem["msg"]})
    return InitErrorDetails(type=message, loc=problem["loc"], input=problem["input"])


def expand(
    data: Mapping[str, Any], sweep: Mapping[str, Sequence[Any]], validated: Callable[[Any], T]
) -> list[tuple[dict[str, Any], T]]:
    """Return every combination of swept values, as written, and what `validated` makes of the data with them.

    Parameters
    ----------
    data : mapping
        What the file says, without its sweep.
    sweep : mapping
        Values by path.
    validated : callable
        Raises ValidationError for data with mistakes.

    Raises
    ------
    ValidationError
        For combinations of values that are allowed one by one.
    """
    found = []
    for values in product(*sweep.values()):
        case = dict(zip(sweep, values, strict=True))
        try:
            found.append((case, validated(_with_entries(data, case))))
        except (ValidationError, InputError) as error:
            told = [str(error)] if isinstance(error, InputError) else [_told(problem) for problem in error.errors()]
            label = ", ".join(f"{path} = {show(value)}" for path, value in case.items())
            details = [mistake(("sweep",), f"{label}: {text}", case) for text in told]
            raise ValidationError.from_exception_data("sweep", details) from None
    return found


def _with_entries(data: Mapping[str, Any], case: Mapping[str, Any]) -> Any:
    changed: Any = data
    for path, value in case.items():
        changed = with_entry(changed, path, value)
    return changed


def mistakes(
    data: Mapping[str, Any], sweep: Any, validated: Callable[[Any], Any], known: Sequence[ErrorDetails]
) -> Iterator[InitErrorDetails]:
    """Give what is wrong with each swept path and value, taken one by one.

    Parameters
    ----------
    data, validated
        As for `expand`.
    sweep : object
        As written; what is no mapping of lists is for the model to refuse.
    known : sequence
        Mistakes of the data without the sweep, which are not repeated.
    """
    if not isinstance(sweep, Mapping):
        return
    told = {_key(problem) for problem in known}
    lists = {path: values for path, values in sweep.items() if isinstance(values, list | tuple)}
    for path, values in lists.items():
        if path.partition(".")[0] not in SWEPT:
            text = f"leads to nothing that can be swept; {suggest(path.partition('.')[0], SWEPT)}"
            yield mistake(("sweep", path, "[key]"), text, path)
            continue
        for i, value in enumerate(values):
            if value in values[:i]:
                yield mistake(("sweep", path, i), "stands here a second time", value)
            yield from _of_one(data, path, i, value, validated, told)
    if prod(len(values) for values in lists.values()) > MOST_CASES:
        yield mistake(("sweep",), f"makes more than {MOST_CASES} cases; sweep fewer values", sweep)


def _of_one(
    data: Mapping[str, Any], path: str, i: int, value: Any, validated: Callable[[Any], Any], told: set[Any]
) -> Iterator[InitErrorDetails]:
    try:
        validated(with_entry(data, path, value))
    except InputError as error:
        yield mistake(("sweep", path, "[key]"), str(error), path)
    except ValidationError as error:
        for problem in error.errors(include_url=False):
            if _key(problem) in told:
                continue
            unknown = problem["type"] == "extra_forbidden" and _ends_alike(problem, path)
            yield mistake(("sweep", path, "[key]" if unknown else i), _told(problem, path), value)


def _key(problem: ErrorDetails) -> tuple[Any, ...]:
    return (problem["loc"], problem["msg"])


def _told(problem: ErrorDetails, path: str | None = None) -> str:
    """Return a mistake's words, with its place where that is not the end of the swept path."""
    message = problem["msg"].removeprefix("Value error, ")
    if not problem["loc"] or (path and _ends_alike(problem, path)):
        return message
    return f"{'.'.join(map(str, problem['loc']))}: {message}"


def _ends_alike(problem: ErrorDetails, path: str) -> bool:
    return bool(problem["loc"]) and str(problem["loc"][-1]) == path.rpartition(".")[2]
