"""A document against a model: which mistakes are told, in which words, and where."""

from pathlib import Path
from typing import Annotated, Any, Literal

import pytest
from pydantic import BaseModel, Field, ValidationInfo, field_validator, model_validator

from multilayer.config import parse_yaml, read
from multilayer.config.validate import validate
from multilayer.errors import InputError
from multilayer.models import Model
from multilayer.units import Length, Porosity, Temperature

FILE = Path("stack.yaml")


class Slab(Model):
    type: Literal["slab"]
    thickness: Length
    porosity: Porosity = 0.5


class Sheet(Model):
    type: Literal["sheet"]
    thickness: Length
    count: int = 1
    flag: bool = False
    name: str = ""


class Ambient(Model):
    temperature: Temperature = 293.15


class Panel(Model):
    version: Literal[1]
    layers: Annotated[list[Annotated[Slab | Sheet, Field(discriminator="type")]], Field(min_length=1)]
    ambient: Ambient = Ambient()
    either: float | Ambient = 1.0
    range: tuple[float, float] = (0.0, 1.0)
    extra: dict[str, Length] | None = None

    @model_validator(mode="after")
    def _range_increases(self):
        if self.range[1] <= self.range[0]:
            raise ValueError("range must increase")
        return self


def mistakes(text, model: Any = Panel):
    with pytest.raises(InputError) as caught:
        validate(parse_yaml(text, FILE), model)
    problems = caught.value.problems
    assert all(problem.file == FILE for problem in problems)
    return {(problem.line, problem.column, problem.path): problem.message for problem in problems}


HEAD = "version: 1\nlayers:\n- {type: slab, thickness: 1 mm}\n"


def test_a_good_file_becomes_the_model():
    panel = validate(parse_yaml(HEAD + "ambient: {temperature: 20 degC}\n", FILE), Panel)
    assert panel.layers == [Slab(type="slab", thickness=1e-3)]
    assert panel.ambient.temperature == pytest.approx(293.15, rel=1e-15)


def test_every_mistake_is_told_with_its_place_in_the_order_of_the_file():
    text = """\
layers:
- type: slab
  thickness: -1 mm
  porosty: 0.9
- {type: sheet, count: 1.5, flag: maybe, name: 5}
- {type: shet}
- {thickness: 1}
- 5
ambient: {temperature: 50 Pa}
colour: red
"""
    found = mistakes(text)
    assert list(found) == sorted(found)
    expected = {
        (1, 1, "version"): "is missing",
        (3, 14, "layers.0.thickness"): "-0.001 is not allowed: it must be above 0",
        (4, 3, "layers.0.porosty"): "did you mean 'porosity'?",
        (5, 3, "layers.1.thickness"): "is missing",
        (5, 24, "layers.1.count"): "must be a whole number, not 1.5",
        (5, 35, "layers.1.flag"): "must be true or false, not 'maybe'",
        (5, 48, "layers.1.name"): "must be text, in quotes, not 5",
        (6, 3, "layers.2"): "'shet' is not allowed as 'type'; allowed: 'slab', 'sheet'",
        (7, 3, "layers.3"): "has no 'type'",
        (8, 3, "layers.4"): "must be a mapping of fields, not 5",
        (9, 24, "ambient.temperature"): "'50 Pa' has the wrong unit",
        (10, 1, "colour"): "there is no such field; allowed: ambient, either, extra, layers, range, version",
    }
    assert set(found) == set(expected)
    for place, words in expected.items():
        assert words in found[place]


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        (HEAD + "extra: {a: 1 Pa}\n", (4, 12, "extra.a"), "wrong unit"),
        (HEAD + "range: [1]\n", (4, 8, "range.1"), "is missing"),
        (HEAD + "range: 5\n", (4, 8, "range"), "must be a list, not 5"),
        (HEAD + "range: [2, 1]\n", (1, 1, ""), "range must increase"),
        (HEAD + "ambient:\n", (4, 9, "ambient"), "not an empty value"),
        (HEAD + "either: {temperature: -1}\n", (4, 23, "either.temperature"), "above 0"),
        ("version: 1\nlayers: []\n", (2, 9, "layers"), "must not be empty"),
        ("version: 1\nlayers: {}\n", (2, 9, "layers"), "must be a list"),
        (HEAD.replace("1", "2", 1), (1, 10, "version"), "2 is not allowed; allowed: 1"),
        (HEAD.replace("1", "'1'", 1), (1, 10, "version"), "'1' is not allowed; allowed: 1"),
    ],
)
def test_a_mistake_stands_where_the_user_wrote_it(text, place, words):
    assert words in mistakes(text)[place]


