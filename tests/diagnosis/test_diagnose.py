"""Diagnoses of campaigns whose effect is known: synthetic ones, and those of an independent solver."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from multilayer import diagnosis
from multilayer.arrays import ComplexArray
from multilayer.diagnosis.diagnose import (
    N_STEPS,
    chosen_effects,
    diagnose_campaign,
    fit_nominal,
    fits_one_by_one,
    warn_of_settings,
)
from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.effects.base import Setting, Values
from multilayer.diagnosis.effects.channel_gain import ChannelGain
from multilayer.diagnosis.fitting import Fitted, begin, best_of, fit_effects, polish_fits
from multilayer.diagnosis.goodness_of_fit import lack_of_fit
from multilayer.diagnosis.places import PLACES
from multilayer.diagnosis.places.plate import InCentre, TopPlate
from multilayer.diagnosis.saved_law import saved_law
from multilayer.diagnosis.starting_laws import starting_laws
from multilayer.errors import InputError, PlausibilityWarning, PluginWarning
from multilayer.experiments.places import SimpleLaw, Term
from multilayer.experiments.two_plate.nuisances import with_usual_uncertainty
from multilayer.experiments.two_plate.plane_waves import PlaneWaveRig
from multilayer.fits.settings import FitSettings
from multilayer.fits.sources import read_fit
from multilayer.measurements.description import USUAL_UNCERTAINTY, Uncertainty
from multilayer.report.diagnosis import diagnosis_report
from multilayer.rig import TwoPlateRig
from multilayer.rig.synthesis import make_campaign
from multilayer.testing.benches import joint_bench, soft_sample
from tests.fits.test_joint import LAW, campaign_and_signals
from validation.blind_check.draw import draw

KEYS = {"version", "verdict", "where", "causes", "group", "gap", "unknowns", "detectable", "next_experiment"}
FEW = ("channel_gain", "channel_delay", "crosstalk", "sensor_mass", "adhesive")


@pytest.fixture(scope="module")
def gain():
    campaign, recordings = campaign_and_signals(gain=1.05)
    told = []
    result = diagnose_campaign(campaign, recordings, chosen_effects(FEW), progress=told.append)
    assert len(told) == N_STEPS
    return result


def test_a_wrong_gain_is_named_with_its_size(gain):
    record = gain.record
    assert record["verdict"] == "effect"
    assert record["group"][0] == ["channel_gain"]
    size = next(c for c in record["causes"] if c["effects"] == ["channel_gain"])["parameters"]["channel_gain.gain"]
    assert size["low"] < 0.05 < size["high"]
    assert record["gap"]["shrinkage"] > 0.9
    assert record["gap"]["held_out"] == "leave one configuration out"


def test_a_density_that_is_wrong_is_a_gap_by_itself_and_told_with_its_value():
    campaign, recordings = campaign_and_signals({"density": 0.12}, noise=0.005)
    result = diagnose_campaign(campaign, recordings, chosen_effects(["channel_gain", "crosstalk"]))
    record, wrong = result.record, result.record["wrong_statement"]
    assert record["verdict"] == "unknown"
    assert "what is stated of the laboratory is wrong: density by 12." in record["sentence"]
    assert wrong["name"] == "density"
    assert wrong["low"] < 0.12 < wrong["high"]
    assert wrong["high"] - wrong["low"] < 0.02
    assert wrong["tied"] == ["top_plate_mass[0.001]"]  # with one plate the data tell the ratio of masses alone
    assert record["stated_deviations"]["density"]["corrected"] == pytest.approx(12, abs=1)
    assert record["gap"]["shrinkage"] > 0.95
    told = record["moduli"]["corrected"]
    true = LAW(np.array(record["moduli"]["frequency_hz"]))
    assert np.mean((told["E1_low"] < true.real) & (true.real < told["E1_high"])) > 0.9
    with pytest.raises(InputError, match=r"density or top_plate_mass\[0.001\] is stated wrongly"):
        saved_law(record, "foam")
    report = diagnosis_report(result, Path("foam"), Path("out"))
    assert "once density or top_plate_mass[0.001] is measured again" in "\n".join(report.sections[-1].remarks)


def test_a_density_that_is_as_likely_wrong_as_an_effect_acts_is_told_beside_it():
    """A lighter sample under plates that are alike does what a mass on them does."""
    campaign, recordings = campaign_and_signals({"density": -0.12}, noise=0.005)
    record = diagnose_campaign(campaign, recordings, chosen_effects(["channel_gain", "sensor_mass"])).record
    assert record["group"][0] == ["sensor_mass"]
    assert {record["wrong_statement"]["name"], *record["wrong_statement"]["tied"]} == {
        "density",
        "top_plate_mass[0.001]",
    }
    assert "what is stated would explain it as well by being wrong" in record["sentence"]
    told = record["moduli"]["corrected"]
    true = LAW(np.array(record["moduli"]["frequency_hz"]))
    assert np.mean((told["E1_low"] < true.real) & (true.real < told["E1_high"])) > 0.9


def test_a_sample_that_is_stiffer_has_no_wrong_height(monkeypatch):
    campaign, recordings = campaign_and_signals(noise=0.005)
    stiffer = LAW.model_copy(update={"relaxed_modulus": 1.05 * 1.2e5, "unrelaxed_modulus": 1.05 * 1.5e6})
    monkeypatch.setattr("tests.fits.test_joint.LAW", stiffer)
    others = campaign_and_signals(noise=0.005)[1]
    mixed = {key: (others if key[0] == "low" else recordings)[key] for key in recordings}
    record = diagnose_campaign(campaign, mixed, chosen_effects(["channel_gain", "crosstalk"])).record
    assert record["verdict"] == "unknown"
    assert record["wrong_statement"] is None
    assert record["places"][0]["place"] == "one_configuration"


@pytest.mark.parametrize(
    ("effect", "sizes", "changes"),
    [("dispersion", [0.5, 3e-4], True), ("preload", [5e-4], False), ("channel_gain", [0.05], False),
     ("temperature_drift", [0.1], False)],
)  # fmt: skip
@pytest.mark.parametrize("given", [False, True])
def test_the_modulus_of_the_material_has_what_acts_there(effect, sizes, changes, given):
    """A relaxation that the law lacks is the sample's; its load, its drift and the channels are not."""
    bench, kind, f = joint_bench(), EFFECTS[effect](), np.array([200.0, 1000.0])
    acting = replace(bench, given=(kind,)) if given else bench.with_effects(kind)
    z = soft_sample(bench)
    sizes = [p.prior.coordinate(value) for p, value in zip(kind.parameters, sizes, strict=True)]
    count = len(bench.modulus_parameters)
    z = np.concatenate([z, sizes])
    law, found = bench.modulus(z[:count], f), acting.own_modulus(z, f)
    s = 2j * np.pi * f * 3e-4
    assert found == pytest.approx(law * (1 + 0.5 * s / (1 + s)) if changes else law)
    assert acting.own_modulus(np.stack([z, z]), f) == pytest.approx(np.stack([found, found]))


