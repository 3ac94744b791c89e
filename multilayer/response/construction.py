"""A wall as it is built: a stack, and what else lets sound through."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from multilayer.arrays import RealArray
from multilayer.bounds import LAYERS
from multilayer.errors import InputError, Problem
from multilayer.models import refuse
from multilayer.response.beside import Beside, Flanking, Hole, Patch, Shares, Slit, Sound, stack_shares
from multilayer.response.finite_size import Window
from multilayer.response.linked_transmission import linked_transmission
from multilayer.response.links import Links, periodic, wrong_links
from multilayer.stack import Stack
from multilayer.units import Area

Mistake = tuple[tuple[str | int, ...], str, Any]
_ROUNDING = 5e-3  # of the power that arrives: transmission with links is known to 2e-3


class Construction(Stack):
    """A stack with what lies beside it in a wall of some `area`, and links between its leaves; without, the stack.

    Every path answers as if it were alone, and powers add up: ``tau = (S0 tau0 + sum S_i tau_i)/S + sum tau_flanking``,
    the absorption likewise. S0 is what patches and openings leave of the area.
    """

    area: Area | None = None
    beside: Annotated[tuple[Beside, ...], Field(max_length=LAYERS.usual)] = ()
    links: Annotated[tuple[Links, ...], Field(max_length=LAYERS.usual)] = ()

    @model_validator(mode="after")
    def _is_a_wall(self) -> Self:
        refuse(self, [*self._same_names(), *self._wrong_areas(), *self._wrong_ends(), *wrong_links(self, self.links)])
        return self

    def _same_names(self) -> Iterator[Mistake]:
        seen = set[str]()
        places = [("beside", i, path.name) for i, path in enumerate(self.beside)]
        places += [("links", i, these.name) for i, these in enumerate(self.links)]
        for key, i, name in places:
            if name is not None and name in seen:
                yield (key, i, "name"), f"another path is called '{name}' already; names must differ", name
            seen.add(name or "")

    def _wrong_areas(self) -> Iterator[Mistake]:
        taken = sum(path.taken for path in self.beside)
        if taken and self.area is None:
            yield ("area",), "is missing: the area of the whole wall, of which patches and openings take a part", None
        elif self.area is not None and taken >= self.area:
            text = f"patches and openings take {taken:g} m2 of {self.area:g} m2; nothing is left of this stack"
            yield ("area",), text, self.area

    def _wrong_ends(self) -> Iterator[Mistake]:
        through = self.lets_through
        for i, path in enumerate(self.beside):
            if isinstance(path, Patch) and path.stack.lets_through != through:
                text = "this patch and the wall must end alike, in a half-space behind both or behind none"
                yield ("beside", i, "stack"), f"{text}; see their terminations", path.stack.termination
            elif not isinstance(path, Patch) and not through:
                text = f"a {path.type} leads nowhere behind this stack; write 'termination: ambient'"
                yield ("beside", i), text, path.type
            elif isinstance(path, Slit | Hole) and self.termination != "ambient":
                text = f"a {path.type} is filled and met by the ambient gas on both sides; write 'termination: ambient'"
                yield ("beside", i), text, path.type

    @property
    def is_plain(self) -> bool:
        """Whether it is no more than its stack."""
        return not (self.beside or self.links)


def paths(
    wall: Construction, frequency: RealArray, sound: Sound, window: Window | None = None, together: int = 1
) -> Mapping[str, Shares]:
    """Return how much each path transmits and absorbs, of the power that meets the whole wall.

    Parameters
    ----------
    wall : Construction
        Its fields hold numbers.
    frequency : array, shape (n_frequency,)
        Hz.
    sound : Sound
    window : Window, optional
        Size of the stack; patches have their own.
    together : int
        So many frequencies after each other are averaged by the caller; of links only their mean is exact.

    Returns
    -------
    mapping
        By name: ``stack``, ``links`` where there are some, and the others by their name or as ``slit 1``, by the order
        of `Construction.beside`. What links add to the transmission, below 0 where the wall transmits less with them,
        is taken from the wave that arrives, or given back to it: they add as much to the absorption, between none and
        all of that wave. So the wall's losses count as they are without links.

    Raises
    ------
    InputError
        When stack and single links would transmit more than arrives.
    """
    own = stack_shares(wall, frequency, sound, window)
    left = 1.0
    if wall.area is not None:
        left = 1 - sum(path.taken for path in wall.beside) / wall.area
    found = {"stack": _scaled(own, left)}
    if wall.links:
        linked = linked_transmission(
            wall,
            wall.links,
            frequency,
            sound.angle,
            max_angle=sound.max_angle,
            weighting=sound.weighting,
            window=window,
            together=together,
            alone=own.transmission,
        )
        assert own.transmission is not None  # by validation
        if not periodic(wall.links):
            _refuse_excess(linked, own.transmission, frequency, together)
        added = linked - own.transmission
        absorbed = np.clip(added, -own.absorption, np.maximum(1 - own.absorption, 0.0))
        found["links"] = Shares(left * added, left * absorbed)
    for i, path in enumerate(wall.beside, start=1):
        name = path.name or f"{path.type} {i}"
        if isinstance(path, Flanking):
            found[name] = Shares(path.transmission(frequency), np.zeros(np.shape(frequency)))
        else:
            assert wall.area is not None  # by validation
            shares = path.shares(frequency, wall.ambient, sound, finite=window is not None)
            found[name] = _scaled(shares, path.taken / wall.area)
    return found


def _refuse_excess(linked: RealArray, alone: RealArray, frequency: RealArray, together: int) -> None:
    """Refuse single links so close that they would let more through than arrives; edges of a small panel may."""
    through, most, centre = (
        np.mean(values.reshape(-1, together), axis=1) for values in (linked, np.maximum(alone, 1.0), frequency)
    )
    if np.any(excess := through > most * (1 + _ROUNDING)):
        first = int(np.argmax(excess))
        text = f"so close, these would let {through[first]:.3g} times as much through as arrives"
        text += f", at {centre[first]:.4g} Hz"
        remedy = "give them a wider spacing or, to lines, 'periodic: true'"
        raise InputError(Problem(f"{text}, as each is computed as if it were alone; {remedy}", "links"))


def _scaled(shares: Shares, factor: float) -> Shares:
    through = None if shares.transmission is None else factor * shares.transmission
    return Shares(through, factor * shares.absorption)


def wall_shares(
    wall: Construction, frequency: RealArray, sound: Sound, window: Window | None = None, together: int = 1
) -> Shares:
    """Return how much a wall transmits and absorbs, all paths together; parameters as of `paths`."""
    found = list(paths(wall, frequency, sound, window, together).values())
    through = [shares.transmission for shares in found if shares.transmission is not None]
    absorbed = np.sum([shares.absorption for shares in found], axis=0)
    return Shares(np.sum(through, axis=0) if through else None, absorbed)
