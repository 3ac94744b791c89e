"""Transfer functions between microphones, from tables or recordings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.errors import InputError, Problem
from multilayer.measurements.columns import FREQUENCY, column_values, complex_columns, complex_values, find_columns
from multilayer.measurements.readers import read_channels, read_spectra
from multilayer.signals.impedance_tube import transfer_functions
from multilayer.tube.file import Source


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
        The lowest of all microphones'; None where it is not known.
    """

    file: Path
    frequency: RealArray
    functions: ComplexArray
    coherence: RealArray | None = None


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
        When a file or a column is missing, a cell is no number, or channels do not fit together.
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
    rates = {channel.sampling_rate or source.sampling_rate for channel in chosen}
    if len(rates) > 1 or len({channel.samples.size for channel in chosen}) > 1:
        raise channels.error(f"the microphones must be sampled together, but they are: {channels}")
    rate = rates.pop()
    if rate is None:
        raise channels.error("does not say its sampling rate; give it as 'sampling_rate' beside 'recording'")
    signals = np.stack([channel.samples for channel in chosen])
    if not np.isfinite(signals).all():
        raise channels.error("holds samples that are not finite; export it again")
    if source.segment * rate > signals.shape[1]:
        raise channels.error(f"lasts {signals.shape[1] / rate:.3g} s, less than one segment of {source.segment:g} s")
    if not np.all(signals.std(axis=1) > 0):
        silent = next(channel.name for channel in chosen if not channel.samples.std() > 0)
        raise channels.error(f"channel '{silent}' is silent; check microphone and cable")
    frequency, functions, coherence = transfer_functions(signals, rate, source.segment)
    return Transfer(file, frequency, functions, coherence.min(axis=0))
