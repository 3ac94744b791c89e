"""The mean over the azimuth against direct integrals of closed forms, and the laws of turning."""

import sys

import numpy as np
import pytest

from multilayer.errors import InputError, ValidityWarning
from multilayer.layers.elastic_plate import ElasticPlate
from multilayer.layers.fluid import Fluid
from multilayer.layers.orthotropic_plate import OrthotropicPlate
from multilayer.matrix.wave import Wave
from multilayer.media.gas import dry_air
from multilayer.response import DiffuseField, Window, diffuse_field, fields, insertion_loss, plane_wave, power_balance
from multilayer.stack import Stack

pytestmark = pytest.mark.filterwarnings("ignore:.*bending wavelength")  # thin or not, the theory is the same

AIR = dry_air()
Z0, C0 = AIR.impedance, AIR.sound_speed
# ratio of stiffnesses 150
BOARD = {
    "thickness": 0.014, "density": 450.0, "young_modulus_x": 6e9, "young_modulus_y": 4e7, "poisson_ratio_xy": 0.3,
    "shear_modulus_xy": 6e7, "loss_factor": 0.02,
}  # fmt: skip
# the ratio of wood
WOOD = {
    "thickness": 0.01, "density": 450.0, "young_modulus_x": 11e9, "young_modulus_y": 5e8, "poisson_ratio_xy": 0.4,
    "shear_modulus_xy": 7e8, "loss_factor": 0.03,
}  # fmt: skip
GAP = Fluid(thickness=0.05)
TIGHT = {"tolerance_db": 2e-6, "tolerance": 5e-7, "max_panels": 1000}
# below, among and above the coincidences of both axes
FREQUENCY = np.array([400.0, 1500.0, 2000.0, 4000.0])


def panel(*layers, termination="ambient"):
    return Stack(layers=layers, termination=termination)


def board(azimuth=0.0, fields=BOARD):
    return OrthotropicPlate(**fields, azimuth=azimuth)


def impedance(plate, frequency, s, azimuth):
    """Return p(front) - p(back) over v3 of Kirchhoff's plate, its stiffness from moments and curvatures."""
    ex, ey, g = (plate[name] * (1 + 1j * plate["loss_factor"]) for name in
                 ("young_modulus_x", "young_modulus_y", "shear_modulus_xy"))  # fmt: skip
    nu, h = plate["poisson_ratio_xy"], plate["thickness"]
    compliance = np.array([[1 / ex, -nu / ex, 0], [-nu / ex, 1 / ey, 0], [0, 0, 1 / g]])
    bending = np.linalg.inv(compliance) * h**3 / 12
    turned = np.deg2rad(azimuth)
    x, y = np.cos(turned), np.sin(turned)
    curvature = np.array([x**2, y**2, 2 * x * y])
    stiffness = np.einsum("i...,ij,j...->...", curvature, bending, curvature)
    omega = 2 * np.pi * frequency
    kx = omega / C0 * np.sqrt(s)
    return 1j * omega * plate["density"] * h + stiffness * kx**4 / (1j * omega)


def tau_of_one(frequency, s, azimuth, plate=BOARD):
    return np.abs(1 + impedance(plate, frequency, s, azimuth) * np.sqrt(1 - s) / (2 * Z0)) ** -2.0


def tau_of_two(frequency, s, azimuth, orientations):
    """Two boards and a gap, by their transfer matrices."""
    cosine = np.sqrt(1 - s)
    one, other = (impedance(BOARD, frequency, s, azimuth + turn) * cosine / Z0 for turn in orientations)
    phase = 2 * np.pi * frequency / C0 * cosine * GAP.thickness
    cos, isin = np.cos(phase), 1j * np.sin(phase)
    a, c = cos + one * isin, isin
    b, d = isin + one * cos + other * a, cos + other * c
    return np.abs(2 / (a + b + c + d)) ** 2


