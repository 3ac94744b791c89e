"""Faces that are bonded in part."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import Chain, Effect, Setting, Values, between, positive, signed
from multilayer.experiments.two_plate.effects import OpenRim
from multilayer.inference.priors import Parameter
from multilayer.rig.partly_bonded import WIDEST_RIM
from multilayer.rig.worn_rim import DEPTHS

_UNEVEN = 0.2  # standard deviation of ln(width) of each configuration's rim


class Delamination(Effect):
    """A rim of either face, or of both, that is not bonded: a constriction at the face, and a rim that resonates.

    The disc with its open rims is one of finite elements, reduced to a few dozen modes (`rig.partly_bonded`): exact for
    any height over the radius and any frequency, within 0.25 % of the transmissibility's largest value. Widths of the
    rim may rise or fall from the first to the last configuration. The top plate, which hangs over, bends under the
    forces of the bonded part and its own inertia, and yields to them: the reading in its centre is right to 0.5 % where
    it bends by a quarter, and to 2 % on a stiff sample (2 MPa under 1 mm of steel). Where that does not fit, each
    configuration may have a rim of its own (`UnevenRims`), and rims may be worn away, too (`WornRim`).

    Limits: the bonded part is a circle about the axis. The plate bends in one shape, below its first resonance. Glue
    and a spring beside the sample are taken in exactly where both faces are open alike, a skin as a change of the
    modulus.
    """

    name = "delamination"
    place = "faces"
    acts_through_place = False
    law = "a rim of each face, or of one of them, is open; finite elements"
    separated_by = "another thickness; configurations remounted"
    source = "glue that misses 2 to 50 % of a face"
    moves_resonances = True
    is_slow = True
    parameters: tuple[Parameter, ...] = (
        positive("open_rim", 0.1, 0.8, bounds=(1e-4, WIDEST_RIM)), signed("trend", 0.4), between("at_base", 0.0, 2.0),
    )  # fmt: skip
    starts: tuple[tuple[float, ...], ...] = ((0.0, 0.0, -1.0), (0.0, 0.0, 1.0))
    aside: tuple[str, ...] = ("trend", "at_base")

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """Return the chain with open rims."""
        return chain.with_(open_rim=OpenRim(_rim(setting, values), values["at_base"], values.get("depth")))

    def finer(self, configurations: Sequence[str] = ()) -> Delamination | None:
        """Return the same with a rim of each configuration by itself; of a single one with a rim that is worn away."""
        return UnevenRims(configurations) if len(configurations) > 1 else WornRim()


class UnevenRims(Delamination):
    """Open rims of which each configuration has one of its own width: every face is glued by itself.

    Parameters
    ----------
    configurations : sequence of str
        Their names.
    """

    def __init__(self, configurations: Sequence[str] = ()) -> None:
        self.configurations = tuple(configurations)
        widths = tuple(signed(_own_width(name), _UNEVEN) for name in self.configurations)
        self.parameters = (*Delamination.parameters, *widths)
        self.starts = tuple((*start, *np.zeros(len(widths))) for start in Delamination.starts)

    def finer(self, configurations: Sequence[str] = ()) -> Delamination | None:
        """Return the same with rims that are worn away."""
        return WornRim(self.configurations)


class WornRim(UnevenRims):
    """Open rims that are worn away at the upper face, by the same share of the height of all samples.

    As where a sample was torn off before, or cut askew. Of finite elements, too (`rig.worn_rim`): some seconds for each
    shape of a sample.
    """

    def __init__(self, configurations: Sequence[str] = ()) -> None:
        super().__init__(configurations)
        self.parameters = (*self.parameters, between("depth", DEPTHS[0], DEPTHS[-1]))
        self.starts = tuple((*start, depth) for start in self.starts for depth in (-2.0, 0.0))
        self.aside = (*Delamination.aside, "depth")

    def finer(self, configurations: Sequence[str] = ()) -> Delamination | None:
        """Return nothing: this is the finest law."""
        return None


def _own_width(configuration: str) -> str:
    return f"width[{configuration}]"


def _rim(setting: Setting, values: Values) -> RealArray:
    """Return the width of the open rim of a configuration, as a share of the radius."""
    own = values.get(_own_width(setting.configuration.name), 0.0)
    return np.clip(values["open_rim"] * np.exp(setting.from_first_to_last * values["trend"] + own), 0.0, WIDEST_RIM)
