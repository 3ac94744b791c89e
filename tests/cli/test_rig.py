"""``multilayer rig``: what it writes, what it keeps to itself, how it ends, and what it refuses."""

import json
import os
import re

import numpy as np
import pytest

from multilayer.rig.bench import Bench
from multilayer.writing import disk
from tests.cli.campaigns import line_of
from tests.cli.command import run, run_elsewhere
from tests.rig.virtual import rod

LAW = "{law: fractional_zener, relaxed_modulus: 100 kPa, unrelaxed_modulus: 1 MPa, relaxation_time: 0.1 ms, order: 0.5}"
TEXT = """\
version: 1
rig: two-plate
seed: 7
specimen:
  density: 80
  young_modulus: LAW
frequencies: [300 Hz, 600 Hz]
configurations: {thicknesses: [12.5 mm, 25 mm], top_plates: [1 mm]}
repeats: 2
noise: {white: 0.004}
uncertainty: {channel_gain: 0.003, channel_delay: 1 us, thickness: 0.05 mm}
effects:
  - {effect: preload, stiffening: 2e-3}
""".replace("LAW", LAW)
SIGNALS = [f"h{h}mm-t1mm_{f}Hz.npz" for h in ("12.5", "25") for f in ("0300", "0600")]


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "rig.yaml"
    path.write_text(TEXT)
    return path


@pytest.fixture
def as_rod(monkeypatch):
    """Take a rod in place of the finite elements."""
    monkeypatch.setattr(Bench, "_transmissibility", rod)


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def edit(file, old, new):
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))


@pytest.mark.usefixtures("as_rod")
class TestWritten:
    def test_campaign_and_truth(self, file, tmp_path):
        done = run("rig", file, "--out", tmp_path / "out" / "foam")
        assert (done.status, done.err) == (0, "")
        folder, truth = tmp_path / "out" / "foam", tmp_path / "out" / "foam.truth.json"
        assert done.out.splitlines() == [
            f"written to {folder}: 4 bursts of 2 configurations",
            f"truth (preload): {truth}",
        ]
        signals = {f"signals/{name}" for name in SIGNALS}
        assert contents(folder).keys() == {"campaign.yaml", "manifest.json"} | signals
        assert {path.name for path in folder.parent.iterdir()} == {"foam", "foam.truth.json"}
        assert json.loads(truth.read_text())["parameters"] == {"stiffening": 2e-3}

    def test_other_commands_take_it(self, file, tmp_path):
        run("rig", file, "--out", tmp_path / "foam")
        done = run("check", tmp_path / "foam", file)
        assert (done.status, done.err) == (0, "")
        assert done.out.splitlines() == [
            f"{tmp_path / 'foam'}: a campaign of 4 bursts without mistakes",
            f"{file}: a virtual rig of 2 configurations without mistakes",
        ]
        fitted = run("fit", tmp_path / "foam", "--out", tmp_path / "fit", "--no-figures")
        assert (fitted.status, fitted.err) == (0, "")

    def test_campaign_says_nothing_of_effects(self, file, tmp_path):
        run("rig", file, "--out", tmp_path / "foam")
        text = (tmp_path / "foam" / "campaign.yaml").read_text()
        for word in ("preload", "stiffening", "effect", "seed", "zener", "truth", "virtual"):
            assert word not in text

    def test_quiet(self, file, tmp_path):
        done = run("rig", file, "--out", tmp_path / "foam", "--quiet-truth")
        assert (done.status, done.err) == (0, "")
        assert done.out == f"written to {tmp_path / 'foam'}: 4 bursts of 2 configurations\n"
        assert not (tmp_path / "foam.truth.json").exists()
        assert json.loads((tmp_path / ".truth" / "foam.truth.json").read_text())["effect"] == "preload"

    def test_a_hidden_folder_of_the_user_that_is_a_link(self, file, tmp_path):
        (tmp_path / "secure").mkdir()
        (tmp_path / ".truth").symlink_to("secure")
        for _ in range(2):
            done = run("rig", file, "--out", tmp_path / "foam", "--quiet-truth")
            assert (done.status, done.err) == (0, "")
        assert json.loads((tmp_path / "secure" / "foam.truth.json").read_text())["effect"] == "preload"

    def test_default_folder(self, file, tmp_path):
        done = run("rig", file, cwd=tmp_path)
        assert done.status == 0
        assert (tmp_path / "results" / "rig" / "campaign.yaml").is_file()
        assert (tmp_path / "results" / "rig.truth.json").is_file()

    def test_same_seed_same_bytes(self, file, tmp_path):
        for name, seed in (("a", ()), ("b", ("--seed", 7)), ("c", ("--seed", 8))):
            run("rig", file, "--out", tmp_path / name, *seed)
        a, b, c = (contents(tmp_path / name) for name in "abc")
        assert a == b
        assert [name for name in a if a[name] == c[name]] == ["campaign.yaml"]  # the manifest holds hashes
        assert (tmp_path / "a.truth.json").read_text() == (tmp_path / "b.truth.json").read_text()
        assert json.loads((tmp_path / "c.truth.json").read_text())["seed"] == 8

    def test_an_older_one_is_replaced(self, file, tmp_path):
        run("rig", file, "--out", tmp_path / "foam")
        (tmp_path / "foam" / "fit.yaml").write_text("version: 1\n")
        edit(file, "[300 Hz, 600 Hz]", "[400 Hz]")
        done = run("rig", file, "--out", tmp_path / "foam", "--quiet-truth")
        assert (done.status, done.err) == (0, "")
        assert sorted(path.name for path in (tmp_path / "foam" / "signals").iterdir()) == [
            "h12.5mm-t1mm_0400Hz.npz",
            "h25mm-t1mm_0400Hz.npz",
        ]
        assert (tmp_path / "foam" / "fit.yaml").read_text() == "version: 1\n"  # is the user's
        assert not (tmp_path / "foam.truth.json").exists()  # that of the campaign before
        assert {path.name for path in tmp_path.iterdir()} == {"rig.yaml", "foam", ".truth"}


