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


@pytest.mark.parametrize("name", ["relaxation", "power", "resonance"])
def test_laws_that_run_backwards_are_not(name):
    assert p_value(LAWS[name].conj()) < 0.001


@pytest.mark.parametrize(("sign", "imag", "told"), [(1, 0.1, True), (1, -0.1, False), (-1, -0.1, True), (0, 0.1, None)])
def test_passivity_is_the_sign_of_the_imaginary_part(sign, imag, told):
    fit = SimpleNamespace(
        place=SimpleNamespace(passive_sign=sign),
        band=lambda deviations: (1 + 1j * (imag - 0.01 * deviations), 1 + 1j * (imag + 0.01 * deviations)),
    )
    assert is_passive(fit) is told


def test_a_law_within_its_uncertainty_of_passive_is_passive():
    fit = SimpleNamespace(
        place=SimpleNamespace(passive_sign=1), band=lambda d: (-0.02j - 0.01j * d, -0.02j + 0.01j * d)
    )
    assert is_passive(fit)
