"""The quantities that simulations compute: names, columns of tables, units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import ComplexArray, RealArray
from multilayer.response.bands import mean_loss, mean_value


@dataclass(frozen=True)
class Quantity:
    """One quantity over frequency.

    Attributes
    ----------
    name : str
        As in `CaseResult.quantities`.
    title : str
        In figures.
    unit : str
        ``dB``, another unit, or empty for a pure number.
    is_complex : bool
    is_level : bool
        A level in dB of what a third octave holds; other quantities in dB are losses.
    """

    name: str
    title: str
    unit: str = ""
    is_complex: bool = False
    is_level: bool = False

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of a table: one, or real and imaginary part."""
        if self.is_complex:
            return (f"{self.name}_re", f"{self.name}_im")
        return (f"{self.name}_{self.unit.lower()}" if self.unit == "dB" else self.name,)

    def parts(self, values: NDArray[Any]) -> dict[str, RealArray]:
        """Return the columns of `values`."""
        parts = (values.real, values.imag) if self.is_complex else (values,)
        return {column: np.asarray(part, dtype=float) for column, part in zip(self.columns, parts, strict=True)}

    def mean(self, values: RealArray, weights: RealArray | None = None) -> RealArray:
        """Return the mean over the last axis: of the power for a quantity in dB, else of the values."""
        if self.is_level:
            return -mean_loss(-values, weights)
        return mean_loss(values, weights) if self.unit == "dB" else mean_value(values, weights)

    def slope_of_mean(self, values: RealArray, slopes: RealArray) -> RealArray:
        """Return the derivatives of the mean over the last axis from those of the values."""
        if self.unit != "dB":
            return mean_value(slopes)
        power = 10 ** ((np.min(values, axis=-1, keepdims=True) - values) / 10)
        return np.asarray(np.sum(power * slopes, axis=-1) / np.sum(power, axis=-1))


QUANTITIES = {
    quantity.name: quantity
    for quantity in (
        Quantity("absorption", "absorption coefficient"),
        Quantity("transmission_loss", "transmission loss", "dB"),
        Quantity("insertion_loss", "insertion loss", "dB"),
        Quantity("normalised_impedance", "surface impedance / (ρ c)", is_complex=True),
        Quantity("reflection", "reflection coefficient", is_complex=True),
        Quantity("transmission", "transmission coefficient", is_complex=True),
        Quantity("radiation_efficiency", "radiation efficiency"),
        Quantity("input_mobility", "input mobility", "m/(N s)", is_complex=True),
        Quantity("bending_stiffness", "bending stiffness", "N m"),
        Quantity("loss_factor", "loss factor of the free wave"),
        Quantity("phase_speed", "phase speed of the free wave", "m/s"),
        Quantity("duct_attenuation", "attenuation of the lined duct", "dB/m"),
        Quantity("sound_power_level", "sound power level", "dB", is_level=True),
        Quantity("impact_level", "normalised impact sound level", "dB", is_level=True),
    )
}


def normalised(impedance: ComplexArray, of_gas: float) -> ComplexArray:
    """Return a surface impedance over that of the gas, infinite at a rigid face."""
    # a quotient of complex numbers would have no number as its imaginary part there
    return np.asarray(np.where(np.isinf(impedance), np.inf, impedance / of_gas))


def mean_of(name: str, quantities: Mapping[str, NDArray[Any]]) -> RealArray:
    """Return the mean of one of several quantities over the last axis, as `Quantity.mean`.

    Of an insertion loss the difference of what stack and reference lose on average: no mean of its own values gives it.
    """
    if name == "insertion_loss":
        loss = quantities["transmission_loss"]
        return np.asarray(mean_loss(loss) - mean_loss(loss - quantities[name]))
    return quantity_named(name).mean(quantities[name])


LOST_IN = "lost_in_"  # names of the shares of the power that layers lose begin so


def quantity_named(name: str) -> Quantity:
    """Return one of `QUANTITIES`, or the share of the power that a layer loses, whose name begins with `LOST_IN`."""
    if name.startswith(LOST_IN):
        return Quantity(name, f"share of the power lost in {name.removeprefix(LOST_IN)}")
    return QUANTITIES[name]


def columns_of(quantities: Mapping[str, NDArray[Any]]) -> dict[str, RealArray]:
    """Return the columns of several quantities, in the order of `QUANTITIES`, then what the layers lose."""
    columns: dict[str, RealArray] = {}
    for name in [*QUANTITIES, *(name for name in quantities if name.startswith(LOST_IN))]:
        if name in quantities:
            columns |= quantity_named(name).parts(quantities[name])
    return columns
