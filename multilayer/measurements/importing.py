"""From recordings of other people's recorders to a campaign folder: what `multilayer import` does."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from multilayer.config.validate import validate
from multilayer.config.yaml12 import Document, dump_yaml
from multilayer.errors import InputError, Problem
from multilayer.measurements.cutting import CutBurst, CutResult, Window, cut_bursts
from multilayer.measurements.description import FILE_NAME, FILL_IN, Campaign
from multilayer.measurements.knowledge import UNNAMED, Knowledge
from multilayer.measurements.pairs import ChannelChoice, Pair, pair_of
from multilayer.measurements.readers import read_channels
from multilayer.measurements.writing import HEADING, signal_bytes, signal_name
from multilayer.signals.envelope import rms

CYCLES = 10.0
_RATE_AGREEMENT = 1e-6
_TO_FILL: Mapping[str, Any] = {
    "specimen": {"density": FILL_IN, "poisson_ratio": FILL_IN},
    "top_plate": {"density": FILL_IN, "young_modulus": FILL_IN, "poisson_ratio": FILL_IN},
    "base_plate": {"density": FILL_IN, "young_modulus": FILL_IN, "poisson_ratio": FILL_IN, "thickness": FILL_IN},
}
_MOUNTING = ("specimen_thickness", "top_plate_thickness", "specimen_radius")
_TEMPLATE = f"""\
# To be filled in, wherever {FILL_IN} stands: density in kg/m3, young_modulus in Pa, thickness and radius in m, or with
# their unit, as 25 mm. 'uncertainty', one standard deviation of each, may be added; see docs/campaign-files.md.
"""


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
    knowledge: Knowledge,
    window: Window,
    frequencies: tuple[float, ...] = (),
    progress: Callable[[str], None] = lambda _: None,
) -> ImportedCampaign:
    """Cut the bursts of recordings and describe them as a campaign.

    Parameters
    ----------
    pairs : sequence of Pair
    knowledge : Knowledge
    window : Window
    frequencies : tuple of float
        Those to be taken, Hz; those that the knowledge lists, or all, when left out.
    progress : callable
        See `cutting.cut_bursts`.

    Raises
    ------
    InputError
        When there is no burst, a burst could not be fitted (see `multilayer.signals.quality`), or the knowledge does
        not fit a campaign.
    """
    result = cut_bursts(pairs, window, frequencies or knowledge.frequencies, progress)
    _refuse_unfit(result, window.cycles)
    name = str(knowledge.mounting.get("name", UNNAMED))
    stem = "".join(c if c.isalnum() or c in "-_." else "_" for c in name)
    names = {burst.frequency: signal_name(stem, burst.frequency) for burst in result.bursts}
    data = _description(knowledge, name, names, result, window, pairs[0].sampling_rate)
    complete = FILL_IN not in dump_yaml(data)
    if complete:
        _check(knowledge, data)
    return ImportedCampaign(HEADING + ("" if complete else _TEMPLATE) + dump_yaml(data), result, names, complete)


def _refuse_unfit(result: CutResult, cycles: float) -> None:
    from multilayer.signals.quality import check_configuration

    recordings = {burst.frequency: burst.recording for burst in result.bursts}
    places = {
        burst.frequency: ", ".join(f"{file} at {at:.3f} s" for file, at in burst.onsets) for burst in result.bursts
    }
    told = [
        finding.message if finding.frequency is None
        else f"burst at {finding.frequency:g} Hz ({places[finding.frequency]}): {finding.message}"
        for finding in check_configuration(recordings, cycles=cycles)
    ]  # fmt: skip
    if told:
        raise InputError([*told, "bursts can be left out: --frequencies names those to take, as --frequencies 200,300"])


def _description(
    knowledge: Knowledge, name: str, names: Mapping[float, str], result: CutResult, window: Window, rate: float
) -> dict[str, Any]:
    given = {
        key: value for key, value in knowledge.data.items() if key not in ("configurations", "burst", "sampling_rate")
    }
    mounting = {key: value for key, value in knowledge.mounting.items() if key not in ("bursts", "name")}
    to_fill = {key: FILL_IN for key in _MOUNTING if key not in mounting}
    shape = knowledge.data.get("burst")
    level = {"level_rms": float(f"{_level(result.bursts, window.cycles):.4g}")}
    burst = {"cycles": window.cycles, "window": "hann"} | level | (dict(shape) if isinstance(shape, Mapping) else {})
    configuration = {"name": name} | mounting | to_fill
    bursts = [{"frequency": frequency, "file": file} for frequency, file in names.items()]
    head = {"version": 1, "rig": "shaker-two-plate"} | given | {"sampling_rate": rate}
    missing = {key: value for key, value in _TO_FILL.items() if key not in given}
    return head | missing | {"burst": burst, "configurations": [configuration | {"bursts": bursts}]}


def _level(bursts: Sequence[CutBurst], cycles: float) -> float:
    """Return the median over the bursts of the base's rms over the duration of a burst, m/s2."""
    energies = [
        float(np.mean(rms(one.recording.base - one.recording.base.mean(axis=1, keepdims=True))) ** 2)
        * one.recording.n_samples / one.recording.sampling_rate / (cycles / one.frequency)
        for one in bursts
    ]  # fmt: skip
    return float(np.sqrt(np.median(energies)))


def _check(knowledge: Knowledge, data: dict[str, Any]) -> None:
    """Refuse what does not fit a campaign, at the line of the file that says it."""
    if knowledge.document is None or knowledge.file is None:
        return
    places, keys = (
        {_moved(path, knowledge.index): place for path, place in there.items() if _is_kept(path, knowledge.index)}
        for there in (knowledge.document.places, knowledge.document.key_places)
    )
    validate(Document(knowledge.file, data, places, keys), Campaign)


def _is_kept(path: tuple[str | int, ...], index: int) -> bool:
    return path[:1] != ("configurations",) or len(path) < 2 or path[1] == index


def _moved(path: tuple[str | int, ...], index: int) -> tuple[str | int, ...]:
    return ("configurations", 0, *path[2:]) if path[:2] == ("configurations", index) else path


def refuse_occupied(folder: Path) -> None:
    """Refuse a folder that holds something, before anything is read for it.

    Raises
    ------
    InputError
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file; choose another folder with --out")
    if folder.is_dir() and any(folder.iterdir()):
        raise InputError(f"{folder}: holds files already; remove it, or choose another folder with --out")


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
    place = folder.absolute()
    refuse_occupied(place)
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=place.parent, prefix=".partial-") as partial:
            new = Path(partial) / "new"
            for burst in made.result.bursts:
                file = new / made.names[burst.frequency]
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(signal_bytes(burst.recording))
            (new / FILE_NAME).write_text(made.text, encoding="utf-8")
            new.replace(place)
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be written to ({error.strerror or error}); choose another with --out"
        ) from None
