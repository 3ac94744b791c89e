"""Diagnose the same data on other kernels, threads, processes, and with rounding's noise: all must say the same.

Run it as ``make -s machines > docs/validation/machines.md``; about an hour on two cores. ``--short`` takes a few cases
under a few variants, some minutes. Exit status 1 where a verdict, a group, a first experiment, or the size of a named
effect differs from that of the first variant.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from argparse import ArgumentParser
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

ROOT = Path(__file__).parents[1]
CAMPAIGNS = ROOT / ".." / "shared" / "campaigns"
NOISE = 1e-12  # relative, of the data: some times what numbers of 64 bits are rounded to
SAME = 1e-3  # of a size, or of the width of its interval where that is larger
PLANTS = {"Ajuga 8 cm": 0.08, "Grass 6 cm": 0.06}
DRAWS = ((149, 7), (14, 7), (54, 7))  # number and seed: buried, faces bonded in part, stiff under load


@dataclass(frozen=True)
class Variant:
    """A machine, or what looks like another one."""

    name: str
    environment: Mapping[str, str] = field(default_factory=dict)
    jobs: int = 1
    noise: int = 0


VARIANTS = (
    Variant("as it is"),
    Variant("Haswell", {"OPENBLAS_CORETYPE": "Haswell"}),
    Variant("Zen", {"OPENBLAS_CORETYPE": "Zen"}),
    Variant("Nehalem, no AVX2", {"OPENBLAS_CORETYPE": "Nehalem", "NPY_DISABLE_CPU_FEATURES": "X86_V3"}),
    Variant("Sandybridge", {"OPENBLAS_CORETYPE": "Sandybridge"}),
    Variant("2 threads", {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2"}),
    Variant("--jobs 2", jobs=2),
    Variant("noise 1e-12", noise=1),
)
HEADING = f"""# The same answer on every machine

Made by `make -s machines`: each case is diagnosed as it is, and again with other kernels of OpenBLAS, without AVX2 in
NumPy, with two threads, in two processes, and with the data multiplied by 1 + {NOISE:g} noise. *same*: verdict, group
and first experiment are, and the sizes of the effects named within {SAME:g} of themselves or of the width of their 90 %
interval. The last column is the time of the first run, s.

What is compared is whether machines agree. What a case *says* is by the rules of the day on which the page was
made; verdicts by today's rules stand on the pages of [places](places.md) and of
[measured tubes](diagnosis_tubes.md).
"""
SHORT = ("as it is", "Nehalem, no AVX2", "noise 1e-12")
SHORT_CASES = ("foam_b", "draw 149 of 7", "tube rear_air_gap")


def main() -> None:
    """Print the table, or as a worker the answers."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--short", action="store_true", help="a few cases, a few variants")
    parser.add_argument("--answer", action="store_true", help="print the answer of this process to one case as JSON")
    parser.add_argument("--together", type=int, default=os.cpu_count(), help="processes at once; all processors")
    parser.add_argument("--variants", nargs="*", help="the first and those named, in place of all")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--noise", type=int, default=0, help="seed; 0 for none")
    parser.add_argument("cases", nargs="*", help="all when left out")
    given = parser.parse_args()
    chosen = given.cases or [name for name in cases() if not given.short or name in SHORT_CASES]
    if given.answer:
        tell(json.dumps(answer(given.cases[0], given.jobs, given.noise)))
        return
    names = SHORT if given.short else [VARIANTS[0].name, *(given.variants or (v.name for v in VARIANTS))]
    sys.exit(compare(chosen, [v for v in VARIANTS if v.name in names], given.together))


def compare(chosen: list[str], variants: list[Variant], together: int) -> int:
    """Print what each variant says of each case, as it comes; return 1 where they differ."""
    tell(HEADING)
    tell(f"| case | says | {' | '.join(v.name for v in variants[1:])} | s |")
    tell(f"|{'---|' * (len(variants) + 2)}")
    differs = 0
    with ThreadPoolExecutor(together) as pool:
        told = {case: [pool.submit(answer_of, case, variant) for variant in variants] for case in chosen}
        for case, runs in told.items():
            try:
                first, *others = [run.result() for run in runs]
            except subprocess.CalledProcessError as failed:
                pool.shutdown(cancel_futures=True)
                sys.exit(f"{case}: {failed.stderr}")
            seen = [differences(first, other) for other in others]
            differs += sum(bool(one) for one in seen)
            tell(
                f"| {case} | {in_short(first)} | {' | '.join(one or 'same' for one in seen)} | {first['seconds']:.0f} |"
            )
    tell(f"\n{len(chosen)} cases, {len(variants)} variants: {differs or 'no'} differences")
    return int(differs > 0)


def answer_of(case: str, variant: Variant) -> dict[str, Any]:
    """Return what a variant says of a case, in a process started as that variant."""
    command = [
        sys.executable, "-m", "validation.machines", "--answer",
        "--jobs", str(variant.jobs), "--noise", str(variant.noise), case,
    ]  # fmt: skip
    environment = {"OMP_NUM_THREADS": "1", **os.environ, **variant.environment}
    found = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, check=True)
    answer: dict[str, Any] = json.loads(found.stdout)
    return answer


def in_short(answer: Mapping[str, Any]) -> str:
    """Return verdict and group, of which an unknown cause is the verdict itself."""
    group = " or ".join("+".join(names) for names in answer["group"])
    return f"effect: {group}" if answer["verdict"] == "effect" else group or answer["verdict"]


