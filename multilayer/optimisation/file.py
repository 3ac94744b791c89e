"""An optimisation file: a simulation, what of it may vary, what is wanted, and within which limits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import islice, product
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import (
    BeforeValidator,
    Field,
    GetJsonSchemaHandler,
    ModelWrapValidatorHandler,
    PrivateAttr,
    ValidationInfo,
    model_validator,
)

from multilayer.config.validate import read
from multilayer.errors import InputError
from multilayer.json_schema import QUANTITY_TEXT, Written, model_schema
from multilayer.models import NO_BOOL, Model, refuse
from multilayer.optimisation.aims import SIZES, Aim, Catalogue, Goal, Limit, Mistake, Setting, goal_of, limit_of
from multilayer.optimisation.design import AMONG, Space, Variant, space_of
from multilayer.optimisation.predict import size_of
from multilayer.simulation.bands import grid_of
from multilayer.simulation.file import SimulatedStack, SimulationFile
from multilayer.stack import lets_through

_TRIED = 64  # combinations of choices, for one that is allowed
_END = {"type": ["number", "string"], "pattern": QUANTITY_TEXT}
_NAMES = {"type": "array", "items": {"type": ["string", "integer"]}}
_DESIGN = Written({
    "type": "object",
    "minProperties": 1,
    "properties": {"order": _NAMES, "optional": _NAMES},
    "additionalProperties": {
        "anyOf": [
            {"type": "array", "items": _END, "minItems": 2, "maxItems": 2},
            {
                "type": "object",
                "properties": {"among": {"type": "array", "minItems": 1}},
                "required": ["among"],
                "additionalProperties": False,
            },
        ]
    },
})  # fmt: skip


_GOALS = Written(
    lambda handler: {"anyOf": [_of_a_goal(handler), {"type": "array", "items": _of_a_goal(handler), "minItems": 1}]}
)


def _of_a_goal(handler: GetJsonSchemaHandler) -> dict[str, Any]:
    return model_schema(Goal, handler)


def _listed(value: Any) -> Any:
    return [value] if isinstance(value, Mapping) else value


class SearchSettings(Model):
    """Effort of the search: descents that are begun for each goal, and the seed of where they begin."""

    starts: Annotated[int, Field(ge=1, le=1000), NO_BOOL] = 8
    seed: Annotated[int, Field(ge=0), NO_BOOL] = 0


class OptimisationFile(SimulatedStack):
    """A simulation, and the search of the best one; read one with `load_optimisation`.

    Attributes
    ----------
    design : mapping
        By path, two bounds or ``{among: [...]}``; `order` and `optional` name layers that may change places, and that
        may be left out.
    goal : tuple of Goal
        Several give a Pareto front.
    limits : tuple of Limit
    catalogue : mapping
        What materials and layers weigh and cost, by name.
    search : SearchSettings
    """

    design: Annotated[dict[str, Any], Field(min_length=1), _DESIGN]
    goal: Annotated[tuple[Goal, ...], Field(min_length=1, max_length=4), BeforeValidator(_listed), _GOALS]
    limits: tuple[Limit, ...] = ()
    catalogue: dict[str, Catalogue] = Field(default_factory=dict)
    search: SearchSettings = SearchSettings()

    _space: Space = PrivateAttr()
    _goals: tuple[Aim, ...] = PrivateAttr(default=())
    _bounds: tuple[Aim, ...] = PrivateAttr(default=())

    @model_validator(mode="wrap")
    @classmethod
    def _resolve(cls, data: Any, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo) -> Self:
        model = handler(data)
        if isinstance(data, Mapping):
            folder = Path((info.context or {}).get("folder", Path()))
            refuse(model, model._resolved(data, folder))
        return model

    def _resolved(self, data: Mapping[str, Any], folder: Path) -> list[Mistake]:
        """Read design, goals and limits against the rest of the file; return what is wrong with them."""
        own = OptimisationFile.model_fields.keys() - SimulatedStack.model_fields.keys()
        plain = {key: value for key, value in data.items() if key not in own}
        if self.reference is not None:
            plain["reference"] = self.reference
        validated = partial(SimulationFile.model_validate, context={"folder": folder})
        self._space, mistakes = space_of(data["design"], plain, validated(plain), validated)
        chosen = None if mistakes else self._space.choices.get("termination")
        mistakes += self._read_aims(folder, chosen or (self.termination,))
        return mistakes or [*self._unknown_sizes()]

    def _read_aims(self, folder: Path, terminations: Sequence[Any]) -> list[Mistake]:
        """Read goals and limits against each termination that a design may have; return what is wrong with them.

        What is wrong with some terminations alone is told where these are chosen.
        """
        of_each: list[list[Mistake]] = []
        for termination in terminations:
            mistakes: list[Mistake] = []
            setting = Setting(grid_of(self.frequency), lets_through(termination), self.reference is not None, folder)
            self._goals = tuple(aim for i, goal in enumerate(self.goal) for aim in goal_of(goal, i, setting, mistakes))
            self._bounds = tuple(
                aim for i, limit in enumerate(self.limits) for aim in limit_of(limit, i, setting, mistakes)
            )
            of_each.append(mistakes)
        common = [one for one in of_each[0] if all(one in mistakes for mistakes in of_each)]
        found = [*common]
        for i, (termination, mistakes) in enumerate(zip(terminations, of_each, strict=True)):
            texts = dict.fromkeys(one[1] for one in mistakes if one not in common)
            found += [(("design", "termination", AMONG, i), text, termination) for text in texts]
        return found

    def _unknown_sizes(self) -> Iterator[Mistake]:
        """Give goals and limits of sizes that some material does not tell."""
        sized = [aim for aim in (*self._goals, *self._bounds) if aim.name in SIZES]
        for variant in self._with_each_choice() if sized else ():
            for aim in sized:
                try:
                    size_of(aim.name, variant.stack, variant, self.catalogue)
                except InputError as error:
                    yield aim.place, str(error), None
                    return

    def _with_each_choice(self) -> Iterator[Variant]:
        """Give a variant of each choice, where one is allowed."""
        axes = self._space.axes
        for axis, n in enumerate(axes or (1,)):
            for j in range(n):
                keys = product(*((j,) if i == axis else range(m) for i, m in enumerate(axes)))
                variants = map(self._space.allowed, islice(keys, _TRIED))
                yield from islice((variant for variant in variants if variant is not None), 1)

    @property
    def space(self) -> Space:
        """All designs."""
        return self._space

    @property
    def goals(self) -> tuple[Aim, ...]:
        """What is wanted."""
        return self._goals

    @property
    def bounds(self) -> tuple[Aim, ...]:
        """What must be kept."""
        return self._bounds


def load_optimisation(path: str | Path) -> OptimisationFile:
    """Read an optimisation file.

    Parameters
    ----------
    path : path
        A YAML file as described in ``docs/tasks/optimise.md``.

    Raises
    ------
    InputError
        With every mistake in the file, each with its line and column.
    """
    file = Path(path)
    return read(file, OptimisationFile, "optimisation", context={"folder": file.parent})
