"""A reduced basis: thousands of transmissibilities from a few dozen full solutions.

The equations are a sum of constant matrices (see `assembly`), so a Galerkin projection onto solutions at some points
holds for any other: G. Rozza, D. B. P. Huynh & A. T. Patera, Arch. Comput. Methods Eng. 15 (2008) 229-275. The basis
holds solutions of the problem and of its dual (a load where the plate's motion is read), which squares the error of the
reading (N. A. Pierce & M. B. Giles, SIAM Rev. 42 (2000) 247-264); real and imaginary parts are separate vectors, so
that stiffness stays positive. Points are added in rounds; the error of a basis is estimated from the full solutions of
the next round, before they join it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.errors import InputError, MultilayerError
from multilayer.rig.assembly import Assembly, Parameters, assemble, coefficients, sample_stiffness
from multilayer.rig.fractions import LossyFractions, PartialFractions
from multilayer.rig.operators import Sparse
from multilayer.rig.solve import Combination

if TYPE_CHECKING:
    from multilayer.rig.two_plate import TwoPlateRig

FLOOR = 1e-4  # transmissibilities below this count as this in relative errors
_ROUND = 16
_MOST_ROUNDS = 24
_RANK = 1e-12  # singular values of the basis kept, relative
_CHUNK = 4_000_000  # numbers in a batch of small matrices
_LEAST_LOSS = 0.01
_REMEMBERED = 64  # sets of frequencies
_ABOUT = 0.3  # loss factor of the modulus about which a lossy rig is expanded
SAMPLE = ("sample_0", "sample_1", "sample_2")  # names of the sample's stiffness, by power of the thickness
Solid: TypeAlias = tuple[float, float]  # Poisson's ratio and E_r/E_z
Fractions: TypeAlias = PartialFractions | LossyFractions


@dataclass(frozen=True)
class ReducedBasis:
    """The projected equations.

    Attributes
    ----------
    matrices : array, shape (n_terms, n, n)
    loads : array, shape (n_terms, n)
    reading : array, shape (n,)
    """

    matrices: RealArray
    loads: RealArray
    reading: RealArray

    @classmethod
    def of(cls, assembly: Assembly, vectors: RealArray) -> ReducedBasis:
        """Return the projection onto orthonormal vectors, shape (n_unknowns, n)."""
        return cls(projected(assembly.matrices, vectors), assembly.loads @ vectors, assembly.reading @ vectors)

    def first(self, n: int) -> ReducedBasis:
        """Return the projection onto the first vectors."""
        return ReducedBasis(self.matrices[:, :n, :n], self.loads[:, :n], self.reading[:n])

    def solve(self, values: ComplexArray) -> ComplexArray:
        """Return the transmissibility at points of coefficients `values`, shape (n_terms, n_points)."""
        size = max(1, _CHUNK // self.matrices[0].size)
        parts = [self._solve(values[:, i : i + size]) for i in range(0, values.shape[1], size)]
        return np.concatenate(parts) if parts else np.empty(0, dtype=complex)

    def _solve(self, values: ComplexArray) -> ComplexArray:
        system, loads = self.combined(values)
        moved = np.linalg.solve(system, loads[..., None])
        return np.asarray(1 + moved[..., 0] @ self.reading)

    def combined(self, values: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return matrices and loads at points of coefficients `values`, shapes (n_points, n, n) and (n_points, n)."""
        n_terms, n = self.loads.shape
        return (values.T @ self.matrices.reshape(n_terms, -1)).reshape(-1, n, n), values.T @ self.loads


def relative_error(values: ComplexArray, truth: ComplexArray) -> float:
    """Return the largest error of `values`, relative to transmissibilities of at least `FLOOR`."""
    return float(np.max(np.abs(values - truth) / np.maximum(np.abs(truth), FLOOR)))


def projected(matrices: Sequence[Sparse], vectors: RealArray) -> RealArray:
    """Return matrices in the span of orthonormal vectors, shape (len(matrices), n, n)."""
    return np.array([vectors.T @ (matrix @ vectors) for matrix in matrices])


def span(snapshots: RealArray) -> RealArray:
    """Return orthonormal vectors of the span of snapshots, shape (n_unknowns, n): those most in use first."""
    scaled = snapshots / np.linalg.norm(snapshots, axis=0)
    vectors, sizes, _ = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray(vectors[:, sizes > _RANK * sizes[0]])


