"""The plane harmonic field that all layers of a stack share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray, frequencies
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
        Wavenumber along the layers, rad/m, of a shape that broadcasts with `frequency`; complex of a wave that decays.
    ambient : Gas
        The fluid on the excitation side, which also saturates the pores.
    azimuth : float or array
        Degrees about the normal, from a direction on the stack to the plane of incidence; of a shape that broadcasts
        with `kx`. Only layers that are not isotropic in their plane use it.
    """

    frequency: RealArray
    kx: RealArray | ComplexArray
    ambient: Gas
    azimuth: RealArray | float = 0.0

    @classmethod
    def incident(cls, frequency: ArrayLike, angle: ArrayLike, ambient: Gas, azimuth: ArrayLike = 0.0) -> Wave:
        """Return the field of a plane wave arriving through `ambient`.

        Parameters
        ----------
        frequency : array
            Hz.
        angle : array
            Degrees from the normal, in [0, 90). Every angle meets every frequency: shapes add up.
        ambient : Gas
        azimuth : array
            Degrees about the normal, any; every azimuth meets every angle and frequency.

        Raises
        ------
        InputError
            For a frequency that is not positive, an angle outside [0, 90), an azimuth that is not finite, or none.
        """
        f, theta, psi = frequencies(frequency), np.asarray(angle, dtype=float), np.asarray(azimuth, dtype=float)
        if not (theta.size and psi.size):
            raise InputError("there is no angle of incidence, or no azimuth; give at least one, in degrees")
        if not np.all((theta >= 0) & (theta < 90)):
            raise InputError("an angle of incidence lies outside the range from 0 to below 90 degrees")
        if not np.all(np.isfinite(psi)):
            raise InputError("an azimuth is not finite; azimuths are degrees about the normal")
        f = f.reshape(f.shape + (1,) * (theta.ndim + psi.ndim))
        kx = 2 * np.pi * f / ambient.sound_speed * np.sin(np.deg2rad(theta)).reshape(theta.shape + (1,) * psi.ndim)
        # what does not depend on the azimuth has its axes all the same
        return cls(f, np.broadcast_to(kx, kx.shape[: kx.ndim - psi.ndim] + psi.shape) if psi.ndim else kx, ambient, psi)

    @cached_property
    def omega(self) -> RealArray:
        """Angular frequency, rad/s."""
        return 2 * np.pi * self.frequency
