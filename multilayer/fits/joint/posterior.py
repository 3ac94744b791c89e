"""What a joint fit leaves known: the law's own parameters, and bands of every curve."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from multilayer.arrays import ArrayLike, RealArray
from multilayer.experiments.two_plate.campaign import CampaignProblem, RigExperiment
from multilayer.inference.identifiability import Derived
from multilayer.inference.posterior import Band, Posterior
from multilayer.inference.summary import LAPLACE, Tell, summarise

if TYPE_CHECKING:
    from multilayer.fits.joint.result import JointFit

MODULI = ("E1_pa", "E2_pa", "loss_factor")
_LEVELS = (0.68, 0.90)
_DRAWN = 400  # samples for a curve of the rig: its quantiles are then within 0.1 standard deviations


def with_posterior(fit: JointFit, method: str = LAPLACE, tell: Tell | None = None) -> JointFit:
    """Return a joint fit with intervals of all parameters and what the data determine.

    Parameters
    ----------
    fit : JointFit
    method : {'laplace', 'profile', 'nested'}
    tell : callable, optional
        Called with a short text now and then.
    """
    found = summarise(fit.problem, fit.minima, method, derived=law_quantities(fit.problem), tell=tell)
    return replace(fit, summary=found)


def law_quantities(problem: CampaignProblem) -> list[Derived]:
    """Return the law's parameters, which may be made up of several coordinates."""
    space = problem.space
    named = zip(problem.law_parameters, space.names, space.units, strict=True)
    return [
        Derived(parameter.name, name, unit, False, partial(_log_of_law, problem, index))
        for index, (parameter, name, unit) in enumerate(named)
    ]


def _log_of_law(problem: CampaignProblem, index: int, z: RealArray) -> RealArray:
    return np.asarray(problem.space.logs(problem.law_coordinates(z))[..., index])


def modulus_band(fit: JointFit, frequency: ArrayLike, probability: float) -> Band:
    """Return the bands of E1 and E2, Pa, and E2/E1, each array of shape (3, n), at frequencies (n,) in Hz.

    All laws compared and deviations from them count by their evidence; of the best law by itself what is known of it.
    """
    of_best = None if fit.summary is None else fit.summary.posterior
    return fit.laws.band(np.asarray(frequency, dtype=float), probability, of_best)


def modulus_intervals(fit: JointFit) -> list[dict[str, Any]]:
    """Return intervals of the moduli at the frequencies of the bursts, as plain data."""
    if fit.summary is None:
        return []
    at = np.array(sorted({float(f) for data in fit.problem.data for f in data.centres}))
    bands = [modulus_band(fit, at, level) for level in _LEVELS]
    return [
        {"frequency_hz": f}
        | {
            f"{name}_interval_{100 * level:.0f}": [float(band.low[row, k]), float(band.high[row, k])]
            for level, band in zip(_LEVELS, bands, strict=True)
            for row, name in enumerate(MODULI)
        }
        for k, f in enumerate(at.tolist())
    ]


class MotionCurve(NamedTuple):
    """Transmissibility of a configuration at the bins of its bursts, sorted; amplitude and phase (degrees) as rows.

    Attributes
    ----------
    frequency : array, shape (n,)
        Hz.
    measured, modelled : array, shape (2, n)
    band : Band
        Of the model, arrays of shape (2, n).
    """

    frequency: RealArray
    measured: RealArray
    modelled: RealArray
    band: Band


def motion_curves(fit: JointFit, posterior: Posterior, probability: float = 0.9) -> dict[str, MotionCurve]:
    """Return what every configuration's channels should see, with the band of what the fit leaves open."""
    few = replace(posterior, samples=posterior.samples[:: max(1, len(posterior.samples) // _DRAWN)])
    found = {}
    for experiment in fit.problem.experiments:
        data = experiment.data
        order = np.argsort(data.frequency, kind="stable")
        phase = np.unwrap(np.angle(data.ratio[order]))

        def curves(
            z: RealArray, experiment: RigExperiment = experiment, order: Any = order, phase: RealArray = phase
        ) -> RealArray:
            # next to the measured phase, so that no curve jumps by a turn
            difference = experiment.difference(fit.problem.points(z))[..., order]
            amplitude = np.abs(experiment.data.ratio[order]) * np.exp(difference.real)
            return np.stack([amplitude, np.rad2deg(phase + difference.imag)], axis=-2)

        measured = np.stack([np.abs(data.ratio[order]), np.rad2deg(phase)])
        modelled = curves(fit.best.z[None])[0]
        found[data.name] = MotionCurve(data.frequency[order], measured, modelled, few.band(curves, probability))
    return found
