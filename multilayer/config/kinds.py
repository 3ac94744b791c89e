"""What kind of file a YAML file is: as its ``kind:`` says or, of files without one, by keys that only this kind has."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from multilayer.config.yaml12 import Document
from multilayer.errors import InputError, Problem, show, suggest

KEY = "kind"
FIT_FILE = "fit.yaml"  # of a folder
TITLES = {
    "stack": "stack file",
    "simulation": "simulation file",
    "campaign": "campaign on the two-plate rig",
    "calibration": "calibration of two accelerometers",
    "fit": "fit of a campaign",
    "stack-fit": "fit of stacks",
    "diagnose": "diagnosis of tube measurements",
    "rig": "campaign of the virtual rig",
    "tube": "raw data of an impedance tube",
    "library": "library of materials",
}
_ALSO = {"stack": "simulation", "simulation": "stack", "diagnose": "stack-fit"}  # that a reader takes as well
# what a file may say beside a stack
OF_A_SIMULATION = frozenset(
    {"frequency", "incidence", "finite_size", "reference", "sweep", "tolerances", "samples", "seed"}
)
_OF_A_STACK_FIT = frozenset({"nominal", "stacks", "measurements", "unknowns"})
_OF_A_DIAGNOSIS = frozenset({"effects", "tube", "reference"})
OF_A_FIT = frozenset(
    {
        "campaign", "method", "model", "start", "dispersion", "bounds", "acceptance", "termination", "pores",
        "quasi_static", "calibration", "sensor_mass",
    }
)  # fmt: skip
_RIGS = {"calibration": "calibration", "two-plate": "rig"}


def kind_of_data(data: Any) -> str:
    """Return the name of a file's kind; empty where nothing tells."""
    if not isinstance(data, Mapping):
        return ""
    told = data.get(KEY)
    return told if isinstance(told, str) and told in TITLES else _kind_of_keys(data)


def _kind_of_keys(data: Mapping[str, Any]) -> str:
    keys = data.keys()
    if "layers" in keys:
        return "stack" if OF_A_SIMULATION.isdisjoint(keys) else "simulation"
    if "rig" in keys:
        return _RIGS.get(str(data["rig"]), "campaign")
    if not _OF_A_STACK_FIT.isdisjoint(keys):
        return "stack-fit" if _OF_A_DIAGNOSIS.isdisjoint(keys) else "diagnose"
    if "materials" in keys:
        return "library"
    if "tube" in keys:
        return "tube"
    return "" if OF_A_FIT.isdisjoint(keys) else "fit"


def fit_file(source: Path) -> Path:
    """Return the fit file that is meant: the source itself, or the one that a folder holds."""
    return source / FIT_FILE if source.is_dir() else source


def taken(kind: str) -> tuple[str, ...]:
    """Return the kinds of files that the reader of a kind takes, this one first."""
    return (kind, _ALSO[kind]) if kind in _ALSO else (kind,)


def without_kind(document: Document, kind: str) -> Document:
    """Return a document without its ``kind``.

    Parameters
    ----------
    document : Document
    kind : str
        What is read here; see `taken`.

    Raises
    ------
    InputError
        When it says another one, or one that there is not.
    """
    if not isinstance(document.data, dict) or KEY not in document.data:
        return document
    if (told := document.data[KEY]) not in taken(kind):
        raise InputError([*document.problems, other_kind(document, told, taken(kind))])
    return replace(document, data={key: value for key, value in document.data.items() if key != KEY})


def other_kind(document: Document, told: Any, kinds: Collection[str] = TITLES) -> Problem:
    """Return the problem of a ``kind`` that is not read here."""
    if isinstance(told, str) and told in TITLES:
        message = f"this file is another one ('{told}': {TITLES[told]}); what is read here: {', '.join(kinds)}"
    else:
        message = f"there is no kind of file {show(told)}; {suggest(str(told), kinds)}"
    return Problem(message, KEY, document.file, *document.position((KEY,)))
