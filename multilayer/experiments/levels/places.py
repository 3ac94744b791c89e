"""Places of a construction and its measurement at which something unmodelled may act on levels."""

from __future__ import annotations

from functools import partial
from typing import ClassVar

import numpy as np

from multilayer.arrays import RealArray
from multilayer.experiments.levels.effects import LevelEffect, LevelSetting
from multilayer.experiments.levels.sound_field import SoundField, mean_power
from multilayer.experiments.places import BasePlace, changes_nothing
from multilayer.stack import Stack

_REACH, _TABULATED = 1.25, 17  # of laws, in units of the place's scale; values in a table


class LevelPlace(BasePlace):
    """Where something may act on levels; override the hook through which it enters the model.

    A level is a real number, and so is the law: values of shape (m, n) at the frequencies of the data, in `stack` and
    `sound_field` at those of all waves.
    """

    kind = LevelEffect.kind
    is_real = True
    length: ClassVar[float] = 1.0  # bands are wide, and errors of levels smooth
    changes_waves = False

    @changes_nothing
    def stack(self, setting: LevelSetting, stack: Stack, values: RealArray) -> Stack:
        """Return the stack; fields may hold arrays of shape (m, n_waves)."""
        return stack

    @changes_nothing
    def sound_field(self, setting: LevelSetting, sound: SoundField, values: RealArray) -> SoundField:
        """Return the sound field."""
        return sound

    @changes_nothing
    def beside(self, setting: LevelSetting, stack: Stack, share: RealArray, values: RealArray) -> RealArray:
        """Return the share of the power, given that of the construction itself."""
        return share

    def reading(self, setting: LevelSetting, level: RealArray, values: RealArray) -> RealArray:
        """Return the level, dB, or absorption as it is reported."""
        return level


class TabulatedPlace(LevelPlace):
    """A place whose law changes stack or sound field.

    What the law changes depends on its value in the band alone, as it is smooth: it is tabulated over constant laws,
    with the nominal values of all unknowns, so that a law at a place costs no more waves. What unknowns and law change
    multiplies, which holds to first order in both. Tables are right to 0.15 dB where coincidence passes a band, else to
    some hundredths.
    """

    def beside(self, setting: LevelSetting, stack: Stack, share: RealArray, values: RealArray) -> RealArray:
        """Return the share of the power, times what the law changes of the nominal one."""
        reach = _REACH * self.scale((setting,), 1.0)
        at = np.linspace(-reach, reach, _TABULATED)
        table = setting.response.table(self.label, at, partial(self._shares, setting))
        return np.asarray(share * np.exp(table(values) - table(np.zeros_like(values))))

    def _shares(self, setting: LevelSetting, law: RealArray) -> RealArray:
        response = setting.response
        sound = self.sound_field(setting, setting.sound, law)
        changed = self.stack(setting, setting.stack, law)
        share = mean_power(setting.quantity, changed, sound, response.nodes, response.ridges)
        return np.broadcast_to(share, (len(law), share.shape[-1]))


def with_share(share: RealArray, added: RealArray) -> RealArray:
    """Return a share of power to which something is added, or taken away without ever taking more than there is.

    ``t + d`` for d >= 0, and ``t exp(d/t)`` below: slope and value join at 0.
    """
    relative = added / share
    return np.asarray(share * np.where(relative >= 0, 1 + relative, np.exp(np.minimum(relative, 0.0))))
