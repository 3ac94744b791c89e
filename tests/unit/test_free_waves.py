"""Free waves along a stack against thin plates, Lamb's, sandwiches of Ross, Kerwin & Ungar, and losses by layer."""

import numpy as np
import pytest
from scipy.optimize import brentq

from multilayer.errors import InputError
from multilayer.response.free_waves import free_waves
from multilayer.stack import Stack

F = np.array([50.0, 200.0, 1000.0, 4000.0])
OMEGA = 2 * np.pi * F
STEEL = {"density": 7800.0, "young_modulus": 2.1e11, "poisson_ratio": 0.3}
PLANE = 2.1e11 / (1 - 0.3**2)


def stack(*layers: dict[str, object], termination: str = "ambient") -> Stack:
    return Stack(layers=layers, termination=termination)


@pytest.mark.parametrize("loss", [0.0, 0.01, 0.3])
def test_a_thin_plate(loss: float) -> None:
    plate = stack({"type": "elastic_plate", "thickness": 1e-3, "loss_factor": loss, **STEEL})
    found = free_waves(plate, F)
    stiffness = PLANE * 1e-9 / 12
    exact = (OMEGA**2 * 7.8 / (stiffness * (1 + 1j * loss))) ** 0.25
    np.testing.assert_allclose(found.wavenumber, exact, rtol=1e-9)
    assert found.mass == pytest.approx(7.8, rel=1e-9)
    np.testing.assert_allclose(found.group_speed, 2 * OMEGA / exact.real * np.cos(np.angle(exact)) ** 2, rtol=1e-6)
    if loss < 0.1:
        np.testing.assert_allclose(found.bending_stiffness, stiffness, rtol=1e-4)
        np.testing.assert_allclose(found.loss_factor, loss, rtol=1e-3, atol=1e-9)
    else:  # the loss of the modulus as an angle: 2 sin(angle/2)
        np.testing.assert_allclose(found.loss_factor, 2 * np.sin(np.arctan(loss) / 2), rtol=1e-4)
    np.testing.assert_allclose(found.layer_loss_factors[0], found.loss_factor, atol=1e-12)


def test_a_thick_solid_has_the_first_antisymmetric_wave_of_lamb() -> None:
    h = 0.05
    found = free_waves(stack({"type": "elastic_solid", "thickness": h, **STEEL}), np.array([200.0, 5e3, 40e3, 130e3]))
    mu = 2.1e11 / 2.6
    shear, compression = np.sqrt(mu / 7800), np.sqrt(mu * 2 * 0.7 / 0.4 / 7800)

    def antisymmetric(k: float, omega: float) -> float:
        # H. Lamb 1917; below the speed of shear waves, by hyperbolic functions
        p, q = np.sqrt(k**2 - (omega / compression) ** 2), np.sqrt(k**2 - (omega / shear) ** 2)
        return float((q**2 + k**2) ** 2 * np.tanh(p * h / 2) - 4 * k**2 * p * q * np.tanh(q * h / 2))

    for i, f in enumerate(found.frequency[:3]):
        omega = 2 * np.pi * f
        exact = brentq(antisymmetric, 1.0001 * omega / shear, 60 * omega / shear, args=(omega,), xtol=1e-13)
        assert found.wavenumber[i].real == pytest.approx(exact, rel=1e-8)
        assert abs(found.wavenumber[i].imag) < 1e-8 * exact
    # in the end Rayleigh's wave, 0.927 of the speed of shear waves
    assert found.phase_speed[-1] / shear == pytest.approx(0.9274, rel=5e-3)


@pytest.mark.parametrize("shear", [3e5, 3e6])
def test_a_constrained_layer(shear: float) -> None:
    # D. Ross, E. E. Ungar & E. M. Kerwin 1959: D1 + D3 + d^2 S g/(1 + g), g = G/(S h2 k^2)
    loss, thickness = 0.1, 1e-3
    face = {"type": "elastic_solid", "thickness": 1e-3, **STEEL}
    core = {
        "type": "elastic_solid", "name": "core", "thickness": thickness, "density": 1000.0, "poisson_ratio": 0.49,
        "young_modulus": 2 * 1.49 * shear, "loss_factor": loss,
    }  # fmt: skip
    frequency = np.array([50.0, 200.0, 800.0])
    found = free_waves(stack(face, core, face), frequency)
    k = found.wavenumber.real
    series = PLANE * 0.5e-3
    g = shear * (1 + 1j * loss) / (series * thickness * k**2)
    expected = PLANE * 2e-9 / 12 + (thickness + 1e-3) ** 2 * series * g / (1 + g)
    assert found.mass == pytest.approx(2 * 7.8 + 1.0, rel=1e-5)
    np.testing.assert_allclose(found.bending_stiffness, expected.real, rtol=0.01)
    np.testing.assert_allclose(found.loss_factor, expected.imag / expected.real, rtol=0.02)
    # all of it comes from the core
    np.testing.assert_allclose(found.layer_loss_factors[1], found.loss_factor, rtol=1e-6)
    np.testing.assert_allclose(found.layer_loss_factors[[0, 2]], 0, atol=1e-6)


