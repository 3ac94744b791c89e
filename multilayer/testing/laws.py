"""The laws that every modulus law keeps: `check_law`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from multilayer.arrays import ComplexArray, IndexArray, RealArray
from multilayer.config import dump_yaml, parse_yaml
from multilayer.layers.elastic_solid import ElasticSolid
from multilayer.media.kramers_kronig import kramers_kronig_loss_modulus
from multilayer.media.laws import LAWS, ModulusLaw, Table
from multilayer.stack import Stack
from multilayer.testing.broken import broken_laws
from multilayer.testing.units import wrong_units

_FREQUENCIES = np.geomspace(1.0, 5e4, 40)
_EVERYWHERE = np.geomspace(1e-6, 1e12, 361)
_PER_DECADE = 30
# so far out that broad spectra are on their plateaus
_ALL_TIME = np.geomspace(1e-45, 1e45, 90 * _PER_DECADE + 1)
_DENSE = np.concatenate([
    _ALL_TIME[_ALL_TIME < 0.9e-9], np.geomspace(1e-9, 1e15, 24 * 2000 + 1), _ALL_TIME[_ALL_TIME > 1.1e15],
])  # fmt: skip
_NEAR = 3  # decades; of a power law of order 0.9 and more, rounding loses what rises 16 decades above adds to E2
_SAME, _ROUNDING = 1e-12, 1e-15


def check_law(law: ModulusLaw) -> None:
    """Check that a modulus law keeps the laws that all of them keep.

    The laws: passive (Re E > 0, Im E >= 0) and real in time (``E(-f) = conj E(f)``); causal by Kramers and Kronig's
    relations, as far as its resonances are wider than a hundredth of their frequencies, unless it states ``causal =
    False``; parameters in units that are SI; frequencies and parameters of any shape give the same as single numbers;
    written to a file and read, it is the same law.

    Parameters
    ----------
    law : ModulusLaw
        Its type must be registered (entry point ``multilayer.modulus_laws``, or `LAWS.register`).

    Raises
    ------
    AssertionError
        With every law that is broken, one per line.

    Examples
    --------
    >>> from multilayer.media.laws import KelvinVoigt
    >>> check_law(KelvinVoigt(young_modulus=1e5, viscosity=12.0))
    """
    broken = broken_laws(_LAWS, law)
    if broken:
        raise AssertionError("\n- ".join([f"the modulus law '{law.law}' breaks these laws:", *broken]))


def _within(law: ModulusLaw, frequency: RealArray) -> RealArray:
    """Return the frequencies for which a law has a value."""
    if not isinstance(law, Table):
        return frequency
    return frequency[(frequency >= law.frequency[0]) & (frequency <= law.frequency[-1])]


def _passive(law: ModulusLaw) -> Iterator[str]:
    f = _within(law, _EVERYWHERE)
    modulus = law(f)
    no_loss = -_ROUNDING * np.abs(modulus)
    for part, wrong in (("real", ~(modulus.real > 0)), ("imaginary", ~(modulus.imag >= no_loss))):
        if np.any(wrong):
            worst = int(np.argmax(wrong))
            yield f"at {f[worst]:g} Hz the modulus is {modulus[worst]:.3g} Pa, whose {part} part is not allowed"


def _real_in_time(law: ModulusLaw) -> Iterator[str]:
    f = _within(law, _EVERYWHERE)
    if not _alike(law(-f), law(f).conj()):
        yield "E(-f) is not the complex conjugate of E(f)"


def _causal(law: ModulusLaw) -> Iterator[str]:
    """Compare E2 with what the dispersion of E1 demands, less a dashpot, which is read from the highest frequency.

    What differs is held against E2 near by: that of a power law or a dashpot grows without end. Where it differs too
    much, denser frequencies judge, as a resonance may be narrower than the steps.
    """
    if isinstance(law, Table):
        return
    f = _ALL_TIME
    inside = np.flatnonzero((f >= _EVERYWHERE[0]) & (f <= _EVERYWHERE[-1]))
    _, beyond = _differences(law, f, inside)
    suspects = ~(beyond <= 0)
    for frequency in f[inside][suspects][np.argsort(-beyond[suspects])]:
        (excess,), (beyond_fine,) = _differences(law, _DENSE, [np.argmin(np.abs(_DENSE - frequency))])
        if beyond_fine <= 0:
            continue
        if law.causal:
            yield (
                f"E2 differs by {excess:.2g} Pa at {frequency:.2g} Hz from what Kramers and Kronig demand of E1: look "
                "for a mistake in the formula; a law that is not meant to be causal says 'causal = False'"
            )
        return
    if not law.causal and np.max(law(f).imag) > 0:
        yield "it says that it is not causal, and is"


def _differences(law: ModulusLaw, f: RealArray, at: Sequence[Any] | IndexArray) -> tuple[RealArray, RealArray]:
    """Return what E2 differs by at some of the frequencies f, Pa, and what of that is too much."""
    modulus = law(f)
    loss = modulus.imag - f * modulus.imag[-1] / f[-1]
    near = np.array([np.max(loss[(f >= x / 10**_NEAR) & (f <= x * 10**_NEAR)]) for x in f[at]])
    excess = np.abs(kramers_kronig_loss_modulus(f, modulus.real, f[at]) - loss[at])
    return excess, excess - 2e-3 * near - 1e-9 * modulus.real[at] - 1e-12 * modulus.imag[at]


def _units(law: ModulusLaw) -> Iterator[str]:
    yield from wrong_units(type(law))


def _any_frequencies(law: ModulusLaw) -> Iterator[str]:
    f = _within(law, _FREQUENCIES)
    together = law(f[:, None])
    if together.shape != (f.size, 1) or together.dtype != complex or np.shape(law(float(f[0]))) != ():
        yield f"frequencies of shape {(f.size, 1)} give {together.dtype} of shape {together.shape}"
    elif not _alike(together[:, 0], np.array([law(float(value)) for value in f])):
        yield "an array of frequencies and single ones differ"


def _any_parameters(law: ModulusLaw) -> Iterator[str]:
    for field, index, value in _numbers(law) if not isinstance(law, Table) else ():
        values = value * np.array([[1.0], [0.9]])
        together = _with(law, field, index, values)(_FREQUENCIES)
        alone = np.array([_with(law, field, index, float(single))(_FREQUENCIES) for single in values[:, 0]])
        if not _alike(np.broadcast_to(together, alone.shape), alone):
            yield f"an array and single numbers of {field} differ"


def _file_round_trip(law: ModulusLaw) -> Iterator[str]:
    if law.law not in LAWS:
        yield f"no entry point 'multilayer.modulus_laws' is called '{law.law}'; no file can name it"
        return
    stack = Stack(layers=(ElasticSolid(thickness=0.01, density=100.0, young_modulus=law, poisson_ratio=0.3),))
    text = dump_yaml(stack.to_dict())
    if Stack.model_validate(parse_yaml(text, Path("stack.yaml")).data) != stack:
        yield f"written as {text!r} it does not come back"


_LAWS: tuple[Callable[[ModulusLaw], Iterator[str]], ...] = (
    _passive, _real_in_time, _causal, _units, _any_frequencies, _any_parameters, _file_round_trip,
)  # fmt: skip


def _numbers(law: ModulusLaw) -> Iterator[tuple[str, int | None, float]]:
    """Give field, index and value of every parameter; the index is None where the field is no list."""
    for field, value in law:
        if isinstance(value, float):
            yield field, None, value
        elif isinstance(value, tuple):
            yield from ((field, index, entry) for index, entry in enumerate(value))


def _with(law: ModulusLaw, field: str, index: int | None, value: Any) -> ModulusLaw:
    """Return a law with another value in a field, or in an entry of it; not validated, for it may be an array."""
    if index is None:
        return law.model_copy(update={field: value})
    entries = getattr(law, field)
    return law.model_copy(update={field: (*entries[:index], value, *entries[index + 1 :])})


def _alike(a: ComplexArray, b: ComplexArray) -> bool:
    return bool(np.all(np.abs(a - b) <= _SAME * np.abs(b)))
