"""What an unmodelled effect says of itself, whatever it acts on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from multilayer.arrays import RealArray
from multilayer.inference.priors import Parameter

Values = Mapping[str, RealArray]  # parameters by name, each of shape (..., 1)


class BaseEffect:
    """What every unmodelled effect says of itself; `Effect` is one of the two-plate rig, `TubeEffect` one of a tube.

    Attributes
    ----------
    name : str
        In the output.
    law : str
        In a line, for people.
    separated_by : str
        The measurement that tells it from others.
    source : str
        Of the prior's size.
    parameters : tuple of Parameter
        With priors in SI units.
    absent : mapping
        Values of parameters at which the effect vanishes, where that is not at their smallest (0 for signed ones).
    law_error : float
        How well the law is known: relative error of what the effect changes, one standard deviation, smooth in ln f.
    size_error : float
        How well a size that is found tells the true one, relative, one standard deviation: `law_error` when None.
    starts : tuple of tuple of float
        Coordinates of all parameters from which fits start; some all over the priors when empty.
    needs_finite_elements : bool
        Whether the rods of the two-plate rig are replaced by finite elements of the free rim.
    """

    kind: ClassVar[str]
    name: ClassVar[str]
    law: ClassVar[str]
    separated_by: ClassVar[str]
    source: ClassVar[str] = ""
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    absent: ClassVar[Mapping[str, float]] = {}
    law_error: ClassVar[float] = 0.15
    size_error: ClassVar[float | None] = None
    starts: ClassVar[tuple[tuple[float, ...], ...]] = ()
    needs_finite_elements: ClassVar[bool] = False
