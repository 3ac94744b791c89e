"""Places at which something unmodelled may act, and laws of it that are drawn from the data.

An effect of unknown law at a place changes all measurements through one complex function of frequency, and mechanics
say how. With several configurations that function is over-determined: whether a place can be right is tested, and the
function is drawn. Errors embedded in a model: K. Sargsyan, X. Huan & H. N. Najm, Int. J. Uncertain. Quantif. 9 (2019)
365-394. Functions as Gaussian processes: C. E. Rasmussen & C. K. I. Williams, Gaussian Processes for Machine Learning,
MIT Press 2006, ch. 2.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import product
from types import MappingProxyType
from typing import Any, ClassVar, Literal, Self, TypeVar

import numpy as np
from scipy.special import ndtri

from multilayer.arrays import ComplexArray, RealArray
from multilayer.experiments.effects import BaseEffect, Values
from multilayer.inference.priors import Parameter, Prior, Priors

LENGTH, SHORT = 0.55, 0.14  # correlation lengths of a drawn law in ln f: of smooth ones, and of such as resonate
SPACING = 0.6  # of its nodes, in correlation lengths
_JITTER = 1e-9
AMPLITUDE = 0.3  # standard deviation of a simple law's amplitude, in units of the place's scale
SHIFT = 0.15  # standard deviation of ln f by which a law moves from configuration to configuration
VARIATION = 0.5  # standard deviation of a law that varies from configuration to configuration, as a share of it
_WORDS = {
    "lossy": "with losses", "fractional": "as a power of i w", "relaxation": "that relaxes",
    "resonance": "that resonates",
}  # fmt: skip
_RESONANCES = 16  # natural frequencies that are tried
H = TypeVar("H", bound=Callable[..., Any])
_OFFSET = Parameter(name="offset", prior=Prior(normal=(0.0, 1.0)))


def changes_nothing(hook: H) -> H:
    """Mark the hook of a base class that returns its argument."""
    hook.changes_nothing = True  # type: ignore[attr-defined]
    return hook


class BasePlace:
    """Where something unmodelled may act: base class of the places of a rig and of a tube.

    A law at a place is a complex function of frequency, `values` in the hooks of subclasses, in the place's unit. Hooks
    must be analytic in it, and return their argument where it is 0.

    Attributes
    ----------
    name : str
        By which files and results name it.
    kind : str
        Of what it is a place: that of the effects there.
    title : str
        For people.
    quantity, unit : str
        What the law is, and in which unit.
    variant : str
        Which of several ways it is in which a law can act there; empty of the usual one.
    configuration : str
        Its name, of a place in one configuration only; a layer's, of a place in one layer.
    moved : mapping
        ln of the law's frequencies in a configuration over those of the law as it is told, by the configuration's name;
        0 where it has no entry.
    factors : mapping
        By what the law is multiplied in a configuration, by the configuration's name; `usual_factor` where it has no
        entry, and 1 everywhere without any.
    differs_by : str
        What `factors` differ by, as `Hypothesis.pieces` or "configuration".
    terms : mapping
        What simple laws are called here, with their units: of a law in proportion to ``(i w)^n`` by n, and the law
        ``value/(1 - (f/f0)^2/(1 + i eta))`` under "resonance".
    needs_finite_elements : bool
        Whether the law stands beside a free rim in finite elements.
    acts_by_bin : bool
        As `BaseEffect.acts_by_bin`.
    detunes : bool
        Whether a law moves a resonance so far that a search from none goes astray: it begins at the best constant.
    known_values : tuple of complex
        Values of a law that are tried at the start besides, in its unit.
    passive_sign : int
        Sign of the real or imaginary part of the law of a passive thing, of a change together with what it changes
        (`departs_from`); 0 where the law is not that of a thing.
    passive_part : {'imag', 'real'}
        Which part that is.
    is_reading : bool
        Whether it is in what a channel or an instrument shows: of no thing, and as likely ahead as behind.
    is_real : bool
        Whether the law is a real function of frequency, as of levels: hooks need not be analytic then.
    length : float
        Correlation length of its law in ln f.
    changes_waves : bool
        Of a law for levels, whether it changes the response to plane waves: stack or sound field.
    usual_factor : float
        About which factors of a law that differs vary: 1, or 0 where an unknown takes up what is common to all.
    differs_already : bool
        Whether the law acts by what differs between configurations: with a factor for each it could be any of them.
    """

    kind: ClassVar[str]
    name: ClassVar[str]
    title: ClassVar[str]
    quantity: ClassVar[str]
    unit: ClassVar[str] = ""
    variant: ClassVar[str] = ""
    configuration: str = ""
    moved: Mapping[str, float] = MappingProxyType({})
    factors: Mapping[str, float] = MappingProxyType({})
    differs_by: str = "configuration"
    terms: ClassVar[Mapping[int | str, tuple[str, str]]] = {}
    needs_finite_elements: bool = False
    acts_by_bin: bool = False
    detunes: ClassVar[bool] = False
    known_values: ClassVar[tuple[complex, ...]] = ()
    passive_sign: ClassVar[int] = 0
    passive_part: ClassVar[Literal["imag", "real"]] = "imag"
    is_reading: ClassVar[bool] = False
    is_real: ClassVar[bool] = False
    length: ClassVar[float] = LENGTH
    changes_waves: ClassVar[bool] = True
    usual_factor: ClassVar[float] = 1.0
    differs_already: ClassVar[bool] = False

    @property
    def label(self) -> str:
        """Name, with the configuration where it is in one only."""
        return f"{self.name}[{self.configuration}]" if self.configuration else self.name

    @classmethod
    def variants(cls) -> tuple[type[Any], ...]:
        """Return the classes of this place, one for each way in which a law can act there; all have its name."""
        return (cls,)

    @classmethod
    def instances(cls, settings: tuple[Any, ...]) -> list[Any]:
        """Return the places of this kind in a campaign or a series of measurements: usually one of each variant."""
        return [kind() for kind in cls.variants()]

    @property
    def modelled(self) -> str:
        """What is modelled there beneath the law, in words; empty where that is nothing."""
        return ""

    @property
    def can_move(self) -> bool:
        """Whether its law may be tried with frequencies or sizes that differ from configuration to configuration."""
        return not (self.configuration or self.needs_finite_elements or self.modelled)

    def differing(
        self,
        moved: Mapping[str, float] = MappingProxyType({}),
        factors: Mapping[str, float] = MappingProxyType({}),
        by: str = "configuration",
    ) -> Self:
        """Return the place with a law that differs from configuration to configuration (`moved`, `factors`)."""
        place = copy(self)
        for name, value in {"moved": dict(moved), "factors": dict(factors), "differs_by": by}.items():
            object.__setattr__(place, name, value)  # some are frozen
        return place

    @property
    def differences(self) -> tuple[Mapping[str, float], Mapping[str, float], str]:
        """How its law differs, as `differing` takes it."""
        return self.moved, self.factors, self.differs_by

    def factor_in(self, setting: Any) -> float:
        """Return by what the law as it is told is multiplied in a configuration."""
        return self.factors.get(setting.configuration.name, self.usual_factor) if self.factors else 1.0

    def law_frequency(self, setting: Any) -> RealArray:
        """Return the frequencies at which the law as it is told acts on a configuration's data, Hz, shape (n,)."""
        shift = self.moved.get(setting.configuration.name, 0.0) if self.moved else 0.0
        return np.asarray(setting.frequency * math.exp(-shift) if shift else setting.frequency)

    @property
    def tells_more(self) -> bool:
        """Whether there is more to tell than the words of the law."""
        return bool(self.modelled or self.moved or self.factors)

    @property
    def entry(self) -> dict[str, Any]:
        """What tells it from others of its name, as ``diagnosis.json`` and files of a saved law have it."""
        found: dict[str, Any] = {}
        if self.variant:
            found["variant"] = self.variant
        if self.configuration:
            found["configuration"] = self.configuration
        if self.needs_finite_elements:
            found["free_rim"] = True
        if self.moved:
            found["moved"] = {name: math.exp(shift) for name, shift in self.moved.items()}
        if self.factors:
            found |= {"factors": dict(self.factors), "differs_by": self.differs_by}
        return found

    def in_words(self, law: str) -> str:
        """Return what acts there, given the words of the law."""
        text = f"{self.modelled}, and beyond it {law}" if self.modelled else law
        if self.factors:
            ends = (f"{end(self.factors.values()):.2g}" for end in (min, max))
            by = self.differs_by
            text = f"{text}, times a factor that differs from {by} to {by} ({' to '.join(ends)})"
        if not self.moved:
            return text
        low, high = (100 * math.expm1(end(self.moved.values())) for end in (min, max))
        return f"{text}, at frequencies that move from configuration to configuration ({low:+.0f} to {high:+.0f} %)"

    def scale(self, settings: tuple[Any, ...], modulus: float) -> float:
        """Return a value of the law that changes the data by about their own size.

        Parameters
        ----------
        settings : tuple
            All configurations.
        modulus : float
            The nominal model's, absolute, Pa; 1 of a tube.
        """
        return 1.0

    def departs_from(self, setting: Any, frequency: RealArray) -> ComplexArray | None:
        """Return what the law is a change of, at frequencies in Hz of shape (n,), in the law's unit.

        None where the law is all there is, or the configuration lacks what changes.
        """
        return None


