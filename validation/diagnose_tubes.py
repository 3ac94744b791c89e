"""Diagnose tube measurements that nobody in this project made: ``docs/validation/diagnosis_tubes.md``.

Run it as ``python -m validation.diagnose_tubes > docs/validation/diagnosis_tubes.md``; some minutes.
"""

from __future__ import annotations

import sys
from typing import Any

from validation.tube_gaps import (
    SAMPLES,
    Case,
    Sure,
    atalla_panneton,
    bare_wool,
    depth_with_correlations,
    fleece,
    limp,
    plants,
)

PLANTS = (("Ajuga 8 cm", 0.08), ("Grass 6 cm", 0.06))
WITHIN, CUT, FROM_CM = 0.2, 4.0, 2

HEADING = """# Diagnosis of measured tubes

Made by `python -m validation.diagnose_tubes`. Data that nobody in this project wrote. The diagnosis is given the
series and the nominal model, never the cause. Misfits are the rms of the difference in the complex reflection
coefficient R. Noise of the TU Delft data is estimated from neighbouring frequencies. Probabilities are those of
campaigns of the two-plate rig: not calibrated on tubes.
"""
PLANTS_TEXT = """
## A cavity behind plants (TU Delft)

Nominal: the plant alone on the wall, 200 to 1600 Hz. Its five JCA parameters are fitted on the series without a cavity;
the posterior of each is its prior for the series with 1 to 5 cm behind, and what that fit leaves of R, rms over root 2,
is the error of each part of R (correlated over 0.3 in ln f). Posteriors are taken one by one: with their correlations
the depths are as good, and their intervals too narrow; that choice was made on these data.

"As known": misfit with the parameters found without a cavity; "first": the most probable of all hypotheses, pairs among
them; its depth, and that of the rear air gap alone; "behind": how far, in ln evidence, the best hypothesis without a
rear air gap is behind the one with it alone.
"""
WOOL_TEXT = """
## A fleece in front of mineral wool (TU Delft)

Nominal: the bare wool, known from its own series in the same way. Third: one wool and one fleece in both thicknesses.
"""
STEP_TEXT = """
## The step of the bare wool near 400 to 450 Hz

Nominal: rigid frame of unknown parameters; the tube is taken for good to 0.01 of R. A resonance within one band is
foretold by no other band: leaving bands out cannot confirm it. Leaving a thickness out can, if both are one material
(third row).
"""
OTHER_TEXT = """
## Limp and rigid, published parameters

Panneton's limp curve (an effective density, as the file turns out: here the impedance of 50 mm of it before a wall), a
rigid frame of his parameters being nominal; both thicknesses of each material of Atalla & Panneton
(2005) before a rigid frame of the published ones. Priors: resistivity 10 %, porosity 0.01, tortuosity 0.05, lengths
15 %; noise 0.03 of Zs/Z0 (of the limp curve: estimated) as one reads off print; tube 0.01 of R (0.005).
"""
PLANT_HEADINGS = (
    "series", "cm", "verdict", "first", "group", "depth / mm, 90 %", "off", "inside", "with it alone",
    "misfit: as known",
    "nominal fit", "with the cause", "cut by", "behind",
)  # fmt: skip
BEFORE = ("data", "verdict", "first", "group", "parameters, 90 %")
AFTER = ("nominal fit", "with the cause", "gap before", "after", "shrinkage")


def heading(*titles: str) -> str:
    """Return the first two lines of a table."""
    return f"| {' | '.join(titles)} |\n|{'---|' * len(titles)}"


def names(effects: tuple[str, ...] | list[str]) -> str:
    """Return the name of a hypothesis."""
    return " + ".join(f"`{name}`" if name != "unknown" else "unknown" for name in effects) or "nominal"


def group(case: Case) -> str:
    """Return the hypotheses that are not told apart."""
    return "; ".join(names(one) for one in case.record["group"]) or "-"


def told(case: Case) -> dict[str, Any]:
    """Return the entry of the cause that is told: the verdict's, or the most probable."""
    chosen = case.record["group"][0] if case.record["verdict"] == "effect" else list(case.first)
    return case.cause(*chosen) or {"parameters": {}}


def sizes(entry: dict[str, Any]) -> str:
    """Return parameters and intervals."""
    parts = [
        f"{name.partition('.')[2]} {p['value']:.3g} ({p['low']:.3g} to {p['high']:.3g}) {p['unit']}".strip()
        for name, p in entry["parameters"].items()
    ]
    return "; ".join(parts) or "-"


def behind(case: Case) -> float:
    """Return by how much the evidence of hypotheses without a rear air gap is below that of it alone."""
    own = case.cause("rear_air_gap")
    others = [one["log_evidence"] for one in case.record["causes"] if "rear_air_gap" not in one["effects"]]
    return float("nan") if own is None or not others else own["log_evidence"] - max(others)


