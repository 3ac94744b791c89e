"""A law at another temperature than that at which it was found."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.media.laws.base import ModulusLaw
from multilayer.media.laws.field import Modulus
from multilayer.media.superposition import arrhenius_log_shift, entropic_shift, wlf_log_shift
from multilayer.models import refuse
from multilayer.units import DIMENSIONLESS, Temperature, Unit

Decades = Annotated[float, Field(gt=0), Unit(DIMENSIONLESS)]
TemperatureDifference = Annotated[float, Field(gt=0), Unit("delta_degC")]
MolarEnergy = Annotated[float, Field(gt=0), Unit("J/mol")]


class Shifted(ModulusLaw):
    """E(f, T) = b_T E(a_T f, T0): another law of `modulus`, found at `reference_temperature`, at `temperature`.

    Time-temperature superposition (J. D. Ferry, Viscoelastic Properties of Polymers, 3rd ed., Wiley 1980, ch. 11). a_T
    is that of Williams, Landel and Ferry where `c1` (decades) and `c2` (K) are given, of Arrhenius where
    `activation_energy` is; b_T is 1, or T/T0 with ``vertical: entropic``.
    """

    wraps: ClassVar[bool] = True
    examples: ClassVar[tuple[dict[str, Any], ...]] = (
        {
            "modulus": {"law": "zener", "relaxed_modulus": 1e5, "unrelaxed_modulus": 1e7, "relaxation_time": 1e-4},
            "temperature": 305.0,
            "reference_temperature": 293.0,
            "c1": 8.86,
            "c2": 101.6,
        },
        {
            "modulus": {"law": "loss_factor", "young_modulus": 2e5, "loss_factor": 0.1},
            "temperature": 280.0,
            "reference_temperature": 293.0,
            "activation_energy": 1e5,
            "vertical": "entropic",
        },
    )

    law: Literal["shifted"] = "shifted"
    modulus: Modulus
    temperature: Temperature
    reference_temperature: Temperature
    c1: Decades | None = None
    c2: TemperatureDifference | None = None
    activation_energy: MolarEnergy | None = None
    vertical: Literal["none", "entropic"] = "none"

    @property
    def causal(self) -> bool:  # type: ignore[override]
        """Whether the law within is."""
        return self.modulus.causal if isinstance(self.modulus, ModulusLaw) else not np.any(np.imag(self.modulus))

    @model_validator(mode="after")
    def _has_a_shift(self) -> Self:
        refuse(self, self._mistakes())
        return self

    def _mistakes(self) -> Iterator[tuple[tuple[str | int, ...], str, Any]]:
        if (self.c1 is None) != (self.c2 is None):
            missing, given = ("c1", self.c2) if self.c1 is None else ("c2", self.c1)
            yield (), f"{missing} is missing: the shifts of Williams, Landel and Ferry need both c1 and c2", given
        elif (self.c1 is None) == (self.activation_energy is None):
            yield (), "give either c1 and c2 (Williams, Landel & Ferry) or activation_energy (Arrhenius)", None
        elif self.c2 is not None and self.temperature <= self.reference_temperature - self.c2:
            pole = self.reference_temperature - self.c2
            text = f"{self.temperature:g} K is not allowed: WLF has its pole at {pole:g} K; take Arrhenius' law there"
            yield ("temperature",), text, self.temperature

    @property
    def log_shift(self) -> RealArray:
        """log10 a_T."""
        if self.activation_energy is not None:
            return arrhenius_log_shift(self.temperature, self.reference_temperature, self.activation_energy)
        assert self.c1 is not None
        assert self.c2 is not None
        return wlf_log_shift(self.temperature, self.reference_temperature, self.c1, self.c2)

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        reduced = 10.0**self.log_shift * np.asarray(frequency, dtype=float)
        risen = entropic_shift(self.temperature, self.reference_temperature) if self.vertical == "entropic" else 1.0
        if isinstance(self.modulus, ModulusLaw):
            return np.asarray(risen * self.modulus(reduced))
        storage, loss = np.real(self.modulus), np.imag(self.modulus)
        return np.asarray(risen * (storage + 1j * np.copysign(loss, reduced)))
