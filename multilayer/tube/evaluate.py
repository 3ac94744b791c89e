"""From a tube file to reflection, impedance, absorption and transmission loss."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from warnings import warn

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import BoolArray, ComplexArray, RealArray
from multilayer.csv_table import csv_table
from multilayer.errors import InputError, PlausibilityWarning, Problem
from multilayer.signals.impedance_tube import (
    FaceState,
    Range,
    TransferMatrix,
    cut_off,
    face_state,
    iso_attenuation,
    kirchhoff_attenuation,
    matrix_transmission,
    normalised_impedance,
    one_load_matrix,
    reflection_coefficient,
    rigid_backed_reflection,
    spacing_range,
    switched_calibration,
    two_load_matrix,
)
from multilayer.simulation.quantities import columns_of
from multilayer.tube.data import Transfer, read_transfer, refuse_other_frequencies, refuse_unlike_units
from multilayer.tube.file import FILE_NAME, FourMicrophones, TubeFile, TwoMicrophones, load_tube, tube_file

_MOST_POWER = 1.2  # of the arriving power, at half of the frequencies, that noise makes of a rigid sample
_VARIES = 0.2  # Np or rad: the squared difference of two microphones of one kind varies less
_ALIKE, _SAME = 0.05, 1e-9  # of two loads, 0 where they are the same: errors grow by its inverse
Spectra = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class TubeResult:
    """Evaluated measurements of a tube.

    Attributes
    ----------
    name : str
    frequency : array, shape (n,)
        Hz.
    working_range : Range
        Hz.
    n_outside : int
        Number of frequencies, measured and wanted, outside of the working range: left out, or kept if the file says so.
    spectra : mapping
        Quantities as in `simulation.quantities`, by name of the CSV file that takes them: ``tube`` (the sample in front
        of the tube's end, or with gas on both sides), ``rigid_backed`` (of four microphones: before a wall that the
        sample does not touch, the gas between them at rest).
    matrix : TransferMatrix or None
        Of four microphones.
    coherence : array, shape (n,) or None
        Of signals over time, averaged over eight segments or more.
    """

    name: str
    frequency: RealArray
    working_range: Range
    n_outside: int
    spectra: Mapping[str, Spectra]
    matrix: TransferMatrix | None = None
    coherence: RealArray | None = None

    @property
    def in_range(self) -> BoolArray:
        """Which frequencies lie in the working range."""
        return (self.frequency >= self.working_range.low) & (self.frequency <= self.working_range.high)

    def tables(self) -> dict[str, str]:
        """Return CSV files by name, which `compare`, `fit`, `diagnose` and `explore --measured` take as measured."""
        head = {"frequency_hz": self.frequency, "in_range": self.in_range}
        more = {} if self.coherence is None else {"coherence": self.coherence}
        files = {f"{name}.csv": _csv({**head, **columns_of(dict(s)), **more}) for name, s in self.spectra.items()}
        if self.matrix is not None:
            parts = {f"{n}_{p}": getattr(v, q) for n, v in self.matrix._asdict().items() for p, q in _PARTS.items()}
            files["transfer_matrix.csv"] = _csv({**head, **parts})
        return files

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: the columns of the tables."""
        return {
            "version": 1,
            "name": self.name,
            "working_range_hz": list(self.working_range),
            "frequencies_outside": self.n_outside,
            "frequency_hz": self.frequency.tolist(),
            "in_range": self.in_range.tolist(),
            "coherence": None if self.coherence is None else self.coherence.tolist(),
            "spectra": {
                name: {column: values.tolist() for column, values in columns_of(dict(spectra)).items()}
                for name, spectra in self.spectra.items()
            },
        }


_PARTS = {"re": "real", "im": "imag"}


def _csv(columns: Mapping[str, NDArray[Any]]) -> str:
    return csv_table(list(columns), zip(*(column.tolist() for column in columns.values()), strict=True))


@np.errstate(all="ignore")  # what is no number is refused, whatever made it so
def evaluate(source: Path) -> TubeResult:
    """Evaluate the measurements of a tube file.

    Parameters
    ----------
    source : Path
        The file, or a folder with a ``tube.yaml``; its data are relative to it.

    Raises
    ------
    InputError
        With every mistake of the file; when data cannot be read, do not fit together, or lie outside of the working
        range altogether.
    """
    path = tube_file(source)
    file = load_tube(path)
    result = _two_microphones(file, path) if isinstance(file, TwoMicrophones) else _four_microphones(file, path)
    _refuse_no_numbers(result, path)
    _warn_of_power(result, path)
    return result


