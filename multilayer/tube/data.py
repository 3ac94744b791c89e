"""Transfer functions between microphones, from tables or recordings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.errors import InputError, Problem
from multilayer.measurements.readers import read_channels
from multilayer.measurements.tables import TextTable, read_table, split_header, unit_factor
from multilayer.signals.impedance_tube import transfer_functions
from multilayer.tube.file import Source

_PARTS = ("re", "im")


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
        The least of all microphones; None where it is not known.
    """

    file: Path
    frequency: RealArray
    functions: ComplexArray
    coherence: RealArray | None = None


def read_transfer(source: Source, folder: Path, n_microphones: int) -> Transfer:
    """Read a source.

    Parameters
    ----------
    source : Source
    folder : Path
        That its files are relative to.
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
    needed = f"name the columns frequency_hz, {', '.join(f'{name}_{part}' for name in names for part in _PARTS)}"
    table = read_table(file, needed)
    columns = _columns(table)
    optional = {f"h1_{part}" for part in _PARTS}
    wanted = ["frequency", *(f"{name}_{part}" for name in names for part in _PARTS)]
    missing = [
        name for name in wanted if name not in columns and not (name in optional and not optional & set(columns))
    ]
    if missing:
        raise table.error(f"has no column {', '.join(missing)}; {needed}", table.line)
    if not table.rows:
        raise table.error("holds no values below its header")
    used = [name for name in wanted if name in columns]
    numbers = dict(zip(used, table.numbers({columns[name][0]: columns[name][1] for name in used}), strict=True))
    frequency = numbers["frequency"]
    table.refuse_not_positive(frequency)
    order = np.argsort(frequency, kind="stable")
    found = [
        numbers[f"{name}_re"] + 1j * numbers[f"{name}_im"] if f"{name}_re" in numbers else np.ones(len(frequency))
        for name in names
    ]
    functions = np.array([np.ones(len(frequency)), *found] if len(names) == 1 else found, dtype=complex)
    return Transfer(file, frequency[order], functions[:, order])


def _columns(table: TextTable) -> dict[str, tuple[int, float]]:
    """Return index and factor of every column by name."""
    found: dict[str, tuple[int, float]] = {}
    for i, header in enumerate(table.names):
        name, unit = split_header(header) or (header, None)
        if name in ("frequency", "freq", "f"):
            try:
                found["frequency"] = i, unit_factor(header, unit, "Hz")
            except ValueError as error:
                raise table.error(str(error), table.line) from None
        else:
            found.setdefault(name, (i, 1.0))
    return found


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