class LawAtPlace(BaseEffect):
    """An effect that is a law at a place: base class of drawn laws and of simple forms.

    It has the hooks of all kinds of effects, and hands each on to its place.
    """

    at_place: Any
    acts_through_place = False  # it is the free law itself
    moves_resonances: ClassVar[bool] = False
    changes_gas: ClassVar[bool] = False

    @property
    def needs_finite_elements(self) -> bool:  # type: ignore[override]
        """Whether its place does."""
        return bool(self.at_place.needs_finite_elements)

    @property
    def acts_by_bin(self) -> bool:  # type: ignore[override]
        """Whether its place does."""
        return bool(self.at_place.acts_by_bin)

    @property
    def changes_waves(self) -> bool:
        """Whether its place does."""
        return bool(self.at_place.changes_waves)

    def values(self, setting: Any, values: Values) -> ComplexArray:
        """Return the law, shape (..., n), in the place's unit."""
        raise NotImplementedError

    def _changes(self, hook: str) -> bool:
        """Tell whether its place acts through a hook; where it does not, the law need not be evaluated."""
        return not getattr(getattr(type(self.at_place), hook, None), "changes_nothing", False)

    def applies(self, setting: Any) -> bool:
        """Tell whether it can act: a place is one of the measurements that it was made for."""
        return True

    def modulus(self, setting: Any, modulus: ComplexArray, values: Values) -> Any:
        """Return the modulus as the place changes it."""
        if not self._changes("modulus"):
            return modulus
        return self.at_place.modulus(setting, modulus, self.values(setting, values))

    def chain(self, setting: Any, chain: Any, values: Values) -> Any:
        """Return the rods and masses as the place changes them."""
        if not self._changes("chain"):
            return chain
        return self.at_place.chain(setting, chain, self.values(setting, values))

    def motion(self, setting: Any, motion: ComplexArray, values: Values) -> Any:
        """Return the reading as the place changes it."""
        if not self._changes("motion"):
            return motion
        return self.at_place.motion(setting, motion, self.values(setting, values))

    def stack(self, setting: Any, stack: Any, values: Values) -> Any:
        """Return the stack as the place changes it."""
        if not self._changes("stack"):
            return stack
        return self.at_place.stack(setting, stack, self.values(setting, values))

    def sound_field(self, setting: Any, sound: Any, values: Values) -> Any:
        """Return the sound field as the place changes it."""
        if not self._changes("sound_field"):
            return sound
        return self.at_place.sound_field(setting, sound, self.values(setting, values))

    def beside(self, setting: Any, stack: Any, share: RealArray, values: Values) -> Any:
        """Return the share of the power that gets through, or is absorbed, as the place changes it."""
        if not self._changes("beside"):
            return share
        return self.at_place.beside(setting, stack, share, self.values(setting, values))

    def surface(self, setting: Any, stack: Any, reflection: ComplexArray, values: Values) -> Any:
        """Return the reflection of the tube's end as the place changes it."""
        if not self._changes("surface"):
            return reflection
        return self.at_place.surface(setting, stack, reflection, self.values(setting, values))

    def reading(self, setting: Any, reflection: ComplexArray, values: Values) -> Any:
        """Return the reflection, or the level, as it is reported."""
        if not self._changes("reading"):
            return reflection
        return self.at_place.reading(setting, reflection, self.values(setting, values))


