"""Model comparison: evidence of the nominal model, of effects one by one, of pairs, and of an unknown cause.

Bayes factors of models: R. E. Kass & A. E. Raftery, J. Am. Stat. Assoc. 90 (1995) 773-795. Tempered probabilities of
models that are all a little wrong: P. Grünwald & T. van Ommen, Bayesian Anal. 12 (2017) 1069-1103.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np
from scipy.special import logsumexp

from multilayer.arrays import RealArray
from multilayer.diagnosis.cross_validation import Shrinkage
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.fitting import Fitted, StartedFit, begin, finish_all, polish_fits
from multilayer.diagnosis.goodness_of_fit import explains_data, lack_of_fit, misfit_p_value
from multilayer.diagnosis.place_fits import PlaceFit
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
    TIED,
    UNEXPLAINED,
    UNKNOWN_SIZES,
)
from multilayer.diagnosis.unknown_cause import NO_DISCREPANCY, discrepancy_evidence, tolerant_evidence
from multilayer.executors import run_all
from multilayer.experiments.hypothesis import Hypothesis
from multilayer.inference.multistart import is_far_off
from multilayer.inference.pulls import pulls_p_value, stated_pulls, stated_values

UNKNOWN: tuple[str, ...] = ("unknown",)
PairTasks = dict[tuple[str, ...], tuple[Fitted, BaseEffect]]  # a fit to begin at, and the second effect
_FAR_BEHIND = 10.0  # times the least misfit, above which an effect is not combined with a second one
_PAIR_BEHIND = 10.0  # times the least misfit, above which a pair is given up after its first steps
_MOST_TIMES = 10.0  # largest size of an effect, relative to its usual one, in the estimate of its gain


@dataclass(frozen=True)
class ModelComparison:
    """All hypotheses that were tried, with their evidence.

    Attributes
    ----------
    nominal : Fitted
    fitted : dict
        By the names of their effects; without the nominal one.
    evidence : dict
        Log evidence by names of effects, each with a discrepancy of the tolerance; the nominal model under ``()``, an
        unknown cause under ``("unknown",)``.
    n_effects : int
        How many effects were tried by themselves.
    places : mapping
        Places with a free law, by label; empty where there are none.
    held_out : mapping
        By names, the log predictive density of held-out data, relative to the best of the near causes and of a free law
        at the best place, and at most 0; of causes that were checked.
    free : Shrinkage, optional
        Of a free law at the best place, where held-out data decide.
    """

    nominal: Fitted
    fitted: dict[tuple[str, ...], Fitted]
    evidence: dict[tuple[str, ...], float]
    n_effects: int
    places: Mapping[str, PlaceFit] = field(default_factory=dict)
    held_out: Mapping[tuple[str, ...], float] = field(default_factory=dict)
    free: Shrinkage | None = None

    def score(self, names: tuple[str, ...]) -> float:
        """Return the logarithm of evidence times prior, plus the log predictive density of held-out data.

        The prior probability of each kind of causes is shared by its members. Of two causes that fit, the evidence
        depends on how wrong their laws may be; the prediction of held-out data hardly does.
        """
        return self.fitted_score(names) + self.held_out.get(names, 0.0)

    def fitted_score(self, names: tuple[str, ...]) -> float:
        """Return the logarithm of evidence times prior."""
        if names == ():
            return self.evidence[names] + float(np.log(PRIOR_NONE))
        if names == UNKNOWN:
            return self.evidence[names] + float(np.log(PRIOR_UNKNOWN))
        n = max(self.n_effects, 1)
        prior = PRIOR_ONE / n if len(names) == 1 else PRIOR_TWO / max(n * (n - 1) / 2, 1)
        return self.evidence[names] + float(np.log(prior))

    @property
    def near(self) -> list[tuple[str, ...]]:
        """Names of the causes that held-out data are to distinguish, the most probable first."""
        ranked = [names for names in self.ranked if names in self.fitted]
        return [names for names in ranked if self.score(ranked[0]) - self.score(names) < NEAR][:MOST_NEAR]

    def tied_with(self, best: tuple[str, ...]) -> list[tuple[str, ...]]:
        """Return names of the known causes that the data cannot tell from one, that one included; the best first."""
        top = self.score(best)
        return [names for names in self.ranked if names != UNKNOWN and top - self.score(names) < TIED]

    def with_held_out(self, shrinkages: Mapping[tuple[str, ...], Shrinkage]) -> ModelComparison:
        """Return the comparison with the log predictive densities of held-out data.

        A known law must foretell them as well as a free law at the best place: that knows less, and holds where the
        cause is another one that acts there.
        """
        densities = [shrinkages[names].log_score for names in self.near if names in shrinkages]
        best = max([*densities, *([self.free.log_score] if self.free else [])], default=0.0)
        scores = {names: min(shrinkage.log_score - best, 0.0) for names, shrinkage in shrinkages.items()}
        return replace(self, held_out=scores)

    @cached_property
    def p_value(self) -> float:
        """Probability of a misfit as large as the nominal model's, if no effect acts."""
        return misfit_p_value(self.nominal, NO_DISCREPANCY)

    @property
    def is_gap(self) -> bool:
        """Whether a cause is well ahead of the nominal model, or chance cannot explain the misfit.

        A known effect shows in the evidence long before it shows in the sum of squares. A cause that changes the data
        by less than solvers differ is no gap, whatever its evidence: differences of solvers are not noise, and resemble
        effects. Where the nominal model takes what is stated of the laboratory for wrong, that is the gap: beside
        hundreds of data the misfit does not tell it.
        """
        if self.p_value <= CERTAIN_P or self.stated_p_value <= CERTAIN_P:
            return True
        return self.is_supported and self.gap_size >= LEAST_SIZE

    @cached_property
    def stated_p_value(self) -> float:
        """Probability of what the nominal model takes stated quantities to be, one of them or all together."""
        parameters, minimum = self.nominal.hypothesis.parameters, self.nominal.minimum
        return pulls_p_value(*stated_values(parameters, minimum.z, minimum.covariance))

    @property
    def is_supported(self) -> bool:
        """Whether some cause is well ahead of the nominal model."""
        return self.score(self.ranked[0]) - self.score(()) >= LEAST_SCORE

    @cached_property
    def gap_size(self) -> float:
        """Change of the modelled data by the best effect or place, as rms of the relative difference."""
        best = self.best_explanation
        if best is None:
            return 0.0
        before = self.nominal.hypothesis.differences(self.nominal.minimum.z)
        after = best.hypothesis.differences(best.minimum.z)
        change = np.concatenate([a - b for a, b in zip(after, before, strict=True)])
        return float(np.sqrt(np.mean(np.abs(change) ** 2))) / self.nominal.hypothesis.unit

    @property
    def best_fitted(self) -> tuple[str, ...] | None:
        """Names of the most probable known effects."""
        return next((names for names in self.ranked if names in self.fitted), None)

    @property
    def best_explanation(self) -> Fitted | None:
        """The fit with the most evidence, of known effects and of free laws at places."""
        fits = [(self.evidence[names], fit) for names, fit in self.fitted.items()]
        fits += [(fit.log_evidence, fit.explanation) for fit in self.places.values()]
        return max(fits, key=lambda pair: pair[0])[1] if fits else None

    @cached_property
    def noise(self) -> float:
        """What noise leaves per datum, with pulls of stated quantities: 1, or less where it is less than stated.

        Judged by the explanation with the most evidence. Errors that are smooth in frequency leave less than 1 to a
        flexible explanation however large they are: where such errors matter most (not `held_out_decides`), it is 1.
        """
        best = self.best_explanation
        if best is None or not self.nominal.hypothesis.held_out_decides:
            return 1.0
        pulls = stated_pulls(best.hypothesis.parameters, best.minimum.z)
        return min(float(best.minimum.misfit + pulls @ pulls) / len(best.minimum.residual), 1.0)

    def place_of(self, names: tuple[str, ...]) -> str:
        """Return the place of a known cause of one effect, or of an unknown one; empty where there is none."""
        if names == UNKNOWN:
            return next(iter(self.places), "")
        places = {effect.place for effect in self.fitted[names].hypothesis.effects}
        return places.pop() if len(places) == 1 else ""

    def lead_at_place(self, names: tuple[str, ...]) -> float:
        """Return how far a cause is ahead of a free law at its place, as a share of what that pays more for parameters.

        About 1 where its law is as good as any, less where a free one fits better. -inf where the cause has no single
        place, or another place has more evidence.
        """
        label = self.place_of(names)
        if not label or label != next(iter(self.places), ""):
            return -float("inf")
        free, known = self.places[label], self.fitted[names]
        more = free.explanation.parameter_cost - known.parameter_cost
        ahead = self.evidence[names] - free.log_evidence
        return ahead / more if more > 0 else float(np.copysign(np.inf, ahead))

    @property
    def tied_places(self) -> list[PlaceFit]:
        """Places with a free law that the data cannot tell apart, the most probable first."""
        best = max((fit.log_evidence for fit in self.places.values()), default=0.0)
        return [fit for fit in self.places.values() if best - fit.log_evidence < TIED]

    @property
    def free_shares(self) -> dict[str, float]:
        """Probability of each place, by label, if something unknown acts at any of them; they add up to 1."""
        scaled = np.array([fit.log_evidence for fit in self.places.values()]) / TEMPERATURE
        shares = np.exp(scaled - logsumexp(scaled)) if len(scaled) else scaled
        return dict(zip(self.places, shares.tolist(), strict=True))

    def place_probabilities(self, shares: Mapping[tuple[str, ...], float], right: float = 1.0) -> dict[str, float]:
        """Return the probability of each place that something acts there, known or unknown; the largest first.

        Parameters
        ----------
        shares : mapping
            Probabilities of all hypotheses, as a verdict tells them.
        right : float
            Probability that something unknown acts at any of the places.
        """
        total = {label: shares[UNKNOWN] * right * share for label, share in self.free_shares.items()}
        for names, fit in self.fitted.items():
            for place in {effect.place for effect in fit.hypothesis.effects}:
                if place in total:
                    total[place] += shares[names]
        return dict(sorted(total.items(), key=lambda item: -item[1]))

    @property
    def several(self) -> bool:
        """Whether there is more than one configuration."""
        return len(self.nominal.hypothesis.data) > 1

    @property
    def ranked(self) -> list[tuple[str, ...]]:
        """Names of the causes, the most probable first; without the nominal model."""
        return sorted((names for names in self.evidence if names), key=lambda names: -self.score(names))

    def probabilities(self) -> dict[tuple[str, ...], float]:
        """Return probabilities by names, from scores divided by a temperature calibrated on development runs.

        Evidence weighs the hypotheses that were tried only. How often something else acts that looks like a known
        effect is calibrated on development runs, too: this share of the known effects' probability is the unknown
        cause's.
        """
        names = list(self.evidence)
        scaled = np.array([self.score(n) for n in names]) / TEMPERATURE
        shares = dict(zip(names, (float(p) for p in np.exp(scaled - logsumexp(scaled))), strict=True))
        known = [n for n in names if n not in ((), UNKNOWN)]
        right = RIGHT_NAMED if self.several else RIGHT_NAMED_ONE
        mistaken = (1 - right) * sum(shares[n] for n in known)
        return shares | {n: right * shares[n] for n in known} | {UNKNOWN: shares[UNKNOWN] + mistaken}

    def probability_with(self, causes: Sequence[tuple[str, ...]]) -> float:
        """Return the probability of some causes, with or without a second effect besides."""
        shares = self.probabilities().items()
        return sum(p for names, p in shares if any(set(cause) <= set(names) for cause in causes))


