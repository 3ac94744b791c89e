"""What the cases of the factorial say: which of them count, and their statistics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np

from multilayer.arrays import BoolArray, RealArray
from multilayer.fits.burst.acceptance import Criteria
from validation.factorial_cases import (
    PLATE_MODULUS,
    PLATE_POISSON,
    PLATE_THICKNESS,
    RADIUS,
    Design,
    Outcome,
    Table,
)

LOST = 1e-8  # transmissibilities below it are rounding: the full solution is 1 plus the plate's relative motion
RATE, LEVEL = 25600.0, 0.5  # Hz and dB of eq. (10)
GAIN = 10.0  # of noise: with more, 1 % of noise makes more than 10 % of a modulus
WEAK = 1e-3  # of the base's motion


@dataclass(frozen=True)
class Run:
    """A design, what was found for it, and how long the last run took (s) for how many of its tasks."""

    design: Design
    outcomes: Sequence[Outcome]
    seconds: float
    n_computed: int


class Spread(NamedTuple):
    """Mean, standard deviation and number of values."""

    mean: float
    std: float
    n: int

    def __str__(self) -> str:
        return f"{self.mean:.2f} ± {self.std:.2f}" if self.n else "-"


Grid: TypeAlias = dict[tuple[float, float], Spread]  # by Poisson's ratio and frequency, Hz


@dataclass(frozen=True)
class Cases:
    """The cases of a run."""

    design: Design
    table: Table

    @classmethod
    def of(cls, run: Run) -> Cases:
        """Return the cases of all tasks."""
        return cls(run.design, Table.of(run.outcomes))

    def __getitem__(self, name: str) -> RealArray:
        return self.table[name]

    @cached_property
    def solved(self) -> BoolArray:
        """Which transmissibilities are more than rounding."""
        return np.asarray(self["transmissibility"] >= LOST)

    @cached_property
    def accepted(self) -> BoolArray:
        """Which have a solution that meets eq. (10) and lies within the bounds."""
        excess = Criteria(1 / RATE, LEVEL).excess(self["delta_tof"], self["delta_level"])
        return np.asarray(self.solved & (excess <= 1) & (self["at_bound"] == 0))

    @cached_property
    def several(self) -> BoolArray:
        """Which have several solutions that fit alike."""
        return np.asarray(self.solved & (self["plausible"] > 1))

    @cached_property
    def waves(self) -> RealArray:
        """Radius over the wavelength of a rod's waves."""
        return np.asarray(RADIUS * self["frequency"] * np.sqrt(self["density"] / self["modulus"]))

    def where(self, **values: float) -> BoolArray:
        """Return the cases of given parameters."""
        found: BoolArray = np.ones(len(self.table), dtype=bool)
        for name, value in values.items():
            found &= np.isclose(self[name], value)
        return found

    def spread(self, name: str, mask: BoolArray) -> Spread:
        """Return the statistics of a column over some cases."""
        values = self[name][mask]
        if not len(values):
            return Spread(float("nan"), float("nan"), 0)
        return Spread(float(values.mean()), float(values.std()), len(values))

    def grid(self, name: str, mask: BoolArray) -> Grid:
        """Return the statistics by (Poisson's ratio, frequency)."""
        return {
            (nu, f): self.spread(name, mask & self.where(poisson_ratio=nu, frequency=f))
            for nu in self.design.poisson_ratios
            for f in self.design.frequencies
        }


def bending_length(modulus: float, thickness: float) -> float:
    """Return over which length, m, the top plate bends on a sample of this modulus (Pa) and thickness (m).

    (D h / E)^(1/4), a plate on springs.
    """
    stiffness = PLATE_MODULUS * PLATE_THICKNESS**3 / (12 * (1 - PLATE_POISSON**2))
    return float((stiffness * thickness / modulus) ** 0.25)


def quartiles(values: RealArray) -> str:
    """Return the median and, in brackets, the quartiles."""
    if not len(values):
        return "-"
    low, middle, high = np.quantile(values, [0.25, 0.5, 0.75])
    return f"{middle:.2f} ({low:.2f} to {high:.2f})"