@dataclass(frozen=True, eq=False)
class DrawnLaw(LawAtPlace):
    """A free function of frequency at a place: a Gaussian process in ln f, by its values at nodes.

    It is complex, or real where the place says so (`BasePlace.is_real`).

    Attributes
    ----------
    at_place : BasePlace
    nodes : array, shape (k,)
        ln f.
    size : float or array, shape (k,)
        Standard deviation of real and imaginary part, in the place's unit; an array at nodes, powers of f between them.
    length : float
        Correlation length in ln f.
    """

    at_place: Any
    nodes: RealArray
    size: float | RealArray
    length: float = LENGTH
    name: str = ""
    parameters: tuple[Parameter, ...] = field(default=(), repr=False)
    law_error: float = 0.0

    @classmethod
    def at(cls, place: Any, frequency: RealArray, size: float, length: float = LENGTH) -> DrawnLaw:
        """Return a law for data at frequencies, Hz."""
        low, high = np.log(frequency.min()), np.log(frequency.max())
        nodes = np.linspace(low, high, max(int(np.ceil((high - low) / (SPACING * length))) + 1, 2))
        parameters = tuple(
            Parameter(name=f"{part}[{np.exp(node):.4g}]", prior=Prior(normal=(0.0, 1.0)))
            for part in (("real",) if place.is_real else ("real", "imag"))
            for node in nodes
        )
        return cls(place, nodes, size, length, name=place.label, parameters=parameters)

    @cached_property
    def with_offset(self) -> DrawnLaw:
        """The law with a last parameter that is added to it, in standard deviations; for derivatives."""
        return replace(self, parameters=(*self.parameters, _OFFSET))

    def basis(self, frequency: RealArray) -> RealArray:
        """Return the change of the law over its size by each node's coordinate, shape (n, k)."""
        return _basis(self.nodes.tobytes(), self.length, np.asarray(frequency, dtype=float).tobytes())

    def constant(self, value: complex) -> RealArray:
        """Return the coordinates, shape (2 k,), of a law that is the same at all nodes, in standard deviations.

        Of a real law shape (k,).
        """
        weights = np.linalg.solve(self.basis(np.exp(self.nodes)), np.ones(len(self.nodes)))
        parts = (value.real,) if self.at_place.is_real else (value.real, value.imag)
        return np.concatenate([part * weights for part in parts])

    def values(self, setting: Any, values: Values) -> ComplexArray:
        """Return the law."""
        z = np.concatenate([values[parameter.name] for parameter in self.parameters], axis=-1)
        return np.asarray(self.drawn(z, self.at_place.law_frequency(setting)) * self.at_place.factor_in(setting))

    def by_parameters(self, setting: Any, z: RealArray) -> ComplexArray:
        """Return the derivative of the law by its coordinates z, over that by its offset, shape (n, 2 k).

        Of a complex law.
        """
        basis = self.basis(self.at_place.law_frequency(setting))
        return np.concatenate([basis, 1j * basis], axis=-1)

    def drawn(self, z: RealArray, frequency: RealArray) -> ComplexArray:
        """Return the law, shape (..., n), in the place's unit, of its parameters, shape (..., 2 k); (..., k) if real.

        One more is the offset of `with_offset`.
        """
        k, of_nodes = len(self.nodes), self.basis(frequency).T
        law, rest = z[..., :k] @ of_nodes, z[..., k:]
        if not self.at_place.is_real:
            law, rest = law + 1j * (z[..., k : 2 * k] @ of_nodes), z[..., 2 * k :]
        if rest.size:
            law = law + rest
        return np.asarray(self._size_at(frequency) * law)

    def _size_at(self, frequency: RealArray) -> RealArray | float:
        if not isinstance(self.size, np.ndarray):
            return self.size
        return np.asarray(np.exp(np.interp(np.log(frequency), self.nodes, np.log(self.size))))


