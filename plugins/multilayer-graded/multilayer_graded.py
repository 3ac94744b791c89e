"""The layer type `graded`: properties that vary through the thickness, between those of two layers of one type."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BeforeValidator, PlainSerializer, TypeAdapter, model_validator
from pydantic_core import PydanticCustomError

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.layers import LAYERS, Layer, LayerField
from multilayer.matrix.equations import FieldEquations
from multilayer.matrix.faces import Faces, from_propagator
from multilayer.matrix.families import Family
from multilayer.matrix.scattering import Reference, Scattering, joined
from multilayer.matrix.small import aligned, multiply
from multilayer.matrix.wave import Wave
from multilayer.models import Model, refuse
from multilayer.registry import RegistryError
from multilayer.units import Length

Profile = Literal["linear", "exponential"]

_NODES = 8  # Gauss's, in every panel
_PASSES = 11  # of Picard's iteration: what is left is below 1.5^22/22! = 7e-18
_TURN = 1.5  # |k| h of a panel
_CHANGE = np.log(1.5)  # of the logarithm of a property within a panel
_THIN = 1.0  # |k| h of a layer that is left to its propagator
_AT_ONCE = 20_000  # nodes times frequencies and angles, to bound the memory


def _face(value: Any) -> Any:
    """Let a homogeneous layer's fields stand without a thickness, which is the graded layer's."""
    if not isinstance(value, Mapping) or not _is_known(value.get("type")):
        return value  # others say what is wrong with it
    if LAYERS[value["type"]].field_equations is Layer.field_equations:
        raise _refused(f"a layer of type {value['type']} cannot be graded: it says no field equations")
    if "thickness" in value:
        raise _refused("has a thickness of its own; leave it out, the graded layer has it")
    return {**value, "thickness": 1.0}


def _is_known(kind: Any) -> bool:
    try:
        return kind in LAYERS and LAYERS[kind] is not None
    except RegistryError:
        return False


def _refused(reason: str) -> PydanticCustomError:
    return PydanticCustomError("layer", "{reason}", {"reason": reason})


def _without_thickness(layer: Layer) -> dict[str, Any]:
    found: dict[str, Any] = TypeAdapter(LayerField).dump_python(layer, mode="json")
    return {key: value for key, value in found.items() if key != "thickness"}


Face = Annotated[LayerField, BeforeValidator(_face), PlainSerializer(_without_thickness)]


class Graded(Layer):
    """A layer whose properties vary smoothly through its thickness: a fluid, a solid, a porous material.

    Fields: `thickness` (m); `front` and `back`, layers of one type without their thickness, the material at the two
    faces; `profile`: every number between the two is `linear` in the depth, or `exponential` (a straight line in the
    logarithm). Types that can be graded say their field equations: `fluid`, `equivalent_fluid`, `elastic_solid`,
    `poroelastic`, and plugins' such as `anisotropic_solid`. The parameters of a modulus law vary like other fields.

    The field equations are integrated over panels by Gauss's quadrature of order 16, no panel thicker than a quarter of
    the shortest wavelength, no property changing by more than a factor of 1.5 within one: relative error below 1e-10.
    Poroelastic materials have one porosity throughout.
    """

    type: Literal["graded"] = "graded"
    thickness: Length
    front: Face
    back: Face
    profile: Profile = "linear"

    summary: ClassVar[str] = "properties that vary through the thickness, between two layers of one type"
    examples: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {
            "thickness": 0.05,
            "front": {"type": "fluid", "density": 1.2, "sound_speed": 340.0},
            "back": {"type": "fluid", "density": 6.0, "sound_speed": 250.0},
            "profile": "exponential",
        },
    )
    composes: ClassVar[bool] = False

    @model_validator(mode="after")
    def _one_material(self) -> Self:
        refuse(self, self._mistakes())
        return self

    def _mistakes(self) -> Iterator[tuple[tuple[str | int, ...], str, Any]]:
        if type(self.front) is not type(self.back):
            yield ("back", "type"), f"is {self.back.type}, the front is {self.front.type}; both must be alike", None
            return
        for place, reason in _differences(self.front, self.back, self.profile):
            yield ("back", *place), reason, None

    def at(self, depth: Numeric) -> Layer:
        """Return the homogeneous material at a depth, as a share of the thickness, from 0 to 1."""
        return _between(self.front, self.back, depth, self.profile)  # type: ignore[no-any-return]

    @property
    def isotropic_in_plane(self) -> bool:  # type: ignore[override]
        """Whether both materials are."""
        return self.front.isotropic_in_plane and self.back.isotropic_in_plane

    def sliced(self, n: int) -> tuple[Layer, ...]:
        """Return slices, each between its own two faces."""
        faces = [self.at(depth) for depth in np.linspace(0, 1, n + 1)]
        thinner = {"thickness": self.thickness / n}
        return tuple(self.model_copy(update={**thinner, "front": a, "back": b}) for a, b in pairwise(faces))

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices."""
        middle = self._equations(wave, np.asarray(0.5))
        reference = middle.reference(wave.kx)
        ends = self._panels(wave, reference)
        thin = self._turn(wave, reference, np.array([0.0, 0.5, 1.0])) < _THIN
        whole: Scattering | None = None
        product: ComplexArray | None = None
        for propagators in self._propagators(wave, ends):
            piece = _all_joined(Scattering.of(reference, propagators))
            whole = piece if whole is None else joined(whole, piece)
            if np.any(thin):
                product = _all_multiplied(propagators, product)
        assert whole is not None
        a, b = whole.faces(reference)
        if product is not None:
            thinner = from_propagator(middle.family, product, wave.ambient.impedance)
            a, b = (np.where(thin, one, other) for one, other in zip(thinner, (a, b), strict=True))
        return Faces(middle.family, a, b, middle.porosity)

    def _equations(self, wave: Wave, depth: RealArray) -> FieldEquations:
        found = self.at(depth).field_equations(wave)
        assert found is not None  # validated
        return found

    def _turn(self, wave: Wave, reference: Reference, depths: RealArray) -> RealArray:
        """Return the largest |k| h at some depths, by frequency, angle and sample."""
        bounds = [reference.wavenumber(*self._equations(wave, depth).matrices) for depth in depths]
        return np.asarray(np.max(np.broadcast_arrays(*bounds), axis=0) * self.thickness)

    def _panels(self, wave: Wave, reference: Reference) -> RealArray:
        """Return where panels begin and end, as shares of the thickness."""
        cuts = _cuts(self.front, self.back, self.profile)
        ends: list[float] = [0.0]
        for start, end in pairwise(cuts):
            turn = float(np.max(self._turn(wave, reference, np.array([start, (start + end) / 2, end])))) * (end - start)
            ends += list(np.linspace(start, end, max(int(np.ceil(turn / _TURN)), 1) + 1)[1:])
        return np.array(ends)

    def _propagators(self, wave: Wave, ends: RealArray) -> Iterator[ComplexArray]:
        """Give V(end) = P V(start) of all panels, shape (n_state, n_state, n_panels, ...), as many at once as fit."""
        axes = max(np.ndim(wave.kx), np.ndim(wave.frequency), *_axes(self.front, self.back), np.ndim(self.thickness))
        nodes, _, _ = _gauss()
        at_once = max(_AT_ONCE // (_NODES * np.broadcast(wave.kx, wave.frequency).size), 1)
        for first in range(0, len(ends) - 1, at_once):
            starts = ends[first : first + at_once + 1]
            width = np.diff(starts).reshape(-1, 1, *(1,) * axes)
            depth = starts[:-1].reshape(width.shape) + width * nodes.reshape(-1, *(1,) * axes)
            equations = self._equations(wave, depth)
            scaled = [m * (self.thickness * width) for m in aligned(*equations.matrices, ndim=width.ndim + 2)]
            shape = np.broadcast_shapes(depth.shape, *(m.shape[2:] for m in scaled))
            x, y = (np.broadcast_to(m, (*m.shape[:2], *shape)) for m in scaled)
            yield _picard(equations.family, x, y)


def _picard(family: Family, x: ComplexArray, y: ComplexArray) -> ComplexArray:
    """Return P of V(end) = P V(start) by Picard's iteration at Gauss's nodes.

    A sum of products without subtractions of the large: it keeps the small bending terms of stiff thin layers.

    Parameters
    ----------
    family : Family
    x, y : complex array, shape (n_state/2, n_state/2, n_panels, n_nodes, ...)
        The field equations times the panel's thickness.
    """
    _, weights, integrals = _gauss()
    panels, nodes, *rest = x.shape[2:]
    x, y = (np.ascontiguousarray(m).reshape(*m.shape[:2], panels, nodes, -1) for m in (x, y))
    even, odd = list(family.even), list(family.odd)
    unit = np.eye(family.size, dtype=complex)[:, :, None, None, None]
    e: ComplexArray = np.broadcast_to(unit[even], (family.half, family.size, *x.shape[2:]))
    o = e
    for _ in range(_PASSES):
        o = unit[odd] + integrals @ multiply(y, e)
        e = unit[even] + integrals @ multiply(x, o)
    whole = np.empty((family.size, family.size, panels, x.shape[-1]), dtype=complex)
    whole[even] = unit[even, :, 0] + weights @ multiply(x, o)
    whole[odd] = unit[odd, :, 0] + weights @ multiply(y, e)
    return whole.reshape(family.size, family.size, panels, *rest)


def _all_joined(slices: Scattering) -> Scattering:
    """Return one slice of many, along their first axis, by pairs."""
    while (n := len(slices.r)) > 1:
        pairs = joined(slices[: n - n % 2 : 2], slices[1::2])
        slices = pairs if n % 2 == 0 else pairs.followed_by(slices[n - 1 :])
    return slices[0]


def _all_multiplied(propagators: ComplexArray, product: ComplexArray | None) -> ComplexArray:
    """Return the product of all, each times those in front of it."""
    with np.errstate(over="ignore", invalid="ignore"):  # where it is thick, nobody uses it
        for n in range(propagators.shape[2]):
            one = propagators[:, :, n]
            product = one if product is None else multiply(one, product)
    assert product is not None
    return product


@cache
def _gauss() -> tuple[RealArray, ComplexArray, ComplexArray]:
    """Return Gauss's nodes and weights on [0, 1], and the integrals from 0 to each node of what has values at nodes."""
    points, weights = np.polynomial.legendre.leggauss(_NODES)
    powers = np.polynomial.legendre.legvander(points, _NODES - 1)
    # of each Legendre polynomial, from -1 to the node
    sums = [np.polynomial.legendre.Legendre.basis(n).integ(lbnd=-1)(points) for n in range(_NODES)]
    integrals = np.transpose(sums) @ np.linalg.inv(powers)
    return np.asarray((points + 1) / 2), np.asarray(weights / 2 + 0j), np.asarray(integrals / 2 + 0j)


def _fields(front: Model, back: Model) -> Iterator[tuple[str, Any, Any]]:
    """Give name and both values of the fields that differ."""
    for name, first in front:
        second = getattr(back, name)
        if name not in ("name", "thickness") and not _same(first, second):
            yield name, first, second


def _same(first: Any, second: Any) -> bool:
    if isinstance(first, np.ndarray) or isinstance(second, np.ndarray):
        return first is second
    return bool(first == second)


def _between(front: Any, back: Any, depth: Numeric, profile: str) -> Any:
    """Return the same kind of model with every number between those of two."""
    found = {}
    for name, first, second in _fields(front, back):
        if isinstance(first, Model):
            found[name] = _between(first, second, depth, profile)
        elif profile == "linear":
            found[name] = first + (second - first) * depth
        else:
            found[name] = first * (second / first) ** depth
    return front.model_copy(update=found)


def _differences(front: Any, back: Any, profile: str) -> Iterator[tuple[tuple[str, ...], str]]:
    """Give path and reason of everything between which nothing lies."""
    for name, first, second in _fields(front, back):
        if name == "porosity" and "young_modulus" in dict(front):
            yield (name,), "differs from the front's: Biot's equations as they are used here hold for one porosity"
        elif isinstance(first, Model) and type(first) is type(second):
            yield from (((name, *place), reason) for place, reason in _differences(first, second, profile))
        elif not (_is_number(first) and _is_number(second)):
            yield (name,), f"differs from the front's ({second!r}, {first!r}); only numbers may vary through the layer"
        elif profile == "exponential" and not np.all(np.real(np.asarray(first) * np.conj(second)) > 0):
            yield (name,), f"no exponential leads from {first!r} to {second!r}; take another value, or profile linear"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | complex | np.ndarray) and not isinstance(value, bool)


