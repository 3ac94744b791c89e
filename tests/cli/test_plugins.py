"""``multilayer plugins``: what is registered and by whom, what is broken and why; single files by ``--plugin``."""

import json
import re
import tomllib
from pathlib import Path

import pytest
from typer.main import get_command

from multilayer.cli import app
from multilayer.cli.plugin_commands import OF_THIS_PROJECT
from multilayer.diagnosis.places import LEVEL_PLACES, PLACES, TUBE_PLACES
from multilayer.errors import InputError
from multilayer.layers import LAYERS
from multilayer.measurements.readers import read_channels, read_spectra, read_waveforms
from multilayer.plugins.commands import BUILT_IN
from multilayer.plugins.files import plugin_files
from multilayer.plugins.listing import KINDS, describe_plugins
from multilayer.registry import Registry
from multilayer.testing import check_place
from tests.cli.command import run, run_elsewhere
from tests.cli.test_bad_input import assert_refused

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
# what a short diagnosis of a tube leaves out
SLOW = (
    "edge_constraint", "facing", "frame_motion", "lateral_air_gap", "microphone_gain", "rear_air_gap", "temperature",
    "sample_position",
)  # fmt: skip

LAYER = """\
from typing import Literal
from multilayer.layers.fluid import Fluid

class Water(Fluid):
    type: Literal['water'] = 'water'
    density: float = 1000.0
    sound_speed: float = 1480.0
"""
FACES = """\
import numpy as np
from multilayer.layers.fluid import fluid_faces
from multilayer.matrix.faces import Faces
from multilayer.matrix.families import FLUID
"""
EFFECT = """\
from multilayer.diagnosis.effects.base import positive
from multilayer.diagnosis.effects.tube import TubeEffect

class Damp(TubeEffect):
    name = 'damp'
    law = 'R (1 - a)'
    separated_by = 'drying'
    source = 'nowhere'
    parameters = (positive('a', 0.01, 1.0),)

    def reading(self, setting, reflection, values):
        return reflection * (1 - values['a'])
"""
FIELDS = """\
from __future__ import annotations
from typing import Annotated, Literal
from pydantic import Field
from multilayer.layers.fluid import Fluid

class Untyped(Fluid):
    type: Literal['untyped'] = 'untyped'
    extra: Nowhere = 1

class Unbounded(Fluid):
    type: Literal['unbounded'] = 'unbounded'
    extra: Annotated[int, Field(multiple_of='x')] = 1
"""
PLACE = """\
from multilayer.diagnosis.places import LevelPlace, Place, TubePlace

class Housing(Place):
    name, title, quantity = 'housing', 'in the housing', 'relative change of the reading'

    def motion(self, setting, motion, values):
        return motion * (1 + values)

class Front(TubePlace):
    name, title, quantity = 'front', 'in front', 'relative change of R'

    def reading(self, setting, reflection, values):
        return reflection * (1 + values)

class Meter(LevelPlace):
    name, title, quantity, unit = 'meter', 'in the meter', 'change of the level', 'dB'

    def reading(self, setting, level, values):
        return level + values
"""
COMMAND = """\
from pathlib import Path
import typer
Path(__file__).with_suffix('.imported').touch()

def command_greet(name: str, times: int = 1) -> None:
    '''Greet.

    Example: multilayer greet Anna
    '''
    from multilayer.layers import LAYERS
    typer.echo(f"{'hello ' * times}{name}, {'brine' in LAYERS}")

def unmade(what: int | str) -> None: ...
def untyped(what: Nowhere) -> None: ...
def grasping(plugin: str) -> None: ...
def sloppy(**options: str) -> None: ...
def bare(what, times=3) -> None: ...
"""
STACK = "layers:\n  - {type: water, thickness: 10 mm}\nfrequency: [100, 200, 400]\ntermination: rigid\n"


