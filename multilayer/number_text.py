"""How numbers are written in tables."""

from __future__ import annotations

import math
import re

_PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
_WITH_PREFIX = re.compile(r"(?P<symbol>kg|s|m|Pa|N|Hz|V)(?P<rest>$|[ /].*)")
_POWERS = {"s": (-12, 0), "m": (-12, 0), "Hz": (0, 9), "g": (-9, 3)}  # nobody writes km, ks or mHz here
_PLAIN = (1e-3, 1e5)  # between these, a unit without prefix needs no power of ten
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def pressure_unit(largest: float) -> tuple[str, float]:
    """Return the unit to write pressures in, and its size in Pa, from the largest of them."""
    for unit, factor in (("GPa", 1e9), ("MPa", 1e6), ("kPa", 1e3)):
        if largest >= factor:
            return unit, factor
    return "Pa", 1.0


def over_unit(name: str, unit: str) -> str:
    """Return ``name / unit``, as axes and columns have it; the name alone without a unit."""
    return f"{name} / {unit}" if unit else name


def with_spread(value: float, spread: float) -> str:
    """Return ``value ± spread`` with two digits of the spread; the value alone when that is 0 or not finite."""
    if not math.isfinite(value):
        return "–"
    if not 0 < spread < float("inf"):
        return f"{value:.4g}"
    digits = max(0, 1 - int(f"{spread:e}".split("e")[1]))
    return f"{value:.{digits}f} ± {spread:.{digits}f}"


def significant(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits; powers of ten only where it is very large or small."""
    if not math.isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    if "e" not in text:
        return text
    mantissa, exponent = text.split("e")
    if -4 <= int(exponent) < 6:
        return f"{float(text):.0f}"
    return f"{mantissa}×10{_raised(exponent)}"


def percent(share: float) -> str:
    """Return a share in percent; a digit more where it is all but whole."""
    if not math.isfinite(share):
        return "–"
    digits = 1 if 0.99 < share < 0.9995 else 0
    return f"{round(100 * share, digits) + 0.0:.{digits}f} %"  # + 0: no minus before a zero


def readable_unit(value: float, unit: str) -> tuple[str, float]:
    """Return the unit to write a value in, and its size in `unit`, an SI unit: 0.0011 kg is written in g.

    A unit that takes no prefix, as 1/Pa, gets a power of ten where the value is far from 1.
    """
    unit = unit.replace("*", " ").replace("^", "")  # as pint writes it
    if not (math.isfinite(value) and value):
        return _pretty(unit), 1.0
    match = _WITH_PREFIX.fullmatch(unit)
    if match is None:
        if _PLAIN[0] <= abs(value) < _PLAIN[1]:
            return _pretty(unit), 1.0
        power = math.floor(math.log10(abs(value)))
        return f"×10{_raised(power)} {_pretty(unit)}".rstrip(), 10.0**power
    symbol, rest = match["symbol"], match["rest"]
    # the kilogram has a prefix already
    symbol, base = ("g", 1e-3) if symbol == "kg" else (symbol, 1.0)
    lowest, highest = _POWERS.get(symbol, (-12, 9))
    power = 3 * math.floor(math.log10(abs(value) / base * (1 + 1e-9)) / 3)
    power = min(max(power, lowest), highest)
    return f"{_PREFIXES[power]}{symbol}{_pretty(rest)}", base * 10.0**power


def plain_unit(value: float, unit: str) -> tuple[str, float]:
    """Return what `readable_unit` does for a number that stands beside its unit: without a power of ten before that."""
    symbol, factor = readable_unit(value, unit)
    return (symbol.partition(" ")[2], 1.0) if symbol.startswith("×") else (symbol, factor)


def with_unit(value: float, unit: str, digits: int = 3) -> str:
    """Return a value in a readable unit."""
    shown, factor = readable_unit(value, unit)
    number = significant(value / factor, digits)
    return f"{number}{shown}" if shown.startswith("×") else f"{number} {shown}".rstrip()


def with_interval(value: float, low: float, high: float, unit: str) -> str:
    """Return ``value (low to high) unit``, to two digits of half the interval."""
    if not (all(map(math.isfinite, (value, low, high))) and low < high):
        return with_unit(value, unit)
    either_sign = low < 0 < high
    shown, factor = readable_unit(max(value, -low, high) if either_sign else value, unit)
    scaled = [x / factor for x in (value, low, high)]
    spread = (scaled[2] - scaled[1]) / 2
    if spread > abs(scaled[0]) and not either_sign:  # over decades no number of decimals suits both ends
        texts = [significant(x, 2) for x in scaled]
    else:
        decimals = max(0, 1 - math.floor(math.log10(spread)))
        texts = [f"{x:z.{decimals}f}" for x in scaled]
    return f"{texts[0]} ({texts[1]} to {texts[2]}) {shown}".rstrip()


def _raised(exponent: int | str) -> str:
    return str(int(exponent)).translate(_SUPERSCRIPT)


def _pretty(unit: str) -> str:
    """Return a unit with raised exponents: ``N s/m4`` as ``N s/m⁴``."""
    return re.sub(r"(?<=[A-Za-z])\d", lambda match: match[0].translate(_SUPERSCRIPT), unit)
