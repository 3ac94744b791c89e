"""Results of a diagnosis as a page begins with them: what was diagnosed, and the effects that were named."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from multilayer.diagnosis.saved_law import RECORD, from_record, named_effects
from multilayer.errors import InputError, Problem
from multilayer.files import is_file
from multilayer.fits.sources import Source, open_source
from multilayer.writing.manifest import MANIFEST, changed_inputs, read_manifest

_COMMAND = "diagnose"
_KINDS = ("diagnose", "stack-fit", "fit", "campaign")  # of inputs, those that name others first


@dataclass(frozen=True)
class Diagnosed:
    """A diagnosis that was written.

    Attributes
    ----------
    source : Source
        What was diagnosed.
    effects : mapping
        By the names of the effects that were named, the values of their parameters; empty without a name.
    changed : list of str
        Inputs that are no longer what they were.
    """

    source: Source
    effects: Mapping[str, Mapping[str, float]]
    changed: list[str]


def is_diagnosis(path: Path) -> bool:
    """Tell whether a path is that of a diagnosis' results: its record, or the folder that holds it."""
    if path.is_dir():
        manifest = read_manifest(path)
        return manifest is not None and _COMMAND in manifest["results"]
    return path.name == RECORD


def open_diagnosis(path: Path) -> Diagnosed:
    """Read the results of a diagnosis, and open what was diagnosed.

    Parameters
    ----------
    path : Path
        Of ``diagnosis.json``, or of its folder.

    Raises
    ------
    InputError
        When the record or its manifest cannot be read, or what was diagnosed is not where it was.
    """
    folder = path if path.is_dir() else path.parent
    manifest = read_manifest(folder)
    if manifest is None or _COMMAND not in manifest["results"]:
        text = f"there is no {MANIFEST} of a diagnosis beside {RECORD}, which tells what was diagnosed"
        raise InputError(Problem(f"{text}; name the folder that diagnose wrote", file=folder))
    inputs = manifest["results"][_COMMAND]["inputs"]
    described = [Path(name) for name in inputs if name.endswith((".yaml", ".yml"))]
    missing = [file for file in described if not is_file(file)]
    if missing:
        text = f"what was diagnosed is not there: {missing[0]}"
        raise InputError(Problem(f"{text}; go to the folder in which diagnose was run, or run it again", file=folder))
    sources = [source for source in map(open_source, described) if source.kind in _KINDS]
    if not sources:
        text = "none of the inputs is a campaign or a fit file; run diagnose again"
        raise InputError(Problem(text, file=folder / MANIFEST))
    source = min(sources, key=lambda one: _KINDS.index(one.kind))
    return Diagnosed(
        source, from_record(folder / RECORD, _named), changed_inputs({"results": {_COMMAND: {"inputs": inputs}}})
    )


def _named(record: Mapping[str, Any]) -> dict[str, dict[str, float]]:
    """Return the values of the effects that a record names."""
    if record["verdict"] != "effect":
        return {}
    return {one.effect: {name: found.value for name, found in one.parameters.items()} for one in named_effects(record)}