def test_the_modulus_of_the_material_has_the_law_that_is_drawn_there():
    bench, f = joint_bench(), np.array([200.0, 1000.0])
    law = SimpleLaw.at(PLACES["sample"](), (Term("power", 0),), f, 1.0)
    z = np.append(soft_sample(bench), law.parameters[0].prior.coordinate(0.2))
    own = bench.with_effects(law).own_modulus(z, f)
    assert own == pytest.approx(np.exp(0.2) * bench.modulus(z[:-1], f))


def test_the_interval_of_an_effect_is_the_same_where_it_is_part_of_the_nominal_model():
    bench, preload = joint_bench(), EFFECTS["preload"]()
    z = np.append(soft_sample(bench), preload.parameters[0].prior.coordinate(5e-4))
    fits = (Fitted(p, p.as_minimum(z)) for p in (bench.with_effects(preload), replace(bench, given=(preload,))))
    as_cause, given = (fit.interval("preload.stiffening") for fit in fits)
    assert given == pytest.approx(as_cause)
    assert given[2] / given[1] > 1.5  # the error of sizes is in it


def test_the_record_is_that_of_the_specification(gain):
    record = json.loads(gain.to_json())
    assert set(record) >= KEYS
    known = [c["probability"] for c in record["causes"] if c["effects"] not in ([], ["unknown"])]
    assert known == sorted(known, reverse=True)
    assert {"quantity", "configuration", "band_hz", "significance", "note"} <= set(record["where"][0])
    assert record["detectable"]["channel_gain"]["smallest"] < 0.05
    assert record["sentence"].startswith("The gap is caused by channel gain")


def test_what_is_deleted_from_the_library_is_not_blamed():
    campaign, recordings = campaign_and_signals(gain=1.05)
    record = diagnose_campaign(campaign, recordings, chosen_effects(FEW, without=["channel_gain"])).record
    assert record["verdict"] == "unknown"
    assert record["group"] == []
    assert all("channel_gain" not in cause["effects"] for cause in record["causes"])


