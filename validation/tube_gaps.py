"""Tube measurements whose cause of disagreement is known, or not, as files of a diagnosis."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.rear_air_gap import RearAirGap
from multilayer.diagnosis.file import DiagnosisFile, diagnosis_file
from multilayer.diagnosis.fitting import fit
from multilayer.diagnosis.nominal import nominal_minimum
from multilayer.diagnosis.result import Diagnosis
from multilayer.diagnosis.tube.diagnose import diagnose_tube
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.inference.problem import GaussianPrior
from multilayer.media.gas import dry_air
from multilayer.media.porous import champoux_allard_modulus
from validation.tube_fits import MEASURED, PORES, SAMPLES, Sample, published, stack

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
Series = Mapping[str, float]
DELFT = {"frequency": "f_hz", "real": "re_zs_over_z0", "imag": "im_zs_over_z0"}


def sample(thickness: float, values: Mapping[str, float] = GUESS) -> dict[str, Any]:
    """Return a rigid-frame sample before a rigid wall, thickness in m."""
    return stack({"type": "equivalent_fluid", "name": "sample", "thickness": thickness, **values})


def delft(table: str, series: Series, priors: Mapping[str, Any], error: float) -> DiagnosisFile:
    """Return series of TU Delft, by name with their thicknesses in m, with a rigid-frame sample as nominal model.

    Several are one material in several thicknesses. No noise is said.
    """
    stacks = {f"mm{1e3 * thickness:g}".replace(".", "_"): sample(thickness) for thickness in series.values()}
    measurement = {
        "kind": "surface_impedance", "normalised": True, "file": f"tudelft_{table}.csv", "columns": DELFT,
        "from": LOWEST,
    }  # fmt: skip
    return diagnosis_file(
        MEASURED,
        stacks=stacks,
        measurements=[
            {**measurement, "name": name, "rows": {"series": name}, "stack": stack}
            for name, stack in zip(series, stacks, strict=True)
        ],
        unknowns={f"layers.sample.{name}": prior for name, prior in priors.items()},
        tube={"error": error},
        search=SEARCH,
    )


def rms(hypothesis: StackProblem, z: RealArray) -> float:
    """Return the root mean square of the difference in the reflection coefficient."""
    return float(np.sqrt(np.mean(np.abs(np.concatenate(hypothesis.differences(z))) ** 2)))


@dataclass(frozen=True)
class Sure:
    """A sample as a series without the effect has it: that series' file, what it says, how well the model does there.

    Attributes
    ----------
    file : DiagnosisFile
    z : array
        Most probable coordinates.
    error : float
        Root mean square of what that fit leaves of each part of R.
    misfit : float
        rms of R.
    """

    file: DiagnosisFile
    z: RealArray
    error: float
    misfit: float


def sure_from(table: str, series: Series, priors: Mapping[str, Any]) -> Sure:
    """Return what series without the effect say; what the model leaves there is its error from now on."""
    coarse = delft(table, series, priors, COARSE)
    error = rms(coarse.hypothesis, nominal_minimum(coarse).z) / float(np.sqrt(2))
    file = delft(table, series, priors, error)
    z = nominal_minimum(file).z
    return Sure(file, z, error, rms(file.hypothesis, z))


@dataclass(frozen=True)
class Case:
    """A diagnosis and its misfits of R: foretold by the sample as known, nominal fit, best hypothesis."""

    name: str
    diagnosis: Diagnosis
    foretold: float
    nominal: float
    after: float
    file: DiagnosisFile
    sure: Sure | None

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


def diagnose(name: str, file: DiagnosisFile, sure: Sure | None = None) -> Case:
    """Return the diagnosis of a file, of a sample that is known if `sure` says so."""
    found = diagnose_tube(file if sure is None else file.with_reference(sure.file), name)
    hypothesis = file.hypothesis
    before, after = (
        float(np.sqrt(np.mean([np.mean(a**2 + b**2) for a, b in parts])))
        for parts in (
            [(c.level_before, c.phase_before) for c in found.curves],
            [(c.level_after, c.phase_after) for c in found.curves],
        )
    )
    return Case(name, found, rms(hypothesis, hypothesis.start if sure is None else sure.z), before, after, file, sure)


def depth_with_correlations(case: Case) -> tuple[float, float, float]:
    """Return depth and interval, m, of a rear air gap where the sample's joint posterior is the prior."""
    assert case.sure is not None
    known = GaussianPrior.of(nominal_minimum(case.sure.file), correlated=True)
    hypothesis = replace(case.file.hypothesis, earlier=known)
    return fit(hypothesis.with_effects(RearAirGap()), hypothesis.start).interval("rear_air_gap.depth")


