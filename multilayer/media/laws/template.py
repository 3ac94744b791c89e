"""Laws to start a fit from: of the right type and number of elements, with arbitrary values."""

from __future__ import annotations

from typing import Any, get_args

from multilayer.arrays import RealArray
from multilayer.errors import InputError
from multilayer.media.laws import LAWS, ModulusLaw, Table


def law_template(law: str | type[ModulusLaw] | ModulusLaw, elements: int | None, f: RealArray) -> ModulusLaw:
    """Return a law to start a fit from.

    Parameters
    ----------
    law : str, type or ModulusLaw
        A name in `LAWS`, a class, or a law, which is returned as it is.
    elements : int or None
        Number of elements; None for laws without lists.
    f : array
        Frequencies of the data, Hz, over which the elements are spread.

    Raises
    ------
    InputError
        For a table, a law that wraps another, and for a law with lists of elements but no number of them.
    """
    kind = LAWS[law] if isinstance(law, str) else law if isinstance(law, type) else type(law)
    if issubclass(kind, Table):
        raise InputError("a table is data, not a law with parameters; fit another law")
    if kind.wraps:
        raise InputError(f"{kind.__name__} changes another law and has no parameters to find; fit that law")
    if isinstance(law, ModulusLaw):
        return law
    if elements is not None:
        return kind.spread(elements, float(f.min()), float(f.max()))
    names = [name for name in kind.model_fields if name != "law"]
    if any(get_args(kind.model_fields[name].annotation) for name in names):
        text = f"{kind.__name__} has lists of entries; say how many `elements` (add --elements N)"
        raise InputError(f"{text}, or give a law to start from")
    ones: dict[str, Any] = dict.fromkeys(names, 1.0)
    return kind.model_construct(**ones)