@dataclass(frozen=True, eq=False)
class DifferingLaw(DrawnLaw):
    """A free function that differs from configuration to configuration, by one unknown in each or for each piece.

    The first parameters are those of the function, the last ones those unknowns.

    Attributes
    ----------
    pieces : mapping
        By the configuration's name, that of what is in it; what has the same name differs alike.
    by : str
        What they are.
    """

    pieces: Mapping[str, str] = field(default_factory=dict)
    by: str = "configuration"
    what: ClassVar[str]

    @classmethod
    def of(cls, law: DrawnLaw, pieces: Mapping[str, str], by: str = "configuration") -> Self:
        """Return the law that is free to differ."""
        prior = cls._prior(law.at_place)
        of_pieces = (Parameter(name=cls._name(piece), prior=prior) for piece in dict.fromkeys(pieces.values()))
        parameters = (*law.parameters, *of_pieces)
        return cls(law.at_place, law.nodes, law.size, law.length, law.name, parameters, pieces=dict(pieces), by=by)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The pieces."""
        return (*dict.fromkeys(self.pieces.values()),)

    @classmethod
    def _prior(cls, place: BasePlace) -> Prior:
        """Return the prior of what differs."""
        raise NotImplementedError

    @classmethod
    def _name(cls, piece: str) -> str:
        return f"{cls.what}[{piece}]"

    def _unknown(self, setting: Any, values: Values) -> RealArray:
        """Return the unknown of a configuration."""
        return values[self._name(self.pieces[setting.configuration.name])]

    def _index(self, setting: Any) -> int:
        """Return which of the unknowns that is."""
        return self.names.index(self.pieces[setting.configuration.name])

    def place_at(self, z: RealArray) -> Any:
        """Return the place with a law that differs as at the coordinates z, shape (2 k + c,)."""
        values = self._prior(self.at_place).value(z[-len(self.names) :])
        by_piece = dict(zip(self.names, map(float, values), strict=True))
        return self._differing({name: by_piece[piece] for name, piece in self.pieces.items()})

    def coordinates(self, by_configuration: Mapping[str, float]) -> RealArray:
        """Return the unknowns' coordinates, shape (c,), as what differs is given; of a piece, the mean."""
        found = [np.mean([by_configuration[n] for n, p in self.pieces.items() if p == piece]) for piece in self.names]
        return np.asarray(self._prior(self.at_place).coordinate(np.array(found)))

    def _differing(self, values: Mapping[str, float]) -> Any:
        raise NotImplementedError

    def _function(self, values: Values) -> RealArray:
        """Return the coordinates of the function."""
        count = 2 * len(self.nodes)  # its offset, where it has one, stands last
        of_function = (*self.parameters[:count], *self.parameters[count + len(self.names) :])
        return np.concatenate([values[parameter.name] for parameter in of_function], axis=-1)

    def _with_slope(self, setting: Any, basis: RealArray, slope: ComplexArray) -> ComplexArray:
        """Return derivatives by the function's coordinates and by the unknowns, of which one acts here."""
        more = np.zeros((len(basis), len(self.names)), dtype=complex)
        more[:, self._index(setting)] = slope
        return np.concatenate([basis, 1j * basis, more], axis=-1)


