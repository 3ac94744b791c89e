"""Face matrices of a slab from its field equations alone, for layers without waves in closed form.

A layer type gives X and Y of ``d(even)/dx3 = X odd`` and ``d(odd)/dx3 = Y even`` (see `Family.even`); here they become
face matrices that hold from infinitely thin to many wavelengths. Thin slabs use the power series of `matrix.faces`.
Thick ones are halved until the series holds and put together again as scattering matrices between waves of a real
reference impedance: nothing grows exponentially, and no eigenvectors merge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.matrix.faces import THIN, Faces, choose, from_propagator, propagator_series
from multilayer.matrix.families import Family
from multilayer.matrix.scattering import Reference, Scattering, joined
from multilayer.matrix.small import Entries, aligned, stack_entries
from multilayer.matrix.wave import Wave

_HALVED_TO = 1.0  # |k| h


@dataclass(frozen=True)
class FieldEquations:
    """The field equations of a medium that is its own mirror image along axis 3.

    Attributes
    ----------
    family : Family
    x, y : entries, shape (n_state/2, n_state/2)
        ``d(even)/dx3 = X odd``, ``d(odd)/dx3 = Y even``, by time and trace dependence exp(i (w t - kx x1)).
    porosity : float or array
        Open area at the faces; 1 for families without pores.
    """

    family: Family
    x: Entries
    y: Entries
    porosity: Numeric = 1.0

    @property
    def matrices(self) -> tuple[ComplexArray, ComplexArray]:
        """X and Y as arrays, with equally many axes."""
        x, y = aligned(stack_entries(self.x), stack_entries(self.y))
        return x, y

    def reference(self, kx: Numeric) -> Reference:
        """Return impedances near those of the medium's own waves."""
        return Reference.of(self.family, *self.matrices, kx)


def slab_faces(wave: Wave, thickness: Numeric, equations: FieldEquations) -> Faces:
    """Return the face matrices of a homogeneous slab of any thickness.

    Parameters
    ----------
    wave : Wave
    thickness : float or array
        m.
    equations : FieldEquations
    """
    family, n = equations.family, equations.family.half
    turn = equations.reference(wave.kx).wavenumber(*equations.matrices) * thickness
    entries = [entry for matrix in (equations.x, equations.y) for row in matrix for entry in row]

    def split(flat: tuple[Numeric, ...]) -> FieldEquations:
        rows = [flat[i : i + n] for i in range(0, len(flat), n)]
        return FieldEquations(family, rows[:n], rows[n:])

    def series(h: Numeric, _kx: Numeric, *flat: Numeric) -> tuple[ComplexArray, ComplexArray]:
        medium = split(flat)
        return from_propagator(family, propagator_series(family, medium.x, medium.y, h), wave.ambient.impedance)

    def halved(h: Numeric, kx: Numeric, *flat: Numeric) -> tuple[ComplexArray, ComplexArray]:
        return _halved(split(flat), h, np.asarray(kx))

    arguments = (thickness, wave.kx, *entries)
    front, back = choose(np.asarray(turn < THIN), series, halved, arguments)
    return Faces(family, front, back, equations.porosity)


def _halved(equations: FieldEquations, thickness: Numeric, kx: Numeric) -> tuple[ComplexArray, ComplexArray]:
    """Return the face matrices from 2^n equal slices, n by frequency, angle and sample."""
    reference = equations.reference(kx)
    turn = reference.wavenumber(*equations.matrices) * thickness
    times = np.maximum(np.ceil(np.log2(np.maximum(turn, _HALVED_TO) / _HALVED_TO)), 0)
    slices = propagator_series(equations.family, equations.x, equations.y, thickness / 2.0**times)
    whole = Scattering.of(reference, slices)
    for n in range(int(np.max(times, initial=0))):
        whole = joined(whole, whole).where(times > n, whole)
    return whole.faces(reference)