def plants(name: str, thickness: float) -> tuple[Sure, list[Case]]:
    """Return a plant as known from the series on the wall, and the diagnoses of those before a cavity."""
    sure = sure_from("plants", {name: thickness}, WIDE)
    series = [f"{name} + cavity {cm} cm" for cm in range(1, 6)]
    return sure, [diagnose(one, delft("plants", {one: thickness}, WIDE, sure.error), sure) for one in series]


def fleece(*cm: str) -> Case:
    """Return the diagnosis of mineral wool with a fleece in front, the wool being known from the bare series."""
    bare, covered = ({f"Mineral wool {what}{one} cm": float(one) / 100 for one in cm} for what in ("", "+ fleece "))
    sure = sure_from("mineral_wool", bare, WOOL)
    return diagnose("; ".join(covered), delft("mineral_wool", covered, WOOL, sure.error), sure)


def bare_wool(*cm: str) -> Case:
    """Return the diagnosis of the bare wool: nothing is known of it, the tube is taken for good to 0.01 of R."""
    series = {f"Mineral wool {one} cm": float(one) / 100 for one in cm}
    return diagnose("; ".join(series), delft("mineral_wool", series, WOOL, 0.01))


def limp() -> Case:
    """Return the diagnosis of the limp curve of Panneton (2007), a rigid frame of his parameters being nominal.

    The file's curves are effective densities over that of air; the limp one becomes the impedance of 50 mm before a
    wall with the bulk modulus of his parameters.
    """
    values = {
        "porosity": 0.98, "flow_resistivity": 25e3, "tortuosity": 1.02, "viscous_length": 9e-5,
        "thermal_length": 1.8e-4,
    }  # fmt: skip
    with (MEASURED / "panneton2007_rigid_limp.csv").open() as file:
        rows = np.array([[float(row[i]) for i in (0, 3, 4)] for row in list(csv.reader(file))[1:]])
    frequency, gas = rows[:, 0], dry_air()
    density = (rows[:, 1] + 1j * rows[:, 2]) * gas.density
    thermal = {name: values[name] for name in ("porosity", "thermal_length")}
    bulk = champoux_allard_modulus(2 * np.pi * frequency, **thermal, gas=gas)
    z = np.sqrt(density * bulk) / np.tan(2 * np.pi * frequency * np.sqrt(density / bulk) * 0.05) / (1j * gas.impedance)
    table = "\n".join(",".join(map(repr, row)) for row in np.stack([frequency, z.real, z.imag], axis=1).tolist())
    measurement = {
        "kind": "surface_impedance", "normalised": True, "file": "limp.csv", "name": "limp",
        "columns": {"frequency": "f [Hz]", "real": "re", "imag": "im"}, "from": 40,
    }  # fmt: skip
    with TemporaryDirectory() as folder:
        Path(folder, "limp.csv").write_text(f"f,re,im\n{table}\n")
        file = diagnosis_file(
            Path(folder),
            nominal=sample(0.05, values),
            measurements=[measurement],
            unknowns=near(values),
            tube={"error": 0.005},  # of R: curves are no measurement
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


__all__ = [
    "SAMPLES",
    "Case",
    "Sure",
    "atalla_panneton",
    "bare_wool",
    "depth_with_correlations",
    "fleece",
    "limp",
    "plants",
]
