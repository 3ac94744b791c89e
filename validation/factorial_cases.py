"""The numerical validation of Bonfiglio & Pompoli 2015, Section 3.2: its cases, and what is found for each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np

from multilayer.arrays import ComplexArray, IndexArray, RealArray
from multilayer.errors import InputError

RADIUS, PLATE_THICKNESS, PLATE_DENSITY, PLATE_MODULUS, PLATE_POISSON = 0.0225, 1e-3, 7850.0, 2.1e11, 0.3  # SI
CYCLES, PERIOD = 10, 25  # of the burst, and from one burst to the next
LINES: IndexArray = np.arange(-4, 5)  # of the spectrum about the tone, in steps of frequency / PERIOD: the main lobe
COLUMNS = (
    "frequency", "density", "loss_factor", "transmissibility", "storage", "loss", "misfit", "storage_best",
    "loss_best", "misfit_best", "misfit_next", "plausible", "missed", "at_bound", "delta_tof", "delta_level",
    "gain_storage", "gain_loss",
)  # fmt: skip


@dataclass(frozen=True)
class Design:
    """A full factorial; Table 2 of the paper by default.

    Attributes
    ----------
    frequencies : tuple of float
        Of the bursts, Hz.
    moduli : tuple of float
        Storage moduli, Pa.
    poisson_ratios, loss_factors : tuple of float
    densities : tuple of float
        kg/m3.
    thicknesses : tuple of float
        m.
    """

    frequencies: tuple[float, ...] = (100.0, 300.0, 500.0, 1000.0, 1500.0, 2000.0)
    moduli: tuple[float, ...] = (1e4, 1e5, 1e6, 1e8)
    poisson_ratios: tuple[float, ...] = (0.0, 0.1, 0.2, 0.3, 0.35, 0.4, 0.45)
    loss_factors: tuple[float, ...] = (0.1, 0.2, 0.4, 0.8)
    densities: tuple[float, ...] = (50.0, 100.0, 200.0, 400.0)
    thicknesses: tuple[float, ...] = (0.010, 0.025, 0.050)

    @property
    def tasks(self) -> list[Task]:
        """One task per geometry and storage modulus, those that take longest first."""
        found = [Task(self, *values) for values in product(self.moduli, self.thicknesses, self.poisson_ratios)]
        return sorted(found, key=lambda task: (task.modulus, -task.thickness))

    @property
    def n_cases(self) -> int:
        """Number of cases."""
        return len(self.tasks) * len(self.frequencies) * len(self.densities) * len(self.loss_factors)


@dataclass(frozen=True)
class Task:
    """The cases of one Poisson's ratio, thickness (m) and storage modulus (Pa)."""

    design: Design
    modulus: float
    thickness: float
    poisson_ratio: float

    @property
    def key(self) -> tuple[float, float, float]:
        """What tells the tasks of a design apart."""
        return self.modulus, self.thickness, self.poisson_ratio


@dataclass(frozen=True)
class Points:
    """Where the transmissibility of a task is wanted, arrays of shape (frequency, density, loss factor, line).

    Attributes
    ----------
    frequency, density : array
        Hz and kg/m3.
    modulus : complex array
        Pa; constant within a burst.
    waves : array
        Rod waves per metre at the burst's frequency, ``f sqrt(rho / E1)``.
    """

    frequency: RealArray
    density: RealArray
    modulus: ComplexArray
    waves: RealArray

    @classmethod
    def of(cls, task: Task) -> Points:
        """Return the spectral lines of all bursts of a task."""
        design = task.design
        axes = (design.frequencies, design.densities, design.loss_factors, 1 + LINES / PERIOD)
        tone, density, loss, line = np.meshgrid(*axes, indexing="ij")
        waves = tone * np.sqrt(density / task.modulus)
        return cls(tone * line, density, np.asarray(task.modulus * (1 + 1j * loss)), waves)


@dataclass(frozen=True)
class Outcome:
    """What a task gives; plain numbers, so that it is written and read as JSON.

    Attributes
    ----------
    key : tuple of float
        See `Task.key`.
    seconds : float
        Processor time.
    cases : list
        A row of `COLUMNS` per case: the burst's frequency (Hz), density (kg/m3) and loss factor; the modulus of the
        transmissibility at the tone; true over found storage and loss modulus and the misfit, for the plausible
        solution nearest to the truth and for the best one; the lowest misfit of the others than the former; how many
        are plausible; whether the search of a fit missed the best; of the solution nearest to the truth: whether it
        lies on a bound, its differences of eq. (10) (s and dB), and the standard deviations of ln E1 and ln E2 per
        relative noise.
    reduction : list of (float, float)
        Transmissibility and error of the reduced basis, at points drawn.
    mesh : list of (float, float, float)
        Rod waves per metre, transmissibility, and its relative change with every interval halved, at points drawn.
    """

    key: tuple[float, float, float]
    seconds: float
    cases: list[tuple[float, ...]]
    reduction: list[tuple[float, float]] = field(default_factory=list)
    mesh: list[tuple[float, float, float]] = field(default_factory=list)

    @classmethod
    def read(cls, plain: dict[str, Any]) -> Outcome:
        """Return an outcome from what JSON has made of it."""
        return cls(**{**plain, "key": tuple(plain["key"])})


@dataclass(frozen=True)
class Table:
    """All cases by column: those of `COLUMNS`, and `modulus`, `thickness`, `poisson_ratio`."""

    columns: dict[str, RealArray]

    @classmethod
    def of(cls, outcomes: Sequence[Outcome]) -> Table:
        """Return the cases of several tasks, one after the other."""
        if not outcomes:
            raise InputError("there is no result")
        rows = np.array([(*outcome.key, *case) for outcome in outcomes for case in outcome.cases], dtype=float)
        return cls(dict(zip(("modulus", "thickness", "poisson_ratio", *COLUMNS), rows.T, strict=True)))

    def __getitem__(self, name: str) -> RealArray:
        return self.columns[name]

    def __len__(self) -> int:
        return len(self["frequency"])
