"""Campaigns of another forward model than the project's: rods, with nothing of the project but the classes they fill.

A sample and a top plate are slender rods on a foot that moves as the burst says: one-dimensional waves in closed form.
Poisson's ratio is 0, and no base plate lies between the accelerometer and the sample. The sample's modulus is any
causal law, a function of frequency (Hz). Signals come from one long transform, so that no ring-down wraps round.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import yaml

from multilayer.measurements.description import Campaign
from multilayer.signals.recording import Recording

Law = Callable[[np.ndarray], np.ndarray]
Recordings = dict[tuple[str, float], Recording]

REST = 0.005  # s, before the burst
TRANSFORM = 20.0  # s: a loss factor of 0.01 at 60 Hz has decayed by exp(-37) then
PAPER = (100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0, 800.0, 900.0, 1000.0, 1100.0, 1200.0, 1300.0, 1400.0, 1500.0)
STATED = {
    "channel_gain": 0.003,
    "channel_delay": 1e-6,
    "remount_gain": 0.001,
    "thickness": 5e-5,
    "density": 0.01,
    "top_plate_mass": 0.002,
}
STEEL, STEEL_MODULUS, RADIUS = 7850.0, 2.1e11, 0.0225


def fractional_zener(relaxed: float, unrelaxed: float, time: float, order: float) -> Law:
    """Return ``E0 + (Einf - E0) z/(1 + z)``, ``z = (i w time)^order``, Pa."""

    def modulus(frequency):
        z = (2j * np.pi * np.asarray(frequency, dtype=float) * time) ** order
        return relaxed + (unrelaxed - relaxed) * z / (1 + z)

    return modulus


def havriliak_negami(relaxed: float, unrelaxed: float, time: float, order: float, asymmetry: float) -> Law:
    """Return ``Einf - (Einf - E0) / (1 + (i w time)^order)^asymmetry``, Pa."""

    def modulus(frequency):
        z = (2j * np.pi * np.asarray(frequency, dtype=float) * time) ** order
        return unrelaxed - (unrelaxed - relaxed) / (1 + z) ** asymmetry

    return modulus


def constant_loss(storage: float, loss_factor: float, at: float = 500.0) -> Law:
    """Return the law of constant loss factor, ``(i f)^n``, with E1 = `storage` Pa at the frequency `at`."""
    order = 2 / np.pi * np.arctan(loss_factor)

    def modulus(frequency):
        return storage * (1 + 1j * loss_factor) * (np.asarray(frequency, dtype=float) / at) ** order

    return modulus


def transmissibility(
    frequency: np.ndarray, modulus: np.ndarray, density: float, height: float, plate: float, plate_density: float
) -> np.ndarray:
    """Return the acceleration of the free end of the plate over that of the sample's foot.

    Two rods: ``1/T = cos a cos b - (Z_plate/Z_sample) sin a sin b`` with a, b the phases ``k h`` of sample and plate
    and Z = sqrt(rho E) (continuous force and motion between them, no force at the end).
    """
    w = 2 * np.pi * np.asarray(frequency)
    a = w * height * np.sqrt(density / modulus)
    b = w * plate * np.sqrt(plate_density / STEEL_MODULUS)
    ratio = np.sqrt(plate_density * STEEL_MODULUS) / np.sqrt(density * modulus)
    # all over exp(|Im a|), which grows where the rod is lossy and many wavelengths long
    back = np.exp(-1j * a - np.abs(a.imag)) / 2
    ahead = np.exp(1j * a - np.abs(a.imag)) / 2
    cosine, sine = ahead + back, (ahead - back) / 1j
    return np.exp(-np.abs(a.imag)) / (cosine * np.cos(b) - ratio * sine * np.sin(b))


def burst(frequency: float, cycles: float, n_samples: int, rate: float, window: str, level: float) -> np.ndarray:
    """Return a tone of so many cycles that begins `REST` s after the record does, m/s2; `level` is its rms."""
    time = np.arange(n_samples) / rate - REST
    share = time * frequency / cycles  # of the burst that is over
    inside = (share > 0) & (share < 1)
    tone = np.where(inside, np.sin(2 * np.pi * frequency * time), 0.0)
    if window == "rectangular":
        return level * np.sqrt(2) * tone
    assert window == "hann", window
    return level * np.sqrt(16 / 3) * tone * np.sin(np.pi * share) ** 2


@dataclass(frozen=True)
class Hum:
    """Mains hum in both channels: rms over the base's in the burst, Hz, and whether each repeat starts at one phase."""

    level: float
    frequency: float = 50.0
    locked: bool = True


