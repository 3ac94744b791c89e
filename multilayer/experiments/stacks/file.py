"""A stack-fit file: stacks, what was measured of them, and what is unknown; see ``docs/stack-fit.md``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol, Self

import numpy as np
from pydantic import ConfigDict, Field, PrivateAttr, ValidationInfo, model_validator

from multilayer.arrays import RealArray
from multilayer.config.kinds import FIT_FILE, read_fit_file
from multilayer.config.validate import validate
from multilayer.config.yaml12 import Document
from multilayer.errors import MultilayerError, suggest
from multilayer.experiments.stacks.field_priors import MistakeError
from multilayer.experiments.stacks.measurements import Measurement, MeasurementField
from multilayer.experiments.stacks.observations import Observation, observe
from multilayer.experiments.stacks.unknowns import Target, Unknown, UnknownFile, resolve
from multilayer.models import NO_BOOL, Model, refuse
from multilayer.simulation.file import Reference
from multilayer.stack import Stack

NOMINAL = "nominal"  # what the only stack is called
Mistake = tuple[tuple[str | int, ...], str, Any]


class Observed(Protocol):
    """A measurement with its data: the name of its stack, and frequencies."""

    @property
    def stack(self) -> str:
        """Name of the stack."""

    @property
    def frequency(self) -> RealArray:
        """Hz, shape (n,)."""


class SearchSettings(Model):
    """Effort of the search for minima."""

    candidates: Annotated[int, Field(ge=1, le=100_000), NO_BOOL] = 256
    starts: Annotated[int, Field(ge=1, le=1000), NO_BOOL] = 8
    seed: Annotated[int, Field(ge=0), NO_BOOL] = 0


class StackFitFile(Model):
    """Stacks, measurements and unknowns; read one with `load_stack_fit`.

    Attributes
    ----------
    nominal : Stack, optional
        The only stack.
    stacks : mapping
        Several stacks by name, instead; files are relative to this file.
    measurements : tuple of Measurement
    unknowns : mapping
        By the path of a field, or by a name of the author's choice.
    search : SearchSettings
    """

    model_config = ConfigDict(json_schema_extra={"oneOf": [{"required": ["nominal"]}, {"required": ["stacks"]}]})

    version: Literal[1] = 1
    nominal: Reference | None = None
    stacks: dict[str, Reference] = Field(default_factory=dict)
    measurements: Annotated[tuple[MeasurementField, ...], Field(min_length=1)]
    unknowns: Annotated[dict[str, UnknownFile], Field(min_length=1)]
    search: SearchSettings = SearchSettings()

    _observations: tuple[Observed, ...] = PrivateAttr(default=())
    _resolved: tuple[Unknown, ...] = PrivateAttr(default=())

    @model_validator(mode="after")
    def _complete(self, info: ValidationInfo) -> Self:
        refuse(self, self._wrong_stacks())
        refuse(self, self._wrong_names())
        mistakes: list[Mistake] = []
        self._observations = tuple(self._observed(Path((info.context or {}).get("folder", Path())), mistakes))
        if not mistakes:  # the range of a law's parameters follows from the data
            self._resolved = tuple(self._resolve_unknowns(mistakes))
            mistakes += self._overlapping_fields()
        refuse(self, mistakes)
        return self

    def implausible(self) -> Iterator[tuple[tuple[str | int, ...], str]]:
        """Give path and text of what is allowed, and hardly ever meant."""
        for i, measurement in enumerate(self.measurements):
            for field, text in measurement.implausible():
                yield ("measurements", i, field), text
            if measurement.file is not None and (twin := self._twin_before(i)):
                text = f"holds the same values as '{twin}': data given twice count twice; remove one of the two"
                yield ("measurements", i, "file"), text

    def _twin_before(self, index: int) -> str:
        """Return the name of an earlier measurement of the same kind with the same values; empty without one."""
        every = self.observations
        data = every[index]
        twins = (
            other.name
            for other in every[:index]
            if other.kind == data.kind
            and np.array_equal(other.frequency, data.frequency)
            and np.array_equal(other.measured, data.measured)
        )
        return next(twins, "")

    def _wrong_stacks(self) -> Iterator[Mistake]:
        if (self.nominal is None) == (not self.stacks):
            yield (), "give the stack as 'nominal: FILE', or several as 'stacks: {NAME: FILE}'", None
        for name in self.stacks:
            if "." in name or name in Stack.model_fields:
                yield (
                    ("stacks", name, "[key]"),
                    "paths start with it: it must hold no '.' and be no key of a stack",
                    name,
                )

    def _wrong_names(self) -> Iterator[Mistake]:
        names, stacks = self._names(), self.by_name
        for i, (name, measurement) in enumerate(zip(names, self.measurements, strict=True)):
            place = ("measurements", i)
            if names.index(name) < i:
                yield (*place, "name"), f"another measurement is called '{name}'; give each a 'name'", name
            if measurement.stack is None and len(stacks) > 1:
                yield place, f"stack: of which stack? {suggest('', stacks)}", None
            if measurement.stack is not None and measurement.stack not in stacks:
                text = f"there is no such stack; {suggest(measurement.stack, stacks)}"
                yield (*place, "stack"), text, measurement.stack
        is_stack_missing = any(measurement.stack not in stacks for measurement in self.measurements) and len(stacks) > 1
        for name in (
            sorted(set(stacks) - {self._stack_of(m) for m in self.measurements}) if not is_stack_missing else ()
        ):
            yield ("stacks", name), "no measurement is of this stack; remove it", name

    def _names(self) -> list[str]:
        return [measurement.name or self._default_name(measurement) for measurement in self.measurements]

    def _default_name(self, measurement: Measurement) -> str:
        return (
            measurement.default_name if measurement.stack is None else f"{measurement.default_name} {measurement.stack}"
        )

    def _stack_of(self, measurement: Measurement) -> str:
        return measurement.stack or next(iter(self.by_name))

    def _observed(self, folder: Path, mistakes: list[Mistake]) -> Iterator[Observed]:
        for i, (name, measurement) in enumerate(zip(self._names(), self.measurements, strict=True)):
            stack = self._stack_of(measurement)
            try:
                yield self._observe(measurement, name, stack, folder)
            except MultilayerError as error:
                hint = "; the path is relative to this file" if "no such file" in str(error) else ""
                field = "file" if measurement.file is not None else "layer"
                mistakes.append((("measurements", i, field), f"{error}{hint}", str(measurement.file)))

    def _observe(self, measurement: Measurement, name: str, stack: str, folder: Path) -> Observed:
        """Return a measurement with its data; subclasses that read it otherwise override this."""
        return observe(measurement, name, stack, self.by_name[stack], folder)

    def _resolve_unknowns(self, mistakes: list[Mistake]) -> Iterator[Unknown]:
        measured = {name: [o.frequency for o in self._observations if o.stack == name] for name in self.by_name}
        frequencies = {name: np.concatenate(parts) for name, parts in measured.items()}
        for name, entry in self.unknowns.items():
            try:
                yield resolve(name, entry, self.by_name, frequencies)
            except MistakeError as error:
                mistakes.append((("unknowns", name, *error.place), error.text, error.value))

    def _overlapping_fields(self) -> Iterator[Mistake]:
        taken: dict[Target, str] = {}
        for unknown in self._resolved:
            for stack, path in unknown.targets:
                for (other_stack, other), name in taken.items():
                    same = f"{path}.".startswith(f"{other}.") or f"{other}.".startswith(f"{path}.")
                    if stack == other_stack and same:
                        text = f"{path} is that of '{name}' already; one of the two must go"
                        yield ("unknowns", unknown.name, "[key]"), text, path
            taken |= dict.fromkeys(unknown.targets, unknown.name)

    @property
    def by_name(self) -> Mapping[str, Stack]:
        """The stacks, the only one as ``nominal``."""
        return self.stacks if self.nominal is None else {NOMINAL: self.nominal}

    @property
    def observations(self) -> tuple[Observation, ...]:
        """The measurements with their data."""
        return tuple(observed for observed in self._observations if isinstance(observed, Observation))

    @property
    def resolved(self) -> tuple[Unknown, ...]:
        """The unknowns with their fields."""
        return self._resolved


def load_stack_fit(source: str | Path | Document) -> StackFitFile:
    """Read a stack-fit file, its stacks and its measurements.

    Parameters
    ----------
    source : path or Document
        A YAML file, or a folder that holds one as ``fit.yaml``, or what it holds.

    Raises
    ------
    InputError
        With every mistake found, each with its line and column.
    """
    document = read_fit_file(source)
    return validate(document, StackFitFile, "stack-fit", context={"folder": document.file.parent})


def name_of(source: Path) -> str:
    """Return the name of a fit: that of its file, or of its folder where the file has the usual name."""
    if source.is_dir():
        return source.resolve().name
    return source.resolve().parent.name if source.name == FIT_FILE else source.stem
