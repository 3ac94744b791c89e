"""The description that every unmodelled effect carries, whatever it acts on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from multilayer.arrays import RealArray
from multilayer.inference.priors import Parameter

Values = Mapping[str, RealArray]  # parameters by name, each of shape (..., 1)


class BaseEffect:
    """Base class of unmodelled effects: `Effect` for those of the two-plate rig, `TubeEffect` for those of a tube.

    Attributes
    ----------
    name : str
        By which files and results name it.
    law : str
        Its equation in a line, for readers of tables.
    separated_by : str
        The measurement that distinguishes it from other effects.
    source : str
        Where the size of the prior is from.
    parameters : tuple of Parameter
        With priors, in SI units.
    absent : mapping
        Values of parameters at which the effect vanishes, where these are not the smallest (0 of signed parameters).
    law_error : float
        How well the law is known: standard deviation of the relative error of what the effect changes, smooth in ln f.
    size_error : float
        Relative standard deviation of a fitted size beyond its statistical error; `law_error` when None.
    size_errors : mapping
        The same by names of parameters, where the size of one is known better or worse than that.
    is_shape_known : bool
        Whether physics fixes the shape of the law; False where that varies from rig to rig, so that a simple form that
        fits better does not speak against the effect.
    starts : tuple of tuple of float
        Standard normal coordinates of all parameters from which fits start; a grid over the priors when empty.
    needs_finite_elements : bool
        Whether the rods of the two-plate rig are replaced by finite elements of the free rim.
    is_slow : bool
        Whether a fit takes as long as many others, so that it has to begin first.
    acts_by_bin : bool
        Whether it needs what was measured at the bins, as the strain: it is left out of what is cut off by the end of a
        record.
    place : str
        Name of the place where it acts; empty where that is none of them.
    acts_through_place : bool
        Whether all that it changes a free law at its place could change as well; False where it depends on more.
    aside : tuple of str
        Parameters that are not a size of the effect: the error of its law does not grow with them.
    absent_in : str
        The change of the experiment that removes the effect, where there is one.
    error_of : str
        Name of the known effect, whose law's error this is; empty of an effect.
    """

    kind: ClassVar[str]
    name: str
    law: ClassVar[str]
    separated_by: ClassVar[str]
    source: ClassVar[str] = ""
    parameters: tuple[Parameter, ...] = ()
    absent: ClassVar[Mapping[str, float]] = {}
    law_error: float = 0.15
    size_error: ClassVar[float | None] = None
    size_errors: ClassVar[Mapping[str, float]] = {}
    is_shape_known: ClassVar[bool] = True
    starts: tuple[tuple[float, ...], ...] = ()
    needs_finite_elements: bool = False
    is_slow: ClassVar[bool] = False
    acts_by_bin: bool = False
    place: ClassVar[str] = ""
    acts_through_place: ClassVar[bool] = True
    aside: tuple[str, ...] = ()
    absent_in: ClassVar[str] = ""
    error_of: str = ""

    @property
    def usual(self) -> list[float]:
        """Standard normal coordinates of an effect of usual size: signed parameters are one standard deviation."""
        return [0.0 if parameter.prior.normal is None else 1.0 for parameter in self.parameters]

    def error_of_size(self, parameter: str) -> float:
        """Return the relative standard deviation of a parameter's value beyond its statistical error."""
        usual = self.law_error if self.size_error is None else self.size_error
        return float(self.size_errors.get(parameter, usual))

    def finer(self, configurations: Sequence[str] = ()) -> BaseEffect | None:
        """Return the effect with a law that knows more, for data that this one does not fit; None without one.

        Its parameters are those of this law and, behind them, further ones.

        Parameters
        ----------
        configurations : sequence of str
            Names of those that were measured, for laws in which each of them has parameters of its own.
        """
        return None
