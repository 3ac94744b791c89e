"""Changes of a stack's data: what names a layer follows it, and new layers can be computed as they come."""

import json
from itertools import permutations
from typing import get_args

import pytest

from multilayer.errors import InputError
from multilayer.explore.curves import computed
from multilayer.explore.edits import edited
from multilayer.explore.file import validated
from multilayer.explore.starting import completed
from multilayer.layers.base import LAYERS
from multilayer.materials import load_library


def three():
    return {
        "layers": [
            {"type": "elastic_plate", "name": "sheet", "material": "AA2009/T12.1/panel", "thickness": "1 mm"},
            {"type": "fluid", "thickness": "20 mm"},
            {"type": "limp", "name": "wool", "material": "AA2009/T11.2/soft_fibrous", "thickness": "50 mm"},
        ],
        "contacts": [{"between": [1, "wool"], "kind": "slip"}],
        "sweep": {"layers.1.thickness": [0.01, 0.02], "layers.wool.thickness": [0.05]},
        "tolerances": {"layers.2.porosity": 0.01},
        "termination": "rigid",
    }


def titles(data):
    return [layer.get("name") or layer.get("material") or layer["type"] for layer in data["layers"]]


class TestMove:
    def test_what_names_the_layer_goes_with_it(self, tmp_path):
        done = edited(three(), {"do": "move", "layer": 0, "to": 2}, tmp_path)
        assert titles(done.data) == ["fluid", "wool", "sheet"]
        assert done.layer == 2
        assert done.data["contacts"] == [{"between": [0, "wool"], "kind": "slip"}]
        assert done.data["sweep"] == {"layers.0.thickness": [0.01, 0.02], "layers.wool.thickness": [0.05]}
        assert done.data["tolerances"] == {"layers.wool.porosity": 0.01}
        assert done.notices == []

    def test_a_contact_of_layers_that_part_is_taken_away_and_told(self, tmp_path):
        done = edited(three(), {"do": "move", "layer": 2, "to": 0}, tmp_path)
        assert "contacts" not in done.data
        assert done.notices == ["1 contact of layers that are no neighbours any more taken away"]

    def test_the_given_data_stay_as_they_are(self, tmp_path):
        data = three()
        edited(data, {"do": "move", "layer": 0, "to": 2}, tmp_path)
        assert data == three()


class TestRemove:
    def test_its_sweeps_and_tolerances_go_too(self, tmp_path):
        done = edited(three(), {"do": "remove", "layer": 2}, tmp_path)
        assert titles(done.data) == ["sheet", "fluid"]
        assert done.data["sweep"] == {"layers.1.thickness": [0.01, 0.02]}
        assert "tolerances" not in done.data
        assert len(done.notices) == 3

    def test_the_last_layer_stays(self, tmp_path):
        with pytest.raises(InputError, match="a stack needs a layer"):
            edited({"layers": [{"type": "fluid", "thickness": 1}]}, {"do": "remove", "layer": 0}, tmp_path)


class TestOthers:
    def test_copy_has_no_name_and_stands_behind(self, tmp_path):
        done = edited(three(), {"do": "copy", "layer": 2}, tmp_path)
        assert titles(done.data)[2:] == ["wool", "AA2009/T11.2/soft_fibrous"]
        assert "name" not in done.data["layers"][3]
        assert done.layer == 3

    def test_rename_renames_where_the_name_stands(self, tmp_path):
        done = edited(three(), {"do": "rename", "layer": 2, "name": "felt"}, tmp_path)
        assert done.data["contacts"] == [{"between": [1, "felt"], "kind": "slip"}]
        assert "layers.felt.thickness" in done.data["sweep"]
        nameless = edited(done.data, {"do": "rename", "layer": 2, "name": " "}, tmp_path)
        assert nameless.data["contacts"] == [{"between": [1, 2], "kind": "slip"}]
        assert nameless.data["tolerances"] == {"layers.2.porosity": 0.01}

    def test_contact(self, tmp_path):
        done = edited(three(), {"do": "contact", "layer": 2, "kind": "slip"}, tmp_path)
        assert {"between": ["wool", "termination"], "kind": "slip"} in done.data["contacts"]
        bonded = edited(three(), {"do": "contact", "layer": 1, "kind": "bonded"}, tmp_path)
        assert "contacts" not in bonded.data

    def test_another_material_keeps_name_and_thickness_only(self, tmp_path):
        edit = {"do": "become", "layer": 2, "field": "material", "value": "AA2009/T11.6/foam"}
        layer = edited(three(), edit, tmp_path).data["layers"][2]
        assert layer == {"material": "AA2009/T11.6/foam", "name": "wool", "thickness": "50 mm"}

    def test_without_its_material_a_layer_has_the_values_itself(self, tmp_path):
        edit = {"do": "become", "layer": 2, "field": "material", "value": ""}
        done = edited(three(), edit, tmp_path).data
        assert "material" not in done["layers"][2]
        assert done["layers"][2]["flow_resistivity"] == "25000 N s/m^4"
        before, after = (
            computed({"layers": data["layers"], "termination": "rigid"}, tmp_path / "x.yaml")
            for data in (three(), done)
        )
        assert after["curves"] == before["curves"]

    @pytest.mark.parametrize(
        ("edit", "text"),
        [
            ({"do": "fly"}, "there is no edit 'fly'"),
            ({"do": "remove", "layer": 3}, "there is no layer 3 among 3"),
            ({"do": "remove", "layer": True}, "there is no layer True"),
            ({"do": "add", "at": 0, "material": "melamin"}, "there is no material 'melamin'"),
        ],
    )
    def test_what_cannot_be_done_is_told(self, edit, text, tmp_path):
        with pytest.raises(InputError, match=text):
            edited(three(), edit, tmp_path)


