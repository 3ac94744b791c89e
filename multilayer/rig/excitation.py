"""The excitation of the virtual rig, and how long a record must be."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import fft

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.signals.bursts import hann_burst
from multilayer.signals.envelope import rms
from multilayer.signals.spectra import to_spectrum

REST = 0.005  # s, before the burst
QUIET = 1e-3  # of the top's crest: a record ends when the top rings no louder
SHORTEST_TAIL = 0.04  # s, after the burst
LONGEST_TAIL = 3.0  # s
_REACH = 15.0  # widths 1/duration beside the tone: further off a Hann window has less than 1e-4 of its crest


@dataclass(frozen=True)
class Timing:
    """How the bursts of one configuration are sampled.

    Attributes
    ----------
    sampling_rate : float
        Hz.
    cycles, level : float
        Periods of a burst under its Hann window; rms of the base over it, m/s2.
    frequencies : tuple of float
        Of the bursts, Hz.
    tail : float
        s after a burst within which the rig comes to rest.
    """

    sampling_rate: float
    cycles: float
    level: float
    frequencies: tuple[float, ...]
    tail: float

    @property
    def n_long(self) -> int:
        """Samples from the start to where everything is at rest, after the longest burst."""
        longest = self.cycles / min(self.frequencies)
        return int(np.ceil((REST + longest + self.tail) * self.sampling_rate)) + 1

    @property
    def n_fft(self) -> int:
        """Transform length, at least twice `n_long`, so that no ring-down wraps round to the start."""
        return int(fft.next_fast_len(2 * self.n_long, real=True))

    def band(self, frequencies: tuple[float, ...]) -> tuple[float, float]:
        """Return from where to where, Hz, the spectra of bursts reach."""
        highest = max(frequencies) * (1 + _REACH / self.cycles)
        return 0.1 * min(frequencies), min(highest, 0.5 * self.sampling_rate)

    def during(self, frequency: float) -> slice:
        """Return the samples of a burst."""
        first = int(np.ceil(REST * self.sampling_rate))
        return slice(first, int((REST + self.cycles / frequency) * self.sampling_rate) + 1)

    def base(self, frequency: float, *, oversampling: int = 1) -> RealArray:
        """Return the base's acceleration, m/s2, shape (n_long * oversampling,)."""
        rate, n = oversampling * self.sampling_rate, oversampling * self.n_long
        return hann_burst(frequency, self.cycles, rate, self.level, n_samples=n, start=REST)

    def base_spectrum(self, frequency: float) -> ComplexArray:
        """Return the spectrum of `base` over the bins of `n_fft`."""
        return to_spectrum(self.base(frequency), self.n_fft)

    def level_of(self, signal: RealArray, frequency: float) -> float:
        """Return the rms of a channel over the burst and over all repeats, m/s2."""
        return float(rms(np.ravel(signal[..., self.during(frequency)])))

    def n_samples(self, top: RealArray, frequency: float) -> int:
        """Return the length of a record that holds the burst and the ring-down of `top`."""
        least = int((REST + self.cycles / frequency + SHORTEST_TAIL) * self.sampling_rate)
        loud = np.flatnonzero(np.abs(top) > QUIET * np.max(np.abs(top)))
        return int(min(max(least, loud[-1] + 1), top.size))


def ring_down(modulus: Callable[[ArrayLike], ComplexArray], per_modulus: float, lowest: float) -> float:
    """Return the time, s, in which free vibrations of the mass on the sample fall by 60 dB; infinite without loss.

    The natural frequency w solves ``w^2 = Re k(w)``, k the stiffness over the mass; the amplitude falls as
    ``exp(-w eta t / 2)``.

    Parameters
    ----------
    modulus : callable
        Complex modulus, Pa, at a frequency, Hz.
    per_modulus : float
        Stiffness of the sample over its modulus and the moving mass, 1/(Pa s2).
    lowest : float
        Hz, where the search for the natural frequency starts.
    """
    f = lowest
    for _ in range(20):  # the modulus varies slowly: each step is closer by its slope, 0.3 at most
        f = float(np.sqrt(complex(modulus(f)).real * per_modulus)) / (2 * np.pi)
    loss = complex(modulus(f)).imag / complex(modulus(f)).real
    return float(np.log(1 / QUIET) / (np.pi * f * loss)) if loss > 0 else float("inf")
