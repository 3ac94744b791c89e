"""What a stack reflects, transmits and moves, with derivatives by fields of its layers, in one plane harmonic field.

The adjoint system (`matrix.adjoint`) gives the derivatives by the coefficients of every layer's medium: densities,
moduli, impedances, thickness. The derivatives of these few coefficients by a field are differences of fourth order of
the medium's formulae alone, over frequency and mostly not over angle; their steps follow from how far the field lies
from where formulae may end, and their error is some 1e-12 of the coefficient.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from pydantic import BaseModel

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.bounds import magnitudes
from multilayer.errors import InputError
from multilayer.layers.base import Layer
from multilayer.matrix.adjoint import solve_with_adjoint
from multilayer.matrix.solve import HalfSpace, Solution, System, Wall
from multilayer.matrix.wave import Wave
from multilayer.paths import Located, locate, positions, token_of, value_at, with_values
from multilayer.response.base_motion import velocity_of_top
from multilayer.response.system import build_system, refuse_infinite, solve_or_explain
from multilayer.stack import Stack
from multilayer.units import field_bounds, field_unit

_POINTS = np.array([1.0, -1.0, 2.0, -2.0])
_WEIGHTS = np.array([8.0, -8.0, -1.0, 1.0]) / 12
_STEP = 1e-3  # of the distance to where formulae may end
_LITTLE = 1e-2  # of what is usual: the reach of a field that is 0, of whose scale nothing is known
_WHOLE_STEP = 1e-4  # of differences of whole responses, which vary faster than formulae of a medium


@dataclass(frozen=True)
class Linearised:
    """The solution of a stack's system and derivatives of its outcomes.

    Attributes
    ----------
    system : System
    solution : Solution
    slopes : complex array, shape (n_fields, n_outcomes, ...)
        Derivatives by the fields, of the reflected and (with a half-space behind) the transmitted pressure; on a moving
        base, of the normal velocity of the last back face.
    by_differences : tuple of str
        Fields whose derivatives are differences of the whole solution.
    """

    system: System
    solution: Solution
    slopes: ComplexArray
    by_differences: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Variations:
    """Fields of a stack's layers, and each layer with these fields varied.

    Attributes
    ----------
    stack : Stack
        Its fields may hold arrays.
    fields : tuple of str
        Dotted paths of fields that hold real numbers (`real_fields`).
    on_base : bool
        Whether the stack stands on a shaken base.
    """

    stack: Stack
    fields: tuple[str, ...]
    on_base: bool = False
    _layers: dict[int, list[_Varied]] = field(default_factory=dict, init=False, repr=False)

    def layers(self, ndim: int) -> list[_Varied]:
        """Return every layer with its fields varied, along an axis in front of `ndim` others."""
        if ndim not in self._layers:  # pieces of a frequency axis share them
            self._layers[ndim] = [self._varied(i, ndim) for i in range(len(self.stack.layers))]
        return self._layers[ndim]

    def _varied(self, i: int, ndim: int) -> _Varied:
        layer, depends = self.stack.layers[i], type(self.stack.layers[i]).under is not Layer.under
        places = [place for place, found in enumerate(self._found) if found.layer == i or depends]
        steps, values = [], {}
        for row, found in enumerate(self._found[place] for place in places):
            points = np.zeros((len(places), len(_POINTS)))
            points[row] = _POINTS
            steps.append(_STEP * _reach(found.located))
            moved = _with_axis(found.located.value, ndim) + points.reshape(-1, *(1,) * ndim) * steps[-1]
            values[found.path if depends else found.inside] = moved
        if depends:
            return _Varied(places, steps, with_values(self.stack, values).at_rest(on_base=self.on_base)[i])
        return _Varied(places, steps, with_values(layer, values))

    @cached_property
    def _found(self) -> list[_Found]:
        """The fields."""
        found, layers = [], self.stack.layers
        known = positions(layers)
        for path in self.fields:
            _, token, inside = path.split(".", 2)
            layer = known[token]
            found.append(_Found(path, layer, inside, locate(layers[layer], inside)))
        return found


@dataclass(frozen=True, eq=False)
class _Found:
    """A field by its path, the index of its layer, the path inside the layer, and what it holds."""

    path: str
    layer: int
    inside: str
    located: Located


@dataclass(frozen=True, eq=False)
class _Varied:
    """A layer with some fields varied.

    Attributes
    ----------
    places : list of int
        Of the fields among all.
    steps : list of array
    layer : Layer
        Its fields hold arrays of four points for each field, one after the other along the first axis.
    """

    places: list[int]
    steps: list[RealArray]
    layer: Layer

    def slopes(self, wave: Wave, ndim: int) -> list[list[ComplexArray] | None]:
        """Return the derivatives by all places of every coefficient of the layer and of its faces' porosity.

        Of a coefficient that depends on none of the fields there is None.
        """
        faces = self.layer.faces(wave)
        assert faces.origin is not None  # as without the steps
        return [self._slope(coefficient, ndim) for coefficient in (*faces.origin.coefficients, faces.porosity)]

    def _slope(self, coefficient: Numeric, ndim: int) -> list[ComplexArray] | None:
        array = np.asarray(coefficient)
        if array.ndim <= ndim or len(array) != len(self.places) * len(_POINTS):
            return None
        points = array.reshape(len(self.places), len(_POINTS), *array.shape[1:])
        near, far = points[:, 0] - points[:, 1], points[:, 2] - points[:, 3]
        differences = near * _WEIGHTS[0] + far * _WEIGHTS[2]
        return [difference / step for difference, step in zip(differences, self.steps, strict=True)]


def linearised(variations: Variations, wave: Wave, head: HalfSpace | Wall) -> Linearised:
    """Return the solution of a stack in the field `wave`, excited by `head`, and its derivatives.

    Parameters
    ----------
    variations : Variations
        The stack, and the fields.
    wave : Wave
    head : HalfSpace or Wall

    Raises
    ------
    InputError, CouplingError
        As `build_system`, and of a stack without a finite response.
    """
    stack, fields = variations.stack, variations.fields
    system = build_system(stack, wave, head)
    try:
        outcomes = solve_with_adjoint(system)
    except np.linalg.LinAlgError:  # with a message
        solve_or_explain(system, stack, wave)
        raise
    refuse_infinite(outcomes.solution, stack, wave, system)
    values = outcomes_of(system, outcomes.solution)
    slopes = np.zeros((len(fields), *values.shape), dtype=complex)
    unknown = set()
    for i, (faces, varied) in enumerate(zip(system.layers, variations.layers(values.ndim - 1), strict=True)):
        if faces.origin is None:
            unknown.update(varied.places)
        elif varied.places:
            gradient = [*faces.origin.gradient(outcomes.fields[i]), outcomes.by_porosity[i]]
            _add_up(slopes, varied.places, gradient, varied.slopes(wave, values.ndim - 1))
    for place in unknown:
        slopes[place] = _by_differences(stack, wave, head, fields[place])
    differences = tuple(fields[place] for place in sorted(unknown))
    return Linearised(system, outcomes.solution, slopes, differences)


def outcomes_of(system: System, solution: Solution) -> ComplexArray:
    """Return the outcomes of a solved system, shape (n_outcomes, ...); see `Linearised`."""
    if isinstance(system.head, Wall):
        return velocity_of_top(system, solution)[None]
    waves = [wave for wave in (solution.reflected, solution.transmitted) if wave is not None]
    return np.array(np.broadcast_arrays(*waves))


def _add_up(
    slopes: ComplexArray,
    places: Sequence[int],
    gradient: Sequence[Numeric | None],
    changes: Sequence[Sequence[ComplexArray] | None],
) -> None:
    """Add to the derivatives by fields those by each coefficient times that of the coefficient by the fields."""
    for by_coefficient, change in zip(gradient, changes, strict=True):
        if by_coefficient is None or change is None:
            continue
        for place, slope in zip(places, change, strict=True):
            if np.any(slope):
                slopes[place] += by_coefficient * slope


def _with_axis(value: Numeric, ndim: int) -> RealArray:
    """Return a field's value with an axis in front of `ndim` others."""
    array = np.asarray(value, dtype=float)
    return array.reshape((1,) * (ndim + 1 - array.ndim) + array.shape)