@pytest.fixture
def broken(tmp_path):
    """Give a path with an installed package: a sound layer, and one of each way to be broken."""
    root = tmp_path / "site"
    info = root / "house_plugins-1.2.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: house-plugins\nVersion: 1.2\n")
    (info / "entry_points.txt").write_text(
        "[multilayer.layers]\nwater = house_good:Water\nraising = house_raising:Water\nleaving = house_leaving:Water\n"
        "number = house_good:NUMBER\nmisnamed = house_good:Water\nmembrane = house_good:Water\n"
        "untyped = house_fields:Untyped\nunbounded = house_fields:Unbounded\n"
        "[multilayer.effects]\ndamp = house_raising:Damp\nmute = house_good:Water\n"
        "[multilayer.modulus_laws]\nspring = house_good:Water\n"
        "[multilayer.readers]\nxyz = house_good:NUMBER\nDAQ = house_commands:command_greet\n"
        "[multilayer.commands]\ngreet = house_commands:command_greet\nfit = house_commands:command_greet\n"
        "unmade = house_commands:unmade\nungiven = house_commands:untyped\ngrasping = house_commands:grasping\n"
        "sloppy = house_commands:sloppy\nbare = house_commands:bare\n"
        "five = house_good:NUMBER\ncrash = house_raising:crash\n"
    )
    (root / "house_good.py").write_text(f"{LAYER}\nNUMBER = 5\n")
    (root / "house_commands.py").write_text(f"from __future__ import annotations\n{COMMAND}")
    (root / "house_fields.py").write_text(FIELDS)
    (root / "house_raising.py").write_text("raise RuntimeError('no\\nlicence')\n")
    (root / "house_leaving.py").write_text("raise SystemExit(3)\n")
    return str(root)


BROKEN = {
    ("layer", "raising"): "house_raising:Water (package house-plugins 1.2) does not load: RuntimeError: no\nlicence",
    ("layer", "leaving"): "house_leaving:Water (package house-plugins 1.2) does not load: SystemExit: 3",
    ("layer", "number"): "cannot be used: it is 5, not a subclass of multilayer.layers.base.Layer",
    ("layer", "misnamed"): "its 'type' is 'water'; it must be 'misnamed'",
    ("layer", "membrane"): "is defined twice, by",
    ("layer", "untyped"): "its fields make no model: name 'Nowhere' is not defined",
    ("layer", "unbounded"): "its fields make no model: Error building",
    ("effect", "damp"): "does not load: RuntimeError",
    ("effect", "mute"): "not a subclass of multilayer.experiments.effects.BaseEffect",
    ("law", "spring"): "not a subclass of multilayer.media.laws.base.ModulusLaw",
    ("reader", "xyz"): "it is 5, not a function",
    ("reader", "DAQ"): "readers are found by the last suffix of a file, in small letters; call it 'daq'",
    (
        "command",
        "fit",
    ): "of house_commands:command_greet (package house-plugins 1.2) cannot be used: a built-in",
    ("command", "unmade"): "its parameters make no command: ",
    ("command", "ungiven"): "its parameters make no command: NameError: name 'Nowhere' is not defined",
    ("command", "grasping"): "it has a parameter 'plugin', an option that every command has",
    ("command", "sloppy"): "it has parameters that cannot be given by name",
    ("command", "bare"): "its parameter 'what' has no annotation; write the type that it is read as, as 'what: float'",
    ("command", "five"): "it is 5, not a function",
    ("command", "crash"): "does not load: RuntimeError",
}


