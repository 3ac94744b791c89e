"""Bounds: told, raised by the environment, and listed in the manual as they are."""

import re
import sys
from pathlib import Path

import pytest

from multilayer.bounds import CASES, DATA_VALUES, FACTOR, MAGNITUDES, OF_OTHER_UNITS, SIZES, YAML_BYTES, Bound, counted
from multilayer.config.yaml12 import read_yaml
from multilayer.errors import InputError
from multilayer.paths import extremes
from multilayer.stack import Stack
from multilayer.units import parse_quantity

PAGE = (Path(__file__).parents[2] / "docs" / "limits.md").read_text(encoding="utf-8")


def rows(first):
    """Return the cells of the table whose head begins so."""
    table = PAGE.partition(f"| {first}")[2].partition("\n\n")[0]
    return [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in table.splitlines()[2:]]


def test_the_manual_lists_every_bound():
    told = [[b.of, counted(b.usual), "yes" if b.can_be_raised else "", b.why] for b in SIZES]
    assert rows("what") == told


def test_the_manual_lists_all_magnitudes():
    units = {**MAGNITUDES, "all others": OF_OTHER_UNITS}
    shown = {"": "pure numbers"}
    assert rows("unit") == [[shown.get(unit, unit), f"{m.least:g}", f"{m.most:g}", m.why] for unit, m in units.items()]


def test_a_factor_in_the_environment_raises_what_can_be_raised(monkeypatch):
    monkeypatch.setenv(FACTOR, "10")
    assert (DATA_VALUES.most, CASES.most) == (10 * DATA_VALUES.usual, CASES.usual)
    monkeypatch.setenv(FACTOR, "much")
    with pytest.raises(InputError, match="must be a number above 0, not 'much'"):
        DATA_VALUES.check(1)


def test_a_refusal_says_how_many_what_and_what_to_do():
    text = str(Bound(1000, "bricks", "", True).refusal(12345, Path("wall.yaml"), "build lower"))
    assert text == (
        "wall.yaml: 12 345 bricks are too many: at most 1 000 are taken; build lower; or "
        "MULTILAYER_BOUNDS_FACTOR=10 in the environment allows ten times as many"
    )


def test_a_file_that_is_too_large_is_not_read(monkeypatch, tmp_path):
    monkeypatch.setenv(FACTOR, "0.001")
    (tmp_path / "large.yaml").write_text("#" * 20_000)
    with pytest.raises(InputError, match=rf"10 001 {YAML_BYTES.of} are too many"):
        read_yaml(tmp_path / "large.yaml")


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such device")
def test_a_file_without_end_is_not_read():
    with pytest.raises(InputError, match="is a pipe or a device"):
        read_yaml("/dev/zero")


@pytest.mark.parametrize("unit", [*MAGNITUDES, "m^3/s"])
def test_numbers_far_from_anything_physical_are_refused(unit):
    known = MAGNITUDES.get(unit, OF_OTHER_UNITS)
    assert [parse_quantity(value, unit) for value in (0, known.least, -known.most)] == [0, known.least, -known.most]
    for value in (known.least / 2, -2 * known.most, 1e300):
        with pytest.raises(ValueError, match=re.escape(f"{value!r} is not allowed: it must be 0, or from")):
            parse_quantity(value, unit)


def test_the_most_extreme_field_comes_first():
    stack = Stack.model_validate({"layers": [{"type": "fluid", "thickness": 0.1}, {"type": "fluid", "thickness": 1e6}]})
    assert extremes(stack)[0][:2] == ("layers.1.thickness", "1e+06 m")
