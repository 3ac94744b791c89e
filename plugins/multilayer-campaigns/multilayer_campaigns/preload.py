"""What the static weight on a sample does to its modulus, and the modulus without any.

``E1 = E1_0 (1 + b s)`` and ``E2/E1 = eta_0 (1 + d s)``, s the static stress: at every frequency and for every specimen
(height and radius) values at zero stress, the slopes b and d common to all specimens, and to all frequencies where the
data allow. So slopes come from what differs between top plates over the same specimen, never between specimens.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError
from multilayer.inference.consistency import ALIKE, generalised_least_squares, p_value
from multilayer.measurements.description import Campaign
from multilayer_campaigns.modulus_points import ModulusPoint, static_stress
from multilayer_campaigns.preload_result import PreloadResult, Slope
from multilayer_campaigns.stress_regression import Cell, Regression, Solution

_SAME = 0.01  # relative: stresses nearer than this are one


def fit_preload(campaigns: Sequence[str], points: Sequence[ModulusPoint], remarks: Sequence[str] = ()) -> PreloadResult:
    """Find slopes and values at zero stress.

    Parameters
    ----------
    campaigns : sequence of str
        Their names.
    points : sequence of ModulusPoint
    remarks : sequence of str
        What a reader should know besides.

    Raises
    ------
    InputError
        When no specimen was measured under two top plates.

    Notes
    -----
    Generalised least squares by Gauss and Newton's steps. The covariance holds the errors that bursts share (see
    `modulus_points.covariance_of`): those of gain, delay, thickness, density and plate mass mostly leave a slope alone,
    and the value at zero stress keeps them in full.
    """
    contrasted = _contrasted([((p.specimen, p.frequency), p.stress) for p in points])
    if not contrasted:
        raise _no_contrast(campaigns, [p.stress for p in points], "has accepted bursts of one frequency")
    apart = Regression([p for p in points if p.frequency in contrasted], contrasted, (True, True))
    found = apart.solve()
    p_shared = [_p_equal(found.slopes[k], found.scale**2 * found.slope_covariance[k]) for k in range(2)]
    apart_in = (p_shared[0] <= ALIKE, p_shared[1] <= ALIKE)
    kept = apart.points if any(apart_in) else list(points)
    last = Regression(kept, contrasted, apart_in)
    final = last.solve()
    storage, loss = (_slope(k, contrasted, found, final, p_shared[k], apart_in[k]) for k in range(2))
    return PreloadResult(list(campaigns), last, final, storage, loss, list(remarks))


def refuse_one_stress(campaigns: Sequence[Campaign], sensor_mass: float = 0.0) -> None:
    """Refuse campaigns that cannot show any slope, before they are fitted.

    Parameters
    ----------
    campaigns : sequence of Campaign
    sensor_mass : float
        kg.

    Raises
    ------
    InputError
        When no specimen was measured at one frequency under two top plates.
    """
    measured = [
        (((one.specimen_thickness, one.specimen_radius), burst.frequency), static_stress(campaign, one, sensor_mass))
        for campaign in campaigns
        for one in campaign.configurations
        for burst in one.bursts
    ]
    if not _contrasted(measured):
        names = [campaign.folder.resolve().name for campaign in campaigns]
        raise _no_contrast(names, [stress for _, stress in measured], "was measured at one frequency")


def _no_contrast(names: Sequence[str], stresses: Sequence[float], what: str) -> InputError:
    listed = ", ".join(f"{s:.3g} Pa" for s in sorted({round(s, 1) for s in stresses}))
    text = f"{', '.join(names)}: no specimen (height and radius) {what} under two static stresses ({listed})"
    return InputError(f"{text}; measure each under two top plates, or name several campaigns")


def _contrasted(measured: Sequence[tuple[Cell, float]]) -> list[float]:
    """Return the frequencies at which some specimen was measured under two stresses."""
    by_cell: dict[Cell, list[float]] = {}
    for cell, stress in measured:
        by_cell.setdefault(cell, []).append(stress)
    return sorted({f for (_, f), stress in by_cell.items() if max(stress) > (1 + _SAME) * min(stress)})


def _p_equal(values: RealArray, covariance: RealArray) -> float:
    """Return the probability of values as different as these if they are one."""
    mean, _ = generalised_least_squares(values, covariance, np.ones((len(values), 1)))
    return p_value(values - mean, covariance, len(values) - 1)


def _slope(
    which: int, frequencies: list[float], found: Solution, final: Solution, p_shared: float, apart: bool
) -> Slope:
    scale = max(found.scale, final.scale)
    each, covariance = found.slopes[which], scale**2 * found.slope_covariance[which]
    if apart:
        mean, square = generalised_least_squares(each, covariance, np.ones((len(each), 1)))
        p_none = p_value(each, covariance)
    else:
        mean, square = final.slopes[which], scale**2 * final.slope_covariance[which]
        p_none = p_value(mean, square)
    value, variance = float(mean[0]), float(square[0, 0])
    return Slope(value, float(np.sqrt(variance)), np.array(frequencies), each, covariance, p_shared, p_none)
