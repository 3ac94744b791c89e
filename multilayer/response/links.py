"""Structural links between the leaves of a wall, studs and ties, as they are described in a file.

What they carry from leaf to leaf is computed by `response.single_links` and `response.periodic_links`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, RealArray
from multilayer.errors import InputError
from multilayer.layers.base import Layer
from multilayer.layers.elastic_plate import ElasticPlate
from multilayer.layers.elastic_solid import ElasticSolid
from multilayer.matrix.wave import Wave
from multilayer.media.elastic import flexural_rigidity
from multilayer.models import Model
from multilayer.stack import Stack
from multilayer.units import Length, Unit

Mistake = tuple[tuple[str | int, ...], str, Any]


class _Links(Model):
    """Links of one kind between two leaves."""

    name: str | None = None
    between: tuple[str | int, str | int]
    spacing: Length


class LineLinks(_Links):
    """Studs: lines along which two leaves are held together.

    Fields: `between` (a layer of each leaf), `spacing` of the lines (m), `compliance` (m2/N, of a piece of unit length:
    how far its two flanges give way under unit force per length; 0 of wood), `periodic` (whether all bays are alike and
    waves that run on to the next lines come back from there; else they count as lost), `fasteners` (m, of periodic
    lines: from screw to screw along a line, on which the leaves are held at the screws alone; else all along).
    """

    kind: Literal["line"] = "line"
    compliance: Annotated[float, Field(ge=0), Unit("m^2/N")] = 0.0
    periodic: bool = False
    fasteners: Length | None = None


class PointLinks(_Links):
    """Ties: points at which two leaves are held together.

    Fields: `between` (a layer of each leaf), `spacing` (m, of a square grid), `compliance` (m/N, of each; 0 of a bolt).
    """

    kind: Literal["point"] = "point"
    compliance: Annotated[float, Field(ge=0), Unit("m/N")] = 0.0


Links = Annotated[LineLinks | PointLinks, Field(discriminator="kind")]


@dataclass(frozen=True)
class Leaf:
    """Plates that lie upon each other, by the indices of the first and the last."""

    first: int
    last: int

    def of(self, stack: Stack) -> tuple[Layer, ...]:
        """Return the plates."""
        return stack.layers[self.first : self.last + 1]

    def mass_and_stiffness(self, stack: Stack, wave: Wave) -> tuple[RealArray, ComplexArray]:
        """Return mass per area, kg/m2, and bending stiffness, N m, of plates that slip on each other."""
        mass, stiffness = np.zeros(1), np.zeros(1, dtype=complex)
        for plate in self.of(stack):
            assert isinstance(plate, ElasticPlate | ElasticSolid)  # by validation
            mass = mass + plate.density * plate.thickness
            stiffness = stiffness + flexural_rigidity(plate.complex_modulus(wave), plate.poisson_ratio, plate.thickness)
        return mass, stiffness


def _leaf(stack: Stack, key: str | int) -> Leaf:
    """Return the leaf to which a layer belongs.

    Raises
    ------
    InputError
        When there is no such layer, or it is no plate.
    """
    at = stack.index(key)
    first = last = at
    if isinstance(stack.layers[at], ElasticPlate):
        while first > 0 and isinstance(stack.layers[first - 1], ElasticPlate):
            first -= 1
        while last < len(stack.layers) - 1 and isinstance(stack.layers[last + 1], ElasticPlate):
            last += 1
    if not isinstance(stack.layers[at], ElasticPlate | ElasticSolid):
        kind = stack.layers[at].type
        raise InputError(f"links hold plates together, and {key} is '{kind}'; name an elastic_plate or elastic_solid")
    beside = [stack.layers[i] for i in (first - 1, last + 1) if 0 <= i < len(stack.layers)]
    if any(isinstance(layer, ElasticPlate | ElasticSolid) for layer in beside):
        raise InputError(
            f"{key} lies on a solid; a leaf with links is one elastic_solid, or any number of elastic_plate"
        )
    return Leaf(first, last)


def leaves(stack: Stack, links: _Links) -> tuple[Leaf, Leaf]:
    """Return the two leaves, from the sound on, that some links connect; raises InputError as `_leaf`."""
    front, back = sorted((_leaf(stack, key) for key in links.between), key=lambda leaf: leaf.first)
    if front == back:
        raise InputError("these are one leaf: links connect two, with a cavity between them")
    return front, back


def periodic(links: Sequence[LineLinks | PointLinks]) -> list[LineLinks]:
    """Return the lines that are computed as a periodic whole: all links, or none (`wrong_links`)."""
    return [these for these in links if isinstance(these, LineLinks) and these.periodic]


def wrong_links(stack: Stack, links: Sequence[LineLinks | PointLinks]) -> Iterator[Mistake]:
    """Give path, text and value of what is wrong with the links of a stack."""
    lines = periodic(links)
    held: dict[tuple[str, float], dict[Leaf, set[Leaf]]] = {}  # by lines, which leaves hang together
    for i, these in enumerate(links):
        try:
            front, back = leaves(stack, these)
        except InputError as error:
            yield ("links", i, "between"), str(error), these.between
            continue
        together = held.setdefault((these.kind, these.spacing), {})
        one, other = (together.get(leaf, {leaf}) for leaf in (front, back))
        if one is other or front in other:
            text = "these leaves are held together already by links of this kind and spacing, that is on the same lines"
            yield ("links", i, "between"), f"{text}; leave these out, or give them another spacing", these.between
        together.update(dict.fromkeys(one | other, one | other))
        if isinstance(these, LineLinks) and these.fasteners is not None and not these.periodic:
            text = "fasteners are computed of periodic lines alone; write 'periodic: true', or leave them out"
            yield ("links", i, "fasteners"), text, these.fasteners
        if these in lines and not all(isinstance(stack.layers[leaf.first], ElasticPlate) for leaf in (front, back)):
            text = "periodic lines hold thin plates; write elastic_plate, or leave 'periodic' out"
            yield ("links", i, "between"), text, these.between
    if lines and (len(lines) < len(links) or len({(these.spacing, these.fasteners) for these in lines}) > 1):
        text = "links of a wall with periodic lines must all be such lines, of one spacing: they act upon each other"
        yield (
            ("links",),
            f"{text}; give all of them 'periodic: true', the same 'spacing' and 'fasteners', or none",
            None,
        )
    if links and stack.termination != "ambient":
        text = "links are computed of walls between two rooms; write 'termination: ambient'"
        yield ("links",), text, stack.termination
    if links and not stack.isotropic_in_plane:
        yield ("links",), "links are computed of stacks that are isotropic in their plane alone", None
