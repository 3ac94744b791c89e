"""Fit every shared campaign burst by burst and compare with the truth: ``docs/validation/complex_modulus.md``.

Run it as ``python -m validation.campaigns > docs/validation/complex_modulus.md``; it takes some minutes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from multilayer.fits.burst.fit import fit_bursts
from multilayer.fits.result import FitResult
from multilayer.fits.sources import read_fit
from validation.scoring import Score, score

MODELS = ("plane_wave", "finite")
CAMPAIGNS = Path(__file__).parents[1] / ".." / "shared" / "campaigns"
HEADING = """# Complex modulus, burst by burst, against the truth

Made by `python -m validation.campaigns`. Signals of an independent finite-element rig; default settings of
`multilayer fit`; errors against the material law at each burst's frequency. "Within 2 s" is the share of bursts whose
error is at most two of the stated standard deviations.

| campaign | model | bursts | accepted | median error E1 | E2 | 9 in 10 within, E1 | E2 | within 2 s, E1 | E2 |
|---|---|---|---|---|---|---|---|---|---|"""
READING = """
`effect-none` is the campaign that the model describes: what remains is the laboratory's own uncertainty. In the others
something acts that the plane-wave model lacks (the sample's free rim in `paper-*` and `effect-finite-size`, a mass, an
adhesive layer, the air in the pores); the moduli are then off by far more than their standard deviations, which cannot
know of it. Finding that out is the task of the diagnosis, not of this fit. The finite model has the free rim, and no
other of these. The material of `paper-c` has a loss factor below 0.01 at most frequencies: its E2 is less than what the
stated delay of the channels amounts to.

## Bursts without an accepted solution, and remarks

"""


def row(name: str, result: FitResult, found: Score) -> str:
    """Return one line of the table."""
    errors, sigmas = np.abs(found.relative), np.abs(found.in_sigmas)
    median, ninth, held = np.median(errors, axis=0), np.quantile(errors, 0.9, axis=0), (sigmas <= 2).mean(axis=0)
    cells = [f"{100 * v:.1f} %" for v in (*median, *ninth)] + [f"{100 * v:.0f} %" for v in held]
    model = result.settings["model"]
    return f"| `{name}` | {model} | {len(result.bursts)} | {found.accepted.sum()} | {' | '.join(cells)} |"


def main() -> None:
    """Fit, score and print the page."""
    lines, remarks = [HEADING], []
    for folder in sorted(file.parent for file in CAMPAIGNS.glob("*/campaign.yaml")):
        print(folder.name, file=sys.stderr)  # noqa: T201
        for model in MODELS:
            job = read_fit(folder, model=model)
            result = fit_bursts(job.campaign, job.recordings, job.settings, job.calibration)
            lines.append(row(folder.name, result, score(result, folder)))
            remarks += [
                f"- `{folder.name}`, {model}, {b.configuration}, {b.frequency:g} Hz: {b.remark}"
                for b in result.bursts
                if b.remark
            ]
    print("\n".join([*lines, READING + "\n".join(remarks)]))  # noqa: T201


if __name__ == "__main__":
    main()