def compare(
    nominal: Fitted,
    singles: Mapping[tuple[str, ...], Fitted],
    effects: Mapping[str, BaseEffect],
    executor: Executor | None = None,
    places: Mapping[str, PlaceFit] | None = None,
) -> ModelComparison:
    """Return the evidence of the nominal model, single effects, promising pairs, and an unknown cause.

    The unknown cause is a free law at one of the places, or a discrepancy that is smooth in every configuration.
    """
    fitted = dict(singles)
    evidence = {names: tolerant_evidence(fit) for names, fit in {(): nominal, **fitted}.items()}
    best = sorted(singles, key=lambda names: -evidence[names])
    several = len(nominal.hypothesis.data) > 1
    is_unfit = bool(best) and bool(lack_of_fit(singles[best[0]]))
    # a single unknown cause that explains the data is preferred to two known ones
    is_open = is_unfit and not any(explains_data(fit.explanation) for fit in (places or {}).values())
    # from a single configuration pairs are never named, and matter only where nothing else fits
    if best and evidence[best[0]] - evidence[()] > LEAST_SCORE and (is_open or (several and not is_unfit)):
        near = [names for names in best if evidence[best[0]] - evidence[names] < NEAR]
        pairs = _promising(singles, best if is_unfit else near, effects, executor, is_open=is_open and several)
        tasks = {(*names, second): (singles[names], effects[second]) for names, second in pairs}
        seen: set[frozenset[str]] = set()
        while tasks:
            seen |= {frozenset(names) for names in tasks}
            before = _best_pair(fitted, evidence)
            for names, pair in _fit_pairs(tasks, executor).items():
                score = tolerant_evidence(pair)
                if score > max(evidence[name,] for name in names) + SECOND_EVIDENCE:
                    fitted[names], evidence[names] = pair, score
            after = _best_pair(fitted, evidence)
            more = _exchanged(fitted[after], effects, singles) if is_open and after and after != before else {}
            tasks = {names: task for names, task in more.items() if frozenset(names) not in seen}
        again = _again_by_themselves(_best_pair(fitted, evidence), fitted, executor)
        fitted |= again
        evidence |= {names: tolerant_evidence(fit) for names, fit in again.items()}
    free = [fit.log_evidence for fit in (places or {}).values()]
    evidences = [discrepancy_evidence(nominal, UNKNOWN_SIZES), *free]
    evidence[UNKNOWN] = float(logsumexp(evidences) - np.log(len(evidences)))
    return ModelComparison(nominal, fitted, evidence, len(singles), places or {})