@dataclass(frozen=True, eq=False)
class MovingLaw(DifferingLaw):
    """A free function whose frequencies differ from configuration to configuration, by shifts of ln f."""

    what = "shift"

    @classmethod
    def _prior(cls, place: BasePlace) -> Prior:
        return Prior(normal=(0.0, SHIFT))

    def _differing(self, values: Mapping[str, float]) -> Any:
        return self.at_place.differing(values, *self.at_place.differences[1:])

    def values(self, setting: Any, values: Values) -> ComplexArray:
        """Return the law."""
        z, shifts = self._function(values), self._unknown(setting, values)[..., 0]
        law = np.empty((len(z), len(setting.frequency)), dtype=complex)
        for shift in np.unique(shifts):  # one, but for differences
            rows = shifts == shift
            law[rows] = self.drawn(z[rows], setting.frequency * np.exp(-shift))
        return np.asarray(law * self.at_place.factor_in(setting))

    def by_parameters(self, setting: Any, z: RealArray) -> ComplexArray:
        """Return the derivative of the law by its coordinates z, over that by its offset, shape (n, 2 k + c)."""
        k, own = len(self.nodes), self._index(setting)
        frequency = setting.frequency * np.exp(-SHIFT * z[2 * k + own])
        slope = _basis_slope(self.nodes, self.length, frequency) @ (z[:k] + 1j * z[k : 2 * k])
        by_shift: ComplexArray = np.asarray(-SHIFT * slope, dtype=complex)
        return self._with_slope(setting, self.basis(frequency), by_shift)