def test_finite_elements_in_two_processes_make_the_same_bytes(file, tmp_path):
    for jobs in (1, 2):
        done = run_elsewhere("rig", file, "--out", tmp_path / str(jobs), "--jobs", jobs, OMP_NUM_THREADS="1")
        assert (done.status, done.err) == (0, "")
    assert contents(tmp_path / "1") == contents(tmp_path / "2")


def test_help():
    done = run("rig", "--help")
    assert (done.status, done.err) == (0, "")
    text = " ".join(re.sub(r"[│╭╰─╮╯]", " ", done.out).split())
    assert "Example: multilayer rig examples/virtual_rig.yaml --out results/virtual" in text
    for option in ("--out", "--quiet-truth", "--seed", "--jobs"):
        assert option in text


# what is replaced in the file by what, where it is told, and how
MISTAKES = {
    "effect": ("preload", "preloaded", "preloaded", "effects.0.effect: there is no effect 'preloaded'; did you mean"),
    "frequency": ("600 Hz", "13 kHz", "13 kHz", "frequencies.1: 13000 Hz is not below half of the sampling_rate"),
    "noise": ("0.004", "-1 %", "-1 %", "noise.white: -0.01 is not allowed: it must be at least 0"),
    "glue": (
        "preload, stiffening: 2e-3",
        "adhesive, thickness: 8 mm",
        "8 mm",
        "effects.0.thickness: 8 mm of glue at both faces are not thinner than the thinnest sample, 12.5 mm",
    ),
    "sensor": (
        "preload, stiffening: 2e-3",
        "sensor_mass, radius: 22 mm",
        "22 mm",
        "effects.0.radius: 22 mm puts the accelerometer off the plate of radius 22.5 mm",
    ),
    "range": (
        "white: 0.004",
        "full_scale: 2",
        "2}\nuncertainty",
        "noise.full_scale: the base channel reaches 11.5 m/s2 at 300 Hz in 'h12.5mm-t1mm', beyond this range of 2 m/s2",
    ),
    "too soft for a mesh": (
        LAW,
        "150+150j Pa",
        "{thicknesses",
        "configurations: configuration 'h12.5mm-t1mm': the mesh would need",
    ),
}