def depth(case: Case, *, alone: bool = False) -> tuple[float, float, float]:
    """Return the depth and its interval, mm, of the best hypothesis that has one, or of the rear air gap `alone`."""
    for one in case.record["causes"]:
        if one["effects"] == ["rear_air_gap"] or (not alone and "rear_air_gap" in one["effects"]):
            found = one["parameters"]["rear_air_gap.depth"]
            return (1e3 * found["value"], 1e3 * found["low"], 1e3 * found["high"])
    return (float("nan"),) * 3


def plant_rows(name: str, sure: Sure, cases: list[Case]) -> list[str]:
    """Return a line per depth."""
    lines = []
    for cm, case in enumerate(cases, start=1):
        value, low, high = depth(case)
        true = 10.0 * cm
        cells = [name, str(cm), case.record["verdict"], names(case.first), group(case)]
        cells += [f"{value:.1f} ({low:.1f} to {high:.1f})", f"{value / true - 1:+.0%}"]
        cells += ["yes" if low <= true <= high else "no"]
        value, low, high = depth(case, alone=True)
        cells += [f"{value:.1f} ({low:.1f} to {high:.1f})", f"{case.foretold:.3f}", f"{case.nominal:.3f}"]
        cells += [f"{case.after:.3f}", f"{case.foretold / case.after:.1f}", f"{behind(case):.1f}"]
        lines.append(f"| {' | '.join(cells)} |")
    print(name, file=sys.stderr)  # noqa: T201
    return lines


def _counts(found: list[tuple[tuple[float, float, float], float]]) -> str:
    """Return how many depths are near the true ones, and how many intervals hold them."""
    near = sum(abs(value / true - 1) <= WITHIN for (value, _, _), true in found)
    return f"{near} and {sum(low <= true <= high for (_, low, high), true in found)}"


def plant_conclusions(found: list[tuple[Sure, list[Case]]]) -> list[str]:
    """Return what is met, counted."""
    flat = [(cm, case) for _, cases in found for cm, case in enumerate(cases, start=1)]
    first = [case for _, case in flat if case.first == ("rear_air_gap",)]
    with_it = [case for _, case in flat if "rear_air_gap" in case.first]
    grouped = [case for _, case in flat if any("rear_air_gap" in one for one in case.record["group"])]
    counts = [_counts([(depth(case, alone=alone), 10.0 * cm) for cm, case in flat]) for alone in (False, True)]
    deep = [case for cm, case in flat if cm >= FROM_CM]
    counts.append(_counts([(depth_with_correlations(case), 0.01 * cm) for cm, case in flat]))
    cut = [case for case in deep if case.foretold / case.after >= CUT]
    return [
        "",
        f"- `rear_air_gap` first: alone in {len(first)} of {len(flat)}, alone or with a second in {len(with_it)};",
        f"  in the group of the verdict, alone or with a second: {len(grouped)}.",
        f"- Depth within {WITHIN:.0%}, and truth in the 90 % interval: {counts[0]} of {len(flat)} by the best",
        f"  hypothesis that has one; {counts[1]} by the rear air gap alone; by this {counts[2]} with correlations",
        "  of the sample's parameters.",
        f"- Misfit of R cut by {CUT:g} or more, {FROM_CM} cm and deeper: {len(cut)} of {len(deep)}.",
        *(
            f"- {name} without a cavity: the model misses R by {sure.misfit:.3f}; error taken {sure.error:.3f}."
            for (name, _), (sure, _) in zip(PLANTS, found, strict=True)
        ),
    ]


def row(case: Case, *, foretold: bool = True) -> str:
    """Return one line of the other tables."""
    gap = case.record["gap"]
    cells = [case.name, case.record["verdict"], names(case.first), group(case), sizes(told(case))]
    cells += [f"{case.foretold:.3f}"] if foretold else []
    cells += [f"{case.nominal:.3f}", f"{case.after:.3f}"]
    cells += [f"{gap['before']:.3g}", f"{gap['after']:.3g}", f"{gap['shrinkage']:.2f}"]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Diagnose and print the page."""
    found = [plants(*one) for one in PLANTS]
    lines = [HEADING, PLANTS_TEXT, heading(*PLANT_HEADINGS)]
    for (name, _), (sure, cases) in zip(PLANTS, found, strict=True):
        lines += plant_rows(name, sure, cases)
    lines += plant_conclusions(found)
    wool = (("2.5",), ("5",), ("2.5", "5"))
    covered, bare = [fleece(*cm) for cm in wool], [bare_wool(*cm) for cm in wool]
    others = [limp(), *(atalla_panneton(one) for one in SAMPLES)]
    lines += [WOOL_TEXT, heading(*BEFORE, "misfit: as known", *AFTER), *(row(case) for case in covered)]
    lines += [STEP_TEXT, heading(*BEFORE, *AFTER), *(row(case, foretold=False) for case in bare)]
    lines += [OTHER_TEXT, heading(*BEFORE, "misfit: as known", *AFTER), *(row(case) for case in others)]
    cases = [*(case for _, each in found for case in each), *covered, *bare, *others]
    lines += ["", "## In words", "", *(f"- {case.name}: {case.record['sentence']}" for case in cases)]
    print("\n".join(lines))  # noqa: T201


if __name__ == "__main__":
    main()
