"""The check of the adhesive alone: two plates glued together without a sample must move as one.

Bonfiglio & Pompoli 2015, Section 2: the effect of the adhesive layer was evaluated "by testing a single adhesive layer
and verifying that the transmissibility is constant in the frequency range of interest with the magnitude and phase
equal to unity and zero".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.chi2 import exceeding
from multilayer.csv_table import csv_table
from multilayer.errors import InputError
from multilayer.signals.calibration import Calibration

COLUMNS = ("frequency_hz", "amplitude", "amplitude_std", "phase_deg", "phase_std_deg", "p_value", "is_unity")
SIGNIFICANT = 0.01  # of all bursts together: each has its share


@dataclass(frozen=True, eq=False)
class AdhesiveCheck:
    """Transmissibility of two plates glued together.

    Attributes
    ----------
    name : str
    frequency : array, shape (n,)
        Hz, rising.
    transmissibility : complex array, shape (n,)
        Top over base.
    std : array, shape (n,)
        Standard deviation of its amplitude, relative, and of its phase, rad.
    calibrated : bool
        Whether the difference between the two channels was taken out.
    """

    name: str
    frequency: RealArray
    transmissibility: ComplexArray
    std: RealArray
    calibrated: bool

    @property
    def p_values(self) -> RealArray:
        """Probability that noise alone departs as far from T = 1, amplitude and phase together, shape (n,)."""
        squares = np.abs(np.log(self.transmissibility)) ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            chi_square = np.where(squares > 0, squares / self.std**2, 0.0)
        return np.array([exceeding(value, 2) for value in chi_square])

    @property
    def is_unity(self) -> list[bool]:
        """Whether T = 1 within the noise, burst by burst."""
        return [bool(p > SIGNIFICANT / len(self.frequency)) for p in self.p_values]

    @property
    def limit(self) -> float:
        """Frequency up to which T = 1 at all bursts, Hz; 0 where it is not at the lowest."""
        fails = np.flatnonzero(~np.array(self.is_unity))
        last = fails[0] - 1 if fails.size else len(self.frequency) - 1
        return float(self.frequency[last]) if last >= 0 else 0.0

    @property
    def sentence(self) -> str:
        """The verdict."""
        f, t = self.frequency, self.transmissibility
        worst = int(np.argmax(np.abs(np.log(t))))
        off = f"largest departure at {f[worst]:g} Hz: {100 * (abs(t[worst]) - 1):+.2g} %, "
        off += f"{np.rad2deg(np.angle(t[worst])):+.2g} degrees, known to {100 * self.std[worst]:.1g} %"
        if all(self.is_unity):
            return f"T = 1 within the noise from {f[0]:g} to {f[-1]:g} Hz ({off})"
        upto = f"up to {self.limit:g} Hz only" if self.limit else "not even at the lowest burst"
        remedy = "a thinner or stiffer adhesive, or diagnose with its effect"
        if not self.calibrated:
            remedy = f"take the channels' own difference out with --calibration; else {remedy}"
        return f"T = 1 within the noise {upto} ({off}): {remedy}"

    def rows(self) -> list[dict[str, Any]]:
        """Return one row per burst, under `COLUMNS`."""
        t = self.transmissibility
        columns = (
            self.frequency, np.abs(t), np.abs(t) * self.std, np.rad2deg(np.angle(t)), np.rad2deg(self.std),
            self.p_values,
        )  # fmt: skip
        return [
            dict(zip(COLUMNS, (*(float(value) for value in row), unity), strict=True))
            for *row, unity in zip(*columns, self.is_unity, strict=True)
        ]

    def to_csv(self) -> str:
        """Return the table."""
        return csv_table(COLUMNS, (row.values() for row in self.rows()))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "version": 1, "name": self.name, "calibrated": self.calibrated, "is_unity": all(self.is_unity),
            "limit_hz": self.limit, "sentence": self.sentence, "bursts": self.rows(),
        }  # fmt: skip


def check_adhesive(name: str, glued: Calibration, calibration: Calibration | None = None) -> AdhesiveCheck:
    """Return the check of an adhesive.

    Parameters
    ----------
    name : str
    glued : Calibration
        Ratio, delay and deviation of the two plates' motion, as `calibrate` returns them of the glued plates.
    calibration : Calibration, optional
        Of the channels, taken out.

    Raises
    ------
    InputError
        For bursts outside of the calibrated frequencies.
    """
    f = glued.frequencies
    value = glued.amplitude_ratio * np.exp(-2j * np.pi * f * glued.time_shift)
    std = glued.std
    if calibration is not None:
        try:
            of_channels = np.array([calibration.at(frequency) for frequency in f])
        except InputError as error:
            raise InputError(f"--calibration: {error}") from None
        value = value / of_channels[:, 0] * np.exp(2j * np.pi * f * of_channels[:, 1])
        std = np.hypot(std, [calibration.std_at(frequency) for frequency in f])
    return AdhesiveCheck(name, f, value, std, calibration is not None)
