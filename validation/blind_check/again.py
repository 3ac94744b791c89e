"""Campaigns of a final seed, diagnosed again by today's rules, their labels open: development data from then on.

Run it as ``python -m validation.blind_check.again --seed 1006 10 160``; half a minute for each.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser

from validation.blind_check.check import BlindTask, answer
from validation.blind_check.draw import draw

HEADING = """| campaign | added | named | probability | places | held-out shrinkage |
|---|---|---|---|---|---|"""


def main() -> None:
    """Print a table."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("numbers", nargs="+", type=int)
    parser.add_argument("--seed", type=int, required=True)
    given = parser.parse_args()
    sys.stdout.write(f"{HEADING}\n")
    for number in given.numbers:
        found, label = answer(BlindTask(number, given.seed)), draw(number, given.seed)
        named = " + ".join(found.first) or found.verdict
        cells = (
            str(number), " + ".join(label.effects) or "nothing", named, f"{found.probability:.2f}",
            ", ".join(found.places[:2]), f"{found.shrinkage:.3f}",
        )  # fmt: skip
        sys.stdout.write(f"| {' | '.join(cells)} |\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
