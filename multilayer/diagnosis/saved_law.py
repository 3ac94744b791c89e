"""What a diagnosis leaves to later campaigns: effects of a rig with their sizes, or a place with the law drawn there.

``multilayer diagnose CAMPAIGN --save-law rig.yaml`` writes it, ``--with rig.yaml`` of fits and diagnoses applies it. It
is data, never code.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar

import numpy as np
from pydantic import Field, model_validator
from scipy.special import ndtri

from multilayer.bounds import FILE_BYTES
from multilayer.config.validate import read
from multilayer.diagnosis.effects.base import EFFECTS, Effect
from multilayer.diagnosis.places import BasePlace, places_of
from multilayer.diagnosis.places.beside import Faces, OpenFaces
from multilayer.diagnosis.places.one_configuration import OneConfiguration
from multilayer.diagnosis.places.sample import SampleShape
from multilayer.errors import InputError, Problem, suggest
from multilayer.experiments.places import LENGTH, SHORT, SPACING, SimpleLaw, TabulatedLaw, Term
from multilayer.experiments.two_plate.campaign import Acting
from multilayer.files import refuse_endless
from multilayer.inference.priors import WIDEST, Prior
from multilayer.models import NO_BOOL, Model
from multilayer.rig.partly_bonded import WIDEST_RIM
from multilayer.rig.worn_rim import DEPTHS
from multilayer.writing.manifest import note_input

RECORD = "diagnosis.json"
T = TypeVar("T")

_REACH = float(ndtri(0.95))  # standard deviations from the value to the end of a 90 % interval
_LEAST = 1e-6  # relative standard deviation of a value whose interval is a point
_NODES = 9  # of a table, at least
_MOST = 1000  # values in a list of a file
_FARTHEST = 20.0  # factor by which a law moves


class Interval(Model):
    """A value with its 90 % interval, SI."""

    value: float
    low: float
    high: float
    unit: str = ""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low <= self.value <= self.high:
            raise ValueError(f"low, value, high must rise: {self.low:g}, {self.value:g}, {self.high:g}")
        return self

    @property
    def std(self) -> float:
        """Standard deviation."""
        return max((self.high - self.low) / (2 * _REACH), _LEAST * abs(self.value))

    def prior(self, was: Prior) -> Prior:
        """Return a prior of this value, of the kind that the parameter's prior was."""
        if was.lognormal is not None or was.loguniform is not None:
            decades = np.log(self.high) - np.log(self.low) if self.low > 0 else 2 * _REACH
            spread = float(np.clip(decades / (2 * _REACH), _LEAST, WIDEST))
            return Prior(lognormal=(self.value, spread), bounds=was.bounds)
        return Prior(normal=(self.value, self.std or 1.0), bounds=was.bounds or was.uniform)


class SavedEffect(Model):
    """A known effect with the sizes that were found."""

    effect: str
    parameters: dict[str, Interval] = Field(default_factory=dict)


class SavedTerm(Model):
    """A term of a simple law: its kind, and its parameters in their order; `order` of a power of i w."""

    kind: Literal["power", "lossy", "fractional", "relaxation", "resonance"]
    order: Annotated[int, Field(ge=-2, le=2), NO_BOOL] = 0
    parameters: dict[str, Interval]


Values = Annotated[tuple[float, ...], Field(min_length=2, max_length=_MOST)]


class SavedTable(Model):
    """A drawn law with its 90 % band, in the place's unit."""

    frequency_hz: Values
    real: Values
    real_low: Values
    real_high: Values
    imag: Values
    imag_low: Values
    imag_high: Values

    @model_validator(mode="after")
    def _sound(self) -> Self:
        lengths = {name: len(getattr(self, name)) for name in type(self).model_fields}
        if len(set(lengths.values())) > 1:
            raise ValueError(f"all lists must be of one length: {lengths}")
        if np.any(np.diff(self.frequency_hz) <= 0) or self.frequency_hz[0] <= 0:
            raise ValueError("frequency_hz must rise, from above 0")
        return self


class SavedRim(Model):
    """Open rims of the sample's faces, as `OpenFaces` has them."""

    width: Annotated[float, Field(ge=0, le=WIDEST_RIM)]
    trend: Annotated[float, Field(ge=-20, le=20)] = 0.0
    at_base: Annotated[float, Field(ge=0, le=2)] = 0.0
    depth: Annotated[float, Field(ge=0, le=DEPTHS[-1])] = 0.0


