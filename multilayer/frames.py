"""Results as arrays over named axes, and as tables and data sets of pandas and xarray where these are installed."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib import import_module
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from multilayer.errors import InputError, suggest
from multilayer.number_text import over_unit

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes

Array: TypeAlias = NDArray[Any]
Column: TypeAlias = tuple[tuple[str, ...], Array]  # the axes, and values over them
_MOST_ROWS = 12  # shown in a notebook
_UNITS_IN_NAMES = ("hz", "pa", "s", "db")


@dataclass(frozen=True)
class Frame:
    """Columns over named axes.

    Attributes
    ----------
    coordinates : mapping
        Coordinates of the axes, by name; a coordinate may lie along an axis of another name.
    values : mapping
        Values by name; their axes are those of the coordinates.
    units : mapping
        SI units by name, where there is one.
    facts : mapping
        Single values that hold for the whole result.
    """

    coordinates: Mapping[str, Column]
    values: Mapping[str, Column]
    units: Mapping[str, str] = field(default_factory=dict)
    facts: Mapping[str, Any] = field(default_factory=dict)

    @property
    def sizes(self) -> dict[str, int]:
        """Length of every axis."""
        columns = [*self.values.values(), *self.coordinates.values()]
        return {axis: size for axes, array in columns for axis, size in zip(axes, array.shape, strict=True)}

    def flat(self) -> dict[str, Array]:
        """Return all columns at their full length, the last axis varying fastest."""
        sizes = self.sizes
        columns = {**self.coordinates, **self.values}
        return {name: _spread(column, sizes).ravel() for name, column in columns.items()}


def _spread(column: Column, sizes: Mapping[str, int]) -> Array:
    axes, array = column
    kept = [axis for axis in sizes if axis in axes]
    ordered = array.transpose([axes.index(axis) for axis in kept])
    shape = [sizes[axis] if axis in axes else 1 for axis in sizes]
    return np.broadcast_to(ordered.reshape(shape), tuple(sizes.values()))


def over(
    coordinates: Mapping[str, Array],
    values: Mapping[str, Array | None],
    units: Mapping[str, str] | None = None,
    facts: Mapping[str, Any] | None = None,
) -> Frame:
    """Return the frame of values whose last axes are those of the coordinates, one after the other.

    Further axes in front are samples; values that are None are left out.

    Parameters
    ----------
    coordinates : mapping
        Arrays by name, of any shape.
    values, units, facts : mapping
        As in `Frame`.
    """
    axes = {name: _axes(name, np.ndim(array)) for name, array in coordinates.items()}
    inner = tuple(axis for names in axes.values() for axis in names)
    columns = {}
    for name, array in values.items():
        if array is not None:
            samples = _axes("sample", np.ndim(array) - len(inner))
            columns[name] = ((*samples, *inner), np.asarray(array))
    along = {name: (axes[name], np.asarray(array)) for name, array in coordinates.items()}
    return Frame(along, columns, units or {}, facts or {})


def _axes(name: str, n: int) -> tuple[str, ...]:
    return (name,) if n == 1 else tuple(f"{name}_{i}" for i in range(n))


class Tabular:
    """A result with a text and an HTML representation, and conversions to pandas and xarray.

    Dataclasses that inherit it need ``repr=False``, or their generated representation takes its place.
    """

    @property
    @abstractmethod
    def frame(self) -> Frame:
        """The result as arrays over named axes."""

    def to_pandas(self) -> pd.DataFrame:
        """Return the result as a table: one row for each point, coordinates and values in columns.

        Raises
        ------
        InputError
            When pandas is not installed.
        """
        return _package("pandas").DataFrame(self.frame.flat())

    def to_xarray(self) -> xr.Dataset:
        """Return the result as a data set with named axes; units stand in the attributes of its variables.

        Raises
        ------
        InputError
            When xarray is not installed.
        """
        frame = self.frame
        values, coordinates = (
            {name: (*column, _unit(frame, name)) for name, column in part.items()}
            for part in (frame.values, frame.coordinates)
        )
        return _package("xarray").Dataset(values, coordinates, dict(frame.facts))

    def plot(self, name: str = "", axes: Axes | None = None, **style: Any) -> Axes:
        """Draw a quantity over frequency, a line for every case, configuration or angle; with its deviations, if any.

        Parameters
        ----------
        name : str
            Of the quantity, as `to_pandas` names its column; the first when left out. Of complex ones the amount.
        axes : matplotlib.axes.Axes, optional
            Where to draw; new ones when left out.
        **style
            Of the lines, as matplotlib's `plot` takes them.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            When there is no such quantity.
        """
        frame = self.frame
        drawable = [key for key, (_, array) in frame.values.items() if array.dtype.kind in "fic"]
        chosen = name or drawable[0]
        if chosen not in drawable:
            raise InputError(f"there is no quantity '{chosen}'; {suggest(chosen, drawable)}")
        if axes is None:
            from matplotlib import pyplot

            _, axes = pyplot.subplots()
        return _drawn(frame, chosen, axes, style)

    def __repr__(self) -> str:
        frame = self.frame
        facts = [f"{name} {_cell(value)}" for name, value in frame.facts.items()]
        head = ", ".join([*(_coordinate_text(frame, name) for name in frame.coordinates), *facts])
        width = max((len(name) for name in frame.values), default=0)
        lines = [f"  {name:{width}}  {_range(frame, name)}".rstrip() for name in frame.values]
        return "\n".join([f"{type(self).__name__}: {head}", *lines])

    def _repr_html_(self) -> str:
        frame = self.frame
        flat = frame.flat()
        n = len(next(iter(flat.values())))
        rows: list[int | None] = list(range(n))
        if n > _MOST_ROWS:
            rows = [*range(_MOST_ROWS // 2), None, *range(n - _MOST_ROWS // 2, n)]
        headings = [over_unit(name, frame.units.get(name, "")) for name in flat]
        cells = [["…" if i is None else _cell(array[i]) for array in flat.values()] for i in rows]
        return html_table(
            headings, cells, f"{type(self).__name__}, {n} rows" if n > _MOST_ROWS else type(self).__name__
        )


def html_table(headings: Sequence[str], rows: Sequence[Sequence[str]], caption: str = "") -> str:
    """Return a table of texts as HTML, for notebooks."""
    head = "".join(f"<th>{escape(text)}</th>" for text in headings)
    body = "".join("<tr>" + "".join(f"<td>{escape(text)}</td>" for text in row) + "</tr>" for row in rows)
    title = f"<caption>{escape(caption)}</caption>" if caption else ""
    return f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _drawn(frame: Frame, name: str, axes: Axes, style: Mapping[str, Any]) -> Axes:
    """Draw a quantity over frequency on axes."""
    flat = frame.flat()
    along = next(key for key in frame.coordinates if key.startswith("frequency"))
    others = [key for key in frame.coordinates if key != along]
    values = np.abs(flat[name]) if np.iscomplexobj(flat[name]) else flat[name]
    spread = flat.get(_deviation(name))
    labels = [", ".join(_cell(flat[key][i]) for key in others) for i in range(len(values))]
    for label in dict.fromkeys(labels):
        rows = np.array([i for i, text in enumerate(labels) if text == label])
        rows = rows[np.argsort(flat[along][rows], kind="stable")]
        bars = None if spread is None else spread[rows]
        shown = {"label": label, **style} if label else dict(style)
        axes.errorbar(flat[along][rows], values[rows], bars, **shown)
    axes.set(xlabel="frequency / Hz", ylabel=over_unit(name, frame.units.get(name, "")))
    if any(labels):
        axes.legend()
    return axes


def _deviation(name: str) -> str:
    """Return the name of the column that holds a quantity's standard deviation: its unit, if named, stays last."""
    stem, _, unit = name.rpartition("_")
    return f"{stem}_std_{unit}" if stem and unit in _UNITS_IN_NAMES else f"{name}_std"


