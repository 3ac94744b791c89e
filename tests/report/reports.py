"""A report of every kind: made-up fits of campaigns, and quick fits and simulations of examples."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from multilayer.experiments.stacks.file import load_stack_fit
from multilayer.fits.joint.fit import fit_joint
from multilayer.fits.joint.posterior import with_posterior
from multilayer.fits.result import BurstFit, FitResult, Solution
from multilayer.fits.settings import FitSettings
from multilayer.fits.sources import read_fit
from multilayer.fits.stacks.fit import fit_stacks
from multilayer.inference.summary import LAPLACE
from multilayer.measurements.description import Campaign
from multilayer.report.diagnosis import diagnosis_report
from multilayer.report.fit import burst_report
from multilayer.report.joint import joint_report
from multilayer.report.simulation import comparison_report, simulation_report
from multilayer.report.stack_fit import stack_fit_report
from multilayer.simulation.compare import compare
from multilayer.simulation.file import SimulationFile, load_simulation
from multilayer.simulation.measured import Measured
from multilayer.simulation.run import plan, run
from tests.fits.synthetic import campaign_dict
from tests.report.diagnoses import diagnosis

EXAMPLES = Path(__file__).parents[2] / "examples"
BURSTS = tuple(float(f) for f in range(100, 1600, 100))
HOSTILE = ('<script>alert("1")</script>', "a & b <b>", "$E_1$", "_100 %", 'x" onload="y', "H" * 60, "泡沫 %s")
WHY_NOT = "level and time of flight cannot be met at once: 0.71 dB, 21 us at the optimum"


def burst(configuration, frequency, *, accepted=True):
    e1 = 1.7e5 * (frequency / 100) ** 0.22
    t = np.linspace(0, 0.1, 50)
    return BurstFit(
        configuration, frequency, e1, 0.01 * e1, 0.4 * e1, 0.02 * e1, 0.4, 0.009, 1e-7, -0.002, accepted,
        reason="" if accepted else WHY_NOT, solution=Solution(e1, 0.4 * e1, 0.012),
        alternatives=[Solution(2 * e1, 0.1 * e1, 0.03)] if frequency == 300 else [],
        history=np.array([[1e5, 4e4, 1.0], [e1, 0.4 * e1, 0.1]]),
        measured_transmissibility=200 / frequency * np.exp(-2j), time=t,
        measured_envelope=np.sin(40 * t) ** 2, modelled_envelope=np.sin(40 * t) ** 2,
    )  # fmt: skip


def fit(*names, rejected=()):
    """Return a fit of all bursts in configurations of some names, and the campaign."""
    data = campaign_dict(frequencies_hz=BURSTS)
    data["configurations"] = [{**data["configurations"][0], "name": name} for name in names]
    bursts = [burst(name, f, accepted=f not in rejected) for name in names for f in BURSTS]
    settings = {"version": 1, "method": "least-squares", "bounds": {"storage_modulus": [1e3, 1e9]}}
    return FitResult(names[0], "least-squares", settings, bursts), Campaign.model_validate(data)


def fitted(*names, rejected=()):
    result, campaign = fit(*names, rejected=rejected)
    static = {"storage_modulus": "120 kPa", "loss_modulus": "28 kPa"}
    return burst_report(result, campaign, FitSettings(quasi_static=static), {"sha256": "0" * 64})


@cache
def joint():
    job = read_fit(EXAMPLES / "foam_b")
    return with_posterior(fit_joint(job.campaign, job.recordings, settings=job.settings), LAPLACE)


@cache
def stack_fit():
    return fit_stacks(load_stack_fit(EXAMPLES / "foam_tube"), "foam_tube")


def simulated(**changes):
    file = load_simulation(EXAMPLES / "foam_absorption.yaml").to_dict()
    return run(plan(SimulationFile.model_validate({**file, "samples": 20, **changes}), "foam"))


def many_cases():
    thicknesses = [0.002 * n for n in range(1, 41)]
    return simulated(sweep={"layers.foam.thickness": thicknesses}, tolerances={}, frequency={"octaves": [125, 4000]})


def compared():
    f = np.array([200.0, 500.0, 1000.0, 2000.0])
    measured = Measured("<i>tube</i>", f, {"absorption": np.array([0.12, 0.41, 0.85, 0.93])})
    return compare(measured, simulated(frequency=f.tolist()))


REPORTS = {
    "fit": lambda: fitted("foam"),
    "fit, many bursts": lambda: fitted(*HOSTILE, rejected=(100.0, 200.0)),
    "fit, none accepted": lambda: fitted("foam", rejected=BURSTS),
    "joint": lambda: joint_report(joint(), {"sha256": "0" * 64}),
    "stack fit": lambda: stack_fit_report(stack_fit()),
    "simulation": lambda: simulation_report(simulated()),
    "simulation, many cases": lambda: simulation_report(many_cases()),
    "transmission": lambda: simulation_report(run(plan(load_simulation(EXAMPLES / "double_wall.yaml"), "double wall"))),
    "comparison": lambda: comparison_report(compared()),
    "diagnosis": lambda: diagnosis_report(diagnosis(n=12)),
}


@cache
def report(name):
    """Return a report, made once."""
    return REPORTS[name]()


@cache
def page(name):
    """Return a report as HTML, made once."""
    made = replace(report(name), figures={})
    return str(made.files()[made.page])
