"""Goodness of fit of a hypothesis: p-values of its misfit, of stated quantities, of sizes of effects, and of laws."""

from __future__ import annotations

import numpy as np

from multilayer.chi2 import exceeding
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.thresholds import FIT_P, SECOND_SHARE, TOLERANCE
from multilayer.diagnosis.unknown_cause import smooth_discrepancy
from multilayer.inference.pulls import largest_pulls, nuisance_p_value

_OFF = "takes what is stated of the laboratory for wrong, which has the probability"


def lack_of_fit(fitted: Fitted, *, is_misfit_allowed: bool = False, of_law: bool = True) -> str:
    """Return why a hypothesis does not fit, the least probable reason; empty where it fits.

    Each of four things needs a probability of at least `FIT_P`: the misfit, the pulls of stated quantities, the sizes
    of effects, and the errors of their laws; of two effects, both of whose laws miss something, of that squared. They
    are tested one by one, since together they would allow more of one of them than any true hypothesis needs. Only the
    misfit may be exempt (`is_misfit_allowed`), and of a free law what there is no usual size of (`of_law`).
    """
    p_values = {
        _OFF: nuisance_p_value(fitted.hypothesis.parameters, fitted.minimum.z),
    }
    if of_law:
        p_values |= {
            "asks for sizes so far from the usual ones that these have the probability": size_p_value(fitted),
            "asks for a law so far from the known one that this has the probability": law_p_value(fitted),
        }
    if not is_misfit_allowed:
        p_values["leaves a misfit of probability"] = misfit_p_value(fitted, TOLERANCE, of_law=of_law)
    text = min(p_values, key=lambda reason: p_values[reason])
    if p_values[text] >= FIT_P ** max(len(fitted.names), 1):
        return ""
    return f"{text} {probability_text(p_values[text])}{f' ({statement_most_off(fitted)})' if text == _OFF else ''}"


def statement_most_off(fitted: Fitted) -> str:
    """Return in words which stated quantity a fit takes to be farthest off, and by how much."""
    return next((pull.in_words for pull in largest_pulls(fitted.hypothesis.parameters, fitted.minimum.z)), "")


def misfit_p_value(fitted: Fitted, tolerance: float, *, of_law: bool = True) -> float:
    """Return the probability of a misfit as large as this, with a smooth discrepancy of relative size `tolerance`.

    The cost of a linear model with normal priors is chi-square distributed with as many degrees of freedom as there are
    data: in closed form what a parametric bootstrap with refits gives. Without the effects' own priors (`of_law` False:
    a free law may be as large as it likes) it is that at most.
    """
    if not fitted.minimum.is_finite:
        return 0.0
    excess = smooth_discrepancy(fitted).misfit_reduction(tolerance)
    return exceeding(_cost(fitted, of_law=of_law) - excess, len(fitted.minimum.residual))


def is_misfit_likely(fitted: Fitted) -> bool:
    """Tell whether a misfit as large as a fit's is no wonder."""
    return misfit_p_value(fitted, TOLERANCE) >= FIT_P


def explains_data(fitted: Fitted) -> bool:
    """Tell whether neither a fit's misfit is a wonder, nor what it takes stated quantities of the laboratory to be."""
    hypothesis, z = fitted.hypothesis, fitted.minimum.z
    return is_misfit_likely(fitted) and nuisance_p_value(hypothesis.parameters, z) >= FIT_P


def is_enough(nominal: Fitted, fitted: Fitted) -> bool:
    """Tell whether a free law explains the data, or leaves no more of the nominal model's gap than a law may miss."""
    n = len(fitted.minimum.residual)
    before, after = nominal.minimum.cost / n - 1, _cost(fitted, of_law=False) / n - 1
    return after < SECOND_SHARE * before or not lack_of_fit(fitted, of_law=False)


def _cost(fitted: Fitted, *, of_law: bool) -> float:
    """Return the cost, or that without the prior of the effects' own parameters."""
    if of_law:
        return fitted.minimum.cost
    own = fitted.minimum.z[fitted.of_effects()]
    return fitted.minimum.cost - float(own @ own)


def size_p_value(fitted: Fitted) -> float:
    """Return the probability, by their priors, of effects' parameters as far out as these, all taken together."""
    coordinates = fitted.minimum.z[fitted.of_effects()]
    return exceeding(float(coordinates @ coordinates), len(coordinates)) if len(coordinates) else 1.0


def law_p_value(fitted: Fitted) -> float:
    """Return the probability of errors of the effects' laws as large as those in the fit, the less probable kind.

    Of errors that are unknowns of the hypothesis, that of their coordinates. Of those integrated out, the posterior
    means have a weighted chi-square distribution, approximated by its first two moments: F. E. Satterthwaite,
    Biometrics Bull. 2 (1946) 110-114.
    """
    drawn = fitted.minimum.z[fitted.of_effects(errors=True)]
    p_value = exceeding(float(drawn @ drawn), len(drawn)) if len(drawn) else 1.0
    if fitted.errors is None or not len(fitted.errors.sizes):
        return p_value
    weights = fitted.errors.sizes**2 / (1 + fitted.errors.sizes**2)
    means = np.sqrt(weights) * (fitted.minimum.residual @ fitted.errors.directions)
    scale = float(np.sum(weights**2) / np.sum(weights))
    return min(p_value, exceeding(float(means @ means) / scale, float(np.sum(weights)) / scale))


def probability_text(p: float) -> str:
    """Return a probability for people."""
    return f"{p:.1g}" if p > 1e-300 else "below 1e-300"
