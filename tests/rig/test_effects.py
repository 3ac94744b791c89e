"""Every effect does what its law says, to the signals or to what the finite elements are given."""

import numpy as np
import pytest

from multilayer.media.rod import rod_transmissibility
from multilayer.rig.bench import Bench, rigid_modulus
from multilayer.rig.effect_base import GRAVITY, REFERENCE_FREQUENCY
from multilayer.rig.effects.clock_skew import resampled
from tests.rig.virtual import DATA, bench, measured, rig_file, rod

F = np.array(DATA["frequencies"])
HEIGHTS = {"thicknesses": [0.0125, 0.025], "top_plates": [0.001]}


@pytest.fixture
def as_rod(monkeypatch):
    """Take a rod in place of the finite elements."""
    monkeypatch.setattr(Bench, "_transmissibility", rod)


@pytest.fixture
def plain(as_rod):
    """Give top over base without any effect."""
    return measured()


class TestNoEffect:
    def test_nothing_stands_for_a_rigid_rod(self):
        geometry = bench().geometry
        assert geometry["poisson_ratio"] == 0
        assert geometry["plate_modulus"] == pytest.approx(2.1e13, rel=0.3)
        assert not {"sensor_mass", "adhesive_thickness", "porosity", "base_thickness"} & set(geometry)

    def test_a_rigid_plate_bends_at_50_khz(self):
        e = rigid_modulus(0.0225, 0.001, 7850, 2.1e11, 0.3)
        bending = e * 0.001**3 / 12 / (1 - 0.3**2)
        assert 9.003 / (2 * np.pi * 0.0225**2) * np.sqrt(bending / 7.85) == pytest.approx(50e3)
        assert rigid_modulus(0.01, 0.01, 7850, 2.1e11, 0.3) == 2.1e11


# effect, and what it makes of T at a frequency
CHAIN = {
    "gain": ({"effect": "channel_gain", "gain": 0.03}, lambda f, t: 1.03 * t),
    "gain with a slope": (
        {"effect": "channel_gain", "gain": 0.03, "perturbation": 0.2},
        lambda f, t: t * (1 + 0.03 * (1 + 0.2 * np.log(f / REFERENCE_FREQUENCY))),
    ),
    "delay": ({"effect": "channel_delay", "delay": 2e-5}, lambda f, t: t * np.exp(-2j * np.pi * f * 2e-5)),
    "high pass": ({"effect": "high_pass", "cut_off": 8}, lambda f, t: t / (1 - 8j / f)),
    "steeper high pass": (
        {"effect": "high_pass", "cut_off": 8, "perturbation": 0.5},
        lambda f, t: t / (1 - 8j / f) ** 1.5,
    ),
    "crosstalk": (
        {"effect": "crosstalk", "share": 0.02, "delay": 1e-4},
        lambda f, t: t + 0.02 * np.exp(-2j * np.pi * f * 1e-4),
    ),
    "crosstalk through a capacitance": (
        {"effect": "crosstalk", "share": 0.02, "perturbation": 0.5},
        lambda f, t: t + 0.02 * (1j * f / REFERENCE_FREQUENCY) ** 0.5,
    ),
    "mount": (
        {"effect": "sensor_mount", "frequency": 5000, "loss_factor": 0.2},
        lambda f, t: t / (1 - (f / 5000) ** 2 + 0.2j * f / 5000),
    ),
    "rocking": (
        {"effect": "rocking", "share": 0.05, "frequency": 600, "loss_factor": 0.3},
        lambda f, t: t + 0.05 * f**2 / (600**2 - f**2 + 0.3j * 600 * f),
    ),
    "cable": (
        {"effect": "cable_resonance", "frequency": 500, "loss_factor": 0.4, "depth": 0.3},
        lambda f, t: t * (500**2 - f**2 + 0.28j * 500 * f) / (500**2 - f**2 + 0.4j * 500 * f),
    ),
    "tilt": (
        {"effect": "base_tilt", "share": 0.05, "frequency": 600, "loss_factor": 0.3},
        lambda f, t: t / (1 + 0.05 * f**2 / (600**2 - f**2 + 0.3j * 600 * f)),
    ),
}


@pytest.mark.parametrize("case", CHAIN)
def test_reading(plain, case):
    effect, law = CHAIN[case]
    assert measured(effect) == pytest.approx(law(F[:, np.newaxis], plain), rel=2e-5)


def test_the_order_of_two_effects_counts(plain):
    gain, talk = {"effect": "channel_gain", "gain": 0.1}, {"effect": "crosstalk", "share": 0.02}
    assert measured(gain, talk) == pytest.approx(1.1 * plain + 0.02, rel=2e-5)
    assert measured(talk, gain) == pytest.approx(1.1 * (plain + 0.02), rel=2e-5)