def _promising(
    singles: Mapping[tuple[str, ...], Fitted],
    best: Sequence[tuple[str, ...]],
    effects: Mapping[str, BaseEffect],
    executor: Executor | None,
    *,
    is_open: bool,
) -> list[tuple[tuple[str, ...], str]]:
    """Return pairs to be fitted, no pair twice: the best effects with those of the largest expected gain besides.

    The best ones are those near the first in evidence or, where that does not fit alone, the next best ones as well.
    Where it explains nothing of several configurations, nor does a free law (`is_open`), it is combined with every
    other effect: far from a minimum, gains cannot be estimated.
    """
    pairs: dict[frozenset[str], tuple[tuple[str, ...], str]] = {}
    least = min(fit.minimum.cost for fit in singles.values())
    competitive = [names for names in best if singles[names].minimum.cost < _FAR_BEHIND * least]
    for names in competitive[:N_FIRST]:
        others = {name: effect for name, effect in effects.items() if name not in names and (name,) in singles}
        is_lost = is_open and names == best[0] and singles[names].minimum.cost_per_datum > UNEXPLAINED
        for second in others if is_lost else _likely(singles[names], others, executor):
            pairs.setdefault(frozenset((*names, second)), (names, second))
    return list(pairs.values())


def _best_pair(fitted: Mapping[tuple[str, ...], Fitted], evidence: Mapping[tuple[str, ...], float]) -> tuple[str, ...]:
    return max((names for names in fitted if len(names) > 1), key=evidence.__getitem__, default=())


