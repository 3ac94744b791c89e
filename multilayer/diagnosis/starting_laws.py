"""Starting points of a search: free laws at places, other minima, and modulus laws spread over their prior."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.place_fits import PlaceFit
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.inference.least_squares import draw_prior
from multilayer.inference.multistart import is_far_off
from multilayer.inference.problem import Minimum

# resonances relative to the band, number of moduli, loss angles (rad), laws that are drawn to choose from
_AROUND, _LEVELS, _ANGLES, _LAWS = (0.3, 4.0), 20, (0.08, 0.24, 0.47, 0.79, 1.1), 4096
# scales within which a law is near a modulus (in ln) and a loss angle (rad); weight of the prior in the choice
_NEAR_LEVEL, _NEAR_ANGLE, _PRIOR_WEIGHT = 0.5, 0.15, 0.02


def starting_laws(problem: CampaignProblem) -> RealArray:
    """Return coordinates of the nominal model with laws spread over their prior, shape (m, d), nuisances being 0.

    Moduli and losses in the middle of the band are evenly spread where the sample's resonance may lie: these determine
    the transmissibility in the first place, and laws with evenly spread parameters would repeat some and lack others.
    """
    f = np.concatenate([data.frequency for data in problem.data])
    stiffness_scales = []  # E / omega^2 at the resonance of the plate, and a third of the sample, on the sample
    for setting in problem.settings:
        height = setting.configuration.specimen_thickness
        mass_per_area = setting.plate_mass / setting.area + problem.campaign.specimen.density * height / 3
        stiffness_scales.append(mass_per_area * height)
    slow, fast = 2 * np.pi * _AROUND[0] * f.min(), 2 * np.pi * _AROUND[1] * f.max()
    levels = np.linspace(np.log(slow**2 * min(stiffness_scales)), np.log(fast**2 * max(stiffness_scales)), _LEVELS)
    laws = draw_prior(len(problem.law_parameters), _LAWS, 0)
    e = problem.space.modulus(problem.law_coordinates(laws), np.array([np.sqrt(f.min() * f.max())]))[:, 0]
    distance = (
        ((np.log(np.abs(e)) - levels[:, None, None]) / _NEAR_LEVEL) ** 2
        + ((np.angle(e) - np.array(_ANGLES)[:, None]) / _NEAR_ANGLE) ** 2
        + _PRIOR_WEIGHT * np.sum(laws**2, axis=-1)
    )
    chosen = laws[np.unique(np.argmin(distance, axis=-1))]
    return np.concatenate([chosen, np.zeros((len(chosen), len(problem.parameters) - chosen.shape[1]))], axis=1)


def other_starts(
    nominal: Fitted, minima: Sequence[Minimum], places: Mapping[str, PlaceFit], effect: BaseEffect
) -> RealArray:
    """Return further starts of the nominal model's unknowns for the fit of an effect, shape (m, n).

    Those with a free law at the effect's place; where that leaves a large gap, or there is none, the nominal model's
    other minima, and laws all over the prior.
    """
    at = places.get(effect.place)
    starts = [] if at is None else [at.explanation.minimum.z[: len(nominal.minimum.z)]]
    if at is None or is_far_off(at.explanation.minimum.cost_per_datum):
        starts += [minimum.z for minimum in minima]
        if is_far_off(nominal.minimum.cost_per_datum):
            starts += [*starting_laws(nominal.hypothesis_as(CampaignProblem))]
    return np.stack(starts)
