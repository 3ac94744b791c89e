"""The smallest piece of a simulation: one stack, or a chunk of samples of it, at all frequencies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypeGuard
from warnings import warn

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import BoolArray, RealArray
from multilayer.errors import InputError, MultilayerError, Problem, ValidityWarning
from multilayer.paths import value_at, with_values
from multilayer.response.bands import POINTS_PER_THIRD, nearest_centres
from multilayer.response.beside import Shares, Sound
from multilayer.response.chunks import in_chunks
from multilayer.response.construction import Construction, wall_shares
from multilayer.response.diffuse_field import diffuse_field
from multilayer.response.driven import driven
from multilayer.response.duct import duct_mode
from multilayer.response.excitations import Excitation, TappingMachine
from multilayer.response.fields import power_balance
from multilayer.response.finite_size import (
    Window,
    finite_absorption,
    finite_loss,
    half_space_behind,
    radiation_towards,
    refuse_other_fluid,
)
from multilayer.response.free_waves import free_waves
from multilayer.response.plane_wave import PlaneWave, plane_wave
from multilayer.response.system import has_extremes, refusal
from multilayer.simulation.linearised import linearised
from multilayer.simulation.quantities import LOST_IN, normalised, quantity_named
from multilayer.simulation.resonances import Parts, hidden, resolved, uneven
from multilayer.simulation.settings import DiffuseIncidence, Duct, FiniteSize, PlaneIncidence
from multilayer.simulation.spread import Slopes, by_differences
from multilayer.simulation.warned import collected_warnings
from multilayer.stack import Stack

Arrays = dict[str, NDArray[Any]]
OF_FREE_WAVES = ("bending_stiffness", "loss_factor", "phase_speed")  # NaN where no wave runs


@dataclass(frozen=True)
class Task:
    """Arguments of `run_task`; small, because they are pickled for other processes.

    Attributes
    ----------
    stack : Stack
        Or a `Construction`.
    frequency : array
        Hz; of shape (n_bands, n_points) to be averaged over the last axis.
    incidence : PlaneIncidence or DiffuseIncidence
    label : str
        Of the case, for messages.
    size : FiniteSize or None
    reference : Stack or None
        For the insertion loss; see `bare`.
    excitation : Excitation or None
        Beside the incident sound.
    free_waves : bool
        Whether those along the stack are asked for.
    layer_losses : bool
        Whether the shares of the power that the layers lose are.
    duct : Duct or None
        That the stack lines.
    samples : mapping
        By path, values of fields in place of those in `stack`, all of one length; empty for the stack itself.
    deviations : mapping
        By path, standard deviations of fields, whose share of the scatter is asked for.
    effort : mapping
        Arguments of `diffuse_field` in place of its own tolerances.
    resolves : bool
        Whether resonances between the frequencies of a band count; not in fits, whose differences and derivatives are
        of the same frequencies, and whose stacks hold arrays.
    """

    stack: Stack
    frequency: RealArray
    incidence: PlaneIncidence | DiffuseIncidence
    label: str = ""
    size: FiniteSize | None = None
    reference: Stack | None = None
    excitation: Excitation | None = None
    free_waves: bool = False
    layer_losses: bool = False
    duct: Duct | None = None
    samples: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    deviations: Mapping[str, float] = field(default_factory=dict)
    effort: Mapping[str, Any] = field(default_factory=dict)
    resolves: bool = True

    @property
    def window(self) -> Window | None:
        """The finite size as the responses take it."""
        return None if self.size is None else Window(self.size.width, self.size.height)

    def bare(self, stack: Stack) -> Stack:
        """Return the reference in the gas of a stack, whatever its own file says: the air is not what is compared."""
        assert self.reference is not None
        return self.reference.model_copy(update={"ambient": stack.ambient})


@dataclass(frozen=True)
class Outcome:
    """What a task gives.

    Attributes
    ----------
    quantities : dict
        By name, of shape (n_frequency,) or (n_samples, n_frequency).
    warnings : tuple of str
        Of validity.
    spread : dict
        By quantity and path, the standard deviation that comes of a field's tolerance, to first order, shape
        (n_frequency,).
    """

    quantities: Arrays
    warnings: tuple[str, ...]
    spread: dict[str, dict[str, RealArray]] = field(default_factory=dict)


def run_task(task: Task) -> Outcome:
    """Return the quantities of one stack, or of a chunk of samples of it.

    Raises
    ------
    MultilayerError
        When it has no finite response, or one that creates energy, naming the case.
    """
    with collected_warnings() as warnings, np.errstate(all="ignore"):  # what is not finite is refused
        try:
            quantities = _sampled(task) if task.samples else _respond(task.stack, task)
            spread = _spread(task)
        except ArithmeticError as error:  # of single numbers, as those of the gas; arrays become inf or nan
            if not has_extremes(task.stack):
                raise
            raise _of_case(task, refusal(task.stack, f"the stack cannot be computed: {_LOST} ({error})")) from error
        except MultilayerError as error:
            raise _of_case(task, error) from error
    return Outcome(quantities, tuple(dict.fromkeys(warnings)), spread)


_LOST = "its numbers are too large or too small beside each other"


def _of_case(task: Task, error: MultilayerError) -> MultilayerError:
    """Return an error with the case in front of it; without a sweep, the error itself."""
    if not task.label:
        return error
    problems = error.problems if isinstance(error, InputError) else [Problem(str(error))]
    return InputError([replace(problem, message=f"{task.label}: {problem.message}") for problem in problems])


def _sampled(task: Task) -> Arrays:
    """Return quantities of all samples at once, where the response takes arrays; otherwise sample by sample."""
    n = len(next(iter(task.samples.values())))
    rows = [{path: column[i].item() for path, column in task.samples.items()} for i in range(n)]
    if takes_arrays(task, [*task.samples]):
        # one more axis in front of the frequencies
        values = {path: column[:, None] for path, column in task.samples.items()}
        quantities = _respond(with_values(task.stack, values), task, rows)
        return {name: np.broadcast_to(value, (n, value.shape[-1])) for name, value in quantities.items()}
    each = [_respond(with_values(task.stack, row), task) for row in rows]
    return {name: np.stack([row_quantities[name] for row_quantities in each]) for name in each[0]}


def _spread(task: Task) -> dict[str, dict[str, RealArray]]:
    """Return the standard deviations that come of each field's tolerance, by quantity and path."""
    exact = [path for path in task.deviations if _takes_derivatives(task, path)]
    slopes: dict[str, Slopes] = {}
    if exact:
        found = linearised(task.stack, exact, task.frequency, task.incidence, task.window, task.effort)
        every = {name: slopes for name, (_, slopes) in found.items() if not quantity_named(name).is_complex}
        if task.reference is not None:
            every["insertion_loss"] = every["transmission_loss"]
        slopes = {path: {name: slope[i] for name, slope in every.items()} for i, path in enumerate(exact)}
    spread: dict[str, dict[str, RealArray]] = {}
    for path, deviation in task.deviations.items():
        if path not in slopes:
            slopes[path] = by_differences(task.stack, path, deviation, lambda stack: _respond(stack, task))
        for name, slope in slopes[path].items():
            spread.setdefault(name, {})[path] = np.abs(slope) * deviation
    return spread


