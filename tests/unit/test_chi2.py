"""Probabilities of chi-square."""

import pytest
from scipy.stats import chi2

from multilayer.chi2 import exceeded, exceeding


@pytest.mark.parametrize(("chi_square", "degrees"), [(0.3, 1), (70.0, 50), (9.0, 2.5), (250.2, 300), (1e6, 432)])
def test_as_the_distribution_has_it(chi_square, degrees):
    assert exceeding(chi_square, degrees) == pytest.approx(chi2.sf(chi_square, degrees), rel=1e-12, abs=1e-300)


def test_nothing_is_exceeded_by_less_than_nothing():
    assert exceeding(-1e-17, 3) == exceeding(0.0, 3) == 1.0


@pytest.mark.parametrize(("probability", "degrees"), [(0.1, 1), (0.0027, 168), (1e-6, 40)])
def test_the_value_exceeded_is_the_quantile(probability, degrees):
    assert exceeded(probability, degrees) == pytest.approx(chi2.isf(probability, degrees), rel=1e-12)
    assert exceeding(exceeded(probability, degrees), degrees) == pytest.approx(probability, rel=1e-9)