class TestClockSkew:
    def test_delay_grows_over_the_record(self, plain):
        skew = 1e-4
        shift = np.angle(measured({"effect": "clock_skew", "skew": skew}) / plain)
        # on average the top of a burst is read at the time of its crest
        least = 2 * np.pi * F * skew * (0.005 + 5 / F)
        for repeat in shift.T:
            assert np.all(repeat > least)
            assert repeat == pytest.approx(least, rel=0.5)

    def test_resampling_is_exact(self):
        time = np.arange(4000) / 25600
        index = np.arange(4000) * 1.0003 + 0.4

        def tone(t):
            return np.sin(2 * np.pi * 1500 * t) * np.exp(-(((t - 0.07) / 0.01) ** 2))

        assert resampled(tone(time), index) == pytest.approx(tone(index / 25600), abs=1e-6)


class TestGeometry:
    def test_sensor(self):
        found = bench({"effect": "sensor_mass", "mass": 1.5e-3, "radius": 0.004}).geometry
        assert (found["sensor_mass"], found["sensor_radius"]) == (1.5e-3, 0.004)
        moved = bench({"effect": "sensor_mass", "perturbation": 0.5}).geometry
        assert moved["sensor_radius"] == pytest.approx(0.5 * (0.0225 - 0.003))
        assert moved["plate_modulus"] == 2.1e11

    def test_sensor_loads_the_rod(self, as_rod):
        found = measured({"effect": "sensor_mass", "mass": 1e-3})
        mass = 7.85 + 1e-3 / (np.pi * 0.0225**2)
        law = rig_file().specimen.modulus
        expected = rod_transmissibility(F, law(F), 80, 0.025, mass)
        assert found[:, 0] == pytest.approx(expected, rel=2e-5)

    def test_adhesive(self):
        found = bench({"effect": "adhesive", "young_modulus": "1 MPa", "loss_factor": 0.5}).geometry
        assert found["adhesive_modulus"](np.array([100.0, 900.0])) == pytest.approx([1e6 + 5e5j] * 2)
        stiffer = bench({"effect": "adhesive", "young_modulus": 1e6, "loss_factor": 0, "perturbation": 0.2}).geometry
        assert abs(stiffer["adhesive_modulus"](np.array(1000.0))) == pytest.approx(1e6 * 2**0.2)

    def test_finite_size(self):
        found = bench({"effect": "finite_size", "perturbation": 0.2}).geometry
        assert (found["poisson_ratio"], found["transverse_ratio"]) == (0.3, 1.2)

    def test_flexure(self):
        found = bench({"effect": "plate_flexure", "radius": 0.01}).geometry
        assert (found["plate_modulus"], found["reading_radius"]) == (2.1e11, 0.01)

    def test_delamination_of_some_configurations(self):
        effect = {"effect": "delamination", "bonded_fraction": 0.8, "configurations": ["h25mm-t1mm"]}
        shares = [bench(effect, index=i, configurations=HEIGHTS).geometry.get("bonded_fraction") for i in (0, 1)]
        assert shares == [None, 0.8]
        effect = {"effect": "delamination", "bonded_fraction": 0.8, "perturbation": 0.5}
        shares = [bench(effect, index=i, configurations=HEIGHTS).geometry["bonded_fraction"] for i in (0, 1)]
        assert shares == pytest.approx([0.7, 0.9])

    def test_flanking(self):
        effect = {"effect": "flanking", "stiffness": "1 kN/m", "loss_factor": 0.2, "perturbation": 0.5}
        found = [bench(effect, index=i, configurations=HEIGHTS).geometry["flanking_stiffness"] for i in (0, 1)]
        assert found == pytest.approx([(1000 + 200j) * 2**0.5, 1000 + 200j])

    def test_skin(self):
        found = bench({"effect": "skin", "thickness": "2 mm", "ratio": 5}).geometry
        assert (found["skin_thickness"], found["skin_ratio"]) == (0.002, 5)
        soft = bench({"effect": "skin", "thickness": "2 mm", "ratio": 5, "perturbation": 0.1}).geometry
        profile = soft["modulus_profile"](np.array([0.0, 0.08, 0.5, 0.92, 1.0]))
        assert profile == pytest.approx([5, 3, 1, 3, 5], abs=1e-3)

    def test_what_the_specimen_has_is_taken(self):
        specimen = {
            **DATA["specimen"],
            "flow_resistivity": 5e4,
            "viscous_length": 1e-4,
            "skin": {"thickness": 1e-3, "ratio": 2},
            "grading": [1, 2],
            "transverse_ratio": 0.5,
        }
        found = bench("saturating_air", "skin", "grading", "finite_size", "anisotropy", specimen=specimen).geometry
        assert (found["flow_resistivity"], found["viscous_length"], found["porosity"]) == (5e4, 1e-4, 0.97)
        assert (found["skin_ratio"], found["modulus_profile"], found["transverse_ratio"]) == (2, (1, 2), 0.5)
        own = bench({"effect": "saturating_air", "flow_resistivity": 1e4}, specimen=DATA["specimen"]).geometry
        assert own["flow_resistivity"] == 1e4

    def test_pores_are_cylinders(self):
        """Poiseuille: sigma = 8 eta / (phi r^2), and both characteristic lengths follow from the radius."""
        found = bench({"effect": "saturating_air", "porosity": 0.9, "flow_resistivity": 1e4}).geometry
        radius = np.sqrt(8 * 1.84e-5 / 0.9 / 1e4)
        assert found["viscous_length"] == pytest.approx(radius, rel=0.02)
        assert found["thermal_length"] == pytest.approx(2 * found["viscous_length"])

    def test_elastic_base(self):
        found = bench(base_plate={"elastic": True}).geometry
        assert (found["base_thickness"], found["base_modulus"]) == (0.01, 7e10)


