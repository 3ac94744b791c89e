"""Axisymmetric integrals of second-order elements; every matrix of the rig is a weighted sum of them.

All are over a part of the section, of scalar fields a (trial) and b (test), times 2 pi r; a,r and a,z are derivatives.
Displacements (u_r, u_z) and the pressure in pores are three such fields on the same nodes. For the strains of an
axisymmetric solid see O. C. Zienkiewicz & R. L. Taylor, The Finite Element Method, vol. 1, 5th ed., 2000, chapter 5.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, BilinearForm, ElementQuad2, FacetBasis, MeshQuad

from multilayer.arrays import RealArray

_ORDER = 6  # of the quadrature: exact for products of second-order functions and r

Profile = Callable[[RealArray], RealArray]
Sparse: TypeAlias = Any  # a scipy.sparse.csr_matrix, whose stubs do not follow the sums and blocks made of it


def _form(integrand: Callable[[Any, Any, RealArray], Any]) -> Any:
    """Return the form of an integrand of (a, b, r), weighted by the keyword `c`."""
    return BilinearForm(lambda a, b, w: w.c * integrand(a, b, w.x[0]))


_RR = _form(lambda a, b, r: a.grad[0] * b.grad[0] * r)
_ZZ = _form(lambda a, b, r: a.grad[1] * b.grad[1] * r)
_ZR = _form(lambda a, b, r: a.grad[1] * b.grad[0] * r)
_Z0 = _form(lambda a, b, r: a.grad[1] * b)
_R0 = _form(lambda a, b, r: a.grad[0] * b)
_OVER = _form(lambda a, b, r: a * b / r)
_R = _form(lambda a, b, r: a.grad[0] * b * r)
_Z = _form(lambda a, b, r: a.grad[1] * b * r)
_HOOP = _form(lambda a, b, r: a * b)
_MASS = _form(lambda a, b, r: a * b * r)


@dataclass(frozen=True)
class Operators:
    """Integrals over one part, each a sparse matrix of shape (n_nodes, n_nodes): row b, column a.

    Attributes
    ----------
    rr, zz, zr : sparse matrix
        Of a,r b,r; of a,z b,z; of a,z b,r.
    z0, r0, over : sparse matrix
        Of a,z b / r; of a,r b / r; of a b / r^2.
    """

    rr: Sparse
    zz: Sparse
    zr: Sparse
    z0: Sparse
    r0: Sparse
    over: Sparse


def basis_of(mesh: MeshQuad, elements: NDArray[np.intp] | None = None) -> Basis:
    """Return second-order functions on a mesh or some of its elements; the numbering of nodes is that of the mesh."""
    return Basis(mesh, ElementQuad2(), elements=elements, intorder=_ORDER)


def operators(basis: Basis, profile: Profile | None = None) -> Operators:
    """Return the integrals over a basis, weighted by a function of the height z, m."""
    weight = _weight(basis, profile)
    forms = (_RR, _ZZ, _ZR, _Z0, _R0, _OVER)
    return Operators(*(form.assemble(basis, c=weight).tocsr() for form in forms))


def gradients(basis: Basis) -> tuple[Sparse, Sparse, Sparse]:
    """Return the integrals of a,r b, of a,z b, and of a b / r."""
    weight = _weight(basis, None)
    along_r, along_z, hoop = (form.assemble(basis, c=weight).tocsr() for form in (_R, _Z, _HOOP))
    return along_r, along_z, hoop


def mass(basis: Basis | FacetBasis) -> Sparse:
    """Return the integral of a b over a volume or, of facets, over a surface."""
    return _MASS.assemble(basis, c=_weight(basis, None)).tocsr()


def _weight(basis: Basis | FacetBasis, profile: Profile | None) -> RealArray:
    x = np.asarray(basis.global_coordinates())
    factor = np.ones_like(x[1]) if profile is None else np.asarray(profile(x[1]), dtype=float)
    return 2 * np.pi * factor


def line_basis(mesh: MeshQuad, facets: NDArray[np.intp]) -> FacetBasis:
    """Return second-order functions on facets of the boundary."""
    return FacetBasis(mesh, ElementQuad2(), facets=facets, intorder=_ORDER)
