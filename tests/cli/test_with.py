"""``--save-law`` and ``--with``: what was found of a rig, applied to its campaigns."""

import json

import numpy as np
import pytest

from multilayer.config.yaml12 import dump_yaml
from multilayer.diagnosis.effects.delamination import Delamination, WornRim
from multilayer.diagnosis.places.beside import Friction, OpenFaces
from multilayer.diagnosis.places.one_configuration import HeightOfOne, PlateOfOne
from multilayer.diagnosis.places.plate import InCentre, TopPlate
from multilayer.diagnosis.places.reading import ReadingOverTime
from multilayer.diagnosis.places.sample import SampleOrder, SampleOrderInMounting, SampleStrain, SampleStrainAtOnce
from multilayer.diagnosis.saved_law import RigLaw, known_effects, saved_law
from multilayer.errors import InputError
from multilayer.experiments.places import TabulatedLaw
from multilayer.media.laws import LAWS
from multilayer.rig.file import RigFile
from multilayer.rig.synthesis import make_campaign
from multilayer.rig.writer import write_campaign as write_rig
from tests.cli.campaigns import write_campaign
from tests.cli.command import run

MASS = 2e-3  # kg
LAW = {
    "law": "fractional_zener", "relaxed_modulus": 2e5, "unrelaxed_modulus": 1.2e6, "relaxation_time": 1e-4,
    "order": 0.5,
}  # fmt: skip
SAVED = {
    "kind": "rig-law",
    "version": 1,
    "laws": [
        {
            "place": "top_plate",
            "centre": 300.0,
            "terms": [
                {"kind": "power", "parameters": {"amplitude": {"value": MASS, "low": 0.9 * MASS, "high": 1.1 * MASS}}}
            ],
        }
    ],
}


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    """Return the folder of a campaign whose top plates carry an accelerometer that nobody mentions."""
    settings = RigFile.model_validate(
        {
            "version": 1, "rig": "two-plate", "specimen": {"density": 90.0, "young_modulus": LAW},
            "frequencies": [120, 250, 400, 650, 900],
            "configurations": {"thicknesses": [0.0125, 0.025], "top_plates": [0.001, 0.003]},
            "repeats": 2, "noise": {"white": 0.004}, "uncertainty": {"top_plate_mass": 0.002, "thickness": 5e-5},
            "effects": [{"effect": "sensor_mass", "mass": MASS}],
        }
    )  # fmt: skip
    folder = tmp_path_factory.mktemp("rig") / "loaded"
    write_rig(make_campaign(settings), folder)
    return folder


def moduli(out):
    record = json.loads((out / "joint.json").read_text())
    f = np.array([row["frequency_hz"] for row in record["moduli"]])
    found = np.array([row["E1_pa"] + 1j * row["E2_pa"] for row in record["moduli"]])
    true = LAWS["fractional_zener"](**{k: v for k, v in LAW.items() if k != "law"})(f)
    return record, np.abs(found / true - 1).max()


@pytest.mark.parametrize("known", ["sensor_mass", "rig.yaml"])
def test_a_fit_with_what_is_known_finds_the_modulus(loaded, tmp_path, known):
    (tmp_path / "rig.yaml").write_text(dump_yaml(SAVED))
    source = str(tmp_path / known) if known.endswith("yaml") else known
    done = run("fit", loaded, "--with", source, "--no-figures", "--out", tmp_path / "with")
    record, error = moduli(tmp_path / "with")
    plain = run("fit", loaded, "--joint", "--no-figures", "--out", tmp_path / "plain")
    _, before = moduli(tmp_path / "plain")
    assert done.status == 0, done.err
    assert (error < 0.02, before > 0.03) == (True, True), (error, before)
    name = "known_top_plate.0.amplitude" if known.endswith("yaml") else "sensor_mass.mass"
    found = record["parameters"][name]
    assert abs(found["value"] - MASS) < 0.03 * MASS
    assert 0 < found["std"] < 0.1 * MASS
    assert record["with"] == [name.partition(".")[0]]
    assert plain.status in (0, 1)


