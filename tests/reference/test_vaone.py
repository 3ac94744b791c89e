"""Diffuse-field curves of the commercial program VA One, 0 to 78 degrees, for 30 mm of melamine foam."""

import csv
from pathlib import Path

import numpy as np
import pytest

from multilayer.response import diffuse_field
from multilayer.stack import Stack

pytestmark = pytest.mark.reference

FOAM = {
    "type": "poroelastic", "thickness": 0.03, "porosity": 0.99, "flow_resistivity": 30000, "tortuosity": 1.01,
    "viscous_length": 250e-6, "thermal_length": 550e-6, "frame_density": 12, "young_modulus": 3e5,
    "poisson_ratio": 0.4, "loss_factor": 0.1,
}  # fmt: skip
FILM = {"type": "elastic_solid", "thickness": 1e-6, "density": 2700, "young_modulus": 7e10, "poisson_ratio": 0.33}
AMBIENT = {"density": 1.21, "sound_speed": 343.0}


def _columns(file: Path, name: str) -> tuple[np.ndarray, np.ndarray]:
    rows = list(csv.DictReader(file.read_text().splitlines()))
    assert len(rows) == 89
    return tuple(np.array([float(row[column]) for row in rows]) for column in ("Frequency", name))


def _panel(termination: str) -> Stack:
    # the film is bonded to the foam's far side: as a solid it carries in-plane tension, a thin plate would slip
    return Stack.model_validate({"ambient": AMBIENT, "layers": [FOAM, FILM], "termination": termination})


def test_transmission_loss(shared: Path) -> None:
    frequency, exact = _columns(shared / "reference" / "vaone_melamine_TL_78.csv", "30mm Melamin")
    found = diffuse_field(_panel("ambient"), frequency)
    assert np.abs(found.transmission_loss - exact).max() < 0.1


def test_absorption(shared: Path) -> None:
    frequency, exact = _columns(shared / "reference" / "vaone_melamine_abs_78.csv", "melamin")
    found = diffuse_field(_panel("rigid"), frequency)
    assert np.abs(found.absorption - exact).max() < 1e-3
