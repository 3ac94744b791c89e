"""Transfer functions between microphones, from tables or recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from warnings import warn

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.errors import InputError, PlausibilityWarning, Problem
from multilayer.measurements.accelerometers import voltage_factor
from multilayer.measurements.columns import FREQUENCY, column_values, complex_columns, complex_values, find_columns
from multilayer.measurements.readers import read_channels, read_spectra
from multilayer.signals.channels import Channel, Channels, refuse_other_starts
from multilayer.signals.clipping import clipped_repeats
from multilayer.signals.impedance_tube import transfer_functions
from multilayer.tube.file import Source
from multilayer.units import UnitLabel, parse_quantity

_SHORTEST_SEGMENT = 8  # samples: a Hann window of fewer tells no frequencies apart
_FEWEST_AVERAGES = 2  # of a single segment the coherence is 1, whatever it holds
_ENOUGH_AVERAGES = 8  # of fewer the coherence of mere noise is well above 0
_SAME_RATE = 1e-4


@dataclass(frozen=True, eq=False)
class Transfer:
    """Transfer functions over frequency.

    Attributes
    ----------
    file : Path
    frequency : array, shape (n,)
        Hz, rising.
    functions : complex array, shape (n_microphones, n)
        Pressure at each microphone over a common reference.
    coherence : array, shape (n,) or None
        The lowest of all microphones'; None where it is not known, or made of too few averages to tell anything.
    units : tuple of (str or None)
        Of all channels, where these are not alike and cannot be converted, so that the functions are no pure numbers;
        otherwise empty.
    """

    file: Path
    frequency: RealArray
    functions: ComplexArray
    coherence: RealArray | None = None
    units: tuple[str | None, ...] = ()


def read_transfer(source: Source, folder: Path, n_microphones: int) -> Transfer:
    """Read the transfer functions of one measurement.

    Parameters
    ----------
    source : Source
    folder : Path
        To which its files are relative.
    n_microphones : int
        2 or 4.

    Raises
    ------
    InputError
        When a file or a column is missing, a cell is no number, channels do not fit together, are silent or clipped, or
        the recording is too short for its segments.
    """
    if source.recording is not None:
        return _from_recording(folder / source.recording, source, n_microphones)
    assert source.file is not None
    names = ("h12",) if n_microphones == 2 else ("h1", "h2", "h3", "h4")
    return _from_table(folder / source.file, names)


def refuse_other_frequencies(first: Transfer, other: Transfer) -> None:
    """Refuse two measurements that were not made at the same frequencies."""
    if first.frequency.shape != other.frequency.shape or not np.allclose(first.frequency, other.frequency, rtol=1e-9):
        message = f"has other frequencies than {first.file}; measure both with the same settings"
        raise InputError(Problem(message, file=other.file))


def refuse_unlike_units(measured: Transfer, corrections: Sequence[Transfer], remedy: str) -> None:
    """Refuse channels in unlike units, but where a correction in the same units takes their ratio out.

    Parameters
    ----------
    measured : Transfer
    corrections : sequence of Transfer
        By which the measured functions are divided.
    remedy : str
        What would be such a correction, as a message calls it.
    """
    if measured.units and not corrections:
        text = f"has channels in {_listed(measured.units)}, whose ratio is no pure number; "
        text += f"export them in one unit, or add {remedy} recorded with the same channels, which takes the ratio out"
        raise InputError(Problem(text, file=measured.file))
    for other in corrections:
        if other.units != measured.units:
            text = f"has channels in {_listed(other.units)}, and {measured.file} in {_listed(measured.units)}: "
            text += "what corrects a measurement must be in the same units; export both alike"
            raise InputError(Problem(text, file=other.file))


def _listed(units: tuple[str | None, ...]) -> str:
    return ", ".join(unit or "no unit" for unit in units) or "one unit"


def _from_table(file: Path, names: tuple[str, ...]) -> Transfer:
    parts = [part for name in names for part in complex_columns(name, (name,), unit=None)]
    needed = f"name the columns frequency_hz, {', '.join(part.role for part in parts)}"
    table = read_spectra(file)
    places = find_columns(table, (FREQUENCY, *parts), needed)
    reference = {"h1_re", "h1_im"}  # 1 where the table leaves both out
    needless = set() if reference & set(places) else reference
    missing = [column.role for column in (FREQUENCY, *parts) if column.role not in {*places, *needless}]
    if missing:
        raise table.error(f"has no column {', '.join(missing)}; {needed}", table.line)
    values = column_values(table, places)
    ones = np.ones(len(values["frequency"]), dtype=complex)
    functions = [complex_values(values, name) if f"{name}_re" in values else ones for name in names]
    return Transfer(file, values["frequency"], np.array([ones, *functions] if len(names) == 1 else functions))


def _from_recording(file: Path, source: Source, n_microphones: int) -> Transfer:
    channels = read_channels(file)
    if len(source.channels) != n_microphones:
        text = f"{len(source.channels)} channels are named for {n_microphones} microphones; it holds: {channels}"
        raise channels.error(text)
    chosen = [channels[name] for name in source.channels]
    _refuse_twice(channels, chosen)
    rate = _rate(channels, chosen, source.sampling_rate)
    refuse_other_starts(channels, chosen)
    signals = np.stack([channel.samples for channel in chosen])
    if not np.isfinite(signals).all():
        raise channels.error("holds samples that are not finite; export it again")
    averages = _averages(channels, signals.shape[1], rate, source.segment)
    if not np.all(signals.std(axis=1) > 0):
        silent = next(channel.name for channel in chosen if not channel.samples.std() > 0)
        raise channels.error(f"channel '{silent}' is silent; check microphone and cable")
    if (clipped := clipped_repeats(signals)).any():
        text = f"channel '{chosen[int(np.argmax(clipped))].name}' is clipped: its tops are flat; "
        raise channels.error(f"{text}lower the level or widen the input range, and measure again")
    factors, units = _in_one_unit(chosen)
    frequency, functions, coherence = transfer_functions(signals * factors[:, None], rate, source.segment)
    told = coherence.min(axis=0) if averages >= _ENOUGH_AVERAGES else None
    return Transfer(file, frequency, functions, told, units)


def _refuse_twice(channels: Channels, chosen: list[Channel]) -> None:
    for i, channel in enumerate(chosen):
        if any(channel is other for other in chosen[:i]):
            text = f"'channels' name '{channel.name}' twice; each microphone has a channel of its own. It holds"
            raise channels.error(f"{text}: {channels}")


def _rate(channels: Channels, chosen: list[Channel], given: float | None) -> float:
    """Return the sampling rate, Hz, of channels that were sampled together."""
    rates = {channel.sampling_rate or given for channel in chosen}
    if len(rates) > 1 or len({channel.samples.size for channel in chosen}) > 1:
        raise channels.error(f"the microphones must be sampled together, but they are: {channels}")
    rate = rates.pop()
    if rate is None:
        raise channels.error("does not say its sampling rate; give it as 'sampling_rate' beside 'recording'")
    if given is not None and abs(rate / given - 1) > _SAME_RATE:
        text = f"says that it is sampled at {rate:g} Hz, but 'sampling_rate' beside 'recording' says {given:g} Hz"
        raise channels.error(f"{text}; leave 'sampling_rate' out")
    return rate


def _averages(channels: Channels, n_samples: int, rate: float, segment: float) -> int:
    """Return over how many segments, overlapping by half, spectra are averaged; refuse or warn of too few."""
    n = round(segment * rate)
    if n < _SHORTEST_SEGMENT:
        text = f"'segment' of {segment:g} s is {n} samples at {rate:g} Hz; at least {_SHORTEST_SEGMENT} are needed"
        raise channels.error(f"{text}, {_SHORTEST_SEGMENT / rate:.3g} s (1/segment is the step in frequency)")
    lasts = f"lasts {n_samples / rate:.3g} s"
    if segment * rate > n_samples:
        raise channels.error(f"{lasts}, less than one segment of {segment:g} s")
    averages = (n_samples - n // 2) // (n - n // 2)
    few = f"{lasts}: its segments of {segment:g} s, which overlap by half, give {averages}"
    remedy = f"shorten 'segment' for {_ENOUGH_AVERAGES} or more, or record longer"
    if averages < _FEWEST_AVERAGES:
        raise channels.error(f"{few} average; at least {_FEWEST_AVERAGES} are needed: {remedy}")
    if averages < _ENOUGH_AVERAGES:
        text = f"{few} averages, of which a coherence, left out here, would tell nothing; {remedy}"
        warn(str(Problem(text, file=channels.file)), PlausibilityWarning, stacklevel=2)
    return averages


def _in_one_unit(chosen: list[Channel]) -> tuple[RealArray, tuple[str | None, ...]]:
    """Return factors to the unit of the first channel, and the units of all where some cannot be converted to it."""
    first = chosen[0].unit or None
    factors = [_factor(channel.unit or None, first) for channel in chosen]
    units = tuple(first if factor else channel.unit or None for channel, factor in zip(chosen, factors, strict=True))
    return np.array([factor or 1.0 for factor in factors]), units if len(set(units)) > 1 else ()


def _factor(unit: str | None, wanted: str | None) -> float | None:
    """Return the factor from a unit to another; None where there is none."""
    if unit == wanted:
        return 1.0
    if unit is None or wanted is None:
        return None
    volts, wanted_volts = voltage_factor(unit), voltage_factor(wanted)
    if volts and wanted_volts:
        return volts / wanted_volts
    try:
        return parse_quantity(f"1 {unit}", UnitLabel(wanted).symbol)
    except ValueError:
        return None
