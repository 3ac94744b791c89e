"""The finite window against limits and against the double integral it replaces."""

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.special import j0

from multilayer.errors import InputError
from multilayer.response import Window, diffuse_field, plane_wave, radiation_impedance
from multilayer.stack import Stack

PANEL = Window(1.4, 1.1)


def test_a_small_panel_is_a_piston() -> None:
    k0 = 1e-3
    found = radiation_impedance(PANEL, k0, 0.0)
    assert found.real == pytest.approx(k0**2 * PANEL.area / (2 * np.pi), rel=1e-5)
    # the mass of a square baffled piston: 0.473 k0 sqrt(S), from the mean of 1/distance over pairs of its points
    square = radiation_impedance(Window(1.0, 1.0), k0, 0.0)
    mean_inverse_distance = 4 / 3 * (1 - np.sqrt(2)) + 4 * np.log(1 + np.sqrt(2))
    assert square.imag == pytest.approx(k0 / (2 * np.pi) * mean_inverse_distance, rel=1e-5)


@pytest.mark.parametrize("angle", [0.0, 30.0, 60.0])
def test_a_large_panel_is_infinite(angle: float) -> None:
    k0 = 2000.0
    found = radiation_impedance(PANEL, k0, k0 * np.sin(np.deg2rad(angle)))
    assert found == pytest.approx(1 / np.cos(np.deg2rad(angle)), abs=0.01)


@pytest.mark.parametrize(("k0", "kt"), [(3.0, 0.0), (5.0, 3.0)])
def test_against_the_integral_over_wavenumbers(k0: float, kt: float) -> None:
    # Villot et al. 2001, eq. (8), with k = k0 sin(t) to take the root away, averaged over the azimuth by a sum
    window = Window(1.2, 0.7)

    def lobe(difference: np.ndarray, length: float) -> np.ndarray:
        return 0.5 * np.sinc(difference * length / (2 * np.pi)) ** 2

    phi = 2 * np.pi * (np.arange(24) + 0.5) / 24

    def integrand(psi: float, t: float) -> float:
        k = k0 * np.sin(t)
        x, y = k * np.cos(psi) - kt * np.cos(phi), k * np.sin(psi) - kt * np.sin(phi)
        return float(np.mean(lobe(x, window.width) * lobe(y, window.height)) * k0 * k)

    value, _ = dblquad(integrand, 0, np.pi / 2, 0, 2 * np.pi, epsrel=1e-4)
    expected = window.area / np.pi**2 * value
    assert radiation_impedance(window, k0, kt).real == pytest.approx(expected, rel=1e-4)


def test_more_nodes_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    k0 = np.array([0.1, 5.0, 100.0])
    first = radiation_impedance(PANEL, k0, 0.9 * k0)
    monkeypatch.setattr("multilayer.response.finite_size._LEAST_PANELS", 9)
    assert first == pytest.approx(radiation_impedance(PANEL, k0, 0.9 * k0), abs=1e-8)


def _fine(window: Window, k0: float, kt: np.ndarray) -> np.ndarray:
    """Return the integral over distance by thousands of nodes, the overlap itself by a sum over directions."""
    # sin^2 takes the kinks of the overlap to the ends, where nodes are dense
    nodes, weights = np.polynomial.legendre.leggauss(40)
    u = np.pi / 2 * (np.arange(60) + 0.5 * (1 + nodes[:, None])).ravel() / 60
    du = np.pi / 2 * np.repeat(0.5 * weights, 60) / 60
    a, b = window.width, window.height
    found = np.zeros(len(kt), dtype=complex)
    diagonal = np.hypot(a, b)
    for low, high in ((0.0, min(a, b)), (min(a, b), max(a, b)), (max(a, b), diagonal)):
        radius, share = low + (high - low) * np.sin(u) ** 2, (high - low) * np.sin(2 * u) * du
        first, last = np.arccos(np.minimum(1, a / radius)), np.arcsin(np.minimum(1, b / radius))
        angle = first + 0.5 * (last - first) * (1 + nodes[:, None])
        overlap = (a - radius * np.cos(angle)) * (b - radius * np.sin(angle))
        overlap = 4 * 0.5 * (last - first) * (weights @ overlap)
        found += j0(kt[:, None] * radius) @ (share * overlap * np.exp(-1j * k0 * radius))
    return 1j * k0 / (2 * np.pi * window.area) * found


@pytest.mark.parametrize("window", [PANEL, Window(1.0, 1.0), Window(8.0, 0.1)])
def test_series_and_single_integrals_are_a_fine_quadrature(window: Window) -> None:
    k0 = np.array([0.02, 1.0, 20.0, 100.0])
    kt = k0[:, None] * np.sqrt(np.linspace(0, 1.2, 150))  # some faster along the panel than the sound in the air
    exact = np.array([_fine(window, *pair) for pair in zip(k0, kt, strict=True)])
    series = radiation_impedance(window, k0[:, None], kt)
    single = np.array([[radiation_impedance(window, k, each) for each in kt[i, ::30]] for i, k in enumerate(k0)])
    for found, expected in ((series, exact), (single, exact[:, ::30])):
        np.testing.assert_allclose(found, expected, rtol=1e-9)
        np.testing.assert_allclose(found.real, expected.real, rtol=1e-8)


def test_many_values_come_in_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    k0 = np.array([[0.5], [30.0]])
    whole = [radiation_impedance(PANEL, k0, k0 * np.linspace(0, 1, n)) for n in (2, 200)]
    monkeypatch.setattr("multilayer.response.finite_size._AT_ONCE", 1)
    pieces = [radiation_impedance(PANEL, k0, k0 * np.linspace(0, 1, n)) for n in (2, 200)]
    for one, other in zip(whole, pieces, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-13)


