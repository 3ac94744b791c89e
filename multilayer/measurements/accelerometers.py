"""Units of accelerations and voltages as data recorders write them, and sensitivities of accelerometers."""

from __future__ import annotations

import re

from multilayer.units import parse_quantity

_ACCELERATION, _VOLTAGE, _SENSITIVITY = "m/s^2", "V", "V*s^2/m"
_EXAMPLES = "'10.2 mV/g' or '1.04 mV/(m/s2)'"
# in pint, and in the SI, g is a gram and ms a millisecond
_GRAVITY = re.compile(r"(?<![\w.])(?:g|G|gn|g_n|gee)(?![\w])")
_METRES = re.compile(r"(?<!\w)m\s*/?\s*s(?:\^|\*\*)?(?:⁻²|-2)|(?<!\w)m/s/s(?!\w)|(?<!\w)m/sec\^?2(?!\w)")
_VOLTS = re.compile(r"(?<!\w)[Vv]olts?(?!\w)")


def _spelled(text: str) -> str:
    """Return a unit as pint takes it."""
    metres = _METRES.sub("(m/s^2)", text.strip())
    return _VOLTS.sub("V", _GRAVITY.sub("standard_gravity", metres))


def _factor(unit: str, wanted: str) -> float | None:
    try:
        scale = parse_quantity(_with_number(_spelled(unit)), wanted)
    except ValueError:
        return None
    return scale if scale > 0 else None


def _with_number(text: str) -> str:
    return text if text[:1].isdigit() or text[:1] == "." else f"1 {text}"


def acceleration_factor(unit: str) -> float | None:
    """Return the factor from a unit to m/s2, as 9.80665 for ``g``; None when it is no acceleration.

    A number may stand ahead of the unit, as ``50 g`` where 1 is full scale.
    """
    return _factor(unit, _ACCELERATION)


def acceleration_ratio(above: str, below: str) -> str | None:
    """Return the unit of one acceleration over another, as ``m/s^2`` over ``g``; None unless both are accelerations."""
    if acceleration_factor(above) is None or acceleration_factor(below) is None:
        return None
    return f"({_spelled(above)})/({_spelled(below)})"


def voltage_factor(unit: str) -> float | None:
    """Return the factor from a unit to V; None when it is no voltage. A number may stand ahead, as ``10 V``."""
    return _factor(unit, _VOLTAGE)


def parse_sensitivity(text: str) -> float:
    """Return the sensitivity of an accelerometer, V per m/s2, from text as ``10.2 mV/g``.

    Raises
    ------
    ValueError
        When it has no unit or another one, or is not above 0.
    """
    spelled = _spelled(text)
    number = re.match(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?", spelled)
    if number is None or number.end() == len(spelled):
        raise ValueError(f"'{text}' is no sensitivity with a unit; write one such as {_EXAMPLES}")
    try:
        value = parse_quantity(spelled, _SENSITIVITY)
    except ValueError:
        raise ValueError(f"'{text}' is no sensitivity of an accelerometer; write one such as {_EXAMPLES}") from None
    if not 0 < value < float("inf"):
        raise ValueError(f"a sensitivity of {text} is not allowed; it must be above 0, such as {_EXAMPLES}")
    return value
