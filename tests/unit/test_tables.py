"""Marks within numbers of text tables: before decimals, or between thousands."""

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.tables import Header, read_text_table
from multilayer.text_lines import Layout, data_lines


def read(tmp_path, text):
    (tmp_path / "table.csv").write_text(text)
    return read_text_table(tmp_path / "table.csv")


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("a;b\n1,25;2\n1,5;3\n", [1.25, 1.5]),
        ("a;b\n1,250;2\n1,500;3\n", [1.25, 1.5]),  # all of a column as wide
        ("a;b\n1;2,5\n1,125;3\n", [1, 1.125]),  # decimals behind such a mark, and no zero at the end
        ("a,b\n1,2.5\n1.125,3\n", [1, 1.125]),
        ("a,b\n800,2\n1000,3\n1.125,4\n", [800, 1000, 1.125]),  # 1000 has no mark
        ("a,b\n0.5,2\n1,3\n1.250,4\n", [0.5, 1, 1.25]),
        ("a;b\n0,125;lot 2.1\n1;of 01.02.2024\n", [0.125, 1]),
    ],
)
def test_decimals(tmp_path, text, values):
    np.testing.assert_array_equal(read(tmp_path, text).numbers({0})[0], values)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a;b\n800;1\n1,000;2\n", r"3: '1,000' stands among whole numbers as '800': are these thousands, or decimals"),
        ("a;b\n800;1\n1,125;2\n", r"3: '1,125' stands .* Write '1125', or '1,1250' for decimals"),
        ("a,b\n800,1\n1.250,2\n", r"3: '1\.250' stands .* Write '1250', or '1\.2500' for decimals"),
        ("a;b\n800;0,5\n1,250;2\n", r"3: '1,250' stands among whole numbers"),
        ('a,b\n800,1\n"1,125",2\n', r"3: '1,125' is no number; write decimals with a point, and thousands without a "),
        ("a;b\n800;1\n1.250.000;2\n", r"3: '1\.250\.000' is no number; .* and thousands without a mark, '1250000'"),
    ],
)
def test_marks_between_thousands_are_refused(tmp_path, text, told):
    with pytest.raises(InputError, match=f"table.csv:{told}"):
        read(tmp_path, text).numbers({0, 1})


def test_units_that_no_suffix_tells_stand_in_brackets():
    for text, unit in (("ph", "radian"), ("z_re", "Pa*s/m")):
        with pytest.raises(ValueError, match=r"has no unit; write '") as error:
            Header.of(text).factor(unit)
        remedy = str(error.value).split("'")[-2]
        assert Header.of(remedy).factor(unit) == 1
        assert Header.of(remedy).name == text
    with pytest.raises(ValueError, match=r"column 'E1 \[-\]' holds no pure numbers; write its unit, as '\[Pa\]'"):
        Header.of("E1 [-]").factor("Pa")


@pytest.mark.parametrize(
    ("separator", "rows", "told"),
    [
        (";", "0.000;1,230\n0.001;1,231\n", r"1: '1,230' has a comma, and '0\.000' in line 1 a point; write decimals"),
        ("\t", "0\t1.5\n1\t2\n2\t1,250\n", r"3: '1,250' has a comma, and '1\.5' in line 1 a point"),
        (";", "0,000;1,230\n0,001;1,231\n", None),
        (";", "0.000;1.230\n0.001;1.231\n", None),
        (",", "0.000,1.230\n0.001,1.231\n", None),
    ],
)
def test_commas_in_recordings_with_points(tmp_path, separator, rows, told):
    file = tmp_path / "run.csv"
    file.write_text(rows)
    layout = Layout(separator, 0)
    if told is None:
        layout.refuse_two_marks(data_lines(file), file)
        return
    with pytest.raises(InputError, match=f"run.csv:{told}"):
        layout.refuse_two_marks(data_lines(file), file)