@pytest.mark.slow
def test_a_diagnosis_with_what_is_known_finds_nothing_beyond_it(loaded, tmp_path):
    (tmp_path / "rig.yaml").write_text(dump_yaml(SAVED))
    done = run(
        "diagnose", loaded, "--with", tmp_path / "rig.yaml", "--no-figures", "--jobs", "1", "--out", tmp_path / "out"
    )
    record = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert (done.status, record["verdict"]) == (0, "no_gap"), record["sentence"]
    assert record["with"] == ["known_top_plate"]


def test_a_diagnosis_saves_what_it_found(loaded, tmp_path):
    file = tmp_path / "rig.yaml"
    done = run("diagnose", loaded, "--save-law", file, "--no-figures", "--jobs", "1", "--out", tmp_path / "out")
    assert done.status == 0, done.err
    assert run("check", file).status == 0
    record = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert sum(cause["probability"] for cause in record["causes"]) > 0.98
    proposed = next(line for line in done.out.splitlines() if "multilayer fit" in line)
    assert proposed.startswith(f"- multilayer fit {loaded} --with {tmp_path / 'out' / 'diagnosis.json'}   #")
    table = np.genfromtxt(tmp_path / "out" / "moduli.csv", delimiter=",", names=True)
    true = LAWS["fractional_zener"](**{k: v for k, v in LAW.items() if k != "law"})(table["frequency_hz"])
    for part, values in (("E1", true.real), ("E2", true.imag)):
        low, high = (table[f"corrected_{part}_{end}_pa"] for end in ("low", "high"))
        assert np.mean((low < values) & (values < high)) > 0.5
    effect, *others = known_effects(str(file))
    found = next(p.prior for p in effect.parameters if p.name == "mass")
    assert (effect.name, others) == ("sensor_mass", [])
    assert abs(found.lognormal[0] / MASS - 1) < 0.1
    wide, *_ = known_effects(str(tmp_path / "out" / "diagnosis.json"))
    assert next(p.prior for p in wide.parameters if p.name == "mass").lognormal[1] > 5 * found.lognormal[1]


def test_where_no_law_can_be_written_nothing_is_computed(tmp_path):
    folder = write_campaign(tmp_path / "foam")
    (tmp_path / "rigs").mkdir()
    done = run("diagnose", folder, "--save-law", tmp_path / "rigs", "--out", tmp_path / "out")
    assert (done.status, done.out) == (2, "")
    assert "--save-law" in done.err
    assert "is a folder; name a file" in done.err
    assert not (tmp_path / "out").exists()


def test_without_a_gap_nothing_is_saved(tmp_path):
    folder = write_campaign(tmp_path / "foam")
    done = run("diagnose", folder, "--save-law", tmp_path / "rig.yaml", "--no-figures", "--out", tmp_path / "out")
    assert done.status == 0
    assert "no law to save" in done.err
    assert not (tmp_path / "rig.yaml").exists()


