"""How often the search of a diagnosis finds the best minimum known: ``docs/validation/search.md``.

Run it as ``python -m validation.search > docs/validation/search.md``; about an hour on one core
(``--problems 50``: a quarter of that).

Each problem is a campaign of the blind check's draw (finite elements, sizes from invisible to obvious, laws bent by up
to 30 %) under the hypothesis of the effect that acts. The best known minimum is the best of: the search as it is; the
same with rounding's noise; and a harder one that sets out from all over the prior whatever the gap, and from the true
size, and follows five times as many starts, twice as far. Behind an end is what is better in both: the density, which
the search makes large, and the evidence, by which ends are chosen. Along a ridge one end may have more evidence than a
point above it, by the volume that Laplace's approximation gives it; that is told, too.
"""

from __future__ import annotations

import os
import sys
from argparse import ArgumentParser
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from time import process_time
from typing import Any

import numpy as np

SEED = 11  # below 1000: for development
PROBLEMS = 200
REACHED = 0.5  # nats
NOISE = 1e-12
STAGES = ((100, 20), (60, 20), (30, 20), (20, 20))  # of the harder search
FOLLOWED = 6
EXPLAINED = 4.0  # chi-square per datum: above, the law is none of what acts, however well it is fitted
HEADING = """# The search of a diagnosis

Made by `python -m validation.search --problems {count}`. {what}

| effect | problems | largest nominal chi-square per datum | reached | behind by at most |
|---|---|---|---|---|"""


@dataclass(frozen=True)
class Outcome:
    """One problem: the effect, the gap, what the best minimum leaves of it, how far behind it runs end, and the cost.

    Gap and what is left are chi-square per datum; `behind` is in density and evidence both, `less_evident` in the
    latter, of the first run.
    """

    number: int
    effect: str
    gap: float
    left: float
    behind: tuple[float, ...]
    less_evident: float
    seconds: float
    harder: float


def main() -> None:
    """Print the page."""
    from multilayer.executors import local_pool, run_all

    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--problems", type=int, default=PROBLEMS)
    count = parser.parse_args().problems
    tasks = [*problems(count)]
    with local_pool(os.cpu_count() or 1) as executor:
        page(run_all(solve, tasks, executor, lambda index: print(f"problem {index}", file=sys.stderr)))  # noqa: T201


def page(outcomes: list[Outcome]) -> None:
    """Print the page of some outcomes."""
    text = (
        f"The first draws of seed {SEED} with one effect,\neach under the hypothesis of that effect. The best minimum "
        "known is the best of the search as it is, the same with\nrounding's noise, and a harder one from all over the "
        "prior and from the true size, with five times as many starts;\n"
        f"it is reached where none is better by {REACHED} nats in density and in evidence. A law that leaves more than "
        f"{EXPLAINED:g} per datum at\nits best does not explain the campaign (it is bent, or too crude); such fits are "
        "not followed to the end."
    )
    tell(HEADING.format(what=text, count=len(outcomes)))
    explained = [one for one in outcomes if one.left <= EXPLAINED]
    for effect in sorted({one.effect for one in explained}):
        tell(line(effect, [one for one in explained if one.effect == effect]))
    tell(line("all that the law explains", explained))
    if rest := [one for one in outcomes if one.left > EXPLAINED]:
        tell(line("the others", rest))
    noisy = np.array([behind for one in explained for behind in one.behind[1:]])
    seen = sum(one.less_evident < REACHED for one in explained)
    seconds, harder = (float(np.median([getattr(one, key) for one in outcomes])) for key in ("seconds", "harder"))
    tell(
        f"\nWith the data multiplied by 1 + {NOISE:g} noise the same search reaches it in "
        f"{100 * np.mean(noisy < REACHED):.1f} % of those that the law explains. By evidence alone (ends higher on the "
        f"same ridge, too), {seen} of {len(explained)} are reached. Median processor time of the nominal "
        f"model's fit and that of one effect: {seconds:.1f} s; of the harder search {harder:.1f} s more."
    )