def takes_arrays(task: Task, paths: Sequence[str]) -> bool:
    """Tell whether the responses of a task take arrays of values at some paths."""
    return isinstance(task.incidence, PlaneIncidence) and is_of_sound(task) and all(map(_is_in_a_layer, paths))


def _takes_derivatives(task: Task, path: str) -> bool:
    return is_of_sound(task) and _is_in_a_layer(path) and isinstance(value_at(task.stack, path), int | float)


def is_of_sound(task: Task) -> bool:
    """Tell whether nothing is asked for but what a stack alone makes of sound, as `linearised` gives it."""
    beside_sound = task.excitation is not None or task.free_waves or task.layer_losses or task.duct is not None
    return not beside_sound and not _is_built(task.stack)


def _is_in_a_layer(path: str) -> bool:
    return path.startswith("layers.")


def _respond(stack: Stack, task: Task, rows: Sequence[Mapping[str, Any]] = ()) -> Arrays:
    """Return quantities over the frequencies of `task`, averaged over its bands if it has any; see `_sampled`."""
    quantities = _averaged(stack, task, rows)
    if task.reference is not None:
        bare = _averaged(task.bare(stack), task)
        quantities["insertion_loss"] = quantities["transmission_loss"] - bare["transmission_loss"]
    return quantities


