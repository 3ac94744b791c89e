"""The examples that come with the package: stack and campaign files, with their data."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

from multilayer.errors import InputError, suggest
from multilayer.writing.workspace import refuse_unusable, workspace

WHAT = {
    "double_wall": "transmission loss of two plates with foam and air between them",
    "foam_absorption": "absorption of a foam, a sweep of its thickness, tolerances",
    "steel_stud_wall": "a double wall with studs of steel, and a floor beside it",
    "duct_silencer": "a silencer of baffles, airways of several heights, with flow",
    "best_absorber": "a search: the best absorber of 50 mm that two materials of the library make",
    "three_layers": "the model of the two-plate rig as a stack",
    "virtual_rig": "a campaign on the virtual rig, with an accelerometer that nobody told",
    "foam_b": "a campaign: bursts of a foam between two plates, to fit and to diagnose",
    "foam_tube": "a reflection coefficient measured in a tube, to fit a stack to",
    "raw_tube": "transfer functions of two microphones in a tube, to evaluate",
    "gallery": "scripts: the same from Python, with figures",
    "reproducing": "scripts: published figures, computed again",
}
_HERE = Path(__file__).parent
_FOLDERS = (_HERE / "_examples", _HERE.parent / "examples")  # as installed; in the repository
_NOT_COPIED = ("__pycache__", "results")


def examples() -> dict[str, Path]:
    """Return the examples by name: a file or a folder each.

    Raises
    ------
    InputError
        When the package was installed without them.
    """
    folder = next((folder for folder in _FOLDERS if folder.is_dir()), None)
    if folder is None:
        text = "there are no examples; install the package again, from its repository: pip install ."
        raise InputError(f"{_FOLDERS[0]}: {text}")
    return {name: folder / name if (folder / name).is_dir() else folder / f"{name}.yaml" for name in WHAT}


def copy_examples(names: Sequence[str], out: Path) -> list[Path]:
    """Copy examples into a folder, all of them or none.

    Parameters
    ----------
    names : sequence of str
        All when empty.
    out : Path
        Made where it is not there; what it holds stays.

    Returns
    -------
    list of Path
        The new files and folders.

    Raises
    ------
    InputError
        For a name that is none, a file that is there already, or a folder that cannot be written to.
    """
    known = examples()
    chosen = list(dict.fromkeys(names or known))
    if unknown := [name for name in chosen if name not in known]:
        raise InputError([f"there is no example '{name}'; {suggest(name, known)}" for name in unknown])
    places = [out / known[name].name for name in chosen]
    if there := [str(place) for place in places if place.exists()]:
        raise InputError(f"{', '.join(there)}: is there already; remove it, or choose another folder with --out")
    refuse_unusable(out)
    with workspace(out / "examples") as space:
        made = [_copied(known[name], space.folder) for name in chosen]
        return [copy.replace(place) for copy, place in zip(made, places, strict=True)]


def _copied(source: Path, folder: Path) -> Path:
    place = folder / source.name
    if source.is_dir():
        shutil.copytree(source, place, ignore=shutil.ignore_patterns(*_NOT_COPIED), copy_function=shutil.copyfile)
    else:
        shutil.copyfile(source, place)
    return place
