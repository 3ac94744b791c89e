"""The kind of a YAML file: from its ``kind:`` or, in files without that, from keys that only one kind has."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from multilayer.config.yaml12 import Document, read_yaml
from multilayer.errors import InputError, Problem, show, suggest

KEY = "kind"
FIT_FILE = "fit.yaml"  # of a folder
TITLES = {
    "stack": "stack file",
    "simulation": "simulation file",
    "optimisation": "search of the best design",
    "campaign": "campaign on the two-plate rig",
    "calibration": "calibration of two accelerometers",
    "fit": "fit of a campaign",
    "stack-fit": "fit of stacks",
    "diagnose": "diagnosis of measured stacks",
    "rig": "campaign of the virtual rig",
    "tube": "raw data of an impedance tube",
    "library": "library of materials",
    "rig-law": "what a diagnosis found of a rig",
}
_ALSO = {"stack": "simulation", "simulation": "stack", "diagnose": "stack-fit"}  # a second kind that its reader takes
# fields of a simulation beside its stack
OF_A_SIMULATION = frozenset(
    {
        "frequency", "incidence", "finite_size", "excitation", "free_waves", "layer_losses", "duct", "reference",
        "sweep", "tolerances", "samples", "seed", "area", "beside", "links",
    }
)  # fmt: skip
_OF_AN_OPTIMISATION = frozenset({"design", "goal", "limits", "catalogue"})
_OF_A_STACK_FIT = frozenset({"nominal", "stacks", "measurements", "unknowns"})
_OF_A_DIAGNOSIS = frozenset({"effects", "tube", "reference"})
OF_A_FIT = frozenset(
    {
        "campaign", "method", "model", "start", "dispersion", "bounds", "acceptance", "termination", "pores",
        "quasi_static", "calibration", "sensor_mass",
    }
)  # fmt: skip
_TELLING = {"laws": "rig-law", "materials": "library", "tube": "tube"}
_RIGS = {"calibration": "calibration", "two-plate": "rig"}


def kind_of_data(data: Any) -> str:
    """Return the name of a file's kind; empty where it cannot be told."""
    if not isinstance(data, Mapping):
        return ""
    kind = data.get(KEY)
    return kind if isinstance(kind, str) and kind in TITLES else _kind_of_keys(data)


def _kind_of_keys(data: Mapping[str, Any]) -> str:
    keys = data.keys()
    if "layers" in keys:
        if not _OF_AN_OPTIMISATION.isdisjoint(keys):
            return "optimisation"
        return "stack" if OF_A_SIMULATION.isdisjoint(keys) else "simulation"
    if "rig" in keys:
        return _RIGS.get(str(data["rig"]), "campaign")
    if not _OF_A_STACK_FIT.isdisjoint(keys):
        return "stack-fit" if _OF_A_DIAGNOSIS.isdisjoint(keys) else "diagnose"
    for key, kind in _TELLING.items():
        if key in keys:
            return kind
    return "" if OF_A_FIT.isdisjoint(keys) else "fit"


def fit_file(source: Path) -> Path:
    """Return the path of a fit file: the source itself, or the ``fit.yaml`` of a folder."""
    return source / FIT_FILE if source.is_dir() else source


def read_fit_file(source: str | Path | Document) -> Document:
    """Return what a fit file, or the ``fit.yaml`` of a folder, holds, its problems with it; a document as it is."""
    return source if isinstance(source, Document) else read_yaml(fit_file(Path(source)), keep_problems=True)


def taken(kind: str) -> tuple[str, ...]:
    """Return the kinds of files that the reader of a kind takes, this one first."""
    return (kind, _ALSO[kind]) if kind in _ALSO else (kind,)


def without_kind(document: Document, kind: str) -> Document:
    """Return a document without its ``kind``.

    Parameters
    ----------
    document : Document
    kind : str
        The kind that is read here; see `taken`.

    Raises
    ------
    InputError
        When it states another kind, or an unknown one.
    """
    if not isinstance(document.data, dict) or KEY not in document.data:
        return document
    if (stated := document.data[KEY]) not in taken(kind):
        raise InputError([*document.problems, other_kind(document, stated, taken(kind))])
    return replace(document, data={key: value for key, value in document.data.items() if key != KEY})


def other_kind(document: Document, stated: Any, kinds: Collection[str] = TITLES) -> Problem:
    """Return the problem of a ``kind`` that is not read here."""
    if isinstance(stated, str) and stated in TITLES:
        message = f"this file is another one ('{stated}': {TITLES[stated]}); what is read here: {', '.join(kinds)}"
    else:
        message = f"there is no kind of file {show(stated)}; {suggest(str(stated), kinds)}"
    return Problem(message, KEY, document.file, *document.position((KEY,)))
