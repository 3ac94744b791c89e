"""The blind check: campaigns are drawn, labels hidden, every campaign diagnosed, and only then unsealed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from multilayer.diagnosis.diagnose import chosen_effects, diagnose_campaign, fit_nominal
from multilayer.diagnosis.effects.base import EFFECTS
from multilayer.rig.synthesis import make_campaign
from validation.blind_check.draw import OUTSIDE, Draw, draw

FINAL_SEEDS = 1000  # seeds from here on are for final runs, each judged once: development data from then on
_OBVIOUS = 10.0  # standard deviations of the nominal misfit above chance: an effect well above the noise


_LAW = ("frequency_hz", "real_low", "real_high", "imag_low", "imag_high")


@dataclass(frozen=True)
class BlindTask:
    """A campaign to draw and to diagnose."""

    number: int
    seed: int


@dataclass(frozen=True)
class Answer:
    """What the diagnosis said of a campaign; it has not seen the label.

    Attributes
    ----------
    number : int
    verdict : str
        ``failed`` where there is no answer.
    first : tuple of str
        The cause that is named first; empty without a gap.
    group : tuple of tuple of str
    probability : float
        Stated, of what the verdict says.
    excess : float
        How many standard deviations the nominal misfit, stated uncertainties included, lies above chance.
    excess_alone : tuple of float
        The same of each of two effects, had it acted by itself; empty for others.
    shrinkage : float
        Of the gap on held-out data.
    intervals : dict
        Low and high end of every parameter of the first cause.
    evidence : dict
        Log evidence over the nominal model's, of what was tried, names joined by ``+``.
    seconds : float
        Of processor time, for making and for diagnosing.
    problem : str
        Why there is no answer.
    places : tuple of str
        Where something acts, the most probable first.
    law : mapping
        Frequency (Hz) and ends of the band of real and imaginary part, of the law drawn at the first place.
    form : tuple of str
        Kinds of the terms of its simple form.
    """

    number: int
    verdict: str
    first: tuple[str, ...] = ()
    group: tuple[tuple[str, ...], ...] = ()
    probability: float = 1.0
    excess: float = 0.0
    excess_alone: tuple[float, ...] = ()
    shrinkage: float = 0.0
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    evidence: Mapping[str, float] = field(default_factory=dict)
    seconds: tuple[float, float] = (0.0, 0.0)
    problem: str = ""
    places: tuple[str, ...] = ()
    law: Mapping[str, Sequence[float]] = field(default_factory=dict)
    form: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Answer:
        """Return what `to_dict` gave, lists in place of tuples."""
        lists = {
            "first": tuple(data["first"]),
            "group": tuple(tuple(names) for names in data["group"]),
            "intervals": {name: (float(low), float(high)) for name, (low, high) in data["intervals"].items()},
            "excess_alone": tuple(data.get("excess_alone", ())),
            "seconds": tuple(data["seconds"]),
            "places": tuple(data.get("places", ())),
            "form": tuple(data.get("form", ())),
        }
        return cls(**{**data, **lists})


def answer(task: BlindTask) -> Answer:
    """Draw a campaign and diagnose it; what is deleted from the library is left out, the label is not looked at."""
    from time import process_time

    start = process_time()
    sealed = draw(task.number, task.seed)
    try:
        made = make_campaign(sealed.settings, sealed.seed)
        ready = process_time()
        without = [name for name in (*sealed.deleted, *OUTSIDE) if name in EFFECTS]  # plugins may know more
        record = diagnose_campaign(made.campaign, made.recordings, chosen_effects(without=without)).record
        given = _answer(task.number, record, (ready - start, process_time() - ready))
        return replace(given, excess_alone=_excess_alone(sealed)) if sealed.kind == "two" else given
    except Exception as error:  # whatever goes wrong with one campaign: it counts, is told, and does not end the check
        return Answer(task.number, "failed", problem=f"{type(error).__name__}: {error}")


def _excess_alone(sealed: Draw) -> tuple[float, ...]:
    """Return how far each of several effects is above the noise by itself: for the scores, once the answer is given."""
    found = []
    for effect in sealed.settings.effects:
        made = make_campaign(sealed.settings.model_copy(update={"effects": (effect,)}), sealed.seed)
        minimum = fit_nominal(made.campaign, made.recordings)[0].minimum
        found.append(_excess(minimum.cost, len(minimum.residual)))
    return tuple(found)


def _excess(chi_square: float, n_data: int) -> float:
    return float((chi_square - n_data) / np.sqrt(2 * n_data))


def _answer(number: int, record: Mapping[str, Any], seconds: tuple[float, float]) -> Answer:
    inputs = record["inputs"]
    excess = _excess(inputs["chi_square"], inputs["n_data"])
    if record["verdict"] == "no_gap":
        return Answer(number, "no_gap", probability=record["probability"], excess=excess, seconds=seconds)
    group = tuple(tuple(names) for names in record["group"])
    chosen = group[0] if group else ("unknown",)
    cause = next(cause for cause in record["causes"] if tuple(cause["effects"]) == chosen)
    evidence = {"+".join(one["effects"]): one["log_evidence"] for one in record["causes"]}
    law = record["law"] or {}
    return Answer(
        number, record["verdict"], chosen, group, record["probability"], excess, (), record["gap"]["shrinkage"],
        {name: (p["low"], p["high"]) for name, p in cause["parameters"].items()}, evidence, seconds,
        places=tuple(place["place"] for place in record["places"]),
        # a law beyond open rims is not the quantity that is drawn at the faces
        law={name: law[name] for name in _LAW} if law and "open_rim" not in law else {},
        form=tuple(term["kind"] for term in law["form"]["terms"]) if law else (),
    )  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """A label beside its answer."""

    draw: Draw
    answer: Answer

    @property
    def gap_free(self) -> bool:
        """Whether nothing was added."""
        return self.draw.kind == "none"

    @property
    def visible(self) -> bool:
        """Whether what was added is well above the noise, after the unknowns took what they can; of two, each."""
        alone = self.answer.excess_alone or (self.answer.excess,)
        return not self.gap_free and min(self.answer.excess, *alone) > _OBVIOUS

    @property
    def named(self) -> bool:
        """Whether the verdict names effects."""
        return self.answer.verdict == "effect"

    @property
    def right(self) -> bool:
        """Whether the verdict is what the label calls for."""
        kind = self.draw.kind
        if kind == "none":
            return self.answer.verdict == "no_gap"
        if kind in ("outside", "deleted"):
            return self.answer.verdict == "unknown"
        return self.named and set(self.answer.first) == set(self.draw.effects)

    @property
    def is_placed(self) -> bool:
        """Whether the first place is where the one effect acts, or the first two are those of two effects."""
        true = set(self.draw.places)
        return bool(self.answer.places) and set(self.answer.places[: len(true)]) == true

    @property
    def held(self) -> float:
        """Share of real and imaginary parts at all frequencies that their bands hold; NaN where that is not known."""
        law = self.answer.law
        if not law or not self.is_placed:
            return float("nan")
        true = self.draw.true_law(np.array(law["frequency_hz"]))
        if true is None:
            return float("nan")
        ends = [np.array(law[name]) for name in _LAW[1:]]
        inside = (ends[0] <= true.real) & (true.real <= ends[1]), (ends[2] <= true.imag) & (true.imag <= ends[3])
        return float(np.mean(inside))

    @property
    def grouped(self) -> bool:
        """Whether the truth is in the group."""
        return any(set(names) == set(self.draw.effects) for names in self.answer.group)

    @property
    def suspects(self) -> bool:
        """Whether a known cause is in the group."""
        return any(tuple(names) != ("unknown",) for names in self.answer.group)


def unseal(answers: Sequence[Answer], seed: int) -> list[Outcome]:
    """Return every answer with its label, in the order of their numbers."""
    return [Outcome(draw(one.number, seed), one) for one in sorted(answers, key=lambda one: one.number)]
