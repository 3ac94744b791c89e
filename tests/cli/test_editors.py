"""What editors and other programs use: check of any file, schemas, JSON of every command, completion of names."""

import json
import re
import shutil

import pytest
from typer.main import get_command

from multilayer.cli import app, completion
from multilayer.cli.plugin_commands import OF_THIS_PROJECT
from multilayer.kinds import KINDS
from multilayer.media.laws import LAWS
from multilayer.simulation.quantities import QUANTITIES
from tests.cli.campaigns import FILE, RATE, write_calibration
from tests.cli.command import run
from tests.cli.test_import import IN_V, IN_VOLTS, VOLTS
from tests.cli.test_optimise import FILE as DESIGN
from tests.cli.test_with import SAVED
from tests.examples.test_examples import EXAMPLES
from tests.recorders import write_csv

STACK = EXAMPLES / "three_layers.yaml"
LIBRARY = "version: 1\nmaterials:\n  ours: {source: a book, type: fluid}\n"
TUBE = """\
version: 1
nominal: foam.yaml
measurements: [{kind: reflection, file: tube.csv, noise: {absolute: 0.01}}]
unknowns: {layers.foam.porosity: {uniform: [0.9, 1]}}
effects: [facing]
"""


def no_constant(name):
    raise AssertionError(f"{name} is no JSON")


def parsed(done):
    """Return what was printed, which is JSON and nothing else."""
    return json.loads(done.out, parse_constant=no_constant)


class TestCheck:
    @pytest.fixture
    def files(self, campaign, tmp_path):
        tube = shutil.copytree(EXAMPLES / "foam_tube", tmp_path / "tube")
        (tube / "why.yaml").write_text(TUBE)
        (tmp_path / "library.yaml").write_text(LIBRARY)
        (tmp_path / "known.yaml").write_text(json.dumps(SAVED))
        (tmp_path / "fit.yaml").write_text(f"version: 1\ncampaign: {campaign.name}\n")
        return {
            "stack": STACK,
            "simulation": EXAMPLES / "double_wall.yaml",
            "optimisation": EXAMPLES / "best_absorber.yaml",
            "campaign": campaign,
            "calibration": write_calibration(tmp_path / "calibration", 1.0, 0.0),
            "fit": tmp_path / "fit.yaml",
            "stack-fit": tube,
            "diagnose": tube / "why.yaml",
            "rig": EXAMPLES / "virtual_rig.yaml",
            "tube": EXAMPLES / "raw_tube",
            "library": tmp_path / "library.yaml",
            "rig-law": tmp_path / "known.yaml",
        }

    def test_every_kind_is_told(self, files):
        assert set(files) == set(KINDS)
        done = run("check", *files.values(), "--json")
        assert (done.status, done.err) == (0, "")
        found = parsed(done)
        assert [one["kind"] for one in found] == list(files)
        assert [one["file"] for one in found] == [str(file) for file in files.values()]
        assert all(one["sound"] and not one["problems"] for one in found)
        told = run("check", *files.values()).out.splitlines()
        articles = ["an" if one["kind"] == "optimisation" else "a" for one in found]
        texts = [f"{article} {one['summary']}" for article, one in zip(articles, found, strict=True)]
        assert told == [f"{one['file']}: {text} without mistakes" for one, text in zip(found, texts, strict=True)]

    def test_mistakes_as_json(self, files, tmp_path):
        wrong = tmp_path / "wrong.yaml"
        wrong.write_text("version: 1\nlayers:\n  - {type: fluid, thickness: -1 mm, colour: red}\n")
        (files["campaign"] / FILE.format(400)).unlink()
        done = run("check", wrong, files["campaign"], STACK, tmp_path / "gone", "--json")
        assert (done.status, done.err) == (2, "")
        found = parsed(done)
        assert [(one["kind"], one["sound"]) for one in found] == [
            ("stack", False), ("campaign", False), ("stack", True), (None, False),
        ]  # fmt: skip
        assert [(p["line"], p["path"]) for p in found[0]["problems"]] == [
            (3, "layers.0.thickness"),
            (3, "layers.0.colour"),
        ]
        assert set(found[0]["problems"][0]) == {"message", "path", "file", "line", "column"}
        assert "there is no file" in found[1]["problems"][0]["message"]

    def test_what_it_cannot_tell(self, tmp_path):
        (tmp_path / "notes.txt").write_text("foam")
        (tmp_path / "list.yaml").write_text("- 1\n")
        done = run("check", tmp_path / "notes.txt", tmp_path, tmp_path / "list.yaml")
        assert (done.status, done.out) == (2, "")
        first, second, third = done.err.splitlines()
        assert "this is no YAML file" in first
        assert "holds none of tube.yaml, fit.yaml, campaign.yaml" in second
        assert "nothing in this file tells what it is" in third

    def test_names_of_files_do_not_matter(self, tmp_path):
        stack = {"kind": "stack", "layers": [{"type": "fluid", "thickness": "10 mm"}]}
        names = ("STACK.YAML", "stack.json", "stack.txt", "stack")
        for name in names:
            (tmp_path / name).write_text(json.dumps(stack))
        done = run("check", *names, cwd=tmp_path)
        assert (done.status, done.out.splitlines()) == (0, [f"{name}: a stack without mistakes" for name in names])
        (tmp_path / "broken.json").write_text('{"kind": "stack", "layers": [}')
        (tmp_path / "broken.csv").write_text("a: [b, c\n1,2")
        done = run("check", "broken.json", "broken.csv", "none.txt", cwd=tmp_path)
        assert (done.status, done.out) == (2, "")
        told = done.err.splitlines()
        assert told[0].startswith("broken.json:1:30: ")
        assert told[1].startswith("broken.csv: this is no YAML file")
        assert told[2] == "none.txt: there is no such file"

    def test_a_stack_file_with_keys_of_a_simulation_is_read_as_simulate_does(self, tmp_path):
        text = "kind: stack\nversion: 1\ntermination: rigid\nlayers: [{type: fluid, thickness: 10 mm}]\n"
        wrong, right = tmp_path / "wrong.yaml", tmp_path / "right.yaml"
        wrong.write_text(f"{text}frequency: banana\nexcitation: 7\n")
        right.write_text(f"{text}frequency: [100 Hz, 200 Hz]\n")
        checked, simulated = run("check", wrong), run("simulate", wrong)
        assert (checked.status, checked.err) == (simulated.status, simulated.err)
        assert f"{wrong}:5:12: frequency: " in checked.err
        assert run("check", right).out == f"{right}: a simulation of one case without mistakes\n"

    def test_values_of_a_library(self, tmp_path):
        file = tmp_path / "library.yaml"
        file.write_text("kind: library\nmaterials:\n  bad: {type: fluid, density: 12 s}\n")
        done = run("check", file)
        assert done.status == 2
        assert f"{file}:3:31: materials.bad.density: '12 s' has the wrong unit" in done.err


