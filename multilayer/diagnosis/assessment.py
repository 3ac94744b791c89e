"""Assessment of the hypotheses, from fits of single effects to a decision: the steps common to rigs and tubes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from multilayer.diagnosis.cross_validation import Shrinkage, cross_validate
from multilayer.diagnosis.decision import Decision, beside_simple_term, decide, objection_to_law, where_in_words
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.entries import cause_entries, confounded_entries, gap_entry, sentence, stated_entries
from multilayer.diagnosis.evidence import UNKNOWN, ModelComparison, compare
from multilayer.diagnosis.experiment_design import Rivals
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.goodness_of_fit import is_misfit_likely
from multilayer.diagnosis.locate import locate, where_entries
from multilayer.diagnosis.place_entries import DrawnPlace, law_entry, place_entries
from multilayer.diagnosis.place_fits import PlaceFit, SimpleForm, as_told, free_to_differ
from multilayer.diagnosis.result import Similarity
from multilayer.diagnosis.signatures import detectable_sizes, signatures, similarity
from multilayer.diagnosis.simple_forms import simple_form, simple_term, with_simple_laws
from multilayer.diagnosis.thresholds import NEAR, RIVAL

Progress = Callable[[str], None]
N_STEPS = 5  # of a diagnosis, the nominal model and the effects one by one included


@dataclass(frozen=True)
class Assessment:
    """All results that a diagnosis reports.

    Attributes
    ----------
    comparison : ModelComparison
    decision : Decision
    shrinkages : mapping
        On held-out data, by the names of effects.
    similarity : Similarity
    detectable : mapping
        The smallest effects that the data would show.
    drawn : DrawnPlace, optional
        The place of the cause with its law; None without a gap, and where places are not told apart.
    """

    comparison: ModelComparison
    decision: Decision
    shrinkages: Mapping[tuple[str, ...], Shrinkage]
    similarity: Similarity
    detectable: Mapping[str, Mapping[str, object]]
    drawn: DrawnPlace | None = None

    @property
    def nominal(self) -> Fitted:
        """The nominal model."""
        return self.comparison.nominal

    @property
    def is_gap(self) -> bool:
        """Whether there is a gap."""
        return self.decision.verdict != "no_gap"

    @property
    def is_statement_wrong(self) -> bool:
        """Whether the nominal model explains the data if something stated is wrong, and nothing else does better."""
        return self.is_gap and not self.comparison.is_supported and is_misfit_likely(self.nominal)

    @property
    def best_fit(self) -> Fitted:
        """The fit of the most probable cause, whether it is trusted or not; the nominal model where there is none."""
        if self.drawn and self.is_law_told:
            return self.drawn.free.explanation
        return self.comparison.fitted.get(self.decision.best, self.nominal)

    @property
    def is_refuted(self) -> bool:
        """Whether the most probable cause is a known one that something speaks against."""
        decision = self.decision
        return decision.verdict == "unknown" and decision.best != UNKNOWN and decision.best not in decision.group

    @property
    def is_law_told(self) -> bool:
        """Whether the law drawn at the best place is the explanation: of an unknown cause, or beside a refuted one."""
        if self.drawn is None:
            return False
        return self.decision.best == UNKNOWN or (self.is_refuted and not self.drawn.objection)

    @property
    def corrected(self) -> Fitted:
        """The model to be used: with the cause where the verdict names an effect."""
        return self.best_fit if self.decision.verdict == "effect" else self.nominal

    @property
    def explanations(self) -> list[tuple[float, Fitted]]:
        """What explains the data, with probabilities: the best, and what is nearly as probable.

        The nominal model without a gap, and where it explains the data if something stated is wrong; empty where
        nothing explains the gap.
        """
        if self.decision.verdict == "no_gap" or self.is_statement_wrong:
            return [(1.0, self.nominal)]
        comparison, probabilities = self.comparison, self.probabilities
        known = [(probabilities[n], comparison.fitted[n]) for n in self.decision.group if n != UNKNOWN]
        if self.decision.verdict == "effect":
            return known
        if self.drawn is None or self.drawn.objection:
            return known if self.decision.best in self.decision.group else []
        shares, places = comparison.free_shares, comparison.places
        told = {**places, self.drawn.free.place.label: self.drawn.free}
        first = self.drawn.free.place.label
        order = sorted(told, key=lambda label: (label != first, -shares[label]))
        free = [(probabilities[UNKNOWN] * shares[label], told[label]) for label in order]
        near = [free[0], *(rival for rival in free[1:] if rival[0] >= RIVAL)]
        rivals = [(share, free_to_differ(fit)) for share, fit in near]
        return [*rivals, *(rival for rival in known if rival[0] >= RIVAL)]

    @cached_property
    def probabilities(self) -> dict[tuple[str, ...], float]:
        """Probabilities of the causes, as they agree with the verdict's."""
        return self.decision.probabilities(self.comparison)

    @property
    def rivals(self) -> Rivals:
        """The hypotheses that an experiment should discriminate: those of the group, or the best and its rival.

        The rival is the second best where that is near, else "none of the known": a free law at the best place, which
        stands for an unknown cause, too; where that is the verdict, it is discriminated from the best of the known.
        """
        ranked = [names for names in self.comparison.ranked if names in self.comparison.fitted]
        ranked = [names for names in ranked if not set(self.decision.best) < set(names)]
        tied = [names for names in ranked if names in self.decision.group]
        score = self.comparison.score
        near = [names for names in ranked[:2] if score(ranked[0]) - score(names) < NEAR]
        free = next(iter(self.comparison.places.values()), None)
        is_unknown = self.decision.verdict == "unknown" and free is not None
        chosen = (tied or ranked[:1]) if is_unknown else tied if len(tied) > 1 else near
        rivals = [(self.comparison.fitted[names], max(self.probabilities[names], 1e-6)) for names in chosen]
        if free is not None and (is_unknown or len(rivals) == 1):
            rivals.append((free.explanation, max(self.probabilities[UNKNOWN], 1e-6)))
        return rivals

    def entries(self, next_experiment: Callable[[Rivals], list[dict[str, Any]]], seed: int) -> dict[str, Any]:
        """Return the entries of ``diagnosis.json`` that are common to rigs and tubes.

        Parameters
        ----------
        next_experiment : callable
            Gives the entries of ``next_experiment`` from the rivals.
        seed : int
            Of the Monte Carlo test of the gap's places.
        """
        comparison, decision, shrinkages = self.comparison, self.decision, self.shrinkages
        probability = decision.probability(comparison)
        is_drawn = self.is_law_told
        shrinkage = self.drawn.shrinkage if self.drawn and is_drawn else shrinkages.get(decision.best)
        law = law_entry(self.drawn) if self.drawn else None
        text = sentence(decision, probability)
        if self.drawn and is_drawn and self.is_refuted:
            text = f"{text} A law of its own {where_in_words(self.drawn.free.place)} explains it."
        if self.drawn and self.drawn.objection:
            if not self.is_statement_wrong:
                best, what = where_in_words(self.drawn.free.place), "That" if is_drawn else "A single law"
                text = f"{text} {what} does not explain it either: the best, {best}, {self.drawn.objection}."
        elif law and is_drawn and law["form_is_enough"]:
            text = f"{text} It acts like {law['form']['text']}."
        elif self.drawn and is_drawn and (place := self.drawn.free.place).tells_more:
            drawn = "like the law drawn there" if place.modelled else "the law drawn there"
            text = f"{text} It acts like {place.in_words(drawn)}."
        where, causes, plans = [], [], []
        if self.is_gap:
            where = where_entries(*locate(self.nominal.hypothesis, self.nominal.minimum, seed))
            causes = cause_entries(comparison, shrinkages, self.similarity, self.probabilities, decision)
            plans = next_experiment(self.rivals)
        return {
            "version": 2,
            "verdict": decision.verdict,
            "sentence": text,
            "probability": round(probability, 4),
            "where": where,
            "causes": causes,
            "group": [list(names) for names in decision.group] if decision.group != [UNKNOWN] else [],
            "gap": gap_entry(self.nominal, shrinkage or next(iter(shrinkages.values()), None), self.best_fit),
            "places": place_entries(comparison, self.probabilities, self.drawn) if self.is_gap else [],
            "law": law,
            "stated_deviations": stated_entries(self.nominal, self.best_fit),
            "detectable": dict(self.detectable),
            "confounded": confounded_entries(self.similarity),
            "next_experiment": plans,
            "hypotheses_tried": len(comparison.evidence),
        }

    def misfit_entries(self) -> dict[str, float]:
        """Return the nominal misfit, as it stands in ``inputs``."""
        return {
            "p_value": self.comparison.p_value,
            "stated_p_value": self.comparison.stated_p_value,
            "chi_square": self.nominal.minimum.cost,
            "n_data": len(self.nominal.minimum.residual),
        }


