"""The material library, a user's own beside it, and `material: NAME` in a stack file."""

import json
import math
import re

import pytest

from multilayer.errors import InputError
from multilayer.layers import LAYERS
from multilayer.layers.equivalent_fluid import EquivalentFluid
from multilayer.layers.limp import Limp
from multilayer.layers.poroelastic import Poroelastic
from multilayer.materials import BUILT_IN as BUILT_IN_FILE
from multilayer.materials import TEXTS, check_library, load_library, material
from multilayer.stack import Stack, load_stack

BUILT_IN = load_library()
FOAM = "AA2009/T11.3/foam"


def layer_of(wanted, **fields):
    return Stack.model_validate({"layers": [{"material": wanted, **fields}]}).layers[0]


class TestLibrary:
    @pytest.mark.parametrize("name", BUILT_IN)
    def test_every_material_makes_its_layer(self, name):
        given = BUILT_IN[name]
        kind = LAYERS[given["type"]]
        thickness = {"thickness": 0.01} if "thickness" in kind.model_fields else {}
        layer = layer_of(name, **thickness)
        assert layer.type == given["type"]
        assert all(getattr(layer, field) is not None for field in kind.fields_taken(given) & set(given))

    @pytest.mark.parametrize("name", BUILT_IN)
    def test_every_material_has_a_source(self, name):
        assert re.search(r"\b(19|20)\d\d\b", BUILT_IN[name]["source"])

    def test_material(self):
        assert material(FOAM) == BUILT_IN[FOAM]
        material(FOAM)["porosity"] = 0.1
        assert material(FOAM)["porosity"] == 0.98

    @pytest.mark.parametrize(
        ("name", "words"),
        [
            ("AA2009/T11.3/foma", "did you mean 'AA2009/T11.3/foam'?"),
            ("glass_wool", "did you mean 'AA2009/T6.1/glass_wool' or 'AA2009/T11.8/glass_wool'?"),
            ("unobtainium", "allowed: AA2009/T11.2/soft_fibrous, "),
        ],
    )
    def test_unknown(self, name, words):
        with pytest.raises(InputError) as caught:
            material(name)
        assert str(caught.value).startswith(f"there is no material '{name}'; {words}")

    @pytest.mark.parametrize(
        ("name", "expected"), [("AA2009/T6.1/glass_wool", 43.27), ("AA2009/T11.2/soft_fibrous", 127.4)]
    )
    def test_decoupling_frequencies_of_the_book(self, name, expected):
        """sigma phi^2 / (2 pi rho1), Hz, as printed there."""
        layer = layer_of(name, type="limp", thickness=0.05)
        ours = layer.flow_resistivity * layer.porosity**2 / (2 * math.pi * layer.frame_density)
        assert ours == pytest.approx(expected, rel=1e-3)


# names in the tables of ../shared -> ours, with the unit of theirs
_FIELDS = {
    "phi": ("porosity", 1.0), "sigma": ("flow_resistivity", 1.0), "alpha": ("tortuosity", 1.0),
    "Lam": ("viscous_length", 1e-6), "Lamp": ("thermal_length", 1e-6), "rho1": ("frame_density", 1.0),
    "rho": ("density", 1.0), "E": ("young_modulus", 1.0), "nu": ("poisson_ratio", 1.0), "eta": ("loss_factor", 1.0),
}  # fmt: skip
_DEFECTS = {
    ("AA2009/T11.4/foam3", "E"): "E_likely", ("AA2009/T11.4/foam4", "E"): "E_likely",
    ("Dazel2013/TV/A", "sigma"): "sigma_reproducing_Fig3",
}  # fmt: skip
_BUILDING = {
    "Vigran2008/T8.2/plasterboard": (800, 3.2e9), "Bauakustik/T4.2.4-1/concrete": (2300, 25e9),
    "Bauakustik/T4.2.4-1/gypsum_board": (950, 3.3e9), "Bauakustik/T4.2.4-1/glass": (2500, 65e9),
    "Bauakustik/T4.2.4-1/chipboard": (650, 4.5e9),
}  # fmt: skip
_RENAMED = {
    "T6.1 Domisol": "T6.1/glass_wool", "T11.2 soft fibrous": "T11.2/soft_fibrous", "T11.3/sheet": "T11.3/porous_sheet",
    "T11.8/glasswool": "T11.8/glass_wool",
}  # fmt: skip


