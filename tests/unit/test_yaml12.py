"""YAML 1.2 text to plain data: the core schema, positions, and what is refused in which words."""

import math
import time
from pathlib import Path

import pytest

from multilayer.config import Document, parse_yaml, read_yaml
from multilayer.config import compose as compose_module
from multilayer.config.compose import compose
from multilayer.errors import InputError

FILE = Path("stack.yaml")


def data_of(text):
    return parse_yaml(text, FILE).data


def refusal(text):
    with pytest.raises(InputError) as caught:
        parse_yaml(text, FILE)
    return caught.value


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1),
        ("-12", -12),
        ("+5", 5),
        ("0777", 777),
        ("0o17", 15),
        ("0x1F", 31),
        ("1e4", 1e4),
        ("1E4", 1e4),
        ("1e-05", 1e-5),
        (".5", 0.5),
        ("5.", 5.0),
        ("-1.5e+3", -1500.0),
        (".inf", math.inf),
        ("-.Inf", -math.inf),
        ("true", True),
        ("True", True),
        ("TRUE", True),
        ("false", False),
        ("null", None),
        ("~", None),
        ("", None),
        ("no", "no"),
        ("yes", "yes"),
        ("on", "on"),
        ("tRUE", "tRUE"),
        ("1:30", "1:30"),
        ("1_000", "1_000"),
        ("0b1", "0b1"),
        ("2020-01-01", "2020-01-01"),
        ("1e", "1e"),
        ("50 mm", "50 mm"),
        ("'5'", "5"),
        ('"true"', "true"),
        ("''", ""),
        ("! 5", "5"),
        ("!!str 5", "5"),
        ("!!float 5", 5.0),
        ('!!int "5"', 5),
    ],
)
def test_a_scalar_is_what_the_core_schema_says(text, value):
    read = data_of(f"key: {text}")["key"]
    assert read == value
    assert type(read) is type(value)


def test_nan_is_a_number():
    assert math.isnan(data_of("a: .nan")["a"])


def test_a_number_as_a_key_becomes_its_text():
    assert data_of("{1: a, 1.5: b, 0x10: c}") == {"1": "a", "1.5": "b", "0x10": "c"}


def test_an_alias_is_the_same_data_but_no_shared_object():
    data = data_of("a: &x {b: [1, 2]}\nc: *x\n")
    assert data["a"] == data["c"] == {"b": [1, 2]}
    assert data["a"] is not data["c"]
    assert data["a"]["b"] is not data["c"]["b"]


STACK = """\
# a comment
version: 1
layers:
  - type: fluid
    thickness: 1 mm
  - {type: screen, name: "µ", mass: 2}
empty:
"""


@pytest.mark.parametrize(
    ("path", "value", "key"),
    [
        ((), (2, 1), (2, 1)),
        (("version",), (2, 10), (2, 1)),
        (("layers",), (4, 3), (3, 1)),
        (("layers", 0), (4, 5), (4, 5)),
        (("layers", 0, "thickness"), (5, 16), (5, 5)),
        (("layers", 1), (6, 5), (6, 5)),
        (("layers", 1, "mass"), (6, 37), (6, 31)),
        (("layers", 0, "porosity"), (4, 5), (4, 5)),  # the deepest ancestor
        (("layers", 0, "thickness", "unit"), (5, 16), (5, 16)),
        (("layers", 7, "type"), (4, 3), (4, 3)),
        (("nothing", "like", "it"), (2, 1), (2, 1)),
    ],
)
def test_every_value_and_key_knows_its_place(path, value, key):
    document = parse_yaml(STACK, FILE)
    assert document.position(path) == value
    assert document.key_position(path) == key


def test_data_without_places_is_placed_at_the_beginning():
    assert Document(FILE, {"a": 1}).position(("a",)) == (1, 1)