def _refuse_no_numbers(result: TubeResult, path: Path) -> None:
    """Refuse coefficients that are no finite numbers; an impedance and a loss may be infinite."""
    for spectra in result.spectra.values():
        for name in ("reflection", "transmission"):
            wrong = ~np.isfinite(spectra[name]) if name in spectra else np.zeros(1, dtype=bool)
            if wrong.any():
                text = f"the {name} coefficient at {result.frequency[wrong][0]:.6g} Hz is no number: pressures of 0 or "
                text += "of equal size, or lengths far from any tube; correct the data, or narrow 'from' and 'to'"
                raise InputError(Problem(text, file=path))


def _warn_of_power(result: TubeResult, path: Path) -> None:
    """Warn of a sample that gives back more power than arrives, at most frequencies: noise makes that at some."""
    tube = result.spectra["tube"]
    power = np.abs(tube["reflection"]) ** 2 + np.abs(tube.get("transmission", 0.0)) ** 2
    gives = power > _MOST_POWER
    if np.mean(gives) > 0.5:
        text = f"at {np.sum(gives)} of {len(gives)} frequencies, as at {result.frequency[gives][0]:.6g} Hz, the sample "
        text += "gives back more power than arrives: are microphones exchanged, or positions those of another setup?"
        warn(str(Problem(text, file=path)), PlausibilityWarning, stacklevel=3)


def name_of(source: Path) -> str:
    """Return the name of a measurement: that of its file, or of the folder of a ``tube.yaml``."""
    file = tube_file(source).resolve()
    return file.parent.name if file.name == FILE_NAME else file.stem


def wavenumber(file: TubeFile, frequency: RealArray) -> ComplexArray:
    """Return the wavenumber along the tube, rad/m, with the attenuation that the file states."""
    gas, diameter = file.ambient.gas, file.tube.hydraulic_diameter
    loss = np.zeros(len(frequency))
    if file.tube.attenuation == "iso":
        loss = iso_attenuation(frequency, gas.sound_speed, diameter)
    elif file.tube.attenuation == "kirchhoff":
        loss = kirchhoff_attenuation(frequency, gas, diameter)
    return np.asarray(2 * np.pi * frequency / gas.sound_speed - 1j * loss)


def _working_range(file: TubeFile, spacings: tuple[float, ...], *, e2611: bool) -> Range:
    c = file.ambient.gas.sound_speed
    ranges = [spacing_range(c, spacing, e2611=e2611) for spacing in spacings]
    plane = cut_off(c, file.tube.widest, rectangular=file.tube.diameter is None)
    return Range(max(working.low for working in ranges), min(plane, *(working.high for working in ranges)))


def _kept(file: TubeFile, path: Path, frequency: RealArray, working: Range) -> tuple[BoolArray, int]:
    """Return which frequencies are evaluated, and how many of the wanted ones lie outside of the working range."""
    wanted = (frequency >= (file.start or 0.0)) & (frequency <= (file.to or np.inf))
    inside = (frequency >= working.low) & (frequency <= working.high)
    kept = wanted if file.keep_outside else wanted & inside
    if not kept.any():
        band = f"{working.low:.4g} to {working.high:.4g} Hz"
        measured = f"there are frequencies from {frequency.min():.4g} to {frequency.max():.4g} Hz"
        bounds = {"from": file.start, "to": file.to}
        asked = " ".join(f"'{name}' {value:.4g} Hz" for name, value in bounds.items() if value is not None)
        message = f"no frequency is left to evaluate: {measured}, {f'wanted are those {asked}, ' if asked else ''}"
        check = "'from' and 'to', spacing and diameter" if asked else "spacing and diameter"
        message += f"and this tube works from {band}; check {check}"
        raise InputError(Problem(message, file=path))
    return kept, int(np.sum(wanted & ~inside))


def _two_microphones(file: TwoMicrophones, path: Path) -> TubeResult:
    data = read_transfer(file.measurement, path.parent, 2)
    h12, switched = _ratio(data), _switched(file, path, data)
    working = _working_range(file, (file.spacing,), e2611=False)
    kept, n_outside = _kept(file, path, data.frequency, working)
    if switched is not None:
        h12 = h12 / switched_calibration(*switched)
        _warn_of_order(file, path, *(ratio[kept] for ratio in switched))
    frequency = data.frequency[kept]
    far = file.distance + file.spacing
    reflection = reflection_coefficient(h12[kept], wavenumber(file, frequency), file.spacing, far)
    coherence = None if data.coherence is None else data.coherence[kept]
    return TubeResult(
        name_of(path), frequency, working, n_outside, {"tube": _of_reflection(reflection)}, None, coherence
    )


def _of_reflection(reflection: ComplexArray) -> Spectra:
    return {
        "absorption": 1 - np.abs(reflection) ** 2,
        "normalised_impedance": normalised_impedance(reflection),
        "reflection": reflection,
    }


def _ratio(data: Transfer) -> ComplexArray:
    return np.asarray(data.functions[1] / data.functions[0])


