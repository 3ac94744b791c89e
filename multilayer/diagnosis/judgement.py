"""From a nominal model and its effects to a verdict: the steps that are the same for rigs and tubes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from multilayer.diagnosis.cross_validation import Shrinkage, shrinkage
from multilayer.diagnosis.decision import Decision, decide
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.evidence import Hypotheses, compare
from multilayer.diagnosis.experiment_design import Alive
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.locate import locate, shown
from multilayer.diagnosis.record import cause_entries, confounded_entries, gap_entry, sentence, worth_checking
from multilayer.diagnosis.result import Similarity
from multilayer.diagnosis.signatures import detectable, inner_products, signature
from multilayer.diagnosis.thresholds import ALIVE

Progress = Callable[[str], None]
N_STEPS = 5  # of a diagnosis, the nominal model and the effects one by one included


@dataclass(frozen=True)
class Judgement:
    """All that a diagnosis rests on.

    Attributes
    ----------
    found : Hypotheses
    decision : Decision
    held : dict
        Shrinkage on held-out data, by the names of effects.
    similarity : Similarity
    sizes : dict
        The smallest effects that the data would show.
    """

    found: Hypotheses
    decision: Decision
    held: Mapping[tuple[str, ...], Shrinkage]
    similarity: Similarity
    sizes: Mapping[str, Mapping[str, object]]

    @property
    def nominal(self) -> Fitted:
        """The nominal model."""
        return self.found.nominal

    @property
    def is_gap(self) -> bool:
        """Whether there is one."""
        return self.decision.verdict != "no_gap"

    @property
    def shown(self) -> Fitted:
        """The most probable cause, also where it is not trusted; the nominal model where there is none."""
        return self.found.fitted.get(self.decision.best, self.nominal)

    @property
    def corrected(self) -> Fitted:
        """The model to be used: with the cause where the verdict names one."""
        return self.shown if self.decision.verdict == "effect" else self.nominal

    @cached_property
    def probabilities(self) -> dict[tuple[str, ...], float]:
        """Of the causes."""
        return self.found.probabilities()

    @property
    def alive(self) -> Alive:
        """The hypotheses an experiment should separate: the group's, or the first and its rival.

        What is far behind is not alive, and which of such it is hangs on next to nothing.
        """
        ranked = [names for names in self.found.ranked if names in self.found.fitted]
        tied = [names for names in ranked if names in self.decision.group]
        near = [names for names in ranked[:2] if self.found.score(ranked[0]) - self.found.score(names) < ALIVE]
        chosen = tied if len(tied) > 1 else near
        return [(self.found.fitted[names], max(self.probabilities[names], 1e-6)) for names in chosen]

    def record(self, next_experiment: Callable[[Alive], list[dict[str, Any]]], seed: int) -> dict[str, Any]:
        """Return ``diagnosis.json``, but for what is special to rigs or tubes.

        Parameters
        ----------
        next_experiment : callable
            Gives the entries of ``next_experiment`` from the hypotheses alive.
        seed : int
            Of the places' look-elsewhere draw.
        """
        probability = self.decision.probability(self.found)
        where, causes, plans = [], [], []
        if self.is_gap:
            where = shown(*locate(self.nominal.hypothesis, self.nominal.minimum, seed))
            causes = cause_entries(self.found, self.held, self.similarity, self.probabilities, self.decision.group)
            plans = next_experiment(self.alive)
        return {
            "version": 1,
            "verdict": self.decision.verdict,
            "sentence": sentence(self.found, self.decision, probability),
            "probability": round(probability, 4),
            "where": where,
            "causes": causes,
            "group": [list(names) for names in self.decision.group if self.decision.verdict == "effect"],
            "gap": gap_entry(self.nominal, self.held.get(self.decision.best) or next(iter(self.held.values()), None)),
            "detectable": dict(self.sizes),
            "confounded": confounded_entries(self.similarity),
            "next_experiment": plans,
            "hypotheses_tried": len(self.found.evidence),
        }

    def fit_numbers(self) -> dict[str, float]:
        """Return the nominal misfit, as it stands in ``inputs``."""
        return {
            "p_value": self.found.p_value,
            "chi_square": self.nominal.minimum.cost,
            "n_data": len(self.nominal.minimum.residual),
        }


def judge(
    nominal: Fitted,
    singles: Mapping[tuple[str, ...], Fitted],
    effects: Mapping[str, BaseEffect],
    tell: Progress,
    executor: Executor | None = None,
) -> Judgement:
    """Return the verdict on a nominal model, its effects fitted one by one.

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
    """
    found = compare(nominal, singles, effects, executor)
    tell("effects in pairs")
    found, held = _on_held_out_data(found, executor) if found.is_gap else (found, {})
    tell("held-out data")
    signatures = [signature(nominal, effect) for effect in effects.values()]
    columns = np.stack(signatures, axis=1) if signatures else np.empty((len(nominal.minimum.residual), 0))
    similarity = Similarity(tuple(effects), *inner_products(nominal.minimum, columns))
    sizes = detectable(nominal, effects, columns)
    tell("verdict")
    return Judgement(found, decide(found, held), held, similarity, sizes)


def _on_held_out_data(
    found: Hypotheses, executor: Executor | None
) -> tuple[Hypotheses, dict[tuple[str, ...], Shrinkage]]:
    """Return the hypotheses with what held-out data say of them, and the shrinkage of those that were checked."""
    held: dict[tuple[str, ...], Shrinkage] = {}
    decides = found.nominal.hypothesis.held_out_decides

    def checked(wanted: Sequence[tuple[str, ...]]) -> Hypotheses:
        tried = [names for names in wanted if names not in held]
        before = next((one.before for one in held.values()), None)
        shares = shrinkage(found.nominal, [found.fitted[names] for names in tried], executor, before) if tried else []
        held.update(zip(tried, shares, strict=True))
        return found.informed(held) if decides else found

    # what is best is known only once held-out data have decided between those that are near
    return checked(worth_checking(checked(found.near if decides else []))), held