def test_shapes_of_the_arguments() -> None:
    assert radiation_impedance(PANEL, 3.0, 1.0).shape == ()
    assert radiation_impedance(PANEL, np.ones((4, 1)), np.ones((5, 1, 30))).shape == (5, 4, 30)
    same = radiation_impedance(PANEL, 3.0, np.zeros(99))
    np.testing.assert_allclose(same, radiation_impedance(PANEL, 3.0, 0.0), rtol=1e-14)


PLATE = {"type": "elastic_plate", "thickness": 4e-3, "density": 2500, "young_modulus": 65e9, "poisson_ratio": 0.22}
GLASS = Stack.model_validate({"layers": [{**PLATE, "loss_factor": 0.02}], "termination": "ambient"})


def test_a_finite_panel_transmits_less_at_low_frequencies_and_alike_at_high_ones() -> None:
    frequency = np.array([50.0, 100.0, 8000.0])
    infinite = diffuse_field(GLASS, frequency, 89.0).transmission_loss
    finite = diffuse_field(GLASS, frequency, 89.0, window=PANEL).transmission_loss
    gain = finite - infinite
    assert gain[0] > gain[1] > 3
    assert abs(gain[2]) < 1


def test_a_finite_absorber_absorbs_more_than_an_infinite_one() -> None:
    foam = {
        "type": "poroelastic", "thickness": 0.1, "porosity": 0.98, "flow_resistivity": 15e3, "tortuosity": 1.05,
        "viscous_length": 1e-4, "thermal_length": 2.5e-4, "frame_density": 25, "young_modulus": 140e3,
        "poisson_ratio": 0.3, "loss_factor": 0.1,
    }  # fmt: skip
    stack = Stack.model_validate({"layers": [foam]})
    frequency = np.array([500.0, 8e3])
    infinite = diffuse_field(stack, frequency, 90.0).absorption
    finite = diffuse_field(stack, frequency, 90.0, window=Window(3.6, 3.0)).absorption
    assert finite[0] > infinite[0] + 0.02  # the edge effect of reverberation rooms
    assert finite[1] == pytest.approx(infinite[1], abs=0.03)


def test_sizes_out_of_range() -> None:
    with pytest.raises(InputError, match="above 0"):
        Window(0.0, 1.0)


def _direct(stack: Stack, frequency: np.ndarray, window: Window | None) -> tuple[np.ndarray, np.ndarray]:
    """Return means of absorption and transmission over the half-space, by Gauss's rule over the cosine."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    edges = np.linspace(0, 1, 201) ** 1.5
    width = np.diff(edges)[:, None]
    cosine = (edges[:-1, None] + width * (nodes + 1) / 2).ravel()
    share = (width * weights).ravel() * cosine
    found = plane_wave(stack, frequency, np.rad2deg(np.arccos(cosine)))
    alpha = found.absorption
    tau = 0 * alpha if found.transmission_loss is None else 10 ** (-found.transmission_loss / 10)
    if window is not None:
        k0 = 2 * np.pi * frequency[:, None] / stack.ambient.gas.sound_speed
        radiation = radiation_impedance(window, k0, k0 * np.sqrt(1 - cosine**2))
        surface = found.surface_impedance / stack.ambient.gas.impedance
        alpha, tau = 4 * surface.real / (cosine * np.abs(surface + radiation) ** 2), tau * radiation.real * cosine
    return alpha @ share, tau @ share


FLEECE = {"type": "equivalent_fluid", "model": "miki", "thickness": 0.05, "flow_resistivity": 15e3}


@pytest.mark.parametrize("window", [None, PANEL])
def test_up_to_grazing_incidence(window: Window | None) -> None:
    """Nothing is lost or infinite at 90 degrees, where the absorption of a finite sample is largest."""
    frequency = np.array([200.0, 500.0, 1500.0, 6000.0])
    fleece = Stack.model_validate({"layers": [FLEECE]})
    tight = {"tolerance_db": 1e-5, "tolerance": 2e-6, "max_panels": 400}
    alpha, _ = _direct(fleece, frequency, window)
    np.testing.assert_allclose(diffuse_field(fleece, frequency, 90.0, window=window).absorption, alpha, atol=1e-4)
    found = diffuse_field(fleece, frequency, 90.0, window=window, **tight).absorption
    np.testing.assert_allclose(found, alpha, rtol=0, atol=tight["tolerance"])
    _, tau = _direct(GLASS, frequency, window)
    found = diffuse_field(GLASS, frequency, 90.0, window=window)
    np.testing.assert_allclose(found.transmission_loss, -10 * np.log10(tau), rtol=0, atol=0.01)
    found = diffuse_field(GLASS, frequency, 90.0, window=window, **tight)
    np.testing.assert_allclose(found.transmission_coefficient, tau, rtol=2e-6)


def test_a_window_does_not_move_the_limit_angle() -> None:
    """Without a largest angle of its own it stops at 78 degrees like an infinite panel; 90 leaves nothing out."""
    default, at_78, at_90 = (
        diffuse_field(GLASS, 125.0, *limit, window=PANEL).transmission_loss for limit in ((), (78.0,), (90.0,))
    )
    assert default == at_78
    assert [at_78, at_90] == pytest.approx([19.6, 19.3], abs=0.05)


def test_panels_of_too_many_wavelengths_are_refused_at_once() -> None:
    with pytest.raises(InputError, match=r"finite_size: .* radians of phase across a finite panel are too many"):
        radiation_impedance(Window(1.0, 1e6), np.array([1.0, 90.0]), np.array([0.5, 45.0]))
