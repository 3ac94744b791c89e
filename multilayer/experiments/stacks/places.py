"""Places of an impedance tube at which something unmodelled may act."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
from pydantic import PrivateAttr

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.experiments.places import BasePlace, changes_nothing
from multilayer.experiments.stacks.effects import TubeEffect, TubeSetting, with_layer, with_layers
from multilayer.layers.base import ElasticLayer
from multilayer.layers.fluid import Fluid
from multilayer.layers.pores import PoreLayer
from multilayer.matrix.wave import Wave
from multilayer.simulation.warned import collected_warnings
from multilayer.stack import Stack

_LEAST = 1e-12  # difference of reflections of the stack before different walls that is rounding


class TubePlace(BasePlace):
    """Where something may act in a tube; override the hook through which it enters the model.

    Values of the law have the shape (m, n), as reflection coefficients have.
    """

    kind = TubeEffect.kind

    @changes_nothing
    def stack(self, setting: TubeSetting, stack: Stack, values: ComplexArray) -> Stack:
        """Return the stack; fields may hold arrays of shape (m, n)."""
        return stack

    @changes_nothing
    def surface(
        self, setting: TubeSetting, stack: Stack, reflection: ComplexArray, values: ComplexArray
    ) -> ComplexArray:
        """Return the reflection coefficient of the tube's end, given that of the sample."""
        return reflection

    @changes_nothing
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


def pore_fluid(setting: TubeSetting, name: str, frequency: RealArray) -> tuple[ComplexArray, ComplexArray] | None:
    """Return density, kg/m3, and bulk modulus, Pa, of the air in a layer's pores, shape (n,); None without such."""
    layers = (setting.stack.layers[index] for index, label in pore_layers(setting.stack) if label == name)
    with collected_warnings():  # the nominal model's warnings are reported
        fluids = (layer.pore_fluid(_wave(setting, frequency)) for layer in layers if isinstance(layer, PoreLayer))
        return next(fluids, None)


def skeleton_modulus(setting: TubeSetting, name: str, frequency: RealArray) -> ComplexArray | None:
    """Return the complex modulus of a layer's skeleton, Pa, shape (n,); None without such a layer."""
    layers = (setting.stack.layers[index] for index, label in elastic_layers(setting.stack) if label == name)
    moduli = (layer.complex_modulus(_wave(setting, frequency)) for layer in layers if isinstance(layer, ElasticLayer))
    return next((np.broadcast_to(modulus, frequency.shape) for modulus in moduli), None)


def _wave(setting: TubeSetting, frequency: RealArray) -> Wave:
    return Wave.incident(frequency, setting.angle, setting.gas)


def with_factors(
    stack: Stack, name: str, density: Numeric = 1.0, bulk_modulus: Numeric = 1.0, young_modulus: Numeric = 1.0
) -> Stack:
    """Return the stack with another medium in a layer, beside what was changed of it before.

    Parameters
    ----------
    stack : Stack
    name : str
        The layer's name, or its position as text; without such a layer the stack stays as it is.
    density, bulk_modulus : complex or array, shape (m, n)
        Factors on the effective density and bulk modulus of the air in the layer's pores, if it has some.
    young_modulus : complex or array, shape (m, n)
        Factor on the complex modulus of its skeleton, if it has one; Poisson's ratio stays.
    """
    for index, layer in enumerate(stack.layers):
        if (layer.name or str(index)) == name:
            before = getattr(layer, "_factors", None)
            kind = _with_factors(type(layer)) if before is None else type(layer)
            other: Any = kind.model_construct(**dict(layer))
            other._factors = tuple(
                a * b for a, b in zip(before or (1.0, 1.0, 1.0), (density, bulk_modulus, young_modulus), strict=True)
            )
            return with_layer(stack, index, other)
    return stack


@cache
def _with_factors(kind: Any) -> Any:
    """Return a layer type with another density and bulk modulus of the air in its pores, and another modulus."""

    class Changed(kind):  # type: ignore[misc]
        _factors: tuple[Any, Any, Any] = PrivateAttr(default=(1.0, 1.0, 1.0))

        def pore_fluid(self, wave: Wave) -> tuple[ComplexArray, ComplexArray]:
            density, bulk = super().pore_fluid(wave)
            return density * self._factors[0], bulk * self._factors[1]

        def complex_modulus(self, wave: Wave) -> Numeric:
            modulus: Numeric = super().complex_modulus(wave) * self._factors[2]
            return modulus

    return Changed