def test_windows_line_ends_and_a_byte_order_mark_do_not_shift_places(tmp_path):
    file = tmp_path / "a.yaml"
    file.write_bytes("\ufeffa: 1\r\nb: 2\r\n".encode())
    document = read_yaml(file)
    assert document.data == {"a": 1, "b": 2}
    assert document.position(("a",)) == (1, 4)
    assert document.position(("b",)) == (2, 4)


def test_a_duplicate_key_names_both_lines():
    (problem,) = refusal("layers:\n  - a: 1\n    b: 2\n    a: 3\n").problems
    assert (problem.line, problem.column, problem.path) == (4, 5, "layers.0.a")
    assert "line 2" in problem.message


@pytest.mark.parametrize("text", ["{a: 1, 'a': 2}", "{1: a, '1': b}", "{a: 1, ? a : 2}", "{a: 1, !!str a: 2}"])
def test_keys_of_the_same_text_are_duplicates_however_written(text):
    assert "second time" in str(refusal(text))


def test_all_that_is_refused_is_told_at_once_in_reading_order():
    text = "a: !foo 1\n<<: {b: 1}\n[1]: 2\nnull: !!python/name:os.system x\nd: {e: 1, e: 2}\n"
    problems = refusal(text).problems
    assert [(problem.line, problem.column) for problem in problems] == [
        (1, 4),
        (2, 1),
        (3, 1),
        (4, 1),
        (4, 7),
        (5, 11),
    ]
    for problem, word in zip(problems, ["'!foo'", "merge", "text", "null", "!!python/name", "second"], strict=True):
        assert word in problem.message
        assert problem.file == FILE


def test_what_an_alias_repeats_is_one_mistake():
    assert len(refusal("a: &x [!foo 1]\nb: *x\nc: *x\n").problems) == 1


@pytest.mark.parametrize(
    "tag",
    [
        "!!python/object/apply:os.system",
        "!!python/name:os.system",
        "!!binary",
        "!!set",
        "!!omap",
        "!!timestamp",
        "!!merge",
        "!foo",
        "!<tag:example.org,2000:x>",
    ],
)
@pytest.mark.parametrize("value", ["x", "[x]", "{x: 1}"])
def test_no_tag_constructs_anything(tag, value):
    (problem,) = refusal(f"key: {tag} {value}").problems
    assert "tag" in problem.message
    assert (problem.line, problem.column, problem.path) == (1, 6, "key")


def test_a_tag_prefix_cannot_smuggle_a_tag_in():
    assert "python" in str(refusal("%TAG ! tag:yaml.org,2002:python/\n---\na: !name:os.system x\n"))


@pytest.mark.parametrize(
    "value", ["!!int abc", "!!bool 1", "!!null x", "!!float x", "!!str [1]", "!!map x", "!!seq {}"]
)
def test_a_core_tag_must_fit_its_value(value):
    assert "does not fit" in str(refusal(f"a: {value}"))


def test_a_quoted_merge_key_is_plain_text():
    assert data_of("'<<': 1") == {"<<": 1}


def test_a_merge_key_comes_with_a_remedy():
    assert "write the fields out" in str(refusal("a: &x {b: 1}\nc:\n  <<: *x\n"))


@pytest.mark.parametrize("text", ["a: &a [*a]", "a: &a {b: {c: *a}}", "&a {*a : 1}", "&a [1, [2, *a]]"])
def test_recursive_data_is_refused(text):
    assert "hold itself" in str(refusal(text))


def test_exploding_aliases_are_refused_quickly():
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 40)]
    start = time.perf_counter()
    error = refusal("\n".join(lines))
    assert time.perf_counter() - start < 1
    assert "repeats by aliases counted are too many: at most 200 000 are taken" in str(error)


def test_ordinary_aliases_are_not_taken_for_an_explosion():
    data = data_of("a: &x {b: 1, c: 2}\nd: [" + "*x, " * 1000 + "]")
    assert data["d"] == [{"b": 1, "c": 2}] * 1000


@pytest.mark.parametrize("opening", ["[", "{a: ", "- ", "? "])
def test_deep_nesting_is_an_error_not_a_crash(opening):
    assert "nested" in str(refusal(opening * 10_000))


