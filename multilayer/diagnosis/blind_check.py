"""The blind check: campaigns are drawn, labels hidden, every campaign diagnosed, then unsealed and scored."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from multilayer.diagnosis.blind_draw import KNOWN, MIX, Draw, draw
from multilayer.diagnosis.diagnose import chosen_effects, diagnose_campaign
from multilayer.rig.synthesis import make_campaign

_OBVIOUS = 10.0  # standard deviations of the nominal misfit above chance: an effect well above the noise


@dataclass(frozen=True)
class BlindTask:
    """A campaign to draw and to diagnose."""

    number: int
    seed: int
    several: bool = True


@dataclass(frozen=True)
class Answer:
    """What the diagnosis said of a campaign; it has not seen the label.

    Attributes
    ----------
    number : int
    verdict : str
    first : tuple of str
        The most probable cause; empty without a gap.
    group : tuple of tuple of str
    probability : float
        Of the first cause.
    excess : float
        How many standard deviations the nominal misfit lies above chance.
    shrinkage : float
    intervals : dict
        Low and high end of every parameter of the first cause.
    problem : str
        Why there is no answer; empty when there is one.
    """

    number: int
    verdict: str
    first: tuple[str, ...] = ()
    group: tuple[tuple[str, ...], ...] = ()
    probability: float = 1.0
    excess: float = 0.0
    shrinkage: float = 0.0
    intervals: dict[str, tuple[float, float]] | None = None
    problem: str = ""


def answer(task: BlindTask) -> Answer:
    """Draw a campaign and diagnose it; what is deleted from the library is left out, the label is not looked at."""
    sealed = draw(task.number, task.seed, several=task.several)
    try:
        made = make_campaign(sealed.settings, sealed.seed)
        effects = chosen_effects(without=sealed.deleted)
        record = diagnose_campaign(made.campaign, made.recordings, effects).record
    except Exception as error:  # one campaign that cannot be made or diagnosed must not end the check
        return Answer(task.number, "failed", problem=f"{type(error).__name__}: {error}")
    return _answer(task.number, record)


def _answer(number: int, record: dict[str, Any]) -> Answer:
    inputs = record["inputs"]
    excess = (inputs["chi_square"] - inputs["n_data"]) / np.sqrt(2 * inputs["n_data"])
    if record["verdict"] == "no_gap":
        return Answer(number, "no_gap", excess=float(excess))
    first = record["causes"][0]
    group = tuple(tuple(names) for names in record["group"])
    chosen = group[0] if group else tuple(first["effects"])
    cause = next((c for c in record["causes"] if tuple(c["effects"]) == chosen), first)
    return Answer(
        number, record["verdict"], chosen, group, cause["probability"], float(excess), record["gap"]["shrinkage"],
        {name: (p["low"], p["high"]) for name, p in cause["parameters"].items()},
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
        """Whether what was added is well above the noise."""
        return not self.gap_free and self.answer.excess > _OBVIOUS

    @property
    def named(self) -> bool:
        """Whether the verdict names effects."""
        return self.answer.verdict == "effect"


def unseal(answers: Sequence[Answer], seed: int, *, several: bool = True) -> list[Outcome]:
    """Return every answer with its label."""
    return [Outcome(draw(one.number, seed, several=several), one) for one in answers]


def score(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return the scores of GAP.md, each beside its number of cases; NaN where there is none."""
    done = [o for o in outcomes if o.answer.verdict != "failed"]
    none = [o for o in done if o.gap_free]
    seen = [o for o in done if o.visible]
    one = [o for o in seen if o.draw.kind == "one"]
    two = [o for o in seen if o.draw.kind == "two"]
    foreign = [o for o in seen if o.draw.kind in ("outside", "deleted")]
    right = [o for o in one if o.named and set(o.answer.first) == set(o.draw.effects)]
    grouped = [o for o in one if o.named and any(set(n) == set(o.draw.effects) for n in o.answer.group)]
    return {
        "campaigns": len(outcomes),
        "failed": len(outcomes) - len(done),
        "false_alarms": _share([o.answer.verdict != "no_gap" for o in none]),
        "detected": _share([o.answer.verdict != "no_gap" for o in seen]),
        "first_name_right": _share([o in right for o in one]),
        "truth_in_group": _share([o in grouped for o in one]),
        "group_size": _mean([len(o.answer.group) for o in grouped]),
        "both_found": _share([o.named and set(o.answer.first) == set(o.draw.effects) for o in two]),
        "says_unknown": _share([o.answer.verdict == "unknown" for o in foreign]),
        "blames_an_innocent": _share([o.named for o in foreign]),
        "brier": _mean([(o.answer.probability - (o in right)) ** 2 for o in one if o.named]),
        "shrinkage": float(np.median([o.answer.shrinkage for o in right])) if right else float("nan"),
        "dummies": _dummies(outcomes),
    }


def _share(hits: Sequence[bool]) -> dict[str, float]:
    return {"share": float(np.mean(hits)) if hits else float("nan"), "of": len(hits)}


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else float("nan")


def _dummies(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return what always saying "no gap", and a random name, would score."""
    gap = [o for o in outcomes if not o.gap_free]
    return {
        "always_no_gap": {"false_alarms": 0.0, "detected": 0.0, "first_name_right": 0.0},
        "random_name": {
            "false_alarms": 1.0,
            "detected": 1.0 if gap else float("nan"),
            "first_name_right": 1 / len(KNOWN),
        },
        "expected_mix": MIX,
    }
