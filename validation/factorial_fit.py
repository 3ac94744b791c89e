"""Bursts of the finite-element rig, inverted by the plane-wave model."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from multilayer.arrays import BoolArray, ComplexArray, RealArray
from multilayer.experiments.two_plate.burst import BurstData, BurstProblem
from multilayer.experiments.two_plate.plane_waves import SPECIMEN, PlaneWaveRig
from multilayer.fits.burst.acceptance import discrepancies_in_band
from multilayer.fits.burst.branches import find_candidates, refine
from multilayer.fits.burst.uncertainty import pseudo_inverse
from multilayer.fits.settings import FitSettings
from multilayer.inference.least_squares import distinct
from multilayer.inference.problem import Minimum
from multilayer.media.elastic import p_wave_modulus
from multilayer.rig import static_shape_factor
from multilayer.signals.bursts import hann_burst
from multilayer.signals.spectra import Noise, to_signal, to_spectrum
from multilayer.stack import Stack
from validation.factorial_cases import (
    CYCLES,
    LINES,
    PERIOD,
    PLATE_DENSITY,
    PLATE_MODULUS,
    PLATE_POISSON,
    PLATE_THICKNESS,
    RADIUS,
    Outcome,
    Task,
)
from validation.factorial_rig import respond

_PER_CYCLE = 16  # samples
_EVALUATIONS, _APART = 30, np.array([0.01, 0.02])  # as in a fit's own search
_ALIKE = 2.0  # misfits of solutions that one burst without noise does not tell apart; that of a fit's own search


@dataclass(frozen=True)
class PeriodicBurst(BurstData):
    """A burst that comes again every `PERIOD` cycles, for so long that the rig repeats itself as well.

    A record of one period has lines at multiples of 1/period, each the response to that line of the base and to
    nothing else: no ring-down is cut off, and what happens beyond the burst's main lobe does not matter.
    """

    @cached_property
    def n_fft(self) -> int:
        """Transform length: the period."""
        return self.n_samples

    @cached_property
    def cut_short(self) -> bool:
        """Never."""
        return False


def periodic_burst(frequency: float, transmissibility: ComplexArray) -> PeriodicBurst:
    """Return the signals of a rig whose transmissibility at `LINES` is given; the top within the main lobe."""
    n, rate = PERIOD * _PER_CYCLE, _PER_CYCLE * frequency
    base = hann_burst(frequency, CYCLES, rate, n_samples=n)
    moved = to_spectrum(base, n)
    spectrum = np.zeros_like(moved)
    spectrum[PERIOD + LINES] = transmissibility * moved[PERIOD + LINES]
    return PeriodicBurst("", frequency, rate, base, to_signal(spectrum, n, n), Noise(0.0, 0.0), CYCLES)


def plane_wave_rig(task: Task, density: float) -> PlaneWaveRig:
    """Return sample and top plate in plane motion; the base is rigid, as it is in the finite elements."""
    sample = {"name": SPECIMEN, "thickness": task.thickness, "density": density, "young_modulus": task.modulus}
    plate = {"name": "top_plate", "thickness": PLATE_THICKNESS, "density": PLATE_DENSITY}
    solids = [
        {"type": "elastic_solid", **sample, "poisson_ratio": task.poisson_ratio},
        {"type": "elastic_solid", **plate, "young_modulus": PLATE_MODULUS, "poisson_ratio": PLATE_POISSON},
    ]
    return PlaneWaveRig(Stack.model_validate({"layers": solids, "termination": "free"}))


@cache
def static_ratio(poisson_ratio: float, thickness: float) -> float:
    """Return true over apparent modulus of a slowly compressed sample in the plane-wave model.

    The model takes the sample for one whose rim is held, of the stiffness of a P wave; its stiffness is the shape
    factor's.
    """
    held = float(np.real(np.asarray(p_wave_modulus(1.0, poisson_ratio))))
    return held / static_shape_factor(poisson_ratio, RADIUS / (2 * thickness))


def invert(problem: BurstProblem, storage: float, loss_factor: float, shift: float) -> tuple[float, ...]:
    """Return the columns of a case from `storage` on.

    The search is that of a fit with default settings, over all its bounds, and from two more starts: the truth, and
    where the plane-wave model has it in slow compression.

    Parameters
    ----------
    problem : BurstProblem
    storage, loss_factor : float
        The true ones; Pa.
    shift : float
        True over apparent modulus in slow compression.
    """
    bounds = _bounds()
    searched = find_candidates(problem, *bounds).minima
    truth = np.array([np.log(storage), loss_factor])
    starts = (truth, truth - [np.log(shift), 0.0])
    own = [refine(problem, start, *bounds, _EVALUATIONS) for start in starts]
    minima = distinct([*searched, *own], _APART)
    plausible = [m for m in minima if m.norm <= _ALIKE * minima[0].norm]
    nearest = min(plausible, key=lambda m: float(np.linalg.norm(m.z - truth)))
    following = min((m.norm for m in minima if m is not nearest), default=np.inf)
    missed = searched[0].norm > _ALIKE * minima[0].norm and bool(np.any(_apart(searched[0], minima[0])))
    delta_tof, delta_level = discrepancies_in_band(problem, nearest.z)
    return (
        *_ratios(nearest, truth), *_ratios(minima[0], truth), float(following), float(len(plausible)), float(missed),
        float(nearest.at_bound), float(delta_tof), float(delta_level), *_gains(problem, nearest.z),
    )  # fmt: skip


def _bounds() -> tuple[RealArray, RealArray]:
    given = FitSettings().bounds
    lowest, highest = zip(given.storage_modulus, given.loss_factor, strict=True)
    low, high = (np.array([np.log(modulus), loss]) for modulus, loss in (lowest, highest))
    return low, high


def _apart(one: Minimum, other: Minimum) -> BoolArray:
    return np.asarray(np.abs(one.z - other.z) > _APART)


def _ratios(minimum: Minimum, truth: RealArray) -> tuple[float, float, float]:
    storage = float(np.exp(truth[0] - minimum.z[0]))
    return storage, float(storage * truth[1] / max(minimum.z[1], 1e-12)), minimum.norm


def _gains(problem: BurstProblem, x: RealArray) -> tuple[float, float]:
    """Return the standard deviations of ln E1 and ln E2 per relative noise, white in the burst's band."""
    rows = pseudo_inverse(problem.jacobian(x))
    of_loss = rows[0] + rows[1] / max(x[1], 1e-12)
    share = rows.shape[1] ** -0.5
    return float(share * np.linalg.norm(rows[0])), float(share * np.linalg.norm(of_loss))


def solve(task: Task) -> Outcome:
    """Return what a task gives."""
    start = time.process_time()
    response, design, cases = respond(task), task.design, []
    shift = static_ratio(task.poisson_ratio, task.thickness)
    for j, density in enumerate(design.densities):
        rig = plane_wave_rig(task, density)
        for i, frequency in enumerate(design.frequencies):
            for k, loss_factor in enumerate(design.loss_factors):
                values = response.values[i, j, k]
                problem = BurstProblem(periodic_burst(frequency, values), rig, dispersive=False)
                head = (frequency, density, loss_factor, float(abs(values[len(LINES) // 2])))
                cases.append((*head, *invert(problem, task.modulus, loss_factor, shift)))
    return Outcome(task.key, time.process_time() - start, cases, response.reduction, response.mesh)