def grow(
    assemblies: Sequence[Assembly], rounds: Iterator[ComplexArray], tolerance: float
) -> tuple[RealArray, list[ReducedBasis], float]:
    """Return vectors that reach `tolerance`, the projections onto them, and their estimated largest relative error.

    Parameters
    ----------
    assemblies : sequence of Assembly
        Of rigs on one mesh that differ in their matrices; points are dealt out to them in turn.
    rounds : iterator of complex array, shape (n_terms, n_points)
        Coefficients of the points to solve, round by round; when they end the last error stands.
    tolerance : float

    Raises
    ------
    MultilayerError
        When many rounds do not reach it.
    """
    full = [Combination(assembly) for assembly in assemblies]
    snapshots: list[RealArray] = []
    vectors, bases, error = np.empty((0, 0)), list[ReducedBasis](), np.inf
    for number, values in enumerate(rounds):
        shares = [values[:, i :: len(full)] for i in range(len(full))]
        exact = [
            np.array([solver.primal_and_dual(column) for column in share.T])
            for solver, share in zip(full, shares, strict=True)
        ]
        truths = [
            np.asarray(1 + part[:, 0] @ assembly.reading, dtype=complex)
            for part, assembly in zip(exact, assemblies, strict=True)
        ]

        error = _largest_error(bases, shares, truths) if bases else np.inf
        if error < tolerance:
            bases = _trimmed(bases, shares, truths, tolerance)
            return vectors[:, : len(bases[0].reading)], bases, _largest_error(bases, shares, truths)
        snapshots += [part.reshape(-1, part.shape[-1]).T for part in exact]
        if number == _MOST_ROUNDS:
            raise MultilayerError(f"the reduced basis of the rig stays at an error of {error:.1g}; narrow its range")
        both = np.concatenate(snapshots, axis=1)
        vectors = span(np.concatenate([both.real, both.imag], axis=1))
        bases = [ReducedBasis.of(assembly, vectors) for assembly in assemblies]
    return vectors, bases, error


def _largest_error(
    bases: Sequence[ReducedBasis], shares: Sequence[ComplexArray], truths: Sequence[ComplexArray]
) -> float:
    """Return the largest error of all bases, each at its points of known transmissibility."""
    triples = zip(bases, shares, truths, strict=True)
    return max(relative_error(basis.solve(values), truth) for basis, values, truth in triples)


def _trimmed(
    bases: Sequence[ReducedBasis], shares: Sequence[ComplexArray], truths: Sequence[ComplexArray], tolerance: float
) -> list[ReducedBasis]:
    """Return the bases with as few of the first vectors as keep the error below `tolerance`."""
    low, high = 0, len(bases[0].reading)  # the error is above at the first, below at the second
    while high - low > 1:
        middle = (low + high) // 2
        if _largest_error([basis.first(middle) for basis in bases], shares, truths) < tolerance:
            high = middle
        else:
            low = middle
    return [basis.first(high) for basis in bases]


def reduce_along(rig: TwoPlateRig, assembly: Assembly, at: Parameters, tolerance: float = 1e-5) -> ComplexArray:
    """Return the transmissibility at many given points, by a basis made from some of them."""
    values = coefficients(rig, assembly.names, at)
    n = values.shape[1]
    order = np.argsort(_radical_inverse(n))
    rounds = (values[:, order[i : i + _ROUND]] for i in range(0, n, _ROUND))
    _, (basis,), _ = grow([assembly], rounds, tolerance)
    return basis.solve(values)


def _radical_inverse(n: int) -> RealArray:
    """Return van der Corput's sequence: taken in its order, indices fill their range ever more densely."""
    index, inverse, share = np.arange(1, n + 1), np.zeros(n), 0.5
    while np.any(index):
        inverse += share * (index % 2)
        index //= 2
        share /= 2
    return inverse


