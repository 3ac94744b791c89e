"""How sure a burst's solution is: noise, the laboratory's own uncertainties, and what the model leaves unexplained."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.inverse.burst import BurstProblem
from multilayer.measurements.description import Uncertainty


def pseudo_inverse(jacobian: RealArray) -> RealArray:
    """Return the matrix that turns a small change of the data into the change of the solution."""
    return np.asarray(np.linalg.pinv(jacobian))


def solution_covariance(problem: BurstProblem, x: RealArray, known: Uncertainty | None) -> RealArray:
    """Return the covariance of (ln E1, E2/E1) at a solution, shape (2, 2).

    Sum of three parts, each through the linear response of the estimator: the noise of both channels (that of the
    base passes through the transmissibility); the laboratory's stated uncertainties; and the unexplained residual,
    taken as if an error of the same norm lay where the unknowns absorb it.
    """
    residual, jacobian = problem.residual_and_jacobian(x)
    response = pseudo_inverse(jacobian)
    unexplained = float(residual @ residual) * np.linalg.inv(jacobian.T @ jacobian)
    covariance = noise_covariance(problem, x, response) + unexplained
    if known is not None:
        shifts = response @ np.stack(stated_shifts(problem, x, known), axis=-1)
        covariance = covariance + shifts @ shifts.T
    return np.asarray(covariance)


def noise_covariance(problem: BurstProblem, x: RealArray, response: RealArray) -> RealArray:
    """Return the part of the covariance that comes from white noise in both channels."""
    data = problem.data
    _, base, _ = data.in_band
    ratio = problem.predict(x) / base
    # one bin of a sum over n samples; bins of a padded record are not independent unless thinned
    overlap = max(data.n_fft / data.n_samples / data.stride, 1.0)
    variance = data.n_samples * (data.noise.top**2 + np.abs(ratio) ** 2 * data.noise.base**2) * overlap
    per_entry = np.tile(variance / 2, 2) / problem.scale**2
    return np.asarray((response * per_entry) @ response.T)


def stated_shifts(problem: BurstProblem, x: RealArray, known: Uncertainty) -> list[RealArray]:
    """Return what one standard deviation of each uncertain quantity does to the residual."""
    f, _, top = problem.data.in_band
    here = problem.predict(x)
    gain = float(np.hypot(known.channel_gain, known.remount_gain))
    shifts: list[ComplexArray] = [gain * top, -2j * np.pi * f * known.channel_delay * top]
    for quantity, amount, relative in (
        ("thickness", known.thickness, False),
        ("density", known.density, True),
        ("top_plate_mass", known.top_plate_mass, True),
    ):
        if amount:
            rig = problem.rig.shifted(quantity, amount, relative=relative)  # type: ignore[arg-type]
            shifts.append(BurstProblem(problem.data, rig, problem.dispersive).predict(x) - here)
    return [problem.as_real(shift) for shift in shifts]
