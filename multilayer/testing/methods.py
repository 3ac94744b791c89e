"""What every inverse method of campaigns keeps: `check_method`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from math import isfinite
from typing import Any

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.experiments.two_plate.plane_waves import PlaneWaveRig
from multilayer.fits.methods import CampaignMethod
from multilayer.fits.result import FitResult
from multilayer.fits.settings import FitSettings, QuasiStatic
from multilayer.fits.sources import FitJob
from multilayer.json_text import json_text
from multilayer.measurements.description import Campaign, Configuration
from multilayer.media.elastic import p_wave_modulus
from multilayer.rig.shape_factor import static_shape_factor
from multilayer.signals.bursts import hann_burst
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import frequencies, to_signal, to_spectrum

_RATE, _CYCLES, _NOISE = 12800.0, 10.0, 1e-3
_FREQUENCIES = (150.0, 250.0, 400.0)
_E1, _LOSS = 2e5, 0.2  # at 250 Hz
_RADIUS = 0.0225
_SLENDER = {"thin": (0.0125, 0.001), "thick": (0.025, 0.001)}  # heights of sample and top plate, m
# of flat discs a free rim does so little that models of infinite extent are within tolerance, and free rods are not
_FLAT = {"flat": (0.005, 0.002), "less flat": (0.006, 0.002)}
_POISSON_RATIO = 0.3  # of the flat discs
_FAR_BELOW = 50.0  # scatter over stated standard deviation; of a rough model's error it may be 20
_FEWEST = 3  # moduli that scatter
Check = Callable[[CampaignMethod, FitResult, float], Iterator[str]]


def check_method(method: CampaignMethod | type[CampaignMethod], *, tolerance: float = 0.15) -> None:
    """Check that an inverse method keeps what all of them keep, on two small campaigns whose modulus is known.

    Says what it is and runs without options; reports progress as often as it says; gives the kind of result that it
    says, under its name; what it accepts is the truth, what it does not has a reason; standard deviations, where it
    states some, are not far below the scatter of what it accepts about the truth; the same input gives the same result;
    tables and record can be written.

    The samples of the first campaign have a Poisson's ratio of 0, those of the second are flat discs with one of 0.3,
    bonded to both plates: as stiff as a free rod times the shape factor.

    Parameters
    ----------
    method : CampaignMethod or its class
    tolerance : float
        Relative error of E1 + i E2 that an accepted modulus may have, the model's own and that of noise (0.1 %).

    Raises
    ------
    AssertionError
        With everything that does not hold, one per line.

    Examples
    --------
    >>> from multilayer.fits.methods import METHODS
    >>> check_method(METHODS["transfer-function"])
    """
    subject = method() if isinstance(method, type) else method
    broken: list[str] = []
    for job in (method_bench(), disc_bench()):
        told: list[str] = []
        result = subject.run(job, told.append)
        broken += [
            f"{check.__name__.strip('_')}: {text}" for check in _CHECKS for text in check(subject, result, tolerance)
        ]
        if len(told) != subject.number_of_steps(job):
            broken.append(f"progress: {subject.number_of_steps(job)} steps are announced, {len(told)} reported")
        if job is method_bench() and json_text(subject.run(job, told.append).to_dict()) != json_text(result.to_dict()):
            broken.append("repeats: the same input gives another result")
    if broken:
        raise AssertionError("\n".join(dict.fromkeys(broken)))


def _says_what_it_is(method: CampaignMethod, result: FitResult, _: float) -> Iterator[str]:
    for field in ("name", "title", "summary"):
        if not str(getattr(method, field, "")).strip():
            yield f"the class needs a '{field}'"
    if not isinstance(result, method.gives):
        yield f"it gives a {type(result).__name__}, not the {method.gives.__name__} that its class announces"
    if (result.method, result.name) != (method.name, method_bench().name):
        yield f"the result is that of '{result.method}' and '{result.name}', not of the method and the campaign"


def _finds_the_truth(_: CampaignMethod, result: FitResult, tolerance: float) -> Iterator[str]:
    if not any(burst.accepted for burst in result.bursts):
        yield "it accepts no modulus of a campaign without any difficulty"
    wrong = set()
    for burst in result.bursts:
        given, truth = complex(burst.storage_modulus, burst.loss_modulus), complex(true_modulus(burst.frequency))
        place = f"{burst.configuration} {burst.frequency:g} Hz"
        if not burst.accepted and not burst.reason:
            yield f"{place}: not accepted, and no reason is told"
        if burst.accepted and not abs(given - truth) <= tolerance * abs(truth):
            yield f"{place}: {given:.4g} Pa are accepted; the truth is {truth:.4g} Pa"
            wrong.add(burst.configuration)
    for name in (name for name in _FLAT if name in wrong):
        factor = _shape_factor(_POISSON_RATIO, _FLAT[name][0])
        yield (
            f"{name} is a bonded disc with a Poisson's ratio of {_POISSON_RATIO:g}, {factor:.3g} times as stiff as a "
            "free rod: multilayer.rig.shape_factor.static_shape_factor tells this factor"
        )


def _knows_its_errors(_: CampaignMethod, result: FitResult, __: float) -> Iterator[str]:
    accepted = [burst for burst in result.bursts if burst.accepted]
    truth = true_modulus([burst.frequency for burst in accepted])
    parts = {
        "E1": ([(b.storage_modulus, b.storage_modulus_std) for b in accepted], truth.real),
        "E2": ([(b.loss_modulus, b.loss_modulus_std) for b in accepted], truth.imag),
    }
    for name, (stated, true) in parts.items():
        values, errors = np.array(stated, dtype=float).reshape(-1, 2).T
        known = np.isfinite(values) & np.isfinite(errors)
        if np.count_nonzero(known) < _FEWEST:
            continue
        scatter, usual = float(np.std((values - true)[known])), float(np.median(errors[known]))
        if scatter > _FAR_BELOW * max(usual, 0.0):
            yield (
                f"{name} scatters by {scatter:.2g} Pa from burst to burst about the truth, and its standard deviation "
                f"is stated as {usual:.2g} Pa; state what it is, or NaN where it is not known"
            )


def _can_be_written(_: CampaignMethod, result: FitResult, __: float) -> Iterator[str]:
    if not all(text.strip() for text in result.tables.values()):
        yield "a table is empty"
    for row in result.rows():
        wrong = [name for name, value in row.items() if not isinstance(value, str | float | bool)]
        if wrong:
            yield f"{', '.join(wrong)} must be text or Python's own numbers"
        negative = [name for name, value in row.items() if "_std" in name and isfinite(value) and value < 0]
        if negative:
            yield f"{', '.join(negative)} must not be negative"


_CHECKS: tuple[Check, ...] = (_says_what_it_is, _finds_the_truth, _knows_its_errors, _can_be_written)


def true_modulus(frequency: ArrayLike) -> ComplexArray:
    """Return the modulus of the bench's sample, Pa: the causal law of constant loss factor."""
    relative: RealArray = np.asarray(frequency, dtype=float) / 250.0
    return np.asarray(_E1 * (1 + 1j * _LOSS) * relative ** (2 / np.pi * np.arctan(_LOSS)))


