"""What a model of an input holds, however deep, and where."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from multilayer.models import Model

Path = tuple[str | int, ...]


def leaves(value: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Give what is neither a model nor a tuple inside of models and tuples, each with its path.

    Parameters
    ----------
    value : Model, tuple or anything
    path : tuple
        Of the value itself.
    """
    if isinstance(value, Model):
        for name in type(value).model_fields:
            yield from leaves(getattr(value, name), (*path, name))
    elif isinstance(value, tuple):
        for index, entry in enumerate(value):
            yield from leaves(entry, (*path, index))
    else:
        yield path, value