@dataclass(frozen=True)
class Rods:
    """A laboratory of rods; what `campaign_of_rods` makes is drawn from it."""

    law: Law
    thicknesses: Sequence[float] = (0.025,)
    top_plates: Sequence[float] = (0.001,)
    density: float = 90.0
    top_density: float = STEEL
    frequencies: Sequence[float] = PAPER
    cycles: float = 10.0
    window: str = "hann"
    sampling_rate: float = 25600.0
    level: float = 5.0
    noise: tuple[float, float] = (0.004, 0.004)
    repeats: int = 3
    hum: Hum | None = None
    tail: float = 0.1
    channel_gain: float = 1.0
    channel_delay: float = 0.0
    errors: Mapping[str, float] = field(default_factory=dict)
    stated: Mapping[str, float] = field(default_factory=lambda: dict(STATED))
    exchanged: bool = False
    seed: int = 1

    def described(self) -> dict:
        """Return the campaign as its file says it."""
        mountings = [(h, t) for h in self.thicknesses for t in self.top_plates]
        return {
            "version": 1,
            "rig": "shaker-two-plate",
            "sampling_rate": self.sampling_rate,
            "specimen": {"density": self.density, "poisson_ratio": 0.0},
            "top_plate": {"density": self.top_density, "young_modulus": STEEL_MODULUS, "poisson_ratio": 0.0},
            "base_plate": {"density": 2700.0, "young_modulus": 7e10, "poisson_ratio": 0.33, "thickness": 0.01},
            **({"uncertainty": dict(self.stated)} if self.stated else {}),
            "burst": {"cycles": float(self.cycles), "window": "hann", "level_rms": self.level},
            "configurations": [
                {
                    "name": name_of(height, plate),
                    "specimen_thickness": height,
                    "top_plate_thickness": plate,
                    "specimen_radius": RADIUS,
                    "bursts": [
                        {"frequency": f, "file": f"{name_of(height, plate)}_{f:g}.npz"} for f in self.frequencies
                    ],
                }
                for height, plate in mountings
            ],
        }

    def recordings(self, height: float, plate: float, rng: np.random.Generator) -> dict[float, Recording]:
        """Return the bursts of one mounting by frequency."""
        n_fft = round(TRANSFORM * self.sampling_rate)
        f = np.fft.rfftfreq(n_fft, 1 / self.sampling_rate)
        ratio = np.ones(len(f), dtype=complex)
        ratio[1:] = transmissibility(
            f[1:],
            self.law(f[1:]),
            self.density * (1 + self.errors.get("density", 0.0)),
            height + self.errors.get("thickness", 0.0),
            plate,
            self.top_density * (1 + self.errors.get("top_plate_mass", 0.0)),
        )
        ratio *= self.channel_gain * np.exp(-2j * np.pi * f * self.channel_delay)
        made = {}
        for f0 in self.frequencies:
            n = round((REST + self.cycles / f0 + self.tail) * self.sampling_rate)
            base = burst(f0, self.cycles, n, self.sampling_rate, self.window, self.level)
            top = np.fft.irfft(ratio * np.fft.rfft(base, n_fft), n_fft)[:n]
            shown = [
                self._shown(channel, share, f0, rng) for channel, share in zip((base, top), self.noise, strict=True)
            ]
            made[f0] = Recording(*(reversed(shown) if self.exchanged else shown), self.sampling_rate)
        return made

    def _shown(self, channel: np.ndarray, share: float, f0: float, rng: np.random.Generator) -> np.ndarray:
        """Return the repeats of a channel: white noise over its rms within the burst, and hum."""
        first, last = (round(t * self.sampling_rate) for t in (REST, REST + self.cycles / f0))
        rms = np.sqrt(np.mean(channel[first:last] ** 2))
        repeats = channel + share * rms * rng.standard_normal((self.repeats, len(channel)))
        if self.hum is None:
            return repeats
        phase = rng.uniform(0, 2 * np.pi, (1 if self.hum.locked else self.repeats, 1))
        time = np.arange(len(channel)) / self.sampling_rate
        return repeats + np.sqrt(2) * self.hum.level * self.level * np.sin(
            2 * np.pi * self.hum.frequency * time + phase
        )


def name_of(height: float, plate: float) -> str:
    """Return the name of a mounting."""
    return f"h{1e3 * height:g}mm-t{1e3 * plate:g}mm"


def campaign_of_rods(law: Law, **options) -> tuple[Campaign, Recordings]:
    """Return a campaign and its recordings, as they would be read from files.

    Parameters
    ----------
    law : callable
        E1 + i E2, Pa, at frequencies, Hz.
    thicknesses, top_plates : sequence of float
        m; every pair is a configuration.
    density, top_density : float
        As stated, kg/m3; `errors` says what is true.
    frequencies : sequence of float
        Of the bursts, Hz.
    cycles : float
    window : {'hann', 'rectangular'}
        Of the signals; the campaign says hann all the same, for it knows no other.
    sampling_rate, level : float
        Hz; rms of the base over the burst, m/s2.
    noise : (float, float)
        White, of base and top: standard deviation over the channel's rms within the burst.
    repeats : int
    hum : Hum, optional
    tail : float
        Length of the record after the burst, s.
    channel_gain, channel_delay : float
        Of the top's chain; s.
    errors : mapping
        True over stated: density and top_plate_mass (relative), thickness (m).
    stated : mapping
        The campaign's `uncertainty`; empty to leave it out.
    exchanged : bool
        Whether base and top are.
    seed : int
    """
    rods = Rods(law, **options)
    campaign, rng = Campaign.model_validate(rods.described()), np.random.default_rng(rods.seed)
    recordings = {}
    for mounting in campaign.configurations:
        made = rods.recordings(mounting.specimen_thickness, mounting.top_plate_thickness, rng)
        recordings |= {(mounting.name, f): recording for f, recording in made.items()}
    return campaign, recordings


def write_rods(folder: Path, law: Law, **options) -> Path:
    """Write a campaign of rods as a laboratory would, and return its folder."""
    campaign, recordings = campaign_of_rods(law, **options)
    folder.mkdir(parents=True)
    (folder / "campaign.yaml").write_text(yaml.safe_dump(Rods(law, **options).described(), sort_keys=False))
    for mounting in campaign.configurations:
        for each in mounting.bursts:
            recording = recordings[mounting.name, each.frequency]
            np.savez(folder / each.file, base=recording.base, top=recording.top)
    return folder
