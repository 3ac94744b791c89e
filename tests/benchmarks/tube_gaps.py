"""Tube measurements whose cause of disagreement is known, or not, as files of a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.result import Diagnosis
from multilayer.diagnosis.tube.diagnose import diagnose_tube
from multilayer.diagnosis.tube.file import DiagnosisFile, diagnosis_file
from multilayer.diagnosis.tube.hypothesis import TubeHypothesis
from multilayer.inverse.least_squares import search
from tests.benchmarks.tube_fits import MEASURED, PORES, SAMPLES, Sample, published, stack

LOWEST = 200.0  # Hz, of the two-microphone tube
COARSE = 0.05  # error of R with which a nominal series is fitted first
SEARCH = {"starts": 4, "candidates": 64}
WIDE: dict[str, Any] = {
    "flow_resistivity": {"loguniform": [300, 3e5]},
    "porosity": {"uniform": [0.3, 0.999]},
    "tortuosity": {"uniform": [1.0, 5.0]},
    "viscous_length": {"lognormal": ["100 um", 1.0]},
    "thermal_length": {"lognormal": ["300 um", 1.0]},
}
WOOL: dict[str, Any] = {
    **WIDE,
    "porosity": {"uniform": [0.9, 0.999]},
    "tortuosity": {"uniform": [1.0, 1.3]},
}
GUESS = {
    "porosity": 0.9, "flow_resistivity": 1e4, "tortuosity": 1.2, "viscous_length": 1e-4, "thermal_length": 3e-4,
}  # fmt: skip
DELFT = {"frequency": "f_hz", "real": "re_zs_over_z0", "imag": "im_zs_over_z0"}
LIMITS = {"porosity": [0.2, 0.9999], "tortuosity": [1.0, 6.0]}


def sample(thickness: float, values: Mapping[str, float] = GUESS) -> dict[str, Any]:
    """Return a rigid-frame sample before a rigid wall, thickness in m."""
    return stack({"type": "equivalent_fluid", "name": "sample", "thickness": thickness, **values})


def delft(table: str, series: str, thickness: float, priors: Mapping[str, Any], error: float) -> DiagnosisFile:
    """Return a series of TU Delft with a rigid-frame sample as nominal model; no noise is said."""
    measurement = {
        "kind": "surface_impedance", "normalised": True, "file": f"tudelft_{table}.csv", "name": series,
        "rows": {"series": series}, "columns": DELFT, "from": LOWEST,
    }  # fmt: skip
    return diagnosis_file(
        MEASURED,
        nominal=sample(thickness),
        measurements=[measurement],
        unknowns={f"layers.sample.{name}": prior for name, prior in priors.items()},
        tube={"error": error},
        search=SEARCH,
    )


def nominal_fit(file: DiagnosisFile) -> Fitted:
    """Return the fit of the nominal model alone."""
    hypothesis, hard = file.hypothesis, file.search
    minima = search(hypothesis, [hypothesis.start], n_best=hard.starts, n_candidates=hard.candidates, seed=hard.seed)
    return Fitted(hypothesis, minima[0])


def rms(hypothesis: TubeHypothesis, z: RealArray) -> float:
    """Return the root mean square of the difference in the reflection coefficient."""
    return float(np.sqrt(np.mean(np.abs(np.concatenate(hypothesis.log_ratios(z))) ** 2)))


def as_priors(fitted: Fitted) -> dict[str, Any]:
    """Return the posterior of each parameter as a prior; correlations are lost, which makes them wider together."""
    found: dict[str, Any] = {}
    for parameter, z, spread in zip(
        fitted.hypothesis.parameters, fitted.minimum.z, np.sqrt(np.diag(fitted.minimum.covariance)), strict=True
    ):
        name = parameter.name.rpartition(".")[2]
        low, value, high = (float(parameter.prior.value(z + step * spread)) for step in (-1, 0, 1))
        if name in LIMITS:
            found[name] = {"normal": [value, (high - low) / 2], "bounds": LIMITS[name]}
        else:
            found[name] = {"lognormal": [value, float(np.log(high / low)) / 2]}
    return found


@dataclass(frozen=True)
class Known:
    """A sample known from a series: priors of its parameters, their best values, and how well the model does there."""

    priors: dict[str, Any]
    values: dict[str, float]
    error: float  # standard deviation of each part of R
    misfit: float  # rms of R


def known_from(table: str, series: str, thickness: float, priors: Mapping[str, Any]) -> Known:
    """Return what a series without the effect says; what the model leaves there is its error from now on."""
    coarse = nominal_fit(delft(table, series, thickness, priors, COARSE))
    assert isinstance(coarse.hypothesis, TubeHypothesis)
    error = rms(coarse.hypothesis, coarse.minimum.z) / float(np.sqrt(2))
    fine = nominal_fit(delft(table, series, thickness, priors, error))
    assert isinstance(fine.hypothesis, TubeHypothesis)
    names = [p.name.rpartition(".")[2] for p in fine.hypothesis.parameters]
    found = [float(p.prior.value(z)) for p, z in zip(fine.hypothesis.parameters, fine.minimum.z, strict=True)]
    misfit = rms(fine.hypothesis, fine.minimum.z)
    return Known(as_priors(fine), dict(zip(names, found, strict=True)), error, misfit)


@dataclass(frozen=True)
class Case:
    """A diagnosis and its misfits of R: foretold by the sample as known, nominal fit, best hypothesis."""

    name: str
    diagnosis: Diagnosis
    foretold: float
    nominal: float
    after: float

    @property
    def record(self) -> dict[str, Any]:
        """What ``diagnosis.json`` holds."""
        return self.diagnosis.record

    @property
    def first(self) -> tuple[str, ...]:
        """The most probable cause of all, the nominal model and something unknown included."""
        return tuple(self.record["causes"][0]["effects"]) if self.record["causes"] else ()

    def cause(self, *effects: str) -> dict[str, Any] | None:
        """Return the entry of a cause, if it is listed."""
        return next((one for one in self.record["causes"] if one["effects"] == list(effects)), None)


def diagnose(name: str, file: DiagnosisFile, values: Mapping[str, float] | None = None) -> Case:
    """Return the diagnosis of a file; `values` are those of the sample as known."""
    found = diagnose_tube(file, name)
    hypothesis = file.hypothesis
    z = hypothesis.start
    if values is not None:
        own = [p.prior.coordinate(values[p.name.rpartition(".")[2]]) for p in hypothesis.parameters]
        z = np.array([float(one) for one in own])
    before, after = (
        float(np.sqrt(np.mean([np.mean(a**2 + b**2) for a, b in parts])))
        for parts in (
            [(c.level_before, c.phase_before) for c in found.curves],
            [(c.level_after, c.phase_after) for c in found.curves],
        )
    )
    return Case(name, found, rms(hypothesis, z), before, after)


def plants(name: str, thickness: float) -> tuple[Known, list[Case]]:
    """Return a plant as known from the series on the wall, and the diagnoses of those before a cavity."""
    known = known_from("plants", name, thickness, WIDE)
    cases = []
    for cm in range(1, 6):
        series = f"{name} + cavity {cm} cm"
        cases.append(diagnose(series, delft("plants", series, thickness, known.priors, known.error), known.values))
    return known, cases


def fleece(cm: str) -> tuple[Known, Case]:
    """Return mineral wool as known from the bare series, and the diagnosis of that with a fleece in front."""
    thickness = float(cm) / 100
    known = known_from("mineral_wool", f"Mineral wool {cm} cm", thickness, WOOL)
    series = f"Mineral wool + fleece {cm} cm"
    file = delft("mineral_wool", series, thickness, known.priors, known.error)
    return known, diagnose(series, file, known.values)


def bare_wool(cm: str) -> Case:
    """Return the diagnosis of the bare wool: nothing is known of it, the tube is taken for good to 0.01 of R."""
    series = f"Mineral wool {cm} cm"
    return diagnose(series, delft("mineral_wool", series, float(cm) / 100, WOOL, 0.01))


def limp() -> Case:
    """Return the diagnosis of the limp curves of Panneton (2007), a rigid frame of his parameters being nominal."""
    values = {
        "porosity": 0.98, "flow_resistivity": 25e3, "tortuosity": 1.02, "viscous_length": 9e-5,
        "thermal_length": 1.8e-4,
    }  # fmt: skip
    measurement = {
        "kind": "surface_impedance", "normalised": True, "file": "panneton2007_rigid_limp.csv", "name": "limp",
        "columns": {"frequency": "f [Hz]", "real": "Re Z limp", "imag": "Im Z limp"},
        "noise": {"relative": 0.02, "absolute": 0.05}, "from": 40,
    }  # fmt: skip
    file = diagnosis_file(
        MEASURED,
        nominal=sample(0.05, values),
        measurements=[measurement],
        unknowns=near(values),
        search=SEARCH,
    )
    return diagnose("Panneton 2007, limp", file)


def near(values: Mapping[str, float]) -> dict[str, Any]:
    """Return priors about published parameters: resistivity 10 %, porosity 0.01, tortuosity 0.05, lengths 15 %."""
    spreads: dict[str, Any] = {
        "flow_resistivity": {"lognormal": [values["flow_resistivity"], 0.1]},
        "porosity": {"normal": [values["porosity"], 0.01], "bounds": [0.5, 0.9999]},
        "tortuosity": {"normal": [values["tortuosity"], 0.05], "bounds": [1.0, 5.0]},
        "viscous_length": {"lognormal": [values["viscous_length"], 0.15]},
        "thermal_length": {"lognormal": [values["thermal_length"], 0.15]},
    }
    return {f"layers.sample.{name}": prior for name, prior in spreads.items()}


def atalla_panneton(one: Sample) -> Case:
    """Return the diagnosis of both thicknesses of a material, the published parameters being nominal."""
    values = {name: value for name, value in published(one).items() if name in PORES}
    both: Sequence[tuple[str, tuple[str, float]]] = (("thin", one.thin), ("thick", one.thick))
    measurement = {
        "kind": "surface_impedance", "normalised": True, "from": 500, "noise": {"absolute": 0.03},
        "columns": {"frequency": "f [Hz]", "real": "Re", "imag": "Im"},
    }  # fmt: skip
    stacks = {}
    for name, (_, thickness) in both:
        own = {"type": "equivalent_fluid", "name": "sample", "thickness": thickness / 1e3, **values}
        stacks[name] = stack(own, one.celsius, one.bar)
    file = diagnosis_file(
        MEASURED,
        stacks=stacks,
        measurements=[
            {**measurement, "name": name, "stack": name, "file": f"ap2005_{file}.CSV"} for name, (file, _) in both
        ],
        unknowns=near(values),
        search=SEARCH,
    )
    return diagnose(f"AP2005 {one.name}", file)


__all__ = ["SAMPLES", "Case", "Known", "atalla_panneton", "bare_wool", "fleece", "limp", "plants"]
