"""What every modulus law is: its base class, what a fit must know of it, and the registry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import prod
from typing import Annotated, Any, ClassVar, Self

from pydantic import model_validator

from multilayer.arrays import ArrayLike, ComplexArray
from multilayer.errors import InputError
from multilayer.models import Model
from multilayer.registry import Registry, subclass_fault
from multilayer.units import NonNegative, Unit

LossModulus = Annotated[float, NonNegative, Unit("Pa")]
_ROUNDING = 1e-12


@dataclass(frozen=True)
class Limit:
    """A bound that ties fields together: the product of their powers is at most 1.

    Attributes
    ----------
    powers : mapping
        Exponent by field; of several free ones a fit replaces the last by its distance from the bound.
    message : str
        What a user reads who exceeds it.
    """

    powers: Mapping[str, int]
    message: str


class ModulusLaw(Model):
    """A modulus law: subclass it, give ``law`` a `Literal` name, and define `__call__`.

    Time exp(+i w t): a passive law has Re(E) > 0 and Im(E) >= 0 at every positive frequency, and the answer to real
    strains is real, ``E(-f) = conj E(f)``.

    Attributes
    ----------
    causal : bool
        Whether E1 and E2 obey the Kramers-Kronig relations, so that stress never precedes strain. Say so where not.
    limits : tuple of Limit
        Bounds that tie fields together; inputs are held to them, and so are fits.
    grid : tuple of str
        Fields that lay out the law along frequency, which a fit takes as given.
    examples : tuple of mapping
        Fields of typical ones, on which a plugin's law is tried.
    """

    causal: ClassVar[bool] = True
    limits: ClassVar[tuple[Limit, ...]] = ()
    grid: ClassVar[tuple[str, ...]] = ()
    examples: ClassVar[tuple[Mapping[str, Any], ...]] = ()

    law: str

    @model_validator(mode="after")
    def _within_limits(self) -> Self:
        for limit in self.limits:
            if prod(getattr(self, name) ** power for name, power in limit.powers.items()) > 1 + _ROUNDING:
                raise ValueError(limit.message)
        return self

    @classmethod
    def spread(cls, elements: int, low: float, high: float) -> Self:
        """Return a law of so many alike elements, moduli of order 1 Pa, spread over the band of some data for a fit.

        Parameters
        ----------
        elements : int
        low, high : float
            Ends of the band, Hz.

        Raises
        ------
        InputError
            When the law has no elements to count.
        """
        raise InputError(f"{cls.__name__} has no elements to count; leave their number out")

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        """Return E1 + i E2, Pa, at `frequency` in Hz (any shape); parameter arrays broadcast against it."""
        raise NotImplementedError


LAWS: Registry[type[ModulusLaw]] = Registry("multilayer.modulus_laws", "modulus law", subclass_fault(ModulusLaw, "law"))
