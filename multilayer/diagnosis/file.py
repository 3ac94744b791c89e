"""A diagnosis file: a stack-fit file of measured tubes or levels, the effects to try, and the tube."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, PrivateAttr, ValidationInfo, model_validator

from multilayer.config.kinds import read_fit_file
from multilayer.config.validate import validate
from multilayer.config.yaml12 import Document
from multilayer.diagnosis.effects.base import EFFECTS, BaseEffect
from multilayer.diagnosis.effects.tube import Tube, TubeEffect, TubeSetting
from multilayer.diagnosis.levels.data import level_data
from multilayer.diagnosis.levels.uncertainty import Situation
from multilayer.diagnosis.tube.data import tube_data
from multilayer.errors import InputError, suggest
from multilayer.experiments.levels.effects import LevelEffect, acts_through_stack
from multilayer.experiments.levels.problem import LevelProblem
from multilayer.experiments.stacks.columns import read_values
from multilayer.experiments.stacks.file import Mistake, StackFitFile
from multilayer.experiments.stacks.measurements import (
    NOISE_ESTIMATED,
    Absorption,
    Measurement,
    Reflection,
    SurfaceImpedance,
    TransmissionLoss,
)
from multilayer.experiments.stacks.observations import Observation, scale_of
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.experiments.stacks.unknowns import placed
from multilayer.json_schema import Schema, Written
from multilayer.models import refuse
from multilayer.registry import RegistryError
from multilayer.simulation.warned import collected_warnings

_IS_REFERENCE = "is_reference"  # in the context of validation: of a file that another one names as its reference


def _as_list(value: Any) -> Any:
    return (value,) if isinstance(value, str) and value != "all" else value


class DiagnosisFile(StackFitFile):
    """A stack-fit file with effects; read one with `load_diagnosis`.

    Measurements are surface impedances and reflection coefficients of tubes, or transmission losses, or absorption
    coefficients: of one of these three kinds. Noise that is not stated is estimated, of levels by the standards.

    Attributes
    ----------
    effects : 'all' or tuple of str
    tube : Tube
    uncertainty : {'in_situ', 'repeatability', 'reproducibility'}
        Which standard deviations of ISO 12999 measured levels have where they state none.
    reference : Path, optional
        Another diagnosis file with the same unknowns, of measurements without any effect: their posterior is the prior
        of the unknowns.
    """

    effects: Annotated[
        Literal["all"] | tuple[str, ...], BeforeValidator(_as_list), Written(lambda _: _effects_written())
    ] = "all"
    tube: Tube = Tube()
    uncertainty: Situation = "in_situ"
    reference: Path | None = None

    _reference_file: DiagnosisFile | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _known_effects(self, info: ValidationInfo) -> Self:
        refuse(self, self._wrong_kinds())
        refuse(self, self._wrong_effects())
        refuse(self, self._wrong_reference(info.context or {}))
        return self

    def _wrong_kinds(self) -> Iterator[Mistake]:
        first = self.measurements[0]
        for i, measurement in enumerate(self.measurements):
            if _family(measurement) != _family(first):
                text = f"is diagnosed by itself; beside a {first.kind} put it into another file"
                yield ("measurements", i, "kind"), f"a {measurement.kind} {text}", measurement.kind

    @property
    def of_levels(self) -> bool:
        """Whether it is of transmission losses or absorption, not of a tube's reflection."""
        return isinstance(self.measurements[0], TransmissionLoss | Absorption)

    @property
    def effect_names(self) -> list[str]:
        """Names of the effects that there are for its measurements; a broken plugin is left out with a warning."""
        if not self.of_levels:
            return tube_names()
        of_absorption = isinstance(self.measurements[0], Absorption)
        return [name for name, kind in EFFECTS.working() if _is_of_levels(kind, of_absorption=of_absorption)]

    def _wrong_reference(self, context: Mapping[str, Any]) -> Iterator[Mistake]:
        if self.reference is None:
            return
        if context.get(_IS_REFERENCE, False):
            text = "a file that is a reference cannot have one itself; take it out there, or put both into one file"
            yield ("reference",), text, str(self.reference)
            return
        try:
            other = _load(Path(context.get("folder", Path())) / self.reference, is_reference=True)
        except InputError as error:
            yield ("reference",), str(error), str(self.reference)
            return
        if [u.parameters for u in other.resolved] != [u.parameters for u in self.resolved]:
            yield (
                ("reference",),
                "its unknowns are others; name the same ones, in the same order and with the same priors",
                None,
            )
        self._reference_file = other

    def with_reference(self, other: DiagnosisFile) -> DiagnosisFile:
        """Return this file with another file, of the same unknowns, as its reference."""
        file = self.model_copy()
        file._reference_file = other
        return file

    @property
    def reference_file(self) -> DiagnosisFile | None:
        """The reference's file, if there is one."""
        return self._reference_file

    def _wrong_effects(self) -> Iterator[Mistake]:
        for i, name in enumerate(self.effects if self.effects != "all" else ()):
            reason = _why_no_such_effect(name, self.effect_names, "levels" if self.of_levels else "a tube")
            if reason:
                yield ("effects", i), reason, name

    def _observe(self, measurement: Measurement, name: str, stack: str, folder: Path) -> Observation:
        nominal = self.by_name[stack]
        if isinstance(measurement, TransmissionLoss | Absorption):
            values = read_values(measurement, folder)
            levels = level_data(measurement, name, stack, nominal, values, self.uncertainty, self.tube)
            with collected_warnings():
                levels.response(nominal)  # raises for a stack that has no response at these frequencies
            return levels
        if not isinstance(measurement, SurfaceImpedance | Reflection):
            raise InputError(
                f"a diagnosis needs what waves do at a stack; of 'kind: {measurement.kind}' it makes nothing. Give a "
                "surface_impedance, a reflection, a transmission_loss or an absorption, or fit the file by "
                "'multilayer fit'"
            )
        data = tube_data(
            measurement, name, stack, scale_of(measurement, nominal), read_values(measurement, folder), self.tube
        )
        with collected_warnings():  # warnings are reported with the result
            # raises for a stack that has no response at these frequencies
            TubeSetting(name, data.frequency, data.angle, nominal, self.tube).reflection(nominal)
        return data

    @property
    def hypothesis(self) -> StackProblem:
        """The nominal model."""
        kind = LevelProblem if self.of_levels else StackProblem
        return kind(placed(self.by_name, self.resolved), self.resolved, self.observations, self.tube)

    def chosen(self, without: Sequence[str] = ()) -> dict[str, BaseEffect]:
        """Return the effects to try, by name; a broken plugin is left out of 'all' with a `PluginWarning`.

        Raises
        ------
        InputError
            When an effect to leave out does not exist.
        """
        for name in without:
            if name not in EFFECTS:
                raise InputError(f"there is no effect '{name}'; {suggest(name, EFFECTS.names())}")
        names = self.effect_names if self.effects == "all" else self.effects
        return {name: EFFECTS[name]() for name in names if name not in without}