def test_a_table_is_a_law_with_its_band():
    f = [100.0, 200.0, 400.0]
    table = {"frequency_hz": f, "real": [1.0, 2.0, 3.0], "real_low": [0.5, 1.5, 2.5], "real_high": [1.5, 2.5, 3.5]}
    table |= {"imag": [0.0] * 3, "imag_low": [-0.1] * 3, "imag_high": [0.1] * 3}
    law = RigLaw.model_validate({"laws": [{"place": "beside", "table": table}]})
    (effect,) = law.applied(None)
    assert isinstance(effect, TabulatedLaw)
    first = effect.parameters[0].prior.normal
    assert first == pytest.approx((1.0, 0.5 / 1.645), rel=1e-3)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"laws": [{**SAVED["laws"][0], "place": "top_plat"}]}, "did you mean 'top_plate'"),
        ({"laws": [{**SAVED["laws"][0], "terms": []}]}, "terms"),
        ({"laws": [{**SAVED["laws"][0], "free_rim": True}]}, "free_rim is of the place sample_shape"),
        ({"laws": [{**SAVED["laws"][0], "open_rim": {"width": 0.1}}]}, "open_rim is of the place faces"),
        ({"laws": [{**SAVED["laws"][0], "place": "faces", "open_rim": {"width": 1.1}}]}, "open_rim.width"),
        ({"laws": [{**SAVED["laws"][0], "moved": {"c1": 0}}]}, "moved.c1"),
        (
            {"laws": [{**SAVED["laws"][0], "place": "one_configuration", "configuration": "c1", "moved": {"c1": 1.1}}]},
            "moved is of a law in all configurations",
        ),
        ({"laws": [{**SAVED["laws"][0], "variant": "at_once"}]}, "top_plate has no variant 'at_once'"),
        ({"laws": [{**SAVED["laws"][0], "configuration": "c1"}]}, "the place top_plate has no configuration"),
        ({"laws": [{**SAVED["laws"][0], "place": "one_configuration"}]}, "one_configuration needs a configuration"),
        ({"laws": [{**SAVED["laws"][0], "place": "sample_strain", "variant": "atonce"}]}, "did you mean 'at_once'"),
        ({"laws": [], "effects": [{"effect": "sensor_mas"}]}, "did you mean 'sensor_mass'"),
        (
            {
                "laws": [],
                "effects": [{"effect": "sensor_mass", "parameters": {"mas": {"value": 1, "low": 1, "high": 1}}}],
            },
            "mass",
        ),
        ({"laws": []}, "nothing to apply"),
    ],
)
def test_mistakes_in_a_file_are_told(tmp_path, change, told):
    file = tmp_path / "rig.yaml"
    file.write_text(dump_yaml({**SAVED, **change}))
    done = run("fit", write_campaign(tmp_path / "foam"), "--with", file, "--out", tmp_path / "out")
    assert done.status == 2
    assert told in done.err
    assert "rig.yaml" in done.err
    assert "Traceback" not in done.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("name", "kind"), [("trend", Delamination), ("depth", WornRim)])
def test_an_effect_has_the_law_whose_parameters_were_saved(tmp_path, name, kind):
    sizes = {"open_rim": {"value": 0.16, "low": 0.15, "high": 0.17}, name: {"value": 0.06, "low": 0.05, "high": 0.07}}
    effects = [{"effect": "delamination", "parameters": sizes}]
    file = tmp_path / "rig.yaml"
    file.write_text(dump_yaml({"kind": "rig-law", "version": 1, "effects": effects}))
    (effect,) = known_effects(str(file))
    assert type(effect) is kind
    assert effect.parameters[0].prior.lognormal[0] == 0.16


def saved_and_read(tmp_path, **law):
    """Return the effect of a law of a diagnosis, by a file."""
    curves = {f"{part}{end}": [0.1, 0.1] for part in ("real", "imag") for end in ("", "_low", "_high")}
    drawn = {"frequency_hz": [100.0, 900.0], "form_is_enough": False, "form": None, **curves, **law}
    file = tmp_path / "rig.yaml"
    saved = saved_law({"verdict": "unknown", "law": drawn}, "foam")
    file.write_text(dump_yaml({"kind": "rig-law", **saved.model_dump(mode="json")}))
    (effect,) = known_effects(str(file))
    return effect


@pytest.mark.parametrize("rim", [False, True])
def test_a_law_beyond_a_free_rim_is_saved_with_it(tmp_path, rim):
    effect = saved_and_read(tmp_path, place="sample_shape", free_rim=rim)
    assert effect.needs_finite_elements is rim


def test_a_law_beyond_open_rims_is_saved_with_them(tmp_path):
    rim = {"width": 0.16, "trend": 0.02, "at_base": 0.0, "depth": 0.06}
    assert saved_and_read(tmp_path, place="faces", open_rim=rim).at_place == OpenFaces(**rim)


def test_a_law_that_moves_is_saved_with_how_far(tmp_path):
    effect = saved_and_read(tmp_path, place="reading", moved={"h25mm": 1.25, "h40mm": 0.8})
    assert effect.at_place.moved == pytest.approx({"h25mm": np.log(1.25), "h40mm": np.log(0.8)})
    assert effect.at_place.entry == {"moved": pytest.approx({"h25mm": 1.25, "h40mm": 0.8})}


