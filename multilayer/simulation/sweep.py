"""From a sweep to its cases: every combination of the values, each checked as if it stood in the file."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from itertools import product
from math import prod
from typing import Any, TypeVar

from pydantic import ValidationError
from pydantic_core import ErrorDetails, InitErrorDetails

from multilayer.bounds import CASES, SWEPT_VALUES
from multilayer.errors import InputError, show, suggest
from multilayer.models import mistake
from multilayer.paths import with_entry

T = TypeVar("T")
SWEPT = (
    "ambient", "layers", "contacts", "termination", "incidence", "finite_size", "excitation", "duct", "area",
    "beside", "links",
)  # fmt: skip


def expand(
    data: Mapping[str, Any], sweep: Mapping[str, Sequence[Any]], validated: Callable[[Any], T]
) -> list[tuple[dict[str, Any], T]]:
    """Return every combination of swept values, as written, and the validated data with these values.

    Parameters
    ----------
    data : mapping
        Of the file, without its sweep.
    sweep : mapping
        Values by path.
    validated : callable
        From data to the model; raises ValidationError for data with mistakes.

    Raises
    ------
    ValidationError
        For combinations that are not allowed, even if each value is.
    """
    cases = []
    for values in product(*sweep.values()):
        case = dict(zip(sweep, values, strict=True))
        try:
            cases.append((case, validated(_with_entries(data, case))))
        except (ValidationError, InputError) as error:
            texts = [str(error)] if isinstance(error, InputError) else [_message(problem) for problem in error.errors()]
            label = ", ".join(f"{path} = {show(value)}" for path, value in case.items())
            details = [mistake("input", ("sweep",), f"{label}: {text}", case) for text in texts]
            raise ValidationError.from_exception_data("sweep", details) from None
    return cases


def _with_entries(data: Mapping[str, Any], case: Mapping[str, Any]) -> Any:
    changed: Any = data
    for path, value in case.items():
        changed = with_entry(changed, path, value)
    return changed


def mistakes(
    data: Mapping[str, Any], sweep: Any, validated: Callable[[Any], Any], without_sweep: Sequence[ErrorDetails]
) -> Iterator[InitErrorDetails]:
    """Give what is wrong with each swept path and value, taken one by one.

    Parameters
    ----------
    data, validated
        As for `expand`.
    sweep : object
        As written; anything but a mapping of lists is left for the model to refuse.
    without_sweep : sequence
        Mistakes of the data without the sweep, which are not repeated.
    """
    if not isinstance(sweep, Mapping):
        return
    reported = {_key(problem) for problem in without_sweep}
    lists = {path: values for path, values in sweep.items() if isinstance(values, list | tuple)}
    cases = prod(len(values) for values in lists.values())
    for bound, count in ((CASES, cases), (SWEPT_VALUES, cases * _size(data))):
        if count > bound.most:
            yield mistake("input", ("sweep",), str(bound.refusal(count, remedy="sweep fewer values")), sweep)
            return
    for path, values in lists.items():
        if path.partition(".")[0] not in SWEPT:
            text = f"leads to nothing that can be swept; {suggest(path.partition('.')[0], SWEPT)}"
            yield mistake("input", ("sweep", path, "[key]"), text, path)
            continue
        seen = set[Any]()
        for i, value in enumerate(values):
            key = value if isinstance(value, int | float) else repr(value)  # mappings cannot be in a set
            if key in seen:
                yield mistake("input", ("sweep", path, i), "stands here a second time", value)
            seen.add(key)
            yield from _value_mistakes(data, path, i, value, validated, reported)


def _size(data: Any) -> int:
    """Return how many values there are in plain data."""
    if isinstance(data, Mapping):
        data = list(data.values())
    return sum(map(_size, data)) if isinstance(data, list | tuple) else 1


def _value_mistakes(
    data: Mapping[str, Any], path: str, i: int, value: Any, validated: Callable[[Any], Any], reported: set[Any]
) -> Iterator[InitErrorDetails]:
    for at_key, text in value_mistakes(data, path, value, validated, reported):
        yield mistake("input", ("sweep", path, "[key]" if at_key else i), text, path if at_key else value)


def value_mistakes(
    data: Mapping[str, Any],
    path: str,
    value: Any,
    validated: Callable[[Any], Any],
    reported: Collection[tuple[Any, ...]] = (),
) -> Iterator[tuple[bool, str]]:
    """Give what is wrong with one value at a path: whether it is the path that is wrong, and the message.

    Parameters
    ----------
    data : mapping
        What stands in the file.
    path : str
    value : object
        As written.
    validated : callable
        From data to the model; raises ValidationError for data with mistakes.
    reported : collection
        Places and messages of mistakes that are not repeated.
    """
    try:
        validated(with_entry(data, path, value))
    except InputError as error:
        yield True, str(error)
    except ValidationError as error:
        for problem in error.errors(include_url=False):
            if _key(problem) not in reported:
                unknown = problem["type"] == "extra_forbidden" and _ends_alike(problem, path)
                yield unknown, _message(problem, path)


def _key(problem: ErrorDetails) -> tuple[Any, ...]:
    return (problem["loc"], problem["msg"])


def _message(problem: ErrorDetails, path: str | None = None) -> str:
    """Return the message of a mistake, with its place where that is not the end of the swept path."""
    message = problem["msg"].removeprefix("Value error, ")
    if not problem["loc"] or (path and _ends_alike(problem, path)):
        return message
    return f"{'.'.join(map(str, problem['loc']))}: {message}"


def _ends_alike(problem: ErrorDetails, path: str) -> bool:
    return bool(problem["loc"]) and str(problem["loc"][-1]) == path.rpartition(".")[2]
