"""Results of a simulation, as arrays, as a table and as plain data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import ComplexArray, RealArray
from multilayer.csv_table import csv_table
from multilayer.frames import Column, Frame, Tabular
from multilayer.response.bands import Width
from multilayer.simulation.quantities import LOST_IN, QUANTITIES, columns_of, quantity_named

PERCENTILES = (5, 50, 95)


@dataclass(frozen=True)
class CaseResult:
    """One combination of swept values; arrays over frequency.

    Attributes
    ----------
    label : str
        As ``foam.thickness = 10 mm``; empty without a sweep.
    shown : mapping
        The swept values as text, by path without ``layers.``.
    characteristic_impedance : float
        Of the ambient gas, Pa s/m.
    quantities : mapping
        Nominal values by name, see `multilayer.simulation.quantities`; only those that exist.
    percentiles : mapping
        By column, shape (3, n_frequency): 5, 50 and 95 % of the samples; empty without tolerances.
    ratings : mapping
        Single numbers by name, where the frequencies suffice for them.
    spread : mapping
        By quantity and field (path without ``layers.``), the standard deviation that comes of the field's tolerance,
        to first order about the nominal stack; empty without tolerances.
    """

    label: str
    shown: Mapping[str, str]
    characteristic_impedance: float
    quantities: Mapping[str, NDArray[Any]]
    percentiles: Mapping[str, RealArray] = field(default_factory=dict)
    ratings: Mapping[str, str] = field(default_factory=dict)
    spread: Mapping[str, Mapping[str, RealArray]] = field(default_factory=dict)

    @property
    def absorption(self) -> RealArray:
        """Absorption coefficient."""
        return self.quantities["absorption"]

    @property
    def transmission_loss(self) -> RealArray | None:
        """Transmission loss, dB; None without a half-space behind the stack."""
        return self.quantities.get("transmission_loss")

    @property
    def insertion_loss(self) -> RealArray | None:
        """Insertion loss against the reference, dB; None without a reference."""
        return self.quantities.get("insertion_loss")

    @property
    def reflection(self) -> ComplexArray | None:
        """Reflected over incident pressure; None in a diffuse field and in bands."""
        return self.quantities.get("reflection")

    @property
    def transmission(self) -> ComplexArray | None:
        """Transmitted over incident pressure; None as `reflection`, and without a half-space behind the stack."""
        return self.quantities.get("transmission")

    @property
    def surface_impedance(self) -> ComplexArray | None:
        """Pressure over normal velocity at the front face, Pa s/m; None as `reflection`."""
        normalised: ComplexArray | None = self.quantities.get("normalised_impedance")
        return None if normalised is None else np.asarray(normalised * self.characteristic_impedance)

    @property
    def layer_losses(self) -> dict[str, RealArray]:
        """Shares of the power that layers lose, by their names or indices; empty where these were not asked for."""
        names = [name for name in self.quantities if name.startswith(LOST_IN)]
        return {name.removeprefix(LOST_IN): self.quantities[name] for name in names}

    @property
    def columns(self) -> dict[str, RealArray]:
        """Columns of a table: nominal values, each with its percentiles as ``NAME_p05``, then what the spread is of."""
        columns: dict[str, RealArray] = {}
        for name, values in columns_of(self.quantities).items():
            columns[name] = values
            for percent, band in zip(PERCENTILES, self.percentiles.get(name, ()), strict=False):
                columns[f"{name}_p{percent:02d}"] = band
        for quantity, of_fields in self.spread.items():
            (name,) = QUANTITIES[quantity].columns
            columns |= {f"{name}_sd_from_{path}": values for path, values in of_fields.items()}
        return columns

    @property
    def units(self) -> dict[str, str]:
        """Units of the columns that are no pure numbers."""
        quantities = [quantity for quantity in map(quantity_named, self.quantities) if quantity.unit]
        return {
            name: quantity.unit
            for quantity in quantities
            for column in quantity.columns
            for name in self.columns
            if name == column or name.startswith((f"{column}_p", f"{column}_sd_from_"))
        }


@dataclass(frozen=True, repr=False)
class SimulationResult(Tabular):
    """All cases of a simulation.

    Attributes
    ----------
    name : str
        Of the file.
    frequency : array
        Hz; nominal centres where there are `bands`.
    bands : str or None
        Over which the values are averaged: ``third octaves`` or ``octaves``; None for single frequencies.
    cases : tuple of CaseResult
    settings : mapping
        The simulation file as plain data.
    """

    name: str
    frequency: RealArray
    bands: Width | None
    cases: tuple[CaseResult, ...]
    settings: Mapping[str, Any]

    @property
    def frame(self) -> Frame:
        """The columns of the CSV file over cases and frequency; NaN where a case lacks a column."""
        nothing = np.full(len(self.frequency), np.nan)
        columns = {
            name: (("case", "frequency"), np.stack([case.columns.get(name, nothing) for case in self.cases]))
            for name in self._columns
        }
        labels: dict[str, Column] = {"case": (("case",), np.array([case.label for case in self.cases]))}
        for path in self.cases[0].shown:
            labels[path] = (("case",), np.array([case.shown.get(path, "") for case in self.cases]))
        units = {"frequency": "Hz", **{name: unit for case in self.cases for name, unit in case.units.items()}}
        return Frame({**labels, "frequency": (("frequency",), self.frequency)}, columns, units, {"name": self.name})

    @property
    def _columns(self) -> list[str]:
        return list(dict.fromkeys(column for case in self.cases for column in case.columns))

    def to_csv(self) -> str:
        """Return one row per case and frequency; columns that a case lacks stay empty there."""
        columns = self._columns
        nothing = [None] * len(self.frequency)
        rows = (
            [case.label, *row]
            for case in self.cases
            for row in zip(self.frequency, *(case.columns.get(name, nothing) for name in columns), strict=True)
        )
        return csv_table(["case", "frequency_hz", *columns], rows)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data; infinite values become None, as JSON knows none."""
        return {
            "version": 1,
            "name": self.name,
            "settings": dict(self.settings),
            "bands": self.bands,
            "frequency_hz": self.frequency.tolist(),
            "cases": [_case_dict(case) for case in self.cases],
        }


def _case_dict(case: CaseResult) -> dict[str, Any]:
    return {
        "label": case.label,
        "values": dict(case.shown),
        "characteristic_impedance_pa_s_m": case.characteristic_impedance,
        "ratings": dict(case.ratings),
        **{name: plain_list(values) for name, values in case.columns.items()},
    }


def plain_list(values: RealArray) -> list[float | None]:
    """Return numbers that JSON can hold: None in place of infinite values and NaN."""
    return [value if math.isfinite(value) else None for value in np.asarray(values, dtype=float).tolist()]