@dataclass(frozen=True, eq=False)
class VaryingLaw(DifferingLaw):
    """A free function times a factor that differs from configuration to configuration, as samples and mountings do."""

    what = "factor"

    @classmethod
    def _prior(cls, place: BasePlace) -> Prior:
        return Prior(normal=(place.usual_factor, VARIATION))

    def _differing(self, values: Mapping[str, float]) -> Any:
        return self.at_place.differing(self.at_place.moved, values, self.by)

    def values(self, setting: Any, values: Values) -> ComplexArray:
        """Return the law."""
        frequency, factor = self.at_place.law_frequency(setting), self._unknown(setting, values)
        z, offset = np.split(self._function(values), [2 * len(self.nodes)], axis=-1)
        law = factor * self.drawn(z, frequency)
        return np.asarray(law + self._size_at(frequency) * offset if offset.size else law)

    def by_parameters(self, setting: Any, z: RealArray) -> ComplexArray:
        """Return the derivative of the law by its coordinates z, over that by its offset, shape (n, 2 k + c)."""
        k, own = len(self.nodes), self._index(setting)
        basis = self.basis(self.at_place.law_frequency(setting))
        slope: ComplexArray = np.asarray(VARIATION * (basis @ (z[:k] + 1j * z[k : 2 * k])), dtype=complex)
        return self._with_slope(setting, (self.at_place.usual_factor + VARIATION * z[2 * k + own]) * basis, slope)


@dataclass(frozen=True, eq=False)
class LawError(DrawnLaw):
    """What the law of a known effect misses at its place: a free function, small beside the law itself.

    Attributes
    ----------
    error_of : str
        Name of the effect.
    absent_in : str
        The experiment that takes the effect away.
    """

    error_of: str = ""
    absent_in: str = ""  # type: ignore[misc]

    @property
    def place(self) -> str:  # type: ignore[override]
        """Name of its place, as effects have it."""
        return str(self.at_place.name)

    @classmethod
    def of(
        cls, effect: BaseEffect, place: Any, frequency: RealArray, size: RealArray | float, length: float
    ) -> LawError:
        """Return the error of an effect's law at a place, for data at frequencies, Hz."""
        law = DrawnLaw.at(place, frequency, 1.0, length)
        name = f"error_of_{effect.name}"
        return cls(place, law.nodes, size, length, name, law.parameters, 0.0, effect.name, effect.absent_in)


@lru_cache(maxsize=256)
def _basis(nodes: bytes, length: float, frequency: bytes) -> RealArray:
    """Return the basis of `DrawnLaw`, of arrays as bytes: a fit asks for the same again and again."""
    at, f = np.frombuffer(nodes) / length, np.frombuffer(frequency)
    basis = _by_coordinates(at, _kernel(at, np.log(f) / length))
    basis.setflags(write=False)
    return basis


def _basis_slope(nodes: RealArray, length: float, frequency: RealArray) -> RealArray:
    """Return the derivative of the basis of `DrawnLaw` by ln f, shape (n, k)."""
    at, x = nodes / length, np.log(frequency) / length
    return _by_coordinates(at, _kernel(at, x) * np.subtract.outer(at, x) / length)


def _by_coordinates(at: RealArray, by_values: RealArray) -> RealArray:
    """Return what is linear in a process's values at nodes, shape (k, n), by its coordinates, shape (n, k)."""
    root = np.linalg.cholesky(_kernel(at, at) + _JITTER * np.eye(len(at)))
    return np.asarray(np.linalg.solve(root, by_values).T)


