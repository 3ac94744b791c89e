"""A modulus that falls with dynamic strain.

A. R. Payne, J. Appl. Polym. Sci. 6 (1962) 57-63. Response at the tone's frequency: describing functions, A. Gelb &
W. E. Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, McGraw-Hill 1968.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.polynomial.legendre import leggauss

from multilayer.arrays import ComplexArray, RealArray, distinct_rows
from multilayer.diagnosis.effects.base import Effect, Setting, Values, between, positive

_POWERS = (0.4, 2.0)
_USUAL_STRAIN = 1e-3  # of a foam of 25 mm near its resonance on a shaker of 5 m/s2
_TURN, _OF_TURN = (0.5 * x for x in leggauss(6))  # points of a quarter of a period, in quarters, and their weights
_ANGLES = 0.5 * np.pi * (_TURN + 0.5)
_SINES = np.sin(_ANGLES)
# of a period's points: shares in the first harmonic of a stress, in its third, and of a modulus in what acts on the
# third harmonic of the strain and shifts that to the first
_FIRST = 2 * _OF_TURN * _SINES**2
_THIRD = 2 * _OF_TURN * _SINES * np.sin(3 * _ANGLES)
_SWINGS = (
    2 * _OF_TURN[:, np.newaxis] * np.stack([np.sin(3 * _ANGLES) ** 2, np.cos(2 * _ANGLES), np.cos(4 * _ANGLES)], axis=1)
)
_HEIGHT, _OF_HEIGHT = (0.5 * x for x in leggauss(3))  # points of the height from its middle, and their weights
_AT = 6  # of the nodes of strain: where most of a burst's energy is


class AmplitudeSoftening(Effect):
    """The modulus falls with the strain: at once, or as the structure of the sample follows the burst.

    At once: the stress is that of a linear sample of the strain ``e / (1 + n y)^(1/n)``, with harmonics, where ``y = b
    |e| (|e| / 1e-3)^(n-1)``. The power n is 1 where the modulus falls in proportion to the strain: ``e / (1 + b |e|)``.
    The strain's amplitude varies within a burst, so that the ratio of stress to strain differs by bin and burst as no
    linear modulus does: the describing function at each instant's amplitude, times the strain of the two channels, has
    a spectrum, and its ratio to that of the strain multiplies the modulus. Over the height the stress varies as in a
    linear rod; what is strained more yields more. Compliances add up along the height, weighed with the stress and with
    that of a force on the top plate.

    With memory: filled rubbers show the softening almost without harmonics, because what the strain breaks up recovers
    in many periods; the modulus of a burst is then ``E / (1 + n y)^(1/n)`` at the amplitude of a steady tone. The
    memory m interpolates between the two, as a weighted geometric mean of both factors.

    Limits: of harmonics of the strain itself the third is taken in, where it is small. Beside a rod solved in time the
    change of the plate's motion is right to 0.7 % of itself, under a plate of twice the sample's mass to 2.5 %.
    """

    name = "amplitude_softening"
    place = "sample_strain"
    acts_through_place = False
    law = "E / (1 + n y)^(1/n), y = b e0 (e0 / 1e-3)^(n-1); or the same of every instant's strain, with harmonics"
    separated_by = "another level; harmonics"
    source = "filled rubbers (Payne) and foams: 1 to 30 % at strains of 1e-3"
    moves_resonances = True
    is_slow = True
    acts_by_bin = True
    # 37 right names of seeds 1012 to 1017: off by 1.3 % in the median, rms 3.8 %, noise included
    size_errors: ClassVar[Mapping[str, float]] = {"softening": 0.025}
    # powers of the strain: 1.2 of filled rubbers (G. Kraus, J. Appl. Polym. Sci. Appl. Polym. Symp. 39 (1984) 75-92)
    parameters = (
        positive("softening", 50.0, 1.5),
        between("memory", 0.0, 1.0),
        positive("power", 1.0, 0.3, "", _POWERS),
    )
    starts = tuple((size, memory, 0.0) for memory in (-2.0, 2.0) for size in (-2.0, -1.0, 0.0, 1.0, 2.0))
    aside = ("memory", "power")

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """Return stress over strain at every bin."""
        b, memory, n = values["softening"], values["memory"], values["power"]
        unit = b * _USUAL_STRAIN ** (1 - n)
        at_once = setting.by_strain(_distinct_over_height(setting, modulus, unit, n))
        with_memory = (1 + n * unit * setting.burst_strain**n) ** (-1 / n)
        return np.asarray(modulus * np.exp((1 - memory) * np.log(at_once) + memory * np.log(with_memory)))


def _distinct_over_height(setting: Setting, modulus: ComplexArray, unit: RealArray, power: RealArray) -> ComplexArray:
    """Return `_over_height`, computed once for points that differ in nothing that it takes, as most of a derivative."""
    if modulus.ndim != 2:
        return _over_height(setting, modulus, unit, power)
    of_rows = [np.broadcast_to(column, (len(modulus), 1)) for column in (unit, power)]
    kept, place = distinct_rows(modulus.real, modulus.imag, *of_rows)
    return _over_height(setting, modulus[kept], *(column[kept] for column in of_rows))[place]


def _over_height(setting: Setting, modulus: ComplexArray, unit: RealArray, power: RealArray) -> ComplexArray:
    """Return the sample's secant modulus over E at `Setting.strain_nodes`, shape (..., n_bursts, k).

    Parameters
    ----------
    setting : Setting
    modulus : complex array, shape (..., n)
        E, Pa.
    unit, power : array, shape (..., 1)
        ``y = unit e^power``.
    """
    n = np.asarray(power)[..., np.newaxis]
    y = np.asarray(unit)[..., np.newaxis] * setting.strain_nodes**n
    gain, fall = _describing(y, n)
    height, density = setting.configuration.specimen_thickness, setting.campaign.specimen.density
    softened = modulus[..., setting.nearest] * gain[..., _AT]
    phase = 2 * np.pi * setting.data.centres * height * np.sqrt(density / softened)
    load = setting.plate_mass / (setting.area * height * density) * phase
    phase, load = phase[..., np.newaxis], load[..., np.newaxis]
    above = phase * (0.5 - _HEIGHT)
    stress = np.sin(above) + load * np.cos(above)
    uneven = np.abs(stress / np.sum(_OF_HEIGHT * stress, axis=-1, keepdims=True)) - 1
    weight = _OF_HEIGHT * stress * np.cos(phase * (0.5 + _HEIGHT))
    weight = weight / np.sum(weight, axis=-1, keepdims=True)
    # a strain that is more by some per cent than the mean: by that of the stress, over what the secant leaves of it
    strain = np.maximum(1 + uneven[..., np.newaxis, :] / (1 + fall[..., np.newaxis]), 0.0)
    secant, _ = _within_period(y[..., np.newaxis] * strain ** n[..., np.newaxis], n[..., np.newaxis])
    even = 1 / np.sum(weight[..., np.newaxis, :] / (secant @ _FIRST), axis=-1)
    return np.asarray(even + _by_third_harmonic(setting, modulus, y, n))


def _by_third_harmonic(setting: Setting, modulus: ComplexArray, y: RealArray, power: RealArray) -> ComplexArray:
    """Return what the third harmonic of the strain adds to the describing function, to first order.

    The stress of a strain of one frequency has a third harmonic. It moves the plate, as a stress that is uniform over a
    rod does, and the swings of the modulus in a period, ``p0 + p2 cos 2 w t + p4 cos 4 w t``, shift the strain so made
    to the first harmonic. The modulus at 3 f follows from that at f as a power of the frequency, whose exponent is 2/pi
    of the loss angle.
    """
    secant, spread = _within_period(y, power)
    tangent = secant / (1 + spread)
    stress = secant @ _THIRD
    own, second, fourth = np.moveaxis(tangent @ _SWINGS, -1, 0)
    height, density = setting.configuration.specimen_thickness, setting.campaign.specimen.density
    here = modulus[..., setting.nearest]
    squared = (6 * np.pi * setting.data.centres * height) ** 2 / (here * 3 ** (2 / np.pi * np.angle(here)))
    squared = density * squared[..., np.newaxis]  # of 3 w h over the speed of waves
    phase = np.sqrt(squared / own)
    load = setting.plate_mass / (setting.area * height * density)
    strain = -stress / (own * phase / np.tan(phase) - load * squared)
    return np.asarray(0.5 * (second - fourth) * strain.real + 0.5j * (second + fourth) * strain.imag)


def _describing(y: RealArray, power: RealArray) -> tuple[RealArray, RealArray]:
    """Return the first harmonic of ``e / (1 + n y)^(1/n)`` over that of e, and its derivative, as of logarithms."""
    secant, spread = _within_period(y, power)
    gain = secant @ _FIRST
    return gain, -((secant * spread / (1 + spread)) @ _FIRST) / gain


def _within_period(y: RealArray, power: RealArray) -> tuple[RealArray, RealArray]:
    """Return ``1 / (1 + n y)^(1/n)`` at points of a period, and ``n y`` there."""
    n = power[..., np.newaxis]
    spread = n * y[..., np.newaxis] * _SINES**n
    return np.exp(-np.log1p(spread) / n), spread
