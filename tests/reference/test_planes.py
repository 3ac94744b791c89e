"""Reflection and transmission against rows of the program PLANES, each within 1.4e-10 of a 40-digit solution."""

import csv
import json
from collections import defaultdict

import pytest

from multilayer.response import plane_wave
from tests.reference.reference_data import stack_of, worst_error

pytestmark = pytest.mark.reference

MATERIALS = {
    "foam": {
        "kind": "pem", "phi": 0.97, "sigma": 87e3, "alpha_inf": 2.52, "Lambda_v": 36e-6, "Lambda_t": 118e-6,
        "rho_1": 31, "E": 143e6, "nu": 0.3, "eta": 0.055,
    },
    "foam2": {
        "kind": "pem", "phi": 0.98, "sigma": 15e3, "alpha_inf": 1.05, "Lambda_v": 100e-6, "Lambda_t": 250e-6,
        "rho_1": 25, "E": 140e3, "nu": 0.3, "eta": 0.1,
    },
    "wood": {"kind": "elastic", "rho": 900, "E": 5e9, "nu": 0.3, "eta": 0.05},
}  # fmt: skip


@pytest.fixture(scope="module")
def air(shared):
    return json.loads((shared / "reference" / "tmm_cases.json").read_text())["air"]


@pytest.fixture(scope="module")
def spectra(shared):
    """Rows by stack, backing and angle; a solid has one frame, so its rows count whatever they say of pores."""
    found = defaultdict(list)
    with (shared / "reference" / "planes_plane_wave.csv").open() as file:
        for row in csv.DictReader(file):
            materials, thicknesses = row["materials"].split("|"), row["thicknesses_mm"].split("|")
            if row["frame"] == "poroelastic" or set(materials) == {"wood"}:
                layers = tuple(zip(materials, thicknesses, strict=True))
                found[layers, row["backing"], float(row["angle_deg"])].append(row)
    return found


def test_rows(spectra, air):
    compared = 0
    for (layers, backing, angle), rows in spectra.items():
        described = [{**MATERIALS[name], "thickness_m": float(mm) / 1e3} for name, mm in layers]
        result = plane_wave(stack_of(air, described, backing), [float(row["frequency_hz"]) for row in rows], angle)
        for key, ours in (("R", result.reflection), ("T", result.transmission)):
            if ours is not None:
                expected = [complex(float(row[f"re_{key}"]), float(row[f"im_{key}"])) for row in rows]
                assert worst_error(ours, expected) < 1e-9, (layers, backing, angle, key)
        compared += len(rows)
    assert compared == 1080
    assert {angle for _, _, angle in spectra} == {0, 5, 45}
