"""Errors of known laws as functions at the effects' places: how large they may be, and what they are good for."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.fitting import Fitted, at_minimum, minimise_scaled, polish_fits
from multilayer.diagnosis.goodness_of_fit import law_p_value, size_p_value
from multilayer.diagnosis.law_errors import with_errors_at_places
from multilayer.inference.derivative import central
from multilayer.testing.benches import joint_bench


def hypothesis_with(*sizes):
    """Return the bench with effects, given as (name, coordinates of its parameters), and all coordinates."""
    bench = joint_bench()
    effects = [EFFECTS[name]() for name, _ in sizes]
    values = [value for _, each in sizes for value in each]
    return bench.with_effects(*effects), np.concatenate([np.zeros(len(bench.parameters)), values])


def test_an_error_is_a_share_of_the_law_at_its_place():
    gain = 0.04
    effect = EFFECTS["channel_gain"]()
    hypothesis, z = hypothesis_with(("channel_gain", [float(effect.parameters[0].prior.coordinate(gain))]))
    placed, at = with_errors_at_places(hypothesis, z)
    (_, error) = placed.effects
    # the reading changes by 1 + law; what the gain adds is g/(1 + g) of it, at all frequencies
    assert error.size == pytest.approx(effect.law_error * gain / (1 + gain), rel=1e-3)
    assert (error.place, placed.names) == ("reading", ("channel_gain",))
    assert placed.law_errors == (0.0, 0.0)
    assert hypothesis.law_errors == (effect.law_error,)
    assert placed.residual(at) == pytest.approx(hypothesis.residual(z))


def test_a_size_is_as_uncertain_as_its_law_leaves_it_beside_its_statistical_error():
    hypothesis, z = hypothesis_with(("sensor_mass", [0.3, 0.5]))
    fitted = Fitted(hypothesis, hypothesis.as_minimum(z))
    reach = 1.6449  # of a 90 % interval, standard deviations
    for name, size_error in (("mass", 0.01), ("bending", 0.15)):
        index = [parameter.name for parameter in hypothesis.parameters].index(f"sensor_mass.{name}")
        prior = hypothesis.parameters[index].prior
        statistical = prior.slope(z[index]) * np.sqrt(fitted.minimum.covariance[index, index])
        value, low, high = fitted.interval(f"sensor_mass.{name}")
        spread = np.log(high / low) / 2 / reach if prior.is_logarithmic else (high - low) / 2 / reach
        of_size = size_error if prior.is_logarithmic else size_error * value
        assert spread == pytest.approx(np.hypot(statistical, of_size), rel=1e-3)


def test_an_error_follows_the_law_over_frequency():
    hypothesis, z = hypothesis_with(("channel_delay", [1.0]))
    error = with_errors_at_places(hypothesis, z)[0].effects[1]
    # a delay grows in proportion to frequency, and so does its error, without a kink
    slope = np.diff(np.log(error.size)) / np.diff(error.nodes)
    assert slope == pytest.approx(np.full(len(slope), slope[0]))
    assert slope[0] == pytest.approx(1.0, abs=0.15)


def test_of_two_effects_each_has_its_error_and_bare_takes_both_away():
    hypothesis, z = hypothesis_with(("channel_gain", [1.0]), ("crosstalk", [1.0, 0.5]))
    placed, at = with_errors_at_places(hypothesis, z)
    assert [effect.error_of for effect in placed.effects] == ["", "channel_gain", "", "crosstalk"]
    back, coordinates = placed.bare(at)
    assert back.names == hypothesis.names
    assert coordinates == pytest.approx(z)


def test_a_single_configuration_holds_no_error_at_a_place():
    hypothesis, z = hypothesis_with(("channel_gain", [1.0]))
    assert len(hypothesis.data) > 1
    assert with_errors_at_places(hypothesis, z) is not None
    assert with_errors_at_places(hypothesis.with_data(hypothesis.data[:1]), z) is None


def test_without_an_effect_there_is_no_error():
    assert with_errors_at_places(joint_bench(), np.zeros(len(joint_bench().parameters))) is None


def test_the_derivative_by_the_errors_is_that_of_finite_differences():
    placed, at = with_errors_at_places(*hypothesis_with(("crosstalk", [1.0, 0.5])))
    at = at + 0.1 * np.random.default_rng(0).standard_normal(at.size)
    jacobian, slopes = placed.linearised(at)[1], central(placed.residual, at)[1]
    assert np.max(np.abs(jacobian - slopes)) < 1e-4 * np.max(np.abs(slopes))


FAULT = 0.1  # share of crosstalk: -20 dB, 3.3 standard deviations of its prior


def crosstalk_as_a_power(exponent, share):
    """Return the bench with data that a crosstalk as a power of i f makes, and the effect at rest."""
    hypothesis, z = hypothesis_with(("crosstalk", [0.0, 0.0]))
    read = []
    for data, difference in zip(hypothesis.data, hypothesis.differences(z), strict=True):
        motion = np.exp(data.target + difference)  # of the model
        law = share * (1j * data.frequency / 500.0) ** exponent
        read.append(replace(data, ratio=motion + law))
    return hypothesis.with_data(read), z


@pytest.mark.parametrize(("share", "gain"), [(FAULT, 5.0), (2 * FAULT, 10.0)])
def test_a_law_that_is_wrong_alike_everywhere_is_named_as_well_as_an_exact_one(share, gain):
    """To first order such an error is as large as the data; at its place it is small."""
    hypothesis, z = crosstalk_as_a_power(0.15, share)
    start = np.concatenate([z[:-2], [share / 0.03, 0.0]])
    to_first_order = at_minimum(hypothesis, start)
    (polished,) = polish_fits({0: to_first_order}).values()
    assert polished.log_evidence > to_first_order.log_evidence + gain
    assert polished.errors is None
    assert law_p_value(polished) > 1e-3
    assert (size_p_value(polished) > 1e-3) == (share <= FAULT)  # -14 dB is more than anybody has seen
    error = polished.hypothesis.effects[1]
    values = dict(zip([p.name for p in polished.hypothesis.parameters], polished.minimum.z, strict=True))
    f = np.geomspace(150, 900, 5)
    constant = 0.03 * values["crosstalk.share"] + 0.01j * values["crosstalk.capacitive"] * f / 1000.0
    drawn = error.drawn(np.array([values[f"{error.name}.{p.name}"] for p in error.parameters]), f)
    assert constant + drawn == pytest.approx(share * (1j * f / 500.0) ** 0.15, rel=0.05)


def test_an_exact_law_needs_no_errors():
    hypothesis, z = crosstalk_as_a_power(0.0, 2 * FAULT)
    start = np.concatenate([z[:-2], [2 * FAULT / 0.03, 0.0]])
    (polished,) = polish_fits({0: Fitted(hypothesis, minimise_scaled(hypothesis, start))}).values()
    assert polished.hypothesis.effects == hypothesis.effects
