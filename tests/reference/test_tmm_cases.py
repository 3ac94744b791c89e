"""Reflection and transmission against 40-digit solutions that several independent programs agree with."""

import json

import numpy as np
import pytest

from multilayer.response import plane_wave
from tests.reference.reference_data import KINDS, stack_of, worst_error

pytestmark = pytest.mark.reference

CASES = [
    "01_fluid_layer_rigid",
    "07_biot_rigid_melamine",
    "08_biot_rigid_foam2",
    "09_biot_double_rigid",
    "11_elastic_biot_rigid",
    "13_elastic_on_rigid",
    "14_elastic_transmission",
    "15_biot_transmission",
    "16_elastic_biot_elastic_transmission",
    "19_thin_plate_transmission",
]


@pytest.fixture(scope="module")
def data(shared):
    return json.loads((shared / "reference" / "tmm_cases.json").read_text())


def test_every_case_of_known_layers_is_compared(data):
    known = [case["id"] for case in data["cases"] if {layer["kind"] for layer in case["layers"]} <= set(KINDS)]
    assert known == CASES


@pytest.mark.parametrize("name", CASES)
def test_case(data, name):
    (case,) = (case for case in data["cases"] if case["id"] == name)
    stack = stack_of(data["air"], case["layers"], case["termination"])
    angles = [angle["theta_deg"] for angle in case["angles"]]
    assert 0 in angles
    assert len(angles) == 4
    result = plane_wave(stack, data["frequencies_Hz"], angles)
    for key, ours in (("R", result.reflection), ("T", result.transmission)):
        if ours is not None:
            expected = np.array([angle[key] for angle in case["angles"]]) @ [1, 1j]
            assert worst_error(ours.T, expected) < 1e-9, key
    assert (result.transmission is None) == (case["termination"] == "rigid")
