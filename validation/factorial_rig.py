"""Transmissibilities of the finite-element rig for the factorial: reduced where that pays, one by one elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from multilayer.arrays import BoolArray, ComplexArray, RealArray
from multilayer.rig.assembly import Assembly, Parameters, assemble, coefficients
from multilayer.rig.mesh import MOST_ELEMENTS, Section
from multilayer.rig.reduced import grow
from multilayer.rig.solve import full_solution
from multilayer.rig.two_plate import TwoPlateRig
from validation.factorial_cases import (
    LINES,
    PERIOD,
    PLATE_DENSITY,
    PLATE_MODULUS,
    PLATE_POISSON,
    PLATE_THICKNESS,
    RADIUS,
    Points,
    Task,
)

# Rod waves per metre at the tone, from and below; resolution of the mesh. Each range has a reduced basis of its own.
_REDUCED = ((0.0, 30.0, 1.0), (30.0, 62.0, 0.7), (62.0, 90.0, 0.5))
# Beyond them the sample is many wavelengths long, and a basis would take about as many full solutions as there are
# points: each is solved by itself.
_FULL, _LONG = 90.0, 160.0
_HALF, _FINE, _LEAST = 0.5, 0.4, 0.3  # resolution up to `_LONG`; beyond it for nu = 0, and for any nu
_FEW = 40  # points that are solved one by one
_ROUND = 16
_TOLERANCE = 5e-7  # the basis is cut to its smallest on 16 points; others may be worse by a hundred
_CHECKS, _MESH_CHECKS = 4, 2
_DENSITY = 100.0  # kg/m3 that the rigs are built with; the cases' are relative to it


@dataclass(frozen=True)
class Response:
    """Transmissibilities of a task, shape as in `Points`, and their errors as in `Outcome`."""

    values: ComplexArray
    reduction: list[tuple[float, float]]
    mesh: list[tuple[float, float, float]]


@dataclass(frozen=True)
class Part:
    """Some points of a task on one mesh."""

    rig: TwoPlateRig
    section: Section
    points: Points
    inside: BoolArray

    @classmethod
    def of(cls, task: Task, points: Points, inside: BoolArray, resolution: float) -> Part:
        """Return the points `inside`, on a mesh for the shortest of their waves."""
        rig = TwoPlateRig(
            RADIUS, task.thickness, _DENSITY, task.poisson_ratio, PLATE_THICKNESS, PLATE_DENSITY, PLATE_MODULUS,
            PLATE_POISSON, resolution=resolution,
        )  # fmt: skip
        most = float(points.waves[inside].max()) * (1 + LINES[-1] / PERIOD)
        section = rig.section(most * (task.modulus / _DENSITY) ** 0.5, task.modulus)
        return cls(rig, section, points, inside)

    def coefficients(self, assembly: Assembly) -> ComplexArray:
        """Return the coefficients of the points, shape (n_terms, n_points)."""
        chosen, p = self.inside, self.points
        at = Parameters(p.frequency[chosen], p.modulus[chosen], p.density[chosen] / _DENSITY)
        return coefficients(self.rig, assembly.names, at)

    def solve(self, rng: np.random.Generator) -> tuple[ComplexArray, list[tuple[float, float]]]:
        """Return the transmissibilities of the points, and checks of them."""
        assembly = assemble(self.rig, self.section)
        values = self.coefficients(assembly)
        reduced = self.points.waves[self.inside].max() < _FULL and values.shape[1] > _FEW
        return _reduced(assembly, values, rng) if reduced else (full_solution(assembly, values), [])

    def halved(self, index: int) -> complex | None:
        """Return the transmissibility of one point with every interval halved; None beyond the finest mesh."""
        section = self.section.halved()
        if section.n_elements > MOST_ELEMENTS:
            return None
        assembly = assemble(self.rig, section)
        return complex(full_solution(assembly, self.coefficients(assembly)[:, index : index + 1])[0])


def _reduced(
    assembly: Assembly, values: ComplexArray, rng: np.random.Generator
) -> tuple[ComplexArray, list[tuple[float, float]]]:
    order = rng.permutation(values.shape[1])
    used = 0

    def rounds() -> Iterator[ComplexArray]:
        nonlocal used
        for used in range(_ROUND, len(order) + _ROUND, _ROUND):
            yield values[:, order[used - _ROUND : used]]

    _, (basis,), _ = grow([assembly], rounds(), _TOLERANCE)
    found = basis.solve(values)
    # points that the basis has not seen; where it has seen all, the last
    checked = order[used:][:_CHECKS] if used < len(order) else order[-_CHECKS:]
    truth = full_solution(assembly, values[:, checked])
    return found, [(float(abs(t)), float(abs(f - t))) for f, t in zip(found[checked], truth, strict=True)]


def respond(task: Task) -> Response:
    """Return the transmissibilities of all points of a task."""
    points = Points.of(task)
    values = np.empty(points.waves.shape, dtype=complex)
    rng = np.random.default_rng(0)
    parts, reduction = list(_parts(task, points)), []
    for part in parts:
        values[part.inside], checks = part.solve(rng)
        reduction += checks
    return Response(values, reduction, _mesh_errors(parts, values, rng))


def _parts(task: Task, points: Points) -> Iterator[Part]:
    for low, high, resolution in _REDUCED:
        inside = (points.waves >= low) & (points.waves < high)
        if inside.any():
            yield Part.of(task, points, inside, resolution)
    for waves in np.unique(np.round(points.waves[points.waves >= _FULL], 6)):
        resolution = _HALF if waves < _LONG else _coarse(task.poisson_ratio)
        yield Part.of(task, points, np.isclose(points.waves, waves), resolution)


def _coarse(poisson_ratio: float) -> float:
    """Return the resolution where the sample is long: what matters there is the longitudinal wave.

    Its length over that of the shear wave, which meshes go by, grows with Poisson's ratio. With 0.4 for nu = 0 an
    apparent modulus is off by 0.4 %.
    """
    longer = ((1 - poisson_ratio) / (1 - 2 * poisson_ratio)) ** 0.5
    return max(_FINE / float(longer), _LEAST)


def _mesh_errors(parts: list[Part], values: ComplexArray, rng: np.random.Generator) -> list[tuple[float, float, float]]:
    found: list[tuple[float, float, float]] = []
    sizes: RealArray = np.array([part.inside.sum() for part in parts], dtype=float)
    for k in rng.choice(len(parts), _MESH_CHECKS, p=sizes / sizes.sum()):
        part = parts[k]
        index = int(rng.integers(int(sizes[k])))
        value = complex(values[part.inside][index])
        fine = part.halved(index)
        if fine is not None:
            found.append((float(part.points.waves[part.inside][index]), abs(fine), abs(fine - value) / abs(fine)))
    return found
