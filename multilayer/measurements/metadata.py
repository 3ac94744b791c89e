"""Metadata of a campaign that is made of recordings: what the experimenter knows, from a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from multilayer.config.yaml12 import Document, read_yaml
from multilayer.errors import InputError, Problem, suggest
from multilayer.measurements.description import FILE_NAME
from multilayer.units import parse_quantity

UNNAMED = "imported"  # a mounting without a name


@dataclass(frozen=True)
class Metadata:
    """What the experimenter knows of a campaign, from a file.

    Attributes
    ----------
    file : Path or None
    data : mapping
        As the file has it.
    mounting : mapping
        The configuration of the recordings.
    document : Document or None
        For lines of mistakes.
    index : int
        Of the mounting among the configurations of the file.
    """

    file: Path | None = None
    data: Mapping[str, Any] = field(default_factory=dict)
    mounting: Mapping[str, Any] = field(default_factory=dict)
    document: Document | None = None
    index: int = 0

    @property
    def is_calibration(self) -> bool:
        """Whether both accelerometers were at one spot."""
        return self.data.get("rig") == "calibration"

    @property
    def kind(self) -> str:
        """Kind of the file that is made of it: ``calibration`` or ``campaign``."""
        return "calibration" if self.is_calibration else "campaign"

    def as_calibration(self) -> Metadata:
        """Return the part that also holds for a calibration with the same bursts."""
        data = {"rig": "calibration"} | {key: self.data[key] for key in ("burst",) if key in self.data}
        mounting = {key: self.mounting[key] for key in ("bursts",) if key in self.mounting}
        return Metadata(self.file, data, mounting, self.document, self.index)

    @property
    def cycles(self) -> float | None:
        """Periods of the bursts, where the file says so."""
        burst = self.data.get("burst")
        cycles = burst.get("cycles") if isinstance(burst, Mapping) else None
        return float(cycles) if isinstance(cycles, int | float) and cycles > 0 else None

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Frequencies that the file lists for the mounting, Hz."""
        bursts = self.mounting.get("bursts")
        entries = bursts if isinstance(bursts, list) else []
        listed = [burst.get("frequency") for burst in entries if isinstance(burst, Mapping)]
        return tuple(frequency for frequency in map(_frequency, listed) if frequency is not None)


def _frequency(written: Any) -> float | None:
    try:
        return parse_quantity(written, "Hz")
    except ValueError:
        return None  # the validation of the whole file reports it


def read_metadata(path: Path, configuration: str | None = None) -> Metadata:
    """Read metadata: a campaign's folder or YAML file, or a YAML file with some of those fields.

    Parameters
    ----------
    path : Path
    configuration : str, optional
        Which of its configurations; needed where it has several.

    Raises
    ------
    InputError
    """
    file = path / FILE_NAME if path.is_dir() else path
    document = read_yaml(file)
    data = document.data
    if not isinstance(data, dict) or not isinstance(data.get("configurations", []), list):
        raise InputError(Problem("is no campaign file: it must hold fields, and a list of configurations", file=file))
    rig = data.get("rig", "shaker-two-plate")
    if rig == "calibration":
        return Metadata(file, data, {"bursts": data.get("bursts")}, document)
    if rig != "shaker-two-plate":
        message = f"describes a '{rig}'; a campaign of a shaker-two-plate, or a calibration, is wanted"
        raise InputError(Problem(message, "rig", file))
    mountings = [mounting for mounting in data.get("configurations", []) if isinstance(mounting, dict)]
    index = _index_of(file, [str(mounting.get("name", UNNAMED)) for mounting in mountings], configuration)
    return Metadata(file, data, mountings[index] if mountings else {}, document, index)


def _index_of(file: Path, names: Sequence[str], wanted: str | None) -> int:
    if wanted is not None and wanted not in names:
        raise InputError(
            Problem(f"--configuration: there is no '{wanted}' in this file; {suggest(wanted, names)}", file=file)
        )
    if wanted is None and len(names) > 1:
        text = f"has several configurations; say with --configuration which one was recorded: {', '.join(names)}"
        raise InputError(Problem(text, file=file))
    return names.index(wanted) if wanted is not None else 0
