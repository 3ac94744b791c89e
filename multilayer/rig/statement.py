"""Descriptions of a virtual campaign: the campaign file with what the experimenter knows, and the truth file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from multilayer.measurements.description import Campaign
from multilayer.measurements.writing import signal_name
from multilayer.media.laws import FractionalZener, ModulusLaw
from multilayer.rig.draws import Errors
from multilayer.rig.file import RigFile


def campaign_of(settings: RigFile) -> Campaign:
    """Return the campaign as an experimenter would describe it: nominal values and stated uncertainties."""
    plates = {
        "top_plate": settings.top_plate.model_dump(),
        "base_plate": settings.base_plate.model_dump(exclude={"elastic"}),
    }
    configurations = [
        {
            "name": mounting.name,
            "specimen_thickness": mounting.thickness,
            "top_plate_thickness": mounting.top_plate,
            "specimen_radius": mounting.radius,
            "bursts": [{"frequency": f, "file": signal_name(mounting.name, f)} for f in mounting.frequencies],
        }
        for mounting in settings.mountings
    ]
    return Campaign.model_validate(
        {
            "version": 1,
            "rig": "shaker-two-plate",
            "sampling_rate": settings.sampling_rate,
            "specimen": {"density": settings.specimen.density, "poisson_ratio": settings.poisson_ratio},
            **plates,
            "uncertainty": settings.uncertainty.model_dump(),
            "burst": settings.burst.model_dump(),
            "configurations": configurations,
        }
    )


def truth_of(
    settings: RigFile, seed: int, errors: Errors, moduli: Mapping[str, Mapping[float, complex]]
) -> dict[str, Any]:
    """Return the contents of the truth file, which the experimenter does not know, as plain data.

    Parameters
    ----------
    settings : RigFile
    seed : int
        Of the draws of errors and noise.
    errors : Errors
        As drawn.
    moduli : mapping
        Complex modulus, Pa, by configuration and frequency, Hz.
    """
    specimen = settings.specimen
    effects = [
        {
            "effect": effect.effect,
            "known": effect.known,
            "perturbation": effect.perturbation,
            "parameters": effect.parameters(specimen),
        }
        for effect in settings.effects
    ]
    return {
        "effect": "+".join(effect.effect for effect in settings.effects) or "none",
        "parameters": effects[0]["parameters"] if len(effects) == 1 else {},
        "effects": effects,
        "material": _material(settings),
        "nu": settings.poisson_ratio,
        "noise": settings.noise.white,
        "seed": seed,
        "errors": errors.to_dict(),
        "moduli": [
            {"configuration": name, "frequency_hz": f, "E1_pa": e.real, "E2_pa": e.imag}
            for name, at in moduli.items()
            for f, e in at.items()
        ],
        "channels": settings.noise.model_dump(mode="json"),
        "remount": None if settings.remount is None else settings.remount.model_dump(),
    }


def _material(settings: RigFile) -> dict[str, Any]:
    """Return the law; of a fractional Zener one also the four numbers E0, ratio, tau, alpha."""
    law = settings.specimen.young_modulus
    plain = settings.specimen.model_dump(mode="json", include={"young_modulus"})["young_modulus"]
    short = {}
    if isinstance(law, FractionalZener):
        ratio = law.unrelaxed_modulus / law.relaxed_modulus
        short = {"E0": law.relaxed_modulus, "ratio": ratio, "tau": law.relaxation_time, "alpha": law.order}
    elif not isinstance(law, ModulusLaw):
        plain = {"E1": complex(law).real, "E2": complex(law).imag}
    return {"rho": settings.specimen.density, **short, "young_modulus": plain}
