"""Diagnose simulated tubes, every effect among all its rivals: ``docs/validation/diagnosis_simulated_tubes.md``.

Run it as ``python -m validation.diagnose_simulated_tubes > docs/validation/diagnosis_simulated_tubes.md``; some
minutes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from multilayer.diagnosis.tube.diagnose import diagnose_tube
from tests.diagnosis.tubes import CASES, NOISE, measured

ERROR = 0.005  # of R, smooth; the diagnosis allows for 0.01
WITHOUT = 15  # data sets without an effect, of each kind
KINDS = {"two": (0.03, 0.06), "one": (0.06,)}
HEADING = f"""# Diagnosis of simulated tubes

Made by `python -m validation.diagnose_simulated_tubes`. A foam on the wall, 200 to 2000 Hz, noise {NOISE:g} and a
smooth error of {ERROR:g} of each part of R; unknown are resistivity (10 %) and tortuosity (0.05). Every effect of tubes
is tried, alone and in pairs. **The data have the laws of the diagnosis itself:** this checks the machinery, not the
physics, for which see [measured tubes](diagnosis_tubes.md).

| thicknesses | effect | verdict | first | group | size, 90 % | true size | gap before | after | shrinkage |
|---|---|---|---|---|---|---|---|---|---|"""


def record_of(effects: dict[str, dict[str, float]], thicknesses: tuple[float, ...], seed: int = 1) -> dict[str, Any]:
    """Return the diagnosis of one simulated data set."""
    with TemporaryDirectory() as folder:
        file = measured(Path(folder), effects, thicknesses, seed=seed, smooth=ERROR)
        return diagnose_tube(file).record


def names(effects: list[str]) -> str:
    """Return the name of a hypothesis."""
    return " + ".join(f"`{name}`" for name in effects) or "nominal"


def row(kind: str, effect: str, record: dict[str, Any]) -> str:
    """Return one line of the table."""
    first = record["causes"][0] if record["causes"] else {"effects": []}
    own = next((one for one in record["causes"] if one["effects"] == [effect]), {"parameters": {}})
    found = [
        f"{key.partition('.')[2]} {p['value']:.3g} ({p['low']:.3g} to {p['high']:.3g})"
        for key, p in own["parameters"].items()
    ]
    gap = record["gap"]
    cells = [kind, f"`{effect}`", record["verdict"], names(first["effects"])]
    cells += ["; ".join(map(names, record["group"])) or "-", "; ".join(found) or "-"]
    cells += ["; ".join(f"{key} {value:.3g}" for key, value in CASES[effect].items())]
    cells += [f"{gap['before']:.3g}", f"{gap['after']:.3g}", f"{gap['shrinkage']:.2f}"]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Diagnose and print the page."""
    lines, said = [HEADING], []
    for kind, thicknesses in KINDS.items():
        found = {name: record_of({name: sizes}, thicknesses) for name, sizes in CASES.items()}
        lines += [row(kind, name, record) for name, record in found.items()]
        first = sum(bool(r["causes"]) and r["causes"][0]["effects"] == [name] for name, r in found.items())
        group = sum([name] in r["group"] for name, r in found.items())
        alarms = sum(record_of({}, thicknesses, seed)["verdict"] != "no_gap" for seed in range(WITHOUT))
        said.append(
            f"- {kind}: first {first} of {len(CASES)}, in the group of the verdict {group}; "
            f"without an effect {alarms} false alarms of {WITHOUT}."
        )
        print(kind, file=sys.stderr)  # noqa: T201
    print("\n".join([*lines, "", *said]))  # noqa: T201


if __name__ == "__main__":
    main()
