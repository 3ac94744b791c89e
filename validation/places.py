"""Where the effects of the shared campaigns act: with the true effect in the library, and deleted from it.

Run it as ``python -m validation.places [NAME ...] > docs/validation/places.md``; all campaigns take half an hour.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.diagnose import chosen_effects, diagnose_campaign
from multilayer.diagnosis.effects.base import EFFECTS
from multilayer.errors import InputError
from multilayer.executors import local_pool
from multilayer.fits.sources import read_fit
from multilayer.number_text import percent, significant

CAMPAIGNS = Path(__file__).parents[1] / ".." / "shared" / "campaigns"
FOREIGN = {"attached_resonator": "top_plate"}  # places of effects that no library holds
HEADING = """# Where effects act

Made by `python -m validation.places`. Campaigns of an independent finite-element rig, seven configurations and one
effect each; each is diagnosed with all effects of the library, and with the true one deleted from it. Shrinkage is that
of the gap on configurations left out, with the law drawn at the place. *In the band*: of the drawn law where the truth
file gives the true one, the share of real and imaginary parts at all frequencies that the 90 % band holds (of a path
beside the sample the real part alone: its truth file says no loss); *off by*: the most by which the law's middle
differs from the true law, as a share of the largest value of that.

| campaign | library | verdict | place | true place | nats to the next | law | in the band | off by | shrinkage |
|---|---|---|---|---|---|---|---|---|---|
"""
NOTES = """
Seven laws can be compared: the bands of all hold the true one at 98 % of the frequencies and more. That of the attached
resonator, a gap ten thousand times above the noise, is right to 1 %, its natural frequency to 0.015 %, as other finite
elements have it. An open rim, deleted from the library, is no compliance that is the same for every height: the law at
the faces stands beside open rims of finite elements, whose sizes are fitted to all data.
"""
Law = Callable[[dict[str, Any], RealArray], ComplexArray]
_SKIN = 2e-3  # m, at either face


def _skin(truth: dict[str, Any], frequency: RealArray) -> ComplexArray:
    """Return what a stiffer layer at a face changes of its compliance, m/Pa."""
    material, stiffer = truth["material"], 1 + truth["parameters"]["stiffening"]
    turn = (2j * np.pi * frequency * material["tau"]) ** material["alpha"]
    modulus = material["E0"] * (1 + material["ratio"] * turn) / (1 + turn)
    return np.asarray(_SKIN * (1 / stiffer - 1) / modulus)


def _resonator(truth: dict[str, Any], frequency: RealArray) -> ComplexArray:
    """Return the dynamic mass of a mass on a spring, kg."""
    size = truth["parameters"]
    return np.asarray(size["mass"] / (1 - (frequency / size["f"]) ** 2 / (1 + 1j * size["loss"])))


def _same(name: str) -> Law:
    return lambda truth, frequency: np.full(frequency.shape, truth["parameters"][name], dtype=complex)


# by the effect, the law at its place, NaN where the truth file does not tell it (the spring's loss); of the others the
# truth files, or the place, have no law of frequency alone
LAWS: dict[str, Law] = {
    "attached_resonator": _resonator,
    "channel_delay": lambda truth, frequency: -2j * np.pi * frequency * truth["parameters"]["delay"],
    "crosstalk": _same("ratio"),
    "flanking": lambda truth, frequency: np.full(frequency.shape, complex(truth["parameters"]["stiffness"], np.nan)),
    "high_pass": lambda truth, frequency: -np.log(1 + truth["parameters"]["corner"] / (1j * frequency)),
    "sensor_mass": _same("mass"),
    "skin": _skin,
}


def truths(names: Sequence[str] = ()) -> list[tuple[Path, dict[str, Any]]]:
    """Return campaigns of several configurations with what was done to them; those of some names."""
    files = sorted([*CAMPAIGNS.glob("*.truth.json"), *CAMPAIGNS.glob("round-1/*.truth.json")])
    if not files:
        raise InputError(f"{CAMPAIGNS}: there are no campaigns with truth files")
    pairs = [(file.with_name(file.name.removesuffix(".truth.json")), json.loads(file.read_text())) for file in files]
    return [
        (folder, truth)
        for folder, truth in pairs
        if not folder.name.startswith("paper") and (not names or _label(folder) in names)
    ]


def _label(folder: Path) -> str:
    return folder.name if folder.parent.name == "campaigns" else f"{folder.parent.name}/{folder.name}"


def place_of(effect: str) -> str:
    """Return the place where an effect acts; empty without one."""
    if effect in FOREIGN or effect == "none":
        return FOREIGN.get(effect, "")
    return str(getattr(EFFECTS[effect], "place", ""))


def row(folder: Path, truth: dict[str, Any], without: Sequence[str], executor: Executor | None) -> str:
    """Return a row of the report."""
    job = read_fit(folder)
    effects = chosen_effects(None, without)
    record = diagnose_campaign(
        job.campaign, job.recordings, effects, calibration=job.calibration, executor=executor
    ).record
    places = record["places"]
    shares = [place["shrinkage"] for place in places if place["shrinkage"] is not None]
    cells = [
        _label(folder),
        f"without {without[0]}" if without else "whole",
        " + ".join(record["group"][0]) if record["verdict"] == "effect" else record["verdict"],
        places[0]["place"] if places else "–",
        place_of(truth["effect"] or "none") or "–",
        significant(min(place["behind"] for place in places[1:])) if len(places) > 1 else "–",
        record["law"]["form"]["text"] if record["law"] else "–",
        *beside_the_truth(truth, record),
        percent(shares[0]) if shares else "–",
    ]
    return f"| {' | '.join(cells)} |\n"


def beside_the_truth(truth: dict[str, Any], record: dict[str, Any]) -> tuple[str, str]:
    """Return the share of a drawn law's band that holds the true law, and how far off its middle is at most."""
    law, true_law = record["law"], LAWS.get(truth["effect"])
    is_comparable = law is not None and "open_rim" not in law and law["place"] == place_of(truth["effect"])
    if true_law is None or not is_comparable:
        return "–", "–"
    true = true_law(truth, np.array(law["frequency_hz"]))
    off, inside = [], []
    known = {name: part for name, part in (("real", true.real), ("imag", true.imag)) if np.all(np.isfinite(part))}
    for part, of_true in known.items():
        low, middle, high = (np.array(law[f"{part}{end}"]) for end in ("_low", "", "_high"))
        inside.append((low <= of_true) & (of_true <= high))
        off.append(np.abs(middle - of_true))
    return percent(float(np.mean(inside))), percent(float(np.max(off) / np.max(np.abs([*known.values()]))))


def main() -> None:
    """Write the report to standard output."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="campaigns, as round-1/effect-skin; all when left out")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    sys.stdout.write(HEADING)
    with local_pool(options.jobs, ["multilayer.diagnosis.diagnose"]) as executor:
        for folder, truth in truths(options.names):
            known = truth["effect"] in EFFECTS.names()
            for without in ([], [truth["effect"]]) if known else ([],):
                sys.stdout.write(row(folder, truth, without, executor))
                sys.stdout.flush()
    sys.stdout.write(NOTES)


if __name__ == "__main__":
    main()
