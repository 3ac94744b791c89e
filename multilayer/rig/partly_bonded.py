"""A disc glued to two plates by a part of each face: its forces on them, from finite elements as a reduced model.

Everything is in units of the sample: lengths of its height h, moduli of E, densities of rho. A given shape and
Poisson's ratio then leave one variable besides the open rims, ``x = rho w^2 h^2 / E``, complex where E is, and the
forces are partial fractions of it with real poles. Fixed-interface modes with the unknowns of both faces (R. R. Craig &
M. C. C. Bampton, AIAA J. 6 (1968) 1313-1319), and the motions that follow from a plate's in powers of x, make a small
matrix, from which each open rim releases its part.

Accuracy: without open rims the forces are those of a rod to 3e-3 up to x = 30 (a height of 0.9 wavelengths). With them
a plate moves as on full finite elements within 0.25 % of its largest motion; at each frequency up to x = 50 within 2 %
of its motion there. Poles that are left out add to that where samples are flat: with a radius of 1.8 heights up to 6 %
of the motion at x = 50, with 3.6 heights 3 % of the largest motion and 8 % of that at x = 30. The mesh is uniform where
the edge of the bond concentrates the stress, as at the tip of a crack: a rim on it acts narrower by a fixed share of an
element (`_SHIFTS`), which is taken in.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, eigh
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from multilayer.arrays import ComplexArray, RealArray
from multilayer.errors import InputError
from multilayer.rig.assembly import blocks, isotropic, solid_parts
from multilayer.rig.mesh import Section, Slab, graded
from multilayer.rig.operators import Sparse, basis_of, mass, operators
from multilayer.shared_results import shared

WIDEST_RIM = 0.7  # share of the radius
_ACROSS = 80  # elements to a radius where rims may open
EDGES = np.arange(round(WIDEST_RIM * _ACROSS) + 1) / _ACROSS  # rims that end where elements do
_NODES = np.delete(np.arange(2 * len(EDGES) - 1), 1) / 2  # and in their middle, but for that of the first
RIMS = _NODES / _ACROSS  # for which forces are tabled
# by so much of an element a rim acts narrower: one that ends where elements do, beside finer meshes extrapolated to
# infinitely fine ones (0.090 with a Poisson's ratio of 0, 0.080 with 0.3), and one that ends in the middle of an
# element, beside the others (0.127 more, within 0.005)
_SHIFTS = (0.087, 0.214)
WIDTHS = RIMS - np.where(RIMS > 0, np.where(_NODES % 1 == 0, *_SHIFTS) / _ACROSS, 0.0)  # as which they act
_CORE, _ALONG = 10, 12  # elements further in, and in half the height, at least
_HALF = 0.5  # of the height
_MODES = 40  # with both faces held, symmetric and antisymmetric ones each
_MOMENTS = 6  # further motions inside, that follow from a plate's
_INNER = _MODES + _MOMENTS
_POLES = 80  # of a disc with open rims
_KEPT = 24  # of these, those whose power series would miss most of any force; the others as power series
_NEIGHBOURS = 4  # rims between which forces are interpolated, by a cubic
# motions of the top plate: moved, the base moved, bent (`deflection`), and its face turned where it is bent (`slope`);
# of the forces by the second on the first, those of `Forces`
_PAIRS = ((0, 0), (0, 1), (2, 0), (2, 1), (2, 2), (3, 0), (3, 1), (3, 2), (3, 3))
_FACES = {0: (1, 0), 1: (1, 1), 2: (0, 1)}  # of an open rim, by `at_base`: the upper face, both, the lower one
FORCES = 5  # on a plate of given thickness (`on_plate`)
_STEEL = 0.3  # Poisson's ratio of the plate, in `deflection`
_SAG = -(1.5 + 0.5 * _STEEL) / (2 * (1 + _STEEL))  # no moment at the plate's rim
CENTRE_DEFLECTION = 1 / 6 - _SAG / 2  # `deflection` at radius 0


@dataclass(frozen=True)
class Forces:
    """Forces on the top plate as partial fractions of ``x = rho w^2 h^2 / E``.

    ``f(x) = static - x inertia - x^2 (r0 + r1 x + r2 x^2 + sum_i residue_i / (pole_i - x))`` for m pairs of motions,
    the force on the one by the other: nine of a disc, of which a plate of given thickness makes five. The rest r stands
    for all other poles.

    Attributes
    ----------
    static, inertia : array, shape (..., m)
    rest : array, shape (..., m, 3)
    poles : array, shape (..., n)
    residues : array, shape (..., m, n)
    """

    static: RealArray
    inertia: RealArray
    rest: RealArray
    poles: RealArray
    residues: RealArray


@dataclass(frozen=True)
class PartlyBondedDisc:
    """A disc of one shape whose rim is open at the upper face, at both faces alike, or at the lower one.

    Attributes
    ----------
    poisson_ratio, shape : float
        As those of `partly_bonded_disc`.
    """

    poisson_ratio: float
    shape: float

    def stiffness(
        self, x: ComplexArray, rim: RealArray, at_base: RealArray, eccentricity: float = 0.0
    ) -> tuple[ComplexArray, ...]:
        """Return the forces that hold the top plate, and what they do to its bending, in units of E A / h.

        Parameters
        ----------
        x : complex array, shape (..., n)
            ``rho w^2 h^2 / E``.
        rim : array, shape (..., 1)
            Width of the open rim as a share of the radius, 0 to `WIDEST_RIM`; cut there.
        at_base : array, shape (..., 1)
            0 with a rim that is open at the upper face only, 1 at both, 2 at the lower one only; forces are linear
            between them.
        eccentricity : float
            Half the top plate's thickness over its radius: by so much the glued face is below the plane about which the
            plate bends, and moves along itself.

        Returns
        -------
        top, base : complex array, shape (..., n)
            Force on the top plate per its own motion, and per that of the base.
        bending_by_top, bending_by_base : complex array, shape (..., n)
            Sums of these forces over the plate, weighed with `deflection`; force on the top plate per its bending too.
        bending_by_bending : complex array, shape (..., n)
            The sum, weighed so, of the forces on a plate that is bent by `deflection` times 1.
        """
        x, rim, share = np.broadcast_arrays(np.asarray(x, dtype=complex), rim, at_base)
        shape = x.shape
        x, rim, share = x.reshape(-1, shape[-1]), rim.reshape(-1, shape[-1])[:, 0], share.reshape(-1, shape[-1])[:, 0]
        numbers, index, weights = between(rim, WIDTHS)
        forces = np.zeros((FORCES, *x.shape), dtype=complex)
        for faces in _FACES:
            of_part = np.maximum(1 - np.abs(share - faces), 0.0)
            if np.any(of_part):
                table = _table(self.poisson_ratio, self.shape, tuple(numbers.tolist()), faces, eccentricity)
                forces += weighed(table, index, of_part[:, None] * weights, x)
        return tuple(forces.reshape(FORCES, *shape))

    def bonded(self, x: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return the forces on the top plate without open rims, by its motion and the base's; x of shape (..., n)."""
        x = np.asarray(x, dtype=complex)
        flat = x.reshape(-1, x.shape[-1])
        alone = _table(self.poisson_ratio, self.shape, (0,), 0, 0.0)
        top, base, *_ = weighed(alone, np.zeros((len(flat), 1), dtype=int), np.ones((len(flat), 1)), flat)
        return top.reshape(x.shape), base.reshape(x.shape)


