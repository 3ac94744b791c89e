"""Formulae of shifts over temperature, and their fits."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.errors import InputError
from multilayer.media.laws import HavriliakNegami
from multilayer.media.superposition import (
    arrhenius_log_shift,
    entropic_shift,
    fit_arrhenius,
    fit_wlf,
    matching_log_shift,
    wlf_log_shift,
    wlf_of_reference,
)

LAW = HavriliakNegami(
    relaxed_modulus=2e5, unrelaxed_modulus=1e8, relaxation_time=2e-4, order=0.35, asymmetry=0.4
)  # at the reference
REFERENCE_K = 300.0
TEMPERATURES = np.arange(270.0, 331.0, 10.0)
WLF = (12.0, 90.0)
LOG_SHIFTS = wlf_log_shift(TEMPERATURES, REFERENCE_K, *WLF)


class TestFormulae:
    def test_wlf(self):
        """c1 = 17.44, c2 = 51.6 K, the values first taken as universal."""
        assert wlf_log_shift(350.0, 350.0, 17.44, 51.6) == 0.0
        assert wlf_log_shift(351.6, 300.0, 17.44, 51.6) == pytest.approx(-17.44 / 2)

    def test_wlf_of_another_reference_is_the_same_curve(self):
        c1, c2 = wlf_of_reference(300.0, 12.0, 90.0, 320.0)
        moved = wlf_log_shift(TEMPERATURES, 320.0, c1, c2)
        difference = LOG_SHIFTS - moved
        assert_allclose(difference, difference[0], atol=1e-12)

    def test_wlf_ends_at_its_pole(self):
        with pytest.raises(InputError, match="WLF has its pole at 210 K"):
            wlf_log_shift([300.0, 210.0], 300.0, 12.0, 90.0)

    def test_arrhenius_of_a_known_energy(self):
        """100 kJ/mol from 20 to 30 degC: exp(-E/R (1/T0 - 1/T)) = 0.258."""
        assert 10 ** arrhenius_log_shift(303.15, 293.15, 1e5) == pytest.approx(0.2583, rel=1e-3)

    def test_rubber_stiffens_with_temperature(self):
        assert entropic_shift(330.0, 300.0) == pytest.approx(1.1)
        assert entropic_shift(330.0, 300.0, 6e-4) == pytest.approx(1.1 / 1.018)

    def test_shift_that_matches_curves(self):
        f = np.geomspace(1.0, 1e3, 31)
        assert matching_log_shift(f, LAW(f).real, f, LAW(f * 20).real) == pytest.approx(np.log10(20), abs=1e-3)
        turned = f[::-1]
        assert matching_log_shift(f, LAW(f).real, turned, LAW(turned * 20).real) == pytest.approx(
            np.log10(20), abs=1e-3
        )

    def test_curves_without_a_common_value_are_joined_at_their_ends(self):
        f = np.array([1.0, 10.0])
        assert matching_log_shift(f, np.array([1.0, 2.0]), f, np.array([3.0, 4.0])) == pytest.approx(1.0)

    def test_fits_find_what_made_the_shifts(self):
        wlf = fit_wlf(TEMPERATURES, LOG_SHIFTS, REFERENCE_K)
        assert wlf.parameters == pytest.approx({"c1": 12.0, "c2": 90.0}, rel=1e-5)
        assert wlf.rms < 1e-6
        arrhenius = fit_arrhenius(TEMPERATURES, arrhenius_log_shift(TEMPERATURES, REFERENCE_K, 2e5), REFERENCE_K)
        assert arrhenius.parameters == pytest.approx({"activation_energy": 2e5})

    def test_the_wrong_formula_shows_in_its_residual(self):
        wrong = fit_arrhenius(TEMPERATURES, LOG_SHIFTS, REFERENCE_K)
        assert wrong.rms > 0.1
        assert wrong.std["activation_energy"] > 0


class TestGeneralisedLeastSquares:
    """Shifts are sums of steps from neighbour to neighbour, away from the reference; one step is hardly known."""

    steps = np.array([0.01, 0.02, 1.0, 0.01, 0.02, 0.01])  # decades; the third step lies next to the reference

    def covariance(self):
        sums = np.zeros((7, 6))
        for k in range(3):
            sums[: k + 1, k] = 1.0
            sums[k + 4 :, k + 3] = 1.0
        return sums * self.steps, (sums * self.steps) @ (sums * self.steps).T

    @pytest.mark.parametrize(
        ("fit", "truth"), [(fit_wlf, {"c1": 12.0, "c2": 90.0}), (fit_arrhenius, {"activation_energy": 2e5})]
    )
    def test_standard_deviations_cover_the_truth(self, fit, truth):
        root, covariance = self.covariance()
        shifts = LOG_SHIFTS if fit is fit_wlf else arrhenius_log_shift(TEMPERATURES, REFERENCE_K, 2e5)
        rng = np.random.default_rng(0)
        scores = []
        for _ in range(100):
            found = fit(TEMPERATURES, shifts + root @ rng.standard_normal(6), REFERENCE_K, covariance)
            scores.append([(found.parameters[name] - value) / found.std[name] for name, value in truth.items()])
        assert np.sqrt(np.mean(np.square(scores))) == pytest.approx(0.9, abs=0.2)  # widened by chance, never narrowed

    def test_a_formula_that_misses_is_less_certain(self):
        covariance = self.covariance()[1]
        right = fit_arrhenius(
            TEMPERATURES, arrhenius_log_shift(TEMPERATURES, REFERENCE_K, 2e5), REFERENCE_K, covariance
        )
        wrong = fit_arrhenius(TEMPERATURES, LOG_SHIFTS, REFERENCE_K, covariance)
        assert wrong.std["activation_energy"] > 5 * right.std["activation_energy"]

    def test_as_many_shifts_as_parameters(self):
        chosen = slice(3, 6)  # of the reference and two more
        t, shifts = TEMPERATURES[chosen], LOG_SHIFTS[chosen]
        assert np.isnan(list(fit_wlf(t, shifts, REFERENCE_K).std.values())).all()
        known = fit_wlf(t, shifts, REFERENCE_K, self.covariance()[1][chosen, chosen])
        assert min(known.std.values()) > 0
