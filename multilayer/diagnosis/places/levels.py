"""Places of a construction and of its measurement at which something unknown may change levels.

What the scale of a place calls usual is a standard deviation of the wider prior of its law, 0.3 of that scale.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.cavity_damping import air_between, with_cavity_losses
from multilayer.diagnosis.effects.flow_resistivity import resistive
from multilayer.diagnosis.effects.levels import LevelSetting, SoundField, plates_of, with_each
from multilayer.diagnosis.levels.paths import link_transmission
from multilayer.diagnosis.places.base import LevelPlace
from multilayer.experiments.levels.places import TabulatedPlace, with_share
from multilayer.experiments.stacks.places import with_factors
from multilayer.layers.base import ElasticLayer
from multilayer.stack import Stack

_LOSS = "transmission_loss"
_STUDS = 0.5  # m apart: what links are measured by
_CAVITY_LOSS, _LEAST_CAVITY_LOSS = (
    0.05,
    -0.01,
)  # loss factor that a cavity's law is measured by; the least a law may give


class BesideTheWall(LevelPlace):
    """A path beside the construction, the same beside each: holes, flanks.

    x of the share ``t0 (exp(x) - 1)`` that is added, t0 being the geometric mean of what the measured constructions let
    through.
    """

    name = "beside"
    title = "beside the construction"
    quantity = "ln(1 + path over mean share)"
    detunes = True
    passive_sign, passive_part = 1, "real"

    @classmethod
    def instances(cls, settings: tuple[LevelSetting, ...]) -> list[LevelPlace]:
        """Return the place beside constructions that let sound through."""
        wanted = all(setting.quantity == _LOSS for setting in settings)
        return [_Beside(tuple(settings))] if wanted else []

    def scale(self, settings: tuple[LevelSetting, ...], modulus: float) -> float:
        """Return 10: at the wider prior (`LAW_SIZES`) a path of 20 times the mean share is usual."""
        return 10.0


@dataclass(frozen=True)
class _Beside(BesideTheWall):
    """The place with the constructions that its law is relative to."""

    measured: tuple[LevelSetting, ...] = ()

    def beside(self, setting: LevelSetting, stack: Stack, share: RealArray, values: RealArray) -> RealArray:
        """Return the share of the power with that of the path."""
        return with_share(share, mean_share(self.measured, setting) * np.expm1(values))


def mean_share(measured: tuple[LevelSetting, ...], setting: LevelSetting) -> RealArray:
    """Return the geometric mean of what nominal constructions let through, at the frequencies of one, shape (n,)."""
    f = np.log(setting.frequency)
    logs = [np.interp(f, np.log(other.frequency), np.log(other.nominal_share)) for other in measured]
    return np.asarray(np.exp(np.mean(logs, axis=0)))


class Links(LevelPlace):
    """Links between leaves, by a factor exp(x) - 1 on what rigid studs half a metre apart would carry."""

    name = "links"
    title = "in links between the leaves"
    quantity = "ln(1 + links over rigid studs)"
    detunes = True
    passive_sign, passive_part = 1, "real"

    @classmethod
    def instances(cls, settings: tuple[LevelSetting, ...]) -> list[LevelPlace]:
        """Return the place where a construction has leaves with something between."""
        return [cls()] if any(setting.quantity == _LOSS and _leaves(setting.stack) for setting in settings) else []

    def scale(self, settings: tuple[LevelSetting, ...], modulus: float) -> float:
        """Return 5: usual are links of 3.5 times what rigid studs carry."""
        return 5.0

    def beside(self, setting: LevelSetting, stack: Stack, share: RealArray, values: RealArray) -> RealArray:
        """Return the share of the power with that of the links."""
        pair = _leaves(stack)
        if pair is None:
            return share
        rigid = link_transmission(setting.frequency, *pair, _STUDS, 0.0, setting.gas)
        return with_share(share, rigid * np.expm1(values))


def _leaves(stack: Stack) -> tuple[ElasticLayer, ElasticLayer] | None:
    plates = plates_of(stack)
    if len(plates) < 2 or plates[-1] - plates[0] < 2:
        return None
    front, back = stack.layers[plates[0]], stack.layers[plates[-1]]
    assert isinstance(front, ElasticLayer)
    assert isinstance(back, ElasticLayer)
    return front, back


class OfBoards(TabulatedPlace):
    """All plates of all constructions, by one of their properties."""

    @classmethod
    def instances(cls, settings: tuple[LevelSetting, ...]) -> list[LevelPlace]:
        """Return the place where there are plates."""
        return [cls()] if any(setting.quantity == _LOSS and plates_of(setting.stack) for setting in settings) else []


class BoardsMass(OfBoards):
    """The mass of all plates."""

    name = "boards_mass"
    title = "in the mass of the boards"
    quantity = "change of ln mass"

    def stack(self, setting: LevelSetting, stack: Stack, values: RealArray) -> Stack:
        """Return the stack with other masses."""
        return with_each(stack, plates_of(stack), "density", np.exp(values))


class BoardsStiffness(OfBoards):
    """The stiffness of all plates, their loss factor kept."""

    name = "boards_stiffness"
    title = "in the stiffness of the boards"
    quantity = "change of ln modulus"

    def scale(self, settings: tuple[LevelSetting, ...], modulus: float) -> float:
        """Return 2: usual are factors of 1.8."""
        return 2.0

    def stack(self, setting: LevelSetting, stack: Stack, values: RealArray) -> Stack:
        """Return the stack with other moduli."""
        for index in plates_of(stack):
            stack = with_factors(stack, stack.layers[index].name or str(index), young_modulus=np.exp(values))
        return stack


class BoardsDamping(OfBoards):
    """The losses of all plates."""

    name = "boards_damping"
    title = "in the losses of the boards"
    quantity = "change of ln loss factor"

    def scale(self, settings: tuple[LevelSetting, ...], modulus: float) -> float:
        """Return 5: usual are factors of 4.5."""
        return 5.0

    def stack(self, setting: LevelSetting, stack: Stack, values: RealArray) -> Stack:
        """Return the stack with other losses."""
        return with_each(stack, plates_of(stack), "loss_factor", np.exp(values))


class Cavity(TabulatedPlace):
    """Losses of the air between plates: loss factor 0.05 (exp(x) - 1)."""

    name = "cavity"
    title = "in the air of the cavity"
    quantity = "ln of 1 + loss factor over 0.05"
    passive_sign, passive_part = 1, "real"

    @classmethod
    def instances(cls, settings: tuple[LevelSetting, ...]) -> list[LevelPlace]:
        """Return the place where there is air between plates."""
        return [cls()] if any(setting.quantity == _LOSS and air_between(setting.stack) for setting in settings) else []

    def scale(self, settings: tuple[LevelSetting, ...], modulus: float) -> float:
        """Return 5: a loss factor of 0.17 is usual."""
        return 5.0

    def stack(self, setting: LevelSetting, stack: Stack, values: RealArray) -> Stack:
        """Return the stack with losses in its cavities."""
        return with_cavity_losses(stack, np.maximum(_CAVITY_LOSS * np.expm1(values), _LEAST_CAVITY_LOSS))


class Filling(TabulatedPlace):
    """The flow resistivity of all porous layers."""

    name = "filling"
    title = "in the porous layers"
    quantity = "change of ln flow resistivity"

    @classmethod
    def instances(cls, settings: tuple[LevelSetting, ...]) -> list[LevelPlace]:
        """Return the place where there are layers with a flow resistivity."""
        return [cls()] if any(resistive(setting.stack) for setting in settings) else []

    def scale(self, settings: tuple[LevelSetting, ...], modulus: float) -> float:
        """Return 3: usual are factors of 2.5."""
        return 3.0

    def stack(self, setting: LevelSetting, stack: Stack, values: RealArray) -> Stack:
        """Return the stack with other flow resistivities."""
        return with_each(stack, resistive(stack), "flow_resistivity", np.exp(values))


class Field(TabulatedPlace):
    """The directions of sound: relative intensity exp(x (s - 1/2)), s = sin^2 of the angle over its largest value."""

    name = "field"
    title = "in the sound field"
    quantity = "ln(grazing over normal)"

    @classmethod
    def instances(cls, settings: tuple[LevelSetting, ...]) -> list[LevelPlace]:
        """Return the place where fields are diffuse."""
        return [cls()] if any(setting.sound.is_diffuse for setting in settings) else []

    def scale(self, settings: tuple[LevelSetting, ...], modulus: float) -> float:
        """Return 10: grazing sound 20 times as strong as normal is usual."""
        return 10.0

    def sound_field(self, setting: LevelSetting, sound: SoundField, values: RealArray) -> SoundField:
        """Return the field with other intensities."""
        return replace(sound, tilt=sound.tilt + values)


class LevelReading(LevelPlace):
    """What is reported, alike of all measurements."""

    name = "reading"
    is_reading = True
    title = "in the reading"
    quantity = "change of what is reported"
    unit = "dB"

    @classmethod
    def instances(cls, settings: tuple[LevelSetting, ...]) -> list[LevelPlace]:
        """Return the place, whose law has the unit of what is measured."""
        return [cls() if settings[0].quantity == _LOSS else AbsorptionReading()]

    def scale(self, settings: tuple[LevelSetting, ...], modulus: float) -> float:
        """Return 10 dB, or 0.5 of absorption: 3 dB and 0.15 are usual."""
        return 10.0 if settings[0].quantity == _LOSS else 0.5

    def reading(self, setting: LevelSetting, level: RealArray, values: RealArray) -> RealArray:
        """Return the level with the change."""
        return np.asarray(level + values)


class AbsorptionReading(LevelReading):
    """What is reported of absorption."""

    unit = ""


@dataclass(frozen=True)
class OneLevel(LevelReading):
    """One measurement that is not like the others.

    Attributes
    ----------
    configuration : str
        Its name.
    """

    configuration: str = ""

    name = "one_measurement"
    title = "in one measurement only"
    quantity = "change in that measurement"

    @classmethod
    def instances(cls, settings: tuple[LevelSetting, ...]) -> list[LevelPlace]:
        """Return a place for each measurement, where there are several."""
        kind = cls if settings[0].quantity == _LOSS else OneAbsorption
        return [kind(setting.name) for setting in settings] if len(settings) > 1 else []

    def reading(self, setting: LevelSetting, level: RealArray, values: RealArray) -> RealArray:
        """Return the level, which changes in this measurement."""
        return np.asarray(level + values) if setting.name == self.configuration else level


@dataclass(frozen=True)
class OneAbsorption(OneLevel):
    """One measurement of absorption that is not like the others."""

    unit = ""