def between(rim: RealArray, widths: RealArray) -> tuple[NDArray[np.intp], NDArray[np.intp], RealArray]:
    """Return how forces of rims, shape (k,), follow from those of given widths; beyond these they are cut.

    Returns
    -------
    numbers : array of int, shape (m,)
        Of the widths that are needed.
    index : array of int, shape (k, 4)
        Which of these are the neighbours of a rim.
    weights : array, shape (k, 4)
        Of their forces.
    """
    rim = np.clip(rim, widths[0], widths[-1])
    first = np.clip(np.searchsorted(widths, rim, side="right") - 2, 0, len(widths) - _NEIGHBOURS)
    neighbours = first[:, None] + np.arange(_NEIGHBOURS)
    nodes = (widths[neighbours] - widths[first, None]) / widths[1]
    t = (rim - widths[first]) / widths[1]
    # a narrow rim takes its width squared (a crack at an edge): no linear term below the first width
    narrow, others = (interpolation_weights(t, nodes, powers) for powers in ((0, 2, 3, 4), (0, 1, 2, 3)))
    numbers, index = np.unique(neighbours, return_inverse=True)
    return numbers, index.reshape(-1, _NEIGHBOURS), np.where((rim < widths[1])[:, None], narrow, others)


def interpolation_weights(t: RealArray, nodes: RealArray, powers: Sequence[int]) -> RealArray:
    """Return the weights, shape (k, n), of values at n nodes in a sum of as many powers through them, at t.

    Nodes of shape (n,), or (k, n) where each t has nodes of its own.
    """
    of_nodes = np.swapaxes(nodes[..., None] ** np.array(powers, dtype=float), -1, -2)
    at = t[:, None] ** np.array(powers, dtype=float)
    return np.asarray(np.linalg.solve(of_nodes, at[..., None])[..., 0])