def _reach(found: Located) -> RealArray:
    """Return how far a field's value may move before its formulae may end: at 0, or at a bound that it never meets."""
    value = np.asarray(found.value, dtype=float)
    usual = magnitudes(found.unit or "").usual
    beyond_zero, ends = _ends(type(found.owner), found.field)
    reach = np.where(value == 0, _LITTLE * usual, usual if beyond_zero else np.abs(value))
    for end in ends:
        room = np.abs(value - end)
        reach = np.where(room > 0, np.minimum(reach, room), reach)
    return reach


@lru_cache
def _ends(owner: type[BaseModel], field: str) -> tuple[bool, list[float]]:
    """Return whether a field may pass 0, as Poisson's ratio does, and the bounds that it never meets."""
    bounds = dict(field_bounds(owner.model_fields[field]))
    return any(bounds.get(side) for side in ("gt", "ge")), [bounds[side] for side in ("gt", "lt") if side in bounds]


def _by_differences(stack: Stack, wave: Wave, head: HalfSpace | Wall, path: str) -> ComplexArray:
    """Return derivatives of the outcomes by one field from four solutions of the whole stack."""
    found, total = locate(stack, path), 0.0
    step = _WHOLE_STEP * _reach(found)[()]
    for point, weight in zip(_POINTS, _WEIGHTS, strict=True):
        near = stack.replaced({path: found.value + point * step})
        system = build_system(near, wave, head)
        total = total + weight * outcomes_of(system, solve_or_explain(system, near, wave))
    return np.asarray(total / step)