class TestSchema:
    def test_prints_one(self):
        done = run("schema", "stack-fit")
        assert (done.status, done.err) == (0, "")
        assert parsed(done)["title"] == "multilayer: fit of stacks"

    def test_lists_kinds(self):
        assert [line.split()[0] for line in run("schema").out.splitlines()] == list(KINDS)
        assert [one["kind"] for one in parsed(run("schema", "--json"))] == list(KINDS)

    def test_writes_all(self, tmp_path):
        done = run("schema", "--out", tmp_path / "schemas")
        assert (done.status, done.err) == (0, "")
        assert {path.name for path in (tmp_path / "schemas").iterdir()} == {f"{name}.json" for name in KINDS}
        run("schema", "rig", "--out", tmp_path / "one")
        assert [path.name for path in (tmp_path / "one").iterdir()] == ["rig.json"]

    def test_refuses_others(self):
        done = run("schema", "stacks")
        assert (done.status, done.out) == (2, "")
        assert "did you mean 'stack'?" in done.err


COMMANDS = get_command(app).commands
MEASURED = "frequency_hz,absorption\n500,0.4\n1000,0.85\n"
DOCUMENTED = re.compile(r"^\| `([^|]+) \| ([^|]*?`([^`|]+)`[^|]*)\|$", re.MULTILINE)


def documented():
    """Return the keys that docs/editors.md promises, by command as it names it."""
    text = (EXAMPLES.parent / "docs" / "editors.md").read_text().partition("## JSON")[2].partition("## Reports")[0]
    return {name.replace("`", "").strip(): set(keys.split()) for name, _, keys in DOCUMENTED.findall(text)}


