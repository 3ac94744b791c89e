"""Where the gap of measured tubes lies when its true effect is deleted from the library: plants before a cavity.

Run it as ``python -m validation.tube_places > docs/validation/tube_places.md``; some minutes.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.file import DiagnosisFile
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.nominal import nominal_minimum
from multilayer.diagnosis.place_fits import PlaceFit, fit_places
from multilayer.diagnosis.simple_forms import with_simple_laws
from multilayer.diagnosis.tube.diagnose import diagnose_tube
from multilayer.inference.least_squares import minimise
from multilayer.inference.problem import GaussianPrior
from multilayer.number_text import percent, significant
from validation.tube_gaps import WIDE, Sure, delft, sure_from

PLANTS = (("Ajuga 8 cm", 0.08), ("Grass 6 cm", 0.06))
WITHIN = 0.2
HEADING = """# Where the gap of measured tubes lies

Made by `python -m validation.tube_places`. Plants in a tube before a cavity of 1 to 5 cm (TU Delft, 200 to 1600 Hz,
one measurement each), the plant known from its series on the wall, as on the page of measured tubes; the library has
no `rear_air_gap`. Tied: places within 6 nats, which such data cannot tell apart: air before a wall is a spring, and
so is a spring in front of the sample, or a softer air in its pores. Drawn: the impedance of the backing, from the law
at `behind` (be that first or not), the simple one where that is as probable as the free one, beside -i Z0 cot(k d)
with the stated depth d: share of the law's frequencies (even in ln f) at which it is off by at most 20 %, median, and
depth by the slope of its phase. A cotangent passes through 0, where any error of depth is large beside it. The best
rear air gaps of these series are 1 to 5 mm off the stated depths, too (measured tubes).

| series | verdict | first place | tied with it | `behind`: nats | within 20 % | off, median | depth / mm | stated |
|---|---|---|---|---|---|---|---|---|
"""


def backing(frequency: RealArray, law: ComplexArray, speed: float, depth: float) -> tuple[RealArray, RealArray]:
    """Return how far the drawn impedance is off that of air of a depth, relative, and the depth by its phase, m."""
    wavenumber = 2 * np.pi * frequency / speed
    reflected = np.exp(law)
    drawn, true = (1 + reflected) / (1 - reflected), -1j / np.tan(wavenumber * depth)
    return np.abs(drawn / true - 1), -law.imag / (2 * wavenumber)


@dataclass(frozen=True)
class Case:
    """A series: its row, whether `behind` is first, or tied with the first, and how far its impedance is off."""

    row: str
    is_first: bool
    is_tied: bool
    off: RealArray


def law_behind(file: DiagnosisFile, sure: Sure) -> PlaceFit:
    """Return the place behind the sample with the law drawn there."""
    hypothesis = replace(file.hypothesis, earlier=GaussianPrior.of(nominal_minimum(sure.file)))
    nominal = Fitted(hypothesis, minimise(hypothesis, hypothesis.start))
    return with_simple_laws(nominal, fit_places(nominal, names=["behind"]))["behind"]


def cases(name: str, thickness: float) -> list[Case]:
    """Return the series of a plant."""
    sure, found = sure_from("plants", {name: thickness}, WIDE), []
    for cm in range(1, 6):
        series = f"{name} + cavity {cm} cm"
        file = delft("plants", {series: thickness}, WIDE, sure.error).with_reference(sure.file)
        record = diagnose_tube(file, series, file.chosen(["rear_air_gap"])).record
        places = record["places"]
        behind = next(place for place in places if place["place"] == "behind")
        cells = [
            series,
            " + ".join(record["group"][0]) if record["verdict"] == "effect" else record["verdict"],
            places[0]["place"],
            ", ".join(place["place"] for place in places[1:] if place["tied"]) or "–",
            significant(behind["behind"]),
        ]
        drawn = law_behind(file, sure)
        off, depth = backing(drawn.grid, drawn.law(), file.hypothesis.settings[0].gas.sound_speed, cm / 100)
        cells += [percent(float(np.mean(off <= WITHIN))), percent(float(np.median(off)))]
        cells += [f"{1e3 * np.median(depth):.0f}", str(10 * cm)]
        found.append(Case(f"| {' | '.join(cells)} |\n", places[0] is behind, behind["tied"], off))
    return found


def conclusions(found: Sequence[Case]) -> str:
    """Return what is met of the targets: `behind` in all series, its impedance off by 20 % at most."""
    count, off = len(found), [float(np.median(case.off)) for case in found]
    met = sum(bool(np.all(case.off <= WITHIN)) for case in found)
    every = percent(float(np.mean([case.off <= WITHIN for case in found])))
    return f"""
- `behind` first: {sum(case.is_first for case in found)} of {count}, aimed at {count}.
- `behind` first, or tied with the first: {sum(case.is_first or case.is_tied for case in found)} of {count}.
- Impedance within {percent(WITHIN)} at all frequencies: {met} of {count}, aimed at {count}.
- In the median over frequency: {sum(median <= WITHIN for median in off)} of {count}; at {every} of all frequencies.
"""


def main() -> None:
    """Write the page to standard output."""
    sys.stdout.write(HEADING)
    found = []
    for name, thickness in PLANTS:
        series = cases(name, thickness)
        sys.stdout.writelines(case.row for case in series)
        sys.stdout.flush()
        found += series
    sys.stdout.write(conclusions(found))


if __name__ == "__main__":
    main()