def weighed(forces: Forces, index: NDArray[np.intp], weights: RealArray, x: ComplexArray) -> ComplexArray:
    """Return the weighed sum of the forces of some rims, indices and weights of shape (k, m) each, shape (5, k, n)."""
    poles = forces.poles[index].reshape(len(x), -1)
    residues = np.swapaxes(weights[..., None, None] * forces.residues[index], 1, 2).reshape(len(x), FORCES, -1)
    # 1 / (pole - x) is (pole - conj(x)) / |pole - x|^2: in real arithmetic up to the sums
    inverse = 1 / ((poles[..., None] - x.real[:, None]) ** 2 + np.square(x.imag)[:, None])
    sums = np.concatenate([residues, residues * poles[:, None]], axis=1) @ inverse
    series = np.swapaxes(sums[:, FORCES:] - np.conj(x)[:, None] * sums[:, :FORCES], 0, 1)
    parts = (forces.static, forces.inertia, *np.moveaxis(forces.rest, -1, 0))
    static, inertia, r0, r1, r2 = (np.einsum("km,kmi->ik", weights, part[index])[..., None] for part in parts)
    return np.asarray(static - x * (inertia + x * (r0 + x * (r1 + x * r2) + series)))


def partly_bonded_disc(poisson_ratio: float, shape: float) -> PartlyBondedDisc:
    """Return the reduced model of a disc.

    Parameters
    ----------
    poisson_ratio : float
        -1 < nu < 0.5.
    shape : float
        S = radius / (2 thickness).

    Raises
    ------
    InputError
        For values out of range.
    """
    if not -1 < poisson_ratio < 0.5:
        raise InputError(f"poisson_ratio: {poisson_ratio:g} is not allowed; it must be above -1 and below 0.5")
    if not 0 < shape < np.inf:
        raise InputError(f"shape: {shape:g} is not allowed; it must be above 0")
    return PartlyBondedDisc(poisson_ratio, shape)


@lru_cache(maxsize=8192)
@shared
def _released(poisson_ratio: float, shape: float, number: int, faces: int) -> Forces:
    """Return the forces of the rim of a number, open at `faces`: 0 at the upper one, 1 at both, 2 at the lower one."""
    top, base = _FACES[faces]
    return _condensed(poisson_ratio, 2 * shape).released(top * RIMS[number], base * RIMS[number])


@lru_cache(maxsize=256)  # a search asks for the same rims again and again
def _table(poisson_ratio: float, shape: float, rims: tuple[int, ...], faces: int, eccentricity: float) -> Forces:
    """Return the forces of rims by their numbers on a plate of some eccentricity."""
    return on_plate([_released(poisson_ratio, shape, number, faces) for number in rims], eccentricity)


