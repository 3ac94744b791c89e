"""Bursts made with the plane-wave rig itself: what the inverse must find again is known exactly."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from multilayer.experiments.two_plate.burst import BurstData, BurstProblem
from multilayer.experiments.two_plate.plane_waves import PlaneWaveRig
from multilayer.measurements.description import Campaign
from multilayer.signals.bursts import hann_burst
from multilayer.signals.spectra import Noise, frequencies, to_signal, to_spectrum

FS = 25600.0


def campaign_dict(thickness: float = 0.025, poisson_ratio: float = 0.0, frequencies_hz: tuple[float, ...] = (500.0,)):
    """Return a campaign description with one configuration."""
    return {
        "version": 1,
        "rig": "shaker-two-plate",
        "sampling_rate": FS,
        "specimen": {"density": 90.0, "poisson_ratio": poisson_ratio},
        "top_plate": {"density": 7850, "young_modulus": 2.1e11, "poisson_ratio": 0.3},
        "base_plate": {"density": 2700, "young_modulus": 7e10, "poisson_ratio": 0.33, "thickness": 0.01},
        "burst": {"cycles": 10, "window": "hann", "level_rms": 5.0},
        "configurations": [
            {
                "name": "one",
                "specimen_thickness": thickness,
                "top_plate_thickness": 0.001,
                "specimen_radius": 0.0225,
                "bursts": [{"frequency": f, "file": f"{f:g}.npz"} for f in frequencies_hz],
            }
        ],
    }


@dataclass(frozen=True)
class Truth:
    """What the synthetic signals are made with."""

    storage_modulus: float
    loss_factor: float
    frequency: float = 500.0
    noise: float = 0.0
    seed: int = 0
    record: float = 6.0  # length of the record in lengths of the burst
    dispersive: bool = True

    @property
    def x(self) -> np.ndarray:
        return np.array([np.log(self.storage_modulus), self.loss_factor])


def rig(termination: str = "free", **options) -> PlaneWaveRig:
    campaign = Campaign.model_validate(campaign_dict(**options))
    return PlaneWaveRig.of(campaign, campaign.configurations[0], termination)


def burst(truth: Truth, model: PlaneWaveRig) -> BurstData:
    """Return one burst, its response computed with a transform long enough for any ring-down."""
    n = int(truth.record * 10 / truth.frequency * FS)
    base = hann_burst(truth.frequency, 10, FS, 5.0, n_samples=n)
    n_fft = 16 * n
    f = frequencies(n_fft, FS)
    shape = BurstProblem(_data(truth, base, base), model, truth.dispersive)
    ratio = np.ones(len(f), dtype=complex)
    ratio[1:] = model.transmissibility(f[1:], shape.modulus(truth.x, f[1:]))
    top = to_signal(ratio * to_spectrum(base, n_fft), n_fft, n)
    rng = np.random.default_rng(truth.seed)
    noisy = [s + truth.noise * s.std() * rng.standard_normal(n) for s in (base, top)]
    data = _data(truth, *noisy)
    return replace(data, noise=Noise(truth.noise * base.std(), truth.noise * top.std()))


def _data(truth: Truth, base: np.ndarray, top: np.ndarray) -> BurstData:
    return BurstData("one", truth.frequency, FS, base, top, Noise(0.0, 0.0))


def problem(truth: Truth, **options) -> BurstProblem:
    """Return the inverse problem of a synthetic burst, with the model that made it."""
    model = rig(**options)
    return BurstProblem(burst(truth, model), model, truth.dispersive)
