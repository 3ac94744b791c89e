"""``multilayer shape-factor``."""

import json

import pytest

from tests.cli.command import run

DYNAMIC = ("--frequency", "100 Hz,1 kHz", "--density", "80 kg/m^3", "--young-modulus", "200 kPa")
SIZE = ("--radius", "22.5 mm", "--thickness", "25 mm")


def test_the_table_of_static_factors():
    done = run("shape-factor", "--poisson-ratio", "0.3", "--shape", "0.5,1")
    assert done.status == 0
    assert "1.1186" in done.out
    assert "1.2107" in done.out


def test_dynamic_factors_as_json():
    done = run("shape-factor", "--poisson-ratio", "0.3", *SIZE, *DYNAMIC, "--json")
    found = json.loads(done.out)
    assert found["frequency_hz"] == [100.0, 1000.0]
    (row,) = found["factors"]
    assert row["storage"][0] == pytest.approx(1.1034, rel=1e-3)
    assert row["loss"][1] > 0


def test_a_dynamic_factor_needs_a_sample():
    done = run("shape-factor", "--poisson-ratio", "0.3", *DYNAMIC)
    assert (done.status, done.out) == (2, "")
    assert "--radius: is missing" in done.err


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("--poisson-ratio", "0.5"), "below 0.5"),
        (("--poisson-ratio", "much"), "--poisson-ratio"),
        (("--shape", "-1"), "above 0"),
        ((*SIZE, *DYNAMIC, "--poisson-ratio", "0.3", "--frequency", "100 kg"), "--frequency"),
        (("--radius", "1 mm,2 mm", "--thickness", "1 mm"), "one value is wanted"),
    ],
)
def test_bad_input_gets_one_line(arguments, word):
    done = run("shape-factor", *arguments)
    assert done.status == 2
    assert word in done.err
    assert len(done.err.strip().splitlines()) == 1