def on_plate(parts: Sequence[Forces], eccentricity: float) -> Forces:
    """Return the five forces on a plate of some eccentricity with several rims, these along the first axis."""
    static, inertia, rest, poles, residues = (
        np.array([getattr(part, field.name) for part in parts]) for field in fields(Forces)
    )
    # bent by 1, its face is turned by the eccentricity
    of_plate = np.eye(FORCES, len(_PAIRS))
    for pair, other, amount in ((2, 5, 1.0), (3, 6, 1.0), (4, 7, 2.0), (4, 8, eccentricity)):
        of_plate[pair, other] = amount * eccentricity
    return Forces(static @ of_plate.T, inertia @ of_plate.T, of_plate @ rest, poles, of_plate @ residues)


@dataclass(frozen=True)
class _Condensed:
    """The disc on few unknowns: modes with both faces held, and the displacements of the nodes of the faces.

    Attributes
    ----------
    stiffness, inertia : array, shape (n, n)
    place : array, shape (n,)
        Radius of the node of an unknown over that of the disc; NaN of a mode.
    is_top, is_axial : array of bool, shape (n,)
        Of the unknowns of faces.
    area : float
    """

    stiffness: RealArray
    inertia: RealArray
    place: RealArray
    is_top: NDArray[np.bool_]
    is_axial: NDArray[np.bool_]
    area: float

    def released(self, top: float, base: float) -> Forces:
        """Return the forces with an open rim at the upper and at the lower face, shares of the radius."""
        face = np.isfinite(self.place)
        rim = np.where(self.is_top, top, base)
        held = face & (self.place <= 1 - rim + 1e-9)
        free = np.flatnonzero(~held)
        on_top = held & self.is_axial & self.is_top
        across = held & ~self.is_axial & self.is_top
        rigid = np.stack([on_top, held & self.is_axial & ~self.is_top, on_top, across], axis=1).astype(float)
        rigid[on_top, 2] = deflection(self.place[on_top])
        rigid[across, 3] = slope(self.place[across])
        k, m = self.stiffness, self.inertia
        inner, inner_mass = k[np.ix_(free, free)], m[np.ix_(free, free)]
        factor = cho_factor(inner)
        poles, modes = eigh(inner, inner_mass, driver="gvd")  # all of them take a third of the time of a part
        lowest = poles[:_POLES], modes[:, :_POLES]
        return partial_fractions(k, m, rigid, free, partial(cho_solve, factor), lowest, self.area)


def partial_fractions(
    stiffness: Any,
    inertia: Any,
    rigid: RealArray,
    free: NDArray[np.intp],
    solve: Callable[[RealArray], RealArray],
    modes: tuple[RealArray, RealArray],
    area: float,
) -> Forces:
    """Return the forces on a disc's plates from its matrices.

    Parameters
    ----------
    stiffness, inertia : array or sparse matrix, shape (n, n)
    rigid : array, shape (n, 4)
        The unknowns that the plates hold, 0 elsewhere: moved with the top plate, with the base, with the top plate
        by `deflection`, and along its face by `slope`.
    free : array of int, shape (k,)
        The other unknowns.
    solve : callable
        Gives their displacements under forces, shape (k, m), by the stiffness among them.
    modes : (array, array), shapes (p,) and (k, p)
        The lowest poles, with their modes, of the free unknowns, the others being held.
    area : float
        Of a face.
    """
    values, shapes = modes
    inner_mass = inertia[free][:, free]
    rigid = rigid.copy()
    rigid[free] = -solve((stiffness @ rigid)[free])  # moved as the held parts are, slowly
    loads = (inertia @ rigid)[free]
    # only the modes' part in the motion by the plates counts
    shares = shapes.T @ loads
    static, whole = rigid.T @ (stiffness @ rigid), rigid.T @ (inertia @ rigid)
    on, by = np.transpose(_PAIRS)
    products = shares[:, on] * shares[:, by]
    sizes = np.abs(products)
    largest = np.max(sizes, axis=0)  # 0 of a face that is bonded in the part only that moves as one: it does not turn
    # what the series of a pole leaves out is residue x^3 / pole^3 / (pole - x)
    weight = np.max(sizes / np.where(largest > 0, largest, 1.0), axis=1) / values**4
    kept = np.sort(np.argsort(weight)[-_KEPT:])
    # sums of residue / pole^k over all other poles, without their eigenvectors: the kept modes are taken out of the
    # loads, since taken off the sums those of low poles would leave no digits of the others
    kept_modes = shapes[:, kept]
    others = loads - inner_mass @ (kept_modes @ shares[kept])
    once = solve(others)
    once -= kept_modes @ (kept_modes.T @ (inner_mass @ once))
    twice = solve(inner_mass @ once)
    rest = np.stack([others.T @ once, others.T @ twice, once.T @ (inner_mass @ twice)], -1)
    parts = *(sums[on, by] for sums in (static, whole, rest)), products[kept].T
    static_all, inertia_all, rest_all, residues = (part / area for part in parts)
    return Forces(static_all, inertia_all, rest_all, values[kept], residues)


