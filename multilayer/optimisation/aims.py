"""What is wanted of a design: goals and limits, of spectra, single-number ratings, thickness, mass and price."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field, model_validator

from multilayer.arrays import BoolArray, RealArray
from multilayer.errors import InputError, show, suggest
from multilayer.json_schema import QUANTITY_TEXT, Written
from multilayer.models import Model, refuse
from multilayer.response import ratings, real_ratings
from multilayer.response.bands import nearest_centres
from multilayer.simulation.bands import Grid
from multilayer.simulation.measured import Measured, read_measured
from multilayer.simulation.quantities import QUANTITIES, mean_of
from multilayer.units import Density, Frequency, NonNegative, Unit, parse_quantity

SPECTRA = ("absorption", "transmission_loss", "insertion_loss")
SIZES = {"thickness": "m", "mass": "kg/m^2", "price": ""}
_FLAT = 1e-12  # of squares, for a slope where a curve is met
Bands = Mapping[float, RealArray]
Mistake = tuple[tuple[str | int, ...], str, Any]


@dataclass(frozen=True)
class Rating:
    """A single-number rating: the true one, in steps, and the same as a real number, which a search can follow."""

    quantity: str
    true: Callable[[Mapping[float, float]], float]
    real: Callable[[Bands], RealArray]

    @property
    def unit(self) -> str:
        """Of its value."""
        return QUANTITIES[self.quantity].unit


def _alpha_w(bands: Mapping[float, float]) -> float:
    return ratings.weighted_absorption(bands).alpha_w


def _alpha_w_of_octaves(bands: Mapping[float, float]) -> float:
    return ratings.weighted_absorption_octaves(bands).alpha_w


def _rw(bands: Mapping[float, float], term: str = "") -> float:
    index = ratings.weighted_reduction_index(bands)
    return index.rw + (float(getattr(index, term)) if term else 0.0)


# functions with names: they are pickled for other processes
_ABSORBED, _LOST = "absorption", "transmission_loss"
RATINGS = {
    "alpha_w": Rating(_ABSORBED, _alpha_w, real_ratings.real_weighted_absorption),
    "NRC": Rating(_ABSORBED, ratings.noise_reduction_coefficient, real_ratings.real_noise_reduction),
    "SAA": Rating(_ABSORBED, ratings.sound_absorption_average, real_ratings.real_absorption_average),
    "Rw": Rating(_LOST, _rw, real_ratings.real_reduction_index),
    "Rw+C": Rating(_LOST, partial(_rw, term="c"), partial(real_ratings.real_adapted_index, spectrum="C")),
    "Rw+Ctr": Rating(_LOST, partial(_rw, term="ctr"), partial(real_ratings.real_adapted_index, spectrum="Ctr")),
    "STC": Rating(_LOST, ratings.sound_transmission_class, real_ratings.real_transmission_class),
    "OITC": Rating(_LOST, ratings.outdoor_indoor_transmission_class, real_ratings.real_outdoor_indoor_class),
}
_IN_OCTAVES = {"alpha_w": Rating(_ABSORBED, _alpha_w_of_octaves, real_ratings.real_weighted_absorption_octaves)}
MEASURES = (*SPECTRA, *RATINGS, *SIZES)


@dataclass(frozen=True)
class Figures:
    """What designs give.

    Attributes
    ----------
    quantities : mapping
        Spectra by name, shape (n_designs, n_frequency).
    sizes : mapping
        Those of `SIZES` that are asked for, by name, shape (n_designs,).
    """

    quantities: Mapping[str, NDArray[Any]]
    sizes: Mapping[str, NDArray[Any]]


_NAME = Written({"enum": list(MEASURES)})
_BOUND = Written({"type": ["number", "string"], "pattern": QUANTITY_TEXT})


class Goal(Model):
    """What is to be as high, as low or as close to a curve as can be.

    `highest` and `lowest` take a spectrum (its mean from `from` to `to`), a rating or a size; `closest` a table of a
    measured or wanted curve (its rms difference), of `quantity` where it has several.
    """

    model_config = ConfigDict(
        populate_by_name=True,
        json_schema_extra={"oneOf": [{"required": [name]} for name in ("highest", "lowest", "closest")]},
    )

    highest: Annotated[str | None, _NAME] = None
    lowest: Annotated[str | None, _NAME] = None
    closest: str | None = None
    quantity: Annotated[str | None, Written({"enum": list(SPECTRA)})] = None
    start: Annotated[Frequency | None, Field(alias="from")] = None
    stop: Annotated[Frequency | None, Field(alias="to")] = None

    @model_validator(mode="after")
    def _one_aim(self) -> Self:
        if sum(name is not None for name in (self.highest, self.lowest, self.closest)) != 1:
            refuse(self, [((), "give one of highest, lowest and closest, as {highest: alpha_w}", None)])
        return self


class Limit(Model):
    """What must be kept: of a spectrum everywhere from `from` to `to`, of a rating or a size."""

    model_config = ConfigDict(
        populate_by_name=True, json_schema_extra={"anyOf": [{"required": ["at_least"]}, {"required": ["at_most"]}]}
    )

    of: Annotated[str, _NAME]
    at_least: Annotated[Any, _BOUND] = None
    at_most: Annotated[Any, _BOUND] = None
    start: Annotated[Frequency | None, Field(alias="from")] = None
    stop: Annotated[Frequency | None, Field(alias="to")] = None

    @model_validator(mode="after")
    def _has_a_bound(self) -> Self:
        if self.at_least is None and self.at_most is None:
            refuse(self, [((), "give at_least or at_most", None)])
        return self


class Catalogue(Model):
    """What a material or a layer weighs and costs, where its fields do not say."""

    density: Density | None = None
    mass: Annotated[float | None, NonNegative, Unit("kg/m^2")] = None
    price: Annotated[float, NonNegative] = 0.0
    price_per_volume: Annotated[float, NonNegative] = 0.0
    price_per_mass: Annotated[float, NonNegative] = 0.0


@dataclass(frozen=True)
class Aim:
    """A goal, or one side of a limit, with everything that it needs.

    Attributes
    ----------
    place : tuple
        Where it stands in the file.
    name : str
        Of `MEASURES`.
    title : str
        For people.
    sign : float
        1 where more is better, -1 where less is.
    bound : float or None
        Of a limit.
    rating : Rating or None
    kept : array of bool, or None
        The frequencies of a spectrum that count.
    target : array or None
        The curve that is to be met there.
    worst : bool
        Of a spectrum the worst value counts, not the mean.
    grid : Grid
    """

    place: tuple[str | int, ...]
    name: str
    title: str
    sign: float
    grid: Grid
    bound: float | None = None
    rating: Rating | None = None
    kept: BoolArray | None = None
    target: RealArray | None = None
    worst: bool = False

    @property
    def unit(self) -> str:
        """Of its value."""
        if self.rating is not None:
            return self.rating.unit
        return SIZES[self.name] if self.name in SIZES else QUANTITIES[self.name].unit

    @property
    def quantity(self) -> str:
        """The spectrum that it is about; empty of a size."""
        return "" if self.name in SIZES else self.rating.quantity if self.rating is not None else self.name

    @property
    def scale(self) -> float:
        """Size of the bound, over which it is missed in per cent."""
        return max(abs(self.bound or 0.0), 1e-3) if self.name in SIZES else 10.0 if self.unit == "dB" else 1.0

    def values(self, figures: Figures) -> RealArray:
        """Return what a search follows, shape (n_designs, n): one value; of a limit of a spectrum one a frequency."""
        if self.name in SIZES:
            return figures.sizes[self.name][:, None]
        if self.rating is not None:
            bands = self.grid.by_band(QUANTITIES[self.quantity].mean, figures.quantities[self.quantity])
            return self.rating.real(bands)[:, None]
        kept = {name: values[:, self.kept] for name, values in figures.quantities.items()}
        spectrum = kept[self.name]
        if self.target is not None:
            return np.asarray(np.sqrt(np.mean((spectrum - self.target) ** 2, axis=1, keepdims=True) + _FLAT))
        if self.worst:
            return np.asarray((np.min if self.sign > 0 else np.max)(spectrum, axis=1, keepdims=True))
        return spectrum if self.bound is not None else mean_of(self.name, kept)[:, None]

    def true(self, figures: Figures) -> float:
        """Return the value of the first design as a standard has it; of a limit of a spectrum the worst."""
        if self.rating is not None:
            bands = self.grid.by_band(QUANTITIES[self.quantity].mean, figures.quantities[self.quantity])
            return float(self.rating.true({centre: float(values[0]) for centre, values in bands.items()}))
        values = self.values(figures)[0]
        return float(np.min(values) if self.sign > 0 else np.max(values))

    def slack(self, value: RealArray | float) -> Any:
        """Return how far a value keeps the bound, over the bound's size; below 0 where it does not."""
        assert self.bound is not None
        return self.sign * (value - self.bound) / self.scale


