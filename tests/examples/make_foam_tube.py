"""Makes ``examples/foam_tube/tube.csv``: the reflection of ``truth.yaml`` with noise. Run as a module from the root."""

from pathlib import Path

import numpy as np

from multilayer.simulation import simulate

FOLDER = Path(__file__).parents[2] / "examples" / "foam_tube"
NOISE = 0.01  # of each part


def table() -> str:
    """Return the text of the file."""
    result = simulate(FOLDER / "truth.yaml")
    reflection = result.cases[0].quantities["reflection"]
    rng = np.random.default_rng(2024)
    noisy = reflection + NOISE * (rng.standard_normal(reflection.shape) + 1j * rng.standard_normal(reflection.shape))
    rows = [f"{f:.1f}, {r.real:.4f}, {r.imag:.4f}" for f, r in zip(result.frequency, noisy, strict=True)]
    return "\n".join(
        ["# made: truth.yaml and normal noise of 0.01", "frequency_hz, reflection_re, reflection_im", *rows, ""]
    )


if __name__ == "__main__":
    (FOLDER / "tube.csv").write_text(table())