def _family(measurement: Measurement) -> str:
    return measurement.quantity if isinstance(measurement, TransmissionLoss | Absorption) else "wave"


def _is_of_levels(kind: type[BaseEffect], *, of_absorption: bool) -> bool:
    if issubclass(kind, LevelEffect):
        return ("absorption" if of_absorption else "transmission_loss") in kind.quantities
    return of_absorption and acts_through_stack(kind())


def _effects_written() -> Schema:
    names = [name for name, kind in EFFECTS.working() if issubclass(kind, TubeEffect | LevelEffect)]
    return {"anyOf": [{"enum": ["all", *names]}, {"type": "array", "items": {"enum": names}}]}


def _why_no_such_effect(name: str, known: Sequence[str], what: str) -> str:
    if name not in EFFECTS:
        return f"there is no effect '{name}'; {suggest(name, EFFECTS.names())}"
    try:
        kind = EFFECTS[name]
    except RegistryError as error:
        return str(error)
    if name not in known:
        return f"'{name}' is an effect of the {kind.kind}; of {what} there are {', '.join(known)}"
    return ""


def tube_names() -> list[str]:
    """Return the names of all effects of tubes; a broken plugin is left out with a `PluginWarning`."""
    return [name for name, kind in EFFECTS.working() if issubclass(kind, TubeEffect)]


def load_diagnosis(source: str | Path | Document) -> DiagnosisFile:
    """Read a diagnosis file, its stacks and its measurements.

    Parameters
    ----------
    source : path or Document
        A YAML file, or a folder that holds one as ``fit.yaml``, or what it holds.

    Raises
    ------
    InputError
        With every mistake found, each with its line and column.
    """
    return _load(source)


def _load(source: str | Path | Document, *, is_reference: bool = False) -> DiagnosisFile:
    document = read_fit_file(source)
    context = {"folder": document.file.parent, NOISE_ESTIMATED: True, _IS_REFERENCE: is_reference}
    return validate(document, DiagnosisFile, "diagnose", context=context)


def diagnosis_file(folder: Path, **data: Any) -> DiagnosisFile:
    """Return a diagnosis file made in Python; its measurements lie in a folder.

    Raises
    ------
    ValidationError
        When it cannot be used.
    """
    return DiagnosisFile.model_validate(data, context={"folder": folder, NOISE_ESTIMATED: True})
