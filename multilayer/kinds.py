"""Every kind of YAML file that the project reads: how to recognise it, how to read it, and its schema.

Models and readers are imported on use, so that importing this module is quick.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from multilayer.config.kinds import KEY, OF_A_SIMULATION, TITLES, kind_of_data, other_kind, taken
from multilayer.errors import InputError, Problem, suggest

if TYPE_CHECKING:
    from multilayer.models import Model

_CLOSE = 0.75  # least similarity of a misspelt key to the right one
_SUFFIXES = (".yaml", ".yml", ".json")  # files of other names are YAML where they can be read as such
FOLDER_FILES = ("tube.yaml", "fit.yaml", "campaign.yaml")
"""Read for a folder: the first of these that it holds."""


@dataclass(frozen=True)
class Kind:
    """A kind of file.

    Attributes
    ----------
    name : str
        On the command line and in files, as ``kind: NAME``.
    home : str
        Where its model is, as ``module:Model``; it may be a union of models.
    read : callable
        Reads a file or folder with all files it names, and returns a short description for the user.
    """

    name: str
    home: str
    read: Callable[[Path], str]

    @property
    def title(self) -> str:
        """Title for the user."""
        return TITLES[self.name]

    @property
    def model(self) -> Any:
        """The model of the file, or a union of several."""
        module, _, name = self.home.partition(":")
        return getattr(import_module(module), name)

    @property
    def fields(self) -> set[str]:
        """Names of the fields at the top level of the file."""
        union, *_ = get_args(self.model) or (self.model,)
        models: tuple[type[Model], ...] = get_args(union) or (union,)
        return {info.alias or name for model in models for name, info in model.model_fields.items()}

    def schema(self) -> dict[str, Any]:
        """Return the JSON Schema of the file, layer types, laws and effects of plugins included."""
        from multilayer.json_schema import schema_of

        schema = schema_of(self.model)
        kind_field = {KEY: {"enum": [*taken(self.name)], "description": f"What this file is: {self.title}."}}
        for part in [schema] if "properties" in schema else schema["oneOf"]:
            model = schema["$defs"][part["$ref"].rpartition("/")[2]] if "$ref" in part else part
            model["properties"] = kind_field | model["properties"]
        return {**schema, "title": f"multilayer: {self.title}"}


def _counted(n: int, noun: str, what: str) -> str:
    return f"{what} of one {noun}" if n == 1 else f"{what} of {n} {noun}s"


def _read_stack(source: Path) -> str:
    from multilayer.stack import load_stack

    load_stack(source)
    return "stack"


def _read_simulation(source: Path) -> str:
    from multilayer.simulation.file import load_simulation

    return _counted(len(load_simulation(source).cases), "case", "simulation")


def _read_optimisation(source: Path) -> str:
    from multilayer.optimisation.file import load_optimisation

    file = load_optimisation(source)
    return _counted(len(file.design), "freedom", "optimisation")


def _read_campaign(source: Path) -> str:
    from multilayer.fits.sources import read_fit

    return f"campaign of {len(read_fit(source).recordings)} bursts"


def _read_calibration(source: Path) -> str:
    from multilayer.measurements.campaign import load_calibration

    load_calibration(source)
    return "calibration"


def _read_stack_fit(source: Path) -> str:
    from multilayer.experiments.stacks.file import load_stack_fit

    return _counted(len(load_stack_fit(source).measurements), "measurement", "stack fit")


def _read_diagnosis(source: Path) -> str:
    from multilayer.diagnosis.file import load_diagnosis

    return _counted(len(load_diagnosis(source).measurements), "measurement", "diagnosis")


def _read_rig(source: Path) -> str:
    from multilayer.rig.file import load_rig  # heavy: finite elements

    return f"virtual rig of {len(load_rig(source).mountings)} configurations"


def _read_tube(source: Path) -> str:
    from multilayer.tube.evaluate import evaluate

    return f"tube measurement at {len(evaluate(source).frequency)} frequencies"


def _read_library(source: Path) -> str:
    from multilayer.materials import check_library

    return _counted(check_library(source), "material", "library")


def _read_rig_law(source: Path) -> str:
    from multilayer.diagnosis.saved_law import load_rig_law

    law = load_rig_law(source)
    return _counted(len(law.effects) + len(law.laws), "effect", "law of a rig")


_ALL = (
    Kind("stack", "multilayer.stack:Stack", _read_stack),
    Kind("simulation", "multilayer.simulation.file:SimulationFile", _read_simulation),
    Kind("optimisation", "multilayer.optimisation.file:OptimisationFile", _read_optimisation),
    Kind("campaign", "multilayer.measurements.description:Campaign", _read_campaign),
    Kind("calibration", "multilayer.measurements.description:CalibrationCampaign", _read_calibration),
    Kind("fit", "multilayer.fits.settings:FitSettings", _read_campaign),
    Kind("stack-fit", "multilayer.experiments.stacks.file:StackFitFile", _read_stack_fit),
    Kind("diagnose", "multilayer.diagnosis.file:DiagnosisFile", _read_diagnosis),
    Kind("rig", "multilayer.rig.file:RigFile", _read_rig),
    Kind("tube", "multilayer.tube.file:TubeMeasurement", _read_tube),
    Kind("library", "multilayer.materials:Library", _read_library),
    Kind("rig-law", "multilayer.diagnosis.saved_law:RigLaw", _read_rig_law),
)
KINDS = {kind.name: kind for kind in _ALL}


def kind_named(name: str) -> Kind:
    """Return a kind by its name.

    Raises
    ------
    InputError
        When there is none, with the nearest.
    """
    if name not in KINDS:
        raise InputError(f"there is no kind of file '{name}'; {suggest(name, KINDS)}")
    return KINDS[name]


def kind_of(source: Path) -> Kind:
    """Return the kind of a file, or of the file that is read for a folder.

    Parameters
    ----------
    source : Path

    Raises
    ------
    InputError
        When it cannot be read, or its kind cannot be told from its contents.
    """
    from multilayer.config.yaml12 import read_yaml

    file = source
    if source.is_dir():
        file = next((source / name for name in FOLDER_FILES if (source / name).is_file()), source / FOLDER_FILES[-1])
        if not file.is_file():
            raise InputError(Problem(f"holds none of {', '.join(FOLDER_FILES)}; name a file in it", file=source))
    is_named_so = file.suffix.lower() in _SUFFIXES
    no_yaml = InputError(Problem("this is no YAML file; name one, or a folder with a campaign", file=file))
    try:
        document = read_yaml(file, keep_problems=True)
    except InputError as error:
        if is_named_so or error.problems[0].line is None:
            raise
        raise no_yaml from None
    if not (is_named_so or isinstance(document.data, Mapping)):
        raise no_yaml
    data = document.data if isinstance(document.data, Mapping) else {}
    if KEY in data and data[KEY] not in [*KINDS]:
        raise InputError(other_kind(document, data[KEY]))
    name = kind_of_data(data) or _nearest(data.keys() - {"version"})
    if name == "stack" and not OF_A_SIMULATION.isdisjoint(data):
        name = "simulation"  # which a stack file may hold, and `simulate` reads
    if not name:
        remedy = f"say it by 'kind:', one of {', '.join(KINDS)}"
        raise InputError(Problem(f"nothing in this file tells what it is; {remedy}", "", file, 1, 1))
    return KINDS[name]


def _nearest(keys: Any) -> str:
    """Return the name of the kind whose fields most of the keys resemble; empty when none does."""
    near = {
        name: sum(bool(get_close_matches(str(key), kind.fields, 1, _CLOSE)) for key in keys)
        for name, kind in KINDS.items()
    }
    best = max(near, key=lambda name: near[name])
    return best if near[best] else ""
