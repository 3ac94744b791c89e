"""Different layers side by side in a fine pattern."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import reduce
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from multilayer.arrays import Numeric
from multilayer.layers.base import Layer, LayerField
from multilayer.matrix.couplings import CouplingError
from multilayer.matrix.faces import Faces
from multilayer.matrix.parallel import reflections, side_by_side
from multilayer.matrix.wave import Wave
from multilayer.media.validity import warn_outside
from multilayer.models import Model, refuse
from multilayer.units import DIMENSIONLESS, Length, Unit

_WHOLE = 1e-6  # what shares may miss of 1
_MOST = 50


class FinePatch(Model):
    """One part of a pattern: its share of the area, its layers, bonded to each other, and whether a wall closes it.

    Fields: `share`, `layers` (from front to back), `closed` (by a rigid wall of its own: what lies behind the pattern
    does not hear it), `side_walls` (rigid ones between it and its neighbours, as of a chamber: sound runs along its
    depth alone, at any angle of incidence), `name`.
    """

    name: str | None = None
    share: Annotated[float, Field(gt=0, le=1), Unit(DIMENSIONLESS)]
    layers: Annotated[tuple[LayerField, ...], Field(min_length=1, max_length=_MOST)]
    closed: bool = False
    side_walls: bool = False


class Patches(Layer):
    """Stacks side by side in a pattern finer than half a wavelength: resonators beside foam, mosaics, slats over wool.

    Fields: `patches` (each a `share` of the area, `layers` and, with a rigid wall behind it alone, `closed`), `period`
    (m, after which the pattern repeats). State (p, v3). Patches share the pressures at both faces, so that air goes
    from one to the other in front of them (Verdiere et al. 2013). Inside, sound runs along the layers of a patch as it
    would if these went on beside it, so that a pattern of patches alike is one layer; with `side_walls` it does not.

    Holds for periods below half a wavelength (`ValidityWarning` beyond). Larger ones answer each for itself: `beside`
    of a simulation.
    """

    type: Literal["patches"] = "patches"
    patches: Annotated[tuple[FinePatch, ...], Field(min_length=1, max_length=_MOST)]
    period: Length

    summary: ClassVar[str] = "stacks side by side in a pattern finer than half a wavelength"
    composes: ClassVar[bool] = False
    vanishes: ClassVar[bool] = False

    @model_validator(mode="after")
    def _is_a_whole(self) -> Self:
        refuse(self, self._mistakes())
        return self

    def _mistakes(self) -> Iterator[tuple[tuple[str | int, ...], str, Any]]:
        whole = sum(patch.share for patch in self.patches)
        if abs(whole - 1) > _WHOLE:
            yield ("patches",), f"the shares sum up to {whole:g}; they must make 1", None
        if all(patch.closed for patch in self.patches):
            text = "all patches are closed, so that nothing hears what is behind; leave 'closed' out, and end the stack"
            yield ("patches",), f"{text} with 'termination: rigid'", None

    @property
    def isotropic_in_plane(self) -> bool:  # type: ignore[override]
        """Whether all layers are."""
        return all(layer.isotropic_in_plane for patch in self.patches for layer in patch.layers)

    @property
    def depth(self) -> Numeric:
        """That of the deepest patch, m."""
        depths = [sum(layer.depth for layer in patch.layers) for patch in self.patches]
        return reduce(np.maximum, depths)

    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices; see `matrix.parallel`."""
        waves = self.period * wave.frequency / wave.ambient.sound_speed
        warn_outside("the pattern of patches", "period / wavelength", waves, -np.inf, 0.5, wave.frequency)
        impedance, along_depth = wave.ambient.impedance, replace(wave, kx=np.zeros_like(wave.frequency))
        parts = []
        for i, patch in enumerate(self.patches):
            layers = [layer.faces(along_depth if patch.side_walls else wave) for layer in patch.layers]
            try:
                parts.append(reflections(layers, impedance, closed=patch.closed))
            except CouplingError as error:
                raise CouplingError(f"patch {patch.name or i}: {error}") from None
        return side_by_side([patch.share for patch in self.patches], parts, impedance)
