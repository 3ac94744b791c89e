"""What a stack does, for programs of finite and boundary elements, of statistical energy analysis and of rooms."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeAlias
from warnings import warn

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.bounds import RESULT_BYTES
from multilayer.errors import InputError, ValidityWarning, suggest
from multilayer.exchange.formats import Exported
from multilayer.response.ports import (
    FaceKind,
    admittance_matrix,
    impedance_matrix,
    surface_admittance,
    surface_impedance,
    transfer_matrix,
)
from multilayer.simulation.bands import Grid, grid_of
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.settings import DiffuseIncidence, PlaneIncidence
from multilayer.simulation.tasks import Task, refuse_unsound, run_task

Along: TypeAlias = Literal["angle", "trace_wavenumber"]

_TIME = "time and trace dependence exp(+i (w t - kx x1)); SI units; the layers are infinite in their plane"
_IMPEDANCE, _ADMITTANCE = "Pa s/m", "m/Pa/s"
_BYTES = 500  # of a value of a matrix, once more where pieces are put together


@dataclass(frozen=True)
class Kind:
    """One kind of table.

    Attributes
    ----------
    summary : str
        For the user.
    remark : str
        What a reader must know of signs.
    at_faces : callable or None
        One of `response.ports`, where it is such.
    units : mapping
        By name, empty for a pure number: what `at_faces` gives, the entries of a matrix row by row.
    levels : tuple of str
        Names of quantities of a simulation, where it is such.
    """

    summary: str
    remark: str
    at_faces: Callable[..., ComplexArray] | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    levels: tuple[str, ...] = ()

    @property
    def has_back(self) -> bool:
        """Whether the back face is a port, in place of the stack's termination."""
        return len(self.units) > 1


@dataclass(frozen=True)
class Wanted:
    """What is asked for beside the simulation file.

    Attributes
    ----------
    kind : str
        A name in `KINDS`.
    along : str
        ``angle`` (degrees), ``trace_wavenumber`` (rad/m), or empty: the incidence of the file.
    directions : tuple of float
        Values of `along`.
    front, back : str
        What touches the faces, see `response.ports`.
    """

    kind: str
    along: Along | Literal[""] = ""
    directions: tuple[float, ...] = ()
    front: FaceKind = "fluid"
    back: FaceKind = "fluid"


def _entries(letter: str, *units: str) -> dict[str, str]:
    return {f"{letter}{entry}": unit for entry, unit in zip(("11", "12", "21", "22"), units, strict=True)}


_INWARD = (
    "p1, v1 at the front face, p2, v2 at the back face, both velocities into the layers; the termination is left out"
)
KINDS: dict[str, Kind] = {
    "surface_impedance": Kind(
        "pressure over velocity at the front face, termination behind",
        "Z = p/v, v into the layers; a passive surface has Re Z >= 0",
        surface_impedance,
        {"surface_impedance": _IMPEDANCE},
    ),
    "surface_admittance": Kind(
        "its inverse",
        "Y = v/p, v into the layers; a passive surface has Re Y >= 0",
        surface_admittance,
        {"surface_admittance": _ADMITTANCE},
    ),
    "admittance_matrix": Kind(
        "[v1; v2] = Y [p1; p2] between both faces: trim of FE and SEA",
        f"[v1; v2] = Y [p1; p2]: {_INWARD}",
        admittance_matrix,
        _entries("y", *[_ADMITTANCE] * 4),
    ),
    "impedance_matrix": Kind(
        "[p1; p2] = Z [v1; v2], its inverse",
        f"[p1; p2] = Z [v1; v2]: {_INWARD}",
        impedance_matrix,
        _entries("z", *[_IMPEDANCE] * 4),
    ),
    "transfer_matrix": Kind(
        "[p1; v1] = T [p2; v2] from back face to front face",
        "[p1; v1] = T [p2; v2]: p1, v1 at the front face, p2, v2 at the back face, both velocities from front to back; "
        "the termination is left out",
        transfer_matrix,
        _entries("t", "", _IMPEDANCE, _ADMITTANCE, ""),
    ),
    "absorption": Kind(
        "absorption coefficient, by angle, or in a diffuse field and bands: room acoustics",
        "absorption coefficient: 1 - |R|^2, transmitted sound included",
        levels=("absorption",),
    ),
    "transmission_loss": Kind(
        "transmission loss, dB",
        "transmission loss from the ambient gas into the termination",
        levels=("transmission_loss",),
    ),
    "sea_trim": Kind(
        "absorption, transmission loss and, of a file with a reference, insertion loss: SEA",
        "absorption coefficient: 1 - |R|^2; transmission loss from the ambient gas into the termination; "
        "insertion loss: transmission loss over that of the reference",
        levels=("absorption", "transmission_loss", "insertion_loss"),
    ),
}


