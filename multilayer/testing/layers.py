"""The laws that every layer type keeps: `check_layer`.

Each law is one function that yields the ways in which a layer breaks it; nothing here needs a test framework.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.config import dump_yaml, parse_yaml
from multilayer.errors import ValidityWarning
from multilayer.layers import LAYERS, Layer
from multilayer.layers.elastic_solid import ElasticSolid
from multilayer.matrix.couplings import CouplingError
from multilayer.matrix.families import Family
from multilayer.matrix.solve import solve
from multilayer.matrix.wave import Wave
from multilayer.paths import value_at
from multilayer.response import plane_wave, plane_wave_derivatives
from multilayer.response.fields import face_states, normal_pressure
from multilayer.response.linearised import real_fields
from multilayer.response.system import behind_gas
from multilayer.stack import Ambient, Stack
from multilayer.testing.broken import broken_laws
from multilayer.testing.units import wrong_units

FREQUENCIES = (1.0, 31.0, 1e3, 9.7e3, 5e4)  # Hz
ANGLES = (0.0, 30.0, 60.0, 85.0, 89.9)  # degrees
AZIMUTHS = (0.0, 37.0, 90.0, 121.0, 217.0)  # degrees; the second and the last are half a turn apart

_CREATED = 1e-12  # share of the incident power
_DIFFERENT = 1e-9
_PARTS_DIFFERENT = 1e-8  # stiff lossless parts at a sharp resonance
_SAMPLES_DIFFERENT = 1e-10  # rows are exchanged for all systems alike: rounding errors depend on the others beside one
_DECAYING = np.array([0.7 - 0.2j, 1.3 - 0.1j, 2.0 - 1.0j])  # kx over the wavenumber of sound
_BESIDE, _NOT_ANALYTIC = 1e-5, 1e-6  # a step of kx over itself; left of a pressure, where abs(kx) leaves about 1e-5
_STEP = 1e-4  # of a value, of the coarser differences
_DERIVATIVES_DIFFERENT = 1e-6
_FIRST, _SECOND = (
    ElasticSolid(thickness=h, density=1500.0, young_modulus=E, poisson_ratio=0.3, loss_factor=0.05)
    for h, E in ((1e-3, 3e9), (4e-3, 1e7))
)


@dataclass(frozen=True)
class _Subject:
    layer: Layer
    frequency: RealArray
    lossless: bool

    def faces(self) -> tuple[Family, ComplexArray, ComplexArray]:
        """Return the family and both face matrices, shape (n_frequency, n_angle, n, n)."""
        faces = self.layer.faces(Wave.incident(self.frequency, ANGLES, Ambient().gas))
        shape = (self.frequency.size, len(ANGLES))
        front, back = (
            np.moveaxis(np.broadcast_to(matrix, matrix.shape[:2] + shape), (0, 1), (-2, -1))
            for matrix in (faces.front, faces.back)
        )
        return faces.family, front, back


Law: TypeAlias = Callable[[_Subject], Iterator[str]]


def check_layer(layer: Layer, *, frequency: Any = FREQUENCIES, lossless: bool = False) -> None:
    """Check that a layer keeps the laws that all layers keep.

    The laws: well-formed and finite face matrices; fields in units that are SI; reciprocity; passivity, by the power
    at its two faces and by what it reflects and transmits; energy balance; composition (one layer equals two bonded
    parts, from a thousandth to ten times its thickness); an infinitely thin layer has no effect; normal incidence is
    the limit of small angles; finite and continuous response near grazing; a response that is analytic where waves
    decay along the layer (complex trace wavenumbers, as in lined ducts); the azimuth makes no difference to a layer
    that is isotropic in its plane, half a turn none to any, and a field ``azimuth`` turns the layer as that of the wave
    does; arrays of frequency, angle, azimuth and parameters give the same as single calls; derivatives by its fields
    agree with differences; read from a stack file, it is the same.

    Parameters
    ----------
    layer : Layer
        The type must be registered (entry point ``multilayer.layers``, or `LAYERS.register`). A type with a field
        ``thickness`` that is no homogeneous slab must set the class attribute ``composes = False``, one that is not
        isotropic in its plane ``isotropic_in_plane = False``.
    frequency : array
        Hz, one axis; narrow it for a layer that holds in a band only.
    lossless : bool
        Check besides that no energy is lost.

    Raises
    ------
    AssertionError
        With every law that is broken, by how much, and where.

    Examples
    --------
    >>> from multilayer.layers.fluid import Fluid
    >>> from multilayer.testing import check_layer
    >>> check_layer(Fluid(thickness=0.1), lossless=True)
    """
    subject = _Subject(layer, np.asarray(frequency, dtype=float), lossless)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)  # the laws hold outside a formula's range too
        broken = broken_laws(_LAWS, subject)
    if broken:
        raise AssertionError("\n- ".join([f"a layer of type '{layer.type}' breaks these laws:", *broken]))


def _well_formed_faces(subject: _Subject) -> Iterator[str]:
    family, front, back = subject.faces()
    for name, matrix in (("front", front), ("back", back)):
        if matrix.shape[-2:] != (family.size, family.size):
            yield f"the {name} matrix is {matrix.shape[-2]} x {matrix.shape[-1]}, not {family.size} x {family.size}"
        if not np.all(np.isfinite(matrix)):
            yield f"the {name} matrix holds numbers that are not finite"


def _units(subject: _Subject) -> Iterator[str]:
    yield from wrong_units(type(subject.layer))


def _reciprocity(subject: _Subject) -> Iterator[str]:
    """For any two fields of one layer, the work of each one's stresses on the other's motion is the same."""
    family, front, back = subject.faces()
    form = np.zeros((family.size, family.size))
    for velocity, stress, sign in family.power_pairs:
        mirrored = -1 if velocity in family.even else 1  # the second field travels towards -x1
        form[velocity, stress], form[stress, velocity] = sign * mirrored, -sign * mirrored
    work, size = _between_faces(form, front, back)
    yield from _exceeding(np.max(np.abs(work) / size, axis=(-2, -1)), _DIFFERENT, "the two faces differ by", subject)


def _passivity(subject: _Subject) -> Iterator[str]:
    family, front, back = subject.faces()
    form = np.zeros((family.size, family.size))
    for velocity, stress, sign in family.power_pairs:
        form[velocity, stress] = form[stress, velocity] = sign
    power, size = _between_faces(form, front, back, conjugate=True)
    scale = np.sqrt(np.diagonal(size, axis1=-2, axis2=-1))
    kept = np.linalg.eigvalsh(power / (scale[..., :, None] * scale[..., None, :]))
    yield from _exceeding(-kept[..., 0], _DIFFERENT, "some fields leave with more power than they bring, by", subject)
    for termination in ("ambient", "rigid"):
        lost = _lost(subject, termination)
        yield from _exceeding(-lost, _CREATED, f"termination {termination}: power is created,", subject)


def _energy_balance(subject: _Subject) -> Iterator[str]:
    for termination in ("ambient", "rigid") if subject.lossless else ():
        lost = _lost(subject, termination)
        yield from _exceeding(lost, _DIFFERENT, f"termination {termination}: power is lost,", subject)


def _composition(subject: _Subject) -> Iterator[str]:
    layer = subject.layer
    if not layer.composes or not hasattr(layer, "thickness"):
        return
    for factor in np.logspace(-3, 1, 9):
        h = factor * layer.thickness
        whole = _surrounded(_with(layer, thickness=h))
        parts = _surrounded(_with(layer, thickness=0.3 * h), _with(layer, thickness=0.7 * h))
        for name, stack in whole.items():
            difference = _difference(_respond(stack, subject), _respond(parts[name], subject))
            what = f"{h:g} m {name} is not 0.3 and 0.7 of it, difference"
            yield from _exceeding(difference, _PARTS_DIFFERENT, what, subject)


def _vanishing_thickness(subject: _Subject) -> Iterator[str]:
    if not subject.layer.vanishes or getattr(subject.layer, "thickness", None) is None:
        return
    small, smaller = (_distance_from_identity(subject, factor) for factor in (1e-6, 1e-8))
    yield from _exceeding(smaller, 0.1 * small + 1e-6, "with the thickness, T - 1 does not vanish but stays", subject)


def _normal_incidence(subject: _Subject) -> Iterator[str]:
    for name, stack in _surrounded(subject.layer).items():
        difference = _difference(*(_respond(stack, subject, [angle]) for angle in (0.0, 1e-6)))
        yield from _exceeding(difference, _DIFFERENT, f"{name}: 0 and 1e-6 degrees differ by", subject)


def _grazing_incidence(subject: _Subject) -> Iterator[str]:
    for name, stack in _surrounded(subject.layer).items():
        for angle in (89.9, 89.999):
            nearly = np.degrees(np.arccos(np.cos(np.radians(angle)) * (1 - 1e-6)))
            here, beside = (_respond(stack, subject, [a])[0] for a in (angle, nearly))
            jump = np.abs(here - beside)  # of a passive surface no more than the relative change of the cosine
            yield from _exceeding(jump, 1e-5, f"{name}: the reflection jumps near {angle} degrees, by", subject)


def _azimuth(subject: _Subject) -> Iterator[str]:
    layer = subject.layer
    for name, stack in _surrounded(layer).items():
        turned = _respond(stack, subject, azimuth=AZIMUTHS)
        straight, turns = turned[..., :1], _difference(turned[..., 1], turned[..., -1])
        yield from _exceeding(turns, _DIFFERENT, f"{name}: half a turn of the azimuth changes the response by", subject)
        if layer.isotropic_in_plane:
            worst = np.max(_difference(turned, straight), axis=-1)
            what = f"{name}: isotropic_in_plane is true, yet the azimuth changes the response by"
            yield from _exceeding(worst, _DIFFERENT, what, subject)
        single = _respond(stack, subject, azimuth=AZIMUTHS[1])
        what = f"{name}: an array and single numbers of the azimuth differ by"
        yield from _exceeding(_difference(turned[..., 1], single), _SAMPLES_DIFFERENT, what, subject)
    if isinstance(getattr(layer, "azimuth", None), float):
        fields = _surrounded(_with(layer, azimuth=layer.azimuth + AZIMUTHS[1]))  # type: ignore[attr-defined]
        for name, stack in _surrounded(layer).items():
            of_wave, of_layer = _respond(stack, subject, azimuth=AZIMUTHS[1]), _respond(fields[name], subject)
            what = f"{name}: the same turn of the wave and of the field azimuth differ by"
            yield from _exceeding(_difference(of_wave, of_layer), _DIFFERENT, what, subject)


def _decaying_waves(subject: _Subject) -> Iterator[str]:
    """Of a wave that decays along the layer the response is the analytic continuation (Cauchy-Riemann)."""
    if not subject.layer.isotropic_in_plane:
        return
    gas = Ambient().gas
    centre = 2 * np.pi * subject.frequency[:, None] / gas.sound_speed * _DECAYING
    for name, stack in _surrounded(subject.layer).items():
        along, across = (_pressure(stack, subject, centre * (1 + step)) for step in (_BESIDE, 1j * _BESIDE))
        back, down = (_pressure(stack, subject, centre * (1 - step)) for step in (_BESIDE, 1j * _BESIDE))
        error = np.abs((along - back) + 1j * (across - down)) / (np.abs(along) + np.abs(back))
        what = f"{name}: at complex kx the response is not analytic in kx, by"
        yield from _exceeding(error, _NOT_ANALYTIC, what, subject)


def _pressure(stack: Stack, subject: _Subject, kx: ComplexArray) -> ComplexArray:
    """Return the normal pressure of the front face behind a half-space that drives it at any wavenumber."""
    wave = Wave(subject.frequency[:, None], kx, Ambient().gas)
    system = behind_gas(stack, wave)
    front, _ = face_states(system.layers[0], solve(system).layers[0])
    return normal_pressure(system.layers[0], front)


def _broadcasting(subject: _Subject) -> Iterator[str]:
    stack = Stack(layers=(subject.layer,), termination="ambient")
    alone = [plane_wave(stack, float(f), angle) for f in subject.frequency for angle in ANGLES]
    single = np.array([[r.reflection for r in alone], [r.transmission for r in alone]])
    single = single.reshape(2, subject.frequency.size, len(ANGLES))
    difference = _difference(_respond(stack, subject), single)
    yield from _exceeding(difference, _SAMPLES_DIFFERENT, "arrays and single numbers differ by", subject)
    for field, value in subject.layer:
        if not isinstance(value, float | complex):
            continue
        values = [value, 0.99 * value]
        several = _respond(stack.replaced({f"layers.0.{field}": np.reshape(values, (2, 1, 1))}), subject)
        for i, sample in enumerate(values):
            single_sample = _respond(stack.replaced({f"layers.0.{field}": sample}), subject)
            picked = (
                np.broadcast_to(several, (2, 2, *single_sample.shape[1:]))[:, i]
                if several.ndim > single_sample.ndim
                else several
            )
            what = f"an array and single numbers of {field} differ by"
            yield from _exceeding(_difference(picked, single_sample), _SAMPLES_DIFFERENT, what, subject)


def _derivatives(subject: _Subject) -> Iterator[str]:
    """Those by the medium are derivatives: differences of two steps lie about them, as far as these agree."""
    stack = Stack(layers=(_with(subject.layer),), termination="ambient")
    paths = [path for path in real_fields(stack, None) if value_at(stack, path) != 0]
    found = plane_wave_derivatives(stack, paths, subject.frequency, ANGLES)
    for path in paths:
        if path in found.by_differences:
            continue
        value, slope = value_at(stack, path), found.by(path)["reflection"]
        steps = np.array([1.0, -1.0, 0.1, -0.1]) * _STEP
        moved = stack.replaced({path: (value * (1 + steps)).reshape(-1, 1, 1)})
        ends = np.broadcast_to(_respond(moved, subject)[0], (4, *slope.shape))
        coarse, fine = ((ends[i] - ends[i + 1]) / (2 * steps[i]) for i in (0, 2))
        error = np.abs(value * slope - fine) - 2 * np.abs(coarse - fine)
        what = f"the derivative by {path.removeprefix('layers.0.')} and differences, times the value, differ by"
        yield from _exceeding(error, _DERIVATIVES_DIFFERENT * (1 + np.abs(value * slope)), what, subject)


def _yaml_round_trip(subject: _Subject) -> Iterator[str]:
    if subject.layer.type not in LAYERS:
        yield f"no entry point 'multilayer.layers' is called '{subject.layer.type}'; no file can name it"
        return
    stack = Stack(layers=(subject.layer,))
    text = dump_yaml(stack.to_dict())
    back = Stack.model_validate(parse_yaml(text, Path("stack.yaml")).data)
    if back != stack:
        yield f"written as {text!r} it comes back as {back.layers[0]!r}"


_LAWS: tuple[Law, ...] = (
    _well_formed_faces, _units, _reciprocity, _passivity, _energy_balance, _composition, _vanishing_thickness,
    _normal_incidence, _grazing_incidence, _azimuth, _decaying_waves, _broadcasting, _derivatives, _yaml_round_trip,
)  # fmt: skip


def _with(layer: Layer, **values: Numeric) -> Layer:
    return layer.model_copy(update={"name": None, **values})


def _surrounded(*layers: Layer) -> dict[str, Stack]:
    """Return stacks that hold the layers, by a name for messages; between solids only where that is possible."""
    stacks = {
        "in the ambient gas": Stack(layers=layers, termination="ambient"),
        "on a rigid wall": Stack(layers=layers, termination="rigid"),
        "between solids": Stack(layers=(_FIRST, *layers, _SECOND), termination="ambient"),
    }
    try:
        plane_wave(stacks["between solids"], 1e3)
    except CouplingError:
        del stacks["between solids"]
    return stacks


def _respond(stack: Stack, subject: _Subject, angles: Any = ANGLES, azimuth: Any = 0.0) -> ComplexArray:
    """Return reflection and transmission along the first axis, zeros where nothing is behind to transmit into."""
    result = plane_wave(stack, subject.frequency, angles, azimuth=azimuth)
    return np.array([result.reflection, 0 * result.reflection if result.transmission is None else result.transmission])


def _lost(subject: _Subject, termination: Any) -> RealArray:
    reflection, transmission = _respond(Stack(layers=(subject.layer,), termination=termination), subject)
    return np.asarray(1 - np.abs(reflection) ** 2 - np.abs(transmission) ** 2)


def _difference(a: ComplexArray, b: ComplexArray) -> RealArray:
    """Return the larger of the differences in reflection, and in transmission by its own size."""
    size = np.maximum(np.maximum(np.abs(a[1]), np.abs(b[1])), 1e-290)
    return np.asarray(np.maximum(np.abs(a[0] - b[0]), np.abs(a[1] - b[1]) / size))


def _distance_from_identity(subject: _Subject, factor: float) -> RealArray:
    thin: Any = subject.layer
    thin = _with(thin, thickness=factor * thin.thickness)
    family, _, _ = subject.faces()
    scale = np.ones(family.size)
    for _, stress, _ in family.power_pairs:
        scale[stress] = Ambient().gas.impedance
    matrix = thin.transfer_matrix(subject.frequency, ANGLES) * scale / scale[:, None]
    return np.asarray(np.max(np.abs(matrix - np.eye(family.size)), axis=(-2, -1)))


def _between_faces(
    form: RealArray, front: ComplexArray, back: ComplexArray, conjugate: bool = False
) -> tuple[ComplexArray, RealArray]:
    """Return a quadratic form of the front states less that of the back states, and the size of its terms."""

    def value(matrix: ComplexArray) -> ComplexArray:
        left = np.swapaxes(np.conj(matrix) if conjugate else matrix, -2, -1)
        return np.asarray(left @ form @ matrix)

    sizes = (np.swapaxes(np.abs(m), -2, -1) @ np.abs(form) @ np.abs(m) for m in (front, back))
    return value(front) - value(back), np.maximum(sum(sizes), np.finfo(float).tiny)


def _exceeding(error: RealArray, limit: Any, what: str, subject: _Subject) -> Iterator[str]:
    """Yield one message when `error`, shape (n_frequency, n_angle), is above its limit or no number, for the worst."""
    beyond = np.where(np.isfinite(error), error - limit, np.inf)
    if np.any(beyond > 0):
        i, j = np.unravel_index(np.argmax(beyond), beyond.shape)
        angle = f", {ANGLES[j]:g} degrees" if error.shape[1] == len(ANGLES) else ""
        yield f"{what} {error[i, j]:.2g} at {subject.frequency[i]:g} Hz{angle}"