def _choices(kind):
    chooser = getattr(kind, "chooser", "")
    return get_args(kind.model_fields[chooser].annotation) if chooser else ("",)


@pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")
@pytest.mark.parametrize(
    ("name", "choice"), [(name, choice) for name, kind in LAYERS.working() for choice in _choices(kind)]
)
def test_every_new_layer_can_be_computed(name, choice, tmp_path):
    data = {"layers": [{"type": "fluid", "thickness": 0.01}], "termination": "rigid", "frequency": [100, 1000]}
    added = edited(data, {"do": "add", "at": 0, "type": name}, tmp_path)
    if choice:
        chooser = LAYERS[name].chooser
        added = edited(added.data, {"do": "become", "layer": 0, "field": chooser, "value": choice}, tmp_path)
        assert added.data["layers"][0][chooser] == choice
    absorption = computed(added.data, tmp_path / "x.yaml")["curves"]["absorption"]["parts"][0]["values"]
    assert all(-1e-6 <= value <= 1 for value in absorption)


@pytest.mark.parametrize("name", load_library())
def test_every_material_can_be_added(name, tmp_path):
    data = {"layers": [{"type": "fluid", "thickness": 0.01}], "termination": "rigid", "frequency": [100, 1000]}
    added = edited(data, {"do": "add", "at": 1, "material": name}, tmp_path)
    assert computed(added.data, tmp_path / "x.yaml")["frequency"] == [100, 1000]


def test_of_an_unknown_type_nothing_is_made_up():
    assert completed({"type": "marshmallow", "name": "x"}) == {"type": "marshmallow", "name": "x"}


@pytest.mark.parametrize(("before", "after"), [*permutations([name for name, _ in LAYERS.working()], 2)])
def test_a_layer_of_any_type_becomes_one_of_any_other(before, after, tmp_path):
    """What it has and the other refuses, as a thickness of a resistive screen, does not stay."""
    data = {"layers": [completed({"type": before, "name": "panel"})], "termination": "rigid"}
    done = edited(data, {"do": "become", "layer": 0, "field": "type", "value": after}, tmp_path)
    assert validated(done.data, tmp_path / "design.yaml").stack.layers[0].type == after
    assert done.data["layers"][0]["name"] == "panel"
    assert json.loads(json.dumps(done.data)) == done.data  # as a page has it


@pytest.mark.parametrize("material", ["AA2009/T11.3/foam", "AA2009/T12.1/panel"])
@pytest.mark.parametrize("after", [name for name, _ in LAYERS.working()])
def test_a_layer_of_a_material_becomes_one_of_any_type(material, after, tmp_path):
    """A material goes where the type refuses what it says, as a soft frame of a plate with holes."""
    data = {"layers": [completed({"material": material}, load_library()[material])], "termination": "rigid"}
    done = edited(data, {"do": "become", "layer": 0, "field": "type", "value": after}, tmp_path)
    assert validated(done.data, tmp_path / "design.yaml").stack.layers[0].type == after
