"""Campaigns of the virtual rig as those who read them find them."""

import io
import json

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.fits.burst.fit import fit_bursts
from multilayer.measurements.campaign import load_campaign, load_recordings
from multilayer.measurements.writing import signal_bytes
from multilayer.rig.bench import Bench
from multilayer.rig.synthesis import make_campaign
from multilayer.rig.writer import write_campaign
from multilayer.signals.quality import check_configuration
from multilayer.signals.spectra import noise_level
from tests.rig.virtual import LAW, ratio, rig_file, rod

STATED = {
    "channel_gain": 0.003,
    "channel_delay": 1e-6,
    "remount_gain": 0.001,
    "thickness": 5e-5,
    "density": 0.01,
    "top_plate_mass": 0.002,
}
SIX = {"thicknesses": [0.0125, 0.025, 0.05], "top_plates": [0.001, 0.003]}
LOUD = {"white": 0.004, "bits": 24}


@pytest.fixture
def as_rod(monkeypatch):
    """Take a rod in place of the finite elements."""
    monkeypatch.setattr(Bench, "_transmissibility", rod)


def made(*effects, seed=None, **changes):
    return make_campaign(rig_file(*effects, **{"noise": LOUD, **changes}), seed)


class TestSignals:
    def test_no_objection_from_the_quality_checks(self, as_rod):
        every = [100.0 * i for i in range(1, 16)]
        found = made("channel_delay", frequencies=every, configurations=SIX, uncertainty=STATED, repeats=3)
        assert len(found.recordings) == 90
        for one in found.campaign.configurations:
            recordings = {burst.frequency: found.recordings[one.name, burst.frequency] for burst in one.bursts}
            assert check_configuration(recordings) == []

    def test_level_and_noise(self, as_rod):
        found = made(repeats=20, noise={"white": 0.01, "base": 0.002, "bits": None})
        for (_, frequency), recording in found.recordings.items():
            during = (recording.time > 0.005) & (recording.time < 0.005 + 10 / frequency)
            base, top = recording.mean()
            assert np.sqrt(np.mean(base[during] ** 2)) == pytest.approx(5.0, rel=0.005)
            noise = noise_level(recording)
            assert noise.base == pytest.approx(0.002 * 5.0, rel=0.03)
            assert noise.top == pytest.approx(0.01 * np.sqrt(np.mean(top[during] ** 2)), rel=0.03)

    def test_rest_before_and_after(self, as_rod):
        found = made(noise={"white": 0, "bits": None})
        for recording in found.recordings.values():
            for channel in recording.mean():
                crest = np.max(np.abs(channel))
                assert np.max(np.abs(channel[:100])) < 1e-4 * crest
                assert np.max(np.abs(channel[-20:])) < 2e-3 * crest

    def test_a_lightly_damped_sample_rings_longer(self, as_rod):
        light = {"density": 80, "young_modulus": {"law": "loss_factor", "young_modulus": 1e5, "loss_factor": 0.02}}
        long, short = (made(specimen=s, noise={"white": 0}) for s in (light, {**light, "young_modulus": LAW}))
        n = [one.recordings["h25mm-t1mm", 500.0].n_samples for one in (long, short)]
        assert n[0] > 3 * n[1]
        top = long.recordings["h25mm-t1mm", 500.0].mean()[1]
        assert np.max(np.abs(top[-50:])) < 2e-3 * np.max(np.abs(top))

    def test_too_loud_for_the_converters(self, as_rod):
        with pytest.raises(
            InputError, match=r"the base channel reaches 11.* beyond this range of 10 m/s2; raise it, or"
        ):
            made(noise={"white": 0, "full_scale": 10})


class TestErrors:
    def test_stated_ones_are_in_the_signals(self, as_rod):
        """What is drawn, and told in the truth only, explains the signals to the last digit."""
        found = made(configurations=SIX, uncertainty=STATED, noise={"white": 0, "bits": None}, seed=3)
        errors, law = found.truth["errors"], rig_file().specimen.modulus
        heights = {entry["nominal"]: entry["error"] for entry in errors["thickness"]}
        plates = {entry["nominal"]: entry["error"] for entry in errors["top_plate_mass"]}
        for one in found.campaign.configurations:
            rho = 80 * (1 + errors["density"])
            mass = 7850 * one.top_plate_thickness * (1 + plates[one.top_plate_thickness])
            h = one.specimen_thickness + heights[one.specimen_thickness]
            gain = (1 + errors["channel_gain"]) * (1 + errors["remount_gain"][one.name])
            for burst in one.bursts:
                f = burst.frequency
                g = 2j * np.pi * f * np.sqrt(rho / law(f)) * h
                t = gain * np.exp(-2j * np.pi * f * errors["channel_delay"])
                t /= np.cosh(g) + mass / rho / h * g * np.sinh(g)
                assert ratio(found.recordings[one.name, f], f) == pytest.approx(complex(t), rel=3e-5)

    def test_have_their_standard_deviations(self, as_rod):
        drawn = [made(frequencies=[500.0], uncertainty=STATED, repeats=1, seed=s).truth["errors"] for s in range(120)]
        of_plate = {"top_plate_mass": [one["top_plate_mass"][0]["error"] for one in drawn]}
        for name in ("channel_gain", "channel_delay", "density", "top_plate_mass"):
            values = np.array(of_plate.get(name) or [one[name] for one in drawn])
            assert np.std(values) == pytest.approx(STATED[name], rel=0.25)
            assert abs(np.mean(values)) < 0.3 * STATED[name]

    def test_remounted_repeats_scatter(self, as_rod):
        found = made(repeats=40, remount={"gain": 0.02, "stiffness": 0.0}, noise={"white": 0})
        ratios = np.abs([ratio(recording, f) for (_, f), recording in found.recordings.items()])
        scatter = ratios / ratios.mean(axis=1, keepdims=True) - 1
        assert scatter.std(axis=1) == pytest.approx(0.02, rel=0.3)
        assert np.corrcoef(scatter)[0, 1] > 0.999  # one mounting, all bursts
        soft = made(repeats=3, remount={"stiffness": 0.05}, noise={"white": 0})
        assert np.ptp(np.abs(ratio(soft.recordings["h25mm-t1mm", 500.0], 500.0))) > 1e-3

    def test_none_without_uncertainty(self, as_rod):
        errors = made().truth["errors"]
        assert errors["channel_gain"] == errors["density"] == errors["remount_gain"]["h25mm-t1mm"] == 0


