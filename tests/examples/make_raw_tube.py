"""Makes the tables of ``examples/raw_tube``: what two unlike microphones read. Run as a module from the root."""

from pathlib import Path

import numpy as np

from multilayer.response import plane_wave
from multilayer.signals.impedance_tube import transfer_function
from multilayer.stack import load_stack

FOLDER = Path(__file__).parents[2] / "examples" / "raw_tube"
STACK = FOLDER.parent / "foam_tube" / "truth.yaml"
FREQUENCY = np.arange(200.0, 5600.0, 50.0)
NEAR, FAR = 0.08, 0.115
NOISE = 1e-3
MISMATCH = 1.08 * np.exp(0.06j)  # of microphone 2 against microphone 1


def tables() -> dict[str, str]:
    """Return the text of the files by name."""
    stack = load_stack(STACK)
    wavenumber = 2 * np.pi * FREQUENCY / stack.ambient.gas.sound_speed
    h12 = transfer_function(plane_wave(stack, FREQUENCY).reflection, wavenumber, NEAR, FAR)
    rng = np.random.default_rng(2024)
    found = {}
    for name, read in (("h12.csv", MISMATCH * h12), ("exchanged.csv", MISMATCH / h12)):
        noise = rng.standard_normal(h12.shape) + 1j * rng.standard_normal(h12.shape)
        noisy = read * (1 + NOISE * noise)
        rows = [f"{f:.0f}, {h.real:.5f}, {h.imag:.5f}" for f, h in zip(FREQUENCY, noisy, strict=True)]
        head = "# made: ../foam_tube/truth.yaml, microphones that differ by 8 % and 0.06 rad, and normal noise of 0.1 %"
        found[name] = "\n".join([head, "frequency_hz, h12_re, h12_im", *rows, ""])
    return found


if __name__ == "__main__":
    for name, text in tables().items():
        (FOLDER / name).write_text(text)
