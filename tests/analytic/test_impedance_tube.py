"""Impedance tubes in closed form: pressures made of a stack's plane waves give the stack back."""

import numpy as np
import pytest
from scipy.signal import lfilter

from multilayer.media.gas import dry_air
from multilayer.response import plane_wave
from multilayer.signals.impedance_tube import (
    FaceState,
    cut_off,
    face_state,
    iso_attenuation,
    kirchhoff_attenuation,
    matrix_transmission,
    normalised_impedance,
    one_load_matrix,
    reflection_coefficient,
    rigid_backed_reflection,
    spacing_range,
    switched_calibration,
    transfer_function,
    transfer_functions,
    two_load_matrix,
)
from multilayer.stack import Stack

FREQUENCY = np.linspace(120.0, 3000.0, 97)
FOAM = {
    "type": "equivalent_fluid", "thickness": 0.04, "porosity": 0.97, "flow_resistivity": 12e3, "tortuosity": 1.3,
    "viscous_length": 80e-6, "thermal_length": 200e-6,
}  # fmt: skip
SCREEN = {"type": "elastic_plate", "thickness": 1e-4, "density": 1200, "young_modulus": 2e9, "poisson_ratio": 0.3}
SYMMETRIC, ASYMMETRIC = [FOAM], [SCREEN, FOAM, {**FOAM, "thickness": 0.02, "flow_resistivity": 40e3}]
POSITIONS = (-0.15, -0.105, 0.17, 0.215)
GAS = dry_air()


def stack(layers, termination="rigid"):
    return Stack.model_validate({"layers": layers, "termination": termination})


def wavenumber(loss=0.0):
    return 2 * np.pi * FREQUENCY / GAS.sound_speed - 1j * loss


def thickness(layers):
    return sum(layer["thickness"] for layer in layers)


def pressures(layers, cavity, loss=0.0, *, positions=POSITIONS):
    """Return the four pressures in a tube that ends in a wall behind the sample and a cavity of air.

    Only plane waves through the sample with air on both sides are used, from its front and, turned round, from its
    back: what returns from the wall meets the back face again and again.
    """
    k, d = wavenumber(loss), thickness(layers)
    front = plane_wave(stack(layers, "ambient"), FREQUENCY)
    back = plane_wave(stack(layers[::-1], "ambient"), FREQUENCY)
    # the wave that returns from the wall, at the back face, over the one that leaves the back face
    wall = np.exp(-2j * k * cavity)
    outgoing = front.transmission / (1 - back.reflection * wall)
    reflection = front.reflection + back.transmission * wall * outgoing
    ahead = [np.exp(-1j * k * x) + reflection * np.exp(1j * k * x) for x in positions[:2]]
    behind = [outgoing * (np.exp(-1j * k * (x - d)) + wall * np.exp(1j * k * (x - d))) for x in positions[2:]]
    return (*ahead, *behind), reflection


def state(layers, cavity, loss=0.0):
    return face_state(pressures(layers, cavity, loss)[0], POSITIONS, wavenumber(loss), GAS.impedance, thickness(layers))


@pytest.mark.parametrize("loss", [0.0, 0.3])
@pytest.mark.parametrize("layers", [SYMMETRIC, ASYMMETRIC])
def test_two_microphones_give_the_reflection(layers, loss):
    """Also behind a tube with losses: they are those of the way to the sample and back."""
    exact = plane_wave(stack(layers), FREQUENCY)
    h12 = transfer_function(exact.reflection, wavenumber(loss), 0.1, 0.145)
    found = reflection_coefficient(h12, wavenumber(loss), 0.045, 0.145)
    np.testing.assert_allclose(found, exact.reflection, rtol=0, atol=1e-9)
    np.testing.assert_allclose(normalised_impedance(found), exact.surface_impedance / GAS.impedance, rtol=1e-9)
    if loss:
        without = reflection_coefficient(h12, wavenumber(), 0.045, 0.145)
        assert np.abs(without - exact.reflection).max() > 0.03