@dataclass(frozen=True)
class Ranges:
    """Where a reduced rig holds: from lowest to highest value of each parameter.

    Attributes
    ----------
    frequency : tuple of float
        Hz.
    modulus : tuple of float
        Storage modulus, Pa.
    loss_factor : tuple of float
    density, thickness, plate_mass : tuple of float
        Relative to the rig's.
    """

    frequency: tuple[float, float]
    modulus: tuple[float, float]
    loss_factor: tuple[float, float] = (0.02, 1.0)
    density: tuple[float, float] = (1.0, 1.0)
    thickness: tuple[float, float] = (1.0, 1.0)
    plate_mass: tuple[float, float] = (1.0, 1.0)

    def draw(self, n: int, skip: int) -> Parameters:
        """Return n points of a Sobol sequence, even in frequency and in slowness; `skip` seeds its scrambling."""
        from scipy.stats import qmc

        u = qmc.Sobol(6, scramble=True, rng=np.random.default_rng(skip)).random(n).T
        # the shortest wavelengths are the hardest to represent: evenly spaced moduli would have too few of them
        slow, fast = (e**-0.5 for e in self.modulus)
        storage = (slow + (fast - slow) * u[1]) ** -2
        low, high = (max(loss, _LEAST_LOSS) for loss in self.loss_factor)
        loss = low * (high / low) ** u[2]
        rest = [
            a + (b - a) * v for (a, b), v in zip((self.density, self.thickness, self.plate_mass), u[3:], strict=True)
        ]
        first, last = self.frequency
        return Parameters(first + (last - first) * u[0], storage * (1 + 1j * loss), *rest)