def export(simulation: SimulationFile, wanted: Wanted, name: str = "stack") -> Exported:
    """Return a table of what a stack does, at the frequencies of a simulation file.

    Parameters
    ----------
    simulation : SimulationFile
        Without a sweep; of its fields tolerances do not count, and of matrices and impedances neither `finite_size`.
    wanted : Wanted
    name : str
        Of the stack, for the table.

    Raises
    ------
    InputError
        For an unknown kind, a sweep, a kind that does not exist in the field or for the stack or wall asked for, or a
        stack without a finite response; with what to do.

    Warns
    -----
    ValidityWarning
        Where a model is used outside its range.
    """
    if wanted.kind not in KINDS:
        raise InputError(f"there is no table '{wanted.kind}'; {suggest(wanted.kind, KINDS)}")
    if wanted.along == "angle" and not all(0 <= angle < 90 for angle in wanted.directions):
        raise InputError("an angle lies outside the range from 0 to below 90 degrees from the normal; see --angle")
    if len(simulation.cases) > 1:
        text = f"the sweep has {len(simulation.cases)} cases, and a table is of one stack; write the wanted values"
        raise InputError(f"{text} into the file, and leave out 'sweep'")
    kind, grid = KINDS[wanted.kind], grid_of(simulation.cases[0].simulation.frequency)
    file = simulation.cases[0].simulation
    directions = max(1, len(wanted.directions))
    RESULT_BYTES.check(grid.points.size * directions * _BYTES, remedy="ask for fewer frequencies or directions")
    if kind.at_faces is None:
        return _levels(file, grid, kind, wanted, name)
    return _at_faces(file, grid, kind, wanted, name)


def _at_faces(file: SimulationFile, grid: Grid, kind: Kind, wanted: Wanted, name: str) -> Exported:
    assert kind.at_faces is not None
    if not file.is_plain:
        text = f"a wall with openings or links has no one {wanted.kind}; leave out 'beside' and 'links'"
        raise InputError(f"{text}, and it is that of the layers")
    if grid.bands is not None:
        text = f"{wanted.kind} is complex, and has no mean over {grid.bands}; give single frequencies, as"
        raise InputError(f"{text} 'frequency: {{from: 100 Hz, to: 5 kHz}}' or a list of them")
    along, directions = _directions(file, wanted)
    touching: dict[str, Any] = {"faces": (wanted.front, wanted.back)} if kind.has_back else {"face": wanted.front}
    matrices = kind.at_faces(file.stack, grid.frequency, **{along: directions}, **touching)
    columns = matrices.reshape(*matrices.shape[:2], len(kind.units))
    values = {entry: columns[..., i] for i, entry in enumerate(kind.units)}
    units = {entry: unit for entry, unit in kind.units.items() if unit}
    remarks = (_TIME, kind.remark, _touching(kind, wanted))
    return Exported(name, wanted.kind, grid.frequency, along, directions, values, units, remarks)


def _directions(file: SimulationFile, wanted: Wanted) -> tuple[Along, RealArray]:
    if wanted.along:
        return wanted.along, np.array(wanted.directions, dtype=float)
    if isinstance(file.incidence, DiffuseIncidence):
        text = f"{wanted.kind} belongs to a plane wave, and the incidence is diffuse; give"
        raise InputError(f"{text} --angle 0,30,60 or --trace-wavenumber 0,5,10")
    return "angle", np.array([file.incidence.angle])


def _touching(kind: Kind, wanted: Wanted) -> str:
    words = {"fluid": "a fluid", "plate": "a plate that is glued on and moves along the normal alone"}
    if not kind.has_back:
        return f"what touches the front face: {words[wanted.front]}"
    return f"what touches the front face: {words[wanted.front]}; the back face: {words[wanted.back]}"


def _levels(file: SimulationFile, grid: Grid, kind: Kind, wanted: Wanted, name: str) -> Exported:
    if wanted.along == "trace_wavenumber":
        raise InputError(f"{wanted.kind} belongs to waves that come through the gas; give --angle")
    if (wanted.front, wanted.back) != ("fluid", "fluid"):
        raise InputError(f"{wanted.kind} belongs to a stack in the gas; leave out --front and --back")
    if "transmission_loss" in kind.levels and not file.lets_through:
        text = f"{wanted.kind} needs a half-space behind the stack; write 'termination: ambient'"
        raise InputError(text)
    waves = [PlaneIncidence(angle=angle) for angle in wanted.directions]
    if isinstance(file.incidence, PlaneIncidence):
        waves = waves or [file.incidence]
    incidences: Sequence[PlaneIncidence | DiffuseIncidence] = waves or [file.incidence]
    task = Task(file.stack, grid.points, file.incidence, "", file.finite_size, file.reference)
    outcomes = []
    for incidence in incidences:
        each = replace(task, incidence=incidence)
        outcome = run_task(each)
        refuse_unsound(each, outcome, grid.frequency)
        outcomes.append(outcome)
    for text in dict.fromkeys(text for outcome in outcomes for text in outcome.warnings):
        warn(text, ValidityWarning, stacklevel=3)
    names = [level for level in kind.levels if level in outcomes[0].quantities]
    values = {level: np.stack([outcome.quantities[level] for outcome in outcomes], axis=-1) for level in names}
    units = {level: "dB" for level in names if level != "absorption"}
    along: Along | Literal[""] = "angle" if waves else ""
    directions, field_text = np.array([wave.angle for wave in waves] or [np.nan]), "plane waves"
    if not waves and isinstance(file.incidence, DiffuseIncidence):
        asked = file.incidence.diffuse
        field_text = f"diffuse field up to {asked.max_angle:g} degrees, {asked.weighting} weighting"
    size = file.finite_size
    across = "infinite" if size is None else f"{size.width:g} m x {size.height:g} m"
    frequencies = "single frequencies" if grid.bands is None else f"averages over {grid.bands}"
    remarks = (kind.remark, f"{field_text}; panel: {across}; {frequencies}")
    return Exported(name, wanted.kind, grid.frequency, along, directions, values, units, remarks)
