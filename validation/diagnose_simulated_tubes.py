"""Diagnose simulated tubes, every effect among all its rivals: ``docs/validation/diagnosis_simulated_tubes.md``.

Run it as ``python -m validation.diagnose_simulated_tubes > docs/validation/diagnosis_simulated_tubes.md``; some
minutes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from multilayer.diagnosis.tube.diagnose import diagnose_tube
from multilayer.media.laws import complex_modulus
from multilayer.stack import Stack
from tests.diagnosis.tubes import CASES, ELASTIC, NOISE, foam, measured, with_modulus

ERROR = 0.005  # of R, smooth; the diagnosis allows for 0.01
WITHOUT = 15  # data sets without an effect, of each kind
KINDS = {"two": (0.03, 0.06), "one": (0.06,)}
LAWS, FRAMES = 14, 6  # moduli of the frame that are drawn; data sets of a frame as stated
HEADING = f"""# Diagnosis of simulated tubes

Made by `python -m validation.diagnose_simulated_tubes`. A foam on the wall, 200 to 2000 Hz, noise {NOISE:g} and a
smooth error of {ERROR:g} of each part of R; unknown are resistivity (10 %) and tortuosity (0.05). Every effect of tubes
is tried, alone and in pairs. **The data have the laws of the diagnosis itself:** this checks the machinery, not the
physics, for which see [measured tubes](diagnosis_tubes.md).

| thicknesses | effect | verdict | first | group | size, 90 % | true size | gap before | after | shrinkage |
|---|---|---|---|---|---|---|---|---|---|"""


FRAME_TEXT = """
## A modulus of the frame that varies with frequency

The foam of both thicknesses has an elastic frame, nominally of E = 0.12 MPa and a loss factor of 0.1, whose resonances
lie in the band. The true modulus is a fractional Zener law drawn at random: relaxed modulus 0.06 to 0.24 MPa, 1.5 to 10
times that unrelaxed, relaxing at 200 to 2000 Hz, of order 0.4 to 0.9. No effect of the library is that; its place is
`layer_modulus`. Ahead: nats of the free law there before the next place. In the band: share of frequencies (even in
ln f) at which the 90 % band of real and of imaginary part holds the true change of ln E.

| relaxed / MPa | ratio | Hz | order | verdict | first place | ahead | in the band: Re | Im | passive | causal |
|---|---|---|---|---|---|---|---|---|---|---|"""


def record_of(effects: dict[str, dict[str, float]], thicknesses: tuple[float, ...], seed: int = 1) -> dict[str, Any]:
    """Return the diagnosis of one simulated data set."""
    with TemporaryDirectory() as folder:
        file = measured(Path(folder), effects, thicknesses, seed=seed, smooth=ERROR)
        return diagnose_tube(file).record


def frame_laws() -> list[dict[str, Any]]:
    """Return moduli of the frame, drawn at random."""
    rng = np.random.default_rng(1)
    laws, ranges = [], np.log([(6e4, 2.4e5), (1.5, 10), (200, 2000)])
    for _ in range(LAWS):
        relaxed, ratio, rate = np.exp(rng.uniform(*ranges.T)).tolist()
        times = {"relaxation_time": 1 / (2 * np.pi * rate), "order": rng.uniform(0.4, 0.9)}
        laws.append(
            {"law": "fractional_zener", "relaxed_modulus": relaxed, "unrelaxed_modulus": ratio * relaxed, **times}
        )
    return laws


def frame_record(modulus: dict[str, Any] | None, seed: int) -> dict[str, Any]:
    """Return the diagnosis of a foam with another modulus of its frame than stated; as stated when left out."""
    layer = ELASTIC if modulus is None else with_modulus(modulus)
    with TemporaryDirectory() as folder:
        file = measured(Path(folder), {}, KINDS["two"], seed, ERROR, layer=layer, nominal=ELASTIC)
        return diagnose_tube(file).record


def frame_row(modulus: dict[str, Any], record: dict[str, Any]) -> tuple[str, bool, list[float]]:
    """Return a line of the table, whether the place is right, and the shares within the band."""
    places = record["places"]
    first = places[0]["place"] if places else "-"
    behind = sorted(place["behind"] for place in places)
    law = {key: np.array(value) for key, value in (record["law"] or {}).items() if isinstance(value, list)}
    is_right = record["verdict"] == "unknown" and first == "layer_modulus"
    shares = []
    if is_right:
        stack = Stack.model_validate(foam(0.03, with_modulus(modulus)))
        true = complex_modulus(stack.layers[0].young_modulus, 0.0, law["frequency_hz"])
        change = np.log(true / (ELASTIC["young_modulus"] * (1 + 1j * ELASTIC["loss_factor"])))
        parts = (("real", change.real), ("imag", change.imag))
        shares = [float(np.mean((law[f"{p}_low"] <= v) & (v <= law[f"{p}_high"]))) for p, v in parts]
    rate = 1 / (2 * np.pi * modulus["relaxation_time"])
    cells = [
        f"{1e-6 * modulus['relaxed_modulus']:.3g}",
        f"{modulus['unrelaxed_modulus'] / modulus['relaxed_modulus']:.2g}",
    ]
    cells += [f"{rate:.0f}", f"{modulus['order']:.2g}", record["verdict"], first]
    cells += [f"{behind[1]:.0f}" if is_right else "-"]
    cells += [f"{share:.0%}" for share in shares] or ["-", "-"]
    cells += [str((record["law"] or {}).get(key)) for key in ("passive", "causal")]
    return f"| {' | '.join(cells)} |", is_right, shares


def frames() -> list[str]:
    """Return the section on moduli of the frame."""
    rows = [frame_row(law, frame_record(law, seed)) for seed, law in enumerate(frame_laws())]
    alarms = sum(frame_record(None, LAWS + seed)["verdict"] != "no_gap" for seed in range(FRAMES))
    held = np.mean([shares for *_, shares in rows if shares], axis=0)
    right = sum(is_right for _, is_right, _ in rows)
    return [
        FRAME_TEXT,
        *(line for line, *_ in rows),
        "",
        f"- `layer_modulus` told as the place of an unknown effect: {right} of {LAWS}.",
        f"- In the band: {held[0]:.0%} of the frequencies by real part, {held[1]:.0%} by imaginary part.",
        f"- A frame as stated: {alarms} false alarms of {FRAMES}.",
    ]


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
    print("\n".join([*lines, "", *said, *frames()]))  # noqa: T201


if __name__ == "__main__":
    main()
