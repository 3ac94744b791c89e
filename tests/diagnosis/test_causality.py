"""Causality and passivity of drawn laws."""

from types import SimpleNamespace

import numpy as np
import pytest

from multilayer.diagnosis.causality import causal_p_value, is_passive

F = np.geomspace(90.0, 1600.0, 12)
S = 1j * F / 400.0
LAWS = {
    "constant": 1 + 0 * S,
    "relaxation": 1 / (1 + S),
    "power": S**0.3,
    "damper": S,
    "resonance": 1 / (1 - (F / 500) ** 2 / (1 + 0.8j)),
}


def p_value(law, error=0.02):
    rng = np.random.default_rng(0)
    noise = error * (rng.standard_normal(F.size) + 1j * rng.standard_normal(F.size))
    return causal_p_value(F, law + noise, error**2 * np.eye(2 * F.size))


@pytest.mark.parametrize("name", LAWS)
def test_causal_laws_are_taken_for_causal(name):
    assert p_value(LAWS[name]) > 0.001


@pytest.mark.parametrize("name", ["relaxation", "resonance"])
def test_laws_that_run_backwards_are_not(name):
    assert p_value(LAWS[name].conj()) < 0.001


@pytest.mark.parametrize(("sign", "imag", "told"), [(1, 0.1, True), (1, -0.1, False), (-1, -0.1, True), (0, 0.1, None)])
def test_passivity_is_the_sign_of_the_imaginary_part(sign, imag, told):
    fit = SimpleNamespace(
        place=SimpleNamespace(passive_sign=sign, passive_part="imag", factors={}),
        drawn=SimpleNamespace(nodes=np.arange(9)),
        departs_from=lambda: None,
        law=lambda: np.ones(3) + 0j,
        band=lambda deviations: (1 + 1j * (imag - 0.01 * deviations), 1 + 1j * (imag + 0.01 * deviations)),
    )
    assert is_passive(fit) is told


@pytest.mark.parametrize(
    ("sign", "real", "told"), [(1, 0.1, True), (1, -0.1, False), (-1, -0.1, True), (-1, 0.1, False)]
)
def test_passivity_of_an_impedance_is_the_sign_of_the_real_part(sign, real, told):
    fit = SimpleNamespace(
        place=SimpleNamespace(passive_sign=sign, passive_part="real", factors={}),
        drawn=SimpleNamespace(nodes=np.arange(9)),
        departs_from=lambda: None,
        law=lambda: np.full(3, real) + 1j,
        band=lambda deviations: (real - 0.01 * deviations + 1j, real + 0.01 * deviations + 1j),
    )
    assert is_passive(fit) is told


def test_a_law_within_its_uncertainty_of_passive_is_passive():
    fit = SimpleNamespace(
        place=SimpleNamespace(passive_sign=1, passive_part="imag", factors={}),
        drawn=SimpleNamespace(nodes=np.arange(9)),
        departs_from=lambda: None,
        law=lambda: np.array([1 - 0.02j]),
        band=lambda d: (1 - 0.02j - 0.01j * d, 1 - 0.02j + 0.01j * d),
    )
    assert is_passive(fit)


def test_nobody_asks_for_the_power_of_a_law_of_both_signs():
    place = SimpleNamespace(passive_sign=1, passive_part="imag", factors={"a": 1.2, "b": -0.1})
    fit = SimpleNamespace(place=place, departs_from=lambda: None, law=lambda: np.array([1.0 - 1j]))
    assert is_passive(fit) is None


def test_nobody_asks_what_is_missing_for_power():
    place = SimpleNamespace(passive_sign=1, passive_part="imag", factors={})
    fit = SimpleNamespace(place=place, departs_from=lambda: None, law=lambda: np.array([-1.0 - 1j]))
    assert is_passive(fit) is None


@pytest.mark.parametrize(
    ("sign", "angle", "told"), [(1, 0.2, True), (1, 0.05, False), (-1, -0.2, True), (-1, 0.0, False)]
)
def test_passivity_of_a_change_is_that_of_what_is_changed(sign, angle, told):
    law = np.full(3, -1 - 0.1j * sign)  # lower, with less losses
    fit = SimpleNamespace(
        place=SimpleNamespace(passive_sign=sign, passive_part="imag", factors={}),
        drawn=SimpleNamespace(nodes=np.arange(9)),
        departs_from=lambda: np.full(3, 11 + 1j * angle),
        law=lambda: law,
        band=lambda deviations: (law - (0.001 + 0.001j) * deviations, law + (0.001 + 0.001j) * deviations),
    )
    assert is_passive(fit) is told


@pytest.mark.parametrize("error", [0.1, 0.03, 0.01])
def test_a_causal_resonance_is_hardly_ever_called_acausal(error):
    rng, law = np.random.default_rng(3), 1 / (1 - (F / 500) ** 2 + 0.3j * F / 500)
    covariance = error**2 * np.eye(2 * F.size)
    draws = error * (rng.standard_normal((40, F.size)) + 1j * rng.standard_normal((40, F.size)))
    assert np.mean([causal_p_value(F, law + draw, covariance) < 0.001 for draw in draws]) <= 0.05
