"""A simulation file: a stack and the settings of its simulation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import (
    Field,
    ModelWrapValidatorHandler,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from multilayer.bounds import SAMPLES
from multilayer.config.validate import read
from multilayer.errors import InputError
from multilayer.models import NO_BOOL, as_mistakes, refuse
from multilayer.paths import locate, unit_of
from multilayer.response.construction import Construction
from multilayer.response.duct import unfit_lining
from multilayer.simulation.bands import grid_of
from multilayer.simulation.settings import (
    DiffuseIncidence,
    Duct,
    Excitation,
    FiniteSize,
    FrequencyGrid,
    FrequencyRange,
    Incidence,
    PlaneIncidence,
)
from multilayer.simulation.sweep import expand, mistakes, set_twice, texts
from multilayer.simulation.tolerances import Tolerance, parse_tolerance
from multilayer.stack import Stack, StackField

Reference = StackField


@dataclass(frozen=True)
class Case:
    """One combination of swept values.

    Attributes
    ----------
    values : mapping
        The swept value by path; empty without a sweep.
    simulation : SimulationFile
        The file with these values, and without a sweep.
    shown : mapping
        The values as text, by path without ``layers.``: numbers with the unit of their field.
    """

    values: Mapping[str, Any]
    simulation: SimulationFile
    shown: Mapping[str, str] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The values as text, as ``foam.thickness = 10 mm``; no two cases of a sweep have the same."""
        return ", ".join(f"{path} = {value}" for path, value in self.shown.items())


class SimulatedStack(Stack):
    """A stack, and in which field it is: what all files have that ask for its response."""

    frequency: FrequencyGrid = FrequencyRange()
    incidence: Incidence = PlaneIncidence()
    finite_size: FiniteSize | None = None
    reference: Reference | None = None

    def implausible(self) -> Iterator[tuple[tuple[str | int, ...], str]]:
        """Give path and text of values that are allowed, and hardly ever meant."""
        yield from super().implausible()
        if "termination" not in self.model_fields_set:
            yield (), "no termination is stated: a rigid wall is assumed, without transmission; say rigid or ambient"

    @model_validator(mode="after")
    def _lets_sound_through(self) -> Self:
        for stack, which in ((self, "this stack"), (self.reference, "the reference")):
            if self.reference is not None and stack is not None and not stack.lets_through:
                text = f"an insertion loss needs a half-space behind {which}; write 'termination: ambient' there"
                refuse(self, [(("reference",), text, None)])
        return self

    @property
    def stack(self) -> Stack:
        """The stack alone."""
        return Stack(**{name: getattr(self, name) for name in Stack.model_fields})


