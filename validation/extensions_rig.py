"""Series of top plates and cubes on the virtual rig, many times over with errors drawn anew."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from multilayer_campaigns.anisotropy import AnisotropyResult, compare_axes
from multilayer_campaigns.modulus_points import points_of
from multilayer_campaigns.multi_campaign import SAME_RIG
from multilayer_campaigns.preload import fit_preload
from multilayer_campaigns.preload_result import PreloadResult

from multilayer.fits.burst.fit import fit_bursts
from multilayer.fits.settings import FitSettings
from multilayer.measurements.description import Campaign
from multilayer.rig.draws import draw_errors
from multilayer.rig.file import RigFile
from multilayer.rig.statement import campaign_of
from multilayer.rig.synthesis import Task, make_campaign, measure
from multilayer.signals.recording import Recording

UNCERTAINTY = {
    "channel_gain": 0.003, "channel_delay": 1e-6, "remount_gain": 0.001, "thickness": 5e-5, "density": 0.01,
    "top_plate_mass": 0.002,
}  # fmt: skip
LAW = {
    "law": "fractional_zener",
    "relaxed_modulus": 1e5,
    "unrelaxed_modulus": 1e6,
    "relaxation_time": 1e-4,
    "order": 0.5,
}
PLATES = (0.001, 0.002, 0.003, 0.005)
FREQUENCIES = (150.0, 300.0, 450.0, 700.0)
ONE_PIECE = SAME_RIG | {"density"}


def rig_file(factor: float = 1.0, **fields: object) -> RigFile:
    """Return the file of a rig; `factor` on the modulus."""
    law = {**LAW, **{name: factor * LAW[name] for name in ("relaxed_modulus", "unrelaxed_modulus")}}
    data = {
        "version": 1, "rig": "two-plate", "specimen": {"density": 80.0, "young_modulus": law, "poisson_ratio": 0.3},
        "frequencies": list(FREQUENCIES), "uncertainty": UNCERTAINTY,
    }  # fmt: skip
    return RigFile.model_validate({**data, **fields})


def preload_once(stiffening: float, seed: int) -> PreloadResult:
    """Return what one laboratory finds of a specimen under four plates."""
    effects = [{"effect": "preload", "stiffening": stiffening}] if stiffening else []
    plates = {"thicknesses": [0.025], "top_plates": list(PLATES)}
    made = make_campaign(rig_file(configurations=plates, effects=effects), seed)
    fitted = fit_bursts(made.campaign, made.recordings)
    return fit_preload(["series"], points_of(0, made.campaign, fitted))


@dataclass(frozen=True)
class Axis:
    """What a cube shows along one axis: its modulus, and further fields of the rig's file."""

    factor: float
    fields: dict[str, object]


def cube_once(axes: Sequence[Axis], seed: int, settings: FitSettings | None = None) -> AnisotropyResult:
    """Return what one laboratory finds along three axes: channels, plate and density are those of all three."""
    points = []
    for index, axis in enumerate(axes):
        campaign, recordings = _along(axis, index, seed)
        points += points_of(index, campaign, fit_bursts(campaign, recordings, settings))
    return compare_axes(["x", "y", "z"], points, common=ONE_PIECE)


def _along(axis: Axis, index: int, seed: int) -> tuple[Campaign, dict[tuple[str, float], Recording]]:
    plates = {"thicknesses": [0.025], "top_plates": [0.001, 0.003]}
    file = rig_file(axis.factor, **{"configurations": plates, **axis.fields})
    own = 3 * seed + index
    shared = {name: getattr(draw_errors(file, 100_000 + seed), name) for name in ONE_PIECE}
    errors = replace(draw_errors(file, own), **shared)
    recordings = {
        (mounting.name, f): Recording(*pair, file.sampling_rate)
        for mounting in file.mountings
        for f, pair in measure(Task(file, errors, mounting, own)).channels.items()
    }
    return campaign_of(file), recordings


def rods(*factors: float) -> list[Axis]:
    """Return axes of a cube whose Poisson's ratio is 0."""
    return [Axis(factor, {}) for factor in factors]


def transversely_isotropic(ratio: float) -> list[Axis]:
    """Return axes of a material of Poisson's ratio 0.3 that is stiffer along z by `ratio`; its rim is free.

    Across z the disc is no body of revolution: the finite elements take the mean of both moduli across its axis.
    """
    across, along = 0.5 * (1 + ratio), 1 / ratio
    exact = {"uncertainty": {}, "noise": {"white": 1e-4}}

    def axis(factor: float, transverse: float) -> Axis:
        effects = [
            {"effect": "finite_size"}, {"effect": "plate_flexure"},
            {"effect": "anisotropy", "transverse_ratio": transverse},
        ]  # fmt: skip
        return Axis(factor, {"effects": effects, **exact})

    return [axis(1.0, across), axis(1.0, across), axis(ratio, along)]


def in_deviations(found: np.ndarray, truth: np.ndarray, spread: np.ndarray) -> tuple[float, float]:
    """Return the rms of the errors in standard deviations, and the share within two of them."""
    z = np.abs(found - truth) / spread
    return float(np.sqrt(np.mean(z**2))), float(np.mean(z <= 2))