class TestRefused:
    @pytest.fixture(autouse=True)
    def nothing_written(self, tmp_path):
        yield
        assert {path.name for path in tmp_path.iterdir()} <= {"rig.yaml", "mine"}

    @pytest.mark.parametrize("case", MISTAKES)
    def test_mistake(self, file, tmp_path, case):
        old, new, at, words = MISTAKES[case]
        edit(file, old, new)
        done = run("rig", file, "--out", tmp_path / "foam")
        assert (done.status, done.out) == (2, "")
        assert f"{file}:{line_of(file, at)}: {words}" in done.err

    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            (("--jobs", 0), "--jobs: 0 is not allowed; it must be at least 1"),
            (("--seed", -1), "'--seed'"),
        ],
    )
    def test_options(self, file, tmp_path, arguments, words):
        done = run("rig", file, "--out", tmp_path / "foam", *arguments)
        assert done.status == 2
        assert words in re.sub(r"[\s│]+", " ", done.err)

    def test_no_file(self, tmp_path):
        done = run("rig", tmp_path / "gone.yaml", "--out", tmp_path / "foam")
        assert (done.status, done.out) == (2, "")
        assert f"{tmp_path / 'gone.yaml'}: there is no such file" in done.err

    def test_a_campaign_in_place_of_a_rig(self, file, sound_campaign, tmp_path):
        done = run("rig", sound_campaign / "campaign.yaml", "--out", tmp_path / "foam")
        assert "rig: 'shaker-two-plate' is not allowed; allowed: 'two-plate'" in done.err


@pytest.mark.usefixtures("as_rod")
class TestFolder:
    def refused(self, file, folder, reason):
        before = contents(folder) if folder.is_dir() else folder.read_bytes()
        done = run("rig", file, "--out", folder)
        assert (done.status, done.out) == (2, "")
        assert f"{folder}: cannot be written to ({reason}" in done.err
        assert "choose another folder with --out" in done.err
        assert before == (contents(folder) if folder.is_dir() else folder.read_bytes())

    def test_is_a_file(self, file, tmp_path):
        (tmp_path / "mine").write_text("mine")
        self.refused(file, tmp_path / "mine", f"{tmp_path / 'mine'} is a file")

    def test_holds_something_else(self, file, tmp_path):
        (tmp_path / "mine").mkdir()
        (tmp_path / "mine" / "letter.txt").write_text("mine")
        self.refused(file, tmp_path / "mine", "it holds other things than a campaign")

    def test_holds_a_measured_campaign(self, file, campaign):
        self.refused(file, campaign, "the campaign in it was not made by the virtual rig")

    def test_is_empty(self, file, tmp_path):
        (tmp_path / "mine").mkdir()
        assert run("rig", file, "--out", tmp_path / "mine").status == 0

    @pytest.mark.parametrize("n_written", [0, 1, 3, 6])
    def test_a_disk_that_fills_up_leaves_what_was_there(self, file, tmp_path, monkeypatch, n_written):
        folder = tmp_path / "foam"
        run("rig", file, "--out", folder)
        before, truth = contents(folder), (tmp_path / "foam.truth.json").read_bytes()
        right, calls = disk.write, []

        def full(path, data):
            calls.append(path)
            if len(calls) > n_written:
                raise OSError(28, os.strerror(28))
            return right(path, data)

        monkeypatch.setattr(disk, "write", full)
        done = run("rig", file, "--out", folder, "--seed", 8)
        assert done.status == 2
        assert "No space left on device" in done.err
        assert contents(folder) == before
        assert (tmp_path / "foam.truth.json").read_bytes() == truth
        assert {one.name for one in tmp_path.iterdir()} == {"rig.yaml", "foam", "foam.truth.json"}


@pytest.mark.usefixtures("as_rod")
def test_signals_hold_what_the_file_asks_for(file, tmp_path):
    run("rig", file, "--out", tmp_path / "foam")
    with np.load(tmp_path / "foam" / "signals" / SIGNALS[0]) as archive:
        assert sorted(archive.files) == ["base", "top"]
        assert archive["base"].shape == archive["top"].shape
        assert archive["base"].shape[0] == 2