@dataclass(frozen=True)
class Setting:
    """What aims are read against: frequencies, whether sound goes through, a reference, and the file's folder."""

    grid: Grid
    through: bool
    reference: bool
    folder: Path


def goal_of(goal: Goal, i: int, setting: Setting, mistakes: list[Mistake]) -> Iterator[Aim]:
    """Give the aim of a goal; what is wrong with it goes to `mistakes`."""
    place = ("goal", i)
    if goal.closest is not None:
        yield from _target(goal, place, setting, mistakes)
        return
    word, name = ("highest", goal.highest) if goal.highest is not None else ("lowest", goal.lowest)
    aim = _aim((*place, word), str(name), word, goal, setting, mistakes)
    if aim is not None:
        yield aim


def limit_of(limit: Limit, i: int, setting: Setting, mistakes: list[Mistake]) -> Iterator[Aim]:
    """Give the aims of a limit, one for each side; what is wrong with it goes to `mistakes`."""
    for word, written in (("at_least", limit.at_least), ("at_most", limit.at_most)):
        if written is None:
            continue
        before = len(mistakes)
        aim = _aim(("limits", i, "of"), limit.of, word, limit, setting, mistakes)
        if aim is None or len(mistakes) > before:
            return  # one side says what is wrong
        try:
            bound = _bound(written, aim.unit)
        except ValueError as error:
            mistakes.append((("limits", i, word), str(error), written))
            continue
        unit = f" {aim.unit}" if aim.unit and not isinstance(written, str) else ""
        title = f"{aim.title} {word.replace('_', ' ')} {written}{unit}"
        yield replace(aim, place=("limits", i, word), title=title, bound=bound)