class SimulationFile(SimulatedStack, Construction):
    """A stack, what lies beside it, and the settings of its simulation; see ``docs/simulation.md``.

    Read one with `load_simulation`.
    """

    excitation: Excitation | None = None
    free_waves: bool = False
    layer_losses: bool = False
    duct: Duct | None = None
    sweep: dict[str, Annotated[tuple[Any, ...], Field(min_length=1)]] = Field(default_factory=dict)
    tolerances: dict[str, Any] = Field(default_factory=dict)
    samples: Annotated[int, Field(ge=2, le=SAMPLES.usual), NO_BOOL] = 200
    seed: Annotated[int, Field(ge=0), NO_BOOL] = 0

    _cases: tuple[Case, ...] = PrivateAttr(default=())
    _scatter: dict[str, Tolerance] = PrivateAttr(default_factory=dict)

    @model_validator(mode="wrap")
    @classmethod
    def _expand(cls, data: Any, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo) -> Self:
        swept = data.get("sweep") if isinstance(data, Mapping) else None
        if not swept:
            model = handler(data)
            model._scatter = model._parsed_tolerances()
            model._cases = model._cases or (Case({}, model),)
            return model
        single = {key: value for key, value in data.items() if key != "sweep"}

        def validated(changed: Any) -> SimulationFile:
            return cls.model_validate(changed, context=info.context)

        try:
            model, reported = handler(data), []
            model._scatter = model._parsed_tolerances()
        except ValidationError as error:
            reported = error.errors(include_url=False)
        wrong = [*as_mistakes(reported), *mistakes(single, swept, validated, reported)]
        if wrong:
            raise ValidationError.from_exception_data(cls.__name__, wrong)
        read_once = single if model.reference is None else {**single, "reference": model.reference}
        model._cases = _cases(model.sweep, expand(read_once, model.sweep, validated))
        return model

    def implausible(self) -> Iterator[tuple[tuple[str | int, ...], str]]:
        """Give path and text of values that are allowed, and hardly ever meant."""
        yield from super().implausible()
        swept = {path.partition(".")[0] for path in self.sweep}
        if not self.beside and "beside" not in swept and (self.area is not None or "area" in swept):
            place = ("sweep", "area") if self.area is None else ("area",)
            yield place, "changes nothing, as nothing lies beside the stack; list that in 'beside', or leave it out"
        if partly := grid_of(self.frequency).partly_filled:
            centres = ", ".join(f"{centre:g}" for centre in partly)
            remedy = "from 89.1 Hz to 5.62 kHz all from 100 Hz to 5 kHz are filled"
            yield ("frequency",), f"fills the third octaves of {centres} Hz in part, so no rating has them; {remedy}"

    @model_validator(mode="after")
    def _is_of_a_stack_alone(self) -> Self:
        asked = [key for key in ("excitation", "free_waves", "layer_losses", "duct") if getattr(self, key)]
        if asked and (self.beside or self.links):
            text = "is computed of a stack alone; leave it out, or 'beside' and 'links'"
            refuse(self, [((asked[0],), text, None)])
        if self.layer_losses and isinstance(self.incidence, DiffuseIncidence):
            text = "are computed of one plane wave; leave it out, or give 'incidence' an angle"
            refuse(self, [(("layer_losses",), text, None)])
        if self.duct is not None and (lack := unfit_lining(self)):
            refuse(self, [(("duct",), lack, None)])
        return self

    def _parsed_tolerances(self) -> dict[str, Tolerance]:
        stack, tolerances = self.stack, dict[str, Tolerance]()
        wrong: list[tuple[tuple[str, ...], str, Any]] = []
        for path, written in self.tolerances.items():
            try:
                found = locate(stack, path)
            except InputError as error:
                wrong.append((("tolerances", path, "[key]"), str(error), path))
                continue
            try:
                tolerances[path] = parse_tolerance(written, found)
            except InputError as error:
                wrong.append((("tolerances", path), str(error), written))
        wrong += [(("tolerances", path, "[key]"), text, path) for path, text in set_twice(stack, tolerances)]
        refuse(self, wrong)
        return tolerances

    @property
    def cases(self) -> tuple[Case, ...]:
        """Every combination of swept values, in the order of the file; one case without a sweep."""
        return self._cases

    @property
    def scatter(self) -> Mapping[str, Tolerance]:
        """Tolerances by path."""
        return self._scatter

    @property
    def stack(self) -> Stack:
        """The stack alone; a `Construction` where something lies beside it."""
        kind = Stack if self.is_plain else Construction
        return kind(**{name: getattr(self, name) for name in kind.model_fields})


def _cases(
    sweep: Mapping[str, Sequence[Any]], expanded: Sequence[tuple[Mapping[str, Any], SimulationFile]]
) -> tuple[Case, ...]:
    """Return the cases of a sweep, in the order of `expand`, with their values as text."""
    first = expanded[0][1]  # a path leads to fields of one unit in all of them
    shown = product(*(texts(values, unit_of(first, path)) for path, values in sweep.items()))
    names = [path.removeprefix("layers.") for path in sweep]
    return tuple(
        Case(values, simulation, dict(zip(names, told, strict=True)))
        for (values, simulation), told in zip(expanded, shown, strict=True)
    )


def load_simulation(path: str | Path) -> SimulationFile:
    """Read a simulation file, or a stack file, which is simulated with the default settings.

    Parameters
    ----------
    path : path
        A YAML file as described in ``docs/simulation.md``.

    Raises
    ------
    InputError
        With every mistake in the file, each with its line and column.
    """
    file = Path(path)
    return read(file, SimulationFile, "simulation", context={"folder": file.parent})
