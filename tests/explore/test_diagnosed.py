"""A page that begins with what a diagnosis named."""

import json
import shutil

import pytest

from multilayer.errors import InputError
from multilayer.explore.diagnosed import is_diagnosis, open_diagnosis
from multilayer.explore.model import ModelExplorer
from tests.cli.command import run
from tests.cli.test_diagnose_levels import write


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Give a folder with a wall of which 4 dB are missing, and its diagnosis."""
    folder = tmp_path_factory.mktemp("wall")
    assert run("diagnose", write(folder), "--out", folder / "diagnosis").status == 0
    return folder


@pytest.fixture
def results(folder, tmp_path):
    """Give a copy of the diagnosis, to be spoilt."""
    return shutil.copytree(folder / "diagnosis", tmp_path / "diagnosis")


@pytest.mark.parametrize("name", ["", "diagnosis.json"])
def test_it_begins_with_what_was_named(folder, name):
    path = folder / "diagnosis" / name
    assert is_diagnosis(path)
    diagnosis = open_diagnosis(path)
    record = json.loads((folder / "diagnosis/diagnosis.json").read_text())
    (cause,) = (one for one in record["causes"] if one["effects"] == list(diagnosis.effects))
    assert record["verdict"] == "effect"
    assert diagnosis.changed == []
    explorer = ModelExplorer(diagnosis.source, diagnosis.effects)
    first = explorer.answer("start", {})["first"]
    shown = explorer.answer("evaluate", first)
    assert list(first["effects"]) == cause["effects"]
    for parameter, entry in cause["parameters"].items():
        value = float(shown["values"][parameter]["text"]) * shown["values"][parameter]["factor"]
        assert entry["low"] < value < entry["high"]
    assert explorer.answer("start", {})["z"] != first["z"]
    assert shown["misfit"] < 1


def test_it_begins_with_the_verdict_not_with_what_stands_first(folder, results):
    """A pair with more evidence may stand before the single effect that is enough."""
    record = json.loads((results / "diagnosis.json").read_text())
    pair = {**record["causes"][0], "effects": ["leak", *record["group"][0]]}
    (results / "diagnosis.json").write_text(json.dumps(record | {"causes": [pair, *record["causes"]]}))
    assert list(open_diagnosis(results).effects) == record["group"][0]


def test_without_a_named_effect_it_begins_with_the_nominal_model(folder, results):
    record = json.loads((results / "diagnosis.json").read_text())
    (results / "diagnosis.json").write_text(json.dumps(record | {"verdict": "unknown"}))
    diagnosis = open_diagnosis(results)
    assert diagnosis.effects == {}
    assert ModelExplorer(diagnosis.source, diagnosis.effects).answer("start", {})["first"] is None


def test_changed_inputs_are_told(folder, results):
    manifest = json.loads((results / "manifest.json").read_text())
    inputs = manifest["results"]["diagnose"]["inputs"]
    table = next(name for name in inputs if name.endswith(".csv"))
    inputs[table] = "0" * 64
    (results / "manifest.json").write_text(json.dumps(manifest))
    assert open_diagnosis(results).changed == [table]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda one: (one / "manifest.json").unlink(), "there is no manifest.json"),
        (lambda one: (one / "diagnosis.json").unlink(), "cannot be read: No such file"),
        (lambda one: (one / "diagnosis.json").write_text("{"), "this is no diagnosis.json"),
        (lambda one: (one / "diagnosis.json").write_text('{"verdict": "effect", "causes": 3}'), "this is no"),
        (lambda one: (one / "diagnosis.json").write_text('{"verdict": "effect", "causes": []}'), "this is no"),
        (lambda one: _rename_inputs(one, ".yaml", "-gone.yaml"), "what was diagnosed is not there"),
        (lambda one: _rename_inputs(one, ".yaml", ".txt"), "none of the inputs is a campaign or a fit file"),
    ],
)
def test_what_is_wrong_is_told(results, change, told):
    change(results)
    with pytest.raises(InputError, match=told):
        open_diagnosis(results / "diagnosis.json")


def _rename_inputs(folder, ending, other):
    file = folder / "manifest.json"
    manifest = json.loads(file.read_text())
    entry = manifest["results"]["diagnose"]
    entry["inputs"] = {name.replace(ending, other): digest for name, digest in entry["inputs"].items()}
    file.write_text(json.dumps(manifest))


@pytest.mark.parametrize(
    ("named", "told"),
    [({"no_such": {}}, "not known here"), ({"receiving_absorption": {"size": 1.0}}, "has other parameters")],
)
def test_effects_of_another_version_are_told(folder, named, told):
    with pytest.raises(InputError, match=told):
        ModelExplorer(open_diagnosis(folder / "diagnosis").source, named)


def test_the_command_says_why(tmp_path):
    result = run("explore", tmp_path / "diagnosis.json", "--no-browser")
    assert result.status == 2
    assert "there is no manifest.json" in result.err