def test_errors_that_nobody_states_are_no_gap():
    campaign, recordings = campaign_and_signals({"density": 0.008, "thickness": 3e-5}, gain=1.002)
    silent = campaign.model_copy(update={"uncertainty": Uncertainty()})
    record = diagnose_campaign(silent, recordings, chosen_effects(FEW)).record
    assert record["verdict"] == "no_gap"
    (text,) = record["warnings"]
    assert all(f"{name} {value:g}" in text for name, value in USUAL_UNCERTAINTY.model_dump().items())


def test_what_is_stated_as_exact_stays_so():
    campaign, _ = campaign_and_signals()
    known = Uncertainty(thickness=0.0, density=0.02)
    found, (text,) = with_usual_uncertainty(campaign.model_copy(update={"uncertainty": known}))
    assert found.uncertainty == USUAL_UNCERTAINTY.model_copy(update={"thickness": 0.0, "density": 0.02})
    assert ("thickness" in text, "density" in text, "remount_gain" in text) == (False, False, True)
    assert with_usual_uncertainty(found) == (found, [])


def test_without_an_effect_there_is_no_gap():
    campaign, recordings = campaign_and_signals({"density": 0.008, "thickness": 3e-5}, gain=1.002)
    record = diagnose_campaign(campaign, recordings, chosen_effects(FEW)).record
    assert record["verdict"] == "no_gap"
    assert record["causes"] == record["where"] == record["group"] == []


class Silent(ChannelGain):
    """An effect of a plugin that never gives a number."""

    name = "silent"

    def motion(self, setting: Setting, motion: ComplexArray, values: Values) -> ComplexArray:
        return np.nan * super().motion(setting, motion, values)


def test_an_effect_that_never_responds_is_left_out_and_told():
    campaign, recordings = campaign_and_signals(gain=1.05)
    effects = {effect.name: effect for effect in (Silent(), ChannelGain())}
    with pytest.warns(PluginWarning, match="effect silent: the model has no response"):
        record = diagnose_campaign(campaign, recordings, effects).record
    assert record["group"] == [["channel_gain"]]
    assert all("silent" not in cause["effects"] for cause in record["causes"])
    with pytest.raises(InputError, match=r"leave out what is given \(silent\)"):
        fit_nominal(campaign, recordings, given=[Silent()])


def test_an_unknown_effect_is_refused():
    with pytest.raises(InputError, match="did you mean 'sensor_mass'"):
        chosen_effects(["sensor_mas"])


SAYS = {
    "sensor_mass": {"sensor_mass": 1e-3},
    "saturating_air": {"pores": {"porosity": 0.95, "flow_resistivity": 2e4}},
    "finite_size": {"model": "finite"},
}


@pytest.mark.parametrize("effect", SAYS)
def test_what_a_fit_file_says_and_a_diagnosis_does_not_take_is_told(effect):
    settings = FitSettings.model_validate(SAYS[effect])
    with pytest.warns(PlausibilityWarning, match=f"may name {effect} as the cause; --with {effect} makes"):
        warn_of_settings(settings)
    warn_of_settings(settings, [EFFECTS[effect]()])
    warn_of_settings(FitSettings())


def test_the_nominal_hypothesis_is_the_plane_wave_rig():
    joint = joint_bench()
    campaign = joint.campaign
    hypothesis = joint
    z = np.zeros(len(joint.parameters))
    for setting in hypothesis.settings:
        modulus = joint.space.modulus(joint.law_coordinates(z), setting.frequency)
        expected = PlaneWaveRig.of(campaign, setting.configuration).transmissibility(setting.frequency, modulus)
        np.testing.assert_allclose(hypothesis.predict(setting, z)[0], expected, rtol=1e-10)