class SavedLaw(Model):
    """A law at a place: a sum of simple terms, amplitudes at `centre`, Hz; or a table.

    With `free_rim` it is what acts beyond the sample's free rim, which finite elements have; with `open_rim` what acts
    beyond open rims of its faces. `moved` has factors of the law's frequencies by configuration, 1 where there is none.
    `factors` are by what it is multiplied in each, as `BasePlace.factors`, and `differs_by` is what they differ by.
    `correlation_length` in ln f is that of a table.
    """

    place: str
    variant: str = ""
    configuration: str = ""
    free_rim: Annotated[bool, Field(strict=True)] = False
    open_rim: SavedRim | None = None
    moved: dict[str, Annotated[float, Field(ge=1 / _FARTHEST, le=_FARTHEST), NO_BOOL]] = Field(
        default_factory=dict, max_length=_MOST
    )
    factors: dict[str, Annotated[float, Field(ge=-_FARTHEST, le=_FARTHEST), NO_BOOL]] = Field(
        default_factory=dict, max_length=_MOST
    )
    differs_by: Literal["configuration", "sample", "top plate"] = "configuration"
    quantity: str = ""
    unit: str = ""
    text: str = ""
    correlation_length: Annotated[float, Field(ge=SHORT)] = LENGTH
    centre: Annotated[float, Field(gt=0)] = 1.0
    terms: tuple[SavedTerm, ...] = ()
    table: SavedTable | None = None

    @model_validator(mode="after")
    def _has_law(self) -> Self:
        if not self.terms and self.table is None:
            raise ValueError("a law needs 'terms' or a 'table'")
        return self


class RigLaw(Model):
    """A file of ``--save-law``.

    Attributes
    ----------
    campaign : str
        That it is from.
    effects : tuple of SavedEffect
    laws : tuple of SavedLaw
    """

    version: Literal[1] = 1
    campaign: str = ""
    effects: tuple[SavedEffect, ...] = ()
    laws: tuple[SavedLaw, ...] = ()

    @model_validator(mode="after")
    def _holds_something(self) -> Self:
        if not (self.effects or self.laws):
            raise ValueError("neither 'effects' nor 'laws': there is nothing to apply")
        return self

    def applied(self, file: Path) -> tuple[Acting, ...]:
        """Return all of it as effects, whose priors are what was found.

        Raises
        ------
        InputError
            For effects, parameters and places that there are not.
        """
        found = [_of_effect(saved, file) for saved in self.effects]
        return (*found, *(_of_law(saved, file) for saved in self.laws))


def load_rig_law(file: Path) -> RigLaw:
    """Read a file of ``--save-law``.

    Raises
    ------
    InputError
        With every mistake found.
    """
    law = read(file, RigLaw, "rig-law")
    law.applied(file)
    return law


def known_effects(source: str) -> tuple[Acting, ...]:
    """Return what ``--with`` names: an effect, a file of ``--save-law``, or the ``diagnosis.json`` of a named effect.

    The sizes of a diagnosis are where the search starts; its priors stay as wide as those of the library, since it may
    be of the same data. A file of ``--save-law`` is knowledge from other data.

    Raises
    ------
    InputError
        When it is none of these.
    """
    file = Path(source)
    if file.suffix == ".json":
        return _of_diagnosis(file)
    if file.suffix in (".yaml", ".yml"):
        return load_rig_law(file).applied(file)
    if source not in EFFECTS.names():
        text = f"--with: there is no effect '{source}'; {suggest(source, EFFECTS.names())}"
        raise InputError(f"{text}, or name a file (rig.yaml of --save-law, diagnosis.json)")
    return (_rig_effect(source, None),)


def saved_law(record: Mapping[str, Any], campaign: str) -> RigLaw:
    """Return what a diagnosis found as a file.

    Raises
    ------
    InputError
        When it found neither an effect nor a law, or a law that does not explain the gap.
    """
    if record["verdict"] == "effect":
        return RigLaw(campaign=campaign, effects=named_effects(record))
    if wrong := record.get("wrong_statement"):
        names = " or ".join([wrong["name"], *wrong["tied"]])
        raise InputError(f"no law to save: {names} is stated wrongly; measure it again, and correct the campaign file")
    if record["verdict"] == "no_gap" or not record["law"]:
        raise InputError("the diagnosis shows no law to save: there is no gap, or no place that explains it")
    if both := record.get("two_causes"):
        if not both["effects"]:
            text = "two unknown laws at once are drawn to be looked at; to save one, find the cause of the other first"
            raise InputError(text)
        return RigLaw(campaign=campaign, effects=_saved_effects(both), laws=(_saved(both["law"]),))
    if wrong := record.get("wrong_statement"):
        raise InputError(
            f"no law to save: {wrong['name']} is stated wrongly; measure it again, and correct the campaign"
        )
    if objection := record["law"].get("objection"):
        raise InputError(f"no law of this diagnosis is worth saving: the best {objection}")
    return RigLaw(campaign=campaign, laws=(_saved(record["law"]),))