def alpha_on_a_gap(frequency, s, azimuth):
    cosine = np.sqrt(1 - s)
    phase = 2 * np.pi * frequency / C0 * cosine * GAP.thickness
    surface = impedance(WOOD, frequency, s, azimuth) * cosine / Z0 - 1j / np.tan(phase)
    return 4 * surface.real / np.abs(1 + surface) ** 2


def direct(integrand, frequency, max_angle=78.0, n=1):
    """Return the mean of a closed form over directions by Gauss's rule on a very fine grid; `n` times finer."""
    nodes, weights = np.polynomial.legendre.leggauss(10)

    def grid(upper, panels):
        edges = upper * np.linspace(0, 1, panels + 1)
        x = edges[:-1, None] + np.diff(edges)[:, None] * (nodes + 1) / 2
        return x.ravel(), np.tile(weights, panels) / (2 * panels)

    psi, share = grid(180.0, 60 * n)
    # in the cosine nothing is singular at grazing incidence
    cosine, part = grid(1 - np.cos(np.deg2rad(max_angle)), 150 * n)
    cosine = 1 - cosine
    part = part * cosine / (part @ cosine)
    return np.array([part @ integrand(f, 1 - cosine[:, None] ** 2, psi) @ share for f in np.atleast_1d(frequency)])


class TestMeans:
    @pytest.mark.parametrize("max_angle", [78.0, 90.0])
    def test_transmission_is_a_direct_integral(self, max_angle):
        exact = direct(tau_of_one, FREQUENCY, max_angle, n=2)
        found = diffuse_field(panel(board()), FREQUENCY, max_angle, **TIGHT)
        np.testing.assert_allclose(found.transmission_coefficient, exact, rtol=1e-6)
        by_default = diffuse_field(panel(board()), FREQUENCY, max_angle)
        np.testing.assert_allclose(by_default.transmission_loss, -10 * np.log10(exact), atol=0.01, rtol=0)
        assert np.all(by_default.transmission_loss_error <= 0.01)

    def test_the_direct_integral_is_one(self):
        """A finer grid changes nothing."""
        some = FREQUENCY[:3]
        np.testing.assert_allclose(direct(tau_of_one, some), direct(tau_of_one, some, n=2), rtol=1e-10)

    @pytest.mark.parametrize("max_angle", [78.0, 90.0])
    def test_absorption_is_a_direct_integral(self, max_angle):
        frequency = np.array([150.0, 700.0, 2000.0])
        exact = direct(alpha_on_a_gap, frequency, max_angle)
        stack = panel(board(30.0, WOOD), GAP, termination="rigid")
        found = diffuse_field(stack, frequency, max_angle, **TIGHT)
        np.testing.assert_allclose(found.absorption, exact, atol=1e-6, rtol=0)
        np.testing.assert_allclose(diffuse_field(stack, frequency, max_angle).absorption, exact, atol=1e-4, rtol=0)

    @pytest.mark.parametrize("orientations", [(0.0, 0.0), (20.0, 65.0), (0.0, 90.0)])
    def test_two_plates_are_a_direct_integral(self, orientations):
        frequency = np.array([100.0, 300.0, 1200.0])
        exact = direct(lambda f, s, psi: tau_of_two(f, s, psi, orientations), frequency, n=2)
        first, second = (board(turn) for turn in orientations)
        found = diffuse_field(panel(first, GAP, second), frequency, **TIGHT)
        np.testing.assert_allclose(found.transmission_coefficient, exact, rtol=1e-6)

    def test_a_plate_of_stiffnesses_150_to_1_at_2_khz(self):
        """Single planes of incidence lie 14 dB apart, and neither of them is the diffuse field."""

        def at(azimuth):
            return -10 * np.log10(direct(lambda f, s, psi: tau_of_one(f, s, 0 * psi + azimuth), 2000.0)[0])

        assert [at(0.0), at(90.0)] == pytest.approx([20.8, 34.4], abs=0.05)
        assert diffuse_field(panel(board()), 2000.0).transmission_loss == pytest.approx(22.3, abs=0.05)

    def test_with_a_window_the_mean_is_that_over_its_orientations(self):
        """Planes of incidence one by one, each with the window's mean radiation."""
        size = {"window": Window(1.4, 1.1), "tolerance_db": 1e-4, "tolerance": 1e-6}
        found = diffuse_field(panel(board()), 500.0, 90.0, **size)
        planes = [
            diffuse_field(panel(_in_one_plane(azimuth)), 500.0, 90.0, **size).transmission_coefficient
            for azimuth in 180 * (np.arange(48) + 0.5) / 48
        ]
        assert found.transmission_coefficient == pytest.approx(np.mean(planes), rel=1e-4)


