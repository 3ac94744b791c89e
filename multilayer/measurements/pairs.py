"""Base and top of a long recording, in m/s2, from the channels of a file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError
from multilayer.measurements.accelerometers import acceleration_factor, parse_sensitivity, voltage_factor
from multilayer.signals.channels import Channel, Channels, refuse_other_starts

ROLES = ("base", "top")


@dataclass(frozen=True)
class ChannelChoice:
    """Which channels are base and top, and the units of their numbers.

    Attributes
    ----------
    names : mapping
        Name of the channel by role, ``base`` and ``top``.
    sensitivities : mapping
        V per m/s2 by role, where a channel holds voltages.
    units : mapping
        By role, where the file states none: what the number 1 is, as ``V``, ``10 V`` or ``m/s2``.
    sampling_rate : float or None
        Hz, where the file does not say.
    """

    names: Mapping[str, str] = field(default_factory=lambda: {role: role for role in ROLES})
    sensitivities: Mapping[str, float] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    sampling_rate: float | None = None


@dataclass(frozen=True, eq=False)
class Pair:
    """Accelerations of base and top over one file, m/s2, shape (n_samples,), and their sampling rate, Hz."""

    file: Path
    base: RealArray
    top: RealArray
    sampling_rate: float


def parse_sensitivities(texts: Iterable[str]) -> dict[str, float]:
    """Return sensitivities, V per m/s2, by role, from text as ``base=10.2mV/g``.

    Raises
    ------
    InputError
        With every mistake.
    """
    sensitivities: dict[str, float] = {}
    problems: list[str] = []
    for role, text in _by_role(texts, "--sensitivity", "base=10.2mV/g").items():
        try:
            sensitivities[role] = parse_sensitivity(text)
        except ValueError as error:
            problems.append(f"--sensitivity {role}: {error}")
    if problems:
        raise InputError(problems)
    return sensitivities


def parse_units(texts: Iterable[str]) -> dict[str, str]:
    """Return units by role from text as ``base=V``; each must be a voltage or an acceleration.

    Raises
    ------
    InputError
    """
    units = _by_role(texts, "--unit", "base=V")
    for role, unit in units.items():
        if acceleration_factor(unit) is None and voltage_factor(unit) is None:
            raise InputError(f"--unit {role}: '{unit}' is no voltage and no acceleration; write V, '10 V', g or m/s2")
    return units


def _by_role(texts: Iterable[str], option: str, example: str) -> dict[str, str]:
    values: dict[str, str] = {}
    for text in texts:
        role, equals, value = (part.strip() for part in text.partition("="))
        if not equals or role not in ROLES or not value:
            raise InputError(f"{option}: '{text}' does not give base or top a value; write {option} {example}")
        if role in values:
            raise InputError(f"{option}: {role} is given twice")
        values[role] = value
    return values


def pair_of(channels: Channels, choice: ChannelChoice) -> Pair:
    """Return base and top of a file.

    Parameters
    ----------
    channels : Channels
    choice : ChannelChoice

    Raises
    ------
    InputError
        When a channel is missing, both roles have the same channel, a unit or a sensitivity is missing or they
        contradict each other, the channels differ in rate, length or start, no rate is known, or a sample is not
        finite.
    """
    if choice.names["base"].casefold() == choice.names["top"].casefold():
        raise InputError(f"--base and --top both name '{choice.names['base']}'; they are two channels")
    chosen = {role: channels[choice.names[role]] for role in ROLES}
    base, top = (_accelerations(channels, role, chosen[role], choice) for role in ROLES)
    return Pair(channels.file, base, top, _rate(channels, chosen["base"], chosen["top"], choice.sampling_rate))


def _rate(channels: Channels, base: Channel, top: Channel, given: float | None) -> float:
    if base.samples.size != top.samples.size or base.sampling_rate != top.sampling_rate:
        raise channels.error(f"base and top must be sampled together, but they are {base} and {top}")
    refuse_other_starts(channels, (base, top))
    rate = base.sampling_rate
    if rate is None and given is None:
        raise channels.error("does not say its sampling rate; give it with --rate, in Hz")
    if rate is not None and given is not None and abs(rate / given - 1.0) > 1e-4:
        raise channels.error(f"says that it is sampled at {rate:g} Hz, but --rate says {given:g} Hz; leave --rate out")
    return float(rate if rate is not None else given or 0.0)


def _accelerations(channels: Channels, role: str, channel: Channel, choice: ChannelChoice) -> RealArray:
    bad = int(np.sum(~np.isfinite(channel.samples)))
    if bad:
        raise channels.error(f"channel '{channel.name}' holds {bad} samples that are not finite; export it again")
    return channel.samples * _factor(channels, role, channel, choice)


def _factor(channels: Channels, role: str, channel: Channel, choice: ChannelChoice) -> float:
    """Return the factor from the numbers of a channel to m/s2."""
    unit = _unit(channels, role, channel, choice.units.get(role))
    sensitivity = choice.sensitivities.get(role)
    acceleration, volts = acceleration_factor(unit), voltage_factor(unit)
    called = f"channel '{channel.name}' ({role}) is in {unit}"
    if acceleration is not None:
        if sensitivity is not None:
            text = "an acceleration already, and a sensitivity would convert it twice"
            raise channels.error(f"{called}, {text}; leave out --sensitivity {role}")
        return acceleration
    if volts is None:
        raise channels.error(f"{called}, neither a voltage nor an acceleration; choose another, or say --unit {role}=V")
    if sensitivity is None:
        raise channels.error(f"{called}; say what that is in m/s2, as --sensitivity {role}=10.2mV/g")
    return volts / sensitivity


def _unit(channels: Channels, role: str, channel: Channel, given: str | None) -> str:
    stated = channel.unit
    understood = stated is not None and (acceleration_factor(stated) is not None or voltage_factor(stated) is not None)
    if stated is not None and understood and given is not None:
        text = f"channel '{channel.name}' says that it is in {stated}"
        raise channels.error(f"{text}, but --unit {role} says {given}; leave --unit {role} out")
    if stated is None and given is None:
        text = f"channel '{channel.name}' ({role}) has no unit"
        raise channels.error(f"{text}; say what 1 is with --unit, as --unit {role}=V, '{role}=10 V' or {role}=m/s2")
    return given or stated or ""
