"""Every hypothesis with its evidence: the nominal model, effects one by one, pairs, and something unknown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.special import logsumexp

from multilayer.diagnosis.cross_validation import Shrinkage
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.fitting import HOPELESS, Begun, Fitted, begin, finish_all, polished
from multilayer.diagnosis.strain import strain
from multilayer.diagnosis.thresholds import (
    CERTAIN_P,
    LEAST_SCORE,
    LEAST_SIZE,
    MOST_NEAR,
    N_FIRST,
    N_SECOND,
    NEAR,
    PRIOR_NONE,
    PRIOR_ONE,
    PRIOR_TWO,
    PRIOR_UNKNOWN,
    RIGHT_NAMED,
    RIGHT_NAMED_ONE,
    SECOND_EVIDENCE,
    TEMPERATURE,
    TOLERANCE,
)
from multilayer.diagnosis.unknown_cause import (
    discrepancy_evidence,
    tolerant_p_value,
)
from multilayer.executors import run_all

UNKNOWN: tuple[str, ...] = ("unknown",)
_SMALL = (1e-6, 0.5 * TOLERANCE, TOLERANCE)
_LARGE = (0.01, 0.02, 0.04, 0.08)
_FAR_BEHIND = 10.0  # times the least misfit: an effect that no second one could help
_PAIR_BEHIND = 2.0  # the same of a pair after its first steps
_MOST_TIMES = 10.0  # its usual size, of an effect whose gain is estimated


@dataclass(frozen=True)
class Hypotheses:
    """All that was tried.

    Attributes
    ----------
    nominal : Fitted
    fitted : dict
        By the names of their effects; without the nominal one.
    evidence : dict
        Log evidence by names, the tolerance being allowed in each; the nominal model under ``()``, none of the known
        effects under ``("unknown",)``.
    n_effects : int
        How many effects were tried by themselves.
    foretold : dict
        By names, how much worse than the best of those near each other a cause foretells held-out data, nats: at most
        0; of causes that were checked.
    """

    nominal: Fitted
    fitted: dict[tuple[str, ...], Fitted]
    evidence: dict[tuple[str, ...], float]
    n_effects: int
    foretold: Mapping[tuple[str, ...], float] = field(default_factory=dict)

    def score(self, names: tuple[str, ...]) -> float:
        """Return the logarithm of evidence times prior: how common such a cause is, shared by all of its kind.

        And what held-out data say of it: the evidence of two causes that fit hangs on how wrong their laws may be, that
        they foretell other data does not.
        """
        if names == ():
            return self.evidence[names] + float(np.log(PRIOR_NONE))
        if names == UNKNOWN:
            return self.evidence[names] + float(np.log(PRIOR_UNKNOWN))
        n = max(self.n_effects, 1)
        prior = PRIOR_ONE / n if len(names) == 1 else PRIOR_TWO / max(n * (n - 1) / 2, 1)
        return self.evidence[names] + float(np.log(prior)) + self.foretold.get(names, 0.0)

    @property
    def near(self) -> list[tuple[str, ...]]:
        """Names of the causes that held-out data are to tell apart, the most probable first."""
        ranked = [names for names in self.ranked if names in self.fitted]
        return [names for names in ranked if self.score(ranked[0]) - self.score(names) < NEAR][:MOST_NEAR]

    def informed(self, held: Mapping[tuple[str, ...], Shrinkage]) -> Hypotheses:
        """Return the same with what held-out data say of the causes that are near each other, and of others."""
        best = max((held[names].log_score for names in self.near if names in held), default=0.0)
        return replace(self, foretold={names: min(one.log_score - best, 0.0) for names, one in held.items()})

    @cached_property
    def p_value(self) -> float:
        """Probability of a misfit as large as the nominal model's, if nothing acts."""
        return tolerant_p_value(self.nominal, 1e-6)

    @property
    def is_gap(self) -> bool:
        """Whether a cause is well ahead of the nominal model, or chance cannot explain the misfit.

        A known effect shows in the evidence long before it shows in the sum of all squares. What changes the data by
        less than solvers differ is none, whatever its evidence: their differences are no noise, and look like
        something.
        """
        return self.p_value <= CERTAIN_P or (self.is_supported and self.gap_size >= LEAST_SIZE)

    @property
    def is_supported(self) -> bool:
        """Whether some cause is well ahead of the nominal model."""
        return self.score(self.ranked[0]) - self.score(()) >= LEAST_SCORE

    @cached_property
    def gap_size(self) -> float:
        """By how much the best effect changes what is modelled: rms of the relative difference."""
        names = self.best_fitted
        if names is None:
            return 0.0
        best = self.fitted[names]
        before = self.nominal.hypothesis.differences(self.nominal.minimum.z)
        after = best.hypothesis.differences(best.minimum.z)
        change = np.concatenate([a - b for a, b in zip(after, before, strict=True)])
        return float(np.sqrt(np.mean(np.abs(change) ** 2)))

    @property
    def best_fitted(self) -> tuple[str, ...] | None:
        """Names of the most probable known effects."""
        return next((names for names in self.ranked if names in self.fitted), None)

    @property
    def several(self) -> bool:
        """Whether there is more than one configuration."""
        return len(self.nominal.hypothesis.data) > 1

    @property
    def ranked(self) -> list[tuple[str, ...]]:
        """Names of the causes, the most probable first; without the nominal model."""
        return sorted((names for names in self.evidence if names), key=lambda names: -self.score(names))

    def probabilities(self) -> dict[tuple[str, ...], float]:
        """Return probabilities by names: scores over the temperature that development runs called for.

        Evidence weighs what was tried. That something else acts which looks the same, it cannot know: development runs
        say how often, and that share of what the known effects have is the unknown's.
        """
        names = list(self.evidence)
        scaled = np.array([self.score(n) for n in names]) / TEMPERATURE
        shares = dict(zip(names, (float(p) for p in np.exp(scaled - logsumexp(scaled))), strict=True))
        known = [n for n in names if n not in ((), UNKNOWN)]
        right = RIGHT_NAMED if self.several else RIGHT_NAMED_ONE
        mistaken = (1 - right) * sum(shares[n] for n in known)
        return shares | {n: right * shares[n] for n in known} | {UNKNOWN: shares[UNKNOWN] + mistaken}

    def probability_with(self, causes: Sequence[tuple[str, ...]]) -> float:
        """Return the probability of some causes; with a second effect of little use beside it, it is the same one."""
        shares = self.probabilities().items()
        return sum(p for names, p in shares if any(set(one) <= set(names) for one in causes))