class TestList:
    def test_everything_of_ours_works(self):
        done = run("plugins", "--json")
        assert (done.status, done.err) == (0, "")
        found = json.loads(done.out)
        assert {entry["kind"] for entry in found} | {"command"} == set(KINDS)  # commands: of plugins only
        assert [entry for entry in found if "error" in entry] == []
        assert all(entry["origin"][0]["package"] for entry in found)
        ours = [entry for entry in found if entry["name"] == "elastic_solid"]
        assert ours[0]["origin"][0]["value"] == "multilayer.layers.elastic_solid:ElasticSolid"

    def test_as_a_table(self):
        done = run("plugins")
        assert (done.status, done.err) == (0, "")
        for entry in describe_plugins():
            assert re.search(rf"^{entry['kind']} +{entry['name']} +", done.out, re.MULTILINE)

    def test_what_is_broken_is_told_and_stops_nothing(self, broken):
        done = run_elsewhere("plugins", "--json", PYTHONPATH=broken)
        assert (done.status, done.err) == (0, "")
        found = {(entry["kind"], entry["name"]): entry for entry in json.loads(done.out)}
        assert {key for key, entry in found.items() if "error" in entry} == set(BROKEN)
        for key, words in BROKEN.items():
            assert words in found[key]["error"]
            assert any(one["package"] == "house-plugins" for one in found[key]["origin"])
        assert len(found[("layer", "membrane")]["origin"]) == 2
        assert {("layer", "fluid"), ("layer", "water"), ("effect", "skin"), ("reader", "csv")} <= set(found)

    def test_in_the_table_it_is_red_and_explained(self, broken):
        done = run_elsewhere("plugins", PYTHONPATH=broken)
        assert (done.status, done.err) == (0, "")
        assert re.search(r"^layer +raising +house-plugins 1.2 +house_raising:Water +broken", done.out, re.MULTILINE)
        assert "broken: layer 'leaving' of house_leaving:Water (package house-plugins 1.2) does not load" in done.out

    def test_in_the_lists_of_layers_and_effects(self, broken):
        for command, key in (("layers", "type"), ("effects", "name")):
            done = run_elsewhere(command, "--json", PYTHONPATH=broken)
            assert done.status == 0
            found = {entry[key]: entry.get("error", entry.get("problem")) for entry in json.loads(done.out)}
            kind = command.removesuffix("s")
            for (of, name), words in BROKEN.items():
                if of == kind:
                    assert words in found[name]
            assert found["fluid" if kind == "layer" else "skin"] is None


class TestUseOfBroken:
    def test_by_name_it_is_an_error(self, broken, tmp_path):
        file = tmp_path / "stack.yaml"
        file.write_text("layers:\n  - {type: raising, thickness: 1 mm}\n")
        done = run_elsewhere("simulate", file, "--out", tmp_path / "out", PYTHONPATH=broken)
        assert_refused(done, f"{file}:2:5: layers.0: layer 'raising' of house_raising:Water", "no licence")
        assert not (tmp_path / "out").exists()

    def test_what_does_not_use_it_knows_nothing_of_it(self, broken, tmp_path):
        file = tmp_path / "stack.yaml"
        file.write_text(STACK)
        done = run_elsewhere("simulate", file, "--no-figures", "--out", tmp_path / "out", PYTHONPATH=broken)
        assert (done.status, done.err) == (0, "")

    def test_what_goes_through_all_warns_of_each_once(self, broken, tmp_path):
        """A library of materials asks all layer types for their fields."""
        file = tmp_path / "stack.yaml"
        file.write_text(
            "layers:\n  - {material: melamine_foam, thickness: 1 cm}\n  - {material: steel, thickness: 1 mm}\n"
        )
        done = run_elsewhere("check", file, PYTHONPATH=broken)
        lines = done.err.splitlines()
        layers = [name for kind, name in BROKEN if kind == "layer"]
        assert len([line for line in lines if line.startswith("warning: left out: layer")]) == len(layers)
        assert "warning: left out: layer 'raising' of house_raising:Water (package house-plugins 1.2)" in done.err

    def test_a_diagnosis_with_all_effects_goes_on(self, broken, tmp_path):
        done = run_elsewhere("diagnose", EXAMPLES / "foam_tube", "--no-figures", "--out", tmp_path / "out",
                             *(f"--without={name}" for name in SLOW), PYTHONPATH=broken)  # fmt: skip
        assert done.status in (0, 1)
        left_out = [line for line in done.err.splitlines() if "left out" in line]
        assert [line.partition(" of ")[0] for line in left_out] == [
            "warning: left out: effect 'damp'", "warning: left out: effect 'mute'",
        ]  # fmt: skip
        assert (tmp_path / "out" / "diagnosis.json").is_file()

    def test_a_diagnosis_that_names_it_is_refused(self, broken, tmp_path):
        text = (EXAMPLES / "foam_tube" / "fit.yaml").read_text()
        folder = tmp_path / "tube"
        folder.mkdir()
        for file in (EXAMPLES / "foam_tube").iterdir():
            (folder / file.name).write_bytes(file.read_bytes())
        effects = re.sub(r"^effects:.*\n", "", text, flags=re.MULTILINE) + "\neffects: [damp]\n"
        (folder / "fit.yaml").write_text(effects)
        done = run_elsewhere("diagnose", folder, "--out", tmp_path / "out", PYTHONPATH=broken)
        assert done.status == 2
        assert "effects.0: effect 'damp' of house_raising:Damp (package house-plugins 1.2) does not load" in done.err
        assert "Traceback" not in done.err
        assert not (tmp_path / "out").exists()


