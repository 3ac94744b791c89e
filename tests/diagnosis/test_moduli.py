"""The modulus as what explains a gap corrects it, and how certain it is."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import norm

from multilayer.diagnosis import moduli as module
from multilayer.diagnosis.moduli import moduli
from multilayer.diagnosis.places import PLACES
from multilayer.experiments.places import DrawnLaw, Term
from tests.diagnosis.rigs import measured


@pytest.fixture(scope="module")
def nominal():
    return measured((PLACES["reading"](), Term("power"), [0.001]))


def logarithms(told, name):
    return [np.log(told[name][f"E1{end}"]) for end in ("", "_low", "_high")]


def test_intervals_of_rivals_are_those_of_their_mixture(nominal):
    other = replace(nominal, minimum=replace(nominal.minimum, z=nominal.minimum.z + 0.3))
    weights = (0.7, 0.2)
    told = moduli(nominal, [*zip(weights, (nominal, other), strict=True)])
    alone = [logarithms(moduli(nominal, [(1.0, fitted)]), "corrected") for fitted in (nominal, other)]
    normals = [(value[7], (high[7] - low[7]) / (2 * 1.6448536)) for value, low, high in alone]

    def below(x):
        shares = [w * norm.cdf((x - mean) / spread) for w, (mean, spread) in zip(weights, normals, strict=True)]
        return sum(shares) / sum(weights)

    value, low, high = (part[7] for part in logarithms(told, "corrected"))
    assert value == pytest.approx(normals[0][0], rel=1e-12)  # that of the first
    assert low == pytest.approx(brentq(lambda x: below(x) - 0.05, 0.0, 30.0, xtol=1e-12), abs=1e-9)
    assert high == pytest.approx(brentq(lambda x: below(x) - 0.95, 0.0, 30.0, xtol=1e-12), abs=1e-9)


def test_a_rival_without_a_logarithm_counts_for_nothing(nominal, monkeypatch):
    other = replace(nominal, minimum=replace(nominal.minimum, z=nominal.minimum.z + 0.3))
    alone = moduli(nominal, [(1.0, nominal)])["corrected"]
    plain = module._logarithms

    def negative(fitted, frequency):
        e1, e2 = plain(fitted, frequency)
        return [e1, (np.full_like(e2[0], np.nan), e2[1])] if fitted is other else [e1, e2]

    monkeypatch.setattr(module, "_logarithms", negative)
    told = moduli(nominal, [(0.9, nominal), (0.06, other)])["corrected"]
    for key in ("E2", "E2_low", "E2_high"):
        np.testing.assert_allclose(told[key], alone[key], rtol=1e-9)


def test_a_misfit_widens_the_intervals(nominal):
    residual = nominal.minimum.residual * 3.0
    worse = replace(nominal, minimum=replace(nominal.minimum, residual=residual))
    widths = []
    for fitted in (nominal, worse):
        _, low, high = logarithms(moduli(fitted, [(1.0, fitted)]), "nominal")
        widths.append(high - low)
    ratio = np.sqrt(worse.minimum.cost / len(residual))
    assert ratio > 1.5
    np.testing.assert_allclose(widths[1] / widths[0], ratio, rtol=1e-9)


def test_nothing_is_told_where_nothing_explains_the_gap(nominal):
    told = moduli(nominal, [])
    assert np.all(np.isnan([told["corrected"][key] for key in told["nominal"]]))
    assert np.all(np.isfinite(told["nominal"]["E2_high"]))


def test_the_modulus_of_samples_that_differ_is_their_mean():
    nominal = measured((PLACES["reading"](), Term("power"), [0.001]))
    names = [data.name for data in nominal.hypothesis.data]
    factors = dict(zip(names, np.linspace(-1.0, 2.0, len(names)), strict=True))
    f = np.array([100.0, 1000.0])
    laws = [DrawnLaw.at(PLACES["sample"](), f, 0.1), DrawnLaw.at(PLACES["sample"]().differing(factors=factors), f, 0.1)]
    alike, differing = (nominal.hypothesis.with_effects(law) for law in laws)
    one = laws[0].constant(1.0 + 0.2j)
    z = nominal.minimum.z
    expected = alike.own_modulus(np.append(z, 0.5 * one), f)
    np.testing.assert_allclose(differing.own_modulus(np.append(z, one), f), expected, rtol=1e-12)