def differences(first: Mapping[str, Any], other: Mapping[str, Any]) -> str:
    """Return what two answers differ in; empty where they agree."""
    for key in ("verdict", "group", "experiment"):
        if first[key] != other[key]:
            return f"{key}: {other[key]}"
    worst = ("", 0.0)
    for name, (value, low, high) in first["sizes"].items():
        off = abs(other["sizes"][name][0] - value) / max(abs(value), abs(high - low))
        worst = max(worst, (name, off), key=lambda one: one[1])
    return f"{worst[0]} by {worst[1]:.1e}" if worst[1] > SAME else ""


def cases() -> dict[str, Callable[[Any, int], dict[str, Any]]]:
    """Return every case: a function of an executor and of a seed of noise that gives ``diagnosis.json``."""
    found: dict[str, Callable[[Any, int], dict[str, Any]]] = {"foam_b": of_campaign(ROOT / "examples" / "foam_b")}
    for file in sorted(CAMPAIGNS.rglob("campaign.yaml")):
        found[file.parent.relative_to(CAMPAIGNS).as_posix()] = of_campaign(file.parent)
    found |= {f"draw {number} of {seed}": of_draw(number, seed) for number, seed in DRAWS}
    from tests.diagnosis.tubes import CASES

    found |= {f"tube {name}": of_tube({name: values}) for name, values in CASES.items()}
    if CAMPAIGNS.is_dir():
        found |= {
            f"{name} + cavity {cm} cm": of_plant(name, thickness, cm)
            for name, thickness in PLANTS.items()
            for cm in range(1, 6)
        }
    return found


def of_campaign(folder: Path) -> Callable[[Any, int], dict[str, Any]]:
    """Return a case of a campaign's folder."""

    def run(executor: Any, noise: int) -> dict[str, Any]:
        from multilayer.fits.sources import read_fit

        job = read_fit(folder)
        return diagnosed(job.campaign, job.recordings, executor, noise)

    return run


def of_draw(number: int, seed: int) -> Callable[[Any, int], dict[str, Any]]:
    """Return a case of a campaign as the blind check draws it."""

    def run(executor: Any, noise: int) -> dict[str, Any]:
        from multilayer.rig.synthesis import make_campaign
        from validation.blind_check.draw import draw

        sealed = draw(number, seed)
        made = make_campaign(sealed.settings, sealed.seed)
        return diagnosed(made.campaign, made.recordings, executor, noise)

    return run


def diagnosed(campaign: Any, recordings: Mapping[Any, Any], executor: Any, noise: int) -> dict[str, Any]:
    """Return the record of a campaign, its signals with noise."""
    from multilayer.diagnosis.diagnose import chosen_effects, diagnose_campaign

    noisy = {
        key: replace(one, base=rounded(one.base, noise), top=rounded(one.top, noise + 1 if noise else 0))
        for key, one in recordings.items()
    }
    # those of plugins differ from machine to machine
    effects = {name: effect for name, effect in chosen_effects().items() if is_built_in(effect)}
    return diagnose_campaign(campaign, noisy, effects, executor=executor).record


def of_tube(acting: Mapping[str, Mapping[str, float]]) -> Callable[[Any, int], dict[str, Any]]:
    """Return a case of a simulated tube with an effect."""

    def run(executor: Any, noise: int) -> dict[str, Any]:
        from tests.diagnosis.tubes import measured

        with TemporaryDirectory() as folder:
            return tube(measured(Path(folder), acting), executor, noise)

    return run


def of_plant(name: str, thickness: float, cm: int) -> Callable[[Any, int], dict[str, Any]]:
    """Return a case of a measured plant before a cavity."""

    def run(executor: Any, noise: int) -> dict[str, Any]:
        from validation.tube_gaps import WIDE, delft, sure_from

        sure = sure_from("plants", {name: thickness}, WIDE)
        file = delft("plants", {f"{name} + cavity {cm} cm": thickness}, WIDE, sure.error)
        return tube(file.with_reference(sure.file), executor, noise)

    return run


def tube(file: Any, executor: Any, noise: int) -> dict[str, Any]:
    """Return the record of tube measurements, their values with noise."""
    from multilayer.diagnosis.tube.diagnose import diagnose_tube

    data = [replace(values, measured=rounded(values.measured, noise)) for values in file.observations]
    file._observations = tuple(data)
    effects = {name: effect for name, effect in file.chosen().items() if is_built_in(effect)}
    return diagnose_tube(file, effects=effects, executor=executor).record


def is_built_in(effect: Any) -> bool:
    """Tell whether an effect is one of the package."""
    return type(effect).__module__.startswith("multilayer.")


def rounded(values: Any, seed: int) -> Any:
    """Return values as another machine might have rounded them."""
    import numpy as np

    return values * (1 + NOISE * np.random.default_rng(seed).standard_normal(values.shape)) if seed else values


def answer(case: str, jobs: int, noise: int) -> dict[str, Any]:
    """Return of a case what must not depend on the machine, and the time it took."""
    from multilayer.executors import local_pool

    start = perf_counter()
    with local_pool(jobs) as pool:
        record = cases()[case](pool, noise)
    group = record["group"]
    named = [cause for cause in record["causes"] if cause["effects"] in group]
    plans = record["next_experiment"]
    return {
        "verdict": record["verdict"],
        "group": group,
        "experiment": [plans[0]["change"], plans[0]["separates"]] if plans else [],
        "sizes": {
            f"{'+'.join(cause['effects'])}: {key}": [p["value"], p["low"], p["high"]]
            for cause in named
            for key, p in cause["parameters"].items()
        },
        "seconds": perf_counter() - start,
    }


def tell(text: str) -> None:
    """Write a line."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
