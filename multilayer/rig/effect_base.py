"""Base class of the virtual rig's effects: a few parameters, and four hooks through which they change a campaign."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, TypeAlias

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, RealArray
from multilayer.models import Model
from multilayer.rig.specimen import SpecimenSettings
from multilayer.units import DIMENSIONLESS, Unit

GRAVITY = 9.80665  # m/s2, standard
PERTURBED = "Perturbed:"  # in an effect's docstring, ahead of its law with a perturbation
REFERENCE_FREQUENCY = 500.0  # Hz: where perturbed laws agree with the unperturbed ones

Perturbation = Annotated[float, Field(ge=-0.5, le=0.5), Unit(DIMENSIONLESS)]
Geometry: TypeAlias = dict[str, Any]
"""Arguments of `multilayer.rig.two_plate.TwoPlateRig`, and ``real_plate_modulus``, that of a plate that may bend."""
Mistake: TypeAlias = tuple[tuple[str | int, ...], str, Any]


@dataclass(frozen=True)
class Mounting:
    """One configuration: its nominal sizes, m, and its place among the `count` configurations of the campaign."""

    name: str
    index: int
    count: int
    thickness: float
    top_plate: float
    radius: float
    frequencies: tuple[float, ...]


@dataclass(frozen=True)
class Moment:
    """One recording: where and when it was made.

    Attributes
    ----------
    mounting : Mounting
    geometry : dict
        What stands on the rig, see `Geometry`.
    frequency : float
        Of the burst, Hz.
    repeat : int
    elapsed, total : float
        Bursts measured before this recording, and in the whole campaign; fractions count repeats.
    since_mounting : float
        Bursts measured since the sample was mounted.
    """

    mounting: Mounting
    geometry: Geometry
    frequency: float
    repeat: int
    elapsed: float
    total: float
    since_mounting: float


@dataclass(frozen=True)
class Surroundings:
    """The rest of a rig file, against which an effect checks its fields.

    Attributes
    ----------
    specimen : SpecimenSettings
    mountings : tuple of Mounting
    sampling_rate : float
        Hz.
    effects : tuple of str
        Names of all effects.
    """

    specimen: SpecimenSettings
    mountings: tuple[Mounting, ...]
    sampling_rate: float
    effects: tuple[str, ...]

    @property
    def thinnest(self) -> float:
        """Thickness of the thinnest sample, m."""
        return min(mounting.thickness for mounting in self.mountings)

    @property
    def slimmest(self) -> float:
        """Radius of the slimmest sample, m."""
        return min(mounting.radius for mounting in self.mountings)


@dataclass(frozen=True)
class Size:
    """How large a blind check draws an effect: log-uniform from invisible to obvious, with a random sign if `signed`.

    Attributes
    ----------
    field : str
        Of the effect; empty where its size is not drawn.
    low, high : float
        SI; the effect of `high` is the smaller one where that is below `low`.
    signed : bool
    parameter : str
        Of the diagnosis's effect of the same name that measures the same thing, where there is one.
    of : callable
        From the value of the field to that of the parameter.
    """

    field: str = ""
    low: float = 1.0
    high: float = 1.0
    signed: bool = False
    parameter: str = ""
    of: Callable[[float], float] = float

    def place(self, value: float) -> float:
        """Return where a size lies on a logarithmic scale from the smallest that is drawn (0) to the largest (1)."""
        return float(np.log(abs(value) / self.low) / np.log(self.high / self.low))


class Effect(Model):
    """A physical effect that the plane-wave model of the rig leaves out.

    A subclass gives `effect` a `Literal` name, adds fields with defaults, and overrides the hooks it needs; each hook
    here returns its argument. `perturbation` changes the *law* of the effect, not its size: a check in which data and
    explanation share their formulae proves little. It is 0 for the law as stated. The docstring states the law, and
    behind the word ``Perturbed:`` the law with a perturbation p; the manual's table of effects is made of it.

    Attributes
    ----------
    known : bool
        Whether diagnoses have an effect of this name; where they have not, "unknown" is the right verdict.
    varies : bool
        Whether the modulus differs from recording to recording.
    takes : tuple of str
        Fields of the specimen that act only where this effect is listed.
    needs : tuple of str
        Effects without which it does nothing; a file must list them (`mistakes`).
    drawn : Size or None
        How large blind checks draw it; None where they leave it out.
    """

    effect: str
    perturbation: Perturbation = 0.0

    known: ClassVar[bool] = True
    varies: ClassVar[bool] = False
    takes: ClassVar[tuple[str, ...]] = ()
    needs: ClassVar[tuple[str, ...]] = ()
    drawn: ClassVar[Size | None] = None

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        """Give what does not fit the rest of the file: path inside the effect, text, value."""
        yield from ()

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        """Return the arguments of the finite elements for a configuration."""
        return geometry

    def apply_to_modulus(self, frequency: RealArray, modulus: ComplexArray, moment: Moment) -> ComplexArray:
        """Return the sample's modulus, Pa, at frequencies, Hz."""
        return modulus

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        """Return top over base as the channels show it, from 0 Hz on; affine in `ratio`."""
        return ratio

    def apply_to_signals(
        self, base: RealArray, top: RealArray, sampling_rate: float, moment: Moment
    ) -> tuple[RealArray, RealArray]:
        """Return the signals of one recording, m/s2, before the noise; `sampling_rate` in Hz."""
        return base, top

    def parameters(self, specimen: SpecimenSettings) -> dict[str, Any]:
        """Return the parameters, in SI, those taken from the specimen included."""
        return self.model_dump(mode="json", exclude={"effect", "perturbation"}, exclude_none=True)


def above_zero(frequency: RealArray) -> RealArray:
    """Return frequencies, Hz, those below 1 Hz replaced by 1 Hz: laws may have a pole at 0."""
    return np.maximum(frequency, 1.0)


def power_law(frequency: RealArray, exponent: float) -> ComplexArray:
    """Return (i f / 500 Hz)^exponent, the causal power law; 1 for an exponent of 0."""
    return np.asarray((1j * above_zero(frequency) / REFERENCE_FREQUENCY) ** exponent)


def resonance(frequency: RealArray, natural: float, loss_factor: float) -> ComplexArray:
    """Return f^2 / (f0^2 - f^2 + i eta f0 f): motion of an oscillator relative to the base that carries it."""
    return np.asarray(frequency**2 / (natural**2 - frequency**2 + 1j * loss_factor * natural * frequency))
