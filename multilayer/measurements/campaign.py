"""From a campaign's folder to its recordings, all read and checked before anything is computed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, TypeVar
from warnings import warn

from multilayer.config.validate import validate
from multilayer.config.yaml12 import DataPath, Document, read_yaml
from multilayer.errors import InputError, PlausibilityWarning, Problem
from multilayer.files import is_file
from multilayer.measurements.description import (
    FILE_NAME,
    FILL_IN,
    Burst,
    CalibrationCampaign,
    Campaign,
    Configuration,
    Description,
)
from multilayer.measurements.readers import read_waveforms
from multilayer.signals.recording import Recording

if TYPE_CHECKING:
    from multilayer.signals.calibration import Calibration
    from multilayer.signals.disturbance import Disturbance

__all__ = [
    "Burst",
    "CalibrationCampaign",
    "Campaign",
    "Configuration",
    "Recording",
    "load_calibration",
    "load_campaign",
    "load_recordings",
    "read_burst",
]

_RATE_AGREEMENT = 1e-3
_KINDS: dict[type[Description], str] = {Campaign: "campaign", CalibrationCampaign: "calibration"}

D = TypeVar("D", bound=Description)


def load_campaign(source: Path | str | Document) -> Campaign:
    """Read the description of a campaign; its signals are not looked at yet.

    Parameters
    ----------
    source : Path, str or Document
        The campaign's folder (with a ``campaign.yaml`` in it), the YAML file itself, or what it holds.

    Raises
    ------
    InputError
        With every mistake, each with file, line and column.
    """
    return _load(source, Campaign)


def campaign_file(path: Path) -> Path:
    """Return the file that describes a campaign: the one in a folder, or the file itself.

    Raises
    ------
    InputError
        When the folder has none.
    """
    if not path.is_dir():
        return path
    if not (path / FILE_NAME).is_file():
        raise InputError(Problem(f"holds no {FILE_NAME}; name a folder that does", file=path))
    return path / FILE_NAME


def _load(source: Path | str | Document, model: type[D]) -> D:
    document = source
    if not isinstance(document, Document):
        document = read_yaml(campaign_file(Path(document)), keep_problems=True)
    _refuse_unfilled(document)
    campaign = validate(document, model, _KINDS[model]).placed(document.file)
    if problems := [*_one_file_of_two(campaign, document)]:
        raise InputError(problems)
    return campaign


def _one_file_of_two(campaign: Description, document: Document) -> Iterator[Problem]:
    first: dict[PurePosixPath, str] = {}
    for path, bursts in _lists(campaign):
        for i, burst in enumerate(bursts):
            here, file = (*path, "bursts", i), PurePosixPath(burst.file)
            if file in first:
                text = f"'{file}' is the recording of {first[file]} as well; each burst has a recording of its own"
                field = (*here, "file")
                yield Problem(text, ".".join(map(str, field)), campaign.file, *document.position(field))
            first.setdefault(file, ".".join(map(str, here)))


def _lists(campaign: Description) -> Iterator[tuple[DataPath, tuple[Burst, ...]]]:
    """Give all bursts of a description, and where they stand."""
    if isinstance(campaign, Campaign):
        for i, configuration in enumerate(campaign.configurations):
            yield ("configurations", i), configuration.bursts
    if isinstance(campaign, CalibrationCampaign):
        yield (), campaign.bursts


def _refuse_unfilled(document: Document) -> None:
    """Refuse a template that was not filled in, in one message."""
    left = [(path, place) for path, place in document.places.items() if document.value(path) == FILL_IN]
    if left:
        listed = ", ".join(f"{'.'.join(map(str, path))} (line {line})" for path, (line, _) in left)
        message = f"{len(left)} fields are still to be filled in, each with a number in SI or with its unit: {listed}"
        raise InputError(Problem(message, "", document.file, *left[0][1]))


def read_burst(campaign: Description, configuration: Configuration | None, burst: Burst) -> Recording:
    """Read one recording; whether it is fit to be used, `multilayer.signals.quality` tells.

    Parameters
    ----------
    campaign : Campaign or CalibrationCampaign
    configuration : Configuration or None
        To which the burst belongs; None in a calibration.
    burst : Burst

    Raises
    ------
    InputError
        When the file is missing (with the line of the campaign's YAML file) or refused by its reader, or
        when it states a sampling rate that differs from the campaign's by more than 0.1 %.
    """
    return _read(campaign, burst, _Places(campaign), _path_of(campaign, configuration, burst))


def _path_of(campaign: Description, configuration: Configuration | None, burst: Burst) -> DataPath:
    """Return where the burst stands in the description; empty when it is not of this campaign."""
    if isinstance(campaign, Campaign):
        if configuration not in campaign.configurations or burst not in configuration.bursts:
            return ()
        index = campaign.configurations.index(configuration)
        return ("configurations", index, "bursts", configuration.bursts.index(burst))
    if isinstance(campaign, CalibrationCampaign) and burst in campaign.bursts:
        return ("bursts", campaign.bursts.index(burst))
    return ()


class _Places:
    """Lines of the campaign's YAML file, which is read again only when a mistake needs its line."""

    def __init__(self, campaign: Description) -> None:
        self.file = campaign.file

    @cached_property
    def _document(self) -> Document | None:
        try:
            return read_yaml(self.file)
        except InputError:  # a campaign made in memory, or a file that has gone since
            return None

    def problem(self, message: str, path: DataPath) -> Problem:
        """Return the problem at its line and column."""
        place = self._document.position(path) if self._document else (None, None)
        return Problem(message, ".".join(map(str, path)), self.file, *place)


def problem_in(campaign: Description, message: str, path: DataPath) -> Problem:
    """Return a problem with what a campaign's file says, at its line and column."""
    return _Places(campaign).problem(message, path)


def _read(campaign: Description, burst: Burst, places: _Places, path: DataPath) -> Recording:
    file = campaign.folder / burst.file
    if not is_file(file):
        message = f"there is no file {file}; correct the name, or remove the burst"
        raise InputError(places.problem(message, (*path, "file")))
    waveforms = read_waveforms(file)
    rate = waveforms.sampling_rate
    if rate is not None and abs(rate / campaign.sampling_rate - 1.0) > _RATE_AGREEMENT:
        message = (
            f"is sampled at {rate:.6g} Hz, but the campaign's sampling_rate is "
            f"{campaign.sampling_rate:.6g} Hz; correct the one that is wrong"
        )
        raise InputError(Problem(message, file=file))
    return Recording(waveforms.base, waveforms.top, campaign.sampling_rate)


def load_recordings(campaign: Campaign) -> dict[tuple[str, float], Recording]:
    """Read and check all recordings of a campaign.

    Parameters
    ----------
    campaign : Campaign

    Returns
    -------
    dict
        Recordings by name of the configuration and frequency of the burst, Hz, in the order of the campaign.

    Raises
    ------
    InputError
        With every problem of every file (see `multilayer.signals.quality`), each with its file.
    """
    places = _Places(campaign)
    problems: list[Problem] = []
    recordings: dict[tuple[str, float], Recording] = {}
    seen, samples = dict[str, "tuple[Disturbance, ...]"](), dict[str, tuple[bytes, ...]]()
    for index, configuration in enumerate(campaign.configurations):
        path: DataPath = ("configurations", index)
        by_frequency, mistakes = _read_and_check(campaign, configuration.bursts, places, path, seen, samples)
        problems += mistakes
        recordings |= {(configuration.name, frequency): recording for frequency, recording in by_frequency.items()}
    if problems:
        raise InputError(dict.fromkeys(problems))
    by_file = {
        configuration.name: {
            burst.file: (burst.frequency, recordings[configuration.name, burst.frequency])
            for burst in configuration.bursts
        }
        for configuration in campaign.configurations
    }
    _tell(campaign, seen, samples, by_file)
    return recordings


def _tell(
    campaign: Description,
    seen: dict[str, tuple[Disturbance, ...]],
    samples: dict[str, tuple[bytes, ...]],
    by_file: Mapping[str, Mapping[str, tuple[float, Recording]]],
) -> None:
    """Warn once of each kind of disturbance that was taken off, and of what else is odd in recordings that can be used.

    `by_file`: by configuration and file, the burst's frequency, Hz, and its recording.
    """
    from multilayer.signals.band_noise import noise_in_words
    from multilayer.signals.clock import clocks_in_words
    from multilayer.signals.copies import copies_in_words
    from multilayer.signals.disturbance import in_words
    from multilayer.signals.neighbours import neighbours_in_words
    from multilayer.signals.repeats import repeats_in_words
    from multilayer.signals.soft_limit import limits_in_words

    cycles = campaign.burst.cycles
    recordings = {file: recording for of_this in by_file.values() for file, recording in of_this.items()}
    texts = [
        *clocks_in_words({name: dict(of_this.values()) for name, of_this in by_file.items()}, cycles),
        *in_words(seen),
        *copies_in_words(samples),
        *neighbours_in_words(by_file, cycles),
        *limits_in_words(recordings, cycles),
        *repeats_in_words(recordings, cycles),
        *noise_in_words(recordings, cycles),
    ]
    for text in texts:
        warn(f"{campaign.file}: {text}", PlausibilityWarning, stacklevel=3)


def _read_and_check(
    campaign: Description,
    bursts: tuple[Burst, ...],
    places: _Places,
    path: DataPath,
    seen: dict[str, tuple[Disturbance, ...]],
    samples: dict[str, tuple[bytes, ...]],
    *,
    together: bool = False,
) -> tuple[dict[float, Recording], list[Problem]]:
    """Return recordings by frequency, Hz, and what is wrong with them; `together`: both sensors at one spot.

    Offset, drift and hum are taken off; what they were is added to `seen`, what stands for the samples to `samples`, by
    file.
    """
    from multilayer.signals.copies import samples_of
    from multilayer.signals.disturbance import without_disturbances
    from multilayer.signals.quality import check_configuration  # heavy: SciPy

    problems: list[Problem] = []
    raw: dict[float, Recording] = {}
    recordings: dict[float, Recording] = {}
    for index, burst in enumerate(bursts):
        try:
            f = burst.frequency
            raw[f] = _read(campaign, burst, places, (*path, "bursts", index))
            samples[str(burst.file)] = samples_of(raw[f])
            recordings[f], seen[str(burst.file)] = without_disturbances(raw[f], f, campaign.burst.cycles)
        except InputError as error:
            problems += error.problems
    files = {burst.frequency: campaign.folder / burst.file for burst in bursts}
    for finding in check_configuration(recordings, cycles=campaign.burst.cycles, together=together, raw=raw):
        if finding.frequency is not None:
            problems.append(Problem(finding.message, file=files[finding.frequency]))
        else:
            where = ("sampling_rate",) if finding.about == "sampling_rate" else path
            problems.append(places.problem(finding.message, where))
    return recordings, problems


def load_calibration(path: Path | str) -> Calibration:
    """Read and check a calibration campaign, and return amplitude ratio and time shift per frequency.

    Parameters
    ----------
    path : Path or str
        A folder with a ``campaign.yaml`` of ``rig: calibration``, or the YAML file itself.

    Raises
    ------
    InputError
        With every mistake in the description, or every problem of every file.
    """
    from multilayer.signals.calibration import calibrate  # heavy: SciPy

    campaign = _load(path, CalibrationCampaign)
    seen, samples = dict[str, "tuple[Disturbance, ...]"](), dict[str, tuple[bytes, ...]]()
    places = _Places(campaign)
    recordings, problems = _read_and_check(campaign, campaign.bursts, places, (), seen, samples, together=True)
    if problems:
        raise InputError(dict.fromkeys(problems))
    by_file = {burst.file: (burst.frequency, recordings[burst.frequency]) for burst in campaign.bursts}
    _tell(campaign, seen, samples, {"": by_file})
    try:
        return calibrate(recordings, cycles=campaign.burst.cycles)
    except InputError as error:
        raise InputError([problem.at(campaign.file) for problem in error.problems]) from None
