"""Time-temperature superposition: shifts of made-up materials found again, formulae of shifts, and a measured foam."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.errors import InputError, ValidityWarning
from multilayer.fits.law_fit import fit_law
from multilayer.inverse.master_curve import master_curve
from multilayer.media.kramers_kronig import check_kramers_kronig
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
from tests.benchmarks.master_curve import REFERENCE, ZERO, read_vn600

LAW = HavriliakNegami(
    relaxed_modulus=2e5, unrelaxed_modulus=1e8, relaxation_time=2e-4, order=0.35, asymmetry=0.4
)  # at the reference
REFERENCE_K = 300.0
TEMPERATURES = np.arange(270.0, 331.0, 10.0)
WLF = (12.0, 90.0)
LOG_SHIFTS = wlf_log_shift(TEMPERATURES, REFERENCE_K, *WLF)


def data(noise=0.0, vertical=1.0, band=(0.03, 30.0), seed=0):
    """Return temperature, frequency and modulus of `LAW`, shifted by WLF."""
    f = np.geomspace(*band, 11)
    t = np.repeat(TEMPERATURES, f.size)
    f = np.tile(f, TEMPERATURES.size)
    e = LAW(f * 10 ** np.repeat(LOG_SHIFTS, 11)) * np.repeat(np.broadcast_to(vertical, TEMPERATURES.shape), 11)
    rng = np.random.default_rng(seed)
    return t, f, e * (1 + noise * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size)))


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


class TestMadeUp:
    def test_shifts_are_found_again(self):
        curve = master_curve(*data(), reference=REFERENCE_K)
        assert_allclose(curve.log_shift, LOG_SHIFTS, atol=0.01)
        assert np.mean(curve.relative_error) < 2e-3
        assert curve.wlf().parameters == pytest.approx({"c1": 12.0, "c2": 90.0}, rel=0.02)
        assert curve.wlf().rms < curve.arrhenius().rms

    def test_standard_deviations_cover_the_truth(self):
        scores = []
        for seed in range(10):
            curve = master_curve(*data(0.02, seed=seed), reference=REFERENCE_K)
            moved = curve.temperature != REFERENCE_K
            scores.append(((curve.log_shift - LOG_SHIFTS) / np.where(moved, curve.log_shift_std, 1.0))[moved])
        assert np.sqrt(np.mean(np.square(scores))) == pytest.approx(1.0, abs=0.35)

    def test_the_reduced_data_lie_on_the_curve(self):
        curve = master_curve(*data(), reference=REFERENCE_K)
        assert_allclose(curve.modulus, LAW(curve.frequency), rtol=0.02)
        assert_allclose(curve.law(curve.frequency), curve.modulus, rtol=0.02)

    def test_bands_that_do_not_overlap(self):
        """One decade measured, gaps of 0.2 to 1.6 decades: said, and the narrow ones bridged all the same."""
        with pytest.warns(ValidityWarning, match="270 and 280 K, 280 and 290 K, .* do not overlap"):
            curve = master_curve(*data(band=(0.3, 3.0)), reference=REFERENCE_K)
        assert_allclose(curve.log_shift[2:], LOG_SHIFTS[2:], atol=0.05)
        assert_allclose(curve.gaps, -np.diff(curve.log_shift) - 1.0)

    def test_order_of_rows_is_no_matter(self):
        t, f, e = data(0.01)
        mixed = np.random.default_rng(0).permutation(t.size)
        there, back = master_curve(t, f, e), master_curve(t[mixed], f[mixed], e[mixed])
        assert_allclose(back.log_shift, there.log_shift, atol=1e-4)
        assert_allclose(back.frequency, there.frequency[mixed], rtol=1e-3)

    def test_another_reference_moves_all_alike(self):
        one, other = (master_curve(*data(0.01), reference=t) for t in (300.0, 320.0))
        assert other.log_shift[TEMPERATURES == 320.0] == 0.0
        assert_allclose(np.diff(other.log_shift), np.diff(one.log_shift), atol=0.01)

    def test_the_middle_temperature_is_the_default_reference(self):
        assert master_curve(*data()).reference == REFERENCE_K


class TestVertical:
    def test_entropic(self):
        made = entropic_shift(TEMPERATURES, REFERENCE_K, 5e-4)
        curve = master_curve(*data(vertical=made), reference=REFERENCE_K, vertical="entropic", expansion=5e-4)
        assert_allclose(curve.vertical, made)
        assert_allclose(curve.log_shift, LOG_SHIFTS, atol=0.01)

    def test_sought(self):
        made = 1.0 + 0.1 * np.sin(TEMPERATURES)
        made /= made[TEMPERATURES == REFERENCE_K]
        measured = data(0.002, vertical=made)
        plain = master_curve(*measured, reference=REFERENCE_K)
        curve = master_curve(*measured, reference=REFERENCE_K, vertical="free", vertical_std=0.1)
        assert np.mean(curve.relative_error) < 0.5 * np.mean(plain.relative_error)
        assert_allclose(curve.vertical, made, rtol=0.06)
        assert_allclose(curve.log_shift, LOG_SHIFTS, atol=0.08)

    def test_what_is_not_there_is_hardly_found(self):
        """Horizontal and vertical shifts do nearly the same: noise of 1 % leaves b_T open to some per cent."""
        loose, tight = (
            master_curve(*data(0.01), reference=REFERENCE_K, vertical="free", vertical_std=std) for std in (0.05, 0.005)
        )
        assert_allclose(loose.vertical, 1.0, atol=0.15)
        assert_allclose(tight.vertical, 1.0, atol=0.015)


class TestRefused:
    @pytest.mark.parametrize(
        ("change", "options", "message"),
        [
            (lambda t, f, e: (t[:-1], f, e), {}, "lists of one length"),
            (lambda t, f, e: (t - 300.0, f, e), {}, "entry 1: temperature"),
            (lambda t, f, e: (t, f, -e), {}, "entry 1: temperature"),
            (lambda t, f, e: (t + np.arange(t.size) * 1e-3, f, e), {}, "round temperatures to nominal ones"),
            (lambda t, f, e: (0 * t + 300.0, f, e), {}, "all data are at 300 K"),
            (lambda t, f, e: (t, f, e), {"reference": 304.0}, "the nearest is 300 K"),
        ],
    )
    def test_data(self, change, options, message):
        with pytest.raises(InputError, match=message):
            master_curve(*change(*data()), **options)

    def test_too_few_temperatures_for_a_formula(self):
        with pytest.raises(InputError, match="four are needed"):
            master_curve(*data()).wlf(315.0)


@pytest.fixture(scope="module")
def foam(shared):
    assert (shared / "measured" / "nist_vn600_dma.csv").is_file()
    return read_vn600()


@pytest.fixture(scope="module")
def foam_curve(foam):
    with pytest.warns(ValidityWarning, match="the data of 238.15 and 243.15 K do not overlap"):
        return master_curve(*foam, reference=REFERENCE)


@pytest.mark.reference
class TestFoam:
    """VN600: Landauer et al., Sci. Data 10:356 (2023)."""

    def test_one_curve_of_nineteen_temperatures(self, foam_curve):
        assert foam_curve.temperature.size == 19
        assert np.mean(foam_curve.relative_error) < 0.02
        assert np.all(np.diff(foam_curve.log_shift) < 0)
        assert np.log10(foam_curve.frequency.max() / foam_curve.frequency.min()) > 18

    @pytest.mark.parametrize(("name", "elements"), [("havriliak_negami", None), ("maxwell", 15), ("free_form", 20)])
    def test_laws_follow_the_whole_curve(self, foam_curve, name, elements):
        found = fit_law(name, foam_curve.frequency, foam_curve.modulus, elements=elements, starts=1 if elements else 4)
        assert found.mean_relative_error < 0.05
        assert found.mean_magnitude_error < 0.05

    @pytest.mark.parametrize(
        ("name", "elements"), [("fractional_zener", None), ("havriliak_negami", None), ("maxwell", 3)]
    )
    def test_laws_follow_the_curve_of_25_degrees(self, foam, name, elements):
        """The published fit of a fractional Zener law to it misses |E| by 8.2 %."""
        t, f, e = (values[foam[0] == REFERENCE] for values in foam)
        assert t.size == 11
        found = fit_law(name, f, e, elements=elements, starts=2)
        assert found.mean_relative_error < 0.03

    def test_wlf_holds_above_the_glass_transition(self, foam_curve):
        assert foam_curve.wlf(ZERO - 0.1).rms < 0.15
        assert foam_curve.wlf(ZERO - 0.1).rms < 0.5 * foam_curve.arrhenius(ZERO - 0.1).rms

    def test_one_isotherm_contradicts_itself(self, foam):
        """At 30 degC E1 rises less with frequency than E2 demands; at 25 degC all is well."""
        verdicts = {}
        for celsius in (25.0, 30.0):
            t, f, e = (values[foam[0] == ZERO + celsius] for values in foam)
            assert t.size == 11
            verdicts[celsius] = check_kramers_kronig(f, e, 0.02 * np.abs(e), 0.02 * np.abs(e)).verdict
        assert verdicts == {25.0: "consistent", 30.0: "inconsistent"}