def _again_by_themselves(
    pair: tuple[str, ...], fitted: Mapping[tuple[str, ...], Fitted], executor: Executor | None
) -> dict[tuple[str, ...], Fitted]:
    """Return better fits of the effects of a pair, each by itself, from the pair's minimum.

    Where a single effect is far off and the pair is not, the search for it may have gone astray.
    """
    if not pair or is_far_off(fitted[pair].minimum.cost_per_datum):
        return {}
    begun = {
        alone.names: StartedFit.at(alone, z[None])
        for alone, z in _parts(fitted[pair])
        if is_far_off(fitted[alone.names].minimum.cost_per_datum)
    }
    again = polish_fits(finish_all(begun, executor), executor)
    return {names: fit for names, fit in again.items() if fit.log_evidence > fitted[names].log_evidence}


def _fit_pairs(tasks: PairTasks, executor: Executor | None) -> dict[tuple[str, ...], Fitted]:
    """Return fits of pairs; such as are far behind others are given up."""
    started = dict(zip(tasks, run_all(_begin_pair, list(tasks.values()), executor), strict=True))
    return polish_fits(finish_all(started, executor, behind=_PAIR_BEHIND), executor, UNEXPLAINED)


def _exchanged(pair: Fitted, effects: Mapping[str, BaseEffect], singles: Mapping[tuple[str, ...], Fitted]) -> PairTasks:
    """Return the pairs that have one effect of the best pair, each to begin at that without the other effect.

    What single effects promise may mislead where neither explains anything alone.
    """
    tasks: PairTasks = {}
    for alone, z in _parts(pair):
        base = replace(pair, hypothesis=alone, minimum=replace(pair.minimum, z=z))
        for (name,) in singles:
            if name not in pair.names:
                tasks[*alone.names, name] = base, effects[name]
    return tasks