def _averaged(stack: Stack, task: Task, rows: Sequence[Mapping[str, Any]] = ()) -> Arrays:
    values = _quantities(stack, task.frequency.ravel(), task)
    quantities = {name: value for name, value in values.items() if value is not None}
    if task.frequency.ndim == 1:
        return quantities
    shape = task.frequency.shape
    of_bands = {
        name: value.reshape(*value.shape[:-1], *shape)
        for name, value in quantities.items()
        if not quantity_named(name).is_complex
    }
    if rows:
        of_bands = {name: np.broadcast_to(value, (len(rows), *shape)) for name, value in of_bands.items()}
    means = {name: _mean(name, value, shape[-1]) for name, value in of_bands.items()}
    if _may_be_narrow(task):
        _resolve(stack, rows or [{}], task, of_bands, means)
    return means


def _mean(name: str, values: RealArray, n_points: int, weights: RealArray | None = None) -> RealArray:
    """Return the mean of a quantity over a band that so many frequencies stand for."""
    quantity = quantity_named(name)
    mean = quantity.mean(values, weights)
    return mean + 10 * np.log10(n_points / POINTS_PER_THIRD) if quantity.is_level else mean


def _may_be_narrow(task: Task) -> bool:
    """Tell whether resonances may lie between the frequencies of a band: those at one angle of incidence."""
    return task.resolves and isinstance(task.incidence, PlaneIncidence) and is_of_sound(task)


def _resolve(stack: Stack, rows: Sequence[Mapping[str, Any]], task: Task, of_bands: Arrays, means: Arrays) -> None:
    """Put means that hold narrow resonances in the place of those that may miss them, sample by sample."""
    n_bands, n_points = task.frequency.shape
    values = {name: value.reshape(len(rows), n_bands, n_points) for name, value in of_bands.items()}
    unresolved = np.any(uneven(np.log(task.frequency), values), axis=-1)
    for i in np.flatnonzero(np.any(unresolved, axis=-1)).tolist():
        which, alone = np.flatnonzero(unresolved[i]), with_values(task.stack, rows[i]) if rows[i] else stack
        parts = [Parts.equal(task.frequency[j], {name: value[i, j] for name, value in values.items()}) for j in which]
        for j, band in zip(which, resolved(parts, partial(_real, alone, task)), strict=True):
            for name, mean in means.items():
                mean.reshape(len(rows), n_bands)[i, j] = _mean(name, band.values[name], n_points, band.weights())
            if not band.even:
                text = f"the mean over the band of {nearest_centres(task.frequency[j])[n_points // 2]:g} Hz may miss"
                warn(f"{text} resonances, which are too narrow or too many there", ValidityWarning, stacklevel=2)


def _real(stack: Stack, task: Task, frequency: RealArray) -> Arrays:
    """Return the quantities that are no complex numbers."""
    values = _quantities(stack, frequency, task)
    return {name: v for name, v in values.items() if v is not None and not quantity_named(name).is_complex}


