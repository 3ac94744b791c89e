"""Models of the fluid in rigid pores by name: the fields that each needs, its functions, and where it holds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.media.double_porosity import holed, slitted
from multilayer.media.empirical import VALID, delany_bazley, miki
from multilayer.media.gas import Gas
from multilayer.media.perforations import hole_pitch
from multilayer.media.pore_sizes import horoshenkov_swift
from multilayer.media.porous import (
    champoux_allard_modulus,
    johnson_density,
    lafarge_modulus,
    pride_density,
    pride_lafarge_modulus,
)
from multilayer.media.relaxation import wilson, wilson_of_resistivity
from multilayer.media.structures import Pores, fibres, grains, open_cells
from multilayer.media.validity import warn_outside, warn_short_waves

FramedPoreModelName: TypeAlias = Literal["jca", "jcal", "jcapl", "fibres", "open_cells", "grains"]
PoreModelName: TypeAlias = Literal["delany_bazley", "miki", FramedPoreModelName, "wilson", "horoshenkov_swift"]
# in a rigid frame only: the porosity of double_porosity is not that of the whole
RigidPoreModelName: TypeAlias = Literal[PoreModelName, "double_porosity"]
Fluid: TypeAlias = tuple[ComplexArray, ComplexArray]
Fields: TypeAlias = Mapping[str, Any]


@dataclass(frozen=True)
class PoreModel:
    """One model.

    Attributes
    ----------
    title : str
    variants : tuple of (tuple of str, callable)
        The fields that one variant takes, and ``fluid(omega, gas, **fields)``: effective density, kg/m3, and bulk
        modulus, Pa, per unit volume of material.
    check : callable
        ``check(title, omega, gas, fields)`` warns outside the range of validity.
    """

    title: str
    variants: tuple[tuple[tuple[str, ...], Callable[..., Fluid]], ...]
    check: Callable[[str, Numeric, Gas, Fields], None]

    @property
    def field_sets(self) -> tuple[tuple[str, ...], ...]:
        """The sets of fields of which one must be given."""
        return tuple(fields for fields, _ in self.variants)

    def fluid(self, omega: Numeric, gas: Gas, given: Fields) -> Fluid:
        """Return effective density, kg/m3, and bulk modulus, Pa, and warn outside the range of validity.

        Parameters
        ----------
        omega : array
            rad/s.
        gas : Gas
            In the pores.
        given : mapping
            Holds the fields of one variant; others may be there and are None.
        """
        self.check(self.title, omega, gas, given)
        for fields, function in self.variants:
            if all(given.get(field) is not None for field in fields):
                return function(omega, gas, **{field: given[field] for field in fields})
        raise AssertionError(f"{self.title}: the fields are validated before")


def _jca(
    omega: Numeric, gas: Gas, *, porosity: Numeric, flow_resistivity: Numeric, tortuosity: Numeric,
    viscous_length: Numeric, thermal_length: Numeric,
) -> Fluid:  # fmt: skip
    density = johnson_density(omega, porosity, flow_resistivity, tortuosity, viscous_length, gas)
    return density, champoux_allard_modulus(omega, porosity, thermal_length, gas)


def _jcal(
    omega: Numeric, gas: Gas, *, porosity: Numeric, flow_resistivity: Numeric, tortuosity: Numeric,
    viscous_length: Numeric, thermal_length: Numeric, thermal_permeability: Numeric,
) -> Fluid:  # fmt: skip
    density = johnson_density(omega, porosity, flow_resistivity, tortuosity, viscous_length, gas)
    return density, lafarge_modulus(omega, porosity, thermal_length, thermal_permeability, gas)


def _jcapl(
    omega: Numeric, gas: Gas, *, porosity: Numeric, flow_resistivity: Numeric, tortuosity: Numeric,
    viscous_length: Numeric, thermal_length: Numeric, thermal_permeability: Numeric,
    static_viscous_tortuosity: Numeric, static_thermal_tortuosity: Numeric,
) -> Fluid:  # fmt: skip
    density = pride_density(
        omega, porosity, flow_resistivity, tortuosity, viscous_length, static_viscous_tortuosity, gas
    )
    bulk = pride_lafarge_modulus(omega, porosity, thermal_length, thermal_permeability, static_thermal_tortuosity, gas)
    return density, bulk


def _check_empirical(title: str, omega: Numeric, _gas: Gas, given: Fields) -> None:
    frequency = np.asarray(omega) / (2 * np.pi)
    warn_outside(title, "f / flow_resistivity (m^3/kg)", frequency / given["flow_resistivity"], *VALID, frequency)


def _check_length(title: str, omega: Numeric, gas: Gas, given: Fields) -> None:
    warn_short_waves(title, np.maximum(given["viscous_length"], given["thermal_length"]), omega, gas)


def _check_wilson(title: str, omega: Numeric, gas: Gas, given: Fields) -> None:
    """Take the radius of tubes of the same relaxation time, tau = rho r^2 / (4 eta)."""
    time = given.get("vorticity_time")
    if time is None:
        time = 2 * gas.density * given["tortuosity"] / (given["flow_resistivity"] * given["porosity"])
    warn_short_waves(title, np.sqrt(4 * gas.viscosity * time / gas.density), omega, gas)


def _check_median(title: str, omega: Numeric, gas: Gas, given: Fields) -> None:
    warn_short_waves(title, given["median_pore_size"], omega, gas)


def _check_double(title: str, omega: Numeric, gas: Gas, given: Fields) -> None:
    """Take the pitch of the holes, or of the slits."""
    share, width = given["perforation"], given.get("slit_width")
    pitch = hole_pitch(given["hole_radius"], share) if width is None else width / share
    warn_short_waves(title, np.maximum(pitch, given["viscous_length"]), omega, gas)


def _structured(title: str, structure: Callable[..., Pores], lowest: float, *variants: tuple[str, ...]) -> PoreModel:
    """Return the model of a structure that holds from a `lowest` porosity; its first variant has all fields."""

    def fluid(omega: Numeric, gas: Gas, **fields: Numeric) -> Fluid:
        return structure(**fields).fluid(omega, fields["porosity"], gas)

    def check(title: str, omega: Numeric, gas: Gas, given: Fields) -> None:
        warn_outside(title, "porosity", given["porosity"], lowest, 1)
        fields = {name: given[name] for name in variants[0] if given.get(name) is not None}
        warn_short_waves(title, structure(**fields).thermal_length, omega, gas)

    return PoreModel(title, tuple((fields, fluid) for fields in variants), check)


_FIVE = ("porosity", "flow_resistivity", "tortuosity", "viscous_length", "thermal_length")
_SIX = (*_FIVE, "thermal_permeability")
_FIBRES = ("porosity", "fibre_diameter")
_EIGHT = (*_SIX, "static_viscous_tortuosity", "static_thermal_tortuosity")

PORE_MODELS: dict[str, PoreModel] = {
    "delany_bazley": PoreModel("Delany-Bazley", ((("flow_resistivity",), delany_bazley),), _check_empirical),
    "miki": PoreModel("Miki", ((("flow_resistivity",), miki),), _check_empirical),
    "jca": PoreModel("Johnson-Champoux-Allard", ((_FIVE, _jca),), _check_length),
    "jcal": PoreModel("Johnson-Champoux-Allard-Lafarge", ((_SIX, _jcal),), _check_length),
    "jcapl": PoreModel("Johnson-Champoux-Allard-Pride-Lafarge", ((_EIGHT, _jcapl),), _check_length),
    "wilson": PoreModel(
        "Wilson",
        (
            (("porosity", "tortuosity", "vorticity_time", "entropy_time"), wilson),
            (("porosity", "tortuosity", "flow_resistivity"), wilson_of_resistivity),
        ),
        _check_wilson,
    ),
    "horoshenkov_swift": PoreModel(
        "Horoshenkov-Swift",
        ((("porosity", "median_pore_size", "pore_size_deviation"), horoshenkov_swift),),
        _check_median,
    ),
    "fibres": _structured("the model of fibres", fibres, 0.7, (*_FIBRES, "fibre_orientation"), _FIBRES),
    "open_cells": _structured("the model of open cells", open_cells, 0.95, ("porosity", "cell_size")),
    "grains": _structured("the model of grains", grains, 0.26, ("porosity", "grain_diameter")),
    "double_porosity": PoreModel(
        "double porosity",
        (((*_FIVE, "perforation", "hole_radius"), holed), ((*_FIVE, "perforation", "slit_width"), slitted)),
        _check_double,
    ),
}