class TestCommands:
    def test_runs_with_its_options_and_with_plugin_files(self, broken, tmp_path):
        (tmp_path / "brine.py").write_text(LAYER.replace("water", "brine"))
        done = run_elsewhere("greet", "Anna", "--times", 2, "--plugin", tmp_path / "brine.py", PYTHONPATH=broken)
        assert done == (0, "hello hello Anna, True\n", "")
        assert run_elsewhere("greet", "Anna", PYTHONPATH=broken).out == "hello Anna, False\n"
        assert "Example: multilayer greet Anna" in run_elsewhere("greet", "--help", PYTHONPATH=broken).out
        assert "--times" in run_elsewhere("greet", "Anna", "--times", "two", PYTHONPATH=broken).err

    def test_help_lists_those_that_work_and_tells_of_the_others(self, broken):
        done = run_elsewhere("--help", PYTHONPATH=broken)
        assert done.status == 0
        assert "│ greet " in done.out.partition("Commands of plugins")[2]
        assert done.out.count("│ fit ") == 1
        names = sorted(name for kind, name in BROKEN if kind == "command")
        told = [line.partition(" of ")[0] for line in done.err.splitlines()]
        assert told == [f"warning: left out: command '{name}'" for name in names]

    @pytest.mark.parametrize("name", ["crash", "five", "unmade", "bare"])
    def test_by_name_it_is_an_error(self, broken, name):
        done = run_elsewhere(name, "--help", PYTHONPATH=broken)
        assert done.status == 2
        assert "Traceback" not in done.err
        assert f"command '{name}' of house_" in done.err
        assert BROKEN["command", name] in done.err

    @pytest.mark.parametrize("arguments", [("--version",), ("layers", "--json"), ("fit", "--help")])
    def test_built_in_commands_know_nothing_of_it(self, broken, arguments):
        done = run_elsewhere(*arguments, PYTHONPATH=broken)
        assert done.status == 0
        assert "Greet" not in done.out
        assert not Path(broken, "house_commands.imported").exists()

    def test_completion_imports_only_what_it_offers(self, broken):
        def complete(line):
            words = {"COMP_WORDS": f"multilayer {line}", "COMP_CWORD": str(len(line.split(" ")))}
            return run_elsewhere(_MULTILAYER_COMPLETE="complete_bash", PYTHONPATH=broken, **words)

        assert complete("laye") == (0, "layers\n", "")
        assert not Path(broken, "house_commands.imported").exists()
        assert complete("gree") == (0, "greet\n", "")
        assert complete("fiv") == (0, "\n", "")  # broken: nothing is offered, nor told

    def test_of_a_file(self, tmp_path):
        file = tmp_path / "greeting.py"
        file.write_text(COMMAND.partition("def unmade")[0])
        (tmp_path / "brine.py").write_text(LAYER.replace("water", "brine"))
        done = run("--plugin", file, "greet", "Anna", "--plugin", tmp_path / "brine.py")
        assert (done.status, done.out) == (0, "hello Anna, True\n")
        assert run("--plugin", file, "greet", "Anna").out == "hello Anna, False\n"
        assert "No such command 'greet'." in run("greet", "Anna").err  # nothing of it stays

    def test_a_name_of_ours_is_refused_in_a_file(self, tmp_path):
        (tmp_path / "fitting.py").write_text("def command_shape_factor(): ...\n")
        done = run("--plugin", tmp_path / "fitting.py", "layers")
        assert_refused(
            done, f"{tmp_path / 'fitting.py'}: command 'shape-factor' of", "a built-in command has this name"
        )

    def test_the_nearest_name(self, broken):
        assert "No such command 'great'. Did you mean 'greet'?" in run_elsewhere("great", PYTHONPATH=broken).err
        assert "No such command 'shapefactor'. Did you mean 'shape-factor'?" in run("shapefactor").err

    def test_names_of_ours(self):
        assert set(get_command(app).commands) == BUILT_IN

    def test_packages_of_this_project(self):
        """The table by which a missing command is told agrees with what the packages say of themselves."""
        brought = {}
        for file in (*ROOT.glob("plugins/*/pyproject.toml"), *ROOT.glob("*/pyproject.toml")):
            project = tomllib.loads(file.read_text())["project"]
            for name in project.get("entry-points", {}).get("multilayer.commands", {}):
                brought[name] = (project["name"], str(file.parent.relative_to(ROOT)))
        assert brought == OF_THIS_PROJECT

    def test_a_package_that_is_not_installed(self, monkeypatch):
        monkeypatch.setattr("multilayer.plugins.commands.COMMANDS", Registry("multilayer.no_commands", "command"))
        done = run("preload", "campaign")
        assert_refused(done, "'preload' is a command of the package multilayer-campaigns, which is not installed;",
                       "python -m pip install ./plugins/multilayer-campaigns")  # fmt: skip
        assert "No such command 'prelod'. Did you mean 'preload'?" in run("prelod").err


