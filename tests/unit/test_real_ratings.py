"""Ratings as real numbers: the ratings of the standards are these in whole steps, wherever nothing else is rounded."""

import numpy as np
import pytest

from multilayer.response import ratings as rt
from multilayer.response import real_ratings as real

RNG = np.random.default_rng(3)
BANDS = (50, 63, 80, *rt.THIRD_OCTAVES)


def losses(n, step):
    """Return transmission losses of n walls in steps of a rating's rounding, shape (n_bands, n)."""
    slope = np.linspace(0, 1, len(BANDS))[:, None]
    values = RNG.uniform(10, 40, n) + RNG.uniform(-5, 40, n) * slope + RNG.normal(0, 4, (len(BANDS), n))
    return np.round(values / step) * step


def of_each(rating, values):
    return np.array([rating(dict(zip(map(float, BANDS), column, strict=True))) for column in values.T])


def in_bands(values):
    return dict(zip(map(float, BANDS), values, strict=True))


def test_reduction_index_is_its_whole_part():
    values = losses(200, 0.1)
    found = real.real_reduction_index(in_bands(values))
    assert np.array_equal(np.floor(found + 1e-9), of_each(lambda bands: rt.weighted_reduction_index(bands).rw, values))


@pytest.mark.parametrize(("spectrum", "term"), [("C", "c"), ("Ctr", "ctr")])
def test_adapted_index_is_its_rounded_value(spectrum, term):
    values = losses(200, 0.1)
    found = real.real_adapted_index(in_bands(values), spectrum)

    def whole(bands):
        index = rt.weighted_reduction_index(bands)
        return index.rw + getattr(index, term)

    assert np.array_equal(np.floor(found + 0.5), of_each(whole, values))


def test_transmission_classes():
    values = losses(200, 1.0)
    found = real.real_transmission_class(in_bands(values))
    assert np.array_equal(np.floor(found + 1e-9), of_each(rt.sound_transmission_class, values))
    found = real.real_outdoor_indoor_class(in_bands(values))
    assert np.array_equal(np.floor(found + 0.5), of_each(rt.outdoor_indoor_transmission_class, values))


def test_weighted_absorption_is_it_in_steps():
    octaves = np.round(RNG.uniform(0, 1, (5, 300)) * 20) / 20
    centres = (250.0, 500.0, 1000.0, 2000.0, 4000.0)
    found = real.real_weighted_absorption_octaves(dict(zip(centres, octaves, strict=True)))
    steps = [
        rt.weighted_from_practical(dict(zip(map(int, centres), column, strict=True))).alpha_w for column in octaves.T
    ]
    assert np.minimum(np.floor(found * 20 + 1e-9) / 20, 1) == pytest.approx(np.maximum(steps, 0))


def test_weighted_absorption_rises_with_every_band():
    """Its slope by an octave that falls short of the curve is one over the number of those; others change nothing."""
    values = {float(band): np.full(1, 0.6) for band in rt.THIRD_OCTAVES}
    before = real.real_weighted_absorption(values)
    assert before == pytest.approx(1 - (3 * 0.4 - 0.1) / 3)  # 250 and 4000 Hz lie nearer to their curve
    raised = {**values, 1000.0: values[1000.0] + 0.03}
    assert real.real_weighted_absorption(raised) - before == pytest.approx(0.01 / 3)
    assert real.real_weighted_absorption({**values, 4000.0: values[4000.0] + 0.03}) == before


def test_means():
    values = {float(band): np.array([0.2, 0.1]) + i / 100 for i, band in enumerate(rt.THIRD_OCTAVES)}
    first = {band: float(value[0]) for band, value in values.items()}
    assert abs(real.real_noise_reduction(values)[0] - rt.noise_reduction_coefficient(first)) <= 0.025 + 1e-9
    assert real.real_absorption_average(values)[0] == pytest.approx(
        rt.sound_absorption_average(first), abs=0.005 + 1e-9
    )
