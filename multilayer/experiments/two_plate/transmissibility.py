"""The transmissibility measured by one burst, and its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.experiments.two_plate.burst import BurstData
from multilayer.measurements.description import Uncertainty


@dataclass(frozen=True)
class Transmissibility:
    """Top over base motion at the frequency of one burst.

    Attributes
    ----------
    frequency : float
        Hz.
    value : complex
    noise : float
        Standard deviation of the real and of the imaginary part from the noise of both channels.
    gain : float
        Relative standard deviation of the amplitude from channels, calibration and remounting.
    delay : float
        Standard deviation of the delay between the channels, s.
    """

    frequency: float
    value: complex
    noise: float = 0.0
    gain: float = 0.0
    delay: float = 0.0

    @property
    def log_shifts(self) -> ComplexArray:
        """Change of ln T by one standard deviation of each independent error, shape (4,)."""
        noise = self.noise / abs(self.value)
        return np.array([noise, 1j * noise, self.gain, -2j * np.pi * self.frequency * self.delay])

    @property
    def amplitude_std(self) -> float:
        """Relative standard deviation of the amplitude."""
        return float(np.linalg.norm(self.log_shifts.real))

    @property
    def phase_std(self) -> float:
        """Standard deviation of the phase, rad."""
        return float(np.linalg.norm(self.log_shifts.imag))


def measure(data: BurstData, known: Uncertainty | None = None) -> Transmissibility:
    """Return the ratio of the two spectra at the burst's stated frequency, with its standard deviations.

    At one frequency, without an average over the band: near a resonance the phase of T changes by radians within a
    burst's band, and the mean is not the transmissibility of any modulus. The ratio is the transmissibility only where
    the record contains the ring-down (`BurstData.cut_short`).

    Parameters
    ----------
    data : BurstData
    known : Uncertainty, optional
        Stated uncertainties of the channels.
    """
    known = known or Uncertainty()
    turn = np.exp(-2j * np.pi * data.frequency / data.sampling_rate * np.arange(data.n_samples))
    base, top = complex(data.base @ turn), complex(data.top @ turn)
    value = top / base
    power = data.n_samples * (data.noise.top**2 + (abs(value) * data.noise.base) ** 2)
    noise = float(np.sqrt(power / 2) / abs(base))
    gain = float(np.linalg.norm([known.channel_gain, known.remount_gain, data.calibration_std]))
    delay = float(np.hypot(known.channel_delay, data.calibration_std / (2 * np.pi * data.frequency)))
    return Transmissibility(data.frequency, value, noise, gain, delay)