@pytest.fixture
def water(tmp_path):
    """Give a plugin file and a simulation that needs it."""
    (tmp_path / "my water.py").write_text(LAYER)
    (tmp_path / "stack.yaml").write_text(STACK)
    return tmp_path / "my water.py", tmp_path / "stack.yaml"


class TestFile:
    @pytest.mark.parametrize("before", [True, False])
    def test_before_the_command_and_after(self, water, tmp_path, before):
        plugin, file = water
        command = ("simulate", file, "--no-figures", "--out", tmp_path / "out")
        option = ("--plugin", plugin)
        done = run(*option, *command) if before else run(*command, *option)
        assert (done.status, done.err) == (0, "")
        assert_refused(run(*command), "there is no layer type 'water'")  # nothing of it stays

    def test_with_other_processes(self, water, tmp_path):
        plugin, file = water
        file.write_text(STACK.replace("water,", "water, name: sea,") + "sweep: {layers.sea.thickness: [1 cm, 2 cm]}\n")
        here, there = (
            run("simulate", file, "--plugin", plugin, "--no-figures", "--out", tmp_path / f"out{jobs}", "--jobs", jobs)
            for jobs in (1, 2)
        )
        assert (here.status, here.err) == (there.status, there.err) == (0, "")
        one, two = (tmp_path / f"out{jobs}" / "simulation.csv" for jobs in (1, 2))
        assert one.read_text() == two.read_text()

    def test_in_the_lists(self, water, tmp_path):
        (tmp_path / "damp.py").write_text(EFFECT)
        assert "\nwater  " in run("layers", "--plugin", water[0]).out
        assert "\ndamp " in run("effects", "--plugin", tmp_path / "damp.py").out
        done = run("--plugin", water[0], "plugins", "--plugin", tmp_path / "damp.py", "--json")
        origins = {(one["kind"], one["name"]): one["origin"] for one in json.loads(done.out)}
        assert origins[("layer", "water")][0]["value"] == str(water[0])
        assert origins[("effect", "damp")][0]["value"] == str(tmp_path / "damp.py")

    def test_a_reader_and_a_law(self, tmp_path):
        (tmp_path / "both.py").write_text(
            "from typing import Literal\nfrom multilayer.signals.recording import Waveforms\n"
            "from multilayer.media.laws import Constant\n"
            "class Stiff(Constant):\n    law: Literal['stiff'] = 'stiff'\n"
            "def read_dat(path) -> Waveforms:\n    return None\n"
            "def read_help() -> str:\n    return ''\n"
        )
        found = json.loads(run("plugins", "--json", "--plugin", tmp_path / "both.py").out)
        ours = [(one["kind"], one["name"]) for one in found if str(tmp_path) in one["origin"][0]["value"]]
        assert ours == [("law", "stiff"), ("reader", "dat")]

    def test_places_of_all_kinds(self, tmp_path):
        (tmp_path / "places.py").write_text(PLACE)
        found = json.loads(run("plugins", "--json", "--plugin", tmp_path / "places.py").out)
        ours = {(one["kind"], one["name"]) for one in found if str(tmp_path) in one["origin"][0]["value"]}
        assert ours == {("place", "housing"), ("place of a tube", "front"), ("place of a construction", "meter")}
        assert {("place", "top_plate"), ("place of a tube", "behind"), ("place of a construction", "cavity")} <= {
            (one["kind"], one["name"]) for one in found
        }
        assert "housing" not in PLACES
        with plugin_files([tmp_path / "places.py"]):
            for known, name in ((PLACES, "housing"), (TUBE_PLACES, "front"), (LEVEL_PLACES, "meter")):
                check_place(known[name])

    def test_an_alias_is_no_second_definition(self, water, tmp_path):
        water[0].write_text(f"{LAYER}\nOldWater = Water\n")
        assert "\nwater  " in run("layers", "--plugin", water[0]).out

    def test_it_stays_as_long_as_somebody_uses_it(self, water):
        with plugin_files([water[0]]):
            kind = LAYERS["water"]
            with plugin_files([water[0]]):
                assert LAYERS["water"] is kind
            assert LAYERS["water"] is kind
        assert "water" not in LAYERS

    @pytest.mark.parametrize("future", ["", "from __future__ import annotations\n"])
    @pytest.mark.parametrize(
        "returned",
        ["Waveforms | Channels", "typing.Union[Waveforms, Channels]", "'Waveforms | Channels'", "channels.Channels"],
    )
    def test_what_a_reader_is_annotated_to_return(self, tmp_path, returned, future):
        (tmp_path / "dat.py").write_text(
            f"{future}import typing\nfrom multilayer.signals import channels\n"
            "from multilayer.signals.channels import Channels\nfrom multilayer.signals.recording import Waveforms\n"
            f"def read_dat(path) -> {returned}: ...\n"
        )
        found = json.loads(run("plugins", "--json", "--plugin", tmp_path / "dat.py").out)
        assert ("reader", "dat") in [(one["kind"], one["name"]) for one in found]

    def test_annotations_are_what_the_file_says(self, tmp_path):
        (tmp_path / "typed.py").write_text(f"def plain(x: int): ...\nassert plain.__annotations__['x'] is int\n{LAYER}")
        assert run("layers", "water", "--plugin", tmp_path / "typed.py").status == 0

    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ("def read_DAQ(path) -> 'Waveforms': ...\n", ": reader 'DAQ' of"),
            ("x = 1\n", ": registers nothing: it defines no layer"),
            ("\n1/0\n", ":2: does not load: ZeroDivisionError: division by zero"),
            ("x = 1\ndef broken(:\n", ":2: does not load: SyntaxError"),
            ("import no_such_thing\n", ":1: does not load: ModuleNotFoundError"),
            ("raise SystemExit(0)\n", ":1: does not load: SystemExit"),
            (LAYER.replace("water", "fluid"), ": layer 'fluid' is defined twice, by multilayer.layers.fluid:Fluid"),
            ("from multilayer.layers.fluid import Fluid\n", ": registers nothing"),
        ],
    )
    def test_a_file_that_cannot_be_used(self, water, tmp_path, text, words):
        bad = tmp_path / "bad.py"
        bad.write_text(text)
        done = run("simulate", water[1], "--plugin", water[0], "--plugin", bad, "--out", tmp_path / "out")
        assert_refused(done, f"{bad}{words}")
        assert not (tmp_path / "out").exists()
        assert "water" not in LAYERS

    def test_half_of_a_file_does_not_stay(self, tmp_path):
        (tmp_path / "half.py").write_text(LAYER + LAYER.replace("Water", "Other").replace("water", "fluid"))
        assert_refused(run("layers", "--plugin", tmp_path / "half.py"), "layer 'fluid' is defined twice")
        assert "water" not in LAYERS

    @pytest.mark.parametrize(
        ("name", "words"), [("gone.py", "there is no such file"), ("stack.yaml", "is no Python file"), (".", "no such")]
    )
    def test_a_file_that_is_none(self, water, tmp_path, name, words):
        assert_refused(run("layers", "--plugin", tmp_path / name), str((tmp_path / name).resolve()), words)

    def test_two_files_of_one_name(self, water, tmp_path):
        (tmp_path / "other.py").write_text(LAYER)
        done = run("layers", "--plugin", water[0], "--plugin", tmp_path / "other.py")
        assert_refused(done, "layer 'water' is defined twice", str(water[0]), str(tmp_path / "other.py"))

    def test_one_file_twice_is_one(self, water):
        assert run("--plugin", water[0], "layers", "--plugin", water[0], "--plugin", water[0]).status == 0


