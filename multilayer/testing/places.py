"""The laws that every place keeps: `check_place`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.places import BasePlace, LevelPlace, TubePlace
from multilayer.experiments.hypothesis import Hypothesis
from multilayer.experiments.places import DrawnLaw
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.testing.benches import joint_bench, level_bench, soft_sample, tube_bench
from multilayer.testing.broken import broken_laws

_SMALL, _USUAL = 1e-5, 0.1  # laws, in units of the place's scale
_SAME, _ANALYTIC, _SEEN = 1e-6, 1e-3, 1e-3


def check_place(place: BasePlace | type[BasePlace]) -> None:
    """Check that a place of the two-plate rig, of a tube or of a construction keeps the laws of a diagnosis.

    The laws: it states its name, title and quantity, and all its variants have its name; a law of 0 changes nothing;
    one of a tenth of its scale changes ln(top/base), the reflection coefficient, or a level, visibly and stays finite;
    what it does is analytic in the law, so that a law drawn as amount and phase is one complex function (not asked of
    the real laws of levels).

    Parameters
    ----------
    place : BasePlace or its class
        Of a class the places that it has in a campaign of two samples under two plates, or in a tube with a foam of
        two thicknesses, whose frame is elastic where a rigid one has none.

    Raises
    ------
    AssertionError
        With every law that is broken, one per line.

    Examples
    --------
    >>> from multilayer.diagnosis.places.plate import TopPlate
    >>> check_place(TopPlate)
    """
    places = place.instances(_bench(place).settings) if isinstance(place, type) else [place]
    broken = [text for each in places for text in broken_laws(_LAWS, each)]
    if not places:
        broken = ["has places: there is none in a campaign of several configurations"]
    if isinstance(place, type) and (others := _names(place.variants()) - _names([place])):
        broken.append(f"says what it is: its variants have the name {', '.join(sorted(others))}; override 'variants'")
    if broken:
        raise AssertionError("\n".join(broken))


def _names(kinds: Iterable[type[BasePlace]]) -> set[str]:
    return {str(getattr(kind, "name", "")) for kind in kinds}


def _says_what_it_is(place: BasePlace) -> Iterator[str]:
    for field in ("name", "title", "quantity"):
        if not str(getattr(place, field, "")).strip():
            yield f"the class needs a '{field}'"


def _nothing_without_a_law(place: BasePlace) -> Iterator[str]:
    change = np.max(np.abs(_change(place, 0j)))
    if not change < _SAME:
        yield f"a law of 0 changes the data by {change:.2g}"


def _acts(place: BasePlace) -> Iterator[str]:
    change = _change(place, _USUAL)
    if not np.all(np.isfinite(change)):
        yield f"a law of {_USUAL:g} times its scale makes values that are not finite"
    elif np.max(np.abs(change)) < _SEEN:
        yield f"a law of {_USUAL:g} times its scale changes the data by {np.max(np.abs(change)):.2g} only"


def _is_analytic(place: BasePlace) -> Iterator[str]:
    if place.is_real:
        return
    before = _change(place, 0j)
    along, across = (_change(place, step) - before for step in (_SMALL, 1j * _SMALL))
    error = np.max(np.abs(across - 1j * along)) / max(float(np.max(np.abs(along))), 1e-300)
    if not error < _ANALYTIC:
        yield f"an imaginary law does something else than i times a real one: {error:.2g} of it"


_LAWS = (_says_what_it_is, _nothing_without_a_law, _acts, _is_analytic)


def _bench(place: BasePlace | type[BasePlace]) -> Hypothesis:
    if place.kind == LevelPlace.kind:
        return level_bench("transmission_loss")
    if place.kind != TubePlace.kind:
        return joint_bench()
    kind = place if isinstance(place, type) else type(place)
    return tube_bench(elastic=not kind.instances(tube_bench().settings))  # some need a frame that moves


def _change(place: BasePlace, law: complex) -> ComplexArray:
    """Return the change of the data of all configurations by a law, in units of the place's scale."""
    bench = _bench(place)
    z = soft_sample(bench) if isinstance(bench, CampaignProblem) else np.zeros(len(bench.parameters))
    frequency = np.concatenate([data.frequency for data in bench.data])
    modulus = bench.modulus_scale(z, float(np.median(frequency)))
    drawn = DrawnLaw.at(place, frequency, place.scale(bench.settings, modulus))
    shifted = bench.with_effects(drawn).differences(np.concatenate([z, drawn.constant(law)]))
    return np.concatenate([a - b for a, b in zip(shifted, bench.differences(z), strict=True)])
