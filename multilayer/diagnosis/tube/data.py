"""Reflection coefficients measured in a tube, prepared for a diagnosis."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, IndexArray, RealArray
from multilayer.errors import InputError
from multilayer.experiments.stacks.columns import MeasuredValues, zero_noise
from multilayer.experiments.stacks.effects import Tube
from multilayer.experiments.stacks.measurements import Reflection, SurfaceImpedance
from multilayer.experiments.stacks.observations import Observation, Scale, grouped
from multilayer.experiments.stacks.responses import WaveResponse
from multilayer.inference.whitening import CorrelatedError, ValueNoise
from multilayer.simulation.settings import PlaneIncidence

_SPACING = 0.05  # of frequencies in ln f: nearer ones carry little information, as their errors are correlated
_FEWEST = 8
_THIRD = np.array([1.0, -3.0, 3.0, -1.0])  # third differences
_LARGE, _SMALL = 80.0, 4.0  # medians of |Z| that no sample reaches: as a multiple of rho c; or falls below: in Pa s/m


def tube_data(
    measurement: SurfaceImpedance | Reflection, name: str, stack: str, scale: Scale, values: MeasuredValues, tube: Tube
) -> Observation:
    """Return a measurement as data of a diagnosis: frequencies even in ln f, noise estimated where none is stated.

    Parameters
    ----------
    measurement : SurfaceImpedance or Reflection
    name, stack : str
    scale : Scale
        Transformation of the measured quantity to the reflection coefficient.
    values : MeasuredValues
    tube : Tube

    Raises
    ------
    InputError
        When there are too few frequencies, or noise must be estimated and cannot.
    """
    f, v = values.frequency, np.asarray(values.values, dtype=complex)
    if len(f) < _FEWEST:
        raise InputError(f"{name}: {len(f)} frequencies are too few for a diagnosis, which needs {_FEWEST}")
    _refuse_contradiction(measurement, name, v)
    reflection, slope = scale.of_measured(v), np.asarray(scale.slope(v), dtype=complex)
    estimated = None if _has_noise(values) else roughness(reflection)
    noise = values.noise
    if estimated is not None:
        size = estimated / np.abs(slope)
        noise = ValueNoise(size, size)
    else:
        for zero in zero_noise(values):
            raise InputError(f"{name}: the noise is 0 at {zero:g} Hz; add an absolute one, as {{absolute: ...}}")
    stated = measurement.model_error
    error = (
        CorrelatedError(tube.error, tube.length) if stated is None else CorrelatedError(stated.relative, stated.length)
    )
    kept = _even(f)
    return Observation(
        name, measurement.kind, stack, measurement.unit, f[kept], v[kept],
        WaveResponse("reflection", f[kept], PlaneIncidence(angle=measurement.angle)), False, scale,
        ValueNoise(noise.real[kept], noise.imaginary[kept]),
        np.asarray(1 / slope if stated is None else v, dtype=complex)[kept], error, len(kept), *grouped(f[kept]),
        measurement.angle, estimated,
    )  # fmt: skip


def _has_noise(values: MeasuredValues) -> bool:
    return bool(np.any(values.noise.real) or np.any(values.noise.imaginary))


def _even(f: RealArray) -> IndexArray:
    """Return the indices of frequencies about evenly spaced in ln f."""
    count = max(round(float(np.log(f[-1] / f[0])) / _SPACING) + 1, _FEWEST)
    if len(f) <= count:
        return np.arange(len(f))
    wanted = np.geomspace(f[0], f[-1], count)
    right = np.clip(np.searchsorted(f, wanted), 1, len(f) - 1)
    nearest = np.where(wanted - f[right - 1] < f[right] - wanted, right - 1, right)
    return np.unique(nearest)


def roughness(reflection: ComplexArray) -> float:
    """Return the standard deviation of the noise of each part of R, from third differences of neighbouring values.

    A quadratic trend over four neighbours cancels; the remainder counts as noise, so that a coarse grid overstates it.
    Errors common to neighbours, as those of mounting, are not included. The median of absolute values over 0.6745 is
    robust against steps and outliers (F. R. Hampel, J. Am. Stat. Assoc. 69 (1974) 383-393); differences as estimates of
    noise: J. von Neumann, Ann. Math. Stat. 12 (1941) 367-395.
    """
    differences = np.convolve(reflection, _THIRD, mode="valid")
    size = float(np.median(np.abs(np.concatenate([differences.real, differences.imag]))))
    return max(size / 0.6745 / float(np.sqrt(np.sum(_THIRD**2))), 1e-5)


def _refuse_contradiction(measurement: SurfaceImpedance | Reflection, name: str, values: ComplexArray) -> None:
    """Refuse values whose size contradicts the quantity that the file states."""
    typical = float(np.median(np.abs(values)))
    if isinstance(measurement, Reflection):
        if typical > 1.5:
            raise InputError(
                f"{name}: these are no reflection coefficients: half of them exceed {typical:.3g}, and no passive "
                "sample reflects more than comes; if they are impedances, say 'kind: surface_impedance'"
            )
    elif measurement.normalised and typical > _LARGE:
        raise InputError(
            f"{name}: an impedance of typically {typical:.3g} times rho c; if it is in Pa s/m, say 'normalised: false'"
        )
    elif not measurement.normalised and typical < _SMALL:
        raise InputError(
            f"{name}: an impedance of typically {typical:.3g} Pa s/m is far below that of air; if it is a multiple of "
            "rho c, say 'normalised: true'"
        )
