"""Places in the channels."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from multilayer.diagnosis.places.base import ComplexArray, Place, Setting


class Reading(Place):
    """The chains of sensors: the logarithm of every reading, amount and phase, changes alike."""

    name = "reading"
    is_reading = True
    title = "in the reading"
    quantity = "change of ln(top/base)"
    terms: ClassVar = {
        0: ("change of ln gain", ""), 1: ("lead", "s"), -1: ("high pass", "Hz"),
        "resonance": ("resonance of a sensor", ""),
    }  # fmt: skip

    def motion(self, setting: Setting, motion: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the motion times ``exp(law)``."""
        return np.asarray(motion * np.exp(values))

    @classmethod
    def variants(cls) -> tuple[type[Reading], ...]:
        """Return what every instant of a record has alike, and what grows over it."""
        return (Reading, ReadingOverTime)


class ReadingOverTime(Reading):
    """The chains of sensors, over the time of each record: the clock of the top channel runs off that of the base.

    Read at ``t (1 + s)`` in place of t, the time since the record's first sample, what is measured is ``S(f) = X(f/(1 +
    s))/(1 + s)``, X the spectrum of the plate's motion: ln(top/base) changes by ``-ln(1 + s) - [ln S(f (1 + s)) - ln
    S(f)]``, here to second order in s. Where the energy of a bin arrives at t, that is a delay of ``-s t``.

    Limits: the third order is ``(s w T)^3``, T the duration of a burst: 0.0017 for 1 % of 10 cycles (T 0.2 of them).
    """

    variant = "over_time"
    title = "in the reading, growing over each record"
    quantity = "relative skew of the top channel's clock"
    acts_by_bin = True
    needs = "top_slopes"
    terms: ClassVar = {0: ("clock skew", "")}

    def scale(self, settings: tuple[Setting, ...], modulus: float) -> float:
        """Return the skew that changes ln(top/base) by 1 where it does most."""
        return 1 / max(float(np.abs(_by_skew(setting)[0]).max()) for setting in settings)

    def motion(self, setting: Setting, motion: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the motion as it is read by that clock."""
        first, second = _by_skew(setting)
        skew = np.log1p(values)
        return np.asarray(motion * np.exp(skew * first + skew**2 * second))


def _by_skew(setting: Setting) -> ComplexArray:
    """Return the change of ln(top/base) by ln(1 + s) of a skew s, and by its square, shape (2, n)."""
    slopes = setting.data.top_slopes
    if slopes is None:
        raise ValueError("without the spectrum of the top channel nothing is known of time")
    return np.stack([-1 - slopes[0], -slopes[1] / 2])


class AddedReading(Place):
    """A share of the base's motion that the top channel shows besides."""

    name = "added_reading"
    is_reading = True
    title = "added to the reading"
    quantity = "share of the base's motion"
    terms: ClassVar = {
        0: ("constant share", ""), 1: ("share that rises with frequency", "s"), "resonance": ("resonance", ""),
    }  # fmt: skip

    def motion(self, setting: Setting, motion: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the motion with a share of the base's."""
        return np.asarray(motion + values)
