"""Derivatives by finite differences: all points of a stencil in one batch, which costs little more than one point.

Steps and errors: W. H. Press et al., Numerical Recipes, 3rd ed., Cambridge 2007, sec. 5.7.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from multilayer.arrays import ComplexArray, RealArray

Values = TypeVar("Values", RealArray, ComplexArray)

# steps of standard normal coordinates
WIDE = 1e-3  # for functions smooth over a standard deviation, and known to few digits
USUAL = 1e-4
FINE = 1e-5  # where a minimum's position depends on the derivative: small truncation and rounding errors
FORWARD = 1e-6  # of one-sided differences, for functions smooth to rounding


@dataclass(frozen=True)
class Stencil:
    """Points from whose values a function's derivative follows.

    Attributes
    ----------
    points : array, shape (m, n)
        The first is where the derivative is taken.
    step : float
    is_central : bool
        Whether there are points on both sides: the error is of second order in the step.
    turn : array, shape (q, q), optional
        Derivatives of other coordinates by the first q: the points lie along these, and derivatives along the axes
        follow. Where all axes cross a valley, what is lost in differences is then not along it.
    """

    points: RealArray
    step: float
    is_central: bool
    turn: RealArray | None = None

    @classmethod
    def central(cls, z: RealArray, step: float = USUAL, turn: RealArray | None = None) -> Stencil:
        """Return points on both sides of coordinates z, shape (n,), along all axes."""
        steps = step * _along(np.eye(z.size), turn)
        return cls(np.concatenate([z[None], z + steps, z - steps]), step, True, turn)

    @classmethod
    def forward(
        cls, z: RealArray, step: float = FORWARD, along: RealArray | None = None, turn: RealArray | None = None
    ) -> Stencil:
        """Return points ahead of coordinates z, shape (n,), along all axes or directions of shape (k, n).

        Half as many points, and an error of first order in the step: about a millionth by default, exact enough for a
        search and for a posterior's width. Of a coordinate on its bound the derivative is that to one side.
        """
        directions = _along(np.eye(z.size) if along is None else along, turn)
        return cls(np.concatenate([z[None], z + step * directions]), step, False, turn)

    def derivative(self, values: Values) -> Values:
        """Return the derivative, shape (..., k), of values at the points, shape (m, ...), along the k axes."""
        if self.is_central:
            n = len(self.points) // 2
            slopes = (values[1 : n + 1] - values[n + 1 :]) / (2 * self.step)
        else:
            slopes = (values[1:] - values[0]) / self.step
        return self.by_axes(np.moveaxis(slopes, 0, -1))

    def by_axes(self, slopes: Values) -> Values:
        """Return derivatives along the axes, shape (..., k), from those along the points."""
        if self.turn is None:
            return slopes
        q = len(self.turn)
        return np.concatenate([slopes[..., :q] @ self.turn, slopes[..., q:]], axis=-1)

    def linearised(self, values: Values) -> tuple[Values, Values]:
        """Return value, shape (...), and derivative, shape (..., k), of values at the points, shape (m, ...)."""
        return values[0], self.derivative(values)


def central(function: Callable[[RealArray], Values], z: RealArray, step: float = USUAL) -> tuple[Values, Values]:
    """Return a function's value and derivative by differences to both sides; see `Stencil.central`."""
    stencil = Stencil.central(z, step)
    return stencil.linearised(function(stencil.points))


def forward(
    function: Callable[[RealArray], Values], z: RealArray, step: float = FORWARD, along: RealArray | None = None
) -> tuple[Values, Values]:
    """Return a function's value and derivative by differences to one side; see `Stencil.forward`."""
    stencil = Stencil.forward(z, step, along)
    return stencil.linearised(function(stencil.points))


def _along(directions: RealArray, turn: RealArray | None) -> RealArray:
    """Return directions, shape (k, n), along other coordinates in place of the first."""
    if turn is None:
        return directions
    q = len(turn)
    return np.concatenate([directions[:, :q] @ np.linalg.inv(turn).T, directions[:, q:]], axis=1)