def assess(
    nominal: Fitted,
    singles: Mapping[tuple[str, ...], Fitted],
    effects: Mapping[str, BaseEffect],
    tell: Progress,
    executor: Executor | None = None,
    places: Mapping[str, PlaceFit] | None = None,
) -> Assessment:
    """Compare the hypotheses, check the best on held-out data, and decide.

    Parameters
    ----------
    nominal : Fitted
    singles : mapping
        Fits of single effects.
    effects : mapping
        Those that can act, by name.
    tell : callable
        Called with a short text after each of three steps.
    executor : Executor, optional
        Where fits run; in this process when left out.
    places : mapping, optional
        Places with a free law, by label.
    """
    comparison = compare(nominal, singles, effects, executor, places)
    tell("effects in pairs")
    comparison, shrinkages = _on_held_out_data(comparison, executor) if comparison.is_gap else (comparison, {})
    tell("held-out data")
    columns = signatures(nominal, effects, executor)
    alike = similarity(nominal.minimum, tuple(effects), columns)
    decision = decide(comparison, shrinkages)
    if decision.verdict == "unknown" and not (comparison.several or nominal.hypothesis.held_out_decides):
        comparison = replace(comparison, places=with_simple_laws(nominal, comparison.places, executor))
        decision = decide(comparison, shrinkages)
    term = rival_term(comparison, decision, executor)
    decision = beside_simple_term(decision, comparison, shrinkages, term) if term else decision
    drawn = _drawn(comparison, decision, shrinkages, executor, term)
    detectable = detectable_sizes(nominal, effects, columns, executor)
    tell("verdict")
    return Assessment(comparison, decision, shrinkages, alike, detectable, drawn)


