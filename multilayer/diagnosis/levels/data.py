"""Measured transmission loss and absorption, prepared for a diagnosis."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.levels.uncertainty import Situation, Spread, absorption_spread, insulation_spread
from multilayer.errors import InputError
from multilayer.experiments.levels.response import LevelResponse
from multilayer.experiments.levels.sound_field import Ridges, SoundField
from multilayer.experiments.stacks.columns import MeasuredValues, zero_noise
from multilayer.experiments.stacks.effects import Tube
from multilayer.experiments.stacks.measurements import Absorption, Measurement, TransmissionLoss
from multilayer.experiments.stacks.observations import Observation, Scale, grouped
from multilayer.inference.whitening import CorrelatedError, ValueNoise
from multilayer.response.bands import Width, band_edges, nearest_centres
from multilayer.response.finite_size import Window
from multilayer.simulation.measured import Measured
from multilayer.simulation.settings import Bands, DiffuseIncidence
from multilayer.stack import Stack

_FEWEST = 8
_PER_THIRD = 4  # frequencies that stand for a third octave
_LENGTH = 0.5  # correlation length in ln f of what is alike in neighbouring bands
_SOLVER = {"transmission_loss": 0.2, "absorption": 0.01}  # dB, and absolute: errors of few directions and frequencies
_LEAST_TUBE = 0.005  # standard deviation of absorption in a tube
_CONCENTRATION = {"uniform": 0.0, "gaussian": 2.0}


def level_data(
    measurement: Absorption | TransmissionLoss,
    name: str,
    stack_name: str,
    stack: Stack,
    values: MeasuredValues,
    situation: Situation,
    tube: Tube,
) -> Observation:
    """Return a measurement as data of a diagnosis.

    Noise that is not stated is that of the standards' repeatability; the error that neighbouring bands share, unless a
    `model_error` is stated, is what the standards have beyond. Absorption at a single angle has the errors of a tube.

    Parameters
    ----------
    measurement : Absorption or TransmissionLoss
    name, stack_name : str
    stack : Stack
        With nominal values.
    values : MeasuredValues
    situation : {'repeatability', 'in_situ', 'reproducibility'}
        Which standard deviations of the standards.
    tube : Tube
        Of absorption at a single angle.

    Raises
    ------
    InputError
        For too few values, frequencies that are no centres of bands, or a stack that nothing gets through.
    """
    f, measured = values.frequency, np.asarray(values.values, dtype=float)
    if len(f) < _FEWEST:
        raise InputError(f"{name}: {len(f)} frequencies are too few for a diagnosis, which needs {_FEWEST}")
    quantity = measurement.quantity
    if quantity == "transmission_loss" and not stack.lets_through:
        raise InputError(f"{name}: nothing gets through stack '{stack_name}'; end it with 'termination: ambient'")
    sound = _sound(measurement)
    spread = _spread(measurement, f, measured, situation, tube)
    stated = values.noise.real
    if np.any(stated):
        for zero in zero_noise(values):
            raise InputError(f"{name}: the noise is 0 at {zero:g} Hz; add an absolute one, as {{absolute: ...}}")
    else:
        stated = spread.alone
    error = CorrelatedError(1.0, tube.length if _is_in_tube(measurement) else _LENGTH)
    amounts = np.hypot(spread.together, _SOLVER[quantity])
    if (model_error := measurement.model_error) is not None:
        error = CorrelatedError(1.0, model_error.length)
        size = model_error.relative * (1.0 if measurement.in_db else np.abs(measured))
        amounts = np.hypot(size, _SOLVER[quantity])
    nodes = band_nodes(f, measurement.bands, name)
    ridges = Ridges.of(stack, float(np.sqrt(f[0] * f[-1])))
    return Observation(
        name, quantity, stack_name, measurement.unit, f, measured,
        LevelResponse(quantity, nodes, sound, ridges), False, Scale(), ValueNoise(stated, stated), amounts, error,
        int(nodes.size), *grouped(f), estimated=None if np.any(values.noise.real) else float(np.median(stated)),
    )  # fmt: skip


def _sound(measurement: Absorption | TransmissionLoss) -> SoundField:
    size = measurement.finite_size
    window = None if size is None else Window(size.width, size.height)
    if not isinstance(measurement.incidence, DiffuseIncidence):
        return SoundField(measurement.incidence.angle, is_diffuse=False, window=window)
    asked = measurement.incidence.diffuse
    return SoundField(asked.max_angle, concentration=_CONCENTRATION[asked.weighting], window=window)


def _is_in_tube(measurement: Measurement) -> bool:
    return isinstance(measurement, Absorption) and not isinstance(measurement.incidence, DiffuseIncidence)


def _spread(
    measurement: Absorption | TransmissionLoss, f: RealArray, measured: RealArray, situation: Situation, tube: Tube
) -> Spread:
    if isinstance(measurement, TransmissionLoss):
        return insulation_spread(f, situation)
    if not _is_in_tube(measurement):
        return absorption_spread(f, measured, situation)
    # of R = 1 - alpha in power: the error of each part of R, and both directions of it
    together = 2 * tube.error * np.sqrt(np.clip(1 - measured, 0.0, 1.0))
    return Spread(np.full(len(f), _LEAST_TUBE), together)


def spread_in_words(measurement: Measurement, situation: Situation, tube: Tube) -> tuple[str, str]:
    """Return noise and model error that a measurement has where it states none, as `level_data` takes them."""
    if _is_in_tube(measurement):
        return f"{_LEAST_TUBE:g} of absorption (none is said)", f"{tube.error:.2g} of each part of R, as 'tube' has it"
    part = 1 if isinstance(measurement, TransmissionLoss) else 2
    noise = f"ISO 12999-{part}, repeatability"
    if situation == "repeatability":
        return noise, "that of the model's solution alone"
    whole = "in situ" if part == 1 and situation == "in_situ" else "reproducibility"  # in situ is no case of part 2
    return noise, f"ISO 12999-{part}, {whole} beyond repeatability"


def band_nodes(f: RealArray, bands: Width | None, name: str) -> RealArray:
    """Return the frequencies that stand for each datum, Hz, shape (n, p).

    Parameters
    ----------
    f : array, shape (n,)
        Hz; centres of the bands, if there are bands.
    bands : {'third octaves', 'octaves'} or None
    name : str
        Of the measurement, for messages.

    Raises
    ------
    InputError
        For a frequency that is no centre of a band.
    """
    if bands is None:
        return f[:, None]
    Measured(name, f, {}).grid(Bands.model_validate({bands.replace(" ", "_"): (float(f[0]), float(f[-1]))}))
    edges = np.stack([band_edges(np.array([centre]), bands) for centre in nearest_centres(f, bands)])
    count = _PER_THIRD * (1 if bands == "third octaves" else 3)
    inside = (np.arange(count) + 0.5) / count
    return np.asarray(edges[:, :1] * (edges[:, 1:] / edges[:, :1]) ** inside)