def named_effects(record: Mapping[str, Any]) -> tuple[SavedEffect, ...]:
    """Return the effects that the verdict of a diagnosis names, with their sizes."""
    return _saved_effects(next(cause for cause in record["causes"] if cause["effects"] == record["group"][0]))


def _saved_effects(cause: Mapping[str, Any]) -> tuple[SavedEffect, ...]:
    parameters = {name: Interval(**value) for name, value in cause["parameters"].items()}
    return tuple(
        SavedEffect(
            effect=name,
            parameters={
                key.partition(".")[2]: value
                for key, value in parameters.items()
                # what belongs to one configuration, as width[h25mm-t1mm], is another one's in a later campaign
                if key.startswith(f"{name}.") and not key.endswith("]")
            },
        )
        for name in cause["effects"]
    )


def _saved(law: Mapping[str, Any]) -> SavedLaw:
    named = {key: law[key] for key in SavedLaw.model_fields if key in law}
    form = law["form"]
    if law["form_is_enough"]:
        terms = tuple(
            SavedTerm(kind=term["kind"], order=term["order"], parameters=term["parameters"]) for term in form["terms"]
        )
        return SavedLaw(**named, text=form["text"], centre=form["centre_hz"], terms=terms)
    columns = ("frequency_hz", "real", "real_low", "real_high", "imag", "imag_low", "imag_high")
    return SavedLaw(**named, table=SavedTable(**{key: tuple(law[key]) for key in columns}))


def _rig_effect(name: str, file: Path | None) -> Effect:
    kind = EFFECTS[name] if name in EFFECTS.names() else None
    if kind is None or not issubclass(kind, Effect):
        rig = [each for each, other in EFFECTS.working() if issubclass(other, Effect)]
        raise InputError(Problem(f"there is no effect '{name}' of the rig; {suggest(name, rig)}", file=file))
    return kind()


def _with_parameters(saved: SavedEffect, file: Path) -> Effect:
    """Return the effect, by the finer of its laws where it was saved with parameters that only that one has."""
    effect = _rig_effect(saved.effect, file)
    known = {parameter.name for parameter in effect.parameters}
    finer = effect.finer()
    return finer if isinstance(finer, Effect) and not known >= set(saved.parameters) else effect


def _of_effect(saved: SavedEffect, file: Path) -> Effect:
    effect = _with_parameters(saved, file)
    known = [parameter.name for parameter in effect.parameters]
    for name in saved.parameters:
        if name not in known:
            raise InputError(Problem(f"{saved.effect} has no parameter '{name}'; {suggest(name, known)}", file=file))
    return _with_priors(effect, {name: found.prior for name, found in saved.parameters.items()})


def _with_priors(effect: Effect, priors: Mapping[str, Callable[[Prior], Prior]]) -> Effect:
    """Return the effect with other priors of some parameters, made of their own."""
    effect.parameters = tuple(
        parameter.model_copy(update={"prior": priors[parameter.name](parameter.prior)})
        if parameter.name in priors
        else parameter
        for parameter in effect.parameters
    )
    return effect