class TestWhatIsReturned:
    """Of a plugin that returns something else than it should, the plugin is told."""

    def test_a_layer(self, tmp_path):
        plugin, file = tmp_path / "still.py", tmp_path / "stack.yaml"
        plugin.write_text(f"{LAYER}\n    def faces(self, wave):\n        super().faces(wave)\n")
        file.write_text(STACK)
        done = run("simulate", file, "--plugin", plugin, "--out", tmp_path / "out")
        what = "what its 'faces' returns is of type NoneType, and must be multilayer.matrix.faces.Faces"
        assert_refused(done, f"layer type 'water' of {plugin} is at fault, not the stack: {what}")
        assert not (tmp_path / "out").exists()

    @pytest.mark.parametrize(
        ("faces", "words"),
        [
            ("fluid_faces(wave, self.thickness, np.ones(7), 1e5)",
             "arrays of its 'faces' do not go together (operands could not be broadcast together with shapes (3,) (7,) "
             "), and must broadcast to (3,)"),
            ("fluid_faces(wave, self.thickness, np.ones((7, 1)), 1e5)",
             "matrices of its 'faces' have the shape (7, 3) over frequencies and angles, and must have (3,)"),
            ("Faces(FLUID, np.ones((1, 2, 3)), np.ones((2, 2, 3)))",
             "the matrix 'front' of its 'faces' is of shape (1, 2, 3), and must be an array of shape (2, 2, 3): (2, 2) "
             "of the family 'fluid', then frequencies and angles"),
            ("Faces(FLUID, np.ones((2, 2, 3)), [[1, 2], [3, 4]])", "the matrix 'back' of its 'faces' is of type list"),
        ],
    )  # fmt: skip
    @pytest.mark.parametrize("name", ["", "sea"])
    def test_arrays_of_a_layer(self, tmp_path, faces, words, name):
        plugin, file = tmp_path / "still.py", tmp_path / "stack.yaml"
        plugin.write_text(f"{FACES}{LAYER}\n    def faces(self, wave):\n        return {faces}\n")
        file.write_text(STACK.replace("water,", f"water, name: {name},") if name else STACK)
        done = run("simulate", file, "--plugin", plugin, "--out", tmp_path / "out")
        named = f"layer {name}: " if name else ""
        assert_refused(done, f"{file}: {named}layer type 'water' of {plugin} is at fault, not the stack: {words}")

    def test_a_layer_whose_numbers_are_not_finite(self, tmp_path):
        plugin, file = tmp_path / "still.py", tmp_path / "stack.yaml"
        plugin.write_text(
            f"{FACES}{LAYER}\n    def faces(self, wave):\n"
            "        return fluid_faces(wave, self.thickness, np.where(wave.frequency > 150, np.nan, 1.2), 1e5)\n"
        )
        file.write_text(STACK.replace("layers:\n", "layers:\n  - {type: fluid, thickness: 1 cm}\n"))
        done = run("simulate", file, "--plugin", plugin, "--out", tmp_path / "out")
        assert_refused(done, "the stack has no finite response here: layer 1 gives numbers that are not finite",
                       f"the formulae of its type 'water' ({plugin}) are wrong (at 200 Hz)")  # fmt: skip

    @pytest.mark.parametrize(
        ("returned", "words"),
        [
            ("None", "what it returns is of type NoneType, and must be Waveforms, Channels, Spectra or a Table"),
            ("[[0.0], [1.0]]", "what it returns is of type list"),
            ("Waveforms([[0, 1]], [[0, 1]], 100)", "'base' is of type list, and must be a NumPy array of real numbers"),
            ("Waveforms(np.ones((1, 3)), np.ones(3))",
             "'top' is an array of float64 of shape (3,), and must be a NumPy array of real numbers of shape (repeats, "
             "samples)"),
            ("Waveforms(np.ones((1, 3)), np.array([['a']]))", "'top' is an array of <U1 of shape (1, 1)"),
            ("Channels(path, (Channel('force', [1.0]),))", "'force' is of type list, and must be a NumPy array of real "
             "numbers of shape (samples,)"),
        ],
    )  # fmt: skip
    def test_a_reader(self, tmp_path, returned, words):
        plugin, file = tmp_path / "daq.py", tmp_path / "burst.daq"
        plugin.write_text(
            "import numpy as np\nfrom multilayer.signals.channels import Channel, Channels\n"
            "from multilayer.signals.recording import Waveforms\n"
            f"def read_daq(path) -> Waveforms:\n    return {returned}\n"
        )
        file.touch()
        told = f"the reader 'daq' of {plugin} is at fault, not the file: {words}"
        assert_refused(run("import", file, "--plugin", plugin, "--out", tmp_path / "out"), told)
        with plugin_files([plugin]):
            for read in (read_waveforms, read_channels, read_spectra):
                with pytest.raises(InputError) as caught:
                    read(file)
                assert told in str(caught.value)