def _switched(file: TwoMicrophones, path: Path, data: Transfer) -> tuple[ComplexArray, ComplexArray] | None:
    """Return the transfer functions before and after the microphones changed places; None where they did not."""
    if file.exchanged is None and file.calibration is None:
        refuse_unlike_units(data, (), "'exchanged' or 'calibration'")
        return None
    pair = file.calibration
    straight = data if pair is None else read_transfer(pair.straight, path.parent, 2)
    source = file.exchanged if pair is None else pair.exchanged
    assert source is not None
    exchanged = read_transfer(source, path.parent, 2)
    for other in (straight, exchanged):
        refuse_other_frequencies(data, other)
    refuse_unlike_units(data, (straight, exchanged), "'exchanged' or 'calibration'")
    return _ratio(straight), _ratio(exchanged)


def _warn_of_order(file: TwoMicrophones, path: Path, straight: ComplexArray, exchanged: ComplexArray) -> None:
    """Warn of an exchanged measurement that looks like channel 1 over channel 2.

    The square of the correction, the product, then is that of H12, and the quotient that of the correction: two
    microphones hardly vary over frequency, and the field between them does.
    """
    varies = _variation(straight * exchanged)
    if varies > max(_VARIES, _variation(straight / exchanged)):
        which = "exchanged" if file.calibration is None else "calibration.exchanged"
        text = f"'{which}' looks like channel 1 over channel 2: what the microphones differ by varies more over "
        text += (
            "frequency than the field does; it needs the same channels in the same order as before they changed places"
        )
        warn(str(Problem(text, file=path)), PlausibilityWarning, stacklevel=4)


def _variation(ratio: ComplexArray) -> float:
    """Return how much a ratio varies over frequency, Np and rad."""
    ratio = ratio[np.isfinite(ratio) & (ratio != 0)]
    return float(np.std(np.log(np.abs(ratio)) + 1j * np.unwrap(np.angle(ratio)))) if ratio.size else 0.0


def _four_microphones(file: FourMicrophones, path: Path) -> TubeResult:
    loads = [read_transfer(source, path.parent, 4) for source in file.loads]
    correction = None if file.calibration is None else read_transfer(file.calibration, path.parent, 4)
    for other in [*loads[1:], *([] if correction is None else [correction])]:
        refuse_other_frequencies(loads[0], other)
    for load in loads:
        refuse_unlike_units(load, [] if correction is None else [correction], "a 'calibration'")
    a, b, c, d = file.positions
    working = _working_range(file, (b - a, d - c), e2611=True)
    kept, n_outside = _kept(file, path, loads[0].frequency, working)
    frequency, impedance = loads[0].frequency[kept], file.ambient.gas.impedance
    k = wavenumber(file, frequency)
    gains = 1.0 if correction is None else correction.functions[:, kept]
    states = [
        face_state(tuple(load.functions[:, kept] / gains), file.positions, k, impedance, file.thickness)
        for load in loads
    ]
    if len(states) == 2:
        _judge_loads(file, path, frequency, states[0], states[1])
    matrix = one_load_matrix(states[0]) if len(states) == 1 else two_load_matrix(states[0], states[1])
    known = [load.coherence[kept] for load in loads if load.coherence is not None]
    coherence = np.min(known, axis=0) if known else None
    spectra = {
        "tube": _of_matrix(matrix, impedance),
        "rigid_backed": _of_reflection(rigid_backed_reflection(matrix, impedance)),
    }
    return TubeResult(name_of(path), frequency, working, n_outside, spectra, matrix, coherence)


def _judge_loads(file: FourMicrophones, path: Path, frequency: RealArray, a: FaceState, b: FaceState) -> None:
    """Refuse two loads behind which the sample moves alike at most frequencies, and warn of nearly such."""
    differences = np.abs(a.p_back * b.v_back - b.p_back * a.v_back)
    share = differences / (np.abs(a.p_back * b.v_back) + np.abs(b.p_back * a.v_back))
    alike = share < _ALIKE
    if np.mean(alike) <= 0.5:
        return
    two = f"the two loads, {' and '.join(str(load.file or load.recording) for load in file.loads)}, are"
    remedy = "two terminations are needed that differ, as open and closed"
    if np.mean(share < _SAME) > 0.5:
        raise InputError(Problem(f"{two} the same: {remedy}; name two measurements", "loads", path))
    text = f"{two} nearly alike: at {np.sum(alike)} of {len(alike)} frequencies, as at {frequency[alike][0]:.6g} Hz, "
    text += f"they differ by less than {100 * _ALIKE:g} %, and errors of the data grow more than {1 / _ALIKE:g}-fold"
    warn(str(Problem(f"{text}; {remedy}", "loads", path)), PlausibilityWarning, stacklevel=4)


def _of_matrix(matrix: TransferMatrix, impedance: float) -> Spectra:
    transmission, reflection = matrix_transmission(matrix, impedance)
    loss = -20 * np.log10(np.abs(transmission))
    return {**_of_reflection(reflection), "transmission_loss": loss, "transmission": transmission}
