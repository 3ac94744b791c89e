"""The double wall of Dazel, Groby, Brouard & Potel, J. Appl. Phys. 113, 083506 (2013), table V.

``python -m examples.reproducing.dazel_2013 [FOLDER]``
"""

import numpy as np

from examples.reproducing.drawing import axes, write
from multilayer import Stack, plane_wave

ANGLE = 85.0
# dB at 85 degrees, at the frequencies of the published table, Hz
PUBLISHED = {
    20: 10.6, 50: 15.3, 100: 28.8, 200: 21.6, 300: 65.6, 500: 82.8, 1000: 103.0, 1200: 102.0, 2000: 136.7,
    3000: 176.2, 5000: 206.8, 10000: 299.9, 15000: 391.6, 20000: 486.0,
}  # fmt: skip


def wall(*layers: tuple[str, float]) -> Stack:
    """Return a wall of materials of table V, each with its thickness in m, in air."""
    slabs = [{"material": f"Dazel2013/TV/{name}", "thickness": thickness} for name, thickness in layers]
    return Stack.model_validate({"layers": slabs, "termination": "ambient"})


DOUBLE_WALL = wall(("F", 0.1), ("G", 0.05), ("H", 0.02))


def transmission_loss(frequency) -> np.ndarray:
    """Return the transmission loss of the double wall at 85 degrees, dB."""
    return plane_wave(DOUBLE_WALL, frequency, ANGLE).transmission_loss


def double_wall():
    """Draw concrete, foam and wood at 85 degrees, and the published values."""
    figure, grid = axes(1, 2)
    frequency = np.geomspace(20, 20e3, 800)
    published, values = np.array(list(PUBLISHED)), np.array(list(PUBLISHED.values()))
    left, right = grid[0]
    left.semilogx(frequency, transmission_loss(frequency), label="multilayer")
    left.semilogx(published, values, "o", markerfacecolor="none", label="published")
    left.set(xlabel="frequency / Hz", ylabel="transmission loss at 85° / dB")
    left.legend()
    right.semilogx(published, transmission_loss(published) - values, "o-")
    right.set(xlabel="frequency / Hz", ylabel="multilayer - published / dB", ylim=(-3, 3))
    return figure


if __name__ == "__main__":
    write({"dazel_double_wall": double_wall})
