"""The laboratory of rods beside what is known of it without the project's models."""

import numpy as np
import pytest

from multilayer.measurements.campaign import load_campaign, load_recordings
from tests.fits.rods import (
    REST,
    Hum,
    campaign_of_rods,
    constant_loss,
    fractional_zener,
    havriliak_negami,
    transmissibility,
    write_rods,
)

LAW = fractional_zener(1.2e5, 1.5e6, 2e-5, 0.45)
ROD = {"density": 90.0, "height": 0.025, "plate": 0.001, "plate_density": 7850.0}
NAME = "h25mm-t1mm"


def test_a_light_sample_is_a_spring_under_a_mass():
    f, modulus = np.array([10.0, 60.0, 300.0]), 2e5 * (1 + 0.2j)
    spring = modulus / 0.025 / 7.85  # over the plate's mass
    expected = 1 / (1 - (2 * np.pi * f) ** 2 / spring)
    np.testing.assert_allclose(transmissibility(f, modulus, **ROD | {"density": 1e-3}), expected, rtol=1e-5)


def test_without_a_plate_the_free_end_of_a_rod_moves_by_one_over_the_cosine():
    f, modulus = np.array([50.0, 700.0, 5000.0]), 2e5 * (1 + 0.2j)
    expected = 1 / np.cos(2 * np.pi * f * 0.025 * np.sqrt(90.0 / modulus))
    np.testing.assert_allclose(transmissibility(f, modulus, **ROD | {"plate": 1e-12}), expected, rtol=1e-6)


@pytest.mark.parametrize("law", [LAW, havriliak_negami(1e5, 2e6, 1e-4, 0.7, 0.4), constant_loss(2e5, 0.3)])
def test_nothing_moves_before_the_foot_does(law):
    # causal to the last digit that the sampled start of a burst allows
    _, recordings = campaign_of_rods(law, frequencies=(300.0,), noise=(0.0, 0.0))
    top = recordings[NAME, 300.0].top[0]
    first = round((REST - 0.001) * 25600)
    assert np.abs(top[:first]).max() < 1e-5 * np.abs(top).max()


def test_what_is_asked_for_is_in_the_signals():
    options = {"frequencies": (300.0,), "repeats": 2, "tail": 0.3}
    _, clean = campaign_of_rods(LAW, noise=(0.0, 0.0), **options)
    _, noisy = campaign_of_rods(LAW, noise=(0.05, 0.02), hum=Hum(0.1), channel_gain=1.1, exchanged=True, **options)
    quiet, loud = clean[NAME, 300.0], noisy[NAME, 300.0]
    during = slice(round(REST * 25600), round((REST + 10 / 300) * 25600))
    assert np.sqrt(np.mean(quiet.base[:, during] ** 2)) == pytest.approx(5.0, rel=1e-3)
    added = np.stack([loud.top - quiet.base, loud.base - 1.1 * quiet.top])  # exchanged, with the top's gain
    hum, noise = added.mean(axis=1), np.diff(added, axis=1)[:, 0] / np.sqrt(2)
    top_rms = 1.1 * np.sqrt(np.mean(quiet.top[:, during] ** 2))
    np.testing.assert_allclose(noise.std(axis=-1), [0.05 * 5.0, 0.02 * top_rms], rtol=0.05)
    np.testing.assert_allclose(np.sqrt(np.mean(hum**2, axis=-1)), 0.1 * 5.0, rtol=0.1)


def test_written_and_read_again(tmp_path):
    options = {"thicknesses": (0.02, 0.04), "frequencies": (200.0, 600.0)}
    campaign, recordings = campaign_of_rods(LAW, **options)
    folder = write_rods(tmp_path / "rods", LAW, **options)
    again = load_campaign(folder)
    assert again.model_dump() == campaign.model_dump()
    for key, recording in load_recordings(again).items():
        np.testing.assert_array_equal(recording.top, recordings[key].top)