def tolerant_evidence(fitted: Fitted) -> float:
    """Return the log evidence of a hypothesis that may be off by as much as solvers, and its laws, are."""
    return discrepancy_evidence(fitted, _SMALL)[0]


def compare(
    nominal: Fitted,
    singles: Mapping[tuple[str, ...], Fitted],
    effects: Mapping[str, BaseEffect],
    executor: Executor | None = None,
) -> Hypotheses:
    """Return the evidence of nominal model, single effects, pairs of promising ones, and of something unknown."""
    fitted = dict(singles)
    evidence = {names: tolerant_evidence(one) for names, one in {(): nominal, **fitted}.items()}
    best = sorted(singles, key=lambda names: -evidence[names])
    several = len(nominal.hypothesis.data) > 1
    strained = bool(best) and bool(strain(singles[best[0]]))
    # of one configuration two are named never, and matter only where one effect does not fit
    if best and evidence[best[0]] - evidence[()] > LEAST_SCORE and (several or strained):
        pairs = _promising(singles, best, effects, several=several, strained=strained)
        tasks = [(singles[names], effects[second]) for names, second in pairs]
        begun = dict(zip(pairs, run_all(_begin_pair, tasks, executor), strict=True))
        rough = finish_all(begun, executor, behind=_PAIR_BEHIND)
        for (names, second), pair in polished(rough, executor, HOPELESS).items():
            score = tolerant_evidence(pair)
            if score > max(evidence[names], evidence[second,]) + SECOND_EVIDENCE:
                fitted[pair.names], evidence[pair.names] = pair, score
    evidence[UNKNOWN] = discrepancy_evidence(nominal, _LARGE)[0]
    return Hypotheses(nominal, fitted, evidence, len(singles))


def _promising(
    singles: Mapping[tuple[str, ...], Fitted],
    best: Sequence[tuple[str, ...]],
    effects: Mapping[str, BaseEffect],
    *,
    several: bool,
    strained: bool,
) -> list[tuple[tuple[str, ...], str]]:
    """Return pairs to be fitted, no pair twice: the best effect with those that would gain most beside it.

    Where it leaves a misfit by itself, the next best ones as well, and of several configurations the best with every
    other: far from a minimum, gains are not to be foreseen.
    """
    found: dict[frozenset[str], tuple[tuple[str, ...], str]] = {}
    least = min(one.minimum.cost for one in singles.values())
    hopeful = [names for names in best if singles[names].minimum.cost < _FAR_BEHIND * least]
    for names in hopeful[: N_FIRST if strained else 1]:
        others = {name: effect for name, effect in effects.items() if name not in names and (name,) in singles}
        for second in others if several and strained and names == best[0] else _likely(singles[names], others):
            found.setdefault(frozenset((*names, second)), (names, second))
    return list(found.values())


def _likely(fitted: Fitted, others: Mapping[str, BaseEffect]) -> list[str]:
    """Return the further effects that promise most beside those of a fit."""
    gains = expected_gains(fitted, others)
    return [name for name in sorted(gains, key=lambda one: -gains[one])[:N_SECOND] if gains[name] > SECOND_EVIDENCE]


def expected_gains(fitted: Fitted, others: Mapping[str, BaseEffect]) -> dict[str, float]:
    """Return by about how much the cost would fall with each of some further effects: half the score statistic.

    From the change of the residuals that an effect of its usual size makes, taken as proportional to that size.
    """
    hypothesis, minimum = fitted.hypothesis, fitted.minimum
    here = hypothesis.residual(minimum.z)
    gains = {}
    for name, effect in others.items():
        more = hypothesis.with_effects(*hypothesis.effects, effect)
        parts = [p.prior.normal is not None for p in effect.parameters]
        steps = np.concatenate([minimum.z, [1.0 if is_signed else 0.0 for is_signed in parts]])
        change = fitted.softened(more.residual(steps) - here)
        if not np.all(np.isfinite(change)):
            gains[name] = 0.0
            continue
        along = minimum.jacobian.T @ change
        stiffness = float(change @ change - along @ np.linalg.solve(minimum.precision, along))
        pull = -float(minimum.residual @ change)
        low = -_MOST_TIMES if any(parts) else 0.0
        times = float(np.clip(pull / max(stiffness, 1e-12), low, _MOST_TIMES))
        gains[name] = times * pull - 0.5 * times**2 * stiffness
    return gains


def _begin_pair(task: tuple[Fitted, BaseEffect]) -> Begun:
    one, other = task
    hypothesis = one.hypothesis.with_effects(*one.hypothesis.effects, other)
    return begin(hypothesis, one.minimum.z, followed=1)