def _of_law(saved: SavedLaw, file: Path) -> Acting:
    known = places_of(Effect.kind)
    if saved.place not in known:
        text = f"there is no place '{saved.place}'; {suggest(saved.place, known)}"
        raise InputError(Problem(text, file=file))
    kinds = {kind.variant: kind for kind in known[saved.place].variants()}
    if saved.variant not in kinds:
        text = f"the place {saved.place} has no variant '{saved.variant}'; {suggest(saved.variant, kinds)}"
        raise InputError(Problem(text, file=file))
    if bool(saved.configuration) != (saved.place == OneConfiguration.name):
        needs = "needs a" if saved.place == OneConfiguration.name else "has no"
        raise InputError(Problem(f"the place {saved.place} {needs} configuration", file=file))
    fields: dict[str, Any] = {"configuration": saved.configuration} if saved.configuration else {}
    if saved.free_rim:
        if saved.place != SampleShape.name:
            raise InputError(Problem(f"free_rim is of the place {SampleShape.name}, not of {saved.place}", file=file))
        fields["needs_finite_elements"] = True
    if saved.open_rim and saved.place != Faces.name:
        raise InputError(Problem(f"open_rim is of the place {Faces.name}, not of {saved.place}", file=file))
    opened = OpenFaces(**saved.open_rim.model_dump()) if saved.open_rim else None
    place: BasePlace = opened or kinds[saved.variant](**fields)
    if saved.moved or saved.factors:
        if not place.can_move:
            field = "moved" if saved.moved else "factors"
            raise InputError(Problem(f"{field} is of a law in all configurations, alone at {saved.place}", file=file))
        moved = {name: float(np.log(factor)) for name, factor in saved.moved.items()}
        place = place.differing(moved, saved.factors, saved.differs_by)
    name = f"known_{place.label}"
    if saved.terms:
        terms = tuple(Term(term.kind, term.order) for term in saved.terms)
        plain = SimpleLaw.at(place, terms, np.array([saved.centre]), 1.0)
        given = [found for term in saved.terms for found in term.parameters.values()]
        if len(given) != len(plain.parameters):
            text = f"the terms at {saved.place} need {len(plain.parameters)} parameters, not {len(given)}"
            raise InputError(Problem(text, file=file))
        pairs = zip(plain.parameters, given, strict=True)
        parameters = tuple(p.model_copy(update={"prior": found.prior(p.prior)}) for p, found in pairs)
        return SimpleLaw(place, terms, saved.centre, name, parameters)
    assert saved.table is not None  # checked when it was read
    return _tabulated(place, name, saved.table, saved.correlation_length)


def _tabulated(place: BasePlace, name: str, table: SavedTable, length: float) -> TabulatedLaw:
    """Return the table at a few nodes: its values are correlated over that distance."""
    f = np.array(table.frequency_hz)
    count = int(np.ceil(np.log(f[-1] / f[0]) / (SPACING * length))) + 1
    nodes = np.geomspace(f[0], f[-1], min(max(_NODES, count), len(f)))

    def at_nodes(values: Sequence[float]) -> np.ndarray:
        return np.interp(np.log(nodes), np.log(f), values)

    mean = at_nodes(table.real) + 1j * at_nodes(table.imag)
    bands = ((table.real_low, table.real_high), (table.imag_low, table.imag_high))
    width = [at_nodes(high) - at_nodes(low) for low, high in bands]
    least = _LEAST * float(np.abs(mean).max())
    std = np.maximum(width[0] / (2 * _REACH), least) + 1j * np.maximum(width[1] / (2 * _REACH), least)
    return TabulatedLaw.of(place, name, nodes, mean, std)


def from_record(file: Path, taken: Callable[[dict[str, Any]], T]) -> T:
    """Return what a function takes from a ``diagnosis.json``.

    Raises
    ------
    InputError
        When the file is too large, cannot be read, or holds no such record.
    """
    try:
        refuse_endless(file)
        FILE_BYTES.check(file.stat().st_size, file, "run diagnose again")
        return taken(json.loads(file.read_text(encoding="utf-8")))
    except OSError as error:
        raise InputError(Problem(f"cannot be read: {error.strerror}", file=file)) from None
    except (ValueError, LookupError, TypeError, AttributeError, StopIteration, RecursionError):
        text = f"this is no {RECORD}; name one that `multilayer diagnose` has written, or run it again"
        raise InputError(Problem(text, file=file)) from None


def _of_diagnosis(file: Path) -> tuple[Acting, ...]:
    note_input(file)
    try:
        saved = from_record(file, lambda record: saved_law(record, file.stem))
    except InputError as error:
        raise InputError([problem.at(file) for problem in error.problems]) from None
    effects: list[Acting] = []
    for one in saved.effects:
        effect = _with_parameters(one, file)
        effects.append(_with_priors(effect, {name: _Wide(found) for name, found in one.parameters.items()}))
    return (*effects, *(_of_law(law, file) for law in saved.laws))


class _Wide:
    """The library's prior about a value that was found."""

    def __init__(self, found: Interval) -> None:
        self.found = found

    def __call__(self, was: Prior) -> Prior:
        if was.lognormal is not None and self.found.value > 0:
            return Prior(lognormal=(self.found.value, was.lognormal[1]), bounds=was.bounds)
        if was.normal is not None:
            return Prior(normal=(self.found.value, was.normal[1]), bounds=was.bounds)
        return was
