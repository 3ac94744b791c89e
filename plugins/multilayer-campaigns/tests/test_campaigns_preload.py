"""Slopes of the modulus over the static stress, and the values without any."""

import numpy as np
import pytest
from comparable import drawn, point
from multilayer_campaigns.modulus_points import points_of, static_stress
from multilayer_campaigns.preload import fit_preload, refuse_one_stress

from multilayer.errors import InputError
from multilayer.fits.burst.fit import fit_bursts
from multilayer.rig.effect_base import GRAVITY
from multilayer.rig.synthesis import make_campaign
from tests.rig.virtual import rig_file

FREQUENCIES, STRESSES = (200.0, 400.0, 800.0), (80.0, 160.0, 240.0)
STIFFENING, DAMPING = 5e-4, -3e-4
UNCERTAINTY = {
    "channel_gain": 0.003, "channel_delay": 1e-6, "remount_gain": 0.001, "thickness": 5e-5, "density": 0.01,
    "top_plate_mass": 0.002,
}  # fmt: skip


def series(stiffening=STIFFENING, damping=DAMPING, by_frequency=0.0):
    """Return exact bursts of one specimen; `by_frequency` is added to the slope of E1 at the highest one."""
    found = []
    for f in FREQUENCIES:
        b = stiffening + (by_frequency if f == FREQUENCIES[-1] else 0.0)
        for s in STRESSES:
            e1, loss = 2e5 * (f / 200) ** 0.2 * (1 + b * s), 0.3 * (1 + damping * s)
            found.append(point(frequency=f, stress=s, storage_modulus=e1, loss_factor=loss))
    return found


class TestRegression:
    def test_exact_values_give_exact_slopes(self):
        found = fit_preload(["foam"], series())
        assert found.storage.value == pytest.approx(STIFFENING, rel=1e-6)
        assert found.loss.value == pytest.approx(DAMPING, rel=1e-6)
        assert found.solution.chi_square < 1e-9
        for row, f in zip(found.rows(), FREQUENCIES, strict=True):
            assert row["E1_0_pa"] == pytest.approx(2e5 * (f / 200) ** 0.2, rel=1e-9)
            assert row["loss_factor_0"] == pytest.approx(0.3, rel=1e-9)

    def test_a_slope_of_its_own_at_one_frequency(self):
        found = fit_preload(["foam"], series(by_frequency=2e-4))
        assert not found.storage.shared
        assert found.loss.shared
        assert found.storage.each == pytest.approx([STIFFENING, STIFFENING, STIFFENING + 2e-4], rel=1e-3)

    def test_common_errors_leave_the_slope_alone(self):
        """All heavy plates of one specimen share its gain: a percent of it is none of the slope."""
        found = fit_preload(["foam"], series())
        row = found.rows()[0]
        assert row["E1_0_std_pa"] / row["E1_0_pa"] > 0.01
        assert found.storage.std * 160 < 0.008

    def test_other_specimens_tell_nothing_of_a_slope(self):
        """A slimmer disc under one plate, ten percent stiffer, changes no slope."""
        other = [point(frequency=f, thickness=0.05, storage_modulus=2.2e5) for f in FREQUENCIES]
        found = fit_preload(["foam"], [*series(), *other])
        assert found.storage.value == pytest.approx(STIFFENING, rel=1e-6)
        assert len(found.cells) == 2 * len(FREQUENCIES)

    def test_probabilities_are_what_they_say(self):
        """Without any effect p is uniform, and the slope's distance in standard deviations is normal."""
        found = [fit_preload(["foam"], drawn(series(0.0, 0.0), seed)) for seed in range(150)]
        shares = [np.mean([one.storage.p_none < p for one in found]) for p in (0.05, 0.5)]
        assert 0.01 <= shares[0] <= 0.11  # one in 1000 samples of 150 is beyond
        assert 0.36 <= shares[1] <= 0.64
        distances = [one.storage.value / one.storage.std for one in found]
        assert np.std(distances) == pytest.approx(1.0, abs=0.2)

    def test_the_line_goes_through_the_values(self):
        found = fit_preload(["foam"], series())
        values, spread = found.regression.line(found.solution, found.cells[0], np.array([0.0, 80.0]))
        assert np.exp(values[1, 0]) == pytest.approx(series()[0].storage_modulus)
        assert spread[0, 0] == pytest.approx(found.rows()[0]["E1_0_std_pa"] / found.rows()[0]["E1_0_pa"])

    def test_one_stress_is_none(self):
        with pytest.raises(InputError, match=r"foam: no specimen .* under two static stresses \(80 Pa\)"):
            fit_preload(["foam"], [point(frequency=f) for f in FREQUENCIES])


class TestRig:
    """Signals of the virtual rig, which knows the weight on the sample."""

    @staticmethod
    def found(*effects, seed=1):
        plates = {"thicknesses": [0.025], "top_plates": [0.001, 0.002, 0.004]}
        file = rig_file(*effects, configurations=plates, uncertainty=UNCERTAINTY, frequencies=[200.0, 450.0])
        made = make_campaign(file, seed)
        fitted = fit_bursts(made.campaign, made.recordings)
        return made, fit_preload(["foam"], points_of(0, made.campaign, fitted))

    def test_stiffening_is_found(self):
        made, found = self.found({"effect": "preload", "stiffening": STIFFENING})
        assert found.storage.verdict == "seen"
        assert abs(found.storage.value - STIFFENING) < 2.5 * found.storage.std
        assert found.storage.std < 0.05 * STIFFENING
        assert found.loss.verdict == "none"
        lightest = [m for m in made.truth["moduli"] if m["configuration"] == "h25mm-t1mm"]
        stress = static_stress(made.campaign, made.campaign.configurations[0])
        for row, truth in zip(found.rows(), lightest, strict=True):
            without = truth["E1_pa"] / (1 + STIFFENING * stress)
            assert abs(row["E1_0_pa"] - without) < 3 * row["E1_0_std_pa"] < 0.02 * without

    def test_nothing_is_found_where_there_is_nothing(self):
        _, found = self.found()
        assert (found.storage.verdict, found.loss.verdict) == ("none", "none")
        assert found.verdict.startswith("no effect of the static stress is seen: at 308 Pa E1 changes by")

    def test_stress(self):
        made, _ = self.found()
        one = made.campaign.configurations[0]
        assert static_stress(made.campaign, one) == pytest.approx(GRAVITY * 7850 * 0.001)
        area = np.pi * one.specimen_radius**2
        assert static_stress(made.campaign, one, 0.01) == pytest.approx(GRAVITY * (7.85 + 0.01 / area))

    def test_campaigns_that_cannot_tell_are_refused_before_the_fit(self):
        made = make_campaign(rig_file(frequencies=[200.0]))
        with pytest.raises(InputError, match="was measured at one frequency under two static stresses"):
            refuse_one_stress([made.campaign])
