"""Laws of the YAML door over arbitrary data and arbitrary text."""

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from multilayer.config import dump_yaml, parse_yaml
from multilayer.errors import InputError

FILE = Path("any.yaml")

LOOKALIKES = st.sampled_from(
    [
        "no",
        "null",
        "1e3",
        "0x1F",
        "1:30",
        "1_0",
        ".inf",
        "<<",
        "---",
        "...",
        "*a",
        "&a",
        "!a",
        *"~=#%@'\"\\µ😀-?|>,[]{}",
    ]
)
SPACED = st.sampled_from(
    ["", " ", " a", "a ", "a  b", "- a", "a: b", "a #b", "\n", "a\nb", "\t", "\r\n", "\x85", "\u2028", "\x00"]
)
TEXT = st.text() | LOOKALIKES | SPACED | st.text(alphabet="ab \n'\"\\:#-", max_size=200)
SCALARS = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | TEXT
DATA = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(TEXT, inner, max_size=5),
    max_leaves=20,
)
MARKUP = st.text(alphabet="ab01.e:,-?[]{}!&*#|>'\"%@`<~\\xU \n\t", max_size=60)


def refused(text):
    try:
        parse_yaml(text, FILE)
    except InputError as error:
        return error.problems
    return []


def same(a, b):
    """Equality that tells 1 from 1.0 from True and 0.0 from -0.0."""
    if type(a) is not type(b):
        return False
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list):
        return len(a) == len(b) and all(map(same, a, b))
    return repr(a) == repr(b)


@settings(deadline=None)
@given(DATA)
def test_data_dumped_and_parsed_is_the_same_data(data):
    assert same(parse_yaml(dump_yaml(data), FILE).data, data)


@settings(deadline=None)
@given(DATA)
def test_a_yaml_1_1_reader_sees_the_same_data(data):
    assert same(yaml.safe_load(dump_yaml(data)), data)


@settings(deadline=None)
@given(DATA)
def test_every_value_has_a_place_in_the_text(data):
    text = dump_yaml(data)
    document = parse_yaml(text, FILE)
    for line, column in document.places.values():
        assert 1 <= line <= text.count("\n") + 1
        assert column >= 1
    assert set(document.key_places) == {path for path in document.places if path and isinstance(path[-1], str)}


@settings(deadline=None, max_examples=300)
@given(st.text() | MARKUP)
def test_text_is_read_or_refused_with_a_place(text):
    problems = refused(text)
    assert all(problem.file == FILE for problem in problems)
    assert all(problem.message == "is empty" or problem.line >= 1 <= problem.column for problem in problems)


@pytest.mark.parametrize("value", [1e16, 1e-5, 0.1, -0.0, 5e-324, 1.7976931348623157e308, 3.0, math.inf])
def test_a_float_is_dumped_in_full_and_read_back_as_a_float(value):
    read = parse_yaml(dump_yaml({"x": value}), FILE).data["x"]
    assert type(read) is float
    assert repr(read) == repr(value)


@pytest.mark.parametrize("text", ["no", "1e3", "1:30", "2020-01-01", "<<", "=", "0o17", "0777", "null", "", "1_000"])
def test_text_that_any_yaml_reader_takes_for_something_else_is_quoted(text):
    assert dump_yaml([text]) in (f"['{text}']\n", f'["{text}"]\n')


def test_a_layer_is_dumped_on_one_line_in_its_order():
    layer = {"type": "fluid", "thickness": "1 mm", "density": 1.2}
    assert dump_yaml({"layers": [layer]}) == "layers:\n- {type: fluid, thickness: 1 mm, density: 1.2}\n"


def test_shared_data_is_written_out():
    shared = [1, 2]
    assert dump_yaml({"a": shared, "b": shared}) == "a: [1, 2]\nb: [1, 2]\n"


@pytest.mark.parametrize("data", [{1: "a"}, {"a": {1, 2}}, [b"x"], 1j, Path("x"), {"a": object()}])
def test_only_plain_data_is_dumped(data):
    with pytest.raises(TypeError, match=r"plain data|text"):
        dump_yaml(data)


def test_numpy_scalars_are_no_plain_data():
    with pytest.raises(TypeError, match="float64"):
        dump_yaml([np.float64(1.0)])