def test_losses_are_divided_by_the_work_of_bending() -> None:
    # two plates that slide on each other: each bends by itself, stiffnesses and losses add up
    layers = [
        {"type": "elastic_plate", "thickness": h, "loss_factor": loss, **STEEL}
        for h, loss in ((1e-3, 0.01), (2e-3, 0.02))
    ]
    found = free_waves(stack(*layers), F)
    np.testing.assert_allclose(found.bending_stiffness, PLANE * 9e-9 / 12, rtol=1e-3)
    np.testing.assert_allclose(found.layer_loss_factors[0], 0.01 / 9, rtol=1e-3)
    np.testing.assert_allclose(found.layer_loss_factors[1], 0.02 * 8 / 9, rtol=1e-3)
    assert found.layers == ("0", "1")


def test_a_layer_of_air_on_a_wall_has_no_free_wave() -> None:
    # slower than sound it is a mass, whatever the wavelength
    with pytest.raises(InputError, match="no wave"):
        free_waves(stack({"type": "fluid", "thickness": 0.01}, termination="rigid"), 100.0)


def test_about_the_resonance_of_a_plate_on_a_foam_no_wave_runs() -> None:
    foam = {
        "type": "elastic_solid", "thickness": 0.025, "density": 30.0, "young_modulus": 1.5e5, "poisson_ratio": 0.3,
        "loss_factor": 0.3,
    }  # fmt: skip
    plate = {"type": "elastic_solid", "thickness": 1e-3, "loss_factor": 1e-3, **STEEL}
    frequency = np.geomspace(20, 2000, 60)
    found = free_waves(stack(plate, foam, plate), frequency)
    runs = np.isfinite(found.wavenumber)
    assert runs[0]
    assert runs[-1]
    assert np.all(found.group_speed[runs] > 0)
    assert np.all(found.loss_factor[runs] > 0)
    # far above, each plate bends by itself
    assert found.bending_stiffness[-1] == pytest.approx(2 * PLANE * 1e-9 / 12, rel=0.1)
    # losses are those of the foam, and where it slides, at that of the plates' own too
    np.testing.assert_allclose(found.layer_loss_factors[:, runs].sum(axis=0), found.loss_factor[runs], rtol=1e-9)


def test_what_cannot_be_answered() -> None:
    plate = {
        "type": "orthotropic_plate", "thickness": 1e-3, "density": 7800.0, "young_modulus_x": 2e11,
        "young_modulus_y": 5e10, "poisson_ratio_xy": 0.3, "shear_modulus_xy": 3e10,
    }  # fmt: skip
    with pytest.raises(InputError, match="direction"):
        free_waves(stack(plate), F)
    with pytest.raises(InputError, match="above 0"):
        free_waves(stack({"type": "elastic_plate", "thickness": 1e-3, **STEEL}), [0.0])


def test_a_plate_over_a_wall_keeps_its_mass() -> None:
    # on a layer of air, which holds on to it: slower than sound another mass, rho/k coth(k h)
    plate = {"type": "elastic_plate", "thickness": 1e-3, "loss_factor": 0.01, **STEEL}
    over_air = stack(plate, {"type": "fluid", "thickness": 0.01}, termination="rigid")
    found = free_waves(over_air, [50.0])
    assert found.mass == pytest.approx(7.8 + 0.01 * over_air.ambient.gas.density, rel=1e-3)
    omega, gas = 2 * np.pi * 50.0, over_air.ambient.gas

    def reactance(k: float) -> float:
        decay = np.sqrt(k**2 - (omega / gas.sound_speed) ** 2)
        return float(
            omega * 7.8 - PLANE * 1e-9 / 12 * k**4 / omega + omega * gas.density / decay / np.tanh(decay * 0.01)
        )

    assert found.wavenumber[0].real == pytest.approx(brentq(reactance, 5.0, 100.0), rel=1e-4)


@pytest.mark.parametrize("model", ["miki", "delany_bazley"])
def test_the_mass_is_that_of_the_layers_whatever_the_frequencies(model: str) -> None:
    # power laws say nothing far below their range: neither the stiffness nor a warning may come from there
    plate = {"type": "elastic_plate", "thickness": 1e-3, "loss_factor": 0.01, **STEEL}
    wool = {"type": "equivalent_fluid", "model": model, "thickness": 0.05, "flow_resistivity": 1e4}
    lined = stack(plate, wool)
    for frequency in ([100.0, 500.0], [500.0, 2000.0]):
        found = free_waves(lined, np.array(frequency))
        assert found.mass == pytest.approx(7.8 + 0.05 * lined.ambient.gas.density, rel=1e-9)
        np.testing.assert_allclose(found.bending_stiffness, PLANE * 1e-9 / 12, rtol=0.02)


def test_the_mass_of_a_pattern_is_that_of_its_layers() -> None:
    plate = {"type": "elastic_plate", "thickness": 1e-3, **STEEL}
    wool = {"type": "equivalent_fluid", "model": "miki", "thickness": 0.02, "flow_resistivity": 1e4}
    heavy = {"type": "membrane", "surface_density": 2.0}
    pattern = {"type": "patches", "period": 0.01, "patches": [
        {"share": 0.75, "layers": [wool]}, {"share": 0.25, "layers": [wool, heavy]},
    ]}  # fmt: skip
    found = free_waves(stack(plate, pattern), [200.0])
    assert found.mass == pytest.approx(7.8 + 0.5, rel=0.01)


def test_a_layer_that_tells_no_mass_has_that_of_slow_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    plate = stack({"type": "elastic_plate", "thickness": 1e-3, **STEEL})
    monkeypatch.setattr(type(plate.layers[0]), "mass_per_area", None)
    assert free_waves(plate, F).mass == pytest.approx(7.8, rel=1e-9)
