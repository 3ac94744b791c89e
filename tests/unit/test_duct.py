"""Lined ducts against spectral collocation, Cremer's optimum and limits by hand."""

import warnings

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize

from multilayer import InputError, Stack
from multilayer.errors import ValidityWarning
from multilayer.matrix.wave import Wave
from multilayer.response import duct_mode, surface_impedance
from multilayer.stack import Ambient

GAS = Ambient().gas
F = np.array([63.0, 500.0, 4000.0])


def lining(*layers, termination="rigid"):
    return Stack(layers=layers, termination=termination)


def wool(thickness, resistivity):
    return {
        "type": "equivalent_fluid",
        "model": "miki",
        "thickness": thickness,
        "flow_resistivity": resistivity,
    }


def collocated(frequency, height, thickness, density, bulk, points=40):
    """Return the wavenumbers of a duct lined by a fluid on one side, the least attenuated first."""

    def differences(length):
        x = np.cos(np.pi * np.arange(points + 1) / points)
        c = np.r_[2.0, np.ones(points - 1), 2.0] * (-1.0) ** np.arange(points + 1)
        apart = x[:, None] - x + np.eye(points + 1)
        d = np.outer(c, 1 / c) / apart
        return -(d - np.diag(d.sum(axis=1))) * 2 / length

    air, fluid = differences(height), differences(thickness)
    n, omega = points + 1, 2 * np.pi * frequency
    a, b = np.zeros((2 * n, 2 * n), dtype=complex), np.eye(2 * n)
    a[:n, :n] = air @ air + np.eye(n) * (omega / GAS.sound_speed) ** 2
    a[n:, n:] = fluid @ fluid + np.eye(n) * omega**2 * density / bulk
    ends = [0, n - 1, n, 2 * n - 1]
    a[ends], b[ends] = 0, 0
    a[0, :n], a[-1, n:] = air[0], fluid[-1]
    a[n - 1, n - 1], a[n - 1, n] = 1, -1
    a[n, :n], a[n, n:] = air[-1] / GAS.density, -fluid[0] / density
    squares = scipy.linalg.eigvals(a, b)
    squares = squares[np.isfinite(squares) & (np.abs(squares) < 1e6)]
    k = np.sqrt(squares)
    k = np.where(k.imag > 0, -k, k)
    return k[np.argsort(-k.imag)]


@pytest.mark.parametrize("seed", range(12))
def test_agrees_with_collocation(seed):
    rng = np.random.default_rng(seed)
    height, thickness, resistivity = 10 ** rng.uniform([-2, -2, 2.5], [0, -0.5, 5])
    stack = lining(wool(thickness, resistivity))
    f = np.geomspace(100, 5000, 12)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)
        mode = duct_mode(stack, f, height, "one side")
        fluids = stack.layers[0].pore_fluid(Wave(f, np.zeros(1), GAS))
    density, bulk = (np.broadcast_to(value, f.shape) for value in fluids)
    each = [collocated(f[i], height, thickness, density[i], bulk[i])[0] for i in range(len(f))]
    np.testing.assert_allclose(mode.wavenumber, each, rtol=3e-5)
    np.testing.assert_allclose(mode.attenuation, -20 / np.log(10) * np.imag(each), rtol=1e-4)


def test_two_linings_face_each_other_as_one_faces_a_wall_at_half_the_height():
    stack = lining(wool(0.05, 5e3))
    np.testing.assert_array_equal(duct_mode(stack, F, 0.2).wavenumber, duct_mode(stack, F, 0.1, "one side").wavenumber)


def honeycomb(depth, resistance):
    """A cloth before a core of wide tubes: it reacts locally."""
    core = {"type": "viscothermal_fluid", "thickness": depth, "tube_radius": 0.02}
    return lining({"type": "screen", "flow_resistance": resistance}, core)


def test_a_cloth_before_air_that_is_open_along_the_duct_takes_nothing():
    """A plane wave runs in the duct and behind the cloth alike, and nothing flows through it."""
    open_behind = lining({"type": "screen", "flow_resistance": 400.0}, {"type": "fluid", "thickness": 0.02})
    mode = duct_mode(open_behind, F, 0.1)
    np.testing.assert_allclose(mode.attenuation, 0, atol=1e-9)
    np.testing.assert_allclose(mode.phase_speed, GAS.sound_speed)


