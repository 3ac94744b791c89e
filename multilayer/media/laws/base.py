"""Base class of modulus laws, with the bounds that fits need, and the registry of laws."""

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
        Exponent by field; a fit replaces the last free field by the product's distance from the bound.
    message : str
        For a user who exceeds it.
    """

    powers: Mapping[str, int]
    message: str


class ModulusLaw(Model):
    """A modulus law: subclass it, give ``law`` a `Literal` name, and define `__call__`.

    Time exp(+i w t): a passive law has Re(E) > 0 and Im(E) >= 0 at every positive frequency, and the stress of a real
    strain is real, ``E(-f) = conj E(f)``.

    Attributes
    ----------
    causal : bool
        Whether E1 and E2 obey the Kramers-Kronig relations, so that stress never precedes strain.
    wraps : bool
        Whether it changes another law, and has none of its own to fit.
    limits : tuple of Limit
        Bounds that tie fields together, for inputs and fits.
    grid : tuple of str
        Fields with the frequencies of the law's elements, which a fit keeps.
    examples : tuple of mapping
        Fields of typical laws, for tests of a plugin's law.
    """

    causal: ClassVar[bool] = True
    wraps: ClassVar[bool] = False
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
        """Return a law of equal elements, moduli of order 1 Pa, spread over the band of the data, to start a fit.

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
