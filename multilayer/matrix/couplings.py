"""Couplings: the quantities that are continuous where two families touch, and the conditions at a wall or a void.

A coupling is a pair (I, J) of small matrices, nested tuples of numbers (or arrays, where a porosity enters), with

    I V_front_side + J V_back_side = 0        (Allard & Atalla 2009, section 11.4)

one row per condition. The number of rows is half the sum of the two states' sizes. Their order does not matter, but
with shear in the first rows the solver, which eliminates shear waves first, has fewer rows to exchange.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, TypeAlias

from multilayer.arrays import Numeric
from multilayer.errors import MultilayerError
from multilayer.matrix.families import FLUID, POROELASTIC, SOLID, Family

Contact: TypeAlias = Literal["bonded", "slip"]
Rows: TypeAlias = tuple[tuple[Numeric, ...], ...]
Coupling: TypeAlias = Callable[[Numeric, Numeric], tuple[Rows, Rows]]

_COUPLINGS: dict[tuple[str, str, Contact], Coupling] = {}


class CouplingError(MultilayerError):
    """Two layers are in a contact for which no coupling is known."""


def register_coupling(front: Family, back: Family, contact: Contact, coupling: Coupling) -> None:
    """Add the coupling of two families; it serves both orders.

    Parameters
    ----------
    front, back : Family
    contact : {'bonded', 'slip'}
    coupling : callable
        ``coupling(porosity_front, porosity_back) -> (I, J)``; the porosities are 1 for families without pores.
    """
    _COUPLINGS[front.name, back.name, contact] = coupling


def couple(
    front: Family, back: Family, contact: Contact, porosity_front: Numeric = 1.0, porosity_back: Numeric = 1.0
) -> tuple[Rows, Rows]:
    """Return (I, J) for two neighbours.

    Raises
    ------
    CouplingError
        When this pair of families has no such contact.
    """
    if (coupling := _COUPLINGS.get((front.name, back.name, contact))) is not None:
        return coupling(porosity_front, porosity_back)
    if (coupling := _COUPLINGS.get((back.name, front.name, contact))) is not None:
        rows_back, rows_front = coupling(porosity_back, porosity_front)
        return rows_front, rows_back
    raise CouplingError(_why_not(front, back, contact))


def _why_not(front: Family, back: Family, contact: Contact) -> str:
    if contact == "slip" and FLUID in (front, back):
        return slips_anyway(front, back)
    return f"no '{contact}' coupling is known for a {front.name} face against a {back.name} face"


def slips_anyway(front: Family, back: Family) -> str:
    """Return the refusal of a contact that changes nothing."""
    return f"a {front.name} face against a {back.name} face slips anyway: leave the contact out"


def _fluid_fluid(_front: Numeric, _back: Numeric) -> tuple[Rows, Rows]:
    return ((1, 0), (0, 1)), ((-1, 0), (0, -1))


def _solid_solid(_front: Numeric, _back: Numeric) -> tuple[Rows, Rows]:
    identity = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))
    return identity, _negative(identity)


def _solid_solid_slip(_front: Numeric, _back: Numeric) -> tuple[Rows, Rows]:
    return (
        ((0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1), (0, 0, 0, 0)),
        ((0, -1, 0, 0), (0, 0, -1, 0), (0, 0, 0, 0), (0, 0, 0, 1)),
    )


def _fluid_solid(_front: Numeric, _back: Numeric) -> tuple[Rows, Rows]:
    """Eq. (11.78): v3 = v3, s13 = 0, p = -s33."""
    return ((0, 1), (0, 0), (1, 0)), ((0, -1, 0, 0), (0, 0, 0, 1), (0, 0, 1, 0))


def _fluid_poroelastic(_front: Numeric, phi: Numeric) -> tuple[Rows, Rows]:
    """Eq. (11.74): volume velocity; no shear; the pressure shared between frame and pores by area."""
    return (
        ((0, 1), (0, 0), (1 - phi, 0), (phi, 0)),
        (
            (0, -(1 - phi), -phi, 0, 0, 0),
            (0, 0, 0, 0, 1, 0),
            (0, 0, 0, 1, 0, 0),
            (0, 0, 0, 0, 0, 1),
        ),
    )


def _sheet_poroelastic_slip(_front: Numeric, _back: Numeric) -> tuple[Rows, Rows]:
    """Return it of an impervious sheet, of state (p, v3), on the frame: no flow through it, no shear, total stress."""
    return (
        ((0, 0), (0, 1), (0, 1), (1, 0)),
        ((0, 0, 0, 0, 1, 0), (0, -1, 0, 0, 0, 0), (0, 0, -1, 0, 0, 0), (0, 0, 0, 1, 0, 1)),
    )


def _solid_poroelastic(_front: Numeric, _back: Numeric) -> tuple[Rows, Rows]:
    """Eq. (11.76): frame and pore fluid move with the solid; shear and total normal stress."""
    return (
        ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 0, 1), (0, 1, 0, 0), (0, 0, 1, 0)),
        (
            (-1, 0, 0, 0, 0, 0),
            (0, -1, 0, 0, 0, 0),
            (0, 0, 0, 0, -1, 0),
            (0, 0, -1, 0, 0, 0),
            (0, 0, 0, -1, 0, -1),
        ),
    )


def _solid_poroelastic_slip(_front: Numeric, _back: Numeric) -> tuple[Rows, Rows]:
    return (
        ((0, 1, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1), (0, 0, 0, 0)),
        (
            (0, -1, 0, 0, 0, 0),
            (0, 0, -1, 0, 0, 0),
            (0, 0, 0, -1, 0, -1),
            (0, 0, 0, 0, 0, 0),
            (0, 0, 0, 0, 1, 0),
        ),
    )


def _poroelastic_poroelastic(front: Numeric, back: Numeric) -> tuple[Rows, Rows]:
    """Eq. (11.66): frame velocities, flow relative to the frame, total stresses and pore pressure."""
    return _poroelastic_side(front), _negative(_poroelastic_side(back))


def _poroelastic_side(phi: Numeric) -> Rows:
    return (
        (1, 0, 0, 0, 0, 0),
        (0, 1, 0, 0, 0, 0),
        (0, -phi, phi, 0, 0, 0),
        (0, 0, 0, 1, 0, 1),
        (0, 0, 0, 0, 1, 0),
        (0, 0, 0, 0, 0, 1 / phi),
    )


def _poroelastic_poroelastic_slip(front: Numeric, back: Numeric) -> tuple[Rows, Rows]:
    kept = (1, 2, 3, 5)
    zero, shear = (0,) * 6, (0, 0, 0, 0, 1, 0)
    of_front, of_back = _poroelastic_side(front), _negative(_poroelastic_side(back))
    return (*(of_front[i] for i in kept), shear, zero), (*(of_back[i] for i in kept), zero, shear)


def _negative(rows: Rows) -> Rows:
    return tuple(tuple(-entry for entry in row) for row in rows)


register_coupling(FLUID, FLUID, "bonded", _fluid_fluid)
register_coupling(SOLID, SOLID, "bonded", _solid_solid)
register_coupling(SOLID, SOLID, "slip", _solid_solid_slip)
register_coupling(FLUID, SOLID, "bonded", _fluid_solid)
register_coupling(FLUID, POROELASTIC, "bonded", _fluid_poroelastic)
register_coupling(FLUID, POROELASTIC, "slip", _sheet_poroelastic_slip)
register_coupling(SOLID, POROELASTIC, "bonded", _solid_poroelastic)
register_coupling(SOLID, POROELASTIC, "slip", _solid_poroelastic_slip)
register_coupling(POROELASTIC, POROELASTIC, "bonded", _poroelastic_poroelastic)
register_coupling(POROELASTIC, POROELASTIC, "slip", _poroelastic_poroelastic_slip)


def _select(family: Family, *components: str) -> Rows:
    return tuple(tuple(int(name == wanted) for name in family.components) for wanted in components)


_WALLS: dict[tuple[str, Contact], Rows] = {
    (FLUID.name, "bonded"): _select(FLUID, "v3"),
    (SOLID.name, "bonded"): _select(SOLID, "v1", "v3"),
    (SOLID.name, "slip"): _select(SOLID, "s13", "v3"),
    (POROELASTIC.name, "bonded"): _select(POROELASTIC, "v1s", "v3s", "v3f"),
    (POROELASTIC.name, "slip"): _select(POROELASTIC, "s13s", "v3s", "v3f"),
}
_VOIDS: dict[str, Rows] = {
    FLUID.name: _select(FLUID, "p"),
    SOLID.name: _select(SOLID, "s13", "s33"),
    POROELASTIC.name: _select(POROELASTIC, "s13s", "s33s", "s33f"),
}


def wall_rows(family: Family, contact: Contact = "bonded") -> tuple[Rows, tuple[int, ...]]:
    """Return the rows of what a rigid wall fixes, and for each 1 where it is a normal velocity, else 0.

    The rows of an immobile wall are set to zero; those of a wall moving along axis 3 take its velocity where the
    second result is 1.

    Raises
    ------
    CouplingError
        When the family has no such contact with a wall.
    """
    rows = _WALLS.get((family.name, contact))
    if rows is None:
        raise CouplingError(f"no '{contact}' contact is known between a {family.name} face and a wall")
    normal = {i for i, name in enumerate(family.components) if name.startswith("v3")}
    return rows, tuple(int(any(row[i] for i in normal)) for row in rows)


def void_rows(family: Family) -> Rows:
    """Return the stresses that vanish at a free face.

    Raises
    ------
    CouplingError
        When the family is unknown here.
    """
    if family.name not in _VOIDS:
        raise CouplingError(f"no free face is known for a {family.name} layer")
    return _VOIDS[family.name]