class TestModulus:
    def test_preload(self):
        effect = {"effect": "preload", "stiffening": 1e-3}
        sensor = {"effect": "sensor_mass", "mass": 1e-3}
        for effects, mass in (((effect,), 7.85), ((sensor, effect), 7.85 + 1e-3 / (np.pi * 0.0225**2))):
            one = bench(*effects)
            found = one.modulus(F, one.moment(200.0, 0)) / one.settings.specimen.modulus(F)
            assert found == pytest.approx(1 + 1e-3 * GRAVITY * mass)

    def test_drift_follows_the_order_of_measurement(self):
        effect = {"effect": "temperature_drift", "total": -0.2}
        benches = [bench(effect, index=i, configurations=HEIGHTS) for i in (0, 1)]
        moments = [(one, one.moment(f, r)) for one in benches for f in F for r in (0, 1)]
        found = [float((one.modulus(F, m) / one.settings.specimen.modulus(F)).real[0]) for one, m in moments]
        # two repeats of six bursts, all of it from the last burst on
        assert found == pytest.approx(1 - 0.2 * np.minimum(np.arange(12) / 10, 1))

    def test_drift_of_remounted_repeats(self):
        one = bench({"effect": "temperature_drift", "rate": 0.01}, remount={"gain": 0.0})
        found = [one.moment(f, r).elapsed for r in (0, 1) for f in F]
        assert found == pytest.approx(np.arange(6) / 2)
        assert one.modulus(F, one.moment(900.0, 1)) == pytest.approx(one.settings.specimen.modulus(F) * 1.025)

    def test_drift_is_in_the_signals(self, plain):
        found = measured({"effect": "temperature_drift", "total": 0.3})
        law = rig_file().specimen.modulus
        scale = 1 + 0.3 * np.minimum(np.arange(6).reshape(3, 2) / 4, 1)
        expected = rod_transmissibility(F[:, np.newaxis], law(F)[:, np.newaxis] * scale, 80, 0.025, 7.85)
        assert found == pytest.approx(expected, rel=2e-5)

    def test_creep_starts_again_with_each_mounting(self):
        for index in (0, 1):
            one = bench({"effect": "creep", "rate": 0.05}, index=index, configurations=HEIGHTS)
            found = one.modulus(F, one.moment(900.0, 1)) / one.settings.specimen.modulus(F)
            assert found == pytest.approx(1 + 0.05 * np.log(1 + 2.5))

    def test_dispersion_changes_nothing(self, plain):
        assert np.array_equal(measured("dispersion"), plain)


class TestFiniteElements:
    """What the effects give the finite elements arrives there."""

    def test_the_rigid_rig_is_a_rod(self):
        one = bench()
        found, f = one.response(one.moment(200.0, 0)), one.bins
        inside = (f > 50) & (f < 2000)
        expected = rod_transmissibility(f[inside], rig_file().specimen.modulus(f[inside]), 80, 0.025, 7.85)
        assert found[inside] == pytest.approx(expected, rel=1e-4)

    def test_a_sensor_is_a_mass(self):
        one = bench("sensor_mass")
        found = one.response(one.moment(200.0, 0))[one.bins == one.bins[100]]
        mass = 7.85 + 1e-3 / (np.pi * 0.0225**2)
        f = one.bins[100]
        expected = rod_transmissibility(f, rig_file().specimen.modulus(f), 80, 0.025, mass)
        assert found[0] == pytest.approx(complex(expected), rel=2e-4)

    def test_glue_is_a_compliance_in_series(self):
        """Far below the resonance of the sample: h/E of both layers of glue adds to that of the sample."""
        one = bench({"effect": "adhesive", "thickness": 5e-4, "young_modulus": 5e4, "density": 1, "loss_factor": 0})
        i = int(np.argmin(np.abs(one.bins - 60)))
        f = one.bins[i]
        law = complex(rig_file().specimen.modulus(f))
        softer = 0.026 / (0.025 / law + 2 * 5e-4 / 5e4)
        found = one.response(one.moment(200.0, 0))[i]
        plain, expected = (rod_transmissibility(f, e, 80, 0.0255, 7.85) - 1 for e in (law, softer))
        assert found - 1 == pytest.approx(complex(expected), rel=0.02)
        assert abs(expected / plain) > 1.05