def _bound(written: Any, unit: str) -> float:
    value = parse_quantity(written, unit)
    if not np.isfinite(value):
        raise ValueError(f"{show(written)} is not finite")
    return value


def _aim(
    place: tuple[str | int, ...], written: str, word: str, item: Goal | Limit, setting: Setting, mistakes: list[Mistake]
) -> Aim | None:
    """Return the aim of a goal or a limit, the latter's bound left out; None where it is wrong."""
    name, sign = written.replace(" ", ""), 1.0 if word in ("highest", "at_least") else -1.0
    title = name if word.startswith("at_") else f"{word} {name}"
    rating = (_IN_OCTAVES if setting.grid.bands == "octaves" else RATINGS).get(name)
    aim = Aim(place, name, title, sign, setting.grid, rating=rating)
    if name not in MEASURES:
        mistakes.append((place, f"there is no '{written}'; {suggest(name, MEASURES)}", written))
    elif name not in SPECTRA and (item.start is not None or item.stop is not None):
        mistakes.append((place[:-1], f"{name} has no band: leave out 'from' and 'to'", None))
    elif name in SIZES:
        return aim
    elif reason := _missing(name, name if name in SPECTRA else RATINGS[name].quantity, rating, setting):
        mistakes.append((place, reason, written))
    elif rating is not None:
        return aim
    else:
        return _in_band(aim, item, mistakes)
    return None


def _in_band(aim: Aim, item: Goal | Limit, mistakes: list[Mistake]) -> Aim | None:
    """Return an aim of a spectrum with the frequencies that count; None where there are none."""
    grid = aim.grid
    low, high = _ends(item, grid)
    kept = (grid.frequency >= low) & (grid.frequency <= high)
    if not np.any(kept):
        text = f"none of the file's frequencies lies there: {_shown(grid)}; ask for others by 'frequency'"
        mistakes.append((aim.place[:-1], text, None))
        return None
    if item.start is None and item.stop is None:
        return replace(aim, kept=kept)
    f = grid.frequency[kept]
    band = f"from {f[0]:g} to {f[-1]:g} Hz" if len(f) > 1 else f"at {f[0]:g} Hz"
    return replace(aim, title=f"{aim.title} {band}", kept=kept)


