"""Places of an impedance tube at which something unmodelled may act."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.experiments.places import BasePlace
from multilayer.experiments.stacks.effects import TubeEffect, TubeSetting, with_layers
from multilayer.layers.fluid import Fluid
from multilayer.stack import Stack

_LEAST = 1e-12  # difference of reflections of the stack before different walls that is rounding


class TubePlace(BasePlace):
    """Where something may act in a tube; override the hook through which it enters the model.

    Values of the law have the shape (m, n), as reflection coefficients have.
    """

    kind = TubeEffect.kind

    def stack(self, setting: TubeSetting, stack: Stack, values: ComplexArray) -> Stack:
        """Return the stack; fields may hold arrays of shape (m, n)."""
        return stack

    def surface(
        self, setting: TubeSetting, stack: Stack, reflection: ComplexArray, values: ComplexArray
    ) -> ComplexArray:
        """Return the reflection coefficient of the tube's end, given that of the sample."""
        return reflection

    def reading(self, setting: TubeSetting, reflection: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the reflection coefficient as it is reported."""
        return reflection


def before_backing(setting: TubeSetting, stack: Stack, reflection: ComplexArray, backing: ComplexArray) -> ComplexArray:
    """Return the reflection of a stack before a backing in place of the rigid wall.

    A stack maps the reflection coefficient r of what backs it to that of its front by a Möbius transformation, which
    three pairs determine: r = 1 (the wall), and -i and -1 (an eighth and a quarter of a wavelength of lossless air
    before it). Cross ratios of four points are the same on both sides.

    Parameters
    ----------
    setting : TubeSetting
    stack : Stack
        With a rigid wall behind it.
    reflection : array, shape (m, n)
        Of that stack.
    backing : array, shape (m, n)
        Reflection coefficient of the backing in air.
    """
    eighth, quarter = (_with_air(setting, stack, turn / setting.wavenumber) for turn in (np.pi / 4, np.pi / 2))
    apart = eighth - quarter
    unlike = np.where(np.abs(apart) > _LEAST, apart, 1.0)
    # (r - 1)(-i + 1)/((r + 1)(-i - 1)) on one side, (R - R1)(R2 - R3)/((R - R3)(R2 - R1)) on the other; the pole at
    # r = -1 is multiplied out
    weight = (backing - 1) * (1 - 1j) * (eighth - reflection) / unlike
    against = (backing + 1) * (-1 - 1j)
    seen = (against * reflection - weight * quarter) / (against - weight)
    return np.asarray(np.where(np.abs(apart) > _LEAST, seen, reflection))


def _with_air(setting: TubeSetting, stack: Stack, depth: RealArray) -> ComplexArray:
    air = Fluid(thickness=1.0).model_copy(update={"thickness": depth[None]})
    return setting.reflection(with_layers(stack, (*stack.layers, air)))