# the effects' rods against finite elements without lateral contraction
CHAINS = {
    "flanking": ({"stiffness": 3e5, "loss_factor": 0.1}, {"flanking_stiffness": 3e5 * (1 + 0.1j)}),
    "sensor_mass": ({"mass": 1e-3, "bending": 0.0}, {"sensor_mass": 1e-3, "sensor_footprint": 0.0225}),
    "skin": ({"thickness": 1e-3, "ratio": 3.0}, {"skin_thickness": 1e-3, "skin_ratio": 3.0}),
    # a plate that bends
    "delamination": (
        {"open_rim": 0.1, "trend": 0.0, "at_base": 1e-9},
        {"bonded_fraction": 0.81, "open_faces": "top", "plate_modulus": 2.1e11, "plate_poisson_ratio": 0.3},
    ),
    "delamination of the lower face": (
        {"open_rim": 0.1, "trend": 0.0, "at_base": 2 - 1e-9},
        {"bonded_fraction": 0.81, "open_faces": "base", "plate_modulus": 2.1e11, "plate_poisson_ratio": 0.3},
    ),
    "adhesive": (
        {"compliance": 2e-9, "loss_factor": 0.3, "surface_density": 0.3},
        # stiffness (1 + i eta)/c and mass of a layer of 0.1 mm
        {
            "adhesive_thickness": 1e-4,
            "adhesive_modulus": 1e-4 * (1 + 0.3j) / 2e-9,
            "adhesive_density": 3e3,
            "adhesive_poisson_ratio": 0.0,
        },
    ),
}


@pytest.mark.parametrize("mass", [1e-3, 5e-3])
def test_a_plate_bends_under_what_stands_in_its_centre_as_finite_elements_do(mass):
    joint = joint_bench()
    law = SimpleLaw.at(InCentre(), (Term("power", 0),), np.array([100.0, 1600.0]), 1e-2)
    hypothesis = joint.with_effects(law)
    z = np.concatenate([soft_sample(joint), [law.parameters[0].prior.coordinate(mass)]])
    for setting in hypothesis.settings:
        size = setting.configuration
        modulus = joint.space.modulus(joint.law_coordinates(z), setting.frequency)
        plain, loaded = (
            TwoPlateRig(
                size.specimen_radius, size.specimen_thickness, 80.0, 0.0, size.top_plate_thickness, attached_mass=m
            ).transmissibility(setting.frequency, modulus)
            for m in (0.0, mass)
        )
        rigid = hypothesis.with_effects(replace(law, at_place=TopPlate())).predict(setting, z)[1]
        found, nominal = hypothesis.predict(setting, z)[1], joint.predict(setting, z[:-1])[1]
        errors = [np.max(np.abs(of / nominal / (loaded / plain) - 1)) for of in (found, rigid)]
        assert errors[0] < 0.1 * errors[1]


@pytest.mark.parametrize("name", CHAINS)
def test_rods_with_effects_are_finite_elements(name):
    sizes, fields = CHAINS[name]
    joint = joint_bench()
    effect = EFFECTS[name.partition(" ")[0]]()
    hypothesis = joint.with_effects(effect)
    own = [float(p.prior.coordinate(sizes[p.name])) for p in effect.parameters]
    z = np.concatenate([np.zeros(len(joint.parameters)), own])
    setting = hypothesis.settings[1]
    configuration = setting.configuration
    rig = TwoPlateRig(
        configuration.specimen_radius,
        configuration.specimen_thickness,
        80.0,
        0.0,
        configuration.top_plate_thickness,
        **{"plate_poisson_ratio": 0.0, "plate_modulus": 2.1e13, **fields},
    )
    modulus = joint.space.modulus(joint.law_coordinates(z), setting.frequency)
    found, expected = hypothesis.predict(setting, z)[0], rig.transmissibility(setting.frequency, modulus)
    nominal = joint.predict(setting, z[: len(joint.parameters)])[0]
    assert np.max(np.abs(nominal / expected - 1)) > 0.01
    np.testing.assert_allclose(found, expected, rtol=3e-3)


def test_names_and_order_are_no_hint(gain):
    """Everything that could carry a label is renamed, and the configurations are shuffled: the verdict stays."""
    campaign, recordings = campaign_and_signals(gain=1.05)
    names = {c.name: f"x{i}" for i, c in enumerate(reversed(campaign.configurations))}
    bursts = {
        c.name: [b.model_copy(update={"file": Path(f"{i}.bin")}) for i, b in enumerate(c.bursts)]
        for c in campaign.configurations
    }
    renamed = [
        c.model_copy(update={"name": names[c.name], "bursts": bursts[c.name]}) for c in campaign.configurations[::-1]
    ]
    other = campaign.model_copy(update={"configurations": renamed})
    signals = {(names[name], f): recording for (name, f), recording in recordings.items()}
    record = diagnose_campaign(other, signals, chosen_effects(FEW)).record
    assert record["group"] == gain.record["group"]
    before, after = (
        {tuple(cause["effects"]): cause["log_evidence"] for cause in one["causes"]} for one in (gain.record, record)
    )
    assert after[("channel_gain",)] == pytest.approx(before[("channel_gain",)], abs=0.1)
    assert after[()] == pytest.approx(before[()], abs=0.1)


