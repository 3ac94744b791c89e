"""The transmissibility of a reduced rig at given frequencies as a sum of partial fractions of the sample's modulus.

Thousands of moduli at the same frequencies then cost one eigenvalue problem per frequency: for symmetric matrices the
symmetric-definite one of G. H. Golub & C. F. Van Loan, Matrix Computations, 4th ed., 2013, section 8.7.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multilayer.arrays import ComplexArray, IndexArray, Numeric, RealArray

_CHUNK = 4_000_000  # numbers in a batch of fractions


@dataclass(frozen=True)
class PartialFractions:
    """At a given frequency a rig without other losses is ``1 + sum_i w_i / (E + mu_i)``, mu and w real.

    Attributes
    ----------
    poles, residues : array, shape (n_frequency, n)
        mu and w.
    """

    poles: RealArray
    residues: RealArray

    @classmethod
    def of(cls, stiffness: RealArray, rest: RealArray, loads: RealArray, reading: RealArray) -> PartialFractions:
        """Return the fractions of ``1 + reading (E K + M)^-1 load``.

        Parameters
        ----------
        stiffness : array, shape (n, n)
            K, positive definite.
        rest : array, shape (n_frequency, n, n)
            M, symmetric and real.
        loads : array, shape (n_frequency, n)
        reading : array, shape (n,)
        """
        unit = np.linalg.inv(np.linalg.cholesky(stiffness))
        others = unit @ rest @ unit.T
        poles, vectors = np.linalg.eigh(0.5 * (others + others.swapaxes(-1, -2)))
        residues = np.einsum("fi,fij->fj", loads @ unit.T, vectors) * ((unit @ reading) @ vectors)
        return cls(poles, residues)

    def at(self, index: IndexArray) -> PartialFractions:
        """Return the fractions at some of the frequencies."""
        return PartialFractions(self.poles[index], self.residues[index])

    def __call__(self, modulus: ComplexArray) -> ComplexArray:
        """Return the transmissibility of moduli of shape (..., n_frequency), Pa."""
        return _summed(self.residues, 1.0, self.poles, modulus)


@dataclass(frozen=True)
class LossyFractions:
    """With further losses, in pores or glue, a rig is ``1 + sum_i w_i / (1 + d_i (E - E0))``, d and w complex.

    Attributes
    ----------
    slopes, residues : complex array, shape (n_frequency, n)
        d (1/Pa) and w.
    centre : complex
        E0, Pa.
    """

    slopes: ComplexArray
    residues: ComplexArray
    centre: complex

    @classmethod
    def of(
        cls, stiffness: RealArray, rest: ComplexArray, loads: ComplexArray, reading: RealArray, centre: complex
    ) -> LossyFractions:
        """Return the fractions as in `PartialFractions.of`; K may be singular (in pressures) and M complex.

        The expansion is about a modulus `centre` with losses, at which ``E0 K + M`` is passive, away from its
        resonances, and so well conditioned.
        """
        about = np.linalg.inv(centre * stiffness + rest)
        slopes, vectors = np.linalg.eig(about @ stiffness)
        moved = np.einsum("fij,fj->fi", about, loads)
        amplitudes = np.linalg.solve(vectors, moved[..., None])[..., 0]
        return cls(slopes, amplitudes * (reading @ vectors), centre)

    def at(self, index: IndexArray) -> LossyFractions:
        """Return the fractions at some of the frequencies."""
        return LossyFractions(self.slopes[index], self.residues[index], self.centre)

    def __call__(self, modulus: ComplexArray) -> ComplexArray:
        """Return the transmissibility of moduli of shape (..., n_frequency), Pa."""
        return _summed(self.residues, self.slopes, 1.0, modulus - self.centre)


def _summed(residues: ComplexArray | RealArray, factor: Numeric, constant: Numeric, x: ComplexArray) -> ComplexArray:
    """Return ``1 + sum_i residue_i / (constant_i + factor_i x)``, batch by batch."""
    size = max(1, _CHUNK // residues.size)
    rows = x.reshape(-1, x.shape[-1])
    parts = [
        np.sum(residues / (constant + factor * rows[i : i + size, :, None]), axis=-1) for i in range(0, len(rows), size)
    ]
    return np.asarray(1 + np.concatenate(parts).reshape(x.shape))