@cache
def method_bench() -> FitJob:
    """Return a small campaign, two heights of a sample with a Poisson's ratio of 0, whose modulus is `true_modulus`."""
    return _job(_SLENDER, 0.0)


@cache
def disc_bench() -> FitJob:
    """Return one of flat discs with a Poisson's ratio of 0.3, bonded to both plates, of the same modulus.

    Their motion is that of rods, stiffer by the static shape factor: at these frequencies that of the virtual rig's
    finite elements to a hundredth.
    """
    return _job(_FLAT, _POISSON_RATIO)


def _job(heights: dict[str, tuple[float, float]], poisson_ratio: float) -> FitJob:
    campaign = Campaign.model_validate(_campaign(heights, poisson_ratio))
    recordings = {}
    for configuration in campaign.configurations:
        for burst in configuration.bursts:
            recordings[configuration.name, burst.frequency] = _recording(campaign, configuration, burst.frequency)
    slow = complex(true_modulus(5.0))
    static = QuasiStatic(storage_modulus=slow.real, loss_modulus=slow.imag, frequency=5.0)
    return FitJob(campaign, recordings, FitSettings(quasi_static=static), None)


def true_motion(campaign: Campaign, configuration: Configuration, frequency: RealArray) -> ComplexArray:
    """Return top over base motion of a bench, for frequencies (n,) in Hz."""
    poisson_ratio = campaign.specimen.poisson_ratio
    factor = _shape_factor(poisson_ratio, configuration.specimen_thickness)
    modulus = true_modulus(frequency) * factor / p_wave_modulus(1.0, poisson_ratio)  # that of the rig is held laterally
    return PlaneWaveRig.of(campaign, configuration).transmissibility(frequency, modulus)


def _shape_factor(poisson_ratio: float, thickness: float) -> float:
    return static_shape_factor(poisson_ratio, _RADIUS / (2 * thickness)) if poisson_ratio else 1.0


def _recording(campaign: Campaign, configuration: Configuration, frequency: float) -> Recording:
    n = int((_CYCLES / frequency + 0.15) * _RATE)
    base = hann_burst(frequency, _CYCLES, _RATE, n_samples=n, start=0.002)
    n_fft = 8 * n
    f = frequencies(n_fft, _RATE)
    ratio = np.ones(len(f), dtype=complex)
    ratio[1:] = true_motion(campaign, configuration, f[1:])
    top = to_signal(ratio * to_spectrum(base, n_fft), n_fft, n)
    rng = np.random.default_rng(int(frequency))
    noisy = [signal + _NOISE * signal.std() * rng.standard_normal((2, n)) for signal in (base, top)]
    return Recording(noisy[0], noisy[1], _RATE)


def _campaign(heights: dict[str, tuple[float, float]], poisson_ratio: float) -> dict[str, Any]:
    bursts = [{"frequency": f, "file": f"{f:g}.npz"} for f in _FREQUENCIES]
    return {
        "version": 1,
        "rig": "shaker-two-plate",
        "sampling_rate": _RATE,
        "specimen": {"density": 90, "poisson_ratio": poisson_ratio},
        "top_plate": {"density": 7850, "young_modulus": 2.1e11, "poisson_ratio": 0.3},
        "base_plate": {"density": 2700, "young_modulus": 7e10, "poisson_ratio": 0.33, "thickness": 0.01},
        "uncertainty": {"channel_gain": 0.003, "channel_delay": 1e-6, "thickness": 5e-5, "density": 0.01},
        "burst": {"cycles": _CYCLES, "level_rms": 5.0},
        "configurations": [
            {
                "name": name,
                "specimen_thickness": sample,
                "top_plate_thickness": plate,
                "specimen_radius": _RADIUS,
                "bursts": bursts,
            }
            for name, (sample, plate) in heights.items()
        ],
    }