def deflection(place: RealArray) -> RealArray:
    """Return how far a unit force at a radius bends the centre of a free plate, in units of ``R^2 / (8 pi D)``.

    Relative to the plate's mean, its inertia being spread over its area; by reciprocity the static deflection under a
    force in the centre, S. P. Timoshenko & S. Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed. 1959, ch. 3.
    Poisson's ratio of the plate is 0.3 (with 0.2 to 0.4 the outermost value differs by 6 %).

    Parameters
    ----------
    place : array
        Radius over that of the plate, 0 to 1; at 0 the mean over the part `1 - WIDEST_RIM`, which always is bonded.
    """
    square = np.asarray(place, dtype=float) ** 2
    core = (1 - WIDEST_RIM) ** 2
    a, c = _SAG, CENTRE_DEFLECTION
    with np.errstate(divide="ignore", invalid="ignore"):
        value = 0.5 * square * np.log(square) + a * square - square**2 / 8 + c
    mean = 0.25 * core * np.log(core) - core / 8 + a * core / 2 - core**2 / 24 + c
    return np.asarray(np.where(square > 0, value, mean))


def slope(place: RealArray) -> RealArray:
    """Return the derivative of `deflection` by the radius over that of the plate, above 0."""
    return np.asarray(place * (2 * np.log(place) + 1 + 2 * _SAG) - 0.5 * np.power(place, 3))


@lru_cache(maxsize=16)
@shared
def _condensed(poisson_ratio: float, radius: float) -> _Condensed:
    """Return the disc on few unknowns, from its upper half in symmetric and in antisymmetric motion.

    With t of the upper face and b of the lower one, mirrored, these halves have ``(t + b) / 2`` and ``(t - b) / 2``.
    """
    half = _half(radius)
    whole = matrices(half.basis, poisson_ratio)
    parts = [half.condensed(whole, is_symmetric=even) for even in (True, False)]
    n = len(half.place)  # unknowns of a face
    mirror = np.where(half.is_axial, -1.0, 1.0)
    size = 2 * (_INNER + n)
    both = np.zeros((2, size, size))
    for number, (sign, part) in enumerate(zip((1.0, -1.0), parts, strict=True)):
        change = np.zeros((_INNER + n, size))
        change[:_INNER, number * _INNER : (number + 1) * _INNER] = np.eye(_INNER)
        change[_INNER:, 2 * _INNER : 2 * _INNER + n] = 0.5 * np.eye(n)
        change[_INNER:, 2 * _INNER + n :] = 0.5 * sign * np.diag(mirror)
        both += 2 * (change.T @ part @ change)
    modes = np.zeros(2 * _INNER, dtype=bool)
    return _Condensed(
        both[0],
        both[1],
        np.concatenate([np.full(2 * _INNER, np.nan), half.place, half.place]),
        np.concatenate([modes, np.ones(n, dtype=bool), np.zeros(n, dtype=bool)]),
        np.concatenate([modes, half.is_axial, half.is_axial]),
        np.pi * radius**2,
    )


