"""A virtual campaign on disk: its folder and its truth file, both complete or neither."""

from __future__ import annotations

import json
from pathlib import Path

from multilayer.config.yaml12 import dump_yaml
from multilayer.measurements.description import FILE_NAME, Campaign
from multilayer.measurements.writing import HEADING, signal_bytes, signal_name
from multilayer.rig.synthesis import SyntheticCampaign
from multilayer.writing.folders import write_files
from multilayer.writing.workspace import resolved, unusable

HIDDEN = ".truth"


def truth_path(folder: Path, *, quiet: bool) -> Path:
    """Return where the truth of a campaign goes: beside its folder, or into a hidden folder beside it."""
    place = resolved(folder)
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
        raise unusable(folder, "it is a file")
    if not any(folder.iterdir()):
        return
    if not (folder / FILE_NAME).is_file():
        raise unusable(folder, f"it holds other things than a campaign: there is no {FILE_NAME} in it")
    if not any(truth_path(folder, quiet=quiet).is_file() for quiet in (False, True)):
        raise unusable(folder, "the campaign in it was not made by the virtual rig: it has no truth file")


def write_campaign(made: SyntheticCampaign, folder: Path, *, quiet: bool = False) -> Path:
    """Write a campaign and its truth file.

    A campaign that the virtual rig made before is replaced as a whole; files of others in its folder stay.

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
    target, other = truth_path(place, quiet=quiet), truth_path(place, quiet=not quiet)
    truth = json.dumps(made.truth, indent=1, allow_nan=False) + "\n"
    # no inputs: the rig's file would tell the truth
    write_files(place, _files(made), made_by="rig", inputs={}, beside={target: truth.encode()}, gone=[other])
    return target


def _files(made: SyntheticCampaign) -> dict[str, bytes | str]:
    """Return the contents of the campaign's folder."""
    signals = {signal_name(*key): signal_bytes(recording) for key, recording in made.recordings.items()}
    return {FILE_NAME: campaign_text(made.campaign), **signals}


def campaign_text(campaign: Campaign) -> str:
    """Return ``campaign.yaml``."""
    return HEADING + dump_yaml({"kind": "campaign"} | campaign.model_dump(mode="json"))
