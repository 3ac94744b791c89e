"""Campaigns in memory: from the file of a virtual rig to recordings and their truth."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError, Problem
from multilayer.measurements.description import Campaign
from multilayer.rig.bench import Bench
from multilayer.rig.draws import Errors, draw_errors, noise_stream
from multilayer.rig.effect_base import Mounting
from multilayer.rig.file import RigFile
from multilayer.rig.noise import add_noise, converted
from multilayer.rig.rod_difference import softened_difference, softening_of
from multilayer.rig.statement import campaign_of, truth_of
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import to_signal, to_spectrum

Channels: TypeAlias = tuple[RealArray, RealArray]


@dataclass(frozen=True)
class SyntheticCampaign:
    """A campaign as it would be read from its folder, and its truth.

    Attributes
    ----------
    campaign : Campaign
        What the experimenter knows.
    recordings : dict
        By name of the configuration and frequency of the burst, Hz; in single precision, as files hold them.
    truth : dict
        Plain data; see ``docs/rig.md``.
    """

    campaign: Campaign
    recordings: dict[tuple[str, float], Recording]
    truth: dict[str, Any]


@dataclass(frozen=True)
class Task:
    """Arguments of `measure` for one configuration, picklable so that another process can make the recordings."""

    settings: RigFile
    errors: Errors
    mounting: Mounting
    seed: int


@dataclass(frozen=True)
class Measured:
    """Result of a task: both channels by burst frequency, Hz, and the true modulus, Pa, at each."""

    channels: dict[float, Channels]
    moduli: dict[float, complex]


Mapper: TypeAlias = Callable[[Callable[[Task], Measured], Sequence[Task]], Iterable[Measured]]


def make_campaign(settings: RigFile, seed: int | None = None, mapper: Mapper = map) -> SyntheticCampaign:
    """Measure a campaign on the virtual rig.

    Parameters
    ----------
    settings : RigFile
    seed : int, optional
        In place of the seed in the file; only errors and noise depend on it.
    mapper : callable, optional
        Gives the results of a function for several tasks, in their order, as `map` does.

    Raises
    ------
    InputError
        When a signal exceeds the converters' range, or the sample is too soft for its finite elements.
    """
    number = settings.seed if seed is None else seed
    errors = draw_errors(settings, number)
    tasks = [Task(settings, errors, mounting, number) for mounting in settings.mountings]
    measured = list(mapper(measure, tasks))
    recordings = {
        (task.mounting.name, f): Recording(*channels, settings.sampling_rate)
        for task, result in zip(tasks, measured, strict=True)
        for f, channels in result.channels.items()
    }
    moduli = {task.mounting.name: result.moduli for task, result in zip(tasks, measured, strict=True)}
    return SyntheticCampaign(campaign_of(settings), recordings, truth_of(settings, number, errors, moduli))


def measure(task: Task) -> Measured:
    """Return the recordings of one configuration."""
    bench = Bench(task.settings, task.errors, task.mounting)
    tops = _true_tops(bench)
    channels = {}
    for i, frequency in enumerate(task.mounting.frequencies):
        clean = _clean(bench, frequency, tops[frequency])
        rng = noise_stream(task.seed, task.mounting.index, i)
        channels[frequency] = _recorded(bench, frequency, clean, rng)
    return Measured(channels, {f: _true_modulus(bench, f) for f in task.mounting.frequencies})


def _true_modulus(bench: Bench, frequency: float) -> complex:
    """Return the modulus at a frequency, Hz, averaged over the repeats, Pa."""
    at = np.array([frequency])
    repeats = range(bench.settings.repeats)
    return complex(np.mean([bench.modulus(at, bench.moment(frequency, repeat)) for repeat in repeats]))


def _true_tops(bench: Bench) -> dict[float, RealArray]:
    """Return the top plate's acceleration in each repeat of each burst, m/s2, shape (repeats, n_samples)."""
    tops = {f: np.stack([_top(bench, f, r) for r in range(bench.settings.repeats)]) for f in bench.mounting.frequencies}
    tops = {f: top[:, : bench.timing.n_samples(top[0], f)] for f, top in tops.items()}
    effect = softening_of(bench)
    if effect is None:
        return tops
    added = softened_difference(bench, effect, max(top.shape[1] for top in tops.values()))
    return {f: top + more[: top.shape[1]] for (f, top), more in zip(tops.items(), added, strict=True)}


def _top(bench: Bench, frequency: float, repeat: int) -> RealArray:
    spectrum = bench.response(bench.moment(frequency, repeat)) * bench.timing.base_spectrum(frequency)
    return to_signal(spectrum, bench.timing.n_fft, bench.timing.n_long)


def _clean(bench: Bench, frequency: float, tops: RealArray) -> Channels:
    """Return what both channels would show without noise, m/s2, each of shape (repeats, n_samples)."""
    base = bench.timing.base(frequency)[: tops.shape[1]]
    pairs = [_read(bench, frequency, repeat, base, top) for repeat, top in enumerate(tops)]
    return np.stack([pair[0] for pair in pairs]), np.stack([pair[1] for pair in pairs])


def _read(bench: Bench, frequency: float, repeat: int, base: RealArray, top: RealArray) -> Channels:
    n_fft, (factor, offset) = bench.timing.n_fft, bench.chain(repeat)
    shown = factor * to_spectrum(top, n_fft) + offset * to_spectrum(base, n_fft)
    channels, moment = (base, to_signal(shown, n_fft, top.size)), bench.moment(frequency, repeat)
    for effect in bench.settings.effects:
        channels = effect.apply_to_signals(*channels, bench.settings.sampling_rate, moment)
    return channels


def _recorded(bench: Bench, frequency: float, clean: Channels, rng: np.random.Generator) -> Channels:
    """Return both channels with noise and steps, in the precision of the files."""
    settings = bench.settings.noise
    whites = (settings.white if settings.base is None else settings.base, settings.white)
    channels = []
    for channel, signal, white in zip(("base", "top"), clean, whites, strict=True):
        level = bench.timing.level_of(signal, frequency)
        noisy = add_noise(signal, level, settings, white, bench.settings.sampling_rate, rng)
        _refuse_overload(bench, frequency, channel, noisy)
        channels.append(converted(noisy, settings).astype(np.float32).astype(np.float64))
    return channels[0], channels[1]


def _refuse_overload(bench: Bench, frequency: float, channel: str, signal: RealArray) -> None:
    limit, crest = bench.settings.noise.full_scale, float(np.max(np.abs(signal)))
    if limit is not None and crest >= limit:
        where = f"the {channel} channel reaches {crest:.3g} m/s2 at {frequency:g} Hz in '{bench.mounting.name}'"
        text = f"{where}, beyond this range of {limit:g} m/s2; raise it, or lower burst.level_rms"
        raise InputError(Problem(text, "noise.full_scale"))