def _kernel(a: RealArray, b: RealArray) -> RealArray:
    return np.asarray(np.exp(-0.5 * np.subtract.outer(a, b) ** 2))


@dataclass(frozen=True)
class Term:
    """A simple law of a few parameters, real in time.

    Attributes
    ----------
    kind : {'power', 'lossy', 'fractional', 'relaxation', 'resonance'}
        ``a (i w)^n``; ``a (1 + i eta)``; ``a (i w/w0)^p``; ``a/(1 + i f/fc)``; ``a/(1 - (f/f0)^2/(1 + i eta))``.
    order : int
        n of the first.
    """

    kind: Literal["power", "lossy", "fractional", "relaxation", "resonance"]
    order: int = 0

    @property
    def key(self) -> int | str:
        """Under which `Place.terms` names it."""
        return "resonance" if self.kind == "resonance" else self.order

    @property
    def count(self) -> int:
        """Number of its parameters."""
        return {"power": 1, "resonance": 3}.get(self.kind, 2)

    @property
    def words(self) -> str:
        """The law in words."""
        powers = {0: "constant", 1: "in proportion to i w", -1: "as 1/(i w)", 2: "as (i w)^2", -2: "as 1/(i w)^2"}
        return powers[self.order] if self.kind == "power" else _WORDS[self.kind]

    def real_words(self, centre: float) -> str:
        """Return a real law in words; its amplitude is that at the centre, Hz."""
        powers = {0: "constant", 1: "in proportion to f", -1: "as 1/f", 2: "as f^2", -2: "as 1/f^2"}
        words = powers[self.order] if self.kind == "power" else "as a power of f"
        return words if self.key == 0 and self.kind == "power" else f"{words}, at {centre:.0f} Hz"

    def parameters(self, scale: float, band: tuple[float, float]) -> tuple[Parameter, ...]:
        """Return amplitude at the band's centre, in the place's unit, then what else the law has."""
        low, high = band
        amplitude = Parameter(name="amplitude", prior=Prior(normal=(0.0, AMPLITUDE * scale)))
        loss = Parameter(name="loss_factor", prior=Prior(loguniform=(0.003, 1.0)))
        rest: dict[str, tuple[Parameter, ...]] = {
            "power": (),
            "lossy": (Parameter(name="loss_factor", prior=Prior(normal=(0.0, 0.5))),),
            "fractional": (Parameter(name="exponent", prior=Prior(normal=(0.0, 0.7))),),
            "relaxation": (Parameter(name="frequency", prior=Prior(loguniform=(low / 3, 3 * high)), unit="Hz"),),
            "resonance": (Parameter(name="frequency", prior=Prior(loguniform=(low / 2, 2 * high)), unit="Hz"), loss),
        }
        return (amplitude, *rest[self.kind])

    def starts(self) -> list[tuple[float, ...]]:
        """Return standard normal coordinates to start from."""
        amplitudes = (-0.7, -0.1, 0.1, 0.7)
        if self.kind == "resonance":
            places = ndtri((np.arange(_RESONANCES) + 0.5) / _RESONANCES)
            return [(a, float(x), eta) for a in (-0.1, 0.1) for x in places for eta in (1.2,)]
        further = {"power": (), "lossy": (0.0,), "fractional": (0.0,), "relaxation": (0.0,)}[self.kind]
        return [(a, *further) for a in amplitudes]

    def values(
        self, frequency: RealArray, centre: float, values: Sequence[RealArray], *, is_real: bool = False
    ) -> ComplexArray:
        """Return the law, shape (..., n), of parameters of shape (..., 1); a real one has f in place of i w."""
        amplitude, *rest = values
        turn = frequency / centre if is_real else 1j * frequency / centre
        if self.kind == "power":
            return np.asarray(amplitude * turn**self.order)
        if self.kind == "lossy":
            return np.asarray(amplitude * (1 + 1j * rest[0]))
        if self.kind == "fractional":
            return np.asarray(amplitude * turn ** rest[0])
        if self.kind == "relaxation":
            return np.asarray(amplitude / (1 + 1j * frequency / rest[0]))
        return np.asarray(amplitude / (1 - (frequency / rest[0]) ** 2 / (1 + 1j * rest[1])))


