"""The plane harmonic field that all layers of a stack share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from multilayer.arrays import ArrayLike, RealArray
from multilayer.errors import InputError
from multilayer.media.gas import Gas


@dataclass(frozen=True)
class Wave:
    """Frequency and trace wavenumber; time and trace dependence exp(i (w t - kx x1)).

    Attributes
    ----------
    frequency : array
        Hz, positive.
    kx : array
        Wavenumber along the layers, rad/m, of a shape that broadcasts with `frequency`.
    ambient : Gas
        The fluid on the excitation side, which also saturates the pores.
    """

    frequency: RealArray
    kx: RealArray
    ambient: Gas

    @classmethod
    def incident(cls, frequency: ArrayLike, angle: ArrayLike, ambient: Gas) -> Wave:
        """Return the field of a plane wave arriving through `ambient`.

        Parameters
        ----------
        frequency : array
            Hz.
        angle : array
            Degrees from the normal, in [0, 90). Every angle meets every frequency: shapes add up.

        Raises
        ------
        InputError
            For a frequency that is not positive or an angle outside [0, 90).
        """
        f, theta = np.asarray(frequency, dtype=float), np.asarray(angle, dtype=float)
        if not (np.all(f > 0) and np.all(np.isfinite(f))):
            raise InputError("a frequency is zero, negative or not finite; frequencies must be above 0 Hz")
        if not np.all((theta >= 0) & (theta < 90)):
            raise InputError("an angle of incidence lies outside the range from 0 to below 90 degrees")
        f = f.reshape(f.shape + (1,) * theta.ndim)
        return cls(f, 2 * np.pi * f / ambient.sound_speed * np.sin(np.deg2rad(theta)), ambient)

    @cached_property
    def omega(self) -> RealArray:
        """Angular frequency, rad/s."""
        return 2 * np.pi * self.frequency
