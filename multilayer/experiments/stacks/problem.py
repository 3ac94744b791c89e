"""Fields of stacks and measurements of them as one inverse problem."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.experiments.stacks.file import StackFitFile
from multilayer.experiments.stacks.observations import Observation
from multilayer.experiments.stacks.unknowns import UnknownFields, placed
from multilayer.inference.derivative import central
from multilayer.inference.priors import Parameter
from multilayer.simulation.warned import collected_warnings

_AT_ONCE = 16_384  # samples times frequencies of one batched solve


@dataclass(frozen=True)
class StackProblem(UnknownFields):
    """Stacks, unknown fields of theirs, and measurements; a `Problem`.

    Attributes
    ----------
    observations : tuple of Observation
    """

    observations: tuple[Observation, ...]

    @classmethod
    def of(cls, file: StackFitFile) -> StackProblem:
        """Return the problem that a file states."""
        return cls(placed(file.by_name, file.resolved), file.resolved, file.observations)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The unknowns' coordinates, one unknown after the other."""
        return self.field_parameters

    @property
    def start(self) -> RealArray:
        """Coordinates near the nominal values."""
        return self.nominal_start

    def predict(self, z: RealArray) -> list[NDArray[Any]]:
        """Return the response of every measurement, shape (..., n_frequency), of coordinates of shape (..., n)."""
        points = np.asarray(z, dtype=float)
        flat = points.reshape(-1, points.shape[-1])
        with collected_warnings():  # a search leaves the range of formulae; the solution's warnings are told
            found = [self._predict(observation, flat) for observation in self.observations]
        return [values.reshape(*points.shape[:-1], -1) for values in found]

    def warnings(self, z: RealArray) -> list[str]:
        """Return where the formulae do not hold at one point, shape (n,)."""
        with collected_warnings() as texts:
            for observation in self.observations:
                self._predict(observation, z[None])
        return list(dict.fromkeys(texts))

    def _predict(self, observation: Observation, z: RealArray) -> NDArray[Any]:
        step = max(1, _AT_ONCE // observation.points)
        pieces = []
        for i in range(0, len(z), step):
            piece = z[i : i + step]
            samples = self.samples(piece)[observation.stack]
            pieces.append(observation.predict(self.stacks[observation.stack], samples, len(piece)))
        return np.concatenate(pieces)

    def residual(self, z: RealArray) -> RealArray:
        """Return whitened residuals, shape (..., n_data); NaN where a stack has no response."""
        predicted = self.predict(z)
        parts = [o.residual(values) for o, values in zip(self.observations, predicted, strict=True)]
        return np.concatenate(parts, axis=-1)

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual and derivative from one batched solve per measurement."""
        return central(self.residual, z)
