"""Time-temperature superposition: shifts of made-up materials found again."""

import numpy as np
import pytest
from multilayer_campaigns.master_curve import master_curve
from numpy.testing import assert_allclose

from multilayer.errors import InputError, ValidityWarning
from multilayer.media.laws import HavriliakNegami
from multilayer.media.superposition import entropic_shift, wlf_log_shift

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

    def test_standard_deviations_of_wlf_cover_the_truth(self):
        """One decade at each temperature: the shifts of all beyond a gap have most of their error in common."""
        scores = []
        for seed in range(10):
            with pytest.warns(ValidityWarning, match="do not overlap"):
                curve = master_curve(*data(0.01, band=(0.1, 3.0), seed=seed), reference=REFERENCE_K)
            found = curve.wlf()
            values, stds = ([part[name] for name in ("c1", "c2")] for part in (found.parameters, found.std))
            scores.append((np.array(values) - WLF) / stds)
        assert np.sqrt(np.mean(np.square(scores))) == pytest.approx(1.0, abs=0.4)

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