def _ends(item: Goal | Limit, grid: Grid) -> tuple[float, float]:
    """Return first and last frequency, Hz; of bands the centres of those that hold them."""
    low, high = item.start or 0.0, item.stop or np.inf
    if grid.bands is None:
        return low * (1 - 1e-9), high * (1 + 1e-9)
    low = float(nearest_centres(low, grid.bands)) if low else low
    return low, float(nearest_centres(high, grid.bands)) if np.isfinite(high) else high


def _shown(grid: Grid) -> str:
    return f"{grid.frequency.min():g} to {grid.frequency.max():g} Hz"


def _missing(name: str, quantity: str, rating: Rating | None, setting: Setting) -> str:
    """Return what a spectrum or a rating lacks; empty where it lacks nothing."""
    if quantity == "transmission_loss" and not setting.through:
        lack = "goes with a half-space behind: write 'termination: ambient'"
    elif quantity == "insertion_loss" and not setting.reference:
        lack = "goes with a reference: write 'reference: FILE', the stack it is compared with"
    elif name in SPECTRA:
        lack = ""
    elif quantity == "absorption" and setting.through:
        lack = "is of an absorber on a wall: write 'termination: rigid'; behind this stack sound goes on"
    elif rating is None:
        lack = "is made of third octaves: write 'frequency: {third_octaves: [100 Hz, 5 kHz]}'"
    else:
        lack = _missing_bands(quantity, rating, setting.grid)
    return f"{name} {lack}" if lack else ""


def _missing_bands(quantity: str, rating: Rating, grid: Grid) -> str:
    there = grid.by_band(QUANTITIES[quantity].mean, np.full(len(grid.frequency), 0.5))
    try:
        rating.true(dict.fromkeys(there, 0.5))
    except InputError as error:
        return f"lacks bands ({error}): write 'frequency: {{third_octaves: [80 Hz, 5 kHz]}}'"
    return ""


def _target(goal: Goal, place: tuple[str | int, ...], setting: Setting, mistakes: list[Mistake]) -> Iterator[Aim]:
    if goal.quantity is not None and goal.quantity not in SPECTRA:
        mistakes.append(((*place, "quantity"), f"there is no such curve; {suggest(goal.quantity, SPECTRA)}", None))
        return
    try:
        curve = read_measured(setting.folder / str(goal.closest), goal.quantity)
    except InputError as error:
        reason = f"{error}; the path is relative to this file" if "no such file" in str(error) else str(error)
        mistakes.append(((*place, "closest"), reason, goal.closest))
        return
    name = _one_curve(curve)
    reason = "it holds none, or several, of a curve to meet: name it by 'quantity'" if name is None else ""
    if reason := reason or _missing(str(name), str(name), None, setting):
        mistakes.append(((*place, "closest"), reason, goal.closest))
        return
    assert name is not None
    there = np.isfinite(curve.quantities[name])
    f, values = curve.frequency[there], curve.quantities[name][there]
    low, high = _ends(goal, setting.grid)
    low, high = max(low, f[0] * (1 - 1e-9)), min(high, f[-1] * (1 + 1e-9))
    kept = (setting.grid.frequency >= low) & (setting.grid.frequency <= high)
    if not np.any(kept):
        text = f"none of the file's frequencies, {_shown(setting.grid)}, lies on this curve"
        mistakes.append(((*place, "closest"), text, goal.closest))
        return
    wanted = np.interp(np.log(setting.grid.frequency[kept]), np.log(f), values)
    title = f"closest to {curve.name} ({QUANTITIES[name].title})"
    yield Aim(place, name, title, -1.0, setting.grid, kept=kept, target=wanted)


def _one_curve(curve: Measured) -> str | None:
    names = [name for name in SPECTRA if name in curve.quantities]
    return names[0] if len(names) == 1 else None
