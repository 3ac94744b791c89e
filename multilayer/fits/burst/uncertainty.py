"""How sure a burst's solution is: noise, the laboratory's own uncertainties, and what the model leaves unexplained."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.experiments.two_plate.burst import BurstProblem
from multilayer.measurements.description import Uncertainty

_BEND = 0.25  # slope of the loss angle by ln f, over the loss angle


@dataclass(frozen=True)
class ErrorParts:
    """Where the uncertainty of a burst's (ln E1, E2/E1) comes from, so that bursts can be compared.

    Attributes
    ----------
    own : array, shape (2, 2)
        Covariance of what belongs to this burst alone: noise, calibration, unexplained residual, and the bend of the
        modulus within the band.
    stated : mapping of str to array, shape (2,)
        What one standard deviation of each stated uncertainty does; other bursts have the same error in common.
    model : array, shape (2, 2)
        What a relative error of the modelled transmissibility does: rows its level (1) and its phase (1 rad).
    """

    own: RealArray
    stated: Mapping[str, RealArray]
    model: RealArray

    @property
    def covariance(self) -> RealArray:
        """Covariance of the solution, shape (2, 2): all parts but that of the model."""
        return np.asarray(self.own + sum(np.outer(shift, shift) for shift in self.stated.values()))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        stated = {name: shift.tolist() for name, shift in self.stated.items()}
        return {"own": self.own.tolist(), "stated": stated, "model": self.model.tolist()}


def pseudo_inverse(jacobian: RealArray) -> RealArray:
    """Return the matrix that turns a small change of the data into the change of the solution."""
    return np.asarray(np.linalg.pinv(jacobian))


def error_parts(problem: BurstProblem, x: RealArray, known: Uncertainty | None) -> ErrorParts:
    """Return the parts of the uncertainty at a solution, each through the linear response of the estimator.

    The noise of both channels (that of the base passes through the transmissibility); that of the calibration; the
    laboratory's stated uncertainties; the unexplained residual, taken as if an error of the same norm lay where the
    unknowns absorb it; and what a loss factor that varies within the band does, for that can be absorbed without a
    residual.
    """
    residual, jacobian = problem.residual_and_jacobian(x)
    response = pseudo_inverse(jacobian)
    unexplained = float(residual @ residual) * response @ response.T
    bend = response @ bend_shift(problem, x)
    top = problem.data.local[2]
    calibrated = response @ problem.as_real(problem.data.calibration_std * np.stack([top, 1j * top])).T
    own = noise_covariance(problem, x, response) + calibrated @ calibrated.T + unexplained + np.outer(bend, bend)
    shifts = {} if known is None else stated_shifts(problem, x, known)
    # a model that is too large finds what a measurement that is too small does
    model = np.stack([response @ problem.as_real(-top), response @ problem.as_real(-1j * top)])
    return ErrorParts(np.asarray(own), {name: response @ shift for name, shift in shifts.items()}, model)


def noise_covariance(problem: BurstProblem, x: RealArray, response: RealArray) -> RealArray:
    """Return the part of the covariance that comes from white noise in both channels."""
    data = problem.data
    _, base, _ = data.local
    ratio = problem.predict(x) / base
    # one bin of a sum over n samples; bins of a padded record are not independent unless thinned
    overlap = max(data.n_fft / data.n_samples / data.stride, 1.0)
    variance = data.n_samples * (data.noise.top**2 + np.abs(ratio) ** 2 * data.noise.base**2) * overlap
    per_entry = np.tile(variance / 2, 2) / problem.scale**2
    return np.asarray((response * per_entry) @ response.T)


def bend_shift(problem: BurstProblem, x: RealArray) -> RealArray:
    """Return what one standard deviation of the modulus' bend within the band does to the residual.

    Where losses rise or fall as a power of frequency, f^a, so does the loss angle, whose slope is a of itself: between
    -1 and 1 for one relaxation, within a half for the broad ones of foams. A quarter is taken as standard deviation.
    """
    if not problem.dispersive:
        return np.zeros(2 * len(problem.data.local[0]))
    bend = _BEND * 2 / np.pi * np.arctan(x[1])
    return problem.as_real(replace(problem, bend=float(bend)).predict(x) - problem.predict(x))


def stated_shifts(problem: BurstProblem, x: RealArray, known: Uncertainty) -> dict[str, RealArray]:
    """Return what one standard deviation of each uncertain quantity does to the residual, by its name."""
    f, _, top = problem.data.local
    here = problem.predict(x)
    shifts: dict[str, ComplexArray] = {
        "channel_gain": known.channel_gain * top,
        "remount_gain": known.remount_gain * top,
        "channel_delay": -2j * np.pi * f * known.channel_delay * top,
    }
    for quantity, amount, relative in (
        ("thickness", known.thickness, False),
        ("density", known.density, True),
        ("top_plate_mass", known.top_plate_mass, True),
    ):
        if amount:
            rig = problem.rig.shifted(quantity, amount, relative=relative)  # type: ignore[arg-type]
            shifts[quantity] = BurstProblem(problem.data, rig, problem.dispersive).predict(x) - here
    return {name: problem.as_real(shift) for name, shift in shifts.items()}
