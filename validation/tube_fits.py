"""Fits of impedance tubes measured elsewhere: one thickness, the other, or both."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.experiments.stacks.file import StackFitFile
from multilayer.experiments.stacks.observations import Observation
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.fits.stacks.fit import describe, find_minima, reweighed
from multilayer.fits.stacks.result import StackFitResult
from multilayer.inference.problem import Minimum
from multilayer.materials import material

MEASURED = Path(__file__).parents[1] / ".." / "shared" / "measured"
LOWEST = 500.0  # Hz
NOISE = {"absolute": 0.03}  # of Zs / Z0, one reading off a printed curve
MODEL_ERROR = {"relative": 0.03, "length": 0.3}  # of tube, mounting and model
SEARCH = {"starts": 4, "candidates": 128}
PORES = ("flow_resistivity", "porosity", "tortuosity", "viscous_length", "thermal_length")
LENGTHS = {"viscous_length": {"lognormal": ["80 um", 0.6]}, "thermal_length": {"lognormal": ["200 um", 0.6]}}
FRAMES = ("equivalent_fluid", "limp", "poroelastic")
ELASTIC = {"young_modulus": {"loguniform": ["10 kPa", "5 MPa"]}, "loss_factor": {"lognormal": [0.12, 0.5]}}


@dataclass(frozen=True)
class Sample:
    """A material of Atalla & Panneton (2005) in two thicknesses: name, files and mm of both, degC, bar, tortuosity."""

    name: str
    thin: tuple[str, float]
    thick: tuple[str, float]
    celsius: float
    bar: float
    most_tortuous: float


SAMPLES = (
    Sample("foam1", ("foam1", 49.92), ("foam1thick", 98.7), 21.5, 0.992, 2.0),
    Sample("foam2", ("foam2", 34.35), ("foam2thick", 68.77), 24.6, 0.997, 2.0),
    Sample("fibrous1", ("fibrous1", 23.37), ("fibrous1thick", 46.83), 22.6, 1.002, 1.1),
    Sample("fibrous2", ("fibrous2thick", 18.98), ("fibrous2", 37.38), 24.6, 0.977, 1.1),
)


@dataclass(frozen=True)
class Fit:
    """A problem, the best of its minima, and what that says."""

    problem: StackProblem
    best: Minimum
    result: StackFitResult


def fit(file: StackFitFile) -> Fit:
    """Return the fit of a file."""
    problem = StackProblem.of_file(file)
    problem, minima = reweighed(problem, find_minima(problem, file))
    return Fit(problem, minima[0], describe(problem, minima))


def published(sample: Sample) -> dict[str, Any]:
    """Return the published parameters."""
    return {
        name: value for name, value in material(f"AP2005/{sample.name}").items() if name in (*PORES, "frame_density")
    }


def atalla_panneton(
    sample: Sample, which: tuple[str, float], frame: str = "equivalent_fluid", *, correlated: bool = True
) -> StackFitFile:
    """Return the fit of one thickness: resistivity and porosity known to what they were measured, the rest open."""
    file, thickness = which
    given = published(sample)
    layer = {"name": "sample", "type": frame, "thickness": thickness / 1e3, **given}
    if frame == "equivalent_fluid":
        del layer["frame_density"]
    elastic = {} if frame != "poroelastic" else ELASTIC
    if elastic:
        layer |= {
            "young_modulus": 1e5,
            "poisson_ratio": 0.3 if sample.name.startswith("foam") else 0.0,
            "loss_factor": 0.1,
        }
    priors = {
        "flow_resistivity": {"lognormal": [given["flow_resistivity"], 0.1]},
        "porosity": {"normal": [given["porosity"], 0.01]},
        "tortuosity": {"uniform": [1.0, sample.most_tortuous]},
        **LENGTHS,
        **elastic,
    }
    measurement = {
        "kind": "surface_impedance", "normalised": True, "file": f"ap2005_{file}.CSV", "from": LOWEST, "noise": NOISE,
        "columns": {"frequency": "f [Hz]", "real": "Re", "imag": "Im"},
    }  # fmt: skip
    return stack_fit(
        nominal=stack(layer, sample.celsius, sample.bar),
        measurements=[measurement | ({"model_error": MODEL_ERROR} if correlated else {})],
        unknowns={f"layers.sample.{name}": prior for name, prior in priors.items()},
    )


def stack(layer: dict[str, Any], celsius: float = 20.0, bar: float = 1.01325) -> dict[str, Any]:
    """Return a sample before a rigid wall."""
    return {"ambient": {"temperature": f"{celsius} degC", "pressure": f"{bar} bar"}, "layers": [layer]}


def stack_fit(**data: Any) -> StackFitFile:
    """Return a stack-fit file made here."""
    return StackFitFile.model_validate({**data, "search": SEARCH}, context={"folder": MEASURED})


def rms(problem: StackProblem, z: RealArray, index: int = 0) -> tuple[float, float]:
    """Return the root mean square of the differences in Zs / Z0 and in the reflection coefficient."""
    return misfit_of(problem.observations[index], problem.predict(z)[index])


def misfit_of(observation: Observation, response: Any) -> tuple[float, float]:
    """Return the same of one response, a reflection coefficient."""
    z, r = observation.measured, observation.scale.of_measured(observation.measured)
    of_z, of_r = (np.abs(d) ** 2 for d in (observation.scale.shown(response) - z, response - r))
    return float(np.sqrt(np.mean(of_z))), float(np.sqrt(np.mean(of_r)))


def of_published(sample: Sample) -> float:
    """Return the misfit of the published parameters, unfitted, on the thick sample."""
    file = atalla_panneton(sample, sample.thick)
    (observation,) = file.observations
    assert file.nominal is not None
    return misfit_of(observation, observation.response(file.nominal))[0]


@dataclass(frozen=True)
class Prediction:
    """The thin sample's fit and what it says of the thick one; misfits of Zs / Z0."""

    sample: Sample
    thin: Fit
    thick: Fit
    own: float  # thin fit on the thin sample
    predicted: float  # thin fit on the thick sample
    direct: float  # thick fit on the thick sample

    @property
    def ratio(self) -> float:
        """Misfit of the prediction over that of the fit."""
        return self.predicted / self.direct


