"""Answers to the page, without a browser and without a server."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from multilayer import load_stack, simulate
from multilayer.errors import InputError
from multilayer.explore.curves import MOST_POINTS, computed
from multilayer.explore.explorer import Explorer
from multilayer.explore.file import open_file
from multilayer.explore.starting import completed
from multilayer.layers.base import LAYERS
from multilayer.simulation.file import SimulationFile, load_simulation
from multilayer.simulation.measured import read_measured
from multilayer.simulation.settings import FrequencyRange
from multilayer.units import field_unit, parse_quantity

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture
def file(tmp_path):
    """Give a copy of the foam on a wall."""
    return Path(shutil.copy(EXAMPLES / "foam_absorption.yaml", tmp_path / "foam.yaml"))


@pytest.fixture
def explorer(file):
    """Give what answers about it."""
    return Explorer(file)


def start(explorer):
    return explorer.answer("start", {})


def fields(answer, layer=0):
    return {field["name"]: field for field in answer["layers"][layer]["fields"]}


def with_thickness(data, text):
    return {**data, "layers": [{**data["layers"][0], "thickness": text}]}


class TestCurves:
    def test_are_those_of_simulate(self, explorer, file):
        data = with_thickness(start(explorer)["data"], "50 mm")
        answer = explorer.answer("evaluate", {"data": data})
        case = simulate(load_simulation(file)).cases[1]  # of its sweep, 50 mm
        shown = answer["curves"]["absorption"]["parts"][0]["values"]
        assert np.allclose(shown, case.quantities["absorption"], rtol=1e-5)
        assert answer["ratings"] == case.ratings
        impedance = [part["values"] for part in answer["curves"]["normalised_impedance"]["parts"]]
        assert np.allclose(impedance[1], case.quantities["normalised_impedance"].imag, rtol=1e-5)

    @pytest.mark.parametrize("incidence", ["normal", 45, {"diffuse": {"max_angle": 70}}])
    def test_of_every_incidence(self, explorer, incidence):
        data = {**start(explorer)["data"], "incidence": incidence, "termination": "ambient"}
        answer = explorer.answer("evaluate", {"data": data})
        assert answer["problems"] == []
        assert "transmission_loss" in answer["curves"]
        assert ("normalised_impedance" in answer["curves"]) == (not isinstance(incidence, dict))
        assert "Rw (C; Ctr)" in answer["ratings"]

    def test_fewer_frequencies_lie_on_the_same_curve(self, explorer):
        data = start(explorer)["data"]
        whole, few = (explorer.answer("evaluate", {"data": data, "points": points}) for points in (None, 50))
        assert len(few["frequency"]) == 50
        whole, few = (one["curves"]["absorption"]["parts"][0]["values"] for one in (whole, few))
        assert few[0] == whole[0]
        assert few[-1] == whole[-1]

    def test_no_more_frequencies_than_a_screen_shows(self, explorer):
        data = start(explorer)["data"]
        answer = explorer.answer("evaluate", {"data": {**data, "frequency": {"points": 3000}}})
        assert (len(answer["frequency"]), answer["left_out"]) == (MOST_POINTS, 3000 - MOST_POINTS)
        listed = np.linspace(100, 1000, 1001).tolist()
        answer = explorer.answer("evaluate", {"data": {**data, "frequency": listed}})
        assert (answer["frequency"][0], answer["frequency"][-1]) == (100, 1000)
        assert len(answer["frequency"]) + answer["left_out"] == 1001

    @pytest.mark.filterwarnings("ignore:diffuse field", "ignore:.*bending wavelength")
    @pytest.mark.parametrize(("kind", "allowed"), [("elastic_plate", 0.2), ("orthotropic_plate", 1.0)])
    def test_of_a_diffuse_field_are_rough_while_a_slider_moves(self, kind, allowed, tmp_path):
        plates = [{**completed({"type": name}), "loss_factor": 0.05} for name in (kind, "elastic_plate")]
        layers = [plates[0], {"type": "fluid", "thickness": "50 mm"}, plates[1]]
        data = {"layers": layers, "termination": "ambient", "incidence": "diffuse", "frequency": [200, 500, 1500, 4000]}
        rest, moving = (computed(data, tmp_path / "x.yaml", moving=moving) for moving in (False, True))
        rest, moving = (np.array(one["curves"]["transmission_loss"]["parts"][0]["values"]) for one in (rest, moving))
        assert np.max(np.abs(rest - moving)) < allowed

    @pytest.mark.parametrize(("name", "quantity", "allowed"), [
        ("duct_silencer", "duct_attenuation", 0.1), ("steel_stud_wall", "transmission_loss", 0.6),
    ])  # fmt: skip
    def test_bands_are_rough_while_a_slider_moves(self, name, quantity, allowed):
        example = EXAMPLES / f"{name}.yaml"
        data = {key: value for key, value in open_file(example).data.items() if key != "sweep"}
        answers = [computed(data, example, points, moving=True) for points in (None, 40)]
        whole, rough = (np.array(one["curves"][quantity]["parts"][0]["values"]) for one in answers)
        assert answers[1]["frequency"] == answers[0]["frequency"]
        assert 0 < np.max(np.abs(rough - whole)) < allowed
        assert computed(data, example, 40)["curves"] == answers[0]["curves"]

    def test_an_infinite_impedance_is_no_number_in_json(self, tmp_path):
        data = {"layers": [{"type": "fluid", "thickness": "1 m"}], "termination": "rigid", "frequency": [85.75, 171.5]}
        json.dumps(computed(data, tmp_path / "x.yaml"), allow_nan=False)


class TestDescription:
    @pytest.mark.parametrize("kind", [name for name, _ in LAYERS.working()])
    def test_what_a_slider_writes_is_read_as_what_it_stands_for(self, kind, explorer):
        data = {**start(explorer)["data"], "layers": [completed({"type": kind})]}
        for field in fields(explorer.answer("evaluate", {"data": data, "describe": True})).values():
            if field["kind"] == "quantity":
                assert field["low"] < field["high"]
                assert field["value"] is None or field["low"] <= field["value"] <= field["high"]
                for end in (field["low"], field["high"]):
                    text = f"{end / field['factor'] - field['offset']:.12g} {field['symbol']}".strip()
                    unit = field_unit(LAYERS[kind].model_fields[field["name"]])
                    assert parse_quantity(text, unit) == pytest.approx(end)

    @pytest.mark.parametrize("written", ["-1 mm", 0, -3, "1e5 m", 1e-9])
    def test_a_slider_has_a_range_whatever_is_written(self, written, explorer):
        data = with_thickness(start(explorer)["data"], written)
        thickness = fields(explorer.answer("evaluate", {"data": data, "describe": True}))["thickness"]
        assert 0 < thickness["low"] < thickness["high"]

    @pytest.mark.parametrize("text", ["nan", "5 kg", "1,5", "<b>", "1e400", "", [1], True])
    def test_a_thickness_that_is_none_is_not_drawn(self, text, explorer):
        answer = explorer.answer("evaluate", {"data": with_thickness(start(explorer)["data"], text), "describe": True})
        assert answer["problems"]
        assert answer["layers"][0]["thickness"] is None

    def test_a_temperature_is_shown_in_degrees(self, explorer):
        answer = explorer.answer("evaluate", {"data": start(explorer)["data"], "describe": True})
        temperature = next(field for field in answer["ambient"] if field["name"] == "temperature")
        assert (temperature["unit"], temperature["value"] - temperature["offset"]) == ("°C", pytest.approx(20))

    def test_thickness_comes_first(self, explorer):
        answer = explorer.answer("evaluate", {"data": start(explorer)["data"], "describe": True})
        assert answer["layers"][0]["fields"][0]["name"] == "thickness"
        assert answer["layers"][0]["thickness"] == pytest.approx(0.05)
        assert answer["layers"][0]["look"] == "porous"

    def test_limits_of_fields_are_those_of_the_models(self, explorer):
        shown = fields(explorer.answer("evaluate", {"data": start(explorer)["data"], "describe": True}))
        assert shown["porosity"]["allowed"] == "above 0, below 1"
        assert (shown["porosity"]["low"], shown["porosity"]["high"]) == (0.001, 0.999)
        assert shown["tortuosity"]["allowed"] == "at least 1"

    def test_what_comes_from_a_material_is_marked_until_it_is_changed(self, explorer):
        layer = {"material": "AA2009/T11.2/soft_fibrous", "thickness": "50 mm"}
        data = {**start(explorer)["data"], "layers": [layer]}
        shown = fields(explorer.answer("evaluate", {"data": data, "describe": True}))
        assert (shown["porosity"]["borrowed"], shown["porosity"]["value"]) == (True, 0.98)
        assert (shown["thickness"]["borrowed"], shown["thickness"]["offered"]) == (False, False)
        data["layers"] = [{**layer, "porosity": 0.9}]
        shown = fields(explorer.answer("evaluate", {"data": data, "describe": True}))
        assert (shown["porosity"]["borrowed"], shown["porosity"]["offered"]) == (False, True)

    def test_fields_of_a_law_stand_in_the_modulus(self, tmp_path):
        file = Path(shutil.copy(EXAMPLES / "three_layers.yaml", tmp_path))
        explorer = Explorer(file)
        answer = explorer.answer("evaluate", {"data": start(explorer)["data"], "describe": True})
        law = fields(answer, 1)["young_modulus"]
        assert (law["kind"], law["value"]) == ("nested", "fractional_zener")
        assert [field["path"] for field in law["fields"]][-1] == ["layers", 1, "young_modulus", "order"]

    @pytest.mark.parametrize("kind", [name for name, _ in LAYERS.working()])
    def test_of_every_type_even_where_all_is_missing(self, kind, explorer):
        data = {**start(explorer)["data"], "layers": [{"type": kind}]}
        answer = explorer.answer("evaluate", {"data": data, "describe": True})
        assert answer["problems"]
        shown = fields(answer)
        missing = {one["path"].split(".")[2] for one in answer["problems"] if one["path"].count(".") == 2}
        assert missing <= set(shown)
        assert all(shown[name]["required"] for name in missing)


class TestMistakes:
    @pytest.mark.parametrize(
        ("change", "path", "text"),
        [
            ({"porosity": 1.2}, "layers.0.porosity", "1.2 is not allowed: it must be below 1"),
            ({"thickness": "5 kg"}, "layers.0.thickness", "'5 kg' has the wrong unit: this is a quantity in m"),
            ({"tortuosity": "x"}, "layers.0.tortuosity", "'x' is no number"),
            ({"model": "jca2"}, "layers.0.model", "'jca2' is not allowed"),
            ({"material": "foam"}, "layers.0.material", "there is no material 'foam'"),
        ],
    )
    def test_are_told_as_everywhere(self, change, path, text, explorer):
        data = start(explorer)["data"]
        data["layers"] = [{**data["layers"][0], **change}]
        answer = explorer.answer("evaluate", {"data": data, "describe": True})
        assert [one["path"] for one in answer["problems"]] == [path]
        assert text in answer["problems"][0]["text"]
        assert explorer.file.name not in answer["problems"][0]["text"]
        assert "curves" not in answer
        assert answer["layers"]  # the controls stay, to correct it

    def test_what_is_hardly_meant_is_a_warning(self, explorer):
        answer = explorer.answer("evaluate", {"data": with_thickness(start(explorer)["data"], 50)})
        assert answer["problems"] == []
        assert any("is '50 mm' meant?" in text for text in answer["warnings"])
        assert all(str(explorer.file) not in text for text in answer["warnings"])

    @pytest.mark.parametrize("data", [None, 3, {}, {"layers": []}, {"layers": [1]}, {"layers": {"a": 1}}])
    def test_of_what_is_no_stack(self, data, explorer):
        for question in ("evaluate", "edit", "save"):
            answer = explorer.answer(question, {"data": data, "edit": {"do": "copy", "layer": 0}, "describe": True})
            assert answer["problems"]

    def test_stacks_that_cannot_be_computed_are_told(self, explorer):
        plate = {"type": "elastic_plate", "thickness": 1e-3, "density": 1, "young_modulus": 1, "poisson_ratio": 0}
        data = {
            "layers": [plate, {"type": "fluid", "thickness": 0.1}],
            "contacts": [{"between": [0, 1], "kind": "slip"}],
        }
        (problem,) = explorer.answer("evaluate", {"data": data})["problems"]
        assert "slips anyway" in problem["text"]

    def test_a_file_with_mistakes_is_not_opened(self, tmp_path):
        file = tmp_path / "bad.yaml"
        file.write_text("version: 1\nlayers:\n  - {type: fluid, thickness: -1}\n")
        with pytest.raises(InputError, match=r"bad\.yaml:3:30: layers\.0\.thickness: -1.0 is not allowed"):
            Explorer(file)


class TestSave:
    def save(self, explorer, data, **wanted):
        known = explorer.answer("watch", {})["digest"]
        request = {"data": data, "name": "new.yaml", "kind": "simulation", "known": known, **wanted}
        return explorer.answer("save", request)

    def test_a_simulation_is_read_back_as_it_was_on_the_page(self, explorer):
        data = with_thickness(start(explorer)["data"], "33.3 mm")
        assert self.save(explorer, data)["problems"] == []
        again = Explorer(explorer.file.with_name("new.yaml"))
        assert start(again)["data"] == data
        assert "kind: simulation" in again.file.read_text()

    def test_a_stack_leaves_the_simulation_out(self, explorer):
        data = start(explorer)["data"]
        assert self.save(explorer, data, kind="stack")["problems"] == []
        file = explorer.file.with_name("new.yaml")
        assert load_stack(file) == load_stack(explorer.file)
        assert "sweep" not in file.read_text()

    def test_sweep_and_tolerances_may_be_left_out(self, explorer):
        self.save(explorer, start(explorer)["data"], aside=False)
        text = explorer.file.with_name("new.yaml").read_text()
        assert "sweep" not in text
        assert "frequency" in text

    def test_another_file_is_replaced_only_when_asked(self, explorer):
        other = explorer.file.with_name("new.yaml")
        other.write_text("mine")
        answer = self.save(explorer, start(explorer)["data"])
        assert answer["taken"]
        assert answer["problems"][0]["text"] == "new.yaml: there is such a file already"
        assert other.read_text() == "mine"
        assert self.save(explorer, start(explorer)["data"], replace=True)["problems"] == []
        assert other.read_text() != "mine"

    def test_the_opened_file_is_replaced_when_asked_and_known(self, explorer):
        data = with_thickness(start(explorer)["data"], "33.3 mm")
        answer = self.save(explorer, data, name="foam.yaml")
        assert "its comments will be lost" in answer["problems"][0]["text"]
        answer = self.save(explorer, data, name="foam.yaml", replace=True)
        assert answer["digest"] == explorer.answer("watch", {})["digest"]
        assert start(explorer)["data"] == data

    def test_the_opened_file_that_has_changed_is_not_replaced(self, explorer):
        """As by an editor, or by a second window that has saved."""
        first = start(explorer)
        explorer.file.write_text(explorer.file.read_text() + "# changed\n")
        assert explorer.answer("watch", {})["digest"] not in ("", first["digest"])
        answer = self.save(explorer, first["data"], name="foam.yaml", replace=True, known=first["digest"])
        assert "has changed on the disk since this window read it" in answer["problems"][0]["text"]
        assert "taken" not in answer
        assert explorer.file.read_text().endswith("# changed\n")

    @pytest.mark.parametrize(
        "name",
        ["../up.yaml", "/tmp/x.yaml", "a/b.yaml", ".hidden.yaml", "x.txt", "", "x\n.yaml", "a\\b.yaml", "-x.yaml",
         "x" * 200 + ".yaml", "\x1b[2J.yaml", "CON:.yaml"],
    )  # fmt: skip
    def test_nothing_is_written_elsewhere(self, name, explorer):
        before = sorted(explorer.file.parent.parent.rglob("*"))
        answer = self.save(explorer, start(explorer)["data"], name=name)
        assert "is no name of a file here" in answer["problems"][0]["text"]
        assert "\x1b" not in answer["problems"][0]["text"]
        assert sorted(explorer.file.parent.parent.rglob("*")) == before

    @pytest.mark.parametrize("where", ["../elsewhere.yaml", "nowhere.yaml", "../nowhere.yaml"])
    def test_no_link_is_followed_out_of_the_folder(self, where, tmp_path):
        folder = tmp_path / "project"
        folder.mkdir()
        explorer = Explorer(Path(shutil.copy(EXAMPLES / "foam_absorption.yaml", folder / "foam.yaml")))
        elsewhere = tmp_path / "elsewhere.yaml"
        elsewhere.write_text("mine")
        (folder / "new.yaml").symlink_to(where)
        before = sorted(tmp_path.rglob("*"))
        answer = self.save(explorer, start(explorer)["data"], replace=True)
        assert "is a link that leads out of the folder, or to no file" in answer["problems"][0]["text"]
        assert sorted(tmp_path.rglob("*")) == before
        assert elsewhere.read_text() == "mine"

    def test_a_link_inside_the_folder_is_followed(self, explorer):
        other = explorer.file.with_name("other.yaml")
        other.write_text("mine")
        explorer.file.with_name("new.yaml").symlink_to(other.name)
        assert self.save(explorer, start(explorer)["data"])["taken"]
        assert self.save(explorer, start(explorer)["data"], replace=True)["problems"] == []
        assert "kind: simulation" in other.read_text()

    def test_where_the_opened_file_is_gone(self, explorer):
        began = start(explorer)
        explorer.file.rename(explorer.file.with_name("renamed.yaml"))
        assert self.save(explorer, began["data"], known=began["digest"])["digest"] == began["digest"]
        assert self.save(explorer, began["data"], known=began["digest"])["taken"]
        assert self.save(explorer, began["data"], known=began["digest"], replace=True)["problems"] == []
        again = self.save(explorer, began["data"], name="foam.yaml", known=began["digest"])
        assert again["digest"] == explorer.answer("watch", {})["digest"] != ""

    def test_what_is_wrong_is_not_saved(self, explorer):
        answer = self.save(explorer, with_thickness(start(explorer)["data"], "-1 mm"))
        assert answer["problems"]
        assert not explorer.file.with_name("new.yaml").exists()

    def test_paths_in_the_file_hold(self, tmp_path):
        (tmp_path / "mine.yaml").write_text(
            "kind: library\nversion: 1\nmaterials: {felt: {type: limp, porosity: 0.9, flow_resistivity: 2e4, "
            "tortuosity: 1.1, viscous_length: 5e-5, thermal_length: 1e-4, frame_density: 50}}\n"
        )
        file = tmp_path / "felt.yaml"
        file.write_text(
            "version: 1\nlibrary: mine.yaml\nlayers: [{material: felt, thickness: 2 cm}]\ntermination: free\n"
        )
        explorer = Explorer(file)
        began = start(explorer)
        assert began["materials"][0]["name"] == "felt"
        added = explorer.answer("edit", {"data": began["data"], "edit": {"do": "add", "at": 1, "material": "felt"}})
        assert self.save(explorer, added["data"])["problems"] == []
        assert len(load_stack(tmp_path / "new.yaml").layers) == 2


class TestFileOnDisk:
    def test_that_is_gone(self, explorer):
        explorer.file.unlink()
        assert explorer.answer("watch", {})["digest"] == ""
        answer = start(explorer)
        assert "there is no such file" in answer["problems"][0]["text"]
        assert "data" not in answer
        assert answer["types"]  # for a window that goes on with what it has
        assert answer["materials"]

    def test_with_mistakes_is_told_with_its_lines_when_read_again(self, explorer):
        explorer.file.write_text("version: 1\nlayers: []\n")
        (problem,) = start(explorer)["problems"]
        assert f"{explorer.file}:2:9: layers: must not be empty" in problem["text"]


def test_frequencies_go_into_a_file_by_the_names_that_are_documented(file):
    written = load_simulation(file).model_copy(update={"frequency": FrequencyRange(start=200, stop=2000)}).to_dict()
    assert written["frequency"] == {"from": 200, "to": 2000, "points": 200, "spacing": "log"}
    assert SimulationFile.model_validate(written).frequency.stop == 2000


def test_measured_curves(file, tmp_path):
    table = tmp_path / "tube.csv"
    table.write_text(
        "frequency_hz,absorption,normalised_impedance_re,normalised_impedance_im\n100,0.1,1,-9\n200,0.3,1,-4\n"
    )
    (shown,) = start(Explorer(file, [read_measured(table)]))["measured"]
    assert (shown["name"], shown["frequency"]) == ("tube", [100, 200])
    assert shown["curves"]["absorption"]["parts"][0]["values"] == [0.1, 0.3]
    assert shown["curves"]["normalised_impedance"]["parts"][1]["values"] == [-9, -4]
