"""The laws that every effect keeps: `check_effect`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.effects.base import Effect
from multilayer.diagnosis.hypothesis import Hypothesis
from multilayer.inverse.joint import ConfigurationData, JointProblem, law_space
from multilayer.inverse.priors import Parameter
from multilayer.inverse.rig import PlaneWaveRig
from multilayer.measurements.description import Campaign

_FREQUENCIES = (100.0, 200.0, 400.0, 800.0, 1500.0)
_MODULUS = 2e5 * (1 + 0.2j)
_TINY, _USUAL = -6.0, 0.0  # standard normal coordinates of an effect's parameters
_INVISIBLE = 0.02  # of ln(ratio): what an effect of next to no size may do
_SAME = 1e-10


def check_effect(effect: Effect | type[Effect]) -> None:
    """Check that an effect keeps the laws of a diagnosis.

    Says what it is (name, law, what separates it, a source for its prior); parameters have priors and own names;
    it vanishes as its parameters become small; it changes something at their usual size; motions stay finite; a batch
    of parameters gives what each gives alone, over frequencies and configurations; nothing it is given is changed in
    place.

    Parameters
    ----------
    effect : Effect or its class

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
    broken = [f"{law.__name__.strip('_')}: {text}" for law in _LAWS for text in law(subject)]
    assert not broken, "\n".join(broken)


def _says_what_it_is(effect: Effect) -> Iterator[str]:
    for field in ("name", "law", "separated_by", "source"):
        if not str(getattr(effect, field, "")).strip():
            yield f"the class needs a '{field}'"
    names = [parameter.name for parameter in effect.parameters]
    if len(set(names)) < len(names):
        yield f"parameters of one name: {names}"
    if any(parameter.prior.kind == "fixed" for parameter in effect.parameters):
        yield "a parameter that is fixed is no parameter"


def _vanishes(effect: Effect) -> Iterator[str]:
    if not effect.parameters or effect.needs_finite_elements:
        return
    tiny = np.array([_absent(effect, parameter) for parameter in effect.parameters])
    change = np.max(np.abs(_logs(effect, tiny) - _logs(None, np.empty(0))))
    if not change < _INVISIBLE:
        yield f"with parameters of next to no size the motion still changes by {change:.2g}"


def _absent(effect: Effect, parameter: Parameter) -> float:
    if parameter.name in effect.absent:
        return float(parameter.prior.coordinate(effect.absent[parameter.name]))
    return 0.0 if parameter.prior.kind == "normal" else _TINY


def _acts(effect: Effect) -> Iterator[str]:
    if not effect.parameters or effect.needs_finite_elements:
        return
    usual = np.array([1.0 if parameter.prior.kind == "normal" else _USUAL for parameter in effect.parameters])
    found = _logs(effect, usual)
    if not np.all(np.isfinite(found)):
        yield "at its usual size the motion is not finite"
    elif not np.max(np.abs(found - _logs(None, np.empty(0)))) > 1e-6:
        yield "at its usual size it changes nothing"


def _batches(effect: Effect) -> Iterator[str]:
    if not effect.parameters or effect.needs_finite_elements:
        return
    points = np.linspace(-1, 1, 3)[:, None] * np.ones(len(effect.parameters))
    together = _logs(effect, points)
    apart = np.stack([_logs(effect, point) for point in points])
    if together.shape != apart.shape:
        yield f"a batch of parameters gives the shape {together.shape}, one by one {apart.shape}"
    elif not np.max(np.abs(together - apart)) < _SAME:
        yield "a batch of parameters gives other motions than one by one"


def _leaves_its_input_alone(effect: Effect) -> Iterator[str]:
    setting = _hypothesis(None).settings[0]
    values: dict[str, RealArray] = {p.name: np.asarray(p.prior.value(np.zeros((1, 1)))) for p in effect.parameters}
    given: ComplexArray = np.full((1, len(setting.frequency)), _MODULUS)
    kept = given.copy()
    effect.modulus(setting, given, values)
    effect.motion(setting, given, values)
    if not np.array_equal(given, kept):
        yield "an array it was given is changed in place"


_LAWS: tuple[Callable[[Effect], Iterator[str]], ...] = (
    _says_what_it_is,
    _vanishes,
    _acts,
    _batches,
    _leaves_its_input_alone,
)


def _logs(effect: Effect | None, coordinates: RealArray) -> ComplexArray:
    """Return ln(model/measured) of all configurations side by side, shape (..., n)."""
    hypothesis = _hypothesis(effect)
    start = np.zeros(len(hypothesis.joint.parameters))
    z = np.concatenate([np.broadcast_to(start, (*coordinates.shape[:-1], start.size)), coordinates], axis=-1)
    return np.concatenate(hypothesis.log_ratios(z), axis=-1)


def _hypothesis(effect: Effect | None) -> Hypothesis:
    campaign, joint = _joint()
    return Hypothesis(campaign, joint, () if effect is None else (effect,))


@cache
def _joint() -> tuple[Campaign, JointProblem]:
    """Return a small campaign without errors, a thin and a thick configuration under two plates."""
    campaign = Campaign.model_validate(_campaign())
    f = np.array(_FREQUENCIES)
    data, rigs = [], {}
    for configuration in campaign.configurations:
        rig = PlaneWaveRig.of(campaign, configuration)
        ratio = rig.transmissibility(f, np.full(len(f), _MODULUS))
        ones = np.ones(len(f))
        data.append(
            ConfigurationData(
                configuration.name, configuration.specimen_thickness, f, np.arange(len(f)), ratio, 1e-6 * ones, f
            )
        )
        rigs[configuration.name] = rig
    space = law_space("fractional_zener", f, np.full(len(f), _MODULUS))
    return campaign, JointProblem(data, rigs, space)


def _campaign() -> dict[str, Any]:
    bursts = [{"frequency": f, "file": f"{f:g}.npz"} for f in _FREQUENCIES]
    sizes = {"thin": (0.0125, 0.001), "thick": (0.025, 0.003)}
    return {
        "version": 1,
        "rig": "shaker-two-plate",
        "sampling_rate": 25600,
        "specimen": {"density": 80, "poisson_ratio": 0.0},
        "top_plate": {"density": 7850, "young_modulus": 2.1e11, "poisson_ratio": 0.3},
        "base_plate": {"density": 2700, "young_modulus": 7e10, "poisson_ratio": 0.33, "thickness": 0.01},
        "burst": {"cycles": 10, "level_rms": 5.0},
        "configurations": [
            {
                "name": name,
                "specimen_thickness": height,
                "top_plate_thickness": plate,
                "specimen_radius": 0.0225,
                "bursts": bursts,
            }
            for name, (height, plate) in sizes.items()
        ],
    }
