"""Units at the doors: what may be written, the SI number it becomes, and what is refused."""

import math
import subprocess
import sys
import time
from typing import Annotated

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from multilayer.units import (
    Acceleration,
    Density,
    FlowResistivity,
    Frequency,
    Length,
    Porosity,
    Pressure,
    Ratio,
    Temperature,
    Unit,
    UnitLabel,
    Viscosity,
    parse_complex_quantity,
    parse_quantity,
)


def field(kind, value):
    return TypeAdapter(kind).validate_python(value)


def refusal(kind, value):
    with pytest.raises(ValidationError) as caught:
        field(kind, value)
    (error,) = caught.value.errors()
    return error["msg"]


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        (Length, "50 mm", 0.05),
        (Length, "50mm", 0.05),
        (Length, " 50  mm ", 0.05),
        (Length, "1 µm", 1e-6),  # micro sign
        (Length, "1 μm", 1e-6),  # Greek mu
        (Length, "1 um", 1e-6),
        (Length, "1e3", 1e3),
        (Length, ".5", 0.5),
        (Length, "1e-3 km", 1.0),
        (Length, 2, 2.0),
        (Pressure, "70 GPa", 70e9),
        (Pressure, "1 kPa", 1e3),
        (Pressure, "1 N/mm^2", 1e6),
        (Temperature, "20 degC", 293.15),
        (Temperature, "20 °C", 293.15),
        (Temperature, "-10 degC", 263.15),
        (Temperature, "68 degF", 293.15),
        (Temperature, "293.15 K", 293.15),
        (Ratio, "98 %", 0.98),
        (Ratio, "98%", 0.98),
        (Porosity, "98 %", 0.98),
        (FlowResistivity, "15 kN s/m^4", 15e3),
        (FlowResistivity, "15 kN·s/m⁴", 15e3),
        (FlowResistivity, "15000 N.s.m-4", 15e3),
        (FlowResistivity, "15000 N s m^-4", 15e3),
        (FlowResistivity, "15 kPa s/m2", 15e3),
        (Density, "2.7 g/cm^3", 2700.0),
        (Density, "2700 kg/m3", 2700.0),
        (Density, "2700 kg/m³", 2700.0),
        (Density, "2700 kg/m**3", 2700.0),
        (Viscosity, "18.4 uPa s", 18.4e-6),
        (Frequency, "1 kHz", 1e3),
        (Frequency, "5 1/s", 5.0),
        (Acceleration, "1 g_0", 9.80665),
        (Acceleration, "5 m/s2", 5.0),
    ],
)
def test_text_with_a_unit_becomes_an_si_number(kind, text, value):
    read = field(kind, text)
    assert type(read) is float
    assert read == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("kind", "value", "words"),
    [
        (Length, "50 Pa", "'50 Pa' has the wrong unit: this is a quantity in m, as 0.05 or '50 mm'"),
        (Length, "50 mmm", "'mmm' in '50 mmm' is no unit known here; write 0.05 or '50 mm'"),
        (Length, "1,5 mm", "decimals follow a point"),
        (Length, "1,250 mm", "decimals follow a point, '1.250 mm', and thousands have no mark, '1250 mm'"),
        (Length, "1,250,000 um", "decimals follow a point, as in '1.5', and thousands have no mark, '1250000 um'"),
        (Length, "50 + 3 mm", "is no unit known here"),
        (Length, "1 2 mm", "is no unit known here"),
        (Length, "thick", "'thick' is no number in m; write 0.05 or '50 mm'"),
        (Length, "", "'' is no number in m"),
        (Length, "1_000", "is no unit known here"),
        (Length, "nan", "is no number"),
        (Length, "inf", "is no number"),
        (Length, math.nan, "nan is not finite"),
        (Length, math.inf, "inf is not finite"),
        (Length, "1e999 mm", "'1e999 mm' is not finite"),
        (Length, 10**400, "is not finite"),
        (Length, True, "True is no number in m"),
        (Length, None, "an empty value is no number in m"),
        (Length, [1], "[1] is no number in m"),
        (Length, 1 + 2j, "is no number in m"),
        (Ratio, "0.98 m", "wrong unit: this is a pure number"),
    ],
)
def test_what_is_no_quantity_of_the_field_is_refused_in_words(kind, value, words):
    assert words in refusal(kind, value)


@pytest.mark.parametrize(
    ("kind", "value"), [(Length, "-1 mm"), (Length, 0), (Temperature, "-300 degC"), (Porosity, "100 %")]
)
def test_bounds_hold_for_the_si_number(kind, value):
    assert "should be" in refusal(kind, value)


@pytest.mark.parametrize("text", ["6.28 rad/s", "60 rpm", "5 turn/s"])
def test_an_angular_frequency_is_no_frequency(text):
    assert "wrong unit" in refusal(Frequency, text)