def tables(shared):
    """Yield our name and the table's values of every material with a density."""
    data = json.loads((shared / "reference" / "material_tables.json").read_text())
    groups = {"AA2009": data["AA2009"], "AP2005": data["AtallaPanneton2005"], "Dazel2013/TV": data["Dazel2013_TableV"]}
    for group, entries in groups.items():
        for key, entry in entries.items():
            parts = {key: entry} if "phi" in entry or "rho" in entry else {f"{key}/{k}": v for k, v in entry.items()}
            for name, values in parts.items():
                if isinstance(values, dict) and {"phi", "E"} & set(values):
                    yield f"{group}/{_RENAMED.get(name, name)}", values


@pytest.mark.reference
def test_values_are_those_of_the_tables(shared):
    compared = set()
    for name, values in tables(shared):
        layer = layer_of(name, thickness=0.01)
        for theirs, (ours, unit) in _FIELDS.items():
            if theirs in values and hasattr(layer, ours):
                expected = values[_DEFECTS.get((name, theirs), theirs)] * unit
                assert getattr(layer, ours) == pytest.approx(expected, rel=1e-12), (name, ours)
        compared.add(name)
    others = {"AA2009/T11.6/membrane", "AA2009/T11.7/impervious_screen"}
    assert compared == set(BUILT_IN) - others - set(_BUILDING)


@pytest.mark.parametrize(("name", "values"), _BUILDING.items())
def test_plates_that_are_built_with(name, values):
    """Density and modulus as printed; the critical frequency of 10 mm is that of textbooks: glass 1.2, board 3 kHz."""
    layer = layer_of(name, thickness=0.01)
    assert (layer.density, layer.young_modulus) == values
    critical = 343**2 / (2 * math.pi) * math.sqrt(12 * layer.density * (1 - layer.poisson_ratio**2) / values[1]) / 0.01
    assert 1000 < critical < 3600


@pytest.mark.parametrize("name", sorted({name for name, _ in _DEFECTS} | {"AA2009/T11.7/fibrous"}))
def test_print_defects_are_noted(name):
    assert "printed as" in BUILT_IN[name]["note"]


