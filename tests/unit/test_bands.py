"""Bands of IEC 61260-1 against its tables, and means over them."""

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.response import band_centres, band_edges, band_levels, band_means
from multilayer.response.bands import band_points, bands_of, nearest_centres
from multilayer.response.ratings import THIRD_OCTAVES

WIDTHS = ("third octaves", "octaves")


def test_nominal_centres_of_the_standard() -> None:
    octaves = [16, 31.5, 63, 125, 250, 500, 1000, 2000, 4000, 8000, 16000]
    assert band_centres(16, 16e3, "octaves").tolist() == octaves
    assert band_centres(100, 5000).tolist() == list(THIRD_OCTAVES)
    assert nearest_centres([15.8489, 89.1, 89.2, 707.0, 708.0, 0.1], "octaves").tolist() == [
        16, 63, 125, 500, 1000, 0.125,
    ]  # fmt: skip


@pytest.mark.parametrize(("width", "half"), [("third octaves", 0.05), ("octaves", 0.15)])
def test_edges_lie_about_exact_centres(width: str, half: float) -> None:
    centres = band_centres(125, 8000, width)
    edges = band_edges(centres, width)
    exact = np.sqrt(edges[:-1] * edges[1:])
    np.testing.assert_allclose(edges[1:] / exact, 10**half)
    np.testing.assert_allclose(exact, centres, rtol=0.012)
    assert exact[centres == 1000] == pytest.approx(1000)


@pytest.mark.parametrize("width", WIDTHS)
def test_points_fill_their_band_evenly(width: str) -> None:
    centres = band_centres(63, 2000, width)
    points, edges = band_points(centres, width), band_edges(centres, width)
    assert points.shape == (len(centres), {"octaves": 63, "third octaves": 21}[width])
    assert np.ptp(np.diff(np.log(points.ravel()))) < 1e-12
    assert np.all((points > edges[:-1, None]) & (points < edges[1:, None]))
    assert {f for f, _ in bands_of(points.ravel(), width)} == set(centres)


def test_means_and_levels_of_a_spectrum() -> None:
    frequency = np.array([900.0, 490.0, 1100.0, 510.0, 1000.0])
    values = np.array([10.0, 0.0, 30.0, 20.0, 20.0])
    assert band_means(frequency, values, "octaves") == {500.0: 10.0, 1000.0: 20.0}
    assert band_means(frequency, values, "octaves", least=3) == {1000.0: 20.0}
    levels = band_levels(frequency, values, "octaves")
    assert levels == pytest.approx({500: -10 * np.log10((1 + 0.01) / 2), 1000: -10 * np.log10(0.111 / 3)})
    assert list(band_levels(frequency, values)) == [500, 1000]


def test_bands_that_transmit_nothing() -> None:
    assert band_levels([1000.0], [np.inf]) == {1000.0: np.inf}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([0.0], [1.0]), "0 Hz lies in no band; frequencies must be above 0"),
        (([np.nan], [1.0]), "nan Hz lies in no band"),
        (([1.0, 2.0], [1.0]), r"\(2,\) frequencies and \(1,\) values are no spectrum"),
        (([1.0], [1.0], "octave"), "there are no bands called 'octave'; did you mean 'octaves'?"),
    ],
)
def test_what_is_no_spectrum(arguments: tuple, words: str) -> None:
    with pytest.raises(InputError, match=words):
        band_means(*arguments)
