"""A virtual campaign on disk: its folder and its truth file, both complete or neither."""

from __future__ import annotations

import json
import shutil
import tempfile
from pathlib import Path

from multilayer.config.yaml12 import dump_yaml
from multilayer.errors import InputError
from multilayer.measurements.description import FILE_NAME, Campaign
from multilayer.measurements.writing import HEADING, signal_bytes, signal_name
from multilayer.rig.synthesis import SyntheticCampaign

HIDDEN = ".truth"


def truth_path(folder: Path, *, quiet: bool) -> Path:
    """Return where the truth of a campaign goes: beside its folder, or into a hidden folder beside it."""
    place = folder.absolute()
    return (place.parent / HIDDEN if quiet else place.parent) / f"{place.name}.truth.json"


def refuse_foreign(folder: Path) -> None:
    """Refuse a folder that holds anything but a campaign that the virtual rig has made.

    Parameters
    ----------
    folder : Path
        Where a campaign is to be written; it may be missing.

    Raises
    ------
    InputError
    """
    if not folder.exists():
        return
    if not folder.is_dir():
        raise _unusable(folder, "it is a file")
    if not any(folder.iterdir()):
        return
    if not (folder / FILE_NAME).is_file():
        raise _unusable(folder, f"it holds other things than a campaign: there is no {FILE_NAME} in it")
    if not any(truth_path(folder, quiet=quiet).is_file() for quiet in (False, True)):
        raise _unusable(folder, "the campaign in it was not made by the virtual rig: it has no truth file")


def _unusable(folder: Path, reason: str) -> InputError:
    return InputError(f"{folder}: cannot be written to ({reason}); choose another folder with --out")


def write_campaign(made: SyntheticCampaign, folder: Path, *, quiet: bool = False) -> Path:
    """Write a campaign and its truth file.

    Both are completed under temporary names first; a campaign that the virtual rig made before is replaced.

    Parameters
    ----------
    made : SyntheticCampaign
    folder : Path
        Of the campaign.
    quiet : bool
        Put the truth into the hidden folder ``.truth`` beside the campaign's.

    Returns
    -------
    Path
        The truth file.

    Raises
    ------
    InputError
        When the folder cannot be written to, or holds something else.
    """
    place = folder.absolute()
    refuse_foreign(place)
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=place.parent, prefix=".partial-") as partial:
            return _write(made, place, Path(partial), quiet)
    except OSError as error:
        raise _unusable(folder, error.strerror or str(error)) from None


def _write(made: SyntheticCampaign, folder: Path, partial: Path, quiet: bool) -> Path:
    new, old, truth = partial / "new", partial / "old", partial / "truth.json"
    _fill(new, made)
    truth.write_text(json.dumps(made.truth, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    target, other = truth_path(folder, quiet=quiet), truth_path(folder, quiet=not quiet)
    target.parent.mkdir(exist_ok=True)
    if folder.exists():
        folder.rename(old)
    try:
        new.rename(folder)
        truth.replace(target)
    except OSError:
        shutil.rmtree(folder, ignore_errors=True)
        if old.exists():
            old.rename(folder)
        raise
    other.unlink(missing_ok=True)  # of the campaign that was there before
    return target


def _fill(folder: Path, made: SyntheticCampaign) -> None:
    (folder / "signals").mkdir(parents=True)
    (folder / FILE_NAME).write_text(campaign_text(made.campaign), encoding="utf-8")
    for (name, frequency), recording in made.recordings.items():
        (folder / signal_name(name, frequency)).write_bytes(signal_bytes(recording))


def campaign_text(campaign: Campaign) -> str:
    """Return ``campaign.yaml``."""
    return HEADING + dump_yaml({"kind": "campaign"} | campaign.model_dump(mode="json"))
