"""Places of an impedance tube at which something unmodelled may act."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
from pydantic import PrivateAttr

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.experiments.places import BasePlace
from multilayer.experiments.stacks.effects import TubeEffect, TubeSetting, with_layer, with_layers
from multilayer.layers.base import ElasticLayer
from multilayer.layers.fluid import Fluid
from multilayer.layers.pores import PoreLayer
from multilayer.matrix.wave import Wave
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


def pore_layers(stack: Stack) -> Iterator[tuple[int, str]]:
    """Yield position and name, or position as text, of every layer with pores."""
    for index, layer in enumerate(stack.layers):
        if isinstance(layer, PoreLayer):
            yield index, layer.name or str(index)


def elastic_layers(stack: Stack) -> Iterator[tuple[int, str]]:
    """Yield position and name, or position as text, of every layer with an isotropic elastic skeleton."""
    for index, layer in enumerate(stack.layers):
        if isinstance(layer, ElasticLayer):
            yield index, layer.name or str(index)


def with_other_modulus(stack: Stack, name: str, factor: Numeric) -> Stack:
    """Return the stack with another Young's modulus of a layer; unchanged where it has no such elastic layer.

    Parameters
    ----------
    stack : Stack
    name : str
        The layer's name, or its position as text.
    factor : complex or array, shape (m, n)
        On the complex modulus.
    """
    for index, label in elastic_layers(stack):
        if label == name:
            layer = stack.layers[index]
            other = _with_stiffness(type(layer)).model_construct(**dict(layer))
            other._stiffness = factor
            return with_layer(stack, index, other)
    return stack


@cache
def _with_stiffness(kind: type[ElasticLayer]) -> Any:
    """Return a layer type whose skeleton has another modulus."""

    class OtherModulus(kind):  # type: ignore[valid-type, misc]
        _stiffness: Any = PrivateAttr(default=1.0)

        def complex_modulus(self, wave: Wave) -> Numeric:
            modulus: Numeric = super().complex_modulus(wave) * self._stiffness
            return modulus

    return OtherModulus


def with_other_pores(stack: Stack, name: str, density: Numeric = 1.0, bulk_modulus: Numeric = 1.0) -> Stack:
    """Return the stack with other air in the pores of a layer; unchanged where it has no such layer with pores.

    Parameters
    ----------
    stack : Stack
    name : str
        The layer's name, or its position as text.
    density, bulk_modulus : complex or array, shape (m, n)
        Factors on the effective density and bulk modulus of the air in the pores.
    """
    for index, label in pore_layers(stack):
        if label == name:
            layer = stack.layers[index]
            other = _with_factors(type(layer)).model_construct(**dict(layer))
            other._factors = (density, bulk_modulus)
            return with_layer(stack, index, other)
    return stack


@cache
def _with_factors(kind: type[PoreLayer]) -> Any:
    """Return a layer type whose pores hold air of another density and bulk modulus."""

    class OtherPores(kind):  # type: ignore[valid-type, misc]
        _factors: tuple[Any, Any] = PrivateAttr(default=(1.0, 1.0))

        def pore_fluid(self, wave: Wave) -> tuple[ComplexArray, ComplexArray]:
            density, bulk = super().pore_fluid(wave)
            return density * self._factors[0], bulk * self._factors[1]

    return OtherPores
