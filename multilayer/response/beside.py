"""What lies beside a stack in a wall and lets sound through as well: patches, slits, holes, flanking paths."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from multilayer.arrays import RealArray
from multilayer.bounds import FREQUENCIES
from multilayer.errors import InputError
from multilayer.media.gas import Gas
from multilayer.media.openings import Passage, hole_passage, slit_passage
from multilayer.media.validity import warn_outside
from multilayer.models import NO_BOOL, Model, refuse
from multilayer.response.diffuse_field import WeightingName, diffuse_field
from multilayer.response.finite_size import (
    Window,
    finite_absorption,
    finite_transmission,
    radiation_towards,
    refuse_other_fluid,
)
from multilayer.response.plane_wave import plane_wave
from multilayer.stack import Ambient, Stack, StackField
from multilayer.units import Area, Frequency, Length, Unit

Level = Annotated[float, Field(ge=-20, le=300), Unit("dB")]
_HALF_BAND = 2**0.5 * 1.01  # what a table says of its first and last band serves to the end of an octave


@dataclass(frozen=True)
class Sound:
    """The sound that meets a wall: one plane wave, or a diffuse field.

    Attributes
    ----------
    angle : float or None
        Of a plane wave, degrees from the normal; None for a diffuse field.
    max_angle : float
        Of a diffuse field, degrees; of what is computed by layers. Openings take waves from all directions.
    weighting : str
        Of a diffuse field, as of `diffuse_field`.
    """

    angle: float | None = None
    max_angle: float = 78.0
    weighting: WeightingName = "uniform"


@dataclass(frozen=True)
class Shares:
    """Transmitted and absorbed power over the power that meets an area; arrays over frequency.

    Attributes
    ----------
    transmission : array or None
        None where nothing is behind.
    absorption : array
        What does not come back, be it transmitted or not.
    """

    transmission: RealArray | None
    absorption: RealArray


def stack_shares(stack: Stack, frequency: RealArray, sound: Sound, window: Window | None = None) -> Shares:
    """Return transmission and absorption of a stack.

    Parameters
    ----------
    stack : Stack
        Its fields hold numbers.
    frequency : array, shape (n_frequency,)
        Hz.
    sound : Sound
    window : Window, optional
        Its size, see `finite_size`.
    """
    if sound.angle is None:
        field = diffuse_field(stack, frequency, sound.max_angle, weighting=sound.weighting, window=window)
        return Shares(field.transmission_coefficient, field.absorption)
    wave = plane_wave(stack, frequency, sound.angle)
    tau = None if wave.transmission_loss is None else 10 ** (-wave.transmission_loss / 10)
    if window is None:
        return Shares(tau, wave.absorption)
    refuse_other_fluid(stack)
    radiation, cosine = radiation_towards(window, frequency, sound.angle, stack.ambient.gas.sound_speed)
    through = None if tau is None else finite_transmission(tau, radiation.real, cosine)
    return Shares(through, finite_absorption(wave.reflection, radiation, cosine))


class Patch(Model):
    """Another stack in the place of this one on a part of the wall: a window, a door, panels of another kind.

    Fields: `stack` (a file or its fields; the wall's ambient gas counts), and its size by `area` (m2), or by `width`
    and `height` (m), of which a simulation with `finite_size` takes account. Each patch answers as if it were alone: it
    is larger than half a wavelength, or far from others. Small ones that exchange sound are `patches`, a layer type.
    """

    type: Literal["patch"] = "patch"
    name: str | None = None
    stack: StackField
    area: Area | None = None
    width: Length | None = None
    height: Length | None = None

    @model_validator(mode="after")
    def _has_one_size(self) -> Self:
        sides = (self.width is None, self.height is None)
        if sides != (self.area is not None,) * 2:
            text = "needs its size: either an area, or width and height"
            refuse(self, [(("area",), text, self.area)])
        return self

    @property
    def taken(self) -> float:
        """The area that it takes from the wall, m2."""
        return self.area if self.area is not None else (self.width or 0.0) * (self.height or 0.0)

    def shares(self, frequency: RealArray, ambient: Ambient, sound: Sound, *, finite: bool) -> Shares:
        """Return what passes through it, see `Shares`; as a panel of its size where `finite`."""
        sized = finite and self.width is not None and self.height is not None
        window = Window(self.width or 0.0, self.height or 0.0) if sized else None
        return stack_shares(self.stack.model_copy(update={"ambient": ambient}), frequency, sound, window)


class _Opening(Model):
    """An opening in a wall that is rigid around it."""

    name: str | None = None
    depth: Length
    count: Annotated[int, Field(ge=1), NO_BOOL] = 1

    what: ClassVar[str]

    def shares(self, frequency: RealArray, ambient: Ambient, sound: Sound, *, finite: bool) -> Shares:
        """Return what passes through it, see `Shares`."""
        del finite
        half = self._across / 2 * frequency / ambient.gas.sound_speed
        warn_outside(
            f"the {self.what} beside the stack", "half of its width / wavelength", half, -np.inf, 0.25, frequency
        )
        passed = self._passage(frequency, ambient.gas, sound.angle)
        return Shares(passed.transmission, passed.absorption)

    @property
    def _across(self) -> float:
        raise NotImplementedError

    def _passage(self, frequency: RealArray, gas: Gas, angle: float | None) -> Passage:
        raise NotImplementedError


class Slit(_Opening):
    """A slit through the wall, with friction and heat conduction: a leak.

    Fields: `width`, `length`, `depth` (m, the way through the wall), `at_edge` (whether it lies in the corner of two
    surfaces on both sides, as under a door), `count`. See `media.openings.slit_passage`.
    """

    type: Literal["slit"] = "slit"
    width: Length
    length: Length
    at_edge: bool = False

    what: ClassVar[str] = "slit"

    @model_validator(mode="after")
    def _is_long(self) -> Self:
        if self.width > self.length:
            text = f"{1e3 * self.width:g} mm is not allowed: the width must not exceed the length"
            refuse(self, [(("width",), text, self.width)])
        return self

    @property
    def taken(self) -> float:
        """The area that it takes from the wall, m2."""
        return self.count * self.width * self.length

    @property
    def _across(self) -> float:
        return self.width

    def _passage(self, frequency: RealArray, gas: Gas, angle: float | None) -> Passage:
        return slit_passage(frequency, self.width, self.length, self.depth, gas, angle, at_edge=self.at_edge)


class Hole(_Opening):
    """A round hole through the wall, with friction and heat conduction: a leak.

    Fields: `radius`, `depth` (m, the way through the wall), `count`. See `media.openings.hole_passage`.
    """

    type: Literal["hole"] = "hole"
    radius: Length

    what: ClassVar[str] = "hole"

    @property
    def taken(self) -> float:
        """The area that it takes from the wall, m2."""
        return self.count * pi * self.radius**2

    @property
    def _across(self) -> float:
        return 2 * self.radius

    def _passage(self, frequency: RealArray, gas: Gas, angle: float | None) -> Passage:
        return hole_passage(frequency, self.radius, self.depth, gas, angle)


class LossSpectrum(Model):
    """Transmission losses, dB, at frequencies, Hz, that rise; linear in between over the logarithm of frequency."""

    frequency: Annotated[tuple[Frequency, ...], Field(min_length=1, max_length=FREQUENCIES.usual)]
    transmission_loss: Annotated[tuple[Level, ...], Field(min_length=1, max_length=FREQUENCIES.usual)]

    @model_validator(mode="after")
    def _is_a_table(self) -> Self:
        if len(self.frequency) != len(self.transmission_loss):
            text = f"{len(self.transmission_loss)} values stand beside {len(self.frequency)} frequencies"
            refuse(self, [(("transmission_loss",), text, self.transmission_loss)])
        if np.any(np.diff(self.frequency) <= 0):
            refuse(self, [(("frequency",), "the frequencies must rise", self.frequency)])
        return self

    def at(self, frequency: RealArray) -> RealArray:
        """Return the losses at frequencies.

        Raises
        ------
        InputError
            More than half an octave below the first or above the last.
        """
        low, high = self.frequency[0] / _HALF_BAND, self.frequency[-1] * _HALF_BAND
        if outside := [f for f in np.ravel(frequency) if not low <= f <= high]:
            known = f"{self.frequency[0]:g} to {self.frequency[-1]:g} Hz"
            raise InputError(
                f"the spectrum of a flanking path goes from {known} and says nothing of {outside[0]:.4g} Hz; state it "
                "there, or ask for other frequencies"
            )
        return np.interp(np.log(frequency), np.log(self.frequency), self.transmission_loss)


class Flanking(Model):
    """A path around the wall, through floors, ducts or side walls, by its transmission loss for the wall's whole area.

    Fields: `transmission_loss` (dB), the same at all frequencies, or a `spectrum` of them. That of ISO 12354-1, R_ij of
    a path, has the wall's area as its reference. It changes no absorption.
    """

    type: Literal["flanking"] = "flanking"
    name: str | None = None
    transmission_loss: Level | None = None
    spectrum: LossSpectrum | None = None

    taken: ClassVar[float] = 0.0

    @model_validator(mode="after")
    def _said_once(self) -> Self:
        if (self.transmission_loss is None) == (self.spectrum is None):
            text = "give either a transmission_loss in dB, or a spectrum {frequency: [...], transmission_loss: [...]}"
            refuse(self, [(("transmission_loss",), text, self.transmission_loss)])
        return self

    def transmission(self, frequency: RealArray) -> RealArray:
        """Return the transmitted power over that which meets the wall."""
        if self.spectrum is not None:
            return np.asarray(10 ** (-self.spectrum.at(frequency) / 10))
        assert self.transmission_loss is not None  # by validation
        return np.full(np.shape(frequency), 10 ** (-self.transmission_loss / 10))


Beside = Annotated[Patch | Slit | Hole | Flanking, Field(discriminator="type")]
