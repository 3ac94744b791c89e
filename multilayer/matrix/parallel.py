"""Stacks side by side, much smaller than a wavelength, as one sheet: they share the pressures at both faces.

K. Verdiere, R. Panneton, S. Elkoun, T. Dupont & P. Leclaire, J. Acoust. Soc. Am. 134 (2013) 4648-4658: the admittances
of the parts add up by area. Each part is solved by itself for waves from either side.
"""

from __future__ import annotations

from collections.abc import Sequence

from multilayer.arrays import ComplexArray, Numeric
from multilayer.matrix.couplings import Contact
from multilayer.matrix.faces import Faces, mirrored
from multilayer.matrix.families import FLUID
from multilayer.matrix.small import stack_entries
from multilayer.matrix.solve import HalfSpace, System, Wall, solve


def reflections(layers: Sequence[Faces], impedance: float, *, closed: bool = False) -> ComplexArray:
    """Return the scattering matrix of bonded layers in a fluid, shape (2, 2, ...), entry first.

    Parameters
    ----------
    layers : sequence of Faces
        From front to back.
    impedance : float
        Of waves that arrive at either side, Pa s/m.
    closed : bool
        Whether a rigid wall closes the back: nothing passes, and from behind it is that wall.
    """
    outside = HalfSpace(impedance)
    bonded: list[Contact] = ["bonded"] * (len(layers) + 1)
    if closed:
        front = solve(System(outside, layers, Wall(), bonded))
        assert front.reflected is not None
        return stack_entries([[front.reflected, 0.0], [0.0, 1.0]])
    front = solve(System(outside, layers, outside, bonded))
    back = solve(System(outside, [mirrored(layer) for layer in reversed(layers)], outside, bonded))
    (r, t), (r_back, t_back) = ((side.reflected, side.transmitted) for side in (front, back))
    assert r is not None  # of waves that arrive, and leave, through a fluid
    assert t is not None
    assert r_back is not None
    assert t_back is not None
    return stack_entries([[r, t_back], [t, r_back]])


def side_by_side(shares: Sequence[Numeric], parts: Sequence[ComplexArray], impedance: float) -> Faces:
    """Return the face matrices of parts that share the pressures at both faces.

    Parameters
    ----------
    shares : sequence of float or array
        Of the area; they sum up to 1.
    parts : sequence of complex array, shape (2, 2, ...)
        Their scattering matrices, see `reflections`; what follows the entries broadcasts, with the shares, too.
    impedance : float
        Of those, Pa s/m.
    """
    # velocities into the sheet over pressures, times the impedance: (1 - S) / (1 + S)
    of_parts = [_cayley(part) for part in parts]
    admittance = stack_entries([
        [sum(share * part[i, j] for share, part in zip(shares, of_parts, strict=True)) for j in (0, 1)] for i in (0, 1)
    ])  # fmt: skip
    scattered = _cayley(admittance)
    (r, t_back), (t, r_back) = scattered
    front = stack_entries([[1 + r, t_back], [(1 - r) / impedance, -t_back / impedance]])
    back = stack_entries([[t, 1 + r_back], [t / impedance, (r_back - 1) / impedance]])
    return Faces(FLUID, front, back)


def _cayley(matrix: ComplexArray) -> ComplexArray:
    """Return (1 - M) (1 + M)^-1 of 2 x 2 matrices, entry first; it is its own inverse."""
    (a, b), (c, d) = matrix
    size = (1 + a) * (1 + d) - b * c
    return stack_entries([
        [((1 - a) * (1 + d) + b * c) / size, -2 * b / size],
        [-2 * c / size, ((1 + a) * (1 - d) + b * c) / size],
    ])  # fmt: skip