def _package(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise InputError(f"to_{name} needs {name}: pip install 'multilayer[frames]'") from None


def _unit(frame: Frame, name: str) -> dict[str, str]:
    return {"units": frame.units[name]} if frame.units.get(name) else {}


def _coordinate_text(frame: Frame, name: str) -> str:
    """Return a coordinate as text: the number of its values, the lowest and the highest."""
    array, unit = frame.coordinates[name][1], frame.units.get(name, "")
    if array.size > 1 and array.dtype.kind in "fi":
        return f"{array.size} of {name} ({f'{array.min():g} to {array.max():g} {unit}'.rstrip()})"
    if array.size == 1:
        return f"{name} {_cell(array.flat[0])} {unit}".rstrip()
    return f"{array.size} of {name}"


def _range(frame: Frame, name: str) -> str:
    """Return the lowest and highest value of a column as text; for complex values, those of the modulus."""
    array, unit = frame.values[name][1], frame.units.get(name, "")
    if array.dtype.kind == "b":
        return f"{int(array.sum())} of {array.size}"
    if array.dtype.kind not in "fic" or not array.size:
        return ""
    amounts = np.abs(array) if array.dtype.kind == "c" else array
    low, high = (f"{end:.4g}" for end in (np.nanmin(amounts), np.nanmax(amounts)))
    what = "complex, of size " if array.dtype.kind == "c" else ""
    return f"{what}{low if low == high else f'{low} to {high}'} {unit}".rstrip()


def _cell(value: Any) -> str:
    if isinstance(value, complex | np.complexfloating):
        return f"{value.real:.4g}{value.imag:+.4g}j"
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    return f"{value:.5g}" if isinstance(value, float | np.floating) else str(value)
