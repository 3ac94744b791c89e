"""How accurate the kernel is, case by case: ``docs/validation/kernel.md``.

Run it as ``python -m validation.kernel > docs/validation/kernel.md``; it takes about a minute. The exact values
come from an independent solution in 80 digits (``tests/analytic/mp_reference.py``).
"""

from __future__ import annotations

import numpy as np

from multilayer.response import plane_wave
from multilayer.stack import Stack
from tests.analytic import mp_reference
from tests.analytic.materials import stack
from tests.analytic.test_against_mp import MIXED, SINGLE

FREQUENCIES = (1.0, 300.0, 3e3, 2e4, 5e4)
_NOTHING = 1e-290  # below it a transmission is no number any more
ANGLES = (0.0, 45.0, 80.0, 89.9)
HEADING = """# The kernel against 80 digits

Made by `python -m validation.kernel`: frequencies 1, 300, 3000, 20 000 and 50 000 Hz, angles 0, 45, 80 and 89.9
degrees, air on both sides. Largest errors of the reflection coefficient R (of a wall: 1) and of the transmission
coefficient T (relative).

| stack | R, absolute | T, relative | smallest abs(T) |
|---|---|---|---|"""


def worst(panel: Stack) -> tuple[float, float, float]:
    """Return the largest errors of one stack, and its smallest transmission."""
    found = plane_wave(panel, FREQUENCIES, ANGLES)
    off_r, off_t, smallest = 0.0, 0.0, np.inf
    for i, j in np.ndindex(found.reflection.shape):
        reflection, transmission = mp_reference.plane_wave(panel, FREQUENCIES[i], ANGLES[j])
        off_r = max(off_r, float(abs(found.reflection[i, j] - reflection)))
        if abs(transmission) > _NOTHING:
            off_t = max(off_t, float(abs(found.transmission[i, j] / transmission - 1)))
            smallest = min(smallest, float(abs(transmission)))
    return off_r, off_t, smallest


def main() -> None:
    """Compare and print the page."""
    panels = {**{name: stack(case) for name, case in SINGLE.items()}, **MIXED}
    print(HEADING)  # noqa: T201
    for name, panel in panels.items():
        print(f"| {name} | " + " | ".join(f"{value:.0e}" for value in worst(panel)) + " |")  # noqa: T201
    print(  # noqa: T201
        "\nMost of what is left comes from 89.9 degrees, where the cosine of the angle has lost digits; beyond, it\n"
        "loses more. Frames that carry sound faster than 3 km/s lose some in layers of metres at a few hertz."
    )


if __name__ == "__main__":
    main()
