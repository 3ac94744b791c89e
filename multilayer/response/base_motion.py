"""A stack shaken at its front face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.frames import Frame, Tabular, over
from multilayer.matrix.families import normal_velocity
from multilayer.matrix.solve import Solution, System, Wall
from multilayer.matrix.wave import Wave
from multilayer.response.system import build_system, solve_or_explain
from multilayer.stack import Stack


@dataclass(frozen=True, repr=False)
class BaseMotion(Tabular):
    """Response of a stack to a uniform motion of its front face along axis 3.

    Attributes
    ----------
    frequency : array
        Hz.
    transmissibility : complex array, shape ``(..., *frequency.shape)``
        Normal motion of the last layer's back face (of its frame) over that of the base.
    """

    frequency: RealArray
    transmissibility: ComplexArray

    @property
    def frame(self) -> Frame:
        """The response over (samples and) frequency."""
        return over({"frequency": self.frequency}, {"transmissibility": self.transmissibility}, {"frequency": "Hz"})


@np.errstate(all="ignore")  # what is not finite is refused, whatever made it so
def base_motion(stack: Stack, frequency: ArrayLike) -> BaseMotion:
    """Return how the back face of `stack` follows an imposed motion of its front face.

    Parameters
    ----------
    stack : Stack
        Its fields may hold arrays that broadcast against `frequency`.
    frequency : array
        Hz, above 0.

    Notes
    -----
    Bonfiglio & Pompoli 2015, eqs. (2)-(4): the column of the imposed velocity goes to the right-hand side. The base
    is rigid and of infinite extent, the motion the same everywhere on it.
    """
    wave = Wave.incident(frequency, 0.0, stack.ambient.gas)
    system = build_system(stack, wave, Wall())
    top = velocity_of_top(system, solve_or_explain(system, stack, wave))
    return BaseMotion(np.asarray(frequency, dtype=float), top)


def velocity_of_top(system: System, solution: Solution) -> ComplexArray:
    """Return the normal velocity (of the frame) at the last back face."""
    last = system.layers[-1]
    row = normal_velocity(last.family)
    return np.asarray(last.states.at_back(solution.layers[-1][:, None])[row, 0])
