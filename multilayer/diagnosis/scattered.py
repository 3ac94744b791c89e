"""Laws all over their prior, to start a search from."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import RealArray
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.inference.least_squares import draw_prior

# where starts are: resonances over the band, how many moduli, angles of loss, points of laws they are chosen from
_AROUND, _LEVELS, _ANGLES, _LAWS = (0.3, 4.0), 20, (0.08, 0.24, 0.47, 0.79, 1.1), 4096
_NEAR_LEVEL, _NEAR_ANGLE, _LIKELY = 0.5, 0.15, 0.02  # what counts as near a level and an angle; against odd laws


def scattered(problem: CampaignProblem) -> RealArray:
    """Return coordinates of the nominal model all over its prior, shape (m, d); what is stated is as stated.

    Laws whose moduli and losses are evenly spread where the sample's resonance may lie. To choose starts by a law's own
    parameters is of little use: what a campaign sees of it first is how stiff and how lossy the sample is in the middle
    of the band.
    """
    f = np.concatenate([data.frequency for data in problem.data])
    stiff = []
    for setting in problem.settings:
        height = setting.configuration.specimen_thickness
        stiff.append((setting.plate_mass / setting.area + problem.campaign.specimen.density * height / 3) * height)
    slow, fast = 2 * np.pi * _AROUND[0] * f.min(), 2 * np.pi * _AROUND[1] * f.max()
    levels = np.linspace(np.log(slow**2 * min(stiff)), np.log(fast**2 * max(stiff)), _LEVELS)
    laws = draw_prior(len(problem.law_parameters), _LAWS, 0)
    e = problem.space.modulus(problem.law_coordinates(laws), np.array([np.sqrt(f.min() * f.max())]))[:, 0]
    off = (
        ((np.log(np.abs(e)) - levels[:, None, None]) / _NEAR_LEVEL) ** 2
        + ((np.angle(e) - np.array(_ANGLES)[:, None]) / _NEAR_ANGLE) ** 2
        + _LIKELY * np.sum(laws**2, axis=-1)
    )
    chosen = laws[np.unique(np.argmin(off, axis=-1))]
    return np.concatenate([chosen, np.zeros((len(chosen), len(problem.parameters) - chosen.shape[1]))], axis=1)
