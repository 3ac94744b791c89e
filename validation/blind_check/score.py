"""Scores of a blind check, each beside its number of cases, its target, and two dummies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.stats import beta

from validation.blind_check.check import Outcome
from validation.blind_check.draw import KNOWN

BINS = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0)  # of stated probabilities
PLACES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)  # of sizes, invisible to obvious


@dataclass(frozen=True)
class Score:
    """One score.

    Attributes
    ----------
    name : str
    value : float
        NaN where there is no case.
    n : int
        Number of cases.
    low, high : float
        The target: the value must lie between; NaN where there is none.
    no_gap, random : float
        What two dummies reach: one that always says "no gap", one that names an effect at random.
    is_share : bool
        Whether the value is a share of the cases.
    """

    name: str
    value: float
    n: int
    low: float = float("nan")
    high: float = float("nan")
    no_gap: float = float("nan")
    random: float = float("nan")
    is_share: bool = False

    @property
    def interval(self) -> tuple[float, float]:
        """Central 90 % interval of a share, by Jeffreys' prior: few cases leave much open; NaN of what is no share."""
        if not (self.is_share and self.n):
            return float("nan"), float("nan")
        hits = self.value * self.n
        low, high = (float(beta.ppf(p, hits + 0.5, self.n - hits + 0.5)) for p in (0.05, 0.95))
        return low, high

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None without target or cases."""
        if not self.n or np.isnan(self.low):
            return None
        return bool(self.low <= self.value <= self.high)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        numbers = {name: getattr(self, name) for name in ("value", "low", "high", "no_gap", "random")}
        numbers["interval_low"], numbers["interval_high"] = self.interval
        shown = {name: round(value, 4) if np.isfinite(value) else None for name, value in numbers.items()}
        return {"name": self.name, "n": self.n, **shown, "met": self.met}


@dataclass(frozen=True)
class Targets:
    """GAP.md's, for one configuration or for several."""

    false_alarms: float = 0.01
    first: float = 0.95
    in_group: float = 0.99
    group_size: float = 1.2
    two: float = 0.80
    unknown: float = 0.90
    innocent: float = 0.05
    calibration: float = 0.05
    brier: float = 0.08
    shrinkage: float = 0.9
    place_known: float = 0.97
    place_foreign: float = 0.90
    two_places: float = 0.7
    form: float = 0.8


SEVERAL = Targets()
ONE = Targets(first=0.85, in_group=0.97, group_size=1.5, two=float("nan"), unknown=0.80, innocent=0.10, brier=0.20,
              shrinkage=0.8, place_known=float("nan"), place_foreign=float("nan"), two_places=float("nan"),
              form=float("nan"))  # fmt: skip


def scores(outcomes: Sequence[Outcome], targets: Targets) -> list[Score]:
    """Return the scores of campaigns with the same targets; those of gaps where the effect is well above the noise."""
    done = [o for o in outcomes if o.answer.verdict != "failed"]
    seen = [o for o in done if o.visible]
    one, two = ([o for o in seen if o.draw.kind == kind] for kind in ("one", "two"))
    foreign = [o for o in seen if o.draw.kind in ("outside", "deleted")]
    right = [o for o in one if o.right]
    stated = [o for o in done if o.gap_free or o.visible]
    chance = 1 / len(KNOWN)
    grouped = [len(o.answer.group) for o in one if o.grouped]
    held = [inside for o in right for inside in intervals_hold(o)]
    known, beyond = ([o for o in part if all(o.draw.places)] for part in (one, foreign))
    bands = [o.held for o in foreign if np.isfinite(o.held)]
    forms = [o for o in foreign if o.draw.true_form and o.is_placed]
    unknown = [o for o in foreign if o.answer.verdict == "unknown"]
    return [
        _share("false alarms on gap-free data", done, _gap_free, _alarm, (0, targets.false_alarms), (0, 1)),
        _share("gap seen", seen, _any, _alarm, (0.95, 1), (0, 1)),
        _share("first name right", one, _any, lambda o: o.right, (targets.first, 1), (0, chance)),
        _share("truth in the group", one, _any, lambda o: o.grouped, (targets.in_group, 1), (0, chance)),
        Score("mean size of the group", _mean(grouped), len(grouped), 1, targets.group_size, 0, 1),
        _share("two effects, both found", two, _any, lambda o: o.right, (targets.two, 1), (0, 0)),
        _share("two effects, one of them named", two, _any, _one_of_two),
        _share("foreign effect: says unknown", foreign, _any, _says_unknown, (targets.unknown, 1), (0, 0)),
        _share("foreign effect: blames an innocent", foreign, _any, lambda o: o.named, (0, targets.innocent), (0, 1)),
        _share("foreign effect: an innocent in the group", foreign, _any, lambda o: o.suspects),
        Score("probabilities: calibration error", calibration_error(stated), len(stated), 0, targets.calibration),
        Score("probabilities: Brier score", brier(stated), len(stated), 0, targets.brier),
        Score("90 % intervals of the size that hold it", _mean(held), len(held), 0.85, 0.95),
        Score("held-out shrinkage, right effect (median)", _median([o.answer.shrinkage for o in right]), len(right),
              targets.shrinkage, np.inf, 0.0, float("nan")),
        _share("place right, effect in the library", known, _any, _placed, (targets.place_known, 1)),
        _share("place right, effect in no library", beyond, _any, _placed, (targets.place_foreign, 1)),
        _share("two effects, both places right", two, _any, _placed, (targets.two_places, 1)),
        Score("held-out shrinkage, unknown effect (median)", _median([o.answer.shrinkage for o in unknown]),
              len(unknown), targets.shrinkage, np.inf),
        Score("90 % band of the drawn law holds the true one", _mean(bands), len(bands), 0.85, 0.95),
        _share("simple form right", forms, _any, lambda o: o.answer.form == (o.draw.true_form,), (targets.form, 1)),
    ]  # fmt: skip


