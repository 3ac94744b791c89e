"""The laws that every effect of the virtual rig keeps: `check_rig_effect`."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from multilayer.diagnosis.effects.base import EFFECTS as DIAGNOSED
from multilayer.rig.bench import Bench
from multilayer.rig.draws import draw_errors
from multilayer.rig.effect_base import PERTURBED, Effect
from multilayer.rig.effects import EFFECTS
from multilayer.rig.file import RigFile
from multilayer.rig.two_plate import TwoPlateRig
from multilayer.testing.broken import broken_laws
from multilayer.units import field_unit

_PERTURBATIONS = (-0.5, 0.0, 0.3)
_FARTHEST = 4.0  # standard deviations: a size that is drawn is a size that is thought of
_LAW = {
    "law": "fractional_zener", "relaxed_modulus": 1e5, "unrelaxed_modulus": 1e6, "relaxation_time": 1e-4, "order": 0.5,
}  # fmt: skip
_RIG = {
    "version": 1,
    "rig": "two-plate",
    "specimen": {"density": 80.0, "poisson_ratio": 0.3, "young_modulus": _LAW},
    "frequencies": [200.0, 500.0, 900.0],
    "configurations": {"thicknesses": [0.025], "top_plates": [0.001]},
}


def check_rig_effect(kind: type[Effect]) -> None:
    """Check that an effect of the virtual rig can be listed in a file, drawn for a blind check, and documented.

    The laws: its docstring states its law, and behind ``Perturbed:`` the law with a perturbation; all fields have
    defaults, and numbers a unit; with any perturbation it makes a valid rig, a passive modulus and a finite reading
    that is affine in top over base, in another process too; it changes nothing in place; read from a file, it is the
    same; diagnoses have an effect of its name if it is `known`; drawn sizes are allowed, and not improbable by the
    prior of the diagnosis's parameter.

    Parameters
    ----------
    kind : subclass of Effect
        Its name must be registered (entry point ``multilayer.rig_effects``, or `EFFECTS.register`).

    Raises
    ------
    AssertionError
        With every law that is broken, one per line.

    Examples
    --------
    >>> from multilayer.rig.effects.channel_gain import ChannelGain
    >>> check_rig_effect(ChannelGain)
    """
    if broken := broken_laws(_LAWS, kind):
        raise AssertionError("\n".join(broken))


def _name(kind: type[Effect]) -> str:
    return str(kind.model_fields["effect"].default)


def _says_what_it_is(kind: type[Effect]) -> Iterator[str]:
    law, _, perturbed = (kind.__doc__ or "").partition(PERTURBED)
    if not law.strip() or not perturbed.strip():
        yield f"the docstring must say the law, and what a perturbation makes of it behind '{PERTURBED}'"
    for name, field in kind.model_fields.items():
        if field.is_required():
            yield f"field '{name}' needs a default"
        elif isinstance(field.default, float) and field_unit(field) is None:
            yield f"field '{name}' needs a unit; write Annotated[float, ..., Unit('...')]"


def _bench(kind: type[Effect], perturbation: float) -> Bench:
    listed = [{"effect": name} for name in kind.needs] + [{"effect": _name(kind), "perturbation": perturbation}]
    settings = RigFile.model_validate({**_RIG, "effects": listed})
    return Bench(settings, draw_errors(settings, 0), settings.mountings[0])


def _makes_a_rig(kind: type[Effect]) -> Iterator[str]:
    for perturbation in _PERTURBATIONS:
        bench: Bench = pickle.loads(pickle.dumps(_bench(kind, perturbation)))
        TwoPlateRig(**{name: value for name, value in bench.geometry.items() if name != "real_plate_modulus"})
        f = np.array(bench.mounting.frequencies)
        modulus = bench.modulus(f, bench.moment(f[0], 1))
        if not np.all((modulus.real > 0) & (modulus.imag >= 0)):
            yield f"perturbed by {perturbation:g}, the modulus is {modulus}, Pa, and must be passive"
        if not np.all(np.isfinite(bench.chain(0))):
            yield f"perturbed by {perturbation:g}, the reading is not finite"


def _reading_is_affine(kind: type[Effect]) -> Iterator[str]:
    f = np.array([0.0, 100.0, 1000.0])
    bench = _bench(kind, 0.0)
    effect, mounting = bench.settings.effects[-1], bench.mounting
    still, plain, twice = (effect.apply_to_response(f, np.full(3, t, dtype=complex), mounting) for t in (0, 1, 2))
    if not np.allclose(twice - plain, plain - still, rtol=1e-9, atol=1e-12):
        yield "what it shows of 2 T is not what it shows of T, and as much again"


def _leaves_its_input_alone(kind: type[Effect]) -> Iterator[str]:
    bench = _bench(kind, 0.3)
    effect = bench.settings.effects[-1]
    f, moment = np.array(bench.mounting.frequencies), bench.moment(bench.mounting.frequencies[0], 0)
    geometry = dict(bench.geometry)
    given: list[Any] = [np.full(3, 1e5 + 1e4j), np.full(3, 1 + 0j), np.ones(400), np.ones(400)]
    kept = [array.copy() for array in given]
    effect.apply_to_geometry(geometry, bench.mounting, bench.settings.specimen)
    effect.apply_to_modulus(f, given[0], moment)
    effect.apply_to_response(f, given[1], bench.mounting)
    effect.apply_to_signals(given[2], given[3], 25600.0, moment)
    if geometry != bench.geometry or not all(map(np.array_equal, given, kept)):
        yield "something it was given is changed in place"


def _file_round_trip(kind: type[Effect]) -> Iterator[str]:
    bench = _bench(kind, 0.3)
    if RigFile.model_validate(json.loads(bench.settings.model_dump_json(exclude_none=True))) != bench.settings:
        yield "written to a file it does not come back"
    unknown = set(bench.settings.effects[-1].parameters(bench.settings.specimen)) - set(kind.model_fields)
    if unknown:
        yield f"parameters for the truth file that are no fields: {', '.join(sorted(unknown))}"


def _twin(kind: type[Effect]) -> Iterator[str]:
    name, drawn = _name(kind), kind.drawn
    if kind.known and name not in DIAGNOSED:
        yield f"no effect '{name}' is known to a diagnosis; say 'known = False', or add it"
    if drawn is None or not drawn.field:
        return
    for size in (drawn.low, drawn.high):
        kind.model_validate({"effect": name, drawn.field: size})
        if drawn.parameter:
            prior = next(p.prior for p in DIAGNOSED[name].parameters if p.name == drawn.parameter)
            coordinate = prior.coordinate(drawn.of(size))
            if not abs(coordinate) < _FARTHEST:
                yield f"a {drawn.field} of {size:g} lies {coordinate:.1f} standard deviations out in the prior"


def _is_registered(kind: type[Effect]) -> Iterator[str]:
    if _name(kind) not in EFFECTS:
        yield f"no entry point 'multilayer.rig_effects' is called '{_name(kind)}'; no file can list it"


_LAWS: tuple[Callable[[type[Effect]], Iterator[str]], ...] = (
    _says_what_it_is, _is_registered, _makes_a_rig, _reading_is_affine, _leaves_its_input_alone, _file_round_trip,
    _twin,
)  # fmt: skip