def test_exchanged_microphones_remove_their_mismatch():
    exact = plane_wave(stack(ASYMMETRIC), FREQUENCY).reflection
    h12 = transfer_function(exact, wavenumber(), 0.1, 0.145)
    mismatch = 1.3 * np.exp(-0.4j) * (1 + 1j * FREQUENCY / 8e3)
    factor = switched_calibration(mismatch * h12, mismatch / h12)
    np.testing.assert_allclose(factor, mismatch, rtol=1e-12)
    found = reflection_coefficient(mismatch * h12 / factor, wavenumber(), 0.045, 0.145)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-9)
    uncalibrated = reflection_coefficient(mismatch * h12, wavenumber(), 0.045, 0.145)
    assert np.abs(uncalibrated - exact).max() > 0.1


def test_the_tube_made_here_is_that_of_a_stack_with_a_cavity():
    """The cavity as a layer of the stack gives the same reflection as the waves that `pressures` puts together."""
    air = {"type": "fluid", "thickness": 0.07, "density": GAS.density, "sound_speed": GAS.sound_speed}
    whole = plane_wave(stack([*ASYMMETRIC, air]), FREQUENCY).reflection
    np.testing.assert_allclose(pressures(ASYMMETRIC, 0.07)[1], whole, rtol=0, atol=1e-10)


@pytest.mark.parametrize("layers", [SYMMETRIC, ASYMMETRIC])
def test_two_loads_give_transfer_matrix_and_transmission_loss(layers):
    matrix = two_load_matrix(state(layers, 0.4), state(layers, 0.47))
    exact = _matrix_of(layers)
    for name, value in matrix._asdict().items():
        np.testing.assert_allclose(value, exact[name], rtol=1e-8, err_msg=name)
    np.testing.assert_allclose(matrix.t11 * matrix.t22 - matrix.t12 * matrix.t21, 1, rtol=1e-8)
    anechoic, rigid = plane_wave(stack(layers, "ambient"), FREQUENCY), plane_wave(stack(layers), FREQUENCY)
    transmission, reflection = matrix_transmission(matrix, GAS.impedance)
    np.testing.assert_allclose(transmission, anechoic.transmission, rtol=1e-9)
    np.testing.assert_allclose(reflection, anechoic.reflection, rtol=0, atol=1e-9)
    np.testing.assert_allclose(-20 * np.log10(np.abs(transmission)), anechoic.transmission_loss, rtol=0, atol=1e-8)
    np.testing.assert_allclose(rigid_backed_reflection(matrix, GAS.impedance), rigid.reflection, rtol=0, atol=1e-9)


def _matrix_of(layers):
    """Return the transfer matrix of a stack of fluids and thin plates from waves through it both ways."""
    front = plane_wave(stack(layers, "ambient"), FREQUENCY)
    back = plane_wave(stack(layers[::-1], "ambient"), FREQUENCY)
    z, r, t, q = GAS.impedance, front.reflection, front.transmission, back.reflection
    # p = 1 + r, z v = 1 - r in front of p = z v = t; and the same from behind
    return {
        "t11": ((1 + r) * (1 - q) + t * t) / (2 * t), "t12": z * ((1 + r) * (1 + q) - t * t) / (2 * t),
        "t21": ((1 - r) * (1 - q) - t * t) / (2 * t * z), "t22": ((1 - r) * (1 + q) + t * t) / (2 * t),
    }  # fmt: skip


def test_a_wall_that_an_elastic_frame_does_not_touch_lets_it_move():
    """Air at rest behind the sample is a thin layer of air ahead of the wall; the wall itself holds the frame."""
    foam = {
        "type": "poroelastic", "thickness": 0.05, "porosity": 0.97, "flow_resistivity": 5e4, "tortuosity": 1.5,
        "viscous_length": 1e-4, "thermal_length": 2e-4, "frame_density": 30, "young_modulus": 8e4,
        "poisson_ratio": 0.3, "loss_factor": 0.1,
    }  # fmt: skip
    loads = [state([foam], cavity) for cavity in (0.4, 0.47)]
    found = 1 - np.abs(rigid_backed_reflection(two_load_matrix(*loads), GAS.impedance)) ** 2
    air = {"type": "fluid", "thickness": 1e-6}
    np.testing.assert_allclose(found, plane_wave(stack([foam, air]), FREQUENCY).absorption, rtol=0, atol=1e-4)
    i = int(np.argmin(np.abs(FREQUENCY - 300)))
    assert (found[i], plane_wave(stack([foam]), FREQUENCY).absorption[i]) == pytest.approx((0.57, 0.21), abs=0.01)


