"""The change of the top plate's motion by a modulus that falls with strain, added to the linear response."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.media.rod import rod_transmissibility
from multilayer.rig.bench import Bench
from multilayer.rig.effect_base import GRAVITY
from multilayer.rig.effects.amplitude_softening import AmplitudeSoftening
from multilayer.rig.effects.preload import static_stress
from multilayer.rig.excitation import Timing
from multilayer.rig.softening import PronySeries, SofteningRod, fit_prony

_HARMONICS = 3.0  # the highest that matters
_FIT_POINTS = 60
_SCALES = np.geomspace(0.2, 8.0, 400)


def softening_of(bench: Bench) -> AmplitudeSoftening | None:
    """Return the softening effect of a configuration; None where the file does not list it."""
    return next((effect for effect in bench.settings.effects if isinstance(effect, AmplitudeSoftening)), None)


def softened_difference(bench: Bench, effect: AmplitudeSoftening, n_samples: int) -> RealArray:
    """Return the change of the top's acceleration by softening, m/s2, shape (bursts, n_samples).

    The finite elements are linear. So a rod with the same mass on top is integrated in time twice, with and without
    softening, and the difference is added to the linear response. The rod's modulus is scaled by the factor that brings
    its linear response closest to that of the finite elements: 1 for a rod under a rigid plate.

    Parameters
    ----------
    bench : Bench
    effect : AmplitudeSoftening
    n_samples : int
        Of the longest record.
    """
    rod = rod_of(bench, effect)
    steps = rod.oversampling(bench.settings.sampling_rate)
    rate = steps * bench.settings.sampling_rate
    base = np.stack([_base(bench.timing, f, steps, n_samples) for f in bench.mounting.frequencies])
    both = [rod.top(base, rate, softened=softened)[:, ::steps] for softened in (True, False)]
    return np.asarray(both[0] - both[1])


def _base(timing: Timing, frequency: float, steps: int, n_samples: int) -> RealArray:
    return timing.base(frequency, oversampling=steps)[: n_samples * steps]


def rod_of(bench: Bench, effect: AmplitudeSoftening) -> SofteningRod:
    """Return the rods, one per burst, that stand for a configuration."""
    low, high = min(bench.mounting.frequencies) / 5, max(bench.mounting.frequencies) * _HARMONICS
    f = np.geomspace(low, high, _FIT_POINTS)
    moduli = [bench.modulus(f, bench.moment(burst, 0)) for burst in bench.mounting.frequencies]
    scale, geometry = modulus_scale(bench), bench.geometry
    return SofteningRod(
        thickness=geometry["thickness"],
        density=geometry["density"],
        top_mass=static_stress(geometry) / GRAVITY,
        series=_together([fit_prony(f, scale * modulus) for modulus in moduli]),
        softening=effect.softening,
        exponent=1 + effect.perturbation,
        highest=max(bench.mounting.frequencies),
    )


def _together(series: Sequence[PronySeries]) -> PronySeries:
    relaxed = np.array([prony.relaxed for prony in series])
    return PronySeries(relaxed, np.stack([prony.stiffnesses for prony in series], axis=-1), series[0].times)


def modulus_scale(bench: Bench) -> float:
    """Return the factor on a rod's modulus that brings its response closest to that of the finite elements."""
    moment = bench.moment(bench.mounting.frequencies[0], 0)
    low, high = bench.timing.band((moment.frequency,) if bench.varies else bench.mounting.frequencies)
    inside = (bench.bins >= low) & (bench.bins <= high) & (bench.bins > 0)
    every = max(np.count_nonzero(inside) // 300, 1)
    f, wanted = bench.bins[inside][::every], bench.response(moment)[inside][::every]
    modulus = bench.modulus(f, moment)
    distances = [float(np.linalg.norm(_rod(bench, f, scale * modulus) - wanted)) for scale in _SCALES]
    best = int(np.argmin(distances))
    near = np.linspace(_SCALES[max(best - 1, 0)], _SCALES[min(best + 1, len(_SCALES) - 1)], 41)
    return float(min(near, key=lambda scale: np.linalg.norm(_rod(bench, f, scale * modulus) - wanted)))


def _rod(bench: Bench, frequency: RealArray, modulus: ArrayLike) -> ComplexArray:
    geometry = bench.geometry
    load = static_stress(geometry) / GRAVITY
    return rod_transmissibility(frequency, modulus, geometry["density"], geometry["thickness"], load)