@pytest.mark.parametrize("text", ["3 dB", "1 Np", "10 deg", "1 rad"])
def test_a_level_or_an_angle_is_no_ratio(text):
    assert "wrong unit" in refusal(Ratio, text)


@pytest.mark.parametrize("text", ["5 %", "-5 %", "0 %"])
def test_a_share_is_no_level(text):
    with pytest.raises(ValueError, match="wrong unit"):
        parse_quantity(text, "dB")


@pytest.mark.parametrize("text", ["3", "3 dB", "3dB"])
def test_levels(text):
    assert parse_quantity(text, "dB") == 3


def test_an_angle_keeps_its_unit():
    assert parse_quantity("1 rad", "degree") == pytest.approx(180 / math.pi)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1.2e5+2e4j Pa", 1.2e5 + 2e4j),
        ("1.2e5 + 2e4j Pa", 1.2e5 + 2e4j),
        ("1.2e+5-2e-4i", 1.2e5 - 2e-4j),
        ("(1+2j) kPa", 1e3 + 2e3j),
        ("2j MPa", 2e6j),
        ("1+j", 1 + 1j),
        ("-1-2i Pa", -1 - 2j),
        ("120 kPa", 120e3),
        ("1e5", 1e5),
        (5, 5.0),
        (1 + 2j, 1 + 2j),
    ],
)
def test_a_complex_quantity(text, value):
    read = parse_complex_quantity(text, "Pa")
    assert read == pytest.approx(value, rel=1e-14)
    assert isinstance(read, complex) == isinstance(value, complex)


@pytest.mark.parametrize("value", ["1+2j mm", "1+2j+3j", "1+2jk", "1 + 2", True, None, "j+1", "i Pi"])
def test_what_is_no_complex_quantity_is_refused(value):
    with pytest.raises(ValueError, match="Pa"):
        parse_complex_quantity(value, "Pa")


@settings(deadline=None)
@given(st.complex_numbers(min_magnitude=1e-8, max_magnitude=1e17))
def test_a_complex_number_survives_being_written(number):
    text = f"{number.real!r}{number.imag:+}j Pa"
    assert parse_complex_quantity(text, "Pa") == number


@settings(deadline=None)
@given(st.floats(1e-12, 1e6) | st.floats(-1e6, -1e-12) | st.just(0.0))
def test_a_number_survives_being_written(number):
    assert parse_quantity(repr(number), "m") == number
    assert parse_quantity(f"{number!r} m", "m") == number


@settings(deadline=None)
@given(st.text() | st.text(alphabet="0123456789.eE+-jmPa ^*/()%°²"))
def test_text_is_a_quantity_or_a_value_error(text):
    for parse in (parse_quantity, parse_complex_quantity):
        try:
            number = parse(text, "Pa")
        except ValueError:
            continue
        assert isinstance(number, float | complex)


@pytest.mark.parametrize(
    "text",
    [
        "1 m**9**9**9**9",
        "1 m^(9**9**9)",
        "1 (m^9)^9",
        "1 m²²²²²²²²²",
        "1 " + "a" * 100_000,
        "1 mm" + " " * 10**6 + "x",
        "1 " + "(" * 10_000,
        "1 __import__('os')",
    ],
    ids=range(8),
)
def test_a_unit_is_no_program(text):
    start = time.perf_counter()
    message = refusal(Length, text)
    assert time.perf_counter() - start < 1
    assert ("is no unit known here" in message) != ("is too long for a number" in message)
    assert len(message) < 300


def test_a_field_type_tells_its_unit():
    assert [label.symbol for label in Length.__metadata__ if isinstance(label, UnitLabel)] == ["m"]


def test_pint_is_loaded_only_for_text_with_a_unit():
    code = (
        "import sys\n"
        "from multilayer.units import parse_quantity\n"
        "parse_quantity(1, 'm'), parse_quantity('1e3', 'm')\n"
        "assert 'pint' not in sys.modules\n"
        "parse_quantity('1 mm', 'm')\n"
        "assert 'pint' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("written", "symbol"), [("kg/m3", "kg/m^3"), ("N s/m4", "N s/m^4"), ("m²", "m^2"), ("°", "degree")]
)
def test_the_unit_of_a_field_may_be_written_as_in_a_file(written, symbol):
    assert (Unit(written), UnitLabel(written)) == (Unit(symbol), UnitLabel(symbol))
    assert field(Annotated[float, Unit(written)], f"2 {written}") == 2.0
    assert refusal(Annotated[float, Unit(written)], "2 A").startswith(
        f"'2 A' has the wrong unit: this is a quantity in {symbol},"
    )