def _logs(front: Any, back: Any) -> Iterator[float]:
    """Give the largest logarithm of the ratio of back to front for every number that keeps its sign."""
    for _, first, second in _fields(front, back):
        if isinstance(first, Model):
            yield from _logs(first, second)
        elif np.all(np.real(np.asarray(first) * np.conj(second)) > 0):
            ratios = np.ravel(np.log(np.abs(np.asarray(second) / first)))
            yield float(ratios[np.argmax(np.abs(ratios))])


def _axes(front: Any, back: Any) -> Iterator[int]:
    """Give the number of axes of all numbers."""
    for name, first in front:
        if isinstance(first, Model):
            yield from _axes(first, getattr(back, name))
        else:
            yield from (np.ndim(first) if _is_number(first) else 0, np.ndim(getattr(back, name)))


def _cuts(front: Layer, back: Layer, profile: str) -> RealArray:
    """Return depths, 0 and 1 among them, between which no property changes by much."""
    found = {0.0, 1.0}
    for log in _logs(front, back):
        steps = np.linspace(0, 1, max(int(np.ceil(abs(log) / _CHANGE)), 1) + 1)
        linear = profile == "linear" and abs(log) > _CHANGE
        found |= {float(depth) for depth in (np.expm1(steps * log) / np.expm1(log) if linear else steps)}
    depths = np.array(sorted(found))
    return np.asarray(depths[np.append(np.diff(depths) > 1e-6, True)])
