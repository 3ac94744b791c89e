"""The laws that every effect keeps: `check_effect`."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.effects.base import BaseEffect, Effect
from multilayer.diagnosis.effects.levels import LevelEffect
from multilayer.diagnosis.effects.tube import TubeEffect
from multilayer.experiments.levels.problem import LevelProblem
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.experiments.two_plate.effects import Chain
from multilayer.inference.priors import Parameter
from multilayer.testing.benches import bench
from multilayer.testing.broken import broken_laws

_TINY, _TINIER, _USUAL = -6.0, -9.0, 0.0  # standard normal coordinates of an effect's parameters
_INVISIBLE = 0.02  # of ln(ratio), of R, or of 25 dB: what an effect of next to no size may do,
_NOTHING, _FALLS = 0.002, 0.5  # and what it may do without falling so far on the way to an even smaller one
_SAME = 1e-10
_SAMPLE = (80.0, 0.025, 0.01)  # density, thickness and mass of the plate on it
_FAR = 1e4  # standard normal coordinates: a gap drags unknowns off by hundreds


def check_effect(effect: BaseEffect | type[BaseEffect]) -> None:
    """Check that an effect keeps the laws of a diagnosis.

    The laws: it states its name, its law, what separates it and a source for its prior; parameters have priors and
    distinct names; it vanishes as its parameters become small, or at the values in `absent`; at their usual size it
    changes something that it does not change then; responses stay finite there, and far out of the priors become NaN at
    worst, without an exception; a batch of parameters gives the same as single ones, over frequencies and
    configurations; its arguments are not changed in place; a finer law of it keeps all these, and has the same
    parameters and more.

    Parameters
    ----------
    effect : BaseEffect or its class
        One of the two-plate rig (`Effect`), of a tube (`TubeEffect`) or of levels (`LevelEffect`).

    Raises
    ------
    AssertionError
        With every law that is broken, one per line.

    Examples
    --------
    >>> from multilayer.diagnosis.effects.sensor_mass import SensorMass
    >>> check_effect(SensorMass)
    """
    subject = effect() if isinstance(effect, type) else effect
    if broken := broken_laws(_LAWS, subject):
        raise AssertionError("\n".join(broken))


def _says_what_it_is(effect: BaseEffect) -> Iterator[str]:
    for field in ("name", "law", "separated_by", "source"):
        if not str(getattr(effect, field, "")).strip():
            yield f"the class needs a '{field}'"
    names = [parameter.name for parameter in effect.parameters]
    if len(set(names)) < len(names):
        yield f"parameters of one name: {names}"
    if any(parameter.prior.kind == "fixed" for parameter in effect.parameters):
        yield "a parameter that is fixed is no parameter"
    if strangers := set(effect.size_errors) - set(names):
        yield f"size_errors of what is no parameter: {sorted(strangers)}"


def _vanishes(effect: BaseEffect) -> Iterator[str]:
    if not _is_tried(effect):
        return
    unit = bench(effect).unit
    change, closer = (np.max(np.abs(_without(effect, size) - _nominal(effect))) for size in (_TINY, _TINIER))
    names = [p.name for p in effect.parameters if p.prior.kind != "normal" and p.name not in effect.absent]
    remedy = (
        "; where the prior ends before the effect does, or it vanishes at another value than the smallest, the class "
        f"says at which: absent = {{'{(names or [effect.parameters[0].name])[0]}': 0.0}}"
    )
    if not change < _INVISIBLE * unit:
        yield f"with parameters of next to no size the response still changes by {change:.2g}{remedy}"
    elif not closer <= max(_FALLS * change, _NOTHING * unit):
        yield (
            f"with parameters of next to no size the response still changes by {change:.2g}, and with smaller ones by "
            f"{closer:.2g}{remedy}"
        )


def _without(effect: BaseEffect, size: float = _TINY) -> ComplexArray:
    """Return the `_logs` with parameters of next to no size."""
    return _logs(effect, np.array([_absent(effect, parameter, size) for parameter in effect.parameters]))


def _absent(effect: BaseEffect, parameter: Parameter, size: float) -> float:
    if parameter.name in effect.absent:
        return float(parameter.prior.coordinate(effect.absent[parameter.name]))
    return 0.0 if parameter.prior.kind == "normal" else size


def _acts(effect: BaseEffect) -> Iterator[str]:
    if not _is_tried(effect):
        return
    usual = np.array([1.0 if parameter.prior.kind == "normal" else _USUAL for parameter in effect.parameters])
    responses = _logs(effect, usual)
    if not np.all(np.isfinite(responses)):
        yield "at its usual size the response is not finite"
    elif not np.max(np.abs(responses - _without(effect))) > 1e-6:
        yield "at its usual size it changes nothing"


def _ends_in_nan(effect: BaseEffect) -> Iterator[str]:
    if not _is_tried(effect):
        return
    for far in (-_FAR, _FAR):
        for which in (*np.eye(len(effect.parameters)), np.ones(len(effect.parameters))):
            try:
                _logs(effect, far * which)
            except Exception as error:
                yield f"at coordinates {far * which} of its priors: {type(error).__name__}: {error}"


def _batches(effect: BaseEffect) -> Iterator[str]:
    if not _is_tried(effect):
        return
    points = np.linspace(-1, 1, 3)[:, None] * np.ones(len(effect.parameters))
    together = _logs(effect, points)
    apart = np.stack([_logs(effect, point) for point in points])
    if together.shape != apart.shape:
        yield f"a batch of parameters gives the shape {together.shape}, one by one {apart.shape}"
    elif not np.max(np.abs(together - apart)) < _SAME:
        yield "a batch of parameters gives other responses than one by one"


def _leaves_its_input_alone(effect: BaseEffect) -> Iterator[str]:
    hypothesis = bench(effect)
    values: dict[str, RealArray] = {p.name: np.asarray(p.prior.value(np.zeros((1, 1)))) for p in effect.parameters}
    given: ComplexArray = np.full((1, len(hypothesis.data[0].frequency)), 0.5 + 0.1j)
    kept, copies = given.copy(), {name: value.copy() for name, value in values.items()}
    if isinstance(effect, TubeEffect) and isinstance(hypothesis, StackProblem):
        setting = hypothesis.settings[0]
        effect.surface(setting, effect.stack(setting, setting.stack, values), given, values)
        effect.reading(setting, given, values)
    elif isinstance(effect, LevelEffect) and isinstance(hypothesis, LevelProblem):
        level, setting_of_level = given.real, hypothesis.settings[0]
        effect.stack(setting_of_level.at_waves, setting_of_level.stack, values)
        effect.sound_field(setting_of_level, setting_of_level.sound, values)
        effect.beside(setting_of_level, setting_of_level.stack, level, values)
        effect.reading(setting_of_level, level, values)
    elif isinstance(effect, Effect) and isinstance(hypothesis, CampaignProblem):
        effect.modulus(hypothesis.settings[0], given, values)
        effect.chain(hypothesis.settings[0], Chain(given, *_SAMPLE), values)
        effect.motion(hypothesis.settings[0], given, values)
    if not np.array_equal(given, kept):
        yield "an array it was given is changed in place"
    if values.keys() != copies.keys() or not all(np.array_equal(values[name], copies[name]) for name in copies):
        yield "the values of its parameters are changed in place"


def _refines(effect: BaseEffect) -> Iterator[str]:
    finer = effect.finer()
    if finer is None:
        return
    known = effect.parameters
    if finer.name != effect.name or finer.parameters[: len(known)] != known:
        yield "the finer law needs the name and the parameters of this one, and its further ones behind them"
    yield from (f"of the finer law, {text}" for text in broken_laws(_LAWS, finer))


def _is_tried(effect: BaseEffect) -> bool:
    """Tell whether the effect has sizes to try, and needs nothing heavy for it."""
    return bool(effect.parameters) and not (isinstance(effect, Effect) and effect.needs_finite_elements)


_LAWS: tuple[Callable[[BaseEffect], Iterator[str]], ...] = (
    _says_what_it_is,
    _vanishes,
    _acts,
    _ends_in_nan,
    _batches,
    _leaves_its_input_alone,
    _refines,
)


def _logs(effect: BaseEffect, coordinates: RealArray) -> ComplexArray:
    """Return modelled minus measured of all configurations side by side, shape (..., n)."""
    nominal = bench(effect)
    start = np.zeros((*coordinates.shape[:-1], len(nominal.parameters)))
    return np.concatenate(
        nominal.with_effects(effect).differences(np.concatenate([start, coordinates], axis=-1)), axis=-1
    )


def _nominal(effect: BaseEffect) -> ComplexArray:
    nominal = bench(effect)
    return np.concatenate(nominal.differences(np.zeros(len(nominal.parameters))), axis=-1)
