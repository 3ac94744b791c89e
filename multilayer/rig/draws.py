"""The errors of a virtual campaign, drawn from the uncertainties that the experimenter states."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator

from multilayer.rig.file import RigFile

# separate streams of random numbers: a further draw in one leaves the others as they are
_CAMPAIGN, _THICKNESS, _MOUNTING, _NOISE, _PLATES = range(5)


@dataclass(frozen=True)
class Errors:
    """The drawn errors of a campaign.

    Attributes
    ----------
    channel_gain, density : float
        Relative, of the whole campaign.
    channel_delay : float
        s.
    top_plate_mass : dict
        Relative, by nominal thickness: every plate is weighed by itself.
    thickness : dict
        m, by nominal thickness.
    remount_gain : dict
        Relative, by configuration.
    repeat_gain, repeat_stiffness : dict
        Relative, by configuration, one number per repeat: those of `remount`.
    """

    channel_gain: float
    channel_delay: float
    density: float
    top_plate_mass: dict[float, float]
    thickness: dict[float, float]
    remount_gain: dict[str, float]
    repeat_gain: dict[str, tuple[float, ...]]
    repeat_stiffness: dict[str, tuple[float, ...]]

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for the truth file, SI."""
        plain = {name: getattr(self, name) for name in ("channel_gain", "channel_delay", "density")}
        pieces = {
            name: [{"nominal": nominal, "error": error} for nominal, error in getattr(self, name).items()]
            for name in ("top_plate_mass", "thickness")
        }
        repeats = {
            name: {k: list(v) for k, v in getattr(self, name).items()}
            for name in ("repeat_gain", "repeat_stiffness")
            if any(any(v) for v in getattr(self, name).values())
        }
        return {**plain, **pieces, "remount_gain": self.remount_gain, **repeats}


def draw_errors(settings: RigFile, seed: int) -> Errors:
    """Draw the errors of a campaign, normal with the standard deviations that the file states.

    Parameters
    ----------
    settings : RigFile
    seed : int
    """
    stated = settings.uncertainty
    gain, delay, density = _stream(seed, _CAMPAIGN).standard_normal(3).tolist()
    heights = dict.fromkeys(mounting.thickness for mounting in settings.mountings)
    plates = dict.fromkeys(mounting.top_plate for mounting in settings.mountings)
    masses = _stream(seed, _PLATES).standard_normal(len(plates)).tolist()
    drawn = _stream(seed, _THICKNESS).standard_normal(len(heights)).tolist()
    remounts = {m.name: _stream(seed, _MOUNTING, m.index) for m in settings.mountings}
    remount_gain = {name: stated.remount_gain * float(rng.standard_normal()) for name, rng in remounts.items()}
    remount = settings.remount
    scatter = {name: rng.standard_normal((2, settings.repeats)) for name, rng in remounts.items()}
    return Errors(
        channel_gain=stated.channel_gain * gain,
        channel_delay=stated.channel_delay * delay,
        density=stated.density * density,
        top_plate_mass={t: stated.top_plate_mass * x for t, x in zip(plates, masses, strict=True)},
        thickness={h: stated.thickness * x for h, x in zip(heights, drawn, strict=True)},
        remount_gain=remount_gain,
        repeat_gain={name: _scaled(remount.gain if remount else 0.0, x[0]) for name, x in scatter.items()},
        repeat_stiffness={name: _scaled(remount.stiffness if remount else 0.0, x[1]) for name, x in scatter.items()},
    )


def _scaled(deviation: float, values: np.ndarray) -> tuple[float, ...]:
    return tuple((deviation * values).tolist())


def _stream(seed: int, *key: int) -> Generator:
    return np.random.default_rng([seed, *key])


def noise_stream(seed: int, mounting: int, burst: int) -> Generator:
    """Return the random numbers of one burst's noise."""
    return _stream(seed, _NOISE, mounting, burst)