class TestInAStack:
    def test_own_fields_come_first(self):
        layer = layer_of(FOAM, thickness="30 mm", tortuosity=1.3, name="foam")
        assert isinstance(layer, Poroelastic)
        assert (layer.tortuosity, layer.porosity, layer.name) == (1.3, 0.98, "foam")

    def test_another_layer_type_takes_what_it_has(self):
        layer = layer_of(FOAM, type="equivalent_fluid", thickness=0.03)
        assert isinstance(layer, EquivalentFluid)
        assert (layer.model, layer.flow_resistivity, layer.thermal_length) == ("jca", 5000.0, 216e-6)
        assert isinstance(layer_of(FOAM, type="limp", thickness=0.03), Limp)

    def test_another_model_takes_what_it_needs(self):
        layer = layer_of(FOAM, type="equivalent_fluid", model="miki", thickness=0.03)
        assert (layer.flow_resistivity, layer.porosity) == (5000.0, None)

    def test_written_back_without_the_library(self):
        stack = Stack.model_validate({"layers": [{"material": FOAM, "thickness": 0.03}]})
        assert "material" not in stack.to_dict()["layers"][0]
        assert Stack.model_validate(stack.to_dict()) == stack

    @pytest.fixture
    def files(self, tmp_path):
        """Write a library and return how to write and read a stack beside it."""
        (tmp_path / "ours.yaml").write_text(
            "materials:\n"
            "  wool:\n"
            "    note: measured last year\n"
            "    type: limp\n"
            "    porosity: 97 %\n"
            "    flow_resistivity: 12 kN s/m^4\n"
            "    tortuosity: 1.0\n"
            "    viscous_length: 60 um\n"
            "    thermal_length: 120 um\n"
            "    frame_density: 40\n"
            f"  {FOAM}: {{type: equivalent_fluid, model: miki, flow_resistivity: 1e4}}\n"
            "  odd: {type: equivalent_fluid, model: miki, flow_resistivity: -5}\n"
        )

        def load(*layers, library="ours.yaml"):
            file = tmp_path / "stack.yaml"
            lines = [f"library: {library}"] if library else []
            file.write_text("\n".join([*lines, "layers:", *(f"- {layer}" for layer in layers)]) + "\n")
            return load_stack(file)

        return load

    def test_own_library(self, files):
        wool, foam, plate = files(
            "{material: wool, thickness: 2 cm}",
            f"{{material: {FOAM}, thickness: 2 cm}}",
            "{material: AA2009/T12.2/steel, thickness: 1 mm}",
        ).layers
        assert (wool.type, wool.porosity, wool.flow_resistivity) == ("limp", 0.97, 12e3)
        assert (foam.model, foam.flow_resistivity) == ("miki", 1e4)  # before the built-in one of this name
        assert plate.young_modulus == 210e9

    def test_by_function(self, files, tmp_path):
        assert material("wool", tmp_path / "ours.yaml")["frame_density"] == 40
        assert set(load_library(tmp_path / "ours.yaml")) == {"wool", FOAM, "odd"}

    def mistakes(self, files, *layers, library="ours.yaml"):
        with pytest.raises(InputError) as caught:
            files(*layers, library=library)
        return [(p.line, p.column, p.path, p.message) for p in caught.value.problems]

    def test_mistakes_are_told_together_at_their_places(self, files):
        told = self.mistakes(
            files,
            "{material: wolo, thickness: 2 cm}",
            "{material: wool, thickness: 2 cm, porosity: 2}",
            "{material: wool}",
            "{material: odd, thickness: 2 cm}",
            "{material: 5, thickness: 2 cm}",
        )
        assert told == [
            (3, 14, "layers.0.material", "there is no material 'wolo'; did you mean 'wool'?"),
            (4, 47, "layers.1.porosity", "2.0 is not allowed: it must be below 1.0"),
            (5, 3, "layers.2.thickness", "is missing; it is required"),
            (6, 3, "layers.3", "flow_resistivity of its material 'odd': -5.0 is not allowed: it must be above 0.0"),
            (7, 14, "layers.4.material", "must be the name of a material, not 5"),
        ]

    def test_no_such_library(self, files):
        told = self.mistakes(files, "{material: wool, thickness: 2 cm}", "{type: fluid}", library="their.yaml")
        assert [place[:3] for place in told] == [(1, 10, "library"), (4, 3, "layers.1.thickness")]
        assert "their.yaml: there is no such file" in told[0][3]

    def test_library_that_is_no_path(self, files):
        (told,) = self.mistakes(files, "{type: fluid, thickness: 1}", library="[a]")
        assert told == (1, 10, "library", "must be the path of a library file, not ['a']")

    def test_mistakes_in_the_library(self, files, tmp_path):
        (tmp_path / "bad.yaml").write_text("materials:\n  wool: {type: limp, porsity: 0.9}\n  x: 5\n")
        with pytest.raises(InputError) as caught:
            load_library(tmp_path / "bad.yaml")
        assert [(p.line, p.column, p.message) for p in caught.value.problems] == [
            (2, 22, "no layer has such a field; did you mean 'porosity'?"),
            (3, 6, "must be a mapping of fields, not 5"),
        ]
        (told,) = self.mistakes(files, "{material: wool, thickness: 1}", library="bad.yaml")
        assert "no layer has such a field" in told[3]

    def test_files_of_a_library_are_looked_for_beside_it(self, files, tmp_path, monkeypatch):
        (tmp_path / "ours").mkdir()
        (tmp_path / "ours" / "rubber.csv").write_text("f [Hz],E1 [Pa],E2 [Pa]\n1,1e6,1e5\n1e4,2e6,2e5\n")
        law = "{law: shifted, modulus: {law: table, file: rubber.csv}, reference_temperature: 20 degC}"
        (tmp_path / "ours" / "library.yaml").write_text(
            "materials:\n  rubber: {type: elastic_solid, density: 1100, poisson_ratio: 0.45,\n"
            f"    young_modulus: {law.replace('}, ref', '}, activation_energy: 1e5, temperature: 30 degC, ref')}}}\n"
        )
        monkeypatch.chdir(tmp_path)
        (rubber,) = files("{material: rubber, thickness: 1 cm}", library="ours/library.yaml").layers
        assert rubber.young_modulus.modulus.storage_modulus == (1e6, 2e6)
        assert check_library("ours/library.yaml") == 1

    def test_values_of_a_library_are_checked_where_it_is_asked_for(self, tmp_path):
        (tmp_path / "bad.yaml").write_text(
            "materials:\n"
            "  gas: {type: nonsense, density: 12 s}\n"
            "  foam: {type: limp, porosity: banana, frame_density: 12 s, porsity: 1, source: a book}\n"
            "  part: {type: poroelastic, porosity: 0.9, thermal_permeability: 1e-9, model: jca}\n"
            "  wool: {porosity: 0.9}\n"
            "  mat: {type: elastic_solid, young_modulus: {law: complex, storage_modulus: 1e6}}\n"
            "  felt: {thickness: 3 mm, model: delany_bazley, porosity: 1.2, density: 12 s}\n"
        )
        with pytest.raises(InputError) as caught:
            check_library(tmp_path / "bad.yaml")
        told = [(p.line, p.path, p.message.partition(";")[0]) for p in caught.value.problems]
        assert told == [
            (2, "materials.gas.type", "there is no layer type 'nonsense'"),
            (3, "materials.foam.porosity", "'banana' is no number"),
            (3, "materials.foam.frame_density", "'12 s' has the wrong unit: this is a quantity in kg/m^3, as 2700 or "
                                                "'2700 kg/m^3'"),
            (3, "materials.foam.porsity", "no layer has such a field"),
            (6, "materials.mat.young_modulus.loss_modulus", "is missing"),
            (7, "materials.felt.porosity", "1.2 is not allowed: it must be below 1.0"),
            (7, "materials.felt.density", "'12 s' has the wrong unit: this is a quantity in kg/m^3, as 2700 or "
                                          "'2700 kg/m^3'"),
        ]  # fmt: skip
        assert check_library(BUILT_IN_FILE) == len(BUILT_IN)

    def test_keys_that_are_misspelt(self, tmp_path):
        (tmp_path / "ours.yaml").write_text("materials:\n  air: {type: fluid}\n")
        file = tmp_path / "stack.yaml"
        file.write_text(
            "libary: ours.yaml\n"
            "layers:\n"
            "- {materal: air, thickness: 1 cm}\n"
            f"- {{type: poroelastic, Material: {FOAM}, thickness: 1 cm}}\n"
        )
        with pytest.raises(InputError) as caught:
            load_stack(file)
        assert [(p.line, p.path, p.message) for p in caught.value.problems] == [
            (1, "libary", "there is no such field; did you mean 'library'?"),
            (3, "layers.0.materal", "there is no such field; did you mean 'material'?"),
            (4, "layers.1.Material", "there is no such field; did you mean 'material'?"),
        ]

    def test_a_second_damping_that_the_material_brings(self, files):
        ((*_, told),) = self.mistakes(
            files, f"{{material: {FOAM}, thickness: 2 cm, young_modulus: 1e5+1e4j}}", library=""
        )
        assert told == (
            f"with what its material '{FOAM}' gives: loss_factor stands beside a young_modulus that has losses "
            "already; give one of the two, or write 'loss_factor: 0'"
        )
        (foam,) = files(
            f"{{material: {FOAM}, thickness: 2 cm, young_modulus: 1e5+1e4j, loss_factor: 0}}", library=""
        ).layers
        assert foam.young_modulus == 1e5 + 1e4j

    def test_without_materials_nothing_changes(self, files):
        assert files("{type: fluid, thickness: 1}", library=None).layers[0].type == "fluid"
        with pytest.raises(InputError, match="there is no such field"):
            files("{type: fluid, thickness: 1, source: a book}", library=None)

    def test_texts_are_no_fields(self):
        assert not set(TEXTS) & {name for kind in LAYERS for name in LAYERS[kind].model_fields}
