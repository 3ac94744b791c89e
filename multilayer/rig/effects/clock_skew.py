"""A clock of the top channel that runs too slow."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import RealArray
from multilayer.rig.effect_base import Effect, Moment, Size
from multilayer.signals.spectra import padded_length, to_signal, to_spectrum
from multilayer.units import DIMENSIONLESS, Unit

_OVERSAMPLING = 8


class ClockSkew(Effect):
    """The top channel's converter has a clock of its own, too slow by `skew`: top(t (1 + skew)), t from the trigger.

    The top channel's lead thus grows over each record. Perturbed: top(t (1 + skew) + p skew t^2 / 0.1 s), a clock that
    drifts.
    """

    effect: Literal["clock_skew"] = "clock_skew"
    skew: Annotated[float, Field(ge=-0.01, le=0.01), Unit(DIMENSIONLESS)] = 200e-6

    known = False
    drawn = Size("skew", 2e-5, 2e-3, signed=True)

    def apply_to_signals(
        self, base: RealArray, top: RealArray, sampling_rate: float, moment: Moment
    ) -> tuple[RealArray, RealArray]:
        time = np.arange(top.size) / sampling_rate
        read_at = time * (1 + self.skew * (1 + self.perturbation * time / 0.1))
        return base, resampled(top, read_at * sampling_rate)


def resampled(signal: RealArray, index: RealArray) -> RealArray:
    """Return a band-limited signal at fractional indices; 0 beyond its ends.

    It is padded with zeros, oversampled by its Fourier series, and read by splines of fifth order.
    """
    from scipy.interpolate import make_interp_spline  # heavy

    n_fft = padded_length(signal.size)
    dense = _OVERSAMPLING * to_signal(to_spectrum(signal, n_fft), _OVERSAMPLING * n_fft, _OVERSAMPLING * signal.size)
    spline = make_interp_spline(np.arange(dense.size) / _OVERSAMPLING, dense, k=5)
    inside = (index >= 0) & (index <= signal.size - 1)
    return np.asarray(np.where(inside, spline(np.clip(index, 0, signal.size - 1)), 0.0))
