"""Every burst's minima with the rig's model, and from those of plane waves to those of finite elements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from multilayer.arrays import RealArray
from multilayer.experiments.two_plate.burst import BurstProblem
from multilayer.experiments.two_plate.finite_elements import FiniteRig, ModulusRange, finite_rigs
from multilayer.fits.burst.branches import Candidates, Choice, choose_branches, find_candidates
from multilayer.fits.settings import FitSettings
from multilayer.measurements.description import Campaign

Progress: TypeAlias = Callable[[str], None]
Bounds: TypeAlias = tuple[RealArray, RealArray]
_MOST_WIDENED = 3
_NEAR = 1e-3  # of ln E1: a solution this near to an end of its range lies on it


def search_bounds(settings: FitSettings) -> Bounds:
    """Return the bounds of (ln E1, E2/E1)."""
    moduli, losses = settings.bounds.storage_modulus, settings.bounds.loss_factor
    return np.array([np.log(moduli[0]), losses[0]]), np.array([np.log(moduli[1]), losses[1]])


def search(
    problems: Sequence[BurstProblem], bounds: Sequence[Bounds], tell: Progress
) -> tuple[list[Candidates], list[Choice]]:
    """Return the minima of every burst within its bounds, and the branch taken among them."""
    candidates = []
    for problem, (low, high) in zip(problems, bounds, strict=True):
        candidates.append(find_candidates(problem, low, high))
        tell(f"{problem.data.configuration} {problem.data.frequency:g} Hz: searched")
    return candidates, choose_branches([p.data.frequency for p in problems], candidates)


def with_free_rim(
    campaign: Campaign,
    problems: Sequence[BurstProblem],
    choices: Sequence[Choice],
    settings: FitSettings,
    tell: Progress,
) -> tuple[list[BurstProblem], list[Bounds], list[Candidates], list[Choice]]:
    """Return problems and solutions with finite elements for a rig, sought around what the plane-wave model found.

    With air in the pores that is a mere guess: a range at whose end a solution lies is widened, and sought anew.
    """
    air, most_loss = settings.pores is not None, settings.bounds.loss_factor[1]
    nu, names = campaign.specimen.poisson_ratio, [problem.data.configuration for problem in problems]
    ranges = {}
    for name in dict.fromkeys(names):
        found = [choice.minimum.z for choice, of in zip(choices, names, strict=True) if of == name]
        ranges[name] = ModulusRange.around(found, nu, most_loss, air=air)
    left, rigs = set(ranges), dict[str, FiniteRig]()
    for _ in range(_MOST_WIDENED if air else 1):
        rigs |= finite_rigs(campaign, {name: ranges[name] for name in left}, tell, settings)
        posed = [replace(problem, rig=rigs[name]) for problem, name in zip(problems, names, strict=True)]
        bounds = [_within(ranges[name], settings) for name in names]
        candidates, chosen = search(posed, bounds, tell)
        left = {name for name, choice in zip(names, chosen, strict=True) if _at_end(choice, ranges[name], settings)}
        if not left:
            break
        ranges |= {name: ranges[name].widened() for name in left}
    return posed, bounds, candidates, chosen


def _within(moduli: ModulusRange, settings: FitSettings) -> Bounds:
    """Return the settings' bounds of (ln E1, E2/E1), as far as they lie in a range."""
    (low, least_loss), (high, most_loss) = search_bounds(settings)
    return (
        np.array([max(low, np.log(moduli.low)), least_loss]),
        np.array([min(high, np.log(moduli.high)), most_loss]),
    )


def _at_end(choice: Choice, moduli: ModulusRange, settings: FitSettings) -> bool:
    """Tell whether a solution lies at an end of its range, inside of the settings' own bounds."""
    low, high = (np.log(e) for e in settings.bounds.storage_modulus)
    x = choice.minimum.z[0]
    ends = [end for end in (np.log(moduli.low), np.log(moduli.high)) if low < end < high]
    return any(abs(x - end) < _NEAR for end in ends)
