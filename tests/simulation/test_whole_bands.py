"""Which third octaves single frequencies stand for: those that they fill from edge to edge."""

import warnings

import numpy as np
import pytest

from multilayer.config import parse_yaml
from multilayer.response.bands import band_centres, mean_value
from multilayer.simulation import SimulationFile, load_simulation, simulate
from multilayer.simulation.bands import Grid, grid_of
from multilayer.simulation.settings import FrequencyRange
from tests.simulation.files import FOAM, PANEL

ALL = band_centres(100, 5000).tolist()


def rated(frequency):
    f = np.asarray(frequency, dtype=float)
    return [*Grid(f, f).by_band(mean_value, np.zeros(len(f)))]


@pytest.mark.parametrize("points", [60, 200, 5000])
def test_the_default_range_fills_the_bands_of_ratings(points):
    frequency = grid_of(FrequencyRange(points=points)).frequency
    assert rated(frequency) == ALL
    assert Grid(frequency, frequency).thirds[0][0] == 100  # and begins in no band before


def test_half_a_band_is_none():
    assert rated(np.geomspace(100, 5000, 200)) == ALL[1:-1]
    assert rated(np.geomspace(90, 5600, 200)) == ALL


@pytest.mark.parametrize(
    ("ends", "lost"), [((100, 5000), [100, 5000]), ((90, 5000), [5000]), ((90, 5600), []), ((300, 2000), [])]
)
def test_a_rating_that_is_lost_to_half_a_band_is_told(ends, lost, tmp_path):
    file = tmp_path / "foam.yaml"
    file.write_text(f"{FOAM}frequency: {{from: {ends[0]}, to: {ends[1]}}}\n")
    assert grid_of(FrequencyRange(**{"from": ends[0], "to": ends[1]})).partly_filled == lost
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        load_simulation(file)
    texts = [str(one.message) for one in told if "in part" in str(one.message)]
    assert len(texts) == bool(lost)
    assert all(f"foam.yaml:{len(FOAM.splitlines()) + 1}" in text for text in texts)
    centres = np.array(ALL)
    assert Grid(centres, centres).partly_filled == []  # single frequencies, of which nobody expects a rating


def test_equal_frequencies_are_one():
    assert rated([100.0, 100.0, 100.0]) == []
    assert rated([90.0, 90.0, 90.0, 112.0]) == []


@pytest.mark.parametrize("step", [4, 6.25, 7])
def test_lines_of_a_spectrum_fill_bands(step):
    assert rated(np.arange(step, 6000, step))[-18:] == ALL


def test_any_even_spacing_of_three_frequencies_fills_a_band():
    low, high = 10**1.95, 10**2.05
    for share in np.linspace(0.01, 1, 30):
        for step in np.linspace(3, 8.6, 30):
            linear = low + share * step + step * np.arange(-1, 40)
            logarithmic = low * (1 + step / 100) ** (share + np.arange(-1, 80))
            for f in (linear, logarithmic):
                if np.count_nonzero((f >= low) & (f < high)) > 2:
                    assert 100 in rated(f), f


def test_frequencies_rounded_to_whole_hertz_fill_bands():
    eighths = 10 ** ((np.arange(18 * 8) + 0.5) / 80 + 1.95)
    assert rated(np.round(eighths)) == ALL


@pytest.mark.filterwarnings("ignore:200 frequencies miss narrow resonances")  # of the cavity, above what Rw needs most
@pytest.mark.parametrize(("text", "name"), [(FOAM, "alpha_w"), (PANEL, "Rw (C; Ctr)")])
def test_a_bare_stack_is_rated_as_its_bands_are(text, name, tmp_path):
    data = parse_yaml(text, tmp_path / "file.yaml").data
    bare, banded, halved = (
        simulate(SimulationFile.model_validate({**data, **more})).cases[0].ratings
        for more in ({}, {"frequency": {"third_octaves": [100, 5000]}}, {"frequency": {"from": 100, "to": 5000}})
    )
    assert bare[name] == banded[name]
    assert name not in halved
