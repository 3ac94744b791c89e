"""From a sweep to its cases: every combination of the values, each checked as if it stood in the file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import product
from math import prod
from typing import Any, TypeVar

from pydantic import ValidationError
from pydantic_core import ErrorDetails, InitErrorDetails

from multilayer.bounds import CASES, SWEPT_VALUES
from multilayer.errors import InputError, show, suggest
from multilayer.models import mistake
from multilayer.paths import index_of, with_entry

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


def texts(values: Sequence[Any], unit: str | None) -> list[str]:
    """Return the values of a swept path as text, no two alike: in few digits and words where these tell them apart.

    Of numbers that look alike all digits are shown, of mappings what they do not all hold; what still does is numbered.

    Parameters
    ----------
    values : sequence
        As written.
    unit : str or None
        Of the field, which is put behind numbers.
    """
    shown = [_text(value, unit) for value in values]
    for text in [text for text, count in Counter(shown).items() if count > 1]:
        alike = [i for i, other in enumerate(shown) if other == text]
        for i, longer in zip(alike, _told_apart([values[i] for i in alike], unit), strict=True):
            shown[i] = longer
    seen = Counter[str]()
    for i, text in enumerate(shown):
        seen[text] += 1
        if seen[text] > 1:
            shown[i] = f"{text} ({seen[text]})"
    return shown


def _text(value: Any, unit: str | None) -> str:
    if isinstance(value, str):
        return value
    return f"{value:g} {unit}" if unit and isinstance(value, int | float) else show(value)


def _told_apart(values: Sequence[Any], unit: str | None) -> list[str]:
    if not all(isinstance(value, Mapping) for value in values):
        return [
            f"{value!r} {unit}" if unit and isinstance(value, int | float) else _text(value, unit) for value in values
        ]
    first, *others = values
    shared = {key for key in first if all(key in other and other[key] == first[key] for other in others)}
    return [show({key: part for key, part in value.items() if key not in shared}) for value in values]


def place(data: Any, path: str) -> tuple[str, ...]:
    """Return the tokens of a path with indices in place of names: the same for all paths that lead to one field.

    Parameters
    ----------
    data : object
        A model, or what stands in a file.
    path : str
        As ``layers.foam.thickness``.

    Raises
    ------
    InputError
        When a list has no such entry.
    """
    tokens = path.split(".")
    for at, token in enumerate(tokens):
        if isinstance(data, list | tuple):
            i = index_of(data, token, "")
            tokens[at], data = str(i), data[i]
        else:
            data = data.get(token) if isinstance(data, Mapping) else getattr(data, token, None)
    return tuple(tokens)


def set_twice(data: Any, paths: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Give each path that sets again what one before it sets, and a message that names both.

    Parameters
    ----------
    data : object
        A model, or what stands in a file.
    paths : iterable of str
        In their order. One that leads nowhere is left to those who read it.
    """
    places: dict[str, tuple[str, ...]] = {}
    for path in paths:
        try:
            here = place(data, path)
        except InputError:
            continue
        for before, there in places.items():
            if there == here:
                yield path, f"'{path}' and '{before}' lead to the same field; leave one of them out"
            elif there[: len(here)] == here:
                yield path, f"'{path}' replaces what '{before}' sets in it; write it before that, or leave one out"
        places[path] = here


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
    for path, text in set_twice(data, lists):
        yield mistake("input", ("sweep", path, "[key]"), text, path)
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