def test_one_load_does_for_a_sample_that_is_the_same_from_both_sides():
    two = two_load_matrix(state(SYMMETRIC, 0.4), state(SYMMETRIC, 0.47))
    one = one_load_matrix(state(SYMMETRIC, 0.4))
    for a, b in zip(one, two, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-7)
    off = one_load_matrix(state(ASYMMETRIC, 0.4))
    assert np.abs(off.t11 / two_load_matrix(state(ASYMMETRIC, 0.4), state(ASYMMETRIC, 0.47)).t11 - 1).max() > 0.05


def test_losses_along_the_tube_are_taken_out():
    loss = iso_attenuation(FREQUENCY, GAS.sound_speed, 0.04)
    matrix = two_load_matrix(state(ASYMMETRIC, 0.4, loss), state(ASYMMETRIC, 0.47, loss))
    transmission, _ = matrix_transmission(matrix, GAS.impedance)
    np.testing.assert_allclose(
        transmission, plane_wave(stack(ASYMMETRIC, "ambient"), FREQUENCY).transmission, rtol=1e-9
    )


def test_layers_of_gas_are_their_own_transfer_matrix():
    """A sample of air: cos, i Z sin, of its thickness; no phase through it is left in the transmission of a stack."""
    k, d, z = wavenumber(), 0.05, GAS.impedance
    one, two = (
        FaceState(np.ones_like(k), (1 - r) / (1 + r) / z, p / (1 + r), v / (1 + r) / z)
        for r, p, v in _air(k, d, (0.3, 0.8j))
    )
    matrix = two_load_matrix(one, two)
    np.testing.assert_allclose(matrix.t11, np.cos(k * d), atol=1e-12)
    np.testing.assert_allclose(matrix.t12, 1j * z * np.sin(k * d), atol=1e-9)
    np.testing.assert_allclose(matrix_transmission(matrix, z)[0], np.exp(-1j * k * d), rtol=1e-10)


def _air(k, d, ends):
    turn = np.exp(-1j * k * d)
    return [(end * turn**2, turn * (1 + end), turn * (1 - end)) for end in ends]


class TestLimits:
    def test_cut_off_of_a_100_mm_tube(self):
        assert cut_off(343.2, 0.1) == pytest.approx(1991, abs=1)
        assert cut_off(343.2, 0.1, rectangular=True) == pytest.approx(1716, abs=1)

    def test_spacing(self):
        assert spacing_range(343.2, 0.05) == pytest.approx((343.2, 3088.8))
        assert spacing_range(343.2, 0.05, e2611=True) == pytest.approx((68.64, 2745.6))

    def test_attenuation_of_iso_is_near_that_of_theory(self):
        iso = iso_attenuation(FREQUENCY, GAS.sound_speed, 0.1)
        theory = kirchhoff_attenuation(FREQUENCY, GAS, 0.1)
        assert iso / theory == pytest.approx(0.955, abs=0.02)
        assert iso[0] == pytest.approx(0.0194 * np.sqrt(120) / (343.2 * 0.1), rel=1e-3)


class TestSpectra:
    def test_a_filter_between_two_channels(self):
        """A first-order low pass: its transfer function in closed form, from twenty seconds of noise."""
        rate = 8192.0
        source = np.random.default_rng(0).standard_normal(int(20 * rate))
        signals = np.stack([source, lfilter([0.3], [1, -0.7], source)])
        frequency, functions, coherence = transfer_functions(signals, rate, 0.25)
        exact = 0.3 / (1 - 0.7 * np.exp(-2j * np.pi * frequency / rate))
        assert frequency[0] == pytest.approx(4.0)
        np.testing.assert_allclose(functions[0], 1, rtol=1e-14)
        np.testing.assert_allclose(functions[1], exact, rtol=0.01)
        assert coherence.min() > 0.99

    def test_noise_of_a_microphone_lowers_the_coherence(self):
        rng = np.random.default_rng(1)
        source = rng.standard_normal(100_000)
        signals = np.stack([source, source + rng.standard_normal(source.size)])
        assert np.median(transfer_functions(signals, 8192.0, 0.05)[2][1]) == pytest.approx(0.5, abs=0.05)
