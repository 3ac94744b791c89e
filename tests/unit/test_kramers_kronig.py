"""Kramers-Kronig relations: the local one, the full one, and the check of measured moduli."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from multilayer.errors import InputError
from multilayer.media.kramers_kronig import (
    check_kramers_kronig,
    gross_loss_modulus,
    kramers_kronig_loss_modulus,
)
from multilayer.media.laws import FreeForm, HavriliakNegami, KelvinVoigt, Zener

BAND = np.geomspace(1.0, 1e4, 30)
ZENER = Zener(relaxed_modulus=1e5, unrelaxed_modulus=3e5, relaxation_time=1e-3)


def random_law(rng):
    order = rng.uniform(0.2, 1.0)
    return HavriliakNegami(
        relaxed_modulus=1e5,
        unrelaxed_modulus=1e5 * 10 ** rng.uniform(0.3, 3.0),
        relaxation_time=10 ** rng.uniform(-5.0, -1.0),
        order=order,
        asymmetry=rng.uniform(0.2, 1.0),
    )


def measured(law, rng, frequency=BAND, relative=0.01):
    """Return noisy moduli of a law, and their standard deviation."""
    modulus = law(frequency)
    std = relative * np.abs(modulus)
    noise = rng.standard_normal(frequency.size) + 1j * rng.standard_normal(frequency.size)
    return modulus + std * noise, std


class TestGross:
    def test_exact_where_e1_is_linear_in_the_logarithm(self):
        """In the middle of twenty decades of constant spectrum, but for the third derivative of ln E1 = ln(a + b x).

        A parabola over -h to h errs by h^2/10 of it: here h = ln 10 and b/a = 1/27.6, which make 2 h^2 (b/a)^2/10.
        """
        law = FreeForm(relaxed_modulus=1e5, frequency=(1e-10, 1e10), rise=(1e6,))
        f = np.geomspace(0.1, 10.0, 201)
        found = gross_loss_modulus(f, law(f).real) / law(f).imag
        assert found[100] - 1 == pytest.approx(2 * np.log(10) ** 2 / 10 / 27.6**2, rel=0.1)
        f = np.geomspace(0.9, 1.1, 21)
        assert_allclose(gross_loss_modulus(f, law(f).real), law(f).imag, rtol=1e-4)

    @pytest.mark.parametrize("order", [0.1, 0.25, 0.5])
    def test_of_a_power_law(self, order):
        f = np.geomspace(1.0, 100.0, 401)
        modulus = (1j * f) ** order
        expected = (np.pi * order / 2) / np.tan(np.pi * order / 2)
        assert_allclose((gross_loss_modulus(f, modulus.real) / modulus.imag)[1:-1], expected, rtol=1e-4)

    def test_at_the_peak_of_a_zener_element(self):
        f = np.geomspace(0.99, 1.01, 3) / (2 * np.pi * 1e-3)
        assert gross_loss_modulus(f, ZENER(f).real)[1] / ZENER(f).imag[1] == pytest.approx(np.pi / 2, rel=1e-3)

    @pytest.mark.parametrize(("contrast", "ratio"), [(1.01, 0.742), (10.0, 0.985)])
    def test_at_that_peak_of_a_law_known_over_decades(self, contrast, ratio):
        """For little contrast 3 pi/(2 h^3) times the integral of v tanh(v) from 0 to the reach h: 0.742."""
        law = Zener(relaxed_modulus=1e5, unrelaxed_modulus=contrast * 1e5, relaxation_time=1e-3)
        f = np.geomspace(1e-3, 1e3, 601) / (2 * np.pi * 1e-3)
        peak = int(np.argmin(np.abs(2e-3 * np.pi * f - 1)))
        assert gross_loss_modulus(f, law(f).real)[peak] / law(f).imag[peak] == pytest.approx(ratio, abs=0.002)

    def test_reaches_as_far_as_the_full_relation(self):
        """ln coth|v/2| has the variance pi^2/6, the slope of a parabola over -h to h that of h^2 - v^2: h^2/5."""
        v = np.linspace(-30, 30, 600_000)  # no point at 0
        weight = np.log(1 / np.tanh(np.abs(v) / 2))
        reach = np.sqrt(5 * np.sum(weight * v**2) / np.sum(weight))
        x = np.linspace(-4, 4, 81)
        e1 = np.exp(0.2 * x)
        usual = gross_loss_modulus(np.exp(x), e1)[40]
        wrong = [gross_loss_modulus(np.exp(x), e1 * (1 + 0.1 * unit))[40] for unit in np.eye(x.size)]
        assert_array_equal(np.abs(wrong / usual - 1) > 1e-9, np.abs(x) < reach)

    def test_errors_of_e1(self):
        """With the numbers of docs/laws.md: 1 % of error in E1 ~ f^0.27 at 15 bursts."""
        f = np.arange(100.0, 1600.0, 100.0)
        e1 = f**0.27
        two_points = _spread(lambda e: np.pi / 2 * e * np.gradient(np.log(e), np.log(f)), e1)
        assert two_points[[1, 9, -1]] == pytest.approx([0.072, 0.266, 0.759], abs=0.001)
        parabola = _spread(lambda e: gross_loss_modulus(f, e), e1)
        assert (parabola.min(), parabola.max()) == (pytest.approx(0.013, abs=0.001), pytest.approx(0.048, abs=0.001))

    @pytest.mark.parametrize("f", [[100.0, 200.0], [1.0, 100.0, 1e4], [1.0, 30.0, 1e3, 3e4, 1e6]])
    def test_few_frequencies_far_apart(self, f):
        """Those nearest are taken however far they are; two make a line."""
        e1 = np.array(f) ** 0.3
        assert_allclose(gross_loss_modulus(f, e1), np.pi / 2 * 0.3 * e1, rtol=1e-9)


def _spread(loss_modulus, e1, relative=0.01):
    """Return the relative standard deviation of E2 for independent relative errors of E1, to first order."""
    step = 1e-6
    usual = loss_modulus(e1) / e1
    wrong = [(e1 * (1 + step * unit), 1 + step * unit) for unit in np.eye(e1.size)]
    slopes = np.array([(loss_modulus(e) / e1 / by - usual) / step for e, by in wrong])
    return relative * np.linalg.norm(slopes, axis=0) / usual


class TestFullRelation:
    def test_of_a_zener_element(self):
        f = np.geomspace(1e-6, 1e10, 3201)
        loss = ZENER(f).imag
        assert_allclose(kramers_kronig_loss_modulus(f, ZENER(f).real), loss, atol=1e-4 * loss.max())

    def test_does_not_see_a_dashpot(self):
        law = KelvinVoigt(young_modulus=1e5, viscosity=10.0)
        assert_allclose(kramers_kronig_loss_modulus(BAND, law(BAND).real), 0.0, atol=1e-6)

    def test_at_some_frequencies(self):
        f = np.geomspace(1e-3, 1e9, 400)
        everywhere = kramers_kronig_loss_modulus(f, ZENER(f).real)
        assert_allclose(kramers_kronig_loss_modulus(f, ZENER(f).real, f[[20, 200]]), everywhere[[20, 200]])


class TestConsistent:
    def test_false_alarms_are_as_many_as_said(self):
        rng = np.random.default_rng(1)
        laws = [random_law(rng) for _ in range(200)]
        checks = [check_kramers_kronig(BAND, *both(measured(law, rng)), significance=0.1) for law in laws]
        alarms = sum(check.verdict == "inconsistent" for check in checks)
        assert alarms <= 30  # of 20 expected; more than 30 in 1 % of all draws
        assert sum(check.verdict == "consistent" for check in checks) >= 160
        assert np.mean([check.p_value < 0.1 for check in checks]) == pytest.approx(0.1, abs=0.05)

    def test_reads_well(self):
        check = check_kramers_kronig(BAND, *both(measured(ZENER, np.random.default_rng(2))))
        assert check.verdict == "consistent"
        assert "a causal passive material has moduli as near as this (chi-square" in check.reasons[0]
        assert check.reduced_chi_square == pytest.approx(1.0, abs=0.5)
        assert check.largest_residual < 4
        assert_allclose(check.modulus, ZENER(BAND), rtol=0.03)

    def test_of_exact_data(self):
        modulus = ZENER(BAND)
        check = check_kramers_kronig(BAND, modulus, 1e-3 * np.abs(modulus), 1e-3 * np.abs(modulus))
        assert check.verdict == "consistent"
        assert "scatter less than their standard deviations say" in check.reasons[1]

    def test_the_order_of_the_data_is_no_matter(self):
        modulus, std = measured(ZENER, np.random.default_rng(3))
        there = check_kramers_kronig(BAND, modulus, std, std)
        back = check_kramers_kronig(BAND[::-1], modulus[::-1], std[::-1], std[::-1])
        assert back.chi_square == pytest.approx(there.chi_square)


class TestInconsistent:
    def test_a_loss_modulus_half_as_large_again(self):
        rng = np.random.default_rng(4)
        for law in (random_law(rng) for _ in range(30)):
            modulus, std = measured(law, rng)
            assert check_kramers_kronig(BAND, modulus.real + 1.5j * modulus.imag, std, std).verdict == "inconsistent"

    def test_a_storage_modulus_that_falls(self):
        rng = np.random.default_rng(5)
        for law in (random_law(rng) for _ in range(30)):
            modulus, std = measured(law, rng)
            turned = modulus.real[::-1] + 1j * modulus.imag
            assert check_kramers_kronig(BAND, turned, std, std).verdict == "inconsistent"

    def test_losses_without_dispersion(self):
        modulus = np.full(BAND.size, 1e5 + 2e4j)
        check = check_kramers_kronig(BAND, modulus, 1e3, 1e3)
        assert check.verdict == "inconsistent"
        assert "no causal passive material has these moduli" in check.reasons[0]
        assert "% off in the mean" in check.reasons[1]

    def test_a_single_outlier_among_many(self):
        f = np.geomspace(1.0, 1e4, 200)
        modulus, std = measured(ZENER, np.random.default_rng(6), f)
        assert check_kramers_kronig(f, modulus, std, std).verdict == "consistent"
        modulus[120] += 8j * std[120]
        check = check_kramers_kronig(f, modulus, std, std)
        assert check.verdict == "inconsistent"
        assert f"in E2 at {f[120]:g} Hz" in check.reasons[1]


class TestCannotTell:
    def test_a_narrow_noisy_band(self):
        f = np.geomspace(100.0, 150.0, 6)
        check = check_kramers_kronig(f, *both(measured(ZENER, np.random.default_rng(7), f, 0.05)))
        assert check.verdict == "cannot tell"
        assert any("times as large would pass as well: widen the band" in reason for reason in check.reasons)

    def test_a_dashpot_of_any_size_leaves_e1_alone(self):
        modulus = KelvinVoigt(young_modulus=1e5, viscosity=2.0)(BAND)
        check = check_kramers_kronig(BAND, modulus, 1e-3 * np.abs(modulus), 1e-3 * np.abs(modulus))
        assert check.verdict == "cannot tell"

    def test_losses_lost_in_noise(self):
        rng = np.random.default_rng(8)
        std = 1e3
        modulus = 1e5 + std * (rng.standard_normal(BAND.size) + 1j * rng.standard_normal(BAND.size))
        assert check_kramers_kronig(BAND, modulus, std, std).verdict == "cannot tell"


@pytest.mark.parametrize(
    ("frequency", "modulus", "std", "message"),
    [
        ([1.0, 2.0, 3.0], [1e5, 1e5], 1.0, "lists of one length"),
        ([1.0, 0.0], [1e5, 1e5], 1.0, "entry 2: frequency and E1"),
        ([1.0, 2.0], [1e5, -1e5], 1.0, "entry 2: frequency and E1"),
        ([1.0, 2.0], [np.nan, 1e5], 1.0, "entry 1: frequency and E1"),
        ([1.0, 2.0], [1e5, 1e5], [1.0, 0.0], "entry 2: standard deviations"),
    ],
)
def test_bad_data(frequency, modulus, std, message):
    with pytest.raises(InputError, match=message):
        check_kramers_kronig(frequency, modulus, std, std)


def both(data):
    """Return moduli and their standard deviation, the same for E1 and E2."""
    modulus, std = data
    return modulus, std, std