class TestTruth:
    def test_campaign_knows_nothing_of_it(self, as_rod):
        effects = ({"effect": "sensor_mass", "mass": 2e-3}, "crosstalk", "preload")
        lie = made(*effects, uncertainty=STATED).campaign
        assert lie == made(uncertainty=STATED).campaign
        assert (lie.specimen.density, lie.specimen.poisson_ratio) == (80, 0)
        assert made("finite_size").campaign.specimen.poisson_ratio == 0.3

    def test_what_it_tells(self, as_rod):
        truth = made({"effect": "preload", "stiffening": 1e-3, "perturbation": 0.1}, seed=5).truth
        assert (truth["effect"], truth["parameters"], truth["nu"], truth["noise"]) == (
            "preload",
            {"stiffening": 1e-3},
            0,
            0.004,
        )
        assert truth["effects"] == [
            {"effect": "preload", "known": True, "perturbation": 0.1, "parameters": {"stiffening": 1e-3}}
        ]
        assert truth["seed"] == 5
        assert truth["material"] | {"young_modulus": 0} == {
            "rho": 80,
            "E0": 1e5,
            "ratio": 10,
            "tau": 1e-4,
            "alpha": 0.5,
            "young_modulus": 0,
        }
        stress = 9.80665 * 7.85
        factor = 1 + 1e-3 * stress * (stress / 100) ** 0.1
        at_500 = next(entry for entry in truth["moduli"] if entry["frequency_hz"] == 500)
        assert complex(at_500["E1_pa"], at_500["E2_pa"]) == pytest.approx(
            complex(rig_file().specimen.modulus(500.0)) * factor
        )
        assert json.loads(json.dumps(truth, allow_nan=False)) == truth

    @pytest.mark.parametrize(
        ("effects", "name"),
        [((), "none"), (("clock_skew",), "clock_skew"), (("preload", "crosstalk"), "preload+crosstalk")],
    )
    def test_name(self, as_rod, effects, name):
        truth = made(*effects).truth
        assert truth["effect"] == name
        assert [one["known"] for one in truth["effects"]] == [one != "clock_skew" for one in effects]


class TestRepeatable:
    def test_same_seed_same_bytes(self, as_rod):
        first, again, other = (made(uncertainty=STATED, seed=s) for s in (1, 1, 2))
        key = ("h25mm-t1mm", 500.0)
        bytes_of = [signal_bytes(one.recordings[key]) for one in (first, again, other)]
        assert bytes_of[0] == bytes_of[1] != bytes_of[2]

    def test_an_effect_changes_no_draw(self, as_rod):
        plain, lie = made(uncertainty=STATED), made("channel_gain", uncertainty=STATED)
        assert plain.truth["errors"] == lie.truth["errors"]

    def test_on_disk_as_in_memory(self, as_rod, tmp_path):
        found = made("crosstalk", uncertainty=STATED, configurations=SIX)
        write_campaign(found, tmp_path / "foam")
        campaign = load_campaign(tmp_path / "foam")
        assert campaign.model_dump() == found.campaign.model_dump()
        read = load_recordings(campaign)
        assert list(read) == list(found.recordings)
        for key, recording in read.items():
            assert np.array_equal(recording.base, found.recordings[key].base)
            assert np.array_equal(recording.top, found.recordings[key].top)

    def test_archives_hold_no_date(self, as_rod):
        recording = made().recordings["h25mm-t1mm", 500.0]
        with np.load(io.BytesIO(signal_bytes(recording))) as archive:
            assert archive["base"].dtype == np.float32
            assert {info.date_time[0] for info in archive.zip.infolist()} == {1980}


def test_a_fit_recovers_the_law(tmp_path):
    """Finite elements, no effect: what is found lies within its stated uncertainty of what is true."""
    frequencies = [200.0, 500.0, 900.0]
    found = made(frequencies=frequencies, uncertainty=STATED, repeats=3, seed=11)
    write_campaign(found, tmp_path / "foam")
    campaign = load_campaign(tmp_path / "foam")
    result = fit_bursts(campaign, load_recordings(campaign))
    assert result.all_accepted
    for burst, true in zip(result.bursts, found.truth["moduli"], strict=True):
        assert burst.frequency == true["frequency_hz"]
        assert abs(burst.storage_modulus - true["E1_pa"]) < 3 * burst.storage_modulus_std
        assert abs(burst.loss_modulus - true["E2_pa"]) < 3 * burst.loss_modulus_std
        assert burst.storage_modulus_std < 0.03 * true["E1_pa"]