@dataclass(frozen=True)
class _Half:
    """The upper half of a disc.

    Attributes
    ----------
    basis : skfem.Basis
    face : sparse matrix, shape (2 n_nodes, n)
        Motions of the face, one per unknown: each node of a rim that may open, and all nodes further in as one.
    place : array, shape (n,)
        Radius of the node over that of the disc.
    is_axial : array of bool, shape (n,)
    """

    basis: Any
    face: Sparse
    place: RealArray
    is_axial: NDArray[np.bool_]

    def condensed(self, whole: tuple[Sparse, Sparse], *, is_symmetric: bool) -> RealArray:
        """Return stiffness and inertia on modes with the face held and the unknowns of the face, shape (2, n, n).

        From those of all unknowns (`matrices`).
        """
        r, z = self.basis.doflocs
        middle, off_axis, below = np.isclose(z, 0), r > 1e-9 * r.max(), z < _HALF * (1 - 1e-9)
        radial, axial = (below & off_axis, below & ~middle) if is_symmetric else (below & off_axis & ~middle, below)
        i = np.flatnonzero(np.concatenate([radial, axial]))
        stiff, inertia = whole
        k, m = csc_matrix(stiff[i][:, i]), csc_matrix(inertia[i][:, i])
        solver = splu(k, permc_spec="MMD_AT_PLUS_A")
        inverse = LinearOperator(k.shape, matvec=solver.solve, dtype=float)
        # a given start: the same result every time
        _, modes = eigsh(k, k=_MODES, M=m, sigma=0.0, OPinv=inverse, v0=np.ones(len(i)))
        by_face = self.face.toarray()
        by_face[i] = -solver.solve((stiff @ self.face)[i].toarray())
        moved = [solver.solve((inertia @ (by_face @ self.is_axial))[i])]
        for _ in range(_MOMENTS - 1):
            moved.append(solver.solve(m @ (moved[-1] / np.linalg.norm(moved[-1]))))
        motions = np.zeros((len(by_face), _INNER + by_face.shape[1]))
        motions[i, :_INNER], _ = np.linalg.qr(np.column_stack([modes, *moved]))
        motions[:, _INNER:] = by_face
        # motions by the face are in equilibrium inside: no motion with the face held does work against their stress
        inside, stiffness = motions[i, :_INNER], np.zeros((motions.shape[1],) * 2)
        stiffness[:_INNER, :_INNER] = inside.T @ (k @ inside)
        stiffness[_INNER:, _INNER:] = (self.face.T @ stiff) @ by_face
        return np.array([stiffness, motions.T @ (inertia @ motions)])


def matrices(basis: Any, poisson_ratio: float) -> tuple[Sparse, Sparse]:
    """Return stiffness and inertia of a solid of unit modulus and density on a basis: radial, then axial unknowns."""
    radial, shear, axial = solid_parts(operators(basis), isotropic(poisson_ratio))
    unit = mass(basis)
    stiff = csc_matrix(blocks(2, radial) + blocks(2, shear) + blocks(2, axial))
    return stiff, csc_matrix(blocks(2, {(0, 0): unit, (1, 1): unit}))


def _half(radius: float) -> _Half:
    core = 1 - WIDEST_RIM
    size = radius / _ACROSS
    rim = np.linspace(core, 1, round(WIDEST_RIM * _ACROSS) + 1)
    radii = np.concatenate([np.linspace(0, core, _CORE + 1)[:-1], rim]) * radius
    coarse = min(_HALF / _ALONG, radius / _CORE)
    heights = graded(0.0, _HALF, coarse, coarse, min(size, coarse))
    basis = basis_of(Section(radii, heights, (Slab("sample", 0.0, _HALF, coarse, size),)).mesh)
    r, z = basis.doflocs
    on_face, n = np.isclose(z, _HALF), len(r)
    nodes = np.flatnonzero(on_face & (r > radius * (core + 1e-9)))
    inner = np.zeros((2 * n, 1))
    inner[n + np.flatnonzero(on_face & (r < radius * (core + 1e-9)))] = 1.0
    unknowns = np.concatenate([nodes, n + nodes])
    face = np.zeros((2 * n, len(unknowns)))
    face[unknowns, np.arange(len(unknowns))] = 1.0
    return _Half(
        basis,
        csc_matrix(np.concatenate([inner, face], axis=1)),
        np.concatenate([[0.0], r[nodes], r[nodes]]) / radius,
        np.concatenate([[True], unknowns >= n]),
    )
