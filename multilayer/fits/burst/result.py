"""What a fit says, and how it is written down."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.csv_table import csv_table
from multilayer.fits.burst.uncertainty import ErrorParts
from multilayer.frames import Frame, Tabular
from multilayer.media.kramers_kronig import gross_loss_modulus

CSV_COLUMNS = (
    "configuration", "frequency_hz", "E1_pa", "E1_std_pa", "E2_pa", "E2_std_pa", "loss_factor", "loss_factor_std",
    "delta_tof_s", "delta_level_db", "accepted",
)  # fmt: skip
_UNITS = {"_hz": "Hz", "_pa": "Pa", "_s": "s", "_db": "dB"}  # by how the name of a column ends


def modulus_frame(rows: Sequence[Sequence[Any]], facts: Mapping[str, Any]) -> Frame:
    """Return rows of `CSV_COLUMNS` as arrays over bursts."""
    columns = {name: (("burst",), np.array(values)) for name, *values in zip(CSV_COLUMNS, *rows, strict=True)}
    coordinates = {name: columns.pop(name) for name in CSV_COLUMNS[:2]}
    units = {name: unit for name in CSV_COLUMNS for end, unit in _UNITS.items() if name.endswith(end)}
    return Frame(coordinates, columns, units, facts)


@dataclass(frozen=True)
class Solution:
    """One point (E1, E2) that explains a burst, Pa, with its misfit (relative norm of the residual)."""

    storage_modulus: float
    loss_modulus: float
    misfit: float


@dataclass(frozen=True)
class BurstFit:
    """Result of one burst.

    Attributes
    ----------
    configuration : str
    frequency : float
        Hz.
    storage_modulus, loss_modulus, loss_factor : float
        Means over the accepted region; moduli in Pa.
    storage_modulus_std, loss_modulus_std, loss_factor_std : float
        Standard deviations over it.
    optimum : Solution
        The best single solution.
    delta_tof, delta_level_db : float
        Measured minus modelled at the optimum: time of flight (s) and level (dB); eq. (10).
    accepted : bool
    reason : str
        Why not, when not accepted.
    notes : list of str
        What a reader should know all the same.
    alternatives : list of Solution
        Other solutions that meet the acceptance criteria.
    errors : ErrorParts, optional
        What the uncertainty of (ln E1, loss factor) consists of.
    history : array, shape (n_evaluations, 3)
        E1, E2 (Pa) and cost at each evaluation of the optimiser.
    measured_transmissibility, modelled_transmissibility : complex
        Top over base at the burst's frequency.
    time, measured_envelope, modelled_envelope : array
        s and m/s2.
    """

    configuration: str
    frequency: float
    storage_modulus: float
    storage_modulus_std: float
    loss_modulus: float
    loss_modulus_std: float
    loss_factor: float
    loss_factor_std: float
    optimum: Solution
    delta_tof: float
    delta_level_db: float
    accepted: bool
    reason: str = ""
    notes: list[str] = field(default_factory=list)
    alternatives: list[Solution] = field(default_factory=list)
    errors: ErrorParts | None = field(repr=False, default=None)
    history: RealArray = field(repr=False, default_factory=lambda: np.empty((0, 3)))
    measured_transmissibility: complex = 1.0
    modelled_transmissibility: complex = 1.0
    time: RealArray = field(repr=False, default_factory=lambda: np.empty(0))
    measured_envelope: RealArray = field(repr=False, default_factory=lambda: np.empty(0))
    modelled_envelope: RealArray = field(repr=False, default_factory=lambda: np.empty(0))

    def row(self) -> tuple[Any, ...]:
        """Return the values of `CSV_COLUMNS`."""
        return (
            self.configuration, self.frequency, self.storage_modulus, self.storage_modulus_std, self.loss_modulus,
            self.loss_modulus_std, self.loss_factor, self.loss_factor_std, self.delta_tof, self.delta_level_db,
            self.accepted,
        )  # fmt: skip

    @property
    def remark(self) -> str:
        """Reason and notes in one line."""
        return "; ".join(part for part in (self.reason, *self.notes) if part)


@dataclass(frozen=True)
class GrossCheck:
    """Local Kramers-Kronig check of one configuration (eq. 12).

    Attributes
    ----------
    frequency, predicted, measured : array
        Hz; E2 from the slope of E1, and as found, Pa.
    mean_relative_error : float
        Of the prediction against what was found.
    """

    frequency: RealArray
    predicted: RealArray
    measured: RealArray
    mean_relative_error: float


@dataclass(frozen=True, repr=False)
class FitResult(Tabular):
    """Result of a campaign.

    Attributes
    ----------
    campaign : str
        Its name.
    method : str
    settings : dict
        What the fit was made with, as plain data.
    bursts : list of BurstFit
        In the order of the campaign.
    """

    campaign: str
    method: str
    settings: dict[str, Any]
    bursts: list[BurstFit]

    @property
    def frame(self) -> Frame:
        """The columns of ``moduli.csv`` over the bursts."""
        return modulus_frame([burst.row() for burst in self.bursts], {"campaign": self.campaign, "method": self.method})

    @property
    def configurations(self) -> list[str]:
        """Names of the configurations, in order."""
        return list(dict.fromkeys(burst.configuration for burst in self.bursts))

    def of(self, configuration: str) -> list[BurstFit]:
        """Return the bursts of one configuration by rising frequency."""
        chosen = [burst for burst in self.bursts if burst.configuration == configuration]
        return sorted(chosen, key=lambda burst: burst.frequency)

    def columns(self, configuration: str, *attributes: str) -> list[RealArray]:
        """Return attributes of a configuration's bursts as arrays."""
        return [np.array([getattr(burst, name) for burst in self.of(configuration)]) for name in attributes]

    @property
    def all_accepted(self) -> bool:
        """Whether every burst has an accepted solution."""
        return all(burst.accepted for burst in self.bursts)

    def gross_check(self, configuration: str) -> GrossCheck | None:
        """Return the check of eq. (12) for a configuration with at least three accepted bursts."""
        bursts = [burst for burst in self.of(configuration) if burst.accepted]
        if len(bursts) < 3:
            return None
        f, e1, e2 = (
            np.array([getattr(b, n) for b in bursts]) for n in ("frequency", "storage_modulus", "loss_modulus")
        )
        predicted = gross_loss_modulus(f, e1)
        known = e2 > 0
        error = float(np.mean(np.abs(predicted[known] / e2[known] - 1))) if known.any() else float("nan")
        return GrossCheck(f, predicted, e2, error)

    def to_csv(self) -> str:
        """Return the table of results; numbers with nine significant digits."""
        return csv_table(CSV_COLUMNS, (burst.row() for burst in self.bursts))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: everything but the time signals."""
        return {
            "version": 1,
            "campaign": self.campaign,
            "method": self.method,
            "settings": self.settings,
            "all_accepted": self.all_accepted,
            "bursts": [_burst_dict(burst) for burst in self.bursts],
            "gross_check": {
                name: check.mean_relative_error
                for name in self.configurations
                if (check := self.gross_check(name)) is not None
            },
        }


def _burst_dict(burst: BurstFit) -> dict[str, Any]:
    plain = dict(zip(CSV_COLUMNS, burst.row(), strict=True))
    return {
        **plain,
        "reason": burst.reason,
        "notes": burst.notes,
        "optimum": _solution_dict(burst.optimum),
        "alternatives": [_solution_dict(solution) for solution in burst.alternatives],
        "errors": None if burst.errors is None else burst.errors.to_dict(),
        "transmissibility": {
            "measured": [burst.measured_transmissibility.real, burst.measured_transmissibility.imag],
            "modelled": [burst.modelled_transmissibility.real, burst.modelled_transmissibility.imag],
        },
        "convergence": {name: burst.history[:, i].tolist() for i, name in enumerate(("E1_pa", "E2_pa", "cost"))},
    }


def _solution_dict(solution: Solution) -> dict[str, float]:
    return {
        "E1_pa": solution.storage_modulus,
        "E2_pa": solution.loss_modulus,
        "misfit": solution.misfit,
    }
