"""From recordings of other people's recorders to a campaign folder: what `multilayer import` does."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError, Problem
from multilayer.measurements.cutting import CutBurst, CutResult, Window, cut_bursts
from multilayer.measurements.describing import campaign_text, file_names, refuse_wrong
from multilayer.measurements.description import FILE_NAME
from multilayer.measurements.metadata import Metadata
from multilayer.measurements.pairs import ChannelChoice, Pair, pair_of
from multilayer.measurements.readers import read_channels
from multilayer.measurements.writing import signal_bytes
from multilayer.signals.envelope import rms
from multilayer.writing.folders import write_new

CYCLES = 10.0
_RATE_AGREEMENT = 1e-6
_LEVELS = 1.5  # ratio: repeats that differ by more were no repeats


@dataclass(frozen=True)
class ImportedCampaign:
    """A campaign made of recordings, not yet written.

    Attributes
    ----------
    text : str
        ``campaign.yaml``.
    result : CutResult
    names : mapping
        File of each burst by frequency, relative to the folder.
    complete : bool
        False where fields of the text are still to be filled in.
    """

    text: str
    result: CutResult
    names: Mapping[float, str]
    complete: bool


def read_pairs(files: Sequence[Path], choice: ChannelChoice) -> list[Pair]:
    """Read base and top of every file.

    Raises
    ------
    InputError
        With the mistakes of every file; and when the files differ in sampling rate.
    """
    twice = sorted({str(file) for file in files if sum(other.resolve() == file.resolve() for other in files) > 1})
    if twice:
        raise InputError(f"{', '.join(twice)}: named more than once; its bursts would count as repeats of themselves")
    pairs: list[Pair] = []
    problems: list[Problem] = []
    for file in files:
        try:
            pairs.append(pair_of(read_channels(file), choice))
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError(dict.fromkeys(problems))
    rates = {pair.sampling_rate for pair in pairs}
    if max(rates) / min(rates) > 1 + _RATE_AGREEMENT:
        listed = ", ".join(f"{pair.file} at {pair.sampling_rate:g} Hz" for pair in pairs)
        raise InputError(f"the files differ in sampling rate: {listed}; import those of one rate together")
    return pairs


def make_campaign(
    pairs: Sequence[Pair],
    metadata: Metadata,
    window: Window,
    frequencies: tuple[float, ...] = (),
    progress: Callable[[str], None] = lambda _: None,
) -> ImportedCampaign:
    """Cut the bursts of recordings and describe them as a campaign.

    Parameters
    ----------
    pairs : sequence of Pair
    metadata : Metadata
    window : Window
    frequencies : tuple of float
        Of the bursts to be taken, Hz; when left out, those that the metadata lists, or else all.
    progress : callable
        See `cutting.cut_bursts`.

    Raises
    ------
    InputError
        When there is no burst, a burst could not be fitted (see `multilayer.signals.quality`), or the metadata does
        not fit a campaign.
    """
    refuse_wrong(metadata, window.cycles)
    result = cut_bursts(pairs, window, frequencies or metadata.frequencies, progress)
    _refuse_unfit(result, window.cycles, together=metadata.is_calibration)
    names = file_names(metadata, [burst.frequency for burst in result.bursts])
    level = _level(result.bursts, window.cycles)
    text, complete = campaign_text(metadata, names, level, window.cycles, pairs[0].sampling_rate)
    return ImportedCampaign(text, result, names, complete)


def _refuse_unfit(result: CutResult, cycles: float, *, together: bool) -> None:
    from multilayer.signals.calibration import calibrate
    from multilayer.signals.disturbance import without_disturbances
    from multilayer.signals.quality import check_configuration

    recordings = {
        burst.frequency: without_disturbances(burst.recording, burst.frequency, cycles)[0] for burst in result.bursts
    }
    raw = {burst.frequency: burst.raw for burst in result.bursts}
    places = {
        burst.frequency: ", ".join(f"{file} at {at:.3f} s" for file, at in burst.onsets) for burst in result.bursts
    }
    unfit = [
        finding.message if finding.frequency is None
        else f"burst at {finding.frequency:g} Hz ({places[finding.frequency]}): {finding.message}"
        for finding in check_configuration(recordings, cycles=cycles, together=together, raw=raw)
    ]  # fmt: skip
    if unfit:
        raise InputError(
            [*unfit, "bursts can be left out: --frequencies names those to take, as --frequencies 200,300"]
        )
    if together:
        calibrate(recordings, cycles=cycles)  # refuses what shows no common motion


def _level(bursts: Sequence[CutBurst], cycles: float) -> float:
    """Return the median over the bursts of the base's rms over the duration of a burst, m/s2."""
    return float(np.median([np.mean(_levels(burst, cycles)) for burst in bursts]))


def _levels(burst: CutBurst, cycles: float) -> RealArray:
    """Return the base's rms over the duration of a burst, m/s2, of every repeat."""
    base = burst.recording.base - burst.recording.base.mean(axis=1, keepdims=True)
    duration = cycles / burst.frequency * burst.recording.sampling_rate
    return np.asarray(rms(base) * np.sqrt(burst.recording.n_samples / duration))


def remarks(made: ImportedCampaign, cycles: float) -> list[str]:
    """Return what a user should look at: what is not alike, disturbs or limits a channel, and coloured noise."""
    from multilayer.signals.band_noise import noise_in_words
    from multilayer.signals.disturbance import in_words, without_disturbances
    from multilayer.signals.repeats import repeats_in_words
    from multilayer.signals.soft_limit import limits_in_words

    bursts = {f"{burst.frequency:g} Hz": burst for burst in made.result.bursts}
    clean, taken = {}, {}
    for name, burst in bursts.items():
        recording, taken[name] = without_disturbances(burst.recording, burst.frequency, cycles)
        clean[name] = burst.frequency, recording
    levels = {name: _levels(burst, cycles) for name, burst in bursts.items()}
    of_levels = [
        f"repeats at {name} differ in level by a factor of {level.max() / level.min():.2g}; a fit averages them"
        for name, level in levels.items()
        if level.max() > _LEVELS * level.min()
    ]
    of_disturbances = [text.replace("taken off", "which a fit takes off") for text in in_words(taken)]
    of_channels = [*limits_in_words(clean, cycles), *repeats_in_words(clean, cycles)]
    return [*of_levels, *of_channels, *of_disturbances, *noise_in_words(clean, cycles)]


def write_imported(made: ImportedCampaign, folder: Path) -> None:
    """Write a campaign, as a whole or not at all.

    Parameters
    ----------
    made : ImportedCampaign
    folder : Path
        Not there yet, or empty.

    Raises
    ------
    InputError
        When the folder cannot be written to.
    """
    signals = {made.names[burst.frequency]: signal_bytes(burst.recording) for burst in made.result.bursts}
    write_new(folder, {**signals, FILE_NAME: made.text}, made_by="import")