def hidden_between(task: Task, shown: Arrays) -> str:
    """Return what narrow resonances between the single frequencies of a task are missed by them; empty without.

    Parameters
    ----------
    task : Task
        Of a stack itself, without samples.
    shown : dict
        Its quantities.
    """
    of_sound = replace(task, excitation=None, free_waves=False, layer_losses=False, duct=None)
    if task.frequency.ndim > 1 or not _may_be_narrow(of_sound):
        return ""
    with (
        collected_warnings(),
        np.errstate(all="ignore"),
        suppress(MultilayerError, ArithmeticError, np.linalg.LinAlgError),
    ):
        missed = hidden(task.frequency, shown, partial(_real, task.stack, of_sound))
        told = [
            f"the {of.quantity.replace('_', ' ')} is up to {float(f'{abs(of.beyond):.2g}'):g}{_UNITS[of.quantity]} "
            f"{'higher' if of.beyond > 0 else 'lower'} (at {of.frequency:.4g} Hz)"
            for of in missed
        ]
        if told:
            case = f"{task.label}: " if task.label else ""
            return (
                f"{case}{len(task.frequency)} frequencies miss narrow resonances: between two of them "
                f"{' and '.join(told)}, which curves and ratings lack; ask for more points, or for third_octaves, "
                "whose means hold them"
            )
    return ""


_UNITS = {"transmission_loss": " dB", "absorption": ""}


def _quantities(stack: Stack, frequency: RealArray, task: Task) -> dict[str, NDArray[Any] | None]:
    quantities = _quantities_of_sound(stack, frequency, task)
    if task.excitation is not None:
        quantities |= _of_excitation(stack, frequency, task.excitation, task.window)
    if task.free_waves:
        waves = free_waves(stack, frequency)
        quantities |= {name: getattr(waves, name) for name in OF_FREE_WAVES}
    if (duct := task.duct) is not None:
        quantities["duct_attenuation"] = duct_mode(stack, frequency, duct.height, duct.lined, duct.mach).attenuation
    if task.layer_losses:
        quantities |= _of_layers(stack, frequency, task.incidence)
    return quantities


def _of_layers(
    stack: Stack, frequency: RealArray, incidence: PlaneIncidence | DiffuseIncidence
) -> dict[str, NDArray[Any]]:
    """Return the share of the power of a plane wave that each layer loses."""
    assert isinstance(incidence, PlaneIncidence)  # files of others are refused
    parts = in_chunks(lambda piece: power_balance(stack, piece, incidence.angle), stack, frequency, 1)
    lost = np.concatenate([part.dissipated for part in parts], axis=-1)
    return {f"{LOST_IN}{name}": share for name, share in zip(parts[0].layers, lost, strict=True)}


_POWER_OF_0_DB = 1e-12  # W
_PRESSURE_OF_0_DB = 20e-6  # Pa
_ABSORPTION = 10.0  # m2, of the reference room
_THIRD_OCTAVE = np.log(10) / 10  # width of a third octave over the frequency


def _of_excitation(
    stack: Stack, frequency: RealArray, excitation: Excitation, window: Window | None
) -> dict[str, NDArray[Any] | None]:
    """Return levels in the third octaves about the frequencies, and what goes with them."""
    response = driven(stack, frequency, excitation, window=window)
    quantities: dict[str, NDArray[Any] | None] = {
        "radiation_efficiency": response.radiation_efficiency,
        "input_mobility": response.input_mobility,
    }
    if response.radiated_power is not None:
        power = response.radiated_power * _THIRD_OCTAVE * frequency
        quantities["sound_power_level"] = 10 * np.log10(power / _POWER_OF_0_DB)
        if isinstance(excitation, TappingMachine):
            behind = half_space_behind(stack)
            assert behind is not None  # it takes up the power
            squared = 4 * behind[0] * behind[1] * power / _ABSORPTION  # mean squared pressure, diffuse
            quantities["impact_level"] = 10 * np.log10(squared / _PRESSURE_OF_0_DB**2)
    return quantities