def test_cremers_optimum():
    """Of all locally reacting linings the one at which two modes meet: k3 h = 2.1062 + 1.1254 i, sin 2x + 2x = 0."""
    f, h = 1000.0, 0.1
    x = scipy.optimize.fsolve(lambda v: [(w := np.sin(2 * complex(*v)) + 2 * complex(*v)).real, w.imag], [2.1, 1.1])
    x = complex(*x)
    assert x == pytest.approx(2.1062 + 1.1254j, abs=1e-4)
    k0 = 2 * np.pi * f / GAS.sound_speed
    for meeting in (x, x.conjugate()):
        best = 1j * k0 * h * GAS.impedance / (meeting * np.tan(meeting))
        if best.real > 0:
            break
    depth = np.arctan2(1, -best.imag / GAS.impedance) / k0

    def away(v):
        z = complex(np.ravel(surface_impedance(honeycomb(v[0], v[1] * GAS.impedance), f))[0]) - best
        return [z.real, z.imag]

    depth, resistance = scipy.optimize.fsolve(away, [depth, best.real / GAS.impedance], xtol=1e-13)
    k = np.sqrt(k0**2 - (meeting / h) ** 2)
    expected = 20 / np.log(10) * abs(k.imag)
    optimal = duct_mode(honeycomb(depth, resistance * GAS.impedance), f, h, "one side").attenuation[0]
    assert optimal == pytest.approx(expected, rel=1e-4)
    for factor in (0.9, 1.1):
        beside = honeycomb(depth, factor * resistance * GAS.impedance)
        assert duct_mode(beside, f, h, "one side").attenuation[0] < optimal


@pytest.mark.parametrize("mach", [-0.3, 0.0, 0.2])
def test_of_little_admittance_the_power_that_enters_is_what_the_wave_loses(mach):
    """8.7 dB times Re(rho c / Z) / (2 h) a metre, with the flow as in a duct 1 + M times as wide, twice."""
    stack, f, h = honeycomb(0.02, 3e5), 200.0, 0.1
    z = complex(np.ravel(surface_impedance(stack, f))[0])
    expected = 20 / np.log(10) * (GAS.impedance / z).real / (2 * h) / (1 + mach) ** 2
    mode = duct_mode(stack, [f], h, "one side", mach)
    assert mode.attenuation[0] == pytest.approx(expected, rel=2e-3)
    assert mode.phase_speed[0] == pytest.approx(GAS.sound_speed * (1 + mach), rel=2e-2)


@pytest.mark.parametrize("mach", [-0.2, 0.2])
def test_flow_satisfies_the_condition_of_ingard_and_myers(mach):
    """The locally reacting impedance of the face is that of the wave in the airway."""
    stack, h = honeycomb(0.05, 400.0), 0.08
    mode = duct_mode(stack, F, h, "one side", mach)
    z, k0 = surface_impedance(stack, F).ravel(), 2 * np.pi * F / GAS.sound_speed
    k3 = np.sqrt((k0 - mach * mode.wavenumber) ** 2 - mode.wavenumber**2)
    right = 1j * k0 * GAS.impedance / z * (1 - mach * mode.wavenumber / k0) ** 2
    np.testing.assert_allclose(k3 * np.tan(k3 * h), right, rtol=1e-7)


def test_a_frame_that_is_light_and_soft_moves_as_a_limp_one():
    fields = {
        "thickness": 0.05, "porosity": 0.98, "flow_resistivity": 1e4, "tortuosity": 1.0, "viscous_length": 1e-4,
        "thermal_length": 2e-4, "frame_density": 20.0,
    }  # fmt: skip
    frame = {"type": "poroelastic", "young_modulus": 100.0, "poisson_ratio": 0.0, "loss_factor": 0.3, **fields}
    limp, soft = (duct_mode(lining(layer), F, 0.2) for layer in ({"type": "limp", **fields}, frame))
    np.testing.assert_allclose(soft.attenuation[1:], limp.attenuation[1:], rtol=0.02)


def test_extremes():
    stack = lining(wool(0.05, 1e4))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)
        mode = duct_mode(stack, [1.0, 5e4], 0.3)
    assert np.all(np.isfinite(mode.wavenumber))
    assert np.all(mode.attenuation >= 0)
    assert mode.attenuation[0] < 0.1
    steel = lining(
        {"type": "elastic_solid", "thickness": 0.1, "density": 7850, "young_modulus": 2e11, "poisson_ratio": 0.3}
    )
    np.testing.assert_allclose(duct_mode(steel, F, 0.3).attenuation, 0, atol=1e-5)


@pytest.mark.parametrize(
    ("stack", "given", "words"),
    [
        (lining(wool(0.05, 1e4), termination="ambient"), {}, "termination: rigid"),
        (lining(wool(0.05, 1e4)).replaced({"layers.0.thickness": np.array([0.05, 0.1])}), {}, "one stack at a time"),
        (lining(wool(0.05, 1e4)), {"height": 0.0}, "above 0 m"),
        (lining(wool(0.05, 1e4)), {"mach": 1.0}, "between -1 and 1"),
        (lining(wool(0.05, 1e4)), {"lined": "all sides"}, "'one side' or on 'both sides'"),
        (lining(wool(0.05, 1e4)), {"frequency": [0.0]}, "above 0 Hz"),
    ],
)
def test_refusals(stack, given, words):
    with pytest.raises(InputError, match=words):
        duct_mode(**({"stack": stack, "frequency": F, "height": 0.2} | given))