def predict(sample: Sample, *, correlated: bool) -> Prediction:
    """Fit the thin sample, predict the thick one, and fit that."""
    thin, thick = (fit(atalla_panneton(sample, which, correlated=correlated)) for which in (sample.thin, sample.thick))
    misfits = [rms(one.problem, other.best.z)[0] for one, other in ((thin, thin), (thick, thin), (thick, thick))]
    return Prediction(sample, thin, thick, *misfits)


def mineral_wool(frame: str, thicknesses: tuple[str, ...], lowest: float) -> StackFitFile:
    """Return the joint fit of the mineral wool in some thicknesses, cm."""
    layer: dict[str, Any] = {
        "name": "wool", "type": frame, "porosity": 0.97, "flow_resistivity": 2e4, "tortuosity": 1.03,
        "viscous_length": 8e-5, "thermal_length": 2e-4,
    }  # fmt: skip
    priors: dict[str, Any] = {
        "flow_resistivity": {"loguniform": [5e3, 2e5]},
        "porosity": {"uniform": [0.9, 0.995]},
        "tortuosity": {"uniform": [1.0, 1.1]},
        **LENGTHS,
    }
    if frame != "equivalent_fluid":
        layer["frame_density"], priors["frame_density"] = 60.0, {"loguniform": [20, 200]}
    if frame == "poroelastic":
        layer |= {"young_modulus": 1e5, "poisson_ratio": 0.0, "loss_factor": 0.1}
        priors |= ELASTIC
    names = {cm: f"cm{cm.replace('.', '_')}" for cm in thicknesses}
    measurement = {
        "kind": "surface_impedance", "normalised": True, "file": "tudelft_mineral_wool.csv", "from": lowest,
        "columns": {"frequency": "f_hz", "real": "re_zs_over_z0", "imag": "im_zs_over_z0"}, "noise": {"absolute": 0.02},
        "model_error": MODEL_ERROR,
    }  # fmt: skip
    return stack_fit(
        stacks={name: stack({**layer, "thickness": float(cm) / 100}) for cm, name in names.items()},
        measurements=[
            {**measurement, "stack": name, "rows": {"series": f"Mineral wool {cm} cm"}} for cm, name in names.items()
        ],
        unknowns={f"layers.wool.{name}": prior for name, prior in priors.items()},
    )