def test_a_law_that_differs_from_plate_to_plate_is_saved_with_its_factors(tmp_path):
    told = {"factors": {"h25mm": 0.2, "h40mm": 1.1}, "differs_by": "top plate"}
    effect = saved_and_read(tmp_path, place="plate", **told)
    assert effect.at_place.entry == told


@pytest.mark.parametrize(("length", "nodes"), [(0.55, 9), (0.14, 29)])
def test_a_table_has_as_many_nodes_as_its_law(tmp_path, length, nodes):
    f = np.geomspace(100, 1000, 61).tolist()
    curves = {f"{part}{end}": [0.1] * 61 for part in ("real", "imag") for end in ("", "_low", "_high")}
    effect = saved_and_read(tmp_path, place="reading", correlation_length=length, frequency_hz=f, **curves)
    assert len(effect.nodes) == nodes


@pytest.mark.parametrize(
    ("place", "variant", "kind"),
    [
        ("sample_strain", "", SampleStrain),
        ("sample_strain", "at_once", SampleStrainAtOnce),
        ("sample_order", "", SampleOrder),
        ("sample_order", "since_mounting", SampleOrderInMounting),
        ("reading", "over_time", ReadingOverTime),
        ("beside", "friction", Friction),
        ("one_configuration", "plate", PlateOfOne),
        ("one_configuration", "height", HeightOfOne),
        ("top_plate", "", TopPlate),
        ("top_plate", "in_centre", InCentre),
    ],
)
def test_a_law_is_saved_with_the_way_in_which_it_acts(tmp_path, place, variant, kind):
    of_one = {"configuration": "h25mm-t1mm"} if place == "one_configuration" else {}
    effect = saved_and_read(tmp_path, place=place, variant=variant, **of_one)
    assert type(effect.at_place) is kind


def test_what_is_no_effect_and_no_file_is_told(tmp_path):
    done = run("fit", write_campaign(tmp_path / "foam"), "--with", "sensor_mas")
    assert (done.status, "did you mean 'sensor_mass'" in done.err) == (2, True)
    done = run("fit", write_campaign(tmp_path / "foam2"), "--with", "sensor_mass", "--method", "nelder-mead")
    assert (done.status, "--with is of joint" in done.err) == (2, True)
    done = run("fit", write_campaign(tmp_path / "foam3"), "--with", "finite_size", "--model", "plane_wave")
    assert (done.status, "'finite_size' needs finite elements" in done.err) == (2, True)


def test_a_diagnosis_without_a_law_cannot_be_saved():
    with pytest.raises(InputError, match="no law to save"):
        saved_law({"verdict": "unknown", "law": None}, "c")


def test_a_law_that_explains_nothing_cannot_be_saved():
    law = {"place": "faces", "objection": "shrinks the gap on held-out data by 28 % only"}
    with pytest.raises(InputError, match="no law of this diagnosis is worth saving: the best shrinks the gap"):
        saved_law({"verdict": "unknown", "law": law}, "c")


@pytest.mark.slow
def test_a_free_rim_is_the_finite_model(tmp_path):
    folder = write_campaign(tmp_path / "foam")
    done = run("fit", folder, "--with", "finite_size", "--no-figures", "--out", tmp_path / "out")
    assert done.status in (0, 1), done.err
    record = json.loads((tmp_path / "out" / "joint.json").read_text())
    assert (record["settings"]["model"], record["settings"]["joint"], record["with"]) == (
        "finite",
        True,
        ["finite_size"],
    )
    assert {"finite_size.poisson_error", "finite_size.radial_stiffness"} <= record["parameters"].keys()
    done = run("diagnose", folder, "--with", "finite_size", "--no-figures", "--jobs", "1", "--out", tmp_path / "why")
    assert done.status == 0, done.err
    assert json.loads((tmp_path / "why" / "diagnosis.json").read_text())["with"] == ["finite_size"]
