"""``campaign.yaml`` of an imported campaign: from recordings and metadata, with gaps for the user to fill in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from multilayer.config.validate import validate
from multilayer.config.yaml12 import Document, dump_yaml
from multilayer.measurements.description import FILL_IN, CalibrationCampaign, Campaign
from multilayer.measurements.metadata import UNNAMED, Metadata
from multilayer.measurements.writing import HEADING, signal_name

_PLATE = ("density", "young_modulus", "poisson_ratio")
_TO_FILL = {
    "specimen": ("density", "poisson_ratio"),
    "top_plate": _PLATE,
    "base_plate": (*_PLATE, "thickness"),
}
_MOUNTING = ("specimen_thickness", "top_plate_thickness", "specimen_radius")
_OF_THE_RECORDING = ("configurations", "burst", "bursts", "sampling_rate")
_TEMPLATE = f"""\
# To be filled in, wherever {FILL_IN} stands: density in kg/m3, young_modulus in Pa, thickness and radius in m, or with
# their unit, as 25 mm. 'uncertainty', one standard deviation of each, may be added; see docs/campaign-files.md.
"""
_CALIBRATION = "# Both accelerometers at one spot of the support plate. SI units; accelerations in m/s^2.\n"
_ANY = 0.1  # a number that every field to be filled in may have


def file_names(metadata: Metadata, frequencies: Sequence[float]) -> dict[float, str]:
    """Return the file of each burst, relative to the campaign's folder, by frequency."""
    name = "calibration" if metadata.is_calibration else _name(metadata)
    stem = "".join(c if c.isalnum() or c in "-_." else "_" for c in name)
    return {frequency: signal_name(stem, frequency) for frequency in frequencies}


def campaign_text(
    metadata: Metadata, names: Mapping[float, str], level: float, cycles: float, rate: float
) -> tuple[str, bool]:
    """Return ``campaign.yaml``, and whether nothing in it is still to be filled in.

    Parameters
    ----------
    metadata : Metadata
    names : mapping
        See `file_names`.
    level : float
        rms of the base over a burst, m/s2, where the metadata says none.
    cycles : float
        Periods of a burst.
    rate : float
        Sampling rate, Hz.
    """
    text = dump_yaml(_data(metadata, names, level, cycles, rate, FILL_IN))
    if metadata.is_calibration:
        return _CALIBRATION + text, True
    complete = FILL_IN not in text
    return HEADING + ("" if complete else _TEMPLATE) + text, complete


def refuse_wrong(metadata: Metadata, cycles: float) -> None:
    """Refuse metadata that does not fit a campaign, before anything is computed.

    Raises
    ------
    InputError
        With every mistake at the line of the file that says it.
    """
    if metadata.document is None or metadata.file is None:
        return
    data = _data(metadata, file_names(metadata, [1.0]), 1.0, cycles, 1e9, _ANY)
    places, keys = (
        {_moved(path, metadata.index): place for path, place in positions.items() if _is_kept(path, metadata.index)}
        for positions in (metadata.document.places, metadata.document.key_places)
    )
    model = CalibrationCampaign if metadata.is_calibration else Campaign
    validate(Document(metadata.file, data, places, keys), model, metadata.kind)


def _name(metadata: Metadata) -> str:
    return str(metadata.mounting.get("name", UNNAMED))


def _data(
    metadata: Metadata, names: Mapping[float, str], level: float, cycles: float, rate: float, missing: Any
) -> dict[str, Any]:
    """Return the fields of the campaign, with `missing` in place of every value that the metadata lacks."""
    shape = metadata.data.get("burst")
    burst = {"cycles": cycles, "window": "hann", "level_rms": float(f"{level:.4g}")}
    burst |= dict(shape) if isinstance(shape, Mapping) else {}
    bursts = [{"frequency": frequency, "file": file} for frequency, file in names.items()]
    head = {"kind": metadata.kind, "version": 1, "rig": "shaker-two-plate"}
    head |= {key: metadata.data[key] for key in metadata.data if key not in (*_OF_THE_RECORDING, "kind")}
    head |= {"sampling_rate": rate}
    if metadata.is_calibration:
        return head | {"burst": burst, "bursts": bursts}
    mounting = {key: value for key, value in metadata.mounting.items() if key not in ("bursts", "name")}
    to_fill = dict.fromkeys([key for key in _MOUNTING if key not in mounting], missing)
    unknown = {part: dict.fromkeys(keys, missing) for part, keys in _TO_FILL.items() if part not in metadata.data}
    configuration = {"name": _name(metadata)} | mounting | to_fill | {"bursts": bursts}
    return head | unknown | {"burst": burst, "configurations": [configuration]}


def _is_kept(path: tuple[str | int, ...], index: int) -> bool:
    return path[:1] != ("configurations",) or len(path) < 2 or path[1] == index


def _moved(path: tuple[str | int, ...], index: int) -> tuple[str | int, ...]:
    return ("configurations", 0, *path[2:]) if path[:2] == ("configurations", index) else path
