"""Finite elements as a diagnosis uses them: as exact as it needs, of campaigns of an independent solver."""

from pathlib import Path

import numpy as np
import pytest

from multilayer.diagnosis.diagnose import fit_nominal
from multilayer.diagnosis.free_rim import free_rim
from multilayer.diagnosis.hypothesis import rig_hypothesis
from multilayer.diagnosis.thresholds import MODEL_ERROR
from multilayer.inverse.finite import two_plate_rig
from multilayer.inverse.sources import read_fit


@pytest.mark.reference
@pytest.mark.parametrize("name", ["paper-b", "paper-c"])
def test_elements_of_a_diagnosis_are_right_to_a_third_of_what_solvers_differ_by(shared: Path, name: str):
    """Of broad and of sharp resonances, on a mesh twice as fine and without a reduced basis."""
    job = read_fit(shared / "campaigns" / name)
    nominal, minima = fit_nominal(job.campaign, job.recordings)
    joint = rig_hypothesis(nominal.hypothesis).joint
    rigs, z = free_rim(job.campaign, joint, minima)
    configuration, data = job.campaign.configurations[0], joint.data[0]
    few = slice(None, None, 8)
    f = data.frequency[few]
    modulus = joint.space.modulus(joint.law_coordinates(z), f)
    exact = two_plate_rig(job.campaign, configuration).replaced(resolution=2.0).transmissibility(f, modulus)
    error = np.abs(rigs[data.name].transmissibility(f, modulus) / exact - 1)
    assert np.max(error) < MODEL_ERROR / 3
    assert len(f) > 5