@dataclass(frozen=True, eq=False)
class SimpleLaw(LawAtPlace):
    """A sum of simple laws at a place.

    Attributes
    ----------
    at_place : BasePlace
    terms : tuple of Term
    centre : float
        Geometric centre of the band, Hz, at which amplitudes are stated.
    """

    at_place: Any
    terms: tuple[Term, ...]
    centre: float
    name: str = ""
    parameters: tuple[Parameter, ...] = field(default=(), repr=False)
    starts: tuple[tuple[float, ...], ...] = field(default=(), repr=False)
    law_error: float = 0.0

    @classmethod
    def at(cls, place: Any, terms: Sequence[Term], frequency: RealArray, scale: float) -> SimpleLaw:
        """Return a sum of laws for data at frequencies, Hz; `scale` is that of the place."""
        band = float(frequency.min()), float(frequency.max())
        parameters = tuple(
            parameter.model_copy(update={"name": f"{number}.{parameter.name}"})
            for number, term in enumerate(terms)
            for parameter in term.parameters(scale, band)
        )
        starts = tuple(sum(each, ()) for each in product(*(term.starts() for term in terms)))
        return cls(place, tuple(terms), math.sqrt(band[0] * band[1]), place.label, parameters, starts)

    @property
    def is_resonant(self) -> bool:
        """Whether its last term is a resonance."""
        return self.terms[-1].kind == "resonance"

    def values(self, setting: Any, values: Values) -> ComplexArray:
        """Return the law."""
        law = self.law_at(
            self.at_place.law_frequency(setting), [values[parameter.name] for parameter in self.parameters]
        )
        return np.asarray(law * self.at_place.factor_in(setting))

    def curve(self, z: RealArray, frequency: RealArray) -> ComplexArray:
        """Return the law, shape (..., n), of coordinates of shape (..., k)."""
        return self.law_at(frequency, list(np.moveaxis(Priors.of(self.parameters).values(z), -1, 0)[..., None]))

    def law_at(self, frequency: RealArray, values: Sequence[RealArray]) -> ComplexArray:
        """Return the law, shape (..., n), of all parameters in their order, of shape (..., 1)."""
        is_real = self.at_place.is_real
        total, rest = np.zeros(frequency.shape, dtype=float if is_real else complex), list(values)
        for term in self.terms:
            total = total + term.values(frequency, self.centre, rest[: term.count], is_real=is_real)
            rest = rest[term.count :]
        return total


@dataclass(frozen=True, eq=False)
class TabulatedLaw(LawAtPlace):
    """A law at a place that another campaign has shown: a table, each value with a normal prior.

    Values between are interpolated in ln f; beyond the table its ends hold.

    Attributes
    ----------
    at_place : BasePlace
    nodes : array, shape (k,)
        ln f.
    """

    at_place: Any
    nodes: RealArray
    name: str = ""
    parameters: tuple[Parameter, ...] = field(default=(), repr=False)
    law_error: float = 0.0

    @classmethod
    def of(cls, place: Any, name: str, frequency: RealArray, mean: ComplexArray, std: ComplexArray) -> TabulatedLaw:
        """Return the law with means and standard deviations of real and imaginary part, shape (k,) each."""
        parts = (("real", mean.real, std.real), ("imag", mean.imag, std.imag))
        parameters = tuple(
            Parameter(name=f"{part}[{f:.4g}]", prior=Prior(normal=(float(value), float(spread))), unit=place.unit)
            for part, values, spreads in parts
            for f, value, spread in zip(frequency, values, spreads, strict=True)
        )
        return cls(place, np.log(frequency), name, parameters)

    def values(self, setting: Any, values: Values) -> ComplexArray:
        """Return the law."""
        k = len(self.nodes)
        at = np.clip(np.log(self.at_place.law_frequency(setting)), self.nodes[0], self.nodes[-1])
        weights = np.stack([np.interp(at, self.nodes, row) for row in np.eye(k)])
        table = np.stack([values[parameter.name][..., 0] for parameter in self.parameters], axis=-1)
        law = (table[..., :k] + 1j * table[..., k:]) @ weights
        return np.asarray(law * self.at_place.factor_in(setting))