MARKER = "import pathlib; pathlib.Path('ran').touch()"


@pytest.mark.parametrize(
    "text",
    [
        f'layers: !!python/object/apply:exec ["{MARKER}"]\n',
        "layers:\n  - !!python/object/apply:eval [\"__import__('os').system('touch ran')\"]\n",
        "layers:\n  - {type: !!python/name:os.system , thickness: 1 mm}\n",
        "layers:\n  - {type: os.system, thickness: touch ran}\n",
        "layers:\n  - {type: 'evil:Water', thickness: 1 mm}\n",
        "layers:\n  - {type: evil, thickness: 1 mm}\n",
        "layers:\n  - {type: evil.py, thickness: 1 mm}\n",
        "layers:\n  - {type: ./evil.py, thickness: 1 mm}\n",
        "plugin: evil.py\nlayers:\n  - {type: fluid, thickness: 1 mm}\n",
        "plugins: [evil.py]\nlayers:\n  - {type: fluid, thickness: 1 mm}\n",
        "library: evil.py\nlayers:\n  - {material: evil, thickness: 1 mm}\n",
        "layers:\n  - {type: elastic_solid, thickness: 1 mm, density: 1, poisson_ratio: 0,"
        " young_modulus: {law: evil.Law}}\n",
        "layers:\n  - {type: fluid, thickness: \"__import__('os').system('touch ran')\"}\n",
    ],
)
def test_a_file_of_data_never_makes_code_run(tmp_path, text):
    (tmp_path / "evil.py").write_text(f"{MARKER}\n{LAYER}")
    (tmp_path / "stack.yaml").write_text(text)
    for command in ("check", "simulate"):
        done = run(command, "stack.yaml", cwd=tmp_path)
        assert done.status == 2
        assert "stack.yaml:" in done.err or "evil.py:" in done.err
        assert "Traceback" not in done.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["evil.py", "stack.yaml"]
