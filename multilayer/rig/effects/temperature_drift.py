"""A modulus that drifts over the campaign."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from multilayer.arrays import ComplexArray, RealArray
from multilayer.models import refuse
from multilayer.rig.effect_base import Effect, Mistake, Moment, Size, Surroundings
from multilayer.units import DIMENSIONLESS, Unit


class TemperatureDrift(Effect):
    """The modulus changes with the order of the recordings: E (1 + d u), u from 0 at the first burst to 1 at the last.

    Give `total` = d (-0.1 when left out), or the `rate` per burst. Perturbed: u (1 + p (u - 1)), a change that speeds
    up or slows down.
    """

    effect: Literal["temperature_drift"] = "temperature_drift"
    total: Annotated[float, Field(gt=-0.9, le=2), Unit(DIMENSIONLESS)] | None = None
    rate: Annotated[float, Field(ge=-0.1, le=0.1), Unit(DIMENSIONLESS)] | None = None

    varies = True
    drawn = Size("total", 5e-3, 0.3, signed=True, parameter="total")

    @model_validator(mode="before")
    @classmethod
    def _usual(cls, data: Any) -> Any:
        given = isinstance(data, Mapping) and any(data.get(name) is not None for name in ("total", "rate"))
        return {**data, "total": -0.1} if isinstance(data, Mapping) and not given else data

    @model_validator(mode="after")
    def _one_of_them(self) -> Self:
        if self.total is not None and self.rate is not None:
            refuse(self, [(("rate",), "rate stands beside total; give one of the two", self.rate)])
        return self

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        bursts = sum(len(mounting.frequencies) for mounting in around.mountings)
        if self.rate is not None and not -0.9 < self.rate * bursts <= 2:
            text = (
                f"{self.rate:g} per burst is a change by {self.rate * bursts:.3g} over {bursts} bursts; make it smaller"
            )
            yield ("rate",), text, self.rate

    def apply_to_modulus(self, frequency: RealArray, modulus: ComplexArray, moment: Moment) -> ComplexArray:
        last = max(moment.total - 1, 1.0)
        change = self.total if self.rate is None else self.rate * last
        u = moment.elapsed / last
        if self.rate is None:
            u = min(u, 1.0)  # repeats of the last burst
        return modulus * (1 + (change or 0.0) * u * (1 + self.perturbation * (u - 1)))