def line(name: str, outcomes: list[Outcome]) -> str:
    """Return a row of the table."""
    behind = np.array([one.behind[0] for one in outcomes])
    reached = int(np.sum(behind < REACHED))
    gap = max(one.gap for one in outcomes)
    return f"| {name} | {len(outcomes)} | {gap:.3g} | {reached} of {len(outcomes)} | {behind.max():.2f} nats |"


def problems(wanted: int) -> Iterator[int]:
    """Give the numbers of draws with one effect."""
    from validation.blind_check.draw import draw

    number, count = 0, 0
    while count < wanted:
        if len(draw(number, SEED).effects) == 1 and draw(number, SEED).kind in ("one", "deleted"):
            yield number
            count += 1
        number += 1


def solve(number: int) -> Outcome:
    """Return how far each run of the search ends behind the best."""
    from multilayer.diagnosis.diagnose import chosen_effects, fit_nominal, fits_one_by_one
    from multilayer.rig.synthesis import make_campaign
    from validation.blind_check.draw import draw

    sealed = draw(number, SEED)
    made = make_campaign(sealed.settings, sealed.seed)
    (name,) = sealed.effects
    effects = chosen_effects([name])
    ends, gap, seconds = [], 0.0, 0.0
    for seed in range(2):
        rng = np.random.default_rng(seed)
        noise = NOISE if seed else 0.0
        recordings = {
            key: replace(one, top=one.top * (1 + noise * rng.standard_normal(one.top.shape)))
            for key, one in made.recordings.items()
        }
        start = process_time()
        nominal, minima = fit_nominal(made.campaign, recordings)
        _, fits = fits_one_by_one(nominal, minima, effects, None)
        ends.append(fits[name,])
        if not seed:
            seconds = process_time() - start
            gap = nominal.minimum.cost_per_datum
            first, others = nominal, [minimum.z for minimum in minima]
    start = process_time()
    if not effects[name].needs_finite_elements:
        ends += harder(first, others, effects[name], sealed.truth)
    best = max(ends, key=lambda end: end.log_evidence)
    behind = tuple(max(how_much_better(other, end) for other in ends) for end in ends[:2])
    left = best.minimum.cost_per_datum
    less_evident = float(best.log_evidence - ends[0].log_evidence)
    return Outcome(number, name, gap, left, behind, less_evident, seconds, process_time() - start)


def how_much_better(other: Any, end: Any) -> float:
    """Return by how many nats an end is better than another in density and in evidence: the lesser of the two."""
    density, reference = (
        -0.5 * (one.minimum.cost + (one.errors.log_determinant if one.errors else 0.0)) for one in (other, end)
    )
    return float(min(density - reference, other.log_evidence - end.log_evidence))


def harder(nominal: Any, minima: Sequence[Any], effect: Any, truth: Mapping[str, float]) -> list[Any]:
    """Return the ends of a search with more starts, among them the true size where the draw tells it."""
    from multilayer.diagnosis.fitting import begin, polish_fits
    from multilayer.diagnosis.starting_laws import starting_laws
    from multilayer.inference import multistart

    others = np.concatenate([starting_laws(nominal.hypothesis), minima])
    effects = [effect]
    if all(f"{effect.name}.{one.name}" in truth for one in effect.parameters):
        at = tuple(float(one.prior.coordinate(truth[f"{effect.name}.{one.name}"])) for one in effect.parameters)
        effects.append(type("AtTruth", (type(effect),), {"starts": (at,)})())
    usual, multistart._STAGES = multistart._STAGES, STAGES
    hypotheses = [nominal.hypothesis.with_effects(one) for one in effects]
    started = [begin(one, nominal.minimum.z, others=others, followed=FOLLOWED) for one in hypotheses]
    multistart._STAGES = usual
    pairs = [(start, end) for one in started for start, end in zip(one.starts, one.ends, strict=True)]
    return [polish_fits({0: replace(end(), valleys=start[None])})[0] for start, end in pairs]


def tell(text: str) -> None:
    """Write a line."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