def _in_one_plane(azimuth):
    """Return an isotropic plate as stiff as the board is along one direction."""
    stiffness = board(azimuth).stiffness(Wave.incident(500.0, 0.0, AIR))
    same = {name: BOARD[name] for name in ("thickness", "density", "loss_factor")}
    return ElasticPlate(**same, young_modulus=float(stiffness.real) * 12 / BOARD["thickness"] ** 3, poisson_ratio=0.0)


class TestTurning:
    def test_a_turn_of_everything_changes_nothing(self):
        def turned(azimuth):
            stack = panel(board(azimuth), GAP, board(azimuth + 50.0, WOOD))
            return diffuse_field(stack, [120.0, 500.0], **TIGHT).transmission_coefficient

        reference = turned(0.0)
        for azimuth in (17.0, 90.0, 133.0, 200.0):
            np.testing.assert_allclose(turned(azimuth), reference, rtol=1e-6)

    def test_a_turn_of_one_plate_upon_another_does(self):
        along, across, back = (
            diffuse_field(panel(board(), GAP, board(turn)), 1200.0).transmission_loss for turn in (0.0, 90.0, -90.0)
        )
        assert across == pytest.approx(back, abs=1e-9)
        assert abs(across - along) > 3

    def test_an_orthotropic_plate_that_is_isotropic(self):
        modulus, ratio = 65e9, 0.22
        same = {"thickness": 6e-3, "density": 2500.0, "loss_factor": 0.02}
        ours = OrthotropicPlate(
            **same, young_modulus_x=modulus, young_modulus_y=modulus, poisson_ratio_xy=ratio,
            shear_modulus_xy=modulus / (2 + 2 * ratio), azimuth=12.0,
        )  # fmt: skip
        theirs = ElasticPlate(**same, young_modulus=modulus, poisson_ratio=ratio)
        frequency = np.array([100.0, 2500.0])
        found, expected = (diffuse_field(panel(plate), frequency, **TIGHT) for plate in (ours, theirs))
        np.testing.assert_allclose(found.transmission_coefficient, expected.transmission_coefficient, rtol=1e-9)

    def test_the_azimuth_of_the_wave_adds_to_that_of_the_plate(self):
        azimuth = np.array([[0.0, 30.0], [90.0, 200.0]])
        frequency, angle = [500.0, 2000.0], [0.0, 45.0, 70.0]
        stack = panel(board(10.0), GAP, board(65.0))
        found = plane_wave(stack, frequency, angle, azimuth=azimuth)
        assert found.transmission.shape == (2, 3, 2, 2)
        for place in np.ndindex(azimuth.shape):
            turned = panel(board(10.0 + azimuth[place]), GAP, board(65.0 + azimuth[place]))
            expected = plane_wave(turned, frequency, angle).transmission
            np.testing.assert_allclose(found.transmission[(..., *place)], expected, rtol=1e-10)

    def test_tables_name_the_azimuth_that_was_asked_for(self):
        asked = plane_wave(panel(board()), [500.0, 2000.0], 45.0, azimuth=[0.0, 30.0, 60.0]).to_pandas()
        assert len(asked) == 6
        assert "azimuth" in asked.columns
        assert "azimuth" not in plane_wave(panel(board()), [500.0, 2000.0], 45.0).to_pandas().columns

    def test_other_responses_take_it_too(self):
        stack, turned = (panel(board(azimuth), GAP) for azimuth in (0.0, 40.0))
        azimuth = np.array([0.0, 40.0])
        along = {"frequency": 700.0, "angle": [30.0, 60.0]}
        shares = power_balance(stack, **along, azimuth=azimuth)
        np.testing.assert_allclose(shares.reflected[..., 1], power_balance(turned, **along).reflected, rtol=1e-10)
        inside, expected = fields(stack, **along, azimuth=azimuth)[1], fields(turned, **along)[1]
        np.testing.assert_allclose(inside["p"][..., 1], expected["p"], rtol=1e-10)
        gain = insertion_loss(stack, turned, **along, azimuth=40.0)
        np.testing.assert_allclose(gain, insertion_loss(turned, panel(board(80.0), GAP), **along), rtol=1e-9, atol=1e-9)
        matrix = board().transfer_matrix(700.0, [60.0], azimuth=azimuth)
        np.testing.assert_allclose(matrix[:, 1], board(40.0).transfer_matrix(700.0, [60.0]), rtol=1e-10)

    def test_isotropic_stacks_have_the_axis_but_no_dependence(self):
        found = plane_wave(panel(GAP), [100.0, 200.0], [0.0, 30.0], azimuth=[0.0, 77.0, 180.0])
        assert found.reflection.shape == (2, 2, 3)
        assert np.ptp(found.reflection.real, axis=-1).max() == 0

    def test_azimuths_that_are_none(self):
        with pytest.raises(InputError, match="azimuth is not finite"):
            plane_wave(panel(board()), 100.0, azimuth=np.nan)


