"""Diagnose every shared campaign and compare with its truth: ``docs/validation/diagnosis.md``.

Run it as ``python -m validation.diagnoses > docs/validation/diagnosis.md``; it takes 20 to 40 minutes.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np

from multilayer.diagnosis.effects.base import EFFECTS
from multilayer.fits.sources import read_fit
from multilayer.media.elastic import p_wave_modulus
from multilayer.threads import THREADS
from validation.scoring import true_modulus

CAMPAIGNS = Path(__file__).parents[1] / ".." / "shared" / "campaigns"
HEADING = """# Diagnosis of the shared campaigns

Made by `python -m validation.diagnoses`. Signals of an independent finite-element rig; who diagnoses has not seen
the effect. "Gap" is chi-square per datum on held-out data, nominal and with the cause.

"Moduli" are errors of the corrected E1 and E2 at 1000 Hz, next to those of the nominal model.

| campaign | truth | verdict | cause | p | size, 90 % interval | true | gap before | after | shrinkage | moduli |
|---|---|---|---|---|---|---|---|---|---|---|"""

TIME = """## Time

Seconds of `multilayer diagnose CAMPAIGN --jobs 2`, from start to exit, all effects, files and figures written; the
better of two runs, each process with one thread, on {cores} cores.
20 s are aimed at for seven configurations and 5 s for one. Seven without a gap meet them, with one mostly not: most of
the time goes into laws drawn at every place, fits of parts of the data that foretell the others, and finite elements of
samples with free or open rims.

| campaign | configurations | bursts | seconds |
|---|---|---|---|"""

WITHOUT = """## With the true effect removed

`--without` the true one: nobody else should be blamed.

| campaign | removed | verdict | in words |
|---|---|---|---|"""


def row(name: str, truth: dict[str, Any], record: dict[str, Any]) -> str:
    """Return one line of the table."""
    cause = None
    if record["verdict"] == "effect":
        cause = next(c for c in record["causes"] if c["effects"] == record["group"][0])
    parameters = cause["parameters"] if cause else {}
    sizes = "; ".join(
        f"{key.split('.')[1]} {p['value']:.3g} ({p['low']:.3g} to {p['high']:.3g}) {p['unit']}".strip()
        for key, p in parameters.items()
    )
    true = "; ".join(f"{key} {value:.3g}" for key, value in truth["parameters"].items())
    gap = record["gap"]
    cells = (
        f"`{name}`", truth["effect"], record["verdict"], " and ".join(cause["effects"]) if cause else "-",
        f"{100 * record['probability']:.0f} %" if cause else "-", sizes or "-", true or "-",
        f"{gap['before']:.3g}", f"{gap['after']:.3g}", f"{gap['shrinkage']:.3f}", _moduli(name, record["unknowns"]),
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


def _moduli(name: str, unknowns: dict[str, Any]) -> str:
    """Return the errors of E1 and E2 with the cause and without."""
    ((label, found),) = unknowns.items()
    true = complex(true_modulus(CAMPAIGNS / name, np.array([float(label[2:].split()[0])]))[0])
    shares = {key: (found[key][0] / true.real - 1, found[key][1] / true.imag - 1) for key in ("corrected", "nominal")}
    return " / ".join(f"{100 * e1:+.1f}, {100 * e2:+.1f} %" for e1, e2 in shares.values())


def main() -> None:
    """Diagnose, compare and print the page."""
    lines, sentences, without = [HEADING], [], [WITHOUT]
    times = [TIME.format(cores=os.cpu_count())]
    for folder in sorted(file.parent for file in CAMPAIGNS.glob("*/campaign.yaml")):
        print(folder.name, file=sys.stderr)  # noqa: T201
        configurations = read_fit(folder).campaign.configurations
        bursts = sum(len(one.bursts) for one in configurations)
        (record, first), (_, second) = (diagnosed(folder) for _ in range(2))
        times.append(f"| `{folder.name}` | {len(configurations)} | {bursts} | {min(first, second):.1f} |")
        truth = json.loads(folder.with_name(f"{folder.name}.truth.json").read_text())
        lines.append(row(folder.name, truth, record))
        sentences.append(f"- `{folder.name}`: {record['sentence']}")
        if (effect := truth["effect"]) in EFFECTS.names():
            said, _ = diagnosed(folder, "--without", effect)
            without.append(f"| `{folder.name}` | {effect} | {said['verdict']} | {said['sentence']} |")
    print("\n".join([*lines, "", _of_glue(), "", *without, "", *times, "", "## In words", "", *sentences]))  # noqa: T201


def diagnosed(folder: Path, *options: str) -> tuple[dict[str, Any], float]:
    """Return what the command writes, as a user types it, and how long it takes, s."""
    with TemporaryDirectory() as parent:
        out = Path(parent) / "results"
        command = [sys.executable, "-m", "multilayer", "diagnose", str(folder), "--out", str(out), "--jobs", "2"]
        start = perf_counter()
        environment = os.environ | dict.fromkeys(THREADS, "1")
        done = subprocess.run([*command, *options], capture_output=True, env=environment, check=False)
        taken = perf_counter() - start
        if done.returncode not in (0, 1):
            raise RuntimeError(done.stderr.decode())
        return json.loads((out / "diagnosis.json").read_text()), taken


def _of_glue() -> str:
    """Return what the true glue's compliance is, free or held sideways."""
    glue = json.loads((CAMPAIGNS / "effect-adhesive.truth.json").read_text())["parameters"]
    free = glue["glue_thickness"] / glue["glue_E"]
    held = free / p_wave_modulus(1.0, 0.3)
    return (
        "The truth file does not tell the glue's Poisson's ratio: its thickness over Young's modulus is "
        f"{free:.3g} m/Pa; a layer that thin is held sideways, and with a ratio of 0.3 it is {held:.3g} m/Pa."
    )


if __name__ == "__main__":
    main()
