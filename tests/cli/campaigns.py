"""A small campaign whose answer is known in closed form, written to disk; and ways to spoil it.

The foam is a rod under a rigid mass, ``T = 1 / (cosh g + (M/m) g sinh g)``, with the law of constant loss factor
``E = E0 (i f / f0)^n``: the tangent of n pi/2 is the loss factor at every frequency.
"""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from multilayer.signals.bursts import hann_burst
from multilayer.signals.spectra import frequencies, to_signal, to_spectrum

RATE = 12800.0
BURSTS = (200, 400, 600)
NAME = "h25mm"
LOSS_FACTOR = 0.3
ORDER = 2 / np.pi * np.arctan(LOSS_FACTOR)
STORAGE_AT_500 = 2e5
POISSON, DENSITY, THICKNESS, TOP_MASS = 0.3, 90.0, 0.025, 7.85
FILE = "signals/{:04d}.npz"

DESCRIPTION = """\
version: 1
rig: shaker-two-plate
sampling_rate: 12800
specimen: {density: 90, poisson_ratio: 0.3}
top_plate: {density: 7850, young_modulus: 210 GPa, poisson_ratio: 0.3}
base_plate: {density: 2700, young_modulus: 70 GPa, poisson_ratio: 0.33, thickness: 10 mm}
uncertainty: {channel_gain: 0.003, channel_delay: 1 us, thickness: 50 um, density: 0.01, top_plate_mass: 0.002}
burst: {cycles: 10, window: hann, level_rms: 5}
configurations:
  - name: h25mm
    specimen_thickness: 25 mm
    top_plate_thickness: 1 mm
    specimen_radius: 22.5 mm
    bursts:
      - {frequency: 200, file: signals/0200.npz}
      - {frequency: 400, file: signals/0400.npz}
      - {frequency: 600, file: signals/0600.npz}
"""
CALIBRATION = """\
version: 1
rig: calibration
sampling_rate: 12800
burst: {cycles: 10, level_rms: 5}
bursts:
  - {frequency: 200, file: 0200.npz}
  - {frequency: 600, file: 0600.npz}
"""


def modulus(frequency):
    """Return E1 + i E2 of the foam, Pa."""
    return STORAGE_AT_500 * (1 + 1j * LOSS_FACTOR) * (np.asarray(frequency) / 500.0) ** ORDER


def transmissibility(frequency):
    """Return top over base; the sample is held at its rim, so that its stiffness is the P-wave modulus."""
    held = modulus(frequency) * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))
    g = 2j * np.pi * frequency * np.sqrt(DENSITY / held) * THICKNESS
    return 1 / (np.cosh(g) + TOP_MASS / (DENSITY * THICKNESS) * g * np.sinh(g))


def burst(frequency, *, response: Callable = transmissibility, noise=1e-3):
    """Return base and top, shape (2 repeats, samples), with noise relative to the rms of each channel."""
    n = int((0.002 + 10 / frequency + 0.1) * RATE)
    base = hann_burst(frequency, 10, RATE, 5.0, n_samples=n, start=0.002)
    n_fft = 8 * n
    f = frequencies(n_fft, RATE)
    ratio = np.ones(len(f), dtype=complex)
    ratio[1:] = response(f[1:])
    top = to_signal(ratio * to_spectrum(base, n_fft), n_fft, n)
    rng = np.random.default_rng(int(frequency))
    return [s + noise * s.std() * rng.standard_normal((2, n)) for s in (base, top)]


def write_campaign(folder: Path) -> Path:
    """Write the campaign into `folder`, and return it."""
    (folder / "signals").mkdir(parents=True)
    (folder / "campaign.yaml").write_text(DESCRIPTION)
    for frequency in BURSTS:
        base, top = burst(frequency)
        np.savez(folder / FILE.format(frequency), base=base, top=top)
    return folder


def write_calibration(folder: Path, gain: float, delay: float) -> Path:
    """Write bursts of two sensors at one spot, the top one with a gain and a delay (s), and return the folder."""
    folder.mkdir(parents=True)
    (folder / "campaign.yaml").write_text(CALIBRATION)
    for frequency in (200, 600):
        base, top = burst(frequency, response=lambda f: gain * np.exp(-2j * np.pi * f * delay))
        np.savez(folder / f"{frequency:04d}.npz", base=base, top=top)
    return folder


def line_of(file: Path, text: str) -> str:
    """Return ``line:column`` of the first place of `text` in a file, counted from 1."""
    before, found, _ = file.read_text().partition(text)
    assert found, f"{text!r} is not in {file}"
    return f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"


def edit(folder: Path, old: str, new: str, name: str = "campaign.yaml") -> None:
    """Replace the first `old` in a file of the campaign."""
    file = folder / name
    text = file.read_text()
    assert old in text, f"{old!r} is not in {file}"
    file.write_text(text.replace(old, new, 1))


def with_line(folder: Path, pattern: str, new: str) -> None:
    """Replace what a regular expression finds in ``campaign.yaml``, once."""
    file = folder / "campaign.yaml"
    text, count = re.subn(pattern, new, file.read_text(), count=1, flags=re.MULTILINE)
    assert count == 1, pattern
    file.write_text(text)


def change_signals(folder: Path, frequency: int, change: Callable) -> None:
    """Replace base and top of one burst by ``change(base, top)``."""
    file = folder / FILE.format(frequency)
    with np.load(file) as data:
        base, top = change(data["base"].copy(), data["top"].copy())
    np.savez(file, base=base, top=top)


def with_configurations(folder, names, frequency):
    """Write so many configurations in place of the one, by YAML texts of their names, each with its recording."""
    file, signals = folder / "campaign.yaml", folder / "signals"
    head, _, mounting = file.read_text().partition("  - name: h25mm\n")
    with np.load(signals / f"{frequency:04d}.npz") as data:
        base, top = data["base"], data["top"]
    parts = []
    for i, name in enumerate(names):
        heard = 1e-4 * np.random.default_rng(i).normal(size=top.shape)  # noise is never twice the same
        np.savez(signals / f"{i}.npz", base=base, top=top + heard)
        parts.append(f"  - name: {name}\n{mounting.replace(f'{frequency:04d}.npz', f'{i}.npz')}")
    file.write_text(head + "".join(parts))