def test_a_mistake_in_aliased_data_is_placed_at_the_data():
    text = "version: 1\nlayers:\n- &a {type: slab, thickness: 0}\n- *a\n"
    assert set(mistakes(text)) == {(3, 30, "layers.0.thickness"), (3, 30, "layers.1.thickness")}


def test_names_of_validators_and_tags_do_not_reach_the_user():
    class Outer(Model):
        panel: Annotated[Panel | None, Field()] = None

    found = mistakes("panel: {version: 1, layers: [{type: slab}], either: x}", Outer)
    assert {path for _, _, path in found} == {"panel.layers.0.thickness", "panel.either"}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("- a\n- b\n", "must hold fields, 'name: value', not ['a', 'b']"),
        ("version:1", "space after each ':'"),
        ("5", "not 5"),
        ("null", "not an empty value"),
    ],
)
def test_a_file_that_holds_no_fields_is_told_so(text, words):
    ((place, message),) = mistakes(text).items()
    assert place == (1, 1, "")
    assert words in message


def test_long_values_are_cut_short_in_messages():
    (message,) = mistakes(HEAD + f"ambient: {'x' * 10_000}\n").values()
    assert len(message) < 200


def test_what_was_filled_in_by_a_validator_is_placed_at_what_asked_for_it():
    class Table(Model):
        values: list[Length]

        @model_validator(mode="before")
        @classmethod
        def _from_file(cls, data):
            return {"values": [*data["values"], -1, -2]}

    found = mistakes("values: [1]\n", Table)
    assert set(found) == {(1, 9, "values")}


def test_one_mistake_that_several_types_report_is_told_once():
    class Either(Model):
        values: list[int] | list[float]

    assert len(mistakes("values: {}\n", Either)) == 1
    with pytest.raises(InputError) as caught:
        validate(parse_yaml("values: {}\n", FILE), Either)
    assert len(caught.value.problems) == 1


def test_models_that_are_not_ours_are_served_too():
    class Plain(BaseModel):
        a: int
        b: int

    assert set(mistakes("a: x\n", Plain)) == {(1, 1, "b"), (1, 4, "a")}


def test_a_bad_key_is_placed_at_the_key():
    class Keys(Model):
        names: dict[Annotated[str, Field(max_length=3)], int]

    assert set(mistakes("names:\n  long: 1\n", Keys)) == {(2, 3, "names.long")}


def test_the_context_reaches_the_validators(tmp_path):
    class Scaled(Model):
        length: float

        @field_validator("length")
        @classmethod
        def _scale(cls, value: float, info: ValidationInfo) -> float:
            return value * info.context["scale"]

    file = tmp_path / "scaled.yaml"
    file.write_text("length: 2\n")
    assert read(file, Scaled, context={"scale": 3}).length == 6


def test_read_names_the_file(tmp_path):
    file = tmp_path / "panel.yaml"
    file.write_text("version: 1\n")
    with pytest.raises(InputError, match="layers: is missing") as caught:
        read(str(file), Panel)
    assert caught.value.problems[0].file == file


def test_too_few_entries_are_counted():
    class Table(Model):
        frequency: Annotated[tuple[Length, ...], Field(min_length=2)]

    assert mistakes("frequency: [1]", Table) == {(1, 12, "frequency"): "must have at least 2 entries"}
    assert set(mistakes("frequency: [1, -1]", Table)) == {(1, 16, "frequency.1")}
    assert set(mistakes("frequency: [-1]", Table)) == {(1, 12, "frequency"), (1, 13, "frequency.0")}
