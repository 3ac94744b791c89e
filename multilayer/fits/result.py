"""What a fit says, and how it is written down: one class; fits of another kind add what differs.

Whatever gives moduli at the bursts of a campaign gives a `FitResult` of `BurstFit`: ``moduli.csv``, ``fit.json``, the
check of eq. (12) and arrays for pandas and xarray come with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from multilayer.arrays import RealArray
from multilayer.csv_table import csv_table
from multilayer.fits.burst.uncertainty import ErrorParts
from multilayer.frames import Frame, Tabular
from multilayer.media.kramers_kronig import gross_loss_modulus

if TYPE_CHECKING:
    from multilayer.inference.summary import PosteriorSummary

MODULUS_COLUMNS = (
    "configuration", "frequency_hz", "E1_pa", "E1_std_pa", "E2_pa", "E2_std_pa", "loss_factor", "loss_factor_std",
    "delta_tof_s", "delta_level_db", "accepted",
)  # fmt: skip
_UNITS = {"_hz": "Hz", "_pa": "Pa", "_s": "s", "_db": "dB"}  # by how the name of a column ends


@dataclass(frozen=True)
class Solution:
    """One point (E1, E2) that explains a burst, Pa, with its misfit (relative norm of the residual)."""

    storage_modulus: float
    loss_modulus: float
    misfit: float


@dataclass(frozen=True)
class BurstFit:
    """The modulus at one frequency of one configuration; what a method does not know is left out.

    Attributes
    ----------
    configuration : str
    frequency : float
        Hz.
    storage_modulus, loss_modulus, loss_factor : float
        Moduli in Pa; means over the accepted region where a fit has one. NaN where there is no solution.
    storage_modulus_std, loss_modulus_std, loss_factor_std : float
        Standard deviations.
    delta_tof, delta_level_db : float
        Measured minus modelled at the optimum: time of flight (s) and level (dB); eq. (10). NaN where not compared.
    accepted : bool
    reason : str
        Why not, when not accepted.
    notes : list of str
        What a reader should know all the same.
    solution : Solution, optional
        The best single one, where the moduli are means; see `optimum`.
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
    delta_tof: float = float("nan")
    delta_level_db: float = float("nan")
    accepted: bool = True
    reason: str = ""
    notes: list[str] = field(default_factory=list)
    solution: Solution | None = None
    alternatives: list[Solution] = field(default_factory=list)
    errors: ErrorParts | None = field(repr=False, default=None)
    history: RealArray = field(repr=False, default_factory=lambda: np.empty((0, 3)))
    measured_transmissibility: complex = 1.0
    modelled_transmissibility: complex = 1.0
    time: RealArray = field(repr=False, default_factory=lambda: np.empty(0))
    measured_envelope: RealArray = field(repr=False, default_factory=lambda: np.empty(0))
    modelled_envelope: RealArray = field(repr=False, default_factory=lambda: np.empty(0))

    @property
    def optimum(self) -> Solution:
        """The best single solution: the moduli themselves where nothing else is known."""
        return self.solution or Solution(self.storage_modulus, self.loss_modulus, float("nan"))

    def row(self) -> tuple[Any, ...]:
        """Return the values of `MODULUS_COLUMNS`."""
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
    """What a fit says.

    Attributes
    ----------
    name : str
        Of the campaign, or of the file of stacks.
    method : str
        As in `multilayer.fits.methods.METHODS`.
    settings : dict
        What the fit was made with, as plain data.
    bursts : list of BurstFit
        Moduli, in the order of the campaign; none of a fit of stacks.
    minima : sequence
        The distinct solutions of a fit of all data at once, the most probable first.
    summary : PosteriorSummary, optional
        Intervals of such a fit, and what the data determine.
    notes : list of str
        What a reader should know of the whole; see `remarks`.
    warnings : list of str
        Where formulae do not hold.
    """

    kind: ClassVar[str] = "bursts"  # by which a report is chosen
    record_name: ClassVar[str] = "fit.json"  # the file that holds everything
    heading: ClassVar[tuple[str, ...]] = ("campaign", "method")  # with which that begins

    name: str
    method: str
    settings: dict[str, Any]
    bursts: list[BurstFit] = field(default_factory=list)
    minima: Sequence[Any] = field(default=(), kw_only=True)
    summary: PosteriorSummary | None = field(default=None, kw_only=True)
    notes: list[str] = field(default_factory=list, kw_only=True)
    warnings: list[str] = field(default_factory=list, kw_only=True)

    @property
    def campaign(self) -> str:
        """The name of the campaign."""
        return self.name

    @property
    def frame(self) -> Frame:
        """The columns of ``moduli.csv`` over the bursts."""
        rows = zip(*(burst.row() for burst in self.bursts), strict=True)
        columns = {name: (("burst",), np.array(values)) for name, values in zip(MODULUS_COLUMNS, rows, strict=True)}
        coordinates = {name: columns.pop(name) for name in MODULUS_COLUMNS[:2]}
        units = {name: unit for name in MODULUS_COLUMNS for end, unit in _UNITS.items() if name.endswith(end)}
        return Frame(coordinates, columns, units, self.facts)

    @property
    def facts(self) -> dict[str, Any]:
        """Single values that hold for all of it."""
        return {"campaign": self.name, "method": self.method}

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
        return bool(self.bursts) and all(burst.accepted for burst in self.bursts)

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

    @property
    def remarks(self) -> list[str]:
        """What a reader should know of the whole, in sentences."""
        of_posterior = "" if self.summary is None else self.summary.remark
        return [text for text in (*self.notes, of_posterior) if text]

    def rows(self) -> list[dict[str, Any]]:
        """Return the rows of ``moduli.csv``."""
        return [dict(zip(MODULUS_COLUMNS, burst.row(), strict=True)) for burst in self.bursts]

    def to_csv(self) -> str:
        """Return the table of results: numbers with nine significant digits, an empty cell where there is none."""
        return csv_table(MODULUS_COLUMNS, [[number_or_none(value) for value in burst.row()] for burst in self.bursts])

    @property
    def tables(self) -> dict[str, str]:
        """CSV tables by the name of their file."""
        return {"moduli.csv": self.to_csv()}

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: everything but time signals and curves."""
        return {
            "version": 1,
            **{name: getattr(self, name) for name in self.heading},
            "settings": self.settings,
            **self.contents(),
            **({} if self.summary is None else self.summary.to_dict()),
        }

    def contents(self) -> dict[str, Any]:
        """Return what `to_dict` has of this kind of fit."""
        checks = {name: self.gross_check(name) for name in self.configurations}
        return {
            "all_accepted": self.all_accepted,
            "bursts": [_burst_dict(burst) for burst in self.bursts],
            "gross_check": {name: check.mean_relative_error for name, check in checks.items() if check is not None},
            **({"remarks": self.notes} if self.notes else {}),
        }


def number_or_none(value: Any) -> Any:
    """Return a value of a table; nothing for a number that is not finite."""
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _burst_dict(burst: BurstFit) -> dict[str, Any]:
    plain = dict(zip(MODULUS_COLUMNS, burst.row(), strict=True))
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
