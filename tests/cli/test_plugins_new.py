"""``multilayer plugins new``: skeletons that work at once, and names that cannot be used."""

import json
import re
import tomllib
from pathlib import Path

import pytest

from multilayer.writing import disk
from tests.cli.command import python, run
from tests.cli.test_bad_input import assert_refused

MANUAL = Path(__file__).parents[2] / "docs" / "plugins.md"
KINDS = ("layer", "law", "effect", "method", "reader", "command")
ENTRY = dict.fromkeys(KINDS, "our_new_thing") | {"command": "our-new-thing"}


def made(folder, kind, name="our-New_thing"):
    done = run("plugins", "new", name, "--kind", kind, "--out", folder)
    assert (done.status, done.err) == (0, "")
    return folder / name


def assert_tests_pass(package):
    done = python("-m", "pytest", "-q", "-p", "no:cacheprovider", cwd=package)
    assert done.status == 0, done.out


@pytest.mark.parametrize("kind", KINDS)
def test_its_tests_pass_at_once(tmp_path, kind):
    package = made(tmp_path / "new" / "folder", kind)
    files = {str(path.relative_to(package)) for path in package.rglob("*") if path.is_file()}
    assert files == {
        "pyproject.toml", "README.md", "our_new_thing.py", "tests/conftest.py", "tests/test_our_new_thing.py",
    }  # fmt: skip
    assert_tests_pass(package)


@pytest.mark.parametrize("kind", KINDS)
def test_its_metadata_lead_to_its_object(tmp_path, kind):
    package = made(tmp_path, kind)
    project = tomllib.loads((package / "pyproject.toml").read_text())
    assert project["project"]["name"] == "our-New_thing"
    group = "modulus_laws" if kind == "law" else f"{kind}s"
    (entries,) = project["project"]["entry-points"].values()
    assert list(project["project"]["entry-points"]) == [f"multilayer.{group}"]
    module, name = entries[ENTRY[kind]].split(":")
    assert project["tool"]["setuptools"]["py-modules"] == [module]
    text = (package / f"{module}.py").read_text()
    assert f"class {name}(" in text or f"def {name}(" in text
    for path in package.rglob("*.*"):
        assert "{{" not in path.read_text()
        assert "{%" not in path.read_text()


@pytest.mark.parametrize("kind", KINDS)
def test_its_module_is_a_plugin_file(tmp_path, kind):
    package = made(tmp_path, kind)
    found = json.loads(run("plugins", "--json", "--plugin", package / "our_new_thing.py").out)
    assert [one["kind"] for one in found if one["name"] == ENTRY[kind]] == [kind]


def test_a_layer_with_three_lines_of_its_own(tmp_path):
    package = made(tmp_path, "layer")
    file = package / "our_new_thing.py"
    edited = {
        "tortuosity: Tortuosity = 1.0": "tortuosity: Tortuosity = 1.3",
        "density = self.tortuosity * gas.density / self.porosity + self.flow_resistivity / (1j * wave.omega)":
            "density = gas.density / self.porosity * (self.tortuosity + 200.0 / (1j * wave.omega))",
        "bulk_modulus = gas.density * gas.sound_speed**2 / self.porosity":
            "bulk_modulus = gas.pressure * (1 + 0.1j) / self.porosity",
    }  # fmt: skip
    text = file.read_text()
    for old, new in edited.items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    file.write_text(text)
    assert_tests_pass(package)


def test_the_layer_of_the_manual_in_the_skeleton(tmp_path):
    package = made(tmp_path, "layer", "my-foam")
    (code,) = (code for code in re.findall(r"```python\n(.*?)```", MANUAL.read_text(), re.DOTALL) if "MyFoam" in code)
    (package / "my_foam.py").write_text(code)
    done = python("-m", "pytest", "-q", "-p", "no:cacheprovider", cwd=package)
    assert (done.status, "skipped" in done.out) == (0, False), done.out
    assert code.count("    examples = ") == 1
    (package / "my_foam.py").write_text(re.sub(r"    examples = .*\n", "", code))
    done = python("-m", "pytest", "-q", "-p", "no:cacheprovider", cwd=package)
    assert done.status == 1
    assert "give the class 'examples', fields of typical layers: check_layer checks those" in done.out


def test_a_wrong_edit_is_caught(tmp_path):
    package = made(tmp_path, "layer")
    file = package / "our_new_thing.py"
    text = file.read_text()
    assert text.count("+ self.flow_resistivity / (1j * wave.omega)") == 1
    file.write_text(text.replace("+ self.flow_resistivity / (1j", "- self.flow_resistivity / (1j"))
    done = python("-m", "pytest", "-q", "-p", "no:cacheprovider", cwd=package)
    assert done.status == 1
    assert "passivity: some fields leave with more power than they bring" in done.out


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("1foam", "'1foam' is no name for a package: write letters and digits"),
        ("my foam", "'my foam' is no name for a package"),
        ("my--foam", "'my--foam' is no name for a package"),
        ("../foam", "'../foam' is no name for a package"),
        ("schaum-\u00e4", "is no name for a package"),
        ("f" * 61, "60 characters at most"),
        ("", "'' is no name for a package"),
        ("lambda", "'lambda' is a word of Python's grammar"),
        ("json", "Python has a module 'json' already"),
        ("numpy", "a module 'numpy' is installed already"),
        ("Multilayer", "a module 'multilayer' is installed already"),
        ("literal", "its class would be called 'Literal', as something that its module imports"),
        ("class-var", "its class would be called 'ClassVar', as something that its module imports"),
        ("length", "its class would be called 'Length', as something that its module imports"),
        ("membrane", "layer 'membrane' is there already, by multilayer.layers.membrane:Membrane (package multilayer"),
    ],
)
def test_a_name_that_cannot_be(tmp_path, name, words):
    assert_refused(run("plugins", "new", name, "--kind", "layer", "--out", tmp_path), words)
    assert list(tmp_path.iterdir()) == []


def test_a_command_of_ours(tmp_path):
    done = run("plugins", "new", "shape-factor", "--kind", "command", "--out", tmp_path)
    assert_refused(done, "'shape-factor' cannot be the package's name: 'shape-factor' is a built-in command")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_exists(tmp_path):
    (tmp_path / "my-foam").mkdir()
    done = run("plugins", "new", "my-foam", "--kind", "law", "--out", tmp_path)
    assert_refused(done, f"{tmp_path / 'my-foam'}: there is such a file or folder already")
    assert list((tmp_path / "my-foam").iterdir()) == []


def test_a_place_that_is_a_file(tmp_path):
    (tmp_path / "taken").write_text("")
    done = run("plugins", "new", "my-foam", "--kind", "law", "--out", tmp_path / "taken")
    assert_refused(done, "cannot be written to")
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


def test_a_disk_that_fills_leaves_nothing(tmp_path, monkeypatch):
    write = disk.write

    def full(path, data):
        if path.name.startswith("test_"):
            raise OSError(28, "No space left on device")
        return write(path, data)

    monkeypatch.setattr(disk, "write", full)
    assert_refused(run("plugins", "new", "my-foam", "--kind", "law", "--out", tmp_path), "No space left on device")
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_kind(tmp_path):
    done = run("plugins", "new", "my-foam", "--kind", "solver", "--out", tmp_path)
    assert done.status == 2
    for kind in KINDS:
        assert kind in done.err


def test_help_shows_examples():
    for command in (("plugins",), ("plugins", "new")):
        done = run(*command, "--help")
        assert (done.status, done.err) == (0, "")
        assert "Example: multilayer plugins new my-foam --kind layer" in " ".join(done.out.split())
