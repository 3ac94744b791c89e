"""What presses on the front face of a stack, by its spectrum of wavenumbers: forces, rain, hammers, flow."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field
from scipy.special import j1, spherical_jn

from multilayer.arrays import ComplexArray, RealArray
from multilayer.media.gas import Gas
from multilayer.models import Model
from multilayer.units import DIMENSIONLESS, Density, Frequency, Length, PositiveRatio, Speed, Unit

Mass = Annotated[float, Field(gt=0), Unit("kg")]
RainRate = Annotated[float, Field(gt=0), Unit("m^3/m^2/s")]  # 40 mm/h and the like
ForceDensity = Annotated[float, Field(gt=0), Unit("N^2/Hz")]
Share = Annotated[float, Field(ge=0, le=1), Unit(DIMENSIONLESS)]


class Excitation(Model):
    """Pressure on the front face, of a known spectrum S(k) of wavenumbers along the face.

    The pressure is the blocked one, on a front face that does not move, and random: waves of different wavenumbers have
    nothing to do with each other. Its one-sided power spectral density is the integral of S over the plane of
    wavenumbers, divided by (2 pi)^2. Of an excitation that covers the whole face (`per_area`) S is in Pa^2 m^2/Hz and
    all that follows is per square metre; of one at a point, its force squared times its shape, in N^2/Hz.
    """

    per_area: ClassVar[bool] = False

    @abstractmethod
    def spectrum(self, frequency: RealArray, wavenumber: RealArray, gas: Gas) -> RealArray:
        """Return S, one-sided, averaged over the azimuth.

        Parameters
        ----------
        frequency : array
            Hz.
        wavenumber : array
            Along the face, rad/m; broadcasts with `frequency`.
        gas : Gas
            In front.
        """
        raise NotImplementedError

    def towards(self, frequency: RealArray, wavenumber: RealArray, azimuth: RealArray, gas: Gas) -> RealArray:
        """Return S at an azimuth, degrees, for stacks that are not isotropic in their plane; the mean by default."""
        del azimuth
        return self.spectrum(frequency, wavenumber, gas)

    def breaks(self, frequency: RealArray) -> list[RealArray]:
        """Return wavenumbers at which the spectrum has peaks, rad/m, each of the shape of `frequency`."""
        del frequency
        return []

    def softened(self, frequency: RealArray, mobility: ComplexArray) -> RealArray:
        """Return the factor by which a front of this input mobility, m/(N s), lessens the squared force."""
        del mobility
        return np.ones_like(frequency)


def disc(wavenumber: RealArray, radius: float | None) -> RealArray:
    """Return the squared shape of a pressure spread evenly over a disc, 1 at k = 0; 1 everywhere without a radius."""
    if radius is None:
        return np.ones_like(wavenumber)
    x = np.maximum(wavenumber * radius, 1e-9)
    return np.asarray((2 * j1(x) / x) ** 2)


class PointForce(Excitation):
    """A random force at one place, spread evenly over a disc where it has a `radius`.

    The disc matters where the wavelengths are no longer than it; a solid front gives way without bound to a force on a
    point and needs it. A fluid, that in the pores of a front, too, gives way so to the edge of a disc: such a front
    needs a plate or a solid above.
    """

    type: Literal["point_force"] = "point_force"
    spectral_density: ForceDensity = 1.0
    radius: Length | None = None

    def spectrum(self, frequency: RealArray, wavenumber: RealArray, gas: Gas) -> RealArray:
        """Return the density of the force times the shape of the disc."""
        del frequency, gas
        return self.spectral_density * disc(wavenumber, self.radius)


class Rain(Excitation):
    """Equal drops that fall anywhere at any time; by default the heavy rain of laboratories, ISO 10140-1.

    Each drop is a sphere whose slices give up their momentum as they arrive, without splashing back: the force
    ``pi rho v^2 d^2 (s - s^2)`` lasts d/v, s from 0 to 1, and its impulse is the drop's momentum. The drops being
    independent, the spectrum is twice their number per area and time, times the squared transform of the force.
    """

    per_area = True

    type: Literal["rain"] = "rain"
    rate: RainRate = 0.040 / 3600
    drop_diameter: Length = 5e-3
    fall_velocity: Speed = 7.0
    water_density: Density = 1000.0

    def spectrum(self, frequency: RealArray, wavenumber: RealArray, gas: Gas) -> RealArray:
        """Return the spectrum of all drops that fall on a square metre."""
        del gas
        volume = np.pi / 6 * self.drop_diameter**3
        momentum = self.water_density * volume * self.fall_velocity
        x = np.maximum(np.pi * frequency * self.drop_diameter / self.fall_velocity, 1e-9)
        pulse = momentum * 3 * spherical_jn(1, x) / x
        return np.asarray(2 * self.rate / volume * pulse**2 * disc(wavenumber, self.drop_diameter / 2))


class TappingMachine(Excitation):
    """The hammers of ISO 10140-5: 0.5 kg each, falling 40 mm, ten blows per second in all.

    Every blow gives the momentum m v (1 + `restitution`): 0 for a hammer that stays, 1 for one that springs back as
    fast as it came, 6 dB more. Lines lie 10 Hz apart; here their power is spread evenly. A front of input mobility Y
    takes up the hammer's momentum over some time, which lessens the force by 1 + i w m Y (L. Cremer, M. Heckl &
    B. A. T. Petersson, Structure-Borne Sound, Springer 2005), as long as the hammer is in touch.
    """

    type: Literal["tapping_machine"] = "tapping_machine"
    restitution: Share = 0.0
    hammer_mass: Mass = 0.5
    fall_height: Length = 0.040
    blows_per_second: Frequency = 10.0
    radius: Length = 0.015

    def spectrum(self, frequency: RealArray, wavenumber: RealArray, gas: Gas) -> RealArray:
        """Return the spectrum of blows on a rigid floor."""
        del frequency, gas
        impulse = (1 + self.restitution) * self.hammer_mass * np.sqrt(2 * 9.80665 * self.fall_height)
        return np.asarray(2 * self.blows_per_second * impulse**2 * disc(wavenumber, self.radius))

    def softened(self, frequency: RealArray, mobility: ComplexArray) -> RealArray:
        """Return the factor of a hammer that meets a floor of this mobility."""
        return np.asarray(1 / np.abs(1 + 2j * np.pi * frequency * self.hammer_mass * mobility) ** 2)


class TurbulentFlow(Excitation):
    """A turbulent boundary layer that the ambient gas flows past the front face with, at zero pressure gradient.

    Spectrum at a point: M. Goody, AIAA J. 42 (2004) 1788-1794. Correlation along and across the flow: G. M. Corcos,
    J. Acoust. Soc. Am. 35 (1963) 192-199, exponentials that decay with ``decay_along`` and ``decay_across`` per radian
    of convection, by ``convection`` times the `speed`. Corcos' form overrates wavenumbers far below the convective one.
    The radiation into the moving gas is that into the gas at rest. The flow goes along azimuth 0 of the stack.
    """

    per_area = True

    type: Literal["turbulent_flow"] = "turbulent_flow"
    speed: Speed
    boundary_layer_thickness: Length
    friction_velocity: Speed
    convection: PositiveRatio = 0.7
    decay_along: PositiveRatio = 0.116
    decay_across: PositiveRatio = 0.7

    def at_a_point(self, frequency: RealArray, gas: Gas) -> RealArray:
        """Return the one-sided power spectral density of the pressure at a point, Pa^2/Hz."""
        thickness, stress = self.boundary_layer_thickness, gas.density * self.friction_velocity**2
        x = 2 * np.pi * frequency * thickness / self.speed
        ratio = self.friction_velocity**2 * thickness * gas.density / (self.speed * gas.viscosity)
        shape = 3.0 * x**2 / ((x**0.75 + 0.5) ** 3.7 + (1.1 * ratio**-0.57 * x) ** 7)
        return np.asarray(2 * np.pi * shape * stress**2 * thickness / self.speed)

    def spectrum(self, frequency: RealArray, wavenumber: RealArray, gas: Gas) -> RealArray:
        """Return the spectrum, averaged over the azimuth in closed form.

        In c, the cosine of the azimuth, Corcos' form is a rational function with four simple poles z; each of them has
        the mean ``-1/sqrt(z^2 - 1)`` of ``1/(c - z)``, the root of the sign of z.
        """
        k, kc, along, across = self._scales(frequency, wavenumber)
        upper, edge = (kc + 1j * along) / k, np.hypot(1, across / k)
        # 4 A B/((A^2 + (k c - kc)^2)(B^2 + k^2 - k^2 c^2)) by its poles: upper, its conjugate, and -+ edge
        scale = -4 * along * across / k**4
        residue = scale / ((2j * along / k) * (upper**2 - edge**2))
        mean = 2 * np.real(-residue / (np.sqrt(upper - 1) * np.sqrt(upper + 1)))
        for z in (edge, -edge):
            mean = mean - scale / (np.abs(z - upper) ** 2 * 2 * edge * across / k)
        return np.asarray(self.at_a_point(frequency, gas) * mean)

    def towards(self, frequency: RealArray, wavenumber: RealArray, azimuth: RealArray, gas: Gas) -> RealArray:
        """Return the spectrum at an azimuth from the direction of the flow, degrees."""
        k, kc, along, across = self._scales(frequency, wavenumber)
        k1, k2 = k * np.cos(np.deg2rad(azimuth)), k * np.sin(np.deg2rad(azimuth))
        form = 4 * along * across / ((along**2 + (k1 - kc) ** 2) * (across**2 + k2**2))
        return np.asarray(self.at_a_point(frequency, gas) * form)

    def breaks(self, frequency: RealArray) -> list[RealArray]:
        """Return the convective wavenumber."""
        return [2 * np.pi * frequency / (self.convection * self.speed)]

    def _scales(self, frequency: RealArray, wavenumber: RealArray) -> tuple[RealArray, RealArray, RealArray, RealArray]:
        convective = np.asarray(2 * np.pi * frequency / (self.convection * self.speed))
        return np.asarray(wavenumber), convective, self.decay_along * convective, self.decay_across * convective
