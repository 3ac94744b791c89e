"""Moduli of several bursts, mountings and campaigns side by side, with the errors that they have in common.

A gain that is 0.3 % too large spoils every burst of a campaign, each by another amount and none by chance. Whoever
compares bursts as if their standard deviations were independent finds differences that are none, or misses some.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError
from multilayer.experiments.two_plate.campaign import MODEL_ERROR
from multilayer.experiments.two_plate.ratios import SMOOTH
from multilayer.fits.burst.uncertainty import ErrorParts
from multilayer.fits.result import BurstFit, FitResult
from multilayer.measurements.description import Campaign, Configuration
from multilayer.rig.effect_base import GRAVITY

Specimen: TypeAlias = tuple[float, float]
"""Thickness and radius, m: what tells the specimens of a campaign apart."""
_FLOOR = 1e-6  # of ln E1 and loss factor: rounding


@dataclass(frozen=True)
class ModulusPoint:
    """What one burst says of the material.

    Attributes
    ----------
    campaign : int
        Which of several.
    configuration : str
    frequency : float
        Hz.
    specimen : tuple of float
        Thickness and radius, m.
    stress : float
        Static, from what lies on the sample, Pa.
    storage_modulus, loss_factor : float
        Pa, and E2/E1.
    spread : tuple of float
        Standard deviations of ln E1 and of the loss factor.
    errors : ErrorParts
        What these consist of.
    """

    campaign: int
    configuration: str
    frequency: float
    specimen: Specimen
    stress: float
    storage_modulus: float
    loss_factor: float
    spread: tuple[float, float]
    errors: ErrorParts


def static_stress(campaign: Campaign, configuration: Configuration, sensor_mass: float = 0.0) -> float:
    """Return the weight of top plate and accelerometer (kg) over the area of the sample, Pa."""
    plate = campaign.top_plate.density * configuration.top_plate_thickness
    return GRAVITY * (plate + sensor_mass / (math.pi * configuration.specimen_radius**2))


def points_of(index: int, campaign: Campaign, result: FitResult, sensor_mass: float = 0.0) -> list[ModulusPoint]:
    """Return the accepted bursts of a campaign's result.

    Parameters
    ----------
    index : int
        Of the campaign, among those that are compared.
    campaign : Campaign
    result : FitResult
    sensor_mass : float
        kg, for the static stress.

    Raises
    ------
    InputError
        When there is none, or the result does not say what its uncertainties consist of.
    """
    found = [_point(index, campaign, burst, sensor_mass) for burst in result.bursts if burst.accepted]
    if not found:
        raise InputError(f"{campaign.folder}: no burst has an accepted solution; 'multilayer fit' says why")
    return found


def _point(index: int, campaign: Campaign, burst: BurstFit, sensor_mass: float) -> ModulusPoint:
    configuration = campaign.configuration(burst.configuration)
    if burst.errors is None:
        raise InputError(f"{campaign.folder}: the parts of the uncertainties are missing; fit the campaign anew")
    # without stated uncertainties the mean is one over the region of eq. (10), which these errors say nothing of
    stated, best = bool(burst.errors.stated), burst.optimum
    return ModulusPoint(
        campaign=index,
        configuration=burst.configuration,
        frequency=burst.frequency,
        specimen=(configuration.specimen_thickness, configuration.specimen_radius),
        stress=static_stress(campaign, configuration, sensor_mass),
        storage_modulus=burst.storage_modulus if stated else best.storage_modulus,
        loss_factor=burst.loss_factor if stated else best.loss_modulus / best.storage_modulus,
        spread=(burst.storage_modulus_std / burst.storage_modulus, burst.loss_factor_std),
        errors=burst.errors,
    )


def values_of(points: Sequence[ModulusPoint]) -> RealArray:
    """Return ln E1 of all points, then their loss factors, shape (2 n,)."""
    return np.array([math.log(p.storage_modulus) for p in points] + [p.loss_factor for p in points])


def covariance_of(
    points: Sequence[ModulusPoint], scatter: float = 0.0, common: frozenset[str] = frozenset()
) -> RealArray:
    """Return the covariance of `values_of`, shape (2 n, 2 n).

    Parameters
    ----------
    points : sequence of ModulusPoint
    scatter : float
        Relative standard deviation of E1, and of the loss factor, from specimen to specimen.
    common : set of str
        Errors that are the same in all campaigns, as ``channel_gain``.

    Notes
    -----
    Gain and delay of the channels, density and plate mass are one error per campaign, the remounting's gain one per
    configuration, the thickness one per height. Errors of different campaigns are independent but for `common`. The
    model's own error (0.2 % of the transmissibility, smooth in ln f) is one function of frequency per configuration.
    """
    n = len(points)
    total = np.diag(np.full(2 * n, _FLOOR**2))
    for i, point in enumerate(points):
        total[np.ix_([i, n + i], [i, n + i])] += _own(point)
    shared = _shared(points, scatter, common)
    return np.asarray(total + shared @ shared.T + _of_the_model(points))


def _own(point: ModulusPoint) -> RealArray:
    """Return the covariance of a burst's own errors, enlarged to what its standard deviations say in all.

    Those come from a region of solutions, and are larger than its linear outline where it bends.
    """
    own = np.array(point.errors.own)
    if point.errors.stated:
        missing = np.square(point.spread) - np.diag(point.errors.covariance)
        own += np.diag(np.maximum(missing, 0.0))
    return own


def _shared(points: Sequence[ModulusPoint], scatter: float, common: frozenset[str]) -> RealArray:
    """Return a column for each error that several points share, shape (2 n, n_errors)."""
    n, columns = len(points), dict[Hashable, RealArray]()
    for i, point in enumerate(points):
        stated = point.errors.stated.items()
        parts = {name if name in common else _owner(name, point): shift for name, shift in stated}
        specimen = (point.campaign, point.specimen)
        parts["stiffness", specimen] = np.array([scatter, 0.0])
        parts["damping", specimen] = np.array([0.0, scatter * point.loss_factor])
        for owner, shift in parts.items():
            columns.setdefault(owner, np.zeros(2 * n))[[i, n + i]] = shift
    return np.stack(list(columns.values()), axis=1)


def _owner(error: str, point: ModulusPoint) -> Hashable:
    if error == "thickness":
        return error, point.campaign, point.specimen[0]
    if error == "remount_gain":
        return error, point.campaign, point.configuration
    return error, point.campaign


def _of_the_model(points: Sequence[ModulusPoint]) -> RealArray:
    n = len(points)
    mounting = [(point.campaign, point.configuration) for point in points]
    same = np.array([[one == other for other in mounting] for one in mounting])
    log_f = np.log([point.frequency for point in points])
    alike = same * np.exp(-0.5 * (np.subtract.outer(log_f, log_f) / SMOOTH) ** 2)
    shifts = MODEL_ERROR * np.array([point.errors.model for point in points])  # (n, level or phase, ln E1 or loss)
    total = np.zeros((2 * n, 2 * n))
    for kind in range(2):
        column = shifts[:, kind].T.reshape(-1)
        total += np.outer(column, column) * np.tile(alike, (2, 2))
    return total
