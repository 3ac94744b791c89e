"""Unmodelled effects of an impedance tube, and the tube as effects see it.

Transfer functions between two microphones: ISO 10534-2; J. Y. Chung & D. A. Blaser, J. Acoust. Soc. Am. 68 (1980)
907-913.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import ClassVar

import numpy as np

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.experiments.effects import BaseEffect, Values
from multilayer.experiments.stacks.responses import WaveResponse
from multilayer.layers.base import Layer
from multilayer.layers.fluid import Fluid
from multilayer.layers.pores import PoreLayer
from multilayer.matrix.couplings import Contact
from multilayer.media.gas import Gas
from multilayer.models import Model
from multilayer.signals.impedance_tube import reflection_coefficient, transfer_function
from multilayer.simulation.settings import PlaneIncidence
from multilayer.stack import LayerContact, Stack
from multilayer.units import Length, PositiveRatio, Ratio

_SPACING = 0.05  # m
_OF_THE_LIMIT = 0.4  # ISO 10534-2 asks for a spacing below 0.45 c/f of the highest frequency


class Tube(Model):
    """The tube of a measurement.

    Attributes
    ----------
    microphone_spacing : float, optional
        Between the two microphones, m; 50 mm, or 0.4 c/f of the highest frequency where that is less.
    microphone_distance : float
        From the sample's face to the nearer microphone, m.
    diameter : float
        m; of a square tube its width.
    error : float
        Error of tube, mounting and model: standard deviation of each part of R. A measurement's `model_error` takes its
        place.
    length : float
        Correlation length of that error in ln f.
    """

    microphone_spacing: Length | None = None
    microphone_distance: Length = 0.1
    diameter: Length = 0.1
    error: Ratio = 0.01  # repeatability of mounting
    length: PositiveRatio = 0.3


@dataclass(frozen=True)
class TubeSetting:
    """A measurement in a tube, as effects see it.

    Attributes
    ----------
    name : str
    frequency : array, shape (n,)
        Hz.
    angle : float
        Degrees from the normal.
    stack : Stack
        With nominal values.
    tube : Tube
    """

    name: str
    frequency: RealArray
    angle: float
    stack: Stack
    tube: Tube

    @property
    def omega(self) -> RealArray:
        """Angular frequency, rad/s."""
        return 2 * np.pi * self.frequency

    @cached_property
    def gas(self) -> Gas:
        """The gas that the evaluation of the measurement assumes."""
        return self.stack.ambient.gas

    @cached_property
    def wavenumber(self) -> RealArray:
        """Component of the wavenumber along the tube, rad/m."""
        return np.asarray(self.omega / self.gas.sound_speed * np.cos(np.deg2rad(self.angle)))

    @cached_property
    def spacing(self) -> float:
        """Distance between the microphones, m."""
        if self.tube.microphone_spacing is not None:
            return self.tube.microphone_spacing
        return min(_SPACING, _OF_THE_LIMIT * self.gas.sound_speed / float(self.frequency.max()))

    def reflection(self, stack: Stack) -> ComplexArray:
        """Return the reflection coefficient of a stack in its ambient gas, shape (..., n)."""
        return np.asarray(WaveResponse("reflection", self.frequency, PlaneIncidence(angle=self.angle))(stack))

    def transfer_function(self, reflection: ComplexArray, wavenumber: Numeric) -> ComplexArray:
        """Return the pressure at the nearer microphone over that at the farther one; ISO 10534-2, annex D."""
        near = self.tube.microphone_distance
        return transfer_function(reflection, wavenumber, near, near + self.spacing)

    def evaluated(self, read: ComplexArray) -> ComplexArray:
        """Return the reflection coefficient that is evaluated from a transfer function; ISO 10534-2, eq. (17)."""
        far = self.tube.microphone_distance + self.spacing
        return reflection_coefficient(read, self.wavenumber, self.spacing, far)


class TubeEffect(BaseEffect):
    """An unmodelled effect of a tube; subclass it and override what it changes.

    The model of a datum is computed in this order: the sample (`stack`), what lies beside it (`surface`), what the
    microphones report (`reading`). Every hook returns its argument where the effect does not act. Values of
    parameters have the shape (m, 1), frequencies (n,).

    Attributes
    ----------
    place : str
        Name of a `places.TubePlace`.
    changes_gas : bool
        Whether the gas of the stack changes, which takes no arrays: samples are then solved one after the other.
    in_tubes_only : bool
        Whether it needs a tube's wall, so that it cannot act on absorption in a room, though it changes the stack only.
    """

    kind = "tube"
    acts_through_place = False  # no bound by a free law: of tubes every effect is fitted, there are few
    changes_gas: ClassVar[bool] = False
    in_tubes_only: ClassVar[bool] = False

    def applies(self, setting: TubeSetting) -> bool:
        """Tell whether the effect can act in a measurement at all."""
        return True

    def stack(self, setting: TubeSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with the effect; fields may hold arrays of shape (m, 1) or (m, n)."""
        return stack

    def surface(self, setting: TubeSetting, stack: Stack, reflection: ComplexArray, values: Values) -> ComplexArray:
        """Return the reflection coefficient of the tube's end, shape (m, n), given that of the sample."""
        return reflection

    def reading(self, setting: TubeSetting, reflection: ComplexArray, values: Values) -> ComplexArray:
        """Return the reflection coefficient as it is reported, shape (m, n)."""
        return reflection


def sample_index(stack: Stack) -> int | None:
    """Return the sample's index: the thickest layer with pores, else the thickest that is no fluid; None without."""
    for kinds in (PoreLayer, Layer):
        slabs = [i for i, layer in enumerate(stack.layers) if isinstance(layer, kinds) and _is_slab(layer)]
        if slabs:
            return max(slabs, key=lambda i: thickness_of(stack.layers[i]))
    return None


def _is_slab(layer: Layer) -> bool:
    return getattr(layer, "thickness", None) is not None and not isinstance(layer, Fluid)


def thickness_of(layer: Layer) -> float:
    """Return the thickness of a layer, m, the mean where it holds an array; 0 of a sheet."""
    thickness = getattr(layer, "thickness", None)
    return 0.0 if thickness is None else float(np.mean(thickness))


def with_layers(stack: Stack, layers: Sequence[Layer]) -> Stack:
    """Return the stack with other layers; old ones that are neighbours still keep the contact between them."""
    pairs = zip(pairwise(stack.layers), stack.interfaces[1:-1], strict=True)
    kinds: dict[tuple[int, int], Contact] = {(id(front), id(back)): kind for (front, back), kind in pairs}
    contacts = [
        LayerContact(between=(i, i + 1), kind=kinds[id(front), id(back)])
        for i, (front, back) in enumerate(pairwise(layers))
        if kinds.get((id(front), id(back)), "bonded") != "bonded"
    ]
    if layers[-1] is stack.layers[-1] and stack.interfaces[-1] != "bonded":
        contacts.append(LayerContact(between=(len(layers) - 1, "termination"), kind=stack.interfaces[-1]))
    return stack.model_copy(update={"layers": tuple(layers), "contacts": tuple(contacts)})


def with_layer(stack: Stack, index: int, layer: Layer) -> Stack:
    """Return the stack with one of its layers replaced."""
    return stack.model_copy(update={"layers": (*stack.layers[:index], layer, *stack.layers[index + 1 :])})


__all__ = ["Tube", "TubeEffect", "TubeSetting", "sample_index", "thickness_of", "with_layer", "with_layers"]