def rival_term(comparison: ModelComparison, decision: Decision, executor: Executor | None = None) -> SimpleForm | None:
    """Return the best simple term at the place of a single effect that is named; None where it is no rival.

    As where the effect's law fits as it stands, of which a simple term may be a part, where its shape is not known, and
    where no law at its place explains the data. Of tubes and levels, a free law is the rival.

    Parameters
    ----------
    comparison : ModelComparison
    decision : Decision
    executor : Executor, optional
        Where fits run; in this process when left out.
    """
    if decision.verdict != "effect" or len(decision.best) > 1 or not comparison.nominal.hypothesis.held_out_decides:
        return None
    at, fitted = comparison.places.get(comparison.place_of(decision.best)), comparison.fitted[decision.best]
    if at is None or not fitted.is_bent or not fitted.hypothesis.effects[0].is_shape_known:
        return None
    if not is_misfit_likely(at.explanation):
        return None
    return simple_term(comparison.nominal, at, executor)


def _drawn(
    comparison: ModelComparison,
    decision: Decision,
    shrinkages: Mapping[tuple[str, ...], Shrinkage],
    executor: Executor | None,
    term: SimpleForm | None,
) -> DrawnPlace | None:
    """Return the place of the cause with its law, and how well that predicts held-out data; None without a gap.

    None, too, where a known effect explains what no free law at its place does: that law would mislead.
    """
    label = comparison.place_of(decision.best) if decision.verdict != "no_gap" else ""
    if decision.verdict == "unknown":
        label = next(iter(comparison.places), "")
    at, nominal = comparison.places.get(label), comparison.nominal
    if at is None or (decision.verdict == "effect" and not is_misfit_likely(at.explanation)):
        return None
    shrinkage = comparison.free if label == next(iter(comparison.places)) else None
    if shrinkage is None:
        known = _any_checked(comparison, shrinkages)
        (shrinkage,) = cross_validate(nominal, [at.explanation], executor, known, comparison.noise)
    same = term if term is not None and term.place is at.place else at.term
    told = as_told(nominal, at)
    objection = objection_to_law(comparison, told, shrinkage) if decision.verdict == "unknown" else ""
    return DrawnPlace(told, simple_form(nominal, told, executor, same), shrinkage, objection)


def _on_held_out_data(
    comparison: ModelComparison, executor: Executor | None
) -> tuple[ModelComparison, dict[tuple[str, ...], Shrinkage]]:
    """Return the comparison with the prediction of held-out data, and the shrinkage of the hypotheses so checked."""
    shrinkages: dict[tuple[str, ...], Shrinkage] = {}
    decides = comparison.nominal.hypothesis.held_out_decides

    def checked(names: Sequence[tuple[str, ...]]) -> ModelComparison:
        fits, known = [comparison.fitted[cause] for cause in names], _any_checked(comparison, shrinkages)
        found = cross_validate(comparison.nominal, fits, executor, known, comparison.noise)
        shrinkages.update(zip(names, found, strict=True))
        return comparison.with_held_out(shrinkages) if decides else comparison

    at = next(iter(comparison.places.values()), None)
    if decides and comparison.several and at is not None and is_misfit_likely(at.explanation):
        (free,) = cross_validate(comparison.nominal, [at.explanation], executor, noise=comparison.noise)
        comparison = replace(comparison, free=free)
    wanted = comparison.near if decides else _best_and_parts(comparison)
    # which hypotheses are best may change by the held-out data of those near the best
    while new := [names for names in wanted if names not in shrinkages]:
        comparison = checked(new)
        wanted = _best_and_parts(comparison)
    return comparison, shrinkages


def _any_checked(comparison: ModelComparison, shrinkages: Mapping[tuple[str, ...], Shrinkage]) -> Shrinkage | None:
    """Return any shrinkage, which tells the gap of the nominal model on held-out data; None where none is known yet."""
    return next(iter(shrinkages.values()), comparison.free)


def _best_and_parts(comparison: ModelComparison) -> list[tuple[str, ...]]:
    """Return the hypotheses to check on held-out data.

    The best, the second where that is near, the single effects of the best, the best single one, all single ones that
    are tied with two at once, and where held-out data decide all that are tied with the best: those not checked would
    count as if they foretold them as well as any.
    """
    ranked = [names for names in comparison.ranked if names in comparison.fitted]
    if not ranked:
        return []
    parts = [(name,) for name in ranked[0] if (name,) in comparison.fitted]
    singles = [names for names in ranked if len(names) == 1]
    decides = comparison.nominal.hypothesis.held_out_decides
    tied = [n for n in comparison.tied_with(ranked[0]) if decides or (n in singles and len(ranked[0]) > 1)]
    return list(dict.fromkeys([*comparison.near[:2], *parts, *singles[:1], *tied]))
