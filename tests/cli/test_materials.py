"""``multilayer materials``, and what ``multilayer layers`` says of fields and models."""

import json

import pytest

from multilayer.layers import LAYERS
from multilayer.layers.meanings import MEANINGS
from multilayer.materials import load_library
from tests.cli.command import run


def test_all_are_listed_with_their_sources():
    done = run("materials")
    assert done.status == 0
    for name, fields in load_library().items():
        (line,) = [line for line in done.out.splitlines() if line.split()[:1] == [name]]
        assert fields["source"][:20] in line


def test_a_part_of_a_name_suffices():
    found = json.loads(run("materials", "glass_wool", "--json").out)
    assert [entry["name"] for entry in found] == [name for name in load_library() if "glass_wool" in name]
    assert "flow_resistivity  40000 N s/m^4" in run("materials", "AA2009/T6.1/glass_wool").out


def test_a_library_of_ones_own(tmp_path):
    file = tmp_path / "ours.yaml"
    file.write_text("version: 1\nmaterials:\n  our_foam: {source: lot 7, type: fluid, density: 2}\n")
    assert "our_foam  fluid  lot 7" in run("materials", "--library", file).out
    done = run("materials", "foan", "--library", file)
    assert (done.status, done.err) == (2, "there is no material 'foan'; allowed: our_foam\n")


@pytest.mark.parametrize("name", [name for name in LAYERS.names() if LAYERS[name].__module__.startswith("multilayer.")])
def test_every_field_of_a_built_in_layer_is_explained(name):
    fields = set(LAYERS[name].model_fields) - {"type", "name"}
    assert fields <= set(MEANINGS)


def test_a_layer_by_name_tells_what_its_models_take():
    done = run("layers", "equivalent_fluid")
    lines = [" ".join(line.split()) for line in done.out.splitlines()]
    assert "miki flow_resistivity" in lines
    assert "jca porosity, flow_resistivity, tortuosity, viscous_length, thermal_length" in lines
    assert "what each model takes" not in run("layers").out
