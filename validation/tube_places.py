"""Where the gap of measured tubes lies when its true effect is deleted from the library: plants before a cavity.

Run it as ``python -m validation.tube_places > docs/validation/tube_places.md``; some minutes.
"""

from __future__ import annotations

import sys

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.tube.diagnose import diagnose_tube
from multilayer.number_text import percent, significant
from validation.tube_gaps import WIDE, delft, sure_from

PLANTS = (("Ajuga 8 cm", 0.08), ("Grass 6 cm", 0.06))
WITHIN = 0.2
HEADING = """# Where the gap of measured tubes lies

Made by `python -m validation.tube_places`. Plants in a tube before a cavity of 1 to 5 cm (TU Delft, 200 to 1600 Hz, one
measurement each), the plant known from its series on the wall, as on the page of measured tubes; the library has no
`rear_air_gap`. Tied: places within 6 nats, which such data cannot tell apart: of one measurement a backing and a
reading whose phase lags are nearly the same. Drawn: the impedance of the backing, from the law at `behind`, beside
-i Z0 cot(k d) with the stated depth d: share of the law's frequencies (even in ln f) at which it is off by at most
20 %, median, and depth by the slope of its phase. A cotangent passes through 0, where any error of depth is large
beside it. The best rear air gaps of these series are 1 to 5 mm off the stated depths, too (measured tubes).

| series | verdict | first place | tied with it | `behind`: nats | within 20 % | off, median | depth / mm | stated |
|---|---|---|---|---|---|---|---|---|
"""


def backing(frequency: RealArray, law: RealArray, speed: float, depth: float) -> tuple[RealArray, RealArray]:
    """Return how far the drawn impedance is off that of air of a depth, relative, and the depth by its phase, m."""
    wavenumber = 2 * np.pi * frequency / speed
    reflected = np.exp(law)
    drawn, true = (1 + reflected) / (1 - reflected), -1j / np.tan(wavenumber * depth)
    return np.abs(drawn / true - 1), -law.imag / (2 * wavenumber)


def rows(name: str, thickness: float) -> list[str]:
    """Return the rows of a plant."""
    sure, written = sure_from("plants", {name: thickness}, WIDE), []
    for cm in range(1, 6):
        series = f"{name} + cavity {cm} cm"
        file = delft("plants", {series: thickness}, WIDE, sure.error).with_reference(sure.file)
        record = diagnose_tube(file, series, file.chosen(["rear_air_gap"])).record
        places, law = record["places"], record["law"]
        behind = next(place for place in places if place["place"] == "behind")
        cells = [
            series,
            " + ".join(record["group"][0]) if record["verdict"] == "effect" else record["verdict"],
            places[0]["place"],
            ", ".join(place["place"] for place in places[1:] if place["tied"]) or "–",
            significant(behind["behind"]),
        ]
        if law and law["place"] == "behind":
            f, drawn = np.array(law["frequency_hz"]), np.array(law["real"]) + 1j * np.array(law["imag"])
            off, depth = backing(f, drawn, file.hypothesis.settings[0].gas.sound_speed, cm / 100)
            cells += [percent(float(np.mean(off <= WITHIN))), percent(float(np.median(off)))]
            cells += [f"{1e3 * np.median(depth):.0f}"]
        else:
            cells += ["–", "–", "–"]
        written.append(f"| {' | '.join([*cells, str(10 * cm)])} |\n")
    return written


def main() -> None:
    """Write the page to standard output."""
    sys.stdout.write(HEADING)
    for name, thickness in PLANTS:
        sys.stdout.writelines(rows(name, thickness))
        sys.stdout.flush()


if __name__ == "__main__":
    main()
