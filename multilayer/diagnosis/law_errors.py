"""Errors of known effects' laws as free functions at the effects' places.

A known effect is a place with a law of few parameters; what that law misses is the place's own function, small beside
it and the same in all configurations. An effect elsewhere that resembles it in one of them does not do so in all.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.places import BasePlace, places_of
from multilayer.diagnosis.thresholds import DISCREPANCY_LENGTH, LAW_LENGTH
from multilayer.experiments.hypothesis import Hypothesis
from multilayer.experiments.places import LawError

_STEP = 1e-4  # of the place's scale, for the derivative by the law
_TINY = 1e-300


def with_errors_at_places(hypothesis: Hypothesis, z: RealArray) -> tuple[Hypothesis, RealArray] | None:
    """Return a hypothesis with errors of its effects' laws as unknowns, and coordinates there, the errors 0.

    Of all effects that have a place, where several configurations hold the error: what is left out of a single one, a
    free function cannot foretell. The standard deviation of an error is the effect's `law_error` times
    the law's amount, as a power of frequency, by what both change in the data.

    Parameters
    ----------
    hypothesis : Hypothesis
    z : array, shape (d,)
        Coordinates near a minimum.

    Returns
    -------
    (Hypothesis, array) or None
        None where no effect has a place, and for a single configuration.
    """
    if len(hypothesis.data) == 1:
        return None
    kinds, effects, coordinates = places_of(hypothesis.kind), [], [z[: len(hypothesis.nominal_parameters)]]
    first = len(hypothesis.nominal_parameters)
    for index, (effect, error) in enumerate(zip(hypothesis.effects, hypothesis.law_errors, strict=True)):
        effects.append(effect)
        coordinates.append(z[first : first + len(effect.parameters)])
        first += len(effect.parameters)
        kind = kinds.get(effect.place)
        # of levels, laws at places are relative to what the constructions do, not to the effect
        places = kind.instances(hypothesis.settings) if error and kind is not None and not kind.is_real else []
        if places:
            law = _error_law(hypothesis, z, index, places[0])
            effects.append(law)
            coordinates.append(np.zeros(len(law.parameters)))
    if len(effects) == len(hypothesis.effects):
        return None
    return hypothesis.with_effects(*effects), np.concatenate(coordinates)


def _error_law(hypothesis: Hypothesis, z: RealArray, index: int, place: BasePlace) -> LawError:
    effect = hypothesis.effects[index]
    frequency = np.concatenate([data.frequency for data in hypothesis.data])
    centre = float(np.sqrt(frequency.min() * frequency.max()))
    unit = _STEP * place.scale(hypothesis.settings, hypothesis.modulus_scale(z, centre))
    law = LawError.of(effect, place, frequency, unit, LAW_LENGTH)
    here = hypothesis.differences(z)
    ahead = hypothesis.with_effects(*hypothesis.effects, law.with_offset)
    moved = ahead.differences(np.concatenate([z, np.zeros(len(law.parameters)), [1.0]]))
    by_effect = _strength(hypothesis, hypothesis.law_change(index, z, here))
    by_unit = _strength(hypothesis, [there - at for there, at in zip(moved, here, strict=True)])
    near = np.exp(-0.5 * (np.subtract.outer(law.nodes, np.log(frequency)) / DISCREPANCY_LENGTH) ** 2)
    share = 0.5 * np.log((near @ by_effect + _TINY) / (near @ by_unit + _TINY))
    # a power of f, as most laws are: a size that has kinks would have laws with kinks
    slope, mean = np.polyfit(law.nodes, share, 1)
    return replace(law, size=np.asarray(effect.law_error * unit * np.exp(mean + slope * law.nodes)))


def _strength(hypothesis: Hypothesis, changes: list[np.ndarray]) -> RealArray:
    """Return the squared change of every datum over its noise, shape (n,), all configurations one after the other."""
    parts = []
    for experiment, change in zip(hypothesis.experiments, changes, strict=True):
        white = experiment.whiten(np.where(np.isfinite(change), change, 0.0)).reshape(2, -1)
        parts.append(np.sum(white**2, axis=0))
    return np.concatenate(parts)