def intervals_hold(outcome: Outcome) -> list[bool]:
    """Return for every parameter with a known truth whether its interval holds it."""
    found = []
    for name, true in outcome.draw.truth.items():
        if name in outcome.answer.intervals:
            low, high = outcome.answer.intervals[name]
            found.append(low <= true <= high)
    return found


def reliability(outcomes: Iterable[Outcome]) -> list[tuple[float, float, int]]:
    """Return stated probability, share that is right, and number, in bins of the stated probability."""
    stated = np.array([(o.answer.probability, o.right) for o in outcomes], dtype=float).reshape(-1, 2)
    found = []
    for low, high in pairwise(BINS):
        inside = (stated[:, 0] >= low) & ((stated[:, 0] < high) | (high == BINS[-1]))
        if inside.any():
            found.append((float(stated[inside, 0].mean()), float(stated[inside, 1].mean()), int(inside.sum())))
    return found


def calibration_error(outcomes: Sequence[Outcome]) -> float:
    """Return the mean distance of stated probability and share that is right, bins weighted by their number."""
    bins = reliability(outcomes)
    total = sum(n for _, _, n in bins)
    return sum(abs(stated - right) * n for stated, right, n in bins) / total if total else float("nan")


def brier(outcomes: Iterable[Outcome]) -> float:
    """Return the mean square of stated probability minus right (1) or wrong (0)."""
    return _mean([(o.answer.probability - o.right) ** 2 for o in outcomes])


def confusion(outcomes: Iterable[Outcome]) -> dict[str, dict[str, int]]:
    """Return how often each label (rows) got each answer (columns); two effects under ``two effects``."""
    found: dict[str, dict[str, int]] = {}
    for o in outcomes:
        kind = o.draw.kind
        label = {"none": "no effect", "two": "two effects"}.get(kind) or o.draw.effects[0]
        label = f"{label} ({'not in the library' if kind == 'outside' else 'deleted'})" if kind in _FOREIGN else label
        row = found.setdefault(label, {})
        said = _said(o)
        row[said] = row.get(said, 0) + 1
    return found


_FOREIGN = ("outside", "deleted")


def _said(outcome: Outcome) -> str:
    if not outcome.named:
        return outcome.answer.verdict
    return "both right" if outcome.right and len(outcome.answer.first) > 1 else " and ".join(outcome.answer.first)


def detection(outcomes: Iterable[Outcome]) -> list[tuple[float, float, float, int]]:
    """Return low and high end of a bin of sizes, share of effects in it that were seen as gaps, and their number."""
    sized = [(o.draw.place, _alarm(o)) for o in outcomes if not np.isnan(o.draw.place)]
    found = []
    for low, high in pairwise(PLACES):
        inside = [seen for place, seen in sized if low <= place < high or place == high == 1]
        if inside:
            found.append((low, high, float(np.mean(inside)), len(inside)))
    return found


def _share(
    name: str,
    outcomes: Sequence[Outcome],
    counted: Callable[[Outcome], bool],
    hit: Callable[[Outcome], bool],
    target: tuple[float, float] = (float("nan"), float("nan")),
    dummies: tuple[float, float] = (float("nan"), float("nan")),
) -> Score:
    cases = [hit(o) for o in outcomes if counted(o)]
    return Score(name, _mean(cases), len(cases), *target, *dummies, is_share=True)


def _any(_: Outcome) -> bool:
    return True


def _gap_free(outcome: Outcome) -> bool:
    return outcome.gap_free


def _alarm(outcome: Outcome) -> bool:
    return outcome.answer.verdict != "no_gap"


def _says_unknown(outcome: Outcome) -> bool:
    return outcome.answer.verdict == "unknown"


def _placed(outcome: Outcome) -> bool:
    return outcome.is_placed


def _one_of_two(outcome: Outcome) -> bool:
    return outcome.named and set(outcome.answer.first) <= set(outcome.draw.effects)


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else float("nan")


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else float("nan")
