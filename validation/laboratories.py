"""Simulated laboratories: campaigns whose material, rig and errors are drawn from what is stated of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri
from scipy.stats import qmc

from multilayer.experiments.two_plate.plane_waves import PlaneWaveRig
from multilayer.measurements.description import Campaign
from multilayer.media.laws import FractionalZener
from multilayer.signals.bursts import hann_burst
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import frequencies, to_signal, to_spectrum

FS = 25600.0
CYCLES = 10
N_FFT = 1 << 16  # so long that no ring-down of the simulated signals wraps round
HEIGHTS = (0.0125, 0.025, 0.04)
PLATES = (0.001, 0.003)
SHAPES = tuple((height, plate) for height in HEIGHTS for plate in PLATES)
REPEATS = 3
NOISE = 0.004  # of each channel's rms
KNOWN = {
    "channel_gain": 0.003, "channel_delay": 1e-6, "remount_gain": 0.001,
    "thickness": 5e-5, "density": 0.01, "top_plate_mass": 0.002,
}  # fmt: skip
SMOOTH = 0.3  # correlation length of the model's error in ln f

Recordings = dict[tuple[str, float], Recording]


@dataclass(frozen=True)
class Simulated:
    """A campaign, its signals, and what it was made with."""

    campaign: Campaign
    recordings: Recordings
    law: FractionalZener
    model_error: float


def description(rng: np.random.Generator) -> dict:
    """Return a campaign of three mountings and four bursts each."""
    bursts = [{"frequency": float(f), "file": f"{f:g}.npz"} for f in np.geomspace(150, 1400, 4).round()]
    chosen = [SHAPES[i] for i in sorted(rng.choice(len(SHAPES), 3, replace=False))]
    return {
        "version": 1, "rig": "shaker-two-plate", "sampling_rate": FS, "uncertainty": KNOWN,
        "specimen": {"density": 90.0, "poisson_ratio": 0.0},
        "top_plate": {"density": 7850, "young_modulus": 2.1e11, "poisson_ratio": 0.3},
        "base_plate": {"density": 2700, "young_modulus": 7e10, "poisson_ratio": 0.33, "thickness": 0.01},
        "burst": {"cycles": CYCLES, "window": "hann", "level_rms": 5.0},
        "configurations": [
            {"name": f"{1e3 * h:g}-{1e3 * t:g}", "specimen_thickness": h, "top_plate_thickness": t,
             "specimen_radius": 0.0225, "bursts": bursts}
            for h, t in chosen
        ],
    }  # fmt: skip


def draw_law(rng: np.random.Generator) -> FractionalZener:
    """Return a foam that relaxes somewhere near the bursts."""
    relaxed = 2e5 * np.exp(0.6 * rng.standard_normal())
    return FractionalZener(
        relaxed_modulus=relaxed,
        unrelaxed_modulus=relaxed * np.exp(rng.uniform(np.log(2), np.log(10))),
        relaxation_time=1 / (2 * np.pi * np.exp(rng.uniform(np.log(50), np.log(2000)))),
        order=rng.uniform(0.35, 0.8),
    )


def smooth_error(f: np.ndarray, size: float, rng: np.random.Generator) -> np.ndarray:
    """Return an error of ln(T), real and imaginary part independent, each normal and smooth in ln f."""
    if not size:
        return np.zeros(len(f), dtype=complex)
    at = np.arange(np.log(10.0), np.log(FS), 0.1)
    covariance = np.exp(-0.5 * (np.subtract.outer(at, at) / SMOOTH) ** 2) + 1e-9 * np.eye(at.size)
    parts = size * np.linalg.cholesky(covariance) @ rng.standard_normal((at.size, 2))
    real, imaginary = (np.interp(np.log(f), at, part) for part in parts.T)
    return real + 1j * imaginary


def laboratories(campaigns: int) -> np.ndarray:
    """Return standard normal deviates of what is uncertain of each rig, shape (campaigns, 14).

    A Latin hypercube: with as many laboratories on either side of every quantile the shares scatter less than those of
    independent draws would. E1 and E2 hang on few numbers per campaign.
    """
    cube = qmc.LatinHypercube(8 + len(SHAPES), rng=np.random.default_rng(0))
    return np.asarray(ndtri(cube.random(campaigns)))


def simulate(seed: int, model_error: float, laboratory: np.ndarray) -> Simulated:
    """Return a campaign with all its errors drawn."""
    rng = np.random.default_rng([seed, round(1e6 * model_error)])
    campaign, law = Campaign.model_validate(description(rng)), draw_law(rng)
    known = campaign.uncertainty
    gain, delay, density = laboratory[:3] * (known.channel_gain, known.channel_delay, known.density)
    masses = dict(zip(PLATES, known.top_plate_mass * laboratory[3:5], strict=True))
    heights = dict(zip(HEIGHTS, known.thickness * laboratory[5:8], strict=True))
    remounts = dict(zip(SHAPES, known.remount_gain * laboratory[8:], strict=True))
    f = frequencies(N_FFT, FS)[1:]
    recordings: Recordings = {}
    for c in campaign.configurations:
        rig = PlaneWaveRig.of(campaign, c).shifted("thickness", heights[c.specimen_thickness], relative=False)
        rig = rig.shifted("density", density, relative=True)
        rig = rig.shifted("top_plate_mass", masses[c.top_plate_thickness], relative=True)
        channels = (1 + gain + remounts[c.specimen_thickness, c.top_plate_thickness]) * np.exp(-2j * np.pi * f * delay)
        ratio = rig.transmissibility(f, law(f)) * channels * np.exp(smooth_error(f, model_error, rng))
        for burst in c.bursts:
            recordings[c.name, burst.frequency] = _recording(burst.frequency, np.concatenate([[1.0], ratio]), rng)
    return Simulated(campaign, recordings, law, model_error)


def _recording(frequency: float, ratio: np.ndarray, rng: np.random.Generator) -> Recording:
    n = int((1.6 * CYCLES / frequency + 0.06) * FS)  # about as long as those of the shared campaigns
    base = hann_burst(frequency, CYCLES, FS, 5.0, n_samples=n)
    top = to_signal(ratio * to_spectrum(base, N_FFT), N_FFT, n)
    base, top = (s + NOISE * s.std() * rng.standard_normal((REPEATS, n)) for s in (base, top))
    return Recording(base, top, FS)