def _parts(pair: Fitted) -> list[tuple[Hypothesis, RealArray]]:
    """Return the hypotheses of each effect of a pair by itself, with the pair's coordinates; its last effect first."""
    hypothesis, z = pair.hypothesis.bare(pair.minimum.z)
    return [hypothesis.without(index, z) for index in range(len(hypothesis.effects))]


def _likely(fitted: Fitted, others: Mapping[str, BaseEffect], executor: Executor | None) -> list[str]:
    """Return the further effects of the largest expected gains beside those of a fit."""
    found = run_all(partial(expected_gain, fitted), list(others.values()), executor)
    gains = dict(zip(others, found, strict=True))
    return [name for name in sorted(gains, key=lambda name: -gains[name])[:N_SECOND] if gains[name] > SECOND_EVIDENCE]


def expected_gain(fitted: Fitted, effect: BaseEffect) -> float:
    """Return an estimate of half the fall of the cost with a further effect: half the score statistic.

    From the change of the residuals by an effect of its usual size, taken as proportional to the size. C. R. Rao, Proc.
    Camb. Philos. Soc. 44 (1948) 50-57.
    """
    hypothesis, minimum = fitted.hypothesis, fitted.minimum
    more = hypothesis.with_effects(*hypothesis.effects, effect)
    steps = np.concatenate([minimum.z, effect.usual])
    change = fitted.whitened(more.residual(steps) - hypothesis.residual(minimum.z))
    if not np.all(np.isfinite(change)):
        return 0.0
    along = minimum.jacobian.T @ change
    stiffness = float(change @ change - along @ np.linalg.solve(minimum.precision, along))
    pull = -float(minimum.residual @ change)
    low = -_MOST_TIMES if any(effect.usual) else 0.0  # of the other sign
    times = float(np.clip(pull / max(stiffness, 1e-12), low, _MOST_TIMES))
    return times * pull - 0.5 * times**2 * stiffness


def _begin_pair(task: tuple[Fitted, BaseEffect]) -> StartedFit:
    fitted, second = task
    hypothesis, z = fitted.hypothesis.bare(fitted.minimum.z)
    return begin(hypothesis.with_effects(*hypothesis.effects, second), z, followed=1)