def _quantities_of_sound(stack: Stack, frequency: RealArray, task: Task) -> dict[str, NDArray[Any] | None]:
    window = task.window
    if _is_built(stack):
        together = math.prod(task.frequency.shape[1:])
        return _of_wall(wall_shares(stack, frequency, _sound(task.incidence), window, together))
    if isinstance(task.incidence, DiffuseIncidence):
        asked = task.incidence.diffuse
        field = diffuse_field(
            stack, frequency, asked.max_angle, weighting=asked.weighting, window=window, **task.effort
        )
        return {"absorption": field.absorption, "transmission_loss": field.transmission_loss}
    wave = plane_wave(stack, frequency, task.incidence.angle)
    quantities = {
        "absorption": wave.absorption,
        "transmission_loss": wave.transmission_loss,
        "normalised_impedance": normalised(wave.surface_impedance, stack.ambient.gas.impedance),
        "reflection": wave.reflection,
        "transmission": wave.transmission,
    }
    if window is None:
        return quantities
    refuse_other_fluid(stack)
    return quantities | _of_finite_size(wave, window, stack.ambient.gas.sound_speed)


def _is_built(stack: Stack) -> TypeGuard[Construction]:
    return isinstance(stack, Construction) and not stack.is_plain


def _sound(incidence: PlaneIncidence | DiffuseIncidence) -> Sound:
    if isinstance(incidence, PlaneIncidence):
        return Sound(incidence.angle)
    return Sound(None, incidence.diffuse.max_angle, incidence.diffuse.weighting)


def _of_wall(shares: Shares) -> dict[str, NDArray[Any] | None]:
    """Return absorption and loss of a wall of several paths, whose pressures are known of none."""
    with np.errstate(divide="ignore"):
        loss = None if shares.transmission is None else -10 * np.log10(shares.transmission)
    return {"absorption": shares.absorption, "transmission_loss": loss}


ENERGY_ERROR = 1e-3  # of the energy that comes in; a diffuse field is known to 1e-4


def keeps_energy(absorption: RealArray, loss: RealArray | None, error: float = ENERGY_ERROR) -> BoolArray:
    """Tell where a response gives back no more energy than came in, but for an error as a share of that.

    Parameters
    ----------
    absorption : array
    loss : array or None
        Transmission loss, dB, of the same shape; None where nothing goes through.
    error : float
    """
    through = 0.0 if loss is None else 10 ** (-loss / 10)
    return np.asarray((absorption - through >= -error) & (absorption <= 1 + error))


def refuse_unsound(task: Task, outcome: Outcome, frequency: RealArray) -> None:
    """Refuse results that are no numbers, or give back more energy than came in.

    Both come of numbers so far apart that their digits are lost, or of a layer that creates energy. Only results that
    are kept are looked at: an inverse problem may pass through such stacks on its way.

    Parameters
    ----------
    task : Task
    outcome : Outcome
        Its result.
    frequency : array, shape (n_frequency,)
        Hz, of the result.

    Raises
    ------
    InputError
        With the first such frequency and the most extreme field.
    """
    absorption, loss = outcome.quantities["absorption"], outcome.quantities.get("transmission_loss")
    kept = [values for name, values in outcome.quantities.items() if name not in OF_FREE_WAVES]
    sound = ~np.isnan(np.array(kept)).any(axis=0)
    if task.size is None and not _is_built(task.stack):  # edges, and openings, add to what a sample takes in
        sound &= keeps_energy(absorption, loss)
    if not np.all(sound):
        first = float(np.broadcast_to(frequency, sound.shape)[~sound][0])
        reason = f"perhaps as a model does not hold here ({outcome.warnings[0]})" if outcome.warnings else _LOST
        text = f"the response gives back more energy than came in, or is no number: {reason}"
        raise _of_case(task, refusal(task.stack, text, first))


def _of_finite_size(wave: PlaneWave, window: Window, sound_speed: float) -> dict[str, NDArray[Any] | None]:
    """Return absorption and loss of a finite panel; impedance and coefficients stay those of an infinite one."""
    radiation, cosine = radiation_towards(window, wave.frequency, wave.angle, sound_speed)
    changed = {"absorption": finite_absorption(wave.reflection, radiation, cosine), "transmission_loss": None}
    if wave.transmission_loss is not None:
        changed["transmission_loss"] = finite_loss(wave.transmission_loss, radiation.real, cosine)
    return changed