def test_a_long_file_is_not_a_deep_one():
    assert data_of("- [[1]]\n" * 200) == [[[1]]] * 200


@pytest.mark.parametrize(
    ("text", "line", "column", "words"),
    [
        ("a: 1\n---\nb: 2\n", 2, 1, "second document"),
        ("a:\n\tb: 1\n", 2, 1, "tab"),
        ("a:\t1\n", 1, 3, "tab"),
        ("a: 1\nb: @x\n", 2, 4, "'@'"),
        ("a: 1\nb: 'x\nc: 2\n", 2, 4, "quote is not closed"),
        ('a: "C:\\data"\n', 1, 8, "single quotes"),
        ('a: "\\U99999999"\n', 1, 7, "out of range"),
        ('a: "\\U00110000"\n', 1, 7, "out of range"),
        ("a: [1, 2\nb: 3\n", 2, 2, "opened in line 1 is not closed"),
        ("a:\n  b: 1\n c: 2\n", 3, 2, "indentation"),
        ("a: 1\nfoo\nb: 2\n", 2, 1, "':' is missing"),
        ("a: b: c\n", 1, 5, "quotes"),
        ("a: - 1\n", 1, 4, "line of its own"),
        ("a: *x\n", 1, 4, "'&x'"),
        ("a: &x 1\nb: &x 2\n", 2, 4, "line 1"),
        ("a: * 5\n", 1, 5, "in quotes"),
        ("a: !e!x 1\n", 1, 4, "'!e!'"),
        ("a: \x07\n", 1, 4, "U+0007"),
        ("a: 1\n\x00", 2, 1, "text file"),
        ("a: " + "9" * 5000, 1, 4, "digits"),
    ],
)
def test_a_mistake_is_told_in_plain_words_at_its_place(text, line, column, words):
    (problem,) = refusal(text).problems
    assert (problem.file, problem.line) == (FILE, line)
    assert problem.column == column
    assert words in problem.message
    assert str(problem).startswith(f"stack.yaml:{line}:{column}: ")


@pytest.mark.parametrize("text", ["", "\n\n", "# only a comment\n"])
def test_an_empty_file_is_said_to_be_empty(text):
    assert str(refusal(text)) == "stack.yaml: is empty"


def test_files_that_cannot_be_read_are_told_apart(tmp_path):
    latin = tmp_path / "latin.yaml"
    latin.write_bytes(b"a: 1\nb: caf\xe9\n")
    for path, words in [
        (tmp_path / "no.yaml", "no such file"),
        (tmp_path, "folder"),
        (latin, ":2:7: is no UTF-8"),
    ]:
        with pytest.raises(InputError, match=words) as caught:
            read_yaml(str(path))
        assert caught.value.problems[0].file == path
    with pytest.raises(InputError, match="cannot be read"):
        read_yaml("a\0b")


ODD = [
    "a: [1, 2", "a: 'x", "a:\n- b\n c", "a: \tb", "{?a: 1}", "a: &x 1\nb: &x 2", "a: *x", "&a [*a]", "[" * 65,
    "a: \x07", "%YAML 9", "a: !!python/x 1", '"\\UFFFFFFFF"', "a: 1\n---\nb", "!<tag:x> a", "a: |\n b\n\tc",
]  # fmt: skip


@pytest.mark.parametrize("text", [*ODD, *(file.read_text() for file in sorted(Path("examples").glob("*.yaml")))])
def test_without_libyaml_files_read_and_mistakes_are_worded_the_same(text, monkeypatch):
    def read():
        compose.cache_clear()
        try:
            document = parse_yaml(text, FILE, keep_problems=True)
        except InputError as error:
            return str(error)
        return document.data, document.places, document.key_places, document.problems

    assert compose_module._LIBYAML, "these tests need a PyYAML with libyaml"
    with_libyaml = read()
    monkeypatch.setattr(compose_module, "_LIBYAML", None)
    assert read() == with_libyaml
    compose.cache_clear()