@dataclass(frozen=True)
class ReducedRig:
    """A rig's transmissibility over ranges of frequency, modulus, density, thickness and plate mass.

    Attributes
    ----------
    rig : TwoPlateRig
    names : tuple of str
        Of the terms.
    basis : ReducedBasis
    ranges : Ranges
    error : float
        Largest error against full solutions at points drawn within the ranges, relative to the modulus of the
        transmissibility (that below 1e-4 counts as 1e-4).
    constants : array, shape (3, 5, n, n), optional
        The sample's stiffness by power of the thickness and elastic constant, for `with_solid`; see `of_solids`.
    """

    rig: TwoPlateRig
    names: tuple[str, ...]
    basis: ReducedBasis
    ranges: Ranges
    error: float
    constants: RealArray | None = None
    _fractions: dict[tuple[Any, ...], Fractions] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def build(cls, rig: TwoPlateRig, ranges: Ranges, tolerance: float = 1e-5) -> ReducedRig:
        """Return the reduced model of a rig.

        Raises
        ------
        InputError
            When the shortest wavelength is too short for the finest mesh.
        MultilayerError
            When the tolerance is not reached.
        """
        section = rig.section(ranges.frequency[1], _softest(ranges))
        assembly = assemble(rig, section)
        rounds = (coefficients(rig, assembly.names, ranges.draw(_ROUND, k)) for k in count())
        _, (basis,), error = grow([assembly], rounds, tolerance)
        return cls(rig, assembly.names, basis, ranges, error)

    @classmethod
    def of_solids(
        cls, rig: TwoPlateRig, ranges: Ranges, solids: Sequence[Solid], tolerance: float = 1e-5
    ) -> ReducedRig:
        """Return the reduced model of a rig that holds for other samples of the same size, too.

        Parameters
        ----------
        rig : TwoPlateRig
        ranges : Ranges
        solids : sequence of (float, float)
            Poisson's ratio and E_r/E_z of samples that the basis is made for, besides the rig's. Between these it
            holds as well: the equations are linear in the elastic constants.
        tolerance : float

        Raises
        ------
        InputError, MultilayerError
            As `build`.
        """
        section = rig.section(ranges.frequency[1], _softest(ranges))
        assemblies = [assemble(one, section) for one in (rig, *(_of_solid(rig, solid) for solid in solids))]
        names = assemblies[0].names
        rounds = (coefficients(rig, names, ranges.draw(2 * _ROUND, k)) for k in count())
        vectors, bases, error = grow(assemblies, rounds, tolerance)
        constants = np.array([projected(parts, vectors) for parts in sample_stiffness(rig, section)])
        return cls(rig, names, bases[0], ranges, error, constants)

    def with_solid(self, solid: Solid) -> ReducedRig:
        """Return the reduced model with another sample, for one made by `of_solids`.

        Parameters
        ----------
        solid : (float, float)
            Poisson's ratio and E_r/E_z.
        """
        assert self.constants is not None, "made by `of_solids`"
        rig, matrices = _of_solid(self.rig, solid), self.basis.matrices.copy()
        for power, name in enumerate(SAMPLE):
            matrices[self.names.index(name)] = np.tensordot(rig.elastic_constants, self.constants[power], 1)
        return replace(self, rig=rig, basis=replace(self.basis, matrices=matrices), _fractions={})

    def transmissibility(
        self,
        frequency: ArrayLike,
        modulus: ArrayLike,
        density: ArrayLike = 1.0,
        thickness: ArrayLike = 1.0,
        plate_mass: ArrayLike = 1.0,
        *,
        extrapolate: bool = False,
    ) -> ComplexArray:
        """Return top over base motion; all arguments broadcast.

        Parameters
        ----------
        frequency : array
            Hz.
        modulus : complex array
            Young's modulus of the sample, Pa.
        density, thickness, plate_mass : array
            Relative to those of the rig.
        extrapolate : bool
            Answer beyond the ranges, too: passively, but of unknown accuracy. For the steps of a search.

        Raises
        ------
        InputError
            Without `extrapolate`, for frequencies or moduli beyond the ranges by more than a thousandth.
        """
        shift = (density, thickness, plate_mass)
        if not extrapolate:
            self._check(np.asarray(frequency, dtype=float), np.asarray(modulus))
        fractions = self._fractions_for(frequency, modulus, shift)
        if fractions is not None:
            return fractions(np.asarray(modulus, dtype=complex))
        given = (frequency, modulus, *shift)
        f, e, *rest = np.broadcast_arrays(*(np.asarray(values) for values in given))
        at = Parameters(f.ravel(), e.ravel(), *(values.ravel() for values in rest))
        return self.basis.solve(coefficients(self.rig, self.names, at)).reshape(f.shape)

    def _check(self, frequency: RealArray, modulus: ComplexArray) -> None:
        for name, values, (low, high), unit in (
            ("frequency", frequency, self.ranges.frequency, "Hz"),
            ("modulus", modulus.real, self.ranges.modulus, "Pa"),
        ):
            if values.size and (values.min() < 0.999 * low or values.max() > 1.001 * high):
                reached = f"{values.min():.4g} to {values.max():.4g} {unit}"
                raise InputError(f"{name}: {reached} leaves the reduced rig's range, {low:.4g} to {high:.4g} {unit}")

    def _fractions_for(
        self, frequency: ArrayLike, modulus: ArrayLike, shift: tuple[ArrayLike, ...]
    ) -> Fractions | None:
        """Return the partial fractions at these frequencies.

        They pay where many moduli meet the same frequencies, else None is returned; they are kept for later calls.
        """
        f = np.asarray(frequency, dtype=float)
        if f.ndim != 1 or np.shape(modulus)[-1:] != f.shape or any(np.ndim(v) for v in shift):
            return None
        scales = tuple(float(np.asarray(v)) for v in shift)
        key = (f.tobytes(), *scales)
        if key not in self._fractions:
            if np.size(modulus) <= f.size:
                return None
            fractions = self._part_of_known(f, scales) or self._expand(f, *scales)
            if len(self._fractions) >= _REMEMBERED:
                self._fractions.pop(next(iter(self._fractions)))
            self._fractions[key] = fractions
        return self._fractions[key]

    def _part_of_known(self, frequency: RealArray, scales: tuple[float, ...]) -> Fractions | None:
        """Return the partial fractions at frequencies that are among those of an earlier call, if they are."""
        for (raw, *others), fractions in self._fractions.items():
            known = np.frombuffer(raw)
            if tuple(others) == scales and np.isin(frequency, known).all():
                order = np.argsort(known)
                return fractions.at(order[np.searchsorted(known, frequency, sorter=order)])
        return None

    @property
    def _lossless(self) -> bool:
        """Whether nothing but the sample's frame is lossy."""
        rig = self.rig
        is_plain = not (rig.adhesive_thickness or rig.has_flank or rig.attached_mass is not None)
        return is_plain and rig.porosity is None

    def _expand(self, frequency: RealArray, density: float, thickness: float, plate_mass: float) -> Fractions:
        at = Parameters(frequency, 0.0, density, thickness, plate_mass)
        rest, loads = self.basis.combined(coefficients(self.rig, self.names, at))
        of_modulus = dict(zip(SAMPLE, (thickness, 1.0, 1 / thickness), strict=True))
        stiffness = np.tensordot([of_modulus.get(name, 0.0) for name in self.names], self.basis.matrices, 1)
        if self._lossless:
            return PartialFractions.of(stiffness, rest.real, loads.real, self.basis.reading)
        centre = complex(np.sqrt(np.prod(self.ranges.modulus)) * (1 + _ABOUT * 1j))
        return LossyFractions.of(stiffness, rest, loads, self.basis.reading, centre)


def _softest(ranges: Ranges) -> float:
    """Return the modulus of the shortest wavelength, Pa."""
    return ranges.modulus[0] * min(1.0, *ranges.density) / max(ranges.density)


def _of_solid(rig: TwoPlateRig, solid: Solid) -> TwoPlateRig:
    return rig.replaced(poisson_ratio=solid[0], transverse_ratio=solid[1])