class TestFlag:
    def test_a_stack_is_isotropic_if_all_its_layers_are(self):
        assert panel(GAP, GAP).isotropic_in_plane
        assert not panel(GAP, board()).isotropic_in_plane

    def test_isotropic_stacks_are_computed_at_one_azimuth(self):
        found = diffuse_field(panel(GAP), [100.0, 5000.0])
        assert np.all(found.angles == 15)
        assert np.all(diffuse_field(panel(GAP, board()), [100.0, 5000.0]).angles >= 30 * 15)

    def test_what_a_layer_that_is_not_costs(self):
        frequency = np.geomspace(100.0, 5000.0, 12)
        same = {name: BOARD[name] for name in ("thickness", "density", "loss_factor")}
        plate = ElasticPlate(**same, young_modulus=BOARD["young_modulus_x"], poisson_ratio=0.3)
        ours, theirs = (diffuse_field(panel(layer), frequency).angles.sum() for layer in (board(), plate))
        assert 30 < ours / theirs < 200


@pytest.mark.slow
def test_azimuths_are_refined_in_vain_nowhere(monkeypatch):
    # with hardly any loss the integrals over angles converge at the lower of these frequencies only
    module = sys.modules[DiffuseField.__module__]
    thin, thick = (
        OrthotropicPlate(**{**WOOD, "loss_factor": 1e-3, "thickness": h}, azimuth=30.0) for h in (0.01, 0.02)
    )
    stack = panel(thin, Fluid(thickness=0.1), thick)

    def computed(many):
        monkeypatch.setattr(module, "_MANY_DIRECTIONS", many)
        with pytest.warns(ValidityWarning, match="1 of 2 frequencies"):
            return diffuse_field(stack, [5010.3, 7942.5], 90.0)

    whole, short = computed(10**9), computed(100)
    assert short.angles[0] == whole.angles[0]
    np.testing.assert_allclose(short.transmission_loss[0], whole.transmission_loss[0], rtol=1e-14)
    assert short.angles[1] < whole.angles[1] / 3
    assert abs(short.transmission_loss[1] - whole.transmission_loss[1]) < short.transmission_loss_error[1]
