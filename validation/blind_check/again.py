"""Campaigns of a final seed, diagnosed again by today's rules, their labels open: development data from then on.

Run it as ``python -m validation.blind_check.again --seed 1006 10 160``; about 45 s for each. ``--right`` and
``--missed`` take, of the answers that are kept of a seed, those that name an effect rightly or say something wrong of a
gap that is seen, ``--drawn`` those whose drawn law has a known truth. The last lines tell how many 90 % intervals of a
size hold the true one, and the share of the true laws that the 90 % bands hold.
"""

from __future__ import annotations

import gzip
import json
import sys
from argparse import ArgumentParser
from pathlib import Path

import numpy as np

from multilayer.executors import as_done, executor_for
from validation.blind_check.check import Answer, BlindTask, Outcome, answer, unseal
from validation.blind_check.score import intervals_hold

HEADING = """\
| campaign | added | named | probability | places | held-out shrinkage | intervals that hold | band that holds |
|---|---|---|---|---|---|---|---|"""


def main() -> None:
    """Print a table."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("numbers", nargs="*", type=int)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--right", action="store_true", help="those whose effect was named")
    parser.add_argument("--missed", action="store_true", help="those whose gap was seen and told wrongly")
    parser.add_argument("--drawn", action="store_true", help="those whose drawn law has a known truth")
    parser.add_argument("--jobs", type=int, default=1)
    given = parser.parse_args()
    numbers = set(given.numbers)
    if given.right or given.missed or given.drawn:
        for outcome in unseal(kept_answers(given.seed), given.seed):
            wanted = (
                (given.right and _is_named(outcome))
                or (given.missed and not outcome.right)
                or (given.drawn and np.isfinite(outcome.held))
            )
            if outcome.visible and wanted:
                numbers.add(outcome.draw.number)
    if not numbers:
        parser.error("which campaigns? Their numbers, --right, --missed or --drawn")
    tasks = [BlindTask(number, given.seed) for number in sorted(numbers)]
    held: list[bool] = []
    shares: list[float] = []
    sys.stdout.write(f"{HEADING}\n")
    with executor_for(given.jobs, None) as executor:
        for _, found in as_done(answer, tasks, executor):
            (outcome,) = unseal([found], given.seed)
            inside = intervals_hold(outcome) if _is_named(outcome) else []
            held += inside
            shares += [outcome.held] if np.isfinite(outcome.held) else []
            sys.stdout.write(f"{_row(outcome, inside)}\n")
            sys.stdout.flush()
    sys.stdout.write(f"\n{sum(held)} of {len(held)} intervals of right names hold the size.\n")
    if shares:
        text = f"The bands of {len(shares)} drawn laws hold the true ones at {100 * np.mean(shares):.1f} %"
        sys.stdout.write(f"{text} of the frequencies.\n")


def kept_answers(seed: int) -> list[Answer]:
    """Return the answers of a final seed that are kept beside this module."""
    path = Path(__file__).with_name(f"answers-{seed}.jsonl.gz")
    with gzip.open(path, "rt") as lines:
        next(lines)  # what they were made with
        return [Answer.from_dict(json.loads(line)) for line in lines]


def _is_named(outcome: Outcome) -> bool:
    return outcome.right and outcome.draw.kind == "one"


def _row(outcome: Outcome, inside: list[bool]) -> str:
    said, label = outcome.answer, outcome.draw
    named = " + ".join(said.first) if outcome.named else said.verdict
    cells = (
        str(label.number), " + ".join(label.effects) or "nothing", named, f"{said.probability:.2f}",
        ", ".join(said.places[:2]), f"{said.shrinkage:.3f}", f"{sum(inside)} of {len(inside)}" if inside else "-",
        f"{100 * outcome.held:.0f} %" if np.isfinite(outcome.held) else "-",
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