def test_nothing_of_the_diagnosis_knows_of_truth_files():
    for path in Path(diagnosis.__file__).parent.rglob("*.py"):
        assert "truth.json" not in path.read_text()


def of_configurations(job, names):
    """Return the campaign and recordings of some configurations of a fit file, of all if there are no names."""
    names = names or {c.name for c in job.campaign.configurations}
    chosen = tuple(c for c in job.campaign.configurations if c.name in names)
    recordings = {key: value for key, value in job.recordings.items() if key[0] in names}
    return job.campaign.model_copy(update={"configurations": chosen}), recordings


@pytest.mark.reference
@pytest.mark.parametrize(
    ("name", "configurations", "without", "verdict", "cause"),
    [
        ("effect-none", ["h12.5mm-t1mm", "h12.5mm-t3mm", "h25mm-t1mm"], [], "no_gap", None),
        ("effect-sensor-mass", ["h12.5mm-t3mm", "h25mm-t1mm", "h40mm-t1mm"], [], "effect", "sensor_mass"),
        pytest.param(
            "effect-sensor-mass",
            ["h12.5mm-t3mm", "h25mm-t1mm", "h40mm-t1mm"],
            ["sensor_mass"],
            "unknown",
            None,
            marks=pytest.mark.slow,
        ),
        pytest.param("paper-b", [], [], "effect", "finite_size", marks=pytest.mark.slow),
    ],
)
def test_campaigns_of_an_independent_solver(shared: Path, name, configurations, without, verdict, cause):
    """Three of seven configurations where there are so many; ``validation.diagnoses`` takes all."""
    job = read_fit(shared / "campaigns" / name)
    campaign, recordings = of_configurations(job, configurations)
    record = diagnose_campaign(campaign, recordings, chosen_effects(without=without)).record
    assert record["verdict"] == verdict
    if cause is not None:
        assert record["group"][0] == [cause]
        assert record["gap"]["shrinkage"] > 0.9


@pytest.mark.reference
@pytest.mark.slow
def test_a_rim_that_is_worn_needs_the_finer_law(shared: Path):
    """Two of the seven configurations, of one shape; the independent solver's rim is 0.1565 radii wide."""
    job = read_fit(shared / "campaigns" / "round-1" / "effect-delamination")
    nominal, minima = fit_nominal(*of_configurations(job, ["h25mm-t1mm", "h25mm-t3mm"]), calibration=job.calibration)
    effects = chosen_effects(["delamination"])
    _, fits = fits_one_by_one(nominal, minima, effects, None)
    found = fits["delamination",]
    assert lack_of_fit(found) == ""
    assert found.interval("delamination.open_rim")[0] == pytest.approx(0.1565, rel=0.03)
    assert found.interval("delamination.depth")[0] == pytest.approx(1 / 16, rel=0.2)
    (coarse,) = fit_effects(nominal, effects).values()
    assert lack_of_fit(coarse)


@pytest.mark.slow
def test_laws_all_over_the_prior_lead_to_a_buried_reading():
    """Valleys sought from laws all over the prior, against those that lie below the nominal model."""
    sealed = draw(149, 7)
    made = make_campaign(sealed.settings, sealed.seed)
    nominal, _ = fit_nominal(made.campaign, made.recordings)
    hypothesis = nominal.hypothesis.with_effects(*chosen_effects(["rocking"]).values())
    near = begin(hypothesis, nominal.minimum.z)
    everywhere = begin(hypothesis, nominal.minimum.z, others=starting_laws(nominal.hypothesis))
    ends = {name: best_of([end() for end in s.ends]) for name, s in (("everywhere", everywhere), ("near", near))}
    polished = polish_fits(ends)
    best = polished["everywhere"]
    assert best.log_evidence > polished["near"].log_evidence - 0.5
    assert best.minimum.cost < 2 * len(best.minimum.residual)


@pytest.mark.slow
def test_a_reading_that_is_buried_is_dug_out():
    """A rocking plate's resonance as high as the sample's own: the nominal model fits it, and no descent leads back."""
    sealed = draw(149, 7)
    assert sealed.effects == ("rocking",)
    made = make_campaign(sealed.settings, sealed.seed)
    effects = chosen_effects(["rocking", "channel_gain", "sensor_mass"])
    record = diagnose_campaign(made.campaign, made.recordings, effects).record
    assert record["group"] == [["rocking"]]
    size = next(c for c in record["causes"] if c["effects"] == ["rocking"])["parameters"]["rocking.share"]
    assert size["low"] < sealed.truth["rocking.share"] < size["high"]
