"""The rod that softens with strain: its law, its Prony series, and its motion in time."""

import numpy as np
import pytest

from multilayer.media.laws import FractionalZener
from multilayer.media.rod import rod_transmissibility
from multilayer.rig.excitation import Timing
from multilayer.rig.rod_difference import modulus_scale, rod_of, softened_difference, softening_of
from multilayer.rig.softening import PronySeries, SofteningRod, fit_prony
from multilayer.signals.spectra import frequencies, to_signal, to_spectrum
from tests.rig.virtual import bench

RATE = 25600.0
ZENER = FractionalZener(relaxed_modulus=1e5, unrelaxed_modulus=1e6, relaxation_time=1e-4, order=0.5)
MAXWELL = PronySeries(np.array([2e5]), np.array([[1.5e5]]), np.array([4e-4]))


def rods(series=MAXWELL, softening=0.0, exponent=1.0, highest=600.0):
    return SofteningRod(0.025, 80.0, 7.85, series, softening, exponent, highest)


def linear_top(series, base, rate):
    """Return the top of a rod by the closed form; padded, so that nothing wraps round."""
    n_fft = 8 * base.size
    f = frequencies(n_fft, rate)
    ratio = np.ones(f.size, dtype=complex)
    single = PronySeries(series.relaxed[0], series.stiffnesses[:, 0], series.times)
    ratio[1:] = rod_transmissibility(f[1:], single(f[1:]), 80.0, 0.025, 7.85)
    return to_signal(ratio * to_spectrum(base, n_fft), n_fft, base.size)


class TestPronySeries:
    @pytest.mark.parametrize(
        ("law", "error"),
        [(ZENER, 5e-4), (lambda f: 2e5 * (1j * f / 500) ** 0.06, 5e-4)],
        ids=["fractional", "constant loss"],
    )
    def test_follows_a_law(self, law, error):
        f = np.geomspace(20, 5000, 80)
        series = fit_prony(f, law(f))
        assert np.max(np.abs(series(f) / law(f) - 1)) < error
        assert np.all(series.stiffnesses >= 0)

    def test_of_an_elastic_solid(self):
        f = np.geomspace(20, 5000, 40)
        series = fit_prony(f, np.full(f.size, 3e5 + 0j))
        assert series.relaxed == pytest.approx(3e5)
        assert series.instantaneous == pytest.approx(3e5)

    def test_of_a_maxwell_element_in_closed_form(self):
        single = PronySeries(np.array(2e5), np.array([1.5e5]), np.array([4e-4]))
        turn = 2j * np.pi * 300 * 4e-4
        assert complex(single(300.0)) == pytest.approx(2e5 + 1.5e5 * turn / (1 + turn))


class TestLinearRod:
    def test_meets_the_closed_form(self):
        errors = []
        for highest, least in ((600.0, 4), (8000.0, 16)):
            rod = rods(highest=highest)
            steps = max(least, rod.oversampling(RATE))
            timing = Timing(RATE, 10.0, 5.0, (400.0,), 0.1)
            base = timing.base(400.0, oversampling=steps)
            found = rod.top(base[np.newaxis], steps * RATE)[0]
            expected = linear_top(MAXWELL, base, steps * RATE)
            errors.append(np.max(np.abs(found - expected)) / np.max(np.abs(expected)))
        assert errors[0] < 0.005
        assert errors[1] < 0.15 * errors[0]  # finer in space and time

    def test_softening_of_zero_changes_nothing(self):
        base = Timing(RATE, 10.0, 5.0, (400.0,), 0.1).base(400.0, oversampling=4)[np.newaxis]
        assert np.array_equal(rods().top(base, 4 * RATE), rods().top(base, 4 * RATE, softened=False))


class TestLaw:
    def test_first_harmonic(self):
        """Of e - b e |e| the first harmonic is that of a linear sample of modulus 1 - 8 b e / (3 pi)."""
        amplitude, softening = 1e-3, 1.0
        phase = 2 * np.pi * np.arange(4096) / 4096
        found = rods(softening=softening).effective(amplitude * np.sin(phase))
        first, third = (2 * np.mean(found * np.sin(k * phase)) / amplitude for k in (1, 3))
        assert 1 - first == pytest.approx(8 / (3 * np.pi) * softening * amplitude, rel=0.002)
        assert third == pytest.approx(8 / (15 * np.pi) * softening * amplitude, rel=0.005)

    @pytest.mark.parametrize("exponent", [0.5, 1.0, 1.3, 1.5])
    def test_stress_rises_with_strain_and_all_exponents_meet(self, exponent):
        rod = rods(softening=50.0, exponent=exponent)
        strain = np.concatenate([[0.0], np.geomspace(1e-8, 10, 500)])
        assert np.all(np.diff(rod.effective(strain)) > 0)
        assert rod.effective(-strain) == pytest.approx(-rod.effective(strain))
        slight = rods(softening=1.0, exponent=exponent).effective(np.array(1e-3))
        assert 1 - slight / 1e-3 == pytest.approx(1e-3, rel=2e-3)

    def test_odd_harmonics_that_grow_with_the_square_of_the_level(self):
        rod, steps = rods(softening=20.0), 4
        timing = Timing(RATE, 10.0, 5.0, (150.0,), 0.1)
        base = timing.base(150.0, oversampling=steps)[np.newaxis]
        differences = [
            rod.top(k * base, steps * RATE)[0] - rod.top(k * base, steps * RATE, softened=False)[0]
            for k in (0.01, 0.02)
        ]
        assert np.linalg.norm(differences[1]) / np.linalg.norm(differences[0]) == pytest.approx(4, rel=0.02)
        top = rod.top(base, steps * RATE)[0]
        time = np.arange(top.size) / (steps * RATE)
        lines = [abs(np.sum(top * np.exp(-2j * np.pi * 150 * k * time))) for k in (1, 2, 3)]
        assert lines[2] > 1e-3 * lines[0]
        assert lines[1] < 0.05 * lines[2]


class TestBesideTheFiniteElements:
    def test_the_rod_is_that_of_the_rig(self):
        """Under a rigid plate, without Poisson's ratio, the finite elements are the rod."""
        one = bench("amplitude_softening")
        assert modulus_scale(one) == pytest.approx(1.0, abs=2e-3)
        rod = rod_of(one, softening_of(one))
        assert (rod.thickness, rod.density, rod.top_mass) == (0.025, 80.0, pytest.approx(7.85))
        assert rod.series.stiffnesses.shape[1] == 3

    def test_a_bulging_sample_has_a_stiffer_rod(self):
        assert 1.05 < modulus_scale(bench("amplitude_softening", "finite_size")) < 1.35

    def test_what_is_added(self):
        one = bench({"effect": "amplitude_softening", "softening": 50})
        added = softened_difference(one, softening_of(one), 1500)
        assert added.shape == (3, 1500)
        assert not added[:, :100].any()  # at rest
        tops = [to_signal(one.response(one.moment(f, 0)) * one.timing.base_spectrum(f), one.timing.n_fft, 1500)
                for f in one.mounting.frequencies]  # fmt: skip
        shares = np.abs(added).max(axis=1) / np.abs(tops).max(axis=1)
        assert shares[0] > 3 * shares[2]  # strain falls with frequency
        assert 0.005 < shares[0] < 0.2