KEYS = documented()
PAGES = {"explore"}  # what they show is a page, not a result
TRIED_ELSEWHERE = {"diagnose", "preload", "anisotropy", "blind-check"}  # they take long


class TestJson:
    def test_every_command_has_it(self):
        without = [name for name, command in COMMANDS.items() if "--json" not in _options(command)]
        assert {*without} == PAGES

    def test_every_command_is_documented(self):
        assert {name.split()[0] for name in KEYS} == {*COMMANDS, *OF_THIS_PROJECT} - PAGES

    @pytest.mark.parametrize("name", [name for name in KEYS if name not in TRIED_ELSEWHERE])
    def test_keys(self, name, sound_campaign, tmp_path):
        measured = tmp_path / "measured.csv"
        measured.write_text(MEASURED)
        second = shutil.copytree(sound_campaign, tmp_path / "second")
        file = tmp_path / "rig.yaml"
        file.write_text((EXAMPLES / "virtual_rig.yaml").read_text().replace("1000 Hz, step", "400 Hz, step"))
        design = tmp_path / "design.yaml"
        design.write_text(DESIGN)
        recording = write_csv(tmp_path / "run.csv", IN_V, RATE, VOLTS)
        out = ("--out", tmp_path / "out")
        drawn = (*out, "--no-figures")
        arguments = {
            "simulate": ("simulate", EXAMPLES / "foam_absorption.yaml", *drawn),
            "optimise": ("optimise", design, *drawn),
            "compare": ("compare", EXAMPLES / "foam_absorption.yaml", measured, *drawn),
            "fit": ("fit", sound_campaign, *drawn),
            "fit --joint": ("fit", sound_campaign, "--joint", "--law", "loss_factor", *drawn),
            "fit of several": ("fit", sound_campaign, second, *drawn),
            "fit of stacks": ("fit", EXAMPLES / "foam_tube", *drawn),
            "methods": ("methods", sound_campaign, *drawn),
            "methods without a campaign": ("methods",),
            "tube": ("tube", EXAMPLES / "raw_tube", *drawn),
            "import": ("import", recording, *IN_VOLTS, "--like", sound_campaign, *out),
            "export": ("export", STACK, "--as", "surface_impedance", "--out", tmp_path / "z.csv"),
            "rig": ("rig", file, *out),
            "effects": ("effects",),
            "layers": ("layers",),
            "materials": ("materials",),
            "examples": ("examples",),
            "plugins": ("plugins",),
            "check": ("check", STACK),
            "shape-factor": ("shape-factor", "--poisson-ratio", "0.3", "--shape", "1"),
            "schema": ("schema",),
        }
        done = run(*arguments[name], "--json")
        assert done.status in (0, 1)
        assert all(line.startswith(("warning: ", "remark: ")) for line in done.err.splitlines())
        found = parsed(done)
        for entry in found if isinstance(found, list) else [found]:
            assert KEYS[name] <= set(entry)

    def test_of_a_fit_that_was_done_before(self, fitted, sound_campaign):
        done = run("fit", sound_campaign, "--out", fitted.folder, "--resume", "--json")
        assert done.status == 0
        assert parsed(done) == json.loads((fitted.folder / "fit.json").read_text())
        assert "nothing to do" in done.err


def _options(command):
    return {option for parameter in command.params for option in parameter.opts}


class TestCompletion:
    @pytest.mark.parametrize(
        ("line", "expected"),
        [
            ("diagnose --without sensor_m", {"sensor_mass", "sensor_mount"}),
            ("diagnose --law z", {"zener"}),
            ("fit --law fr", {"free_form", "fractional_zener"}),
            ("fit --method n", {"nelder-mead"}),
            ("fit --model f", {"finite"}),
            ("fit --posterior p", {"profile"}),
            ("schema st", {"stack", "stack-fit"}),
            ("compare --quantity a", {"absorption"}),
            ("methods --lateral h", {"held"}),
            ("layers poro", {"poroelastic"}),
        ],
    )
    def test_names(self, line, expected):
        words = f"multilayer {line}"
        environment = {
            "_MULTILAYER_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(len(words.split()) - 1),
        }  # fmt: skip
        done = run(**environment)
        assert set(done.out.split()) == expected

    def test_lists_are_whole(self):
        assert completion.laws("") == LAWS.names()
        assert completion.quantities("") == list(QUANTITIES)