def real_fields(stack: Stack, fields: Sequence[str] | None) -> tuple[str, ...]:
    """Return dotted paths of layers' fields that hold real numbers: those asked for, or all.

    Raises
    ------
    InputError
        For a text in place of a list, and for a path that leads nowhere, not into a layer, or to what is no real
        number.
    """
    if isinstance(fields, str):
        raise InputError(f"'{fields}' is a text; give a list of paths, as ['layers.NAME.thickness']")
    if fields is None:
        return tuple(_every(stack.layers, ("layers",)))
    for path in fields:
        if path.split(".")[0] != "layers":
            raise InputError(f"'{path}' is no field of a layer; derivatives are by fields as layers.NAME.thickness")
        try:
            value = value_at(stack, path)
        except InputError as error:
            raise InputError(f"'{path}' {error}") from None
        if not _is_real(value):
            raise InputError(f"'{path}' holds {value!r}, by which there is no derivative; it must be a real number")
    return tuple(dict.fromkeys(fields))


def _is_real(value: Any) -> bool:
    array = np.asarray(value) if isinstance(value, int | float | np.ndarray) else None
    return array is not None and array.dtype.kind in "fiu"


def _every(item: Any, path: tuple[str, ...]) -> Iterator[str]:
    """Give the paths of all quantities inside that are real numbers; layers go by their names."""
    if isinstance(item, tuple):
        for i, inner in enumerate(item):
            yield from _every(inner, (*path, token_of(item, i)))
    elif isinstance(item, BaseModel):
        for name, info in type(item).model_fields.items():
            value = getattr(item, name)
            if isinstance(value, tuple | BaseModel):
                yield from _every(value, (*path, name))
            elif field_unit(info) is not None and _is_real(value):
                yield ".".join((*path, name))
