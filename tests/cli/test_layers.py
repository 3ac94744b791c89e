"""``multilayer layers``: what a stack file may hold, plugins included, those that fail too."""

import json
import re
from typing import Literal

import pytest
from pydantic import Field

from multilayer.layers.base import LAYERS, Layer
from multilayer.layers.fluid import Fluid
from multilayer.registry import RegistryError
from multilayer.units import Length
from tests.cli.command import run, run_elsewhere


@pytest.fixture(scope="module")
def table():
    done = run("layers")
    assert (done.status, done.err) == (0, "")
    return done.out


@pytest.fixture(scope="module")
def described():
    done = run("layers", "--json")
    assert (done.status, done.err) == (0, "")
    return {entry["type"]: entry for entry in json.loads(done.out)}


def own_fields(kind):
    return [name for name in LAYERS[kind].model_fields if name not in ("type", "name")]


@pytest.mark.parametrize("kind", LAYERS.names())
class TestEveryLayer:
    def test_in_the_table(self, table, kind):
        (section,) = re.findall(rf"^{kind}  .*?\n\n", table, re.MULTILINE | re.DOTALL)
        heading, _, *lines = section.strip().splitlines()
        assert heading == f"{kind}  {LAYERS[kind].summary}"
        assert [line.split()[0] for line in lines] == own_fields(kind)

    def test_as_json(self, described, kind):
        entry = described[kind]
        assert entry["summary"] == LAYERS[kind].summary != ""
        assert len(entry["origin"]) == 1
        assert [field["name"] for field in entry["fields"]] == own_fields(kind)
        for field in entry["fields"]:
            assert set(field) == {"name", "unit", "required", "default", "allowed", "meaning"}
            assert field["required"] is LAYERS[kind].model_fields[field["name"]].is_required()

    def test_units(self, described, kind):
        units = {field["name"]: field["unit"] for field in described[kind]["fields"]}
        known = {"thickness": "m", "density": "kg/m^3", "young_modulus": "Pa", "poisson_ratio": "", "loss_factor": ""}
        assert {name: units[name] for name in known if name in units} == {n: u for n, u in known.items() if n in units}


def test_json_lists_every_layer(described):
    assert sorted(described) == LAYERS.names()


def test_bounds_are_shown(table):
    assert re.search(r"^ *poisson_ratio +- +required +> -1, < 0.5 +\w", table, re.MULTILINE)
    assert re.search(r"^ *loss_factor +- +0.0 +>= 0 +\w", table, re.MULTILINE)
    # a field without a default of its own may be left out
    assert re.search(r"^ *sound_speed +m/s +optional +> 0 +\w", table, re.MULTILINE)


class TestTakenNames:
    def test_registering_a_taken_name_names_both(self):
        class Other(Layer):
            """Another fluid."""

        with pytest.raises(RegistryError, match="defined twice") as caught:
            LAYERS.register("fluid", Other)
        assert "multilayer.layers.fluid:Fluid" in str(caught.value)
        assert f"{__name__}:" in str(caught.value)
        assert "rename or remove one" in str(caught.value)
        assert LAYERS["fluid"] is Fluid

    @pytest.fixture
    def plugins(self, tmp_path):
        """Give an installed package whose layers are a sound one, one of a taken name, and one that fails."""
        (tmp_path / "example_layers.py").write_text(
            "from typing import Literal\n"
            "from multilayer.layers.fluid import Fluid\n"
            "class Water(Fluid):\n"
            "    type: Literal['water'] = 'water'\n"
            "    summary = 'water [at rest]'\n"
        )
        metadata = tmp_path / "example_layers-1.2.dist-info"
        metadata.mkdir()
        (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: example-layers\nVersion: 1.2\n")
        (metadata / "entry_points.txt").write_text(
            "[multilayer.layers]\nwater = example_layers:Water\nfluid = example_layers:Water\n"
            "broken = example_layers:Gone\n"
        )
        return str(tmp_path)

    def test_plugins_in_the_list(self, plugins):
        done = run_elsewhere("layers", PYTHONPATH=plugins)
        assert (done.status, done.err) == (0, "")
        assert "water  water [at rest]\n" in done.out
        (line,) = [line for line in done.out.splitlines() if line.startswith("fluid: ")]
        assert "layer 'fluid' is defined twice" in line
        broken = done.out.partition("broken: ")[2]
        assert broken.startswith("layer 'broken' of example_layers:Gone (package example-layers 1.2) does not load")
        # a plugin that fails stops no other
        for kind in LAYERS.names():
            assert re.search(rf"^{kind}(: |  )", done.out, re.MULTILINE)

    def test_a_stack_that_uses_a_taken_name(self, plugins, tmp_path):
        file = tmp_path / "stack.yaml"
        file.write_text("layers:\n  - {type: water, thickness: 1 mm}\n  - {type: fluid, thickness: 1 mm}\n")
        done = run_elsewhere("check", file, PYTHONPATH=plugins)
        assert (done.status, done.out) == (2, "")
        assert done.err.startswith(f"{file}:3:5: layers.1: layer 'fluid' is defined twice, by ")
        for owner in ("multilayer.layers.fluid:Fluid", "example_layers:Water (package example-layers 1.2)"):
            assert owner in done.err
        assert len(done.err.splitlines()) == 1


class Odd(Fluid):
    """A layer with defaults that are no plain data."""

    type: Literal["odd"] = "odd"
    depths: list[Length] = Field(default_factory=lambda: [0.1, 0.2])
    twice: float = Field(default_factory=lambda data: 2 * data["thickness"])
    stiffness: complex = 1e5 + 2e4j


def test_defaults_that_are_made_or_no_plain_data():
    LAYERS.register("odd", Odd)
    try:
        done, table = run("layers", "odd", "--json"), run("layers", "odd")
    finally:
        LAYERS.unregister("odd")
    assert (done.status, done.err, table.status, table.err) == (0, "", 0, "")
    fields = {field["name"]: field for field in json.loads(done.out)[0]["fields"]}
    assert fields["depths"]["default"] == [0.1, 0.2]
    assert (fields["twice"]["default"], fields["twice"]["required"]) == (None, False)
    assert fields["stiffness"]["default"] == "100000+20000j"
    assert re.search(r"^depths +m +\[0.1, 0.2\]", table.out, re.MULTILINE)
    assert re.search(r"^twice +- +optional", table.out, re.MULTILINE)
