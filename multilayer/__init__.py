"""Layered panels and samples in vibro-acoustics: forward simulation, inversion, diagnosis.

The public names load on first use, so that ``import multilayer`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from multilayer.diagnosis.diagnose import diagnose_campaign
    from multilayer.diagnosis.result import Diagnosis
    from multilayer.errors import InputError, MultilayerError
    from multilayer.fits.result import FitResult
    from multilayer.fits.run import fit_campaign
    from multilayer.fits.settings import FitSettings
    from multilayer.layers import LAYERS, Layer
    from multilayer.measurements import load_campaign, load_recordings
    from multilayer.response import base_motion, diffuse_field, fields, plane_wave, power_balance
    from multilayer.simulation import SimulationFile, SimulationResult, load_simulation, simulate
    from multilayer.stack import Stack, load_stack

_HOMES = {
    "LAYERS": "multilayer.layers",
    "Diagnosis": "multilayer.diagnosis.result",
    "FitResult": "multilayer.fits.result",
    "FitSettings": "multilayer.fits.settings",
    "InputError": "multilayer.errors",
    "Layer": "multilayer.layers",
    "MultilayerError": "multilayer.errors",
    "SimulationFile": "multilayer.simulation",
    "SimulationResult": "multilayer.simulation",
    "Stack": "multilayer.stack",
    "base_motion": "multilayer.response",
    "diagnose_campaign": "multilayer.diagnosis.diagnose",
    "diffuse_field": "multilayer.response",
    "fields": "multilayer.response",
    "fit_campaign": "multilayer.fits.run",
    "load_campaign": "multilayer.measurements",
    "load_recordings": "multilayer.measurements",
    "load_simulation": "multilayer.simulation",
    "load_stack": "multilayer.stack",
    "plane_wave": "multilayer.response",
    "power_balance": "multilayer.response",
    "simulate": "multilayer.simulation",
}

__all__ = [
    "LAYERS",
    "Diagnosis",
    "FitResult",
    "FitSettings",
    "InputError",
    "Layer",
    "MultilayerError",
    "SimulationFile",
    "SimulationResult",
    "Stack",
    "base_motion",
    "diagnose_campaign",
    "diffuse_field",
    "fields",
    "fit_campaign",
    "load_campaign",
    "load_recordings",
    "load_simulation",
    "load_stack",
    "plane_wave",
    "power_balance",
    "simulate",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("multilayer")
    if name not in _HOMES:
        raise AttributeError(f"module 'multilayer' has no attribute '{name}'")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
