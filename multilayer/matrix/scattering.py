"""Slices of a layer as scattering matrices, whose entries stay bounded when slices are joined.

    c-(front) = r c+(front) + t' c-(back)        c+(back) = t c+(front) + r' c-(back)

between wave-like amplitudes ``velocity = c+ + c-``, ``sign * stress = Z (c+ - c-)`` of a real reference impedance Z for
each power pair of the state. Of a passive slice no singular value (weighed by power) exceeds 1, whatever Z.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.matrix.families import Family

_TINY = 1e-300


@dataclass(frozen=True)
class Reference:
    """Reference impedances.

    Attributes
    ----------
    family : Family
    impedances : array, shape (..., n_state/2)
        Pa s/m, one for each of the family's power pairs, above 0.
    """

    family: Family
    impedances: RealArray

    @classmethod
    def of(cls, family: Family, x: ComplexArray, y: ComplexArray, kx: Numeric) -> Reference:
        """Return impedances near those of a medium's own waves, from its field equations (see `FieldEquations`)."""
        matrix = _whole(family, x, y)
        impedances = []
        for velocity, stress, _ in family.power_pairs:
            inertia, compliance = np.abs(matrix[stress, velocity]) + _TINY, np.abs(matrix[velocity, stress]) + _TINY
            both = inertia * compliance + np.abs(kx) ** 2
            # evanescent fields of solids are borne by stiffness, those of fluids by mass
            fluid = family.components[stress] in ("p", "s33f")
            impedances.append(inertia / np.sqrt(both) if fluid else np.sqrt(both) / compliance)
        return cls(family, np.stack(np.broadcast_arrays(*impedances), axis=-1))

    def wavenumber(self, x: ComplexArray, y: ComplexArray) -> RealArray:
        """Return an upper bound of |k| of all waves along axis 3, rad/m."""
        scale = self._scale()
        even, odd = list(self.family.even), list(self.family.odd)
        norms = []
        for matrix, rows, columns in ((x, even, odd), (y, odd, even)):
            scaled = np.moveaxis(matrix, (0, 1), (-2, -1)) * scale[..., None, columns] / scale[..., rows, None]
            norms.append(np.sqrt(np.sum(np.abs(scaled) ** 2, axis=(-2, -1))))
        return np.asarray(np.sqrt(norms[0] * norms[1]))

    def _scale(self) -> RealArray:
        """Return the size of each entry of a state beside a velocity of 1."""
        scale = np.ones((*self.impedances.shape[:-1], self.family.size))
        for pair, (_, stress, _) in enumerate(self.family.power_pairs):
            scale[..., stress] = self.impedances[..., pair]
        return scale

    def order(self) -> tuple[list[int], RealArray]:
        """Return the indices of velocities, then stresses, pair by pair, and the scale of each with its sign."""
        pairs = self.family.power_pairs
        rows = [velocity for velocity, _, _ in pairs] + [stress for _, stress, _ in pairs]
        signs = np.array([1.0] * len(pairs) + [float(sign) for *_, sign in pairs])
        return rows, self._scale()[..., rows] * signs


@dataclass(frozen=True)
class Scattering:
    """Scattering matrices of a slice, each of shape (..., m, m) for m power pairs."""

    r: ComplexArray
    t: ComplexArray
    r_back: ComplexArray
    t_back: ComplexArray

    @classmethod
    def of(cls, reference: Reference, propagator: ComplexArray) -> Scattering:
        """Return the matrices of a thin slice from V(back) = P V(front), entry first."""
        rows, scale = reference.order()
        p = np.moveaxis(propagator[np.ix_(rows, rows)], (0, 1), (-2, -1)) * scale[..., None, :] / scale[..., :, None]
        m = len(rows) // 2
        a, b, c, d = p[..., :m, :m], p[..., :m, m:], p[..., m:, :m], p[..., m:, m:]
        q11, q12 = (a + b + c + d) / 2, (a - b + c - d) / 2
        q21, q22 = (a + b - c - d) / 2, (a - b - c + d) / 2
        t_back = np.asarray(np.linalg.inv(q22), dtype=np.complex128)
        r = -t_back @ q21
        return cls(r, q11 + q12 @ r, q12 @ t_back, t_back)

    def __getitem__(self, index: int | slice) -> Scattering:
        """Return some of many slices along the first axis."""
        return Scattering(*(matrix[index] for matrix in self._all()))

    def followed_by(self, others: Scattering) -> Scattering:
        """Return these slices and others along the first axis; nothing is joined."""
        return Scattering(*(np.concatenate(both) for both in zip(self._all(), others._all(), strict=True)))

    def where(self, chosen: RealArray, other: Scattering) -> Scattering:
        """Return this where `chosen`, the other elsewhere."""
        mask = np.asarray(chosen, dtype=bool)[..., None, None]
        return Scattering(
            *(np.where(mask, inside, outside) for inside, outside in zip(self._all(), other._all(), strict=True))
        )

    def _all(self) -> tuple[ComplexArray, ...]:
        return self.r, self.t, self.r_back, self.t_back

    def faces(self, reference: Reference) -> tuple[ComplexArray, ComplexArray]:
        """Return the face matrices (A, B), entry first; the coefficients are the amplitudes that arrive."""
        rows, scale = reference.order()
        eye = np.broadcast_to(np.eye(self.r.shape[-1]), self.r.shape)
        front = np.block([[eye + self.r, self.t_back], [eye - self.r, -self.t_back]])
        back = np.block([[self.t, eye + self.r_back], [self.t, self.r_back - eye]])
        backwards = np.argsort(rows)
        return tuple(  # type: ignore[return-value]
            np.moveaxis((matrix * scale[..., :, None])[..., backwards, :], (-2, -1), (0, 1)) for matrix in (front, back)
        )


def joined(front: Scattering, back: Scattering) -> Scattering:
    """Return the matrices of two slices, one behind the other.

    The star product of R. Redheffer, J. Math. Phys. 41 (1962) 1-41.
    """
    eye = np.eye(front.r.shape[-1])
    inward = np.linalg.solve(eye - back.r @ front.r_back, np.concatenate([back.r @ front.t, back.t_back], axis=-1))
    m = front.r.shape[-1]
    onward = np.linalg.solve(
        eye - front.r_back @ back.r, np.concatenate([front.t, front.r_back @ back.t_back], axis=-1)
    )
    return Scattering(
        r=front.r + front.t_back @ inward[..., :m],
        t=back.t @ onward[..., :m],
        r_back=back.r_back + back.t @ onward[..., m:],
        t_back=front.t_back @ inward[..., m:],
    )


def _whole(family: Family, x: ComplexArray, y: ComplexArray) -> ComplexArray:
    """Return M of dV/dx3 = M V from its two blocks."""
    shape = np.broadcast_shapes(x.shape[2:], y.shape[2:])
    matrix = np.zeros((family.size, family.size, *shape), dtype=complex)
    matrix[np.ix_(family.even, family.odd)] = x
    matrix[np.ix_(family.odd, family.even)] = y
    return matrix
