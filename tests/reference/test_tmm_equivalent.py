"""Equivalent fluids and limp frames against 40-digit solutions and the program PLANES."""

import csv
import json
from collections import defaultdict
from typing import Any

import numpy as np
import pytest

from multilayer.response import plane_wave
from multilayer.stack import Stack

pytestmark = pytest.mark.reference

_PORES = {
    "porosity": "phi", "flow_resistivity": "sigma", "tortuosity": "alpha_inf", "viscous_length": "Lambda_v",
    "thermal_length": "Lambda_t",
}  # fmt: skip
KINDS: dict[str, tuple[dict[str, str], dict[str, str]]] = {
    "fluid": ({"type": "fluid"}, {"density": "rho", "sound_speed": "c"}),
    "eqf": ({"type": "equivalent_fluid"}, _PORES),
    "eqf_jcal": ({"type": "equivalent_fluid", "model": "jcal"}, {**_PORES, "thermal_permeability": "k0_prime"}),
    "limp": ({"type": "limp"}, {**_PORES, "frame_density": "rho_1"}),
}
CASES = ["02_eqf_jca_rigid", "03_eqf_jca_air_gap_rigid", "05_limp_rigid", "22_eqf_jcal_rigid"]
MATERIALS = {
    "foam": {"kind": "eqf", "phi": 0.97, "sigma": 87e3, "alpha_inf": 2.52, "Lambda_v": 36e-6, "Lambda_t": 118e-6},
    "foam2": {"kind": "eqf", "phi": 0.98, "sigma": 15e3, "alpha_inf": 1.05, "Lambda_v": 100e-6, "Lambda_t": 250e-6},
}
WOOD = {"type": "elastic_solid", "density": 900, "young_modulus": 5e9, "poisson_ratio": 0.3, "loss_factor": 0.05}


@pytest.fixture(scope="module")
def data(shared):
    return json.loads((shared / "reference" / "tmm_cases.json").read_text())


def ambient_of(air: dict[str, Any], prandtl: float | None = None) -> dict[str, Any]:
    return {
        "density": air["rho0_kg_m3"], "sound_speed": air["c0_m_s"], "viscosity": air["mu_Pa_s"],
        "prandtl": prandtl or air["Pr"], "heat_capacity_ratio": air["gamma"], "pressure": air["P0_Pa"],
    }  # fmt: skip


def layer_of(given: dict[str, Any], thickness: float) -> dict[str, Any]:
    head, fields = KINDS[given["kind"]]
    return {**head, "thickness": thickness, **{ours: given[theirs] for ours, theirs in fields.items()}}


def test_every_case_is_compared(data):
    kinds = {"eqf", "eqf_jcal", "limp"}
    assert [case["id"] for case in data["cases"] if kinds & {layer["kind"] for layer in case["layers"]}] == CASES


@pytest.mark.parametrize("name", CASES)
def test_case(data, name):
    (case,) = (case for case in data["cases"] if case["id"] == name)
    # that program takes Cp and the conductivity of air, and so another Prandtl number (note in the file)
    prandtl = data["air"]["mu_Pa_s"] * 1006 / 0.0262 if "jcal" in name else None
    stack = Stack.model_validate(
        {
            "ambient": ambient_of(data["air"], prandtl),
            "layers": [layer_of(layer, layer["thickness_m"]) for layer in case["layers"]],
            "termination": case["termination"],
        }
    )
    angles = [angle["theta_deg"] for angle in case["angles"]]
    assert angles == [0, 30, 60, 80]
    ours = plane_wave(stack, data["frequencies_Hz"], angles).reflection.T
    expected = np.array([angle["R"] for angle in case["angles"]]) @ [1, 1j]
    assert np.max(np.abs(ours - expected) / np.abs(expected)) < 1e-13


@pytest.fixture(scope="module")
def spectra(shared):
    found = defaultdict(list)
    with (shared / "reference" / "planes_plane_wave.csv").open() as file:
        for row in csv.DictReader(file):
            if row["frame"] == "equivalent_fluid":
                layers = tuple(zip(row["materials"].split("|"), row["thicknesses_mm"].split("|"), strict=True))
                found[layers, row["backing"], float(row["angle_deg"])].append(row)
    return found


def test_rows_of_planes(spectra, data):
    """Within 1e-9 of each value, or within the 1.4e-10 that the file's own error reaches."""
    compared = 0
    for (layers, backing, angle), rows in spectra.items():
        described = [
            {**WOOD, "thickness": float(mm) / 1e3} if name == "wood" else layer_of(MATERIALS[name], float(mm) / 1e3)
            for name, mm in layers
        ]
        termination = {"rigid": "rigid", "transmission": "ambient"}[backing]
        stack = Stack.model_validate(
            {"ambient": ambient_of(data["air"]), "layers": described, "termination": termination}
        )
        result = plane_wave(stack, [float(row["frequency_hz"]) for row in rows], angle)
        for key, ours in (("R", result.reflection), ("T", result.transmission)):
            if ours is not None:
                expected = np.array([complex(float(row[f"re_{key}"]), float(row[f"im_{key}"])) for row in rows])
                error = np.abs(ours - expected)
                assert np.all((error < 1e-9 * np.abs(expected)) | (error < 1.4e-10)), (layers, backing, angle, key)
        compared += len(rows)
    assert compared == 1680
    assert {angle for _, _, angle in spectra} == {5, 45}
