"""Small measurements without errors, on which laws of effects are checked: a rig, a tube, walls."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.effects.levels import LevelEffect
from multilayer.diagnosis.effects.tube import TubeEffect
from multilayer.experiments.hypothesis import Hypothesis
from multilayer.experiments.levels.problem import LevelProblem
from multilayer.experiments.levels.response import LevelResponse
from multilayer.experiments.levels.sound_field import Quantity, Ridges, SoundField
from multilayer.experiments.stacks.observations import Observation, Scale
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.experiments.stacks.responses import WaveResponse
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.experiments.two_plate.plane_waves import PlaneWaveRig
from multilayer.experiments.two_plate.ratios import ConfigurationData
from multilayer.fits.joint.search import law_space
from multilayer.inference.whitening import CorrelatedError, ValueNoise
from multilayer.measurements.description import Campaign
from multilayer.response import plane_wave
from multilayer.simulation.settings import PlaneIncidence
from multilayer.stack import Stack

_FREQUENCIES = (100.0, 200.0, 400.0, 800.0, 1500.0)
_LEAD = 0.005  # of a record before its burst, s
_MODULUS = 2e5 * (1 + 0.2j)
_LAW = (2e5, 0.25, 3e-4, 0.6)  # relaxed modulus, that over the unrelaxed one, relaxation time, order


def bench(effect: BaseEffect) -> Hypothesis:
    """Return the nominal hypothesis of the kind that an effect is of; all its unknowns may be 0."""
    if isinstance(effect, TubeEffect):
        return tube_bench()
    if isinstance(effect, LevelEffect):
        return level_bench("transmission_loss" if "transmission_loss" in effect.quantities else "absorption")
    return joint_bench()


@cache
def level_bench(quantity: Quantity) -> LevelProblem:
    """Return levels of two double walls, of air and of mineral wool, or absorption of a foam; nothing is unknown."""
    board = {"type": "elastic_plate", "thickness": 0.0125, "density": 700.0, "young_modulus": 2.5e9,
             "poisson_ratio": 0.3, "loss_factor": 0.02}  # fmt: skip
    wool = {"type": "equivalent_fluid", "name": "wool", "thickness": 0.05, "model": "miki", "flow_resistivity": 8e3}
    walls = {
        "air": [board, {"type": "fluid", "thickness": 0.05}, board],
        "filled": [board, wool, board],
    }
    layers = walls if quantity == "transmission_loss" else {"thin": [wool], "thick": [wool, wool | {"name": "more"}]}
    end = "ambient" if quantity == "transmission_loss" else "rigid"
    f, n = np.array(_FREQUENCIES), len(_FREQUENCIES)
    ones, stacks = np.ones(n), {}
    data = []
    for name, of_wall in layers.items():
        stack = stacks[name] = Stack.model_validate({"version": 1, "layers": of_wall, "termination": end})
        response = LevelResponse(quantity, f[:, None], SoundField(78.0), Ridges.of(stack, float(f[2])))
        data.append(
            Observation(
                name, quantity, name, "", f, response(stack)[0], response, False, Scale(), ValueNoise(ones, ones), ones,
                CorrelatedError(1.0), n, np.arange(n), f,
            )
        )  # fmt: skip
    return LevelProblem(stacks, (), tuple(data))


@cache
def tube_bench(*, elastic: bool = False) -> StackProblem:
    """Return a foam of two thicknesses on the wall of a tube, with a rigid or an elastic frame; nothing is unknown."""
    sizes = (("thin", 0.025), ("thick", 0.05))
    stacks = {name: Stack.model_validate(_foam(thickness, elastic=elastic)) for name, thickness in sizes}
    f, n = np.array(_FREQUENCIES), len(_FREQUENCIES)
    ones = np.ones(n, dtype=complex)
    noise = ValueNoise(np.full(n, 1e-3), np.full(n, 1e-3))
    data = tuple(
        Observation(
            name, "reflection", name, "", f, plane_wave(stack, f).reflection,
            WaveResponse("reflection", f, PlaneIncidence(angle=0.0)), False, Scale(), noise, ones,
            CorrelatedError(0.01), n, np.arange(n), f,
        )
        for name, stack in stacks.items()
    )  # fmt: skip
    return StackProblem(stacks, (), data)


def _foam(thickness: float, *, elastic: bool) -> dict[str, Any]:
    foam = {
        "type": "equivalent_fluid", "name": "foam", "thickness": thickness, "porosity": 0.97, "flow_resistivity": 1e4,
        "tortuosity": 1.3, "viscous_length": 1e-4, "thermal_length": 2e-4,
    }  # fmt: skip
    frame = {
        "type": "poroelastic",
        "frame_density": 30.0,
        "young_modulus": 1e5,
        "poisson_ratio": 0.3,
        "loss_factor": 0.1,
    }
    return {"version": 1, "layers": [foam | frame if elastic else foam]}


@cache
def joint_bench() -> CampaignProblem:
    """Return a small campaign without errors, a thin and a thick configuration under two plates."""
    campaign = Campaign.model_validate(_campaign())
    f = np.array(_FREQUENCIES)
    data, rigs = [], {}
    for configuration in campaign.configurations:
        rig = PlaneWaveRig.of(campaign, configuration)
        ratio = rig.transmissibility(f, np.full(len(f), _MODULUS))
        of_bursts = np.arange(len(f))
        given = ConfigurationData(
            configuration.name, configuration.specimen_thickness, f, of_bursts, ratio, 1e-6 * np.ones(len(f)), f
        )
        stretch = np.abs(ratio - 1) * campaign.burst.level_rms / (2 * np.pi * f) ** 2
        data.append(
            replace(given, top_slopes=_slopes(f, campaign.burst.cycles), friction=4j / np.pi / stretch.astype(complex))
        )
        rigs[configuration.name] = rig
    space = law_space("fractional_zener", f, np.full(len(f), _MODULUS))
    return CampaignProblem(campaign, data, rigs, space)


def _slopes(f: RealArray, cycles: float) -> ComplexArray:
    """Return `ConfigurationData.top_slopes` of Hann bursts at f, Hz, each in the middle of its spectrum."""
    turns = 2 * np.pi * f * (_LEAD + cycles / (2 * f))
    duration = cycles * np.sqrt(1 / 12 - 1 / (2 * np.pi**2))  # standard deviation under the window, in periods
    return np.stack([-1j * turns, -1j * turns - (2 * np.pi * duration) ** 2])


def soft_sample(problem: CampaignProblem) -> RealArray:
    """Return coordinates of a problem with the law of `joint_bench` for a foam; nothing else departs from its prior."""
    z = np.zeros(len(problem.parameters))
    for index, (parameter, value) in enumerate(zip(problem.law_parameters, _LAW, strict=True)):
        z[index] = float(parameter.prior.coordinate(np.log(value)))
    return z


def _campaign() -> dict[str, Any]:
    bursts = [{"frequency": f, "file": f"{f:g}.npz"} for f in _FREQUENCIES]
    sizes = {"thin": (0.0125, 0.001), "thick": (0.025, 0.003)}
    return {
        "version": 1,
        "rig": "shaker-two-plate",
        "sampling_rate": 25600,
        "specimen": {"density": 80, "poisson_ratio": 0.0},
        "top_plate": {"density": 7850, "young_modulus": 2.1e11, "poisson_ratio": 0.3},
        "base_plate": {"density": 2700, "young_modulus": 7e10, "poisson_ratio": 0.33, "thickness": 0.01},
        "burst": {"cycles": 10, "level_rms": 5.0},
        "configurations": [
            {
                "name": name,
                "specimen_thickness": height,
                "top_plate_thickness": plate,
                "specimen_radius": 0.0225,
                "bursts": bursts,
            }
            for name, (height, plate) in sizes.items()
        ],
    }
