"""Input that cannot be used: told in words at its place, with what to do; and nothing is written."""

import os
import re

import numpy as np
import pytest

from tests.cli.campaigns import BURSTS, FILE, change_signals, edit, line_of, with_line, write_calibration
from tests.cli.command import run

CAMPAIGN, SIGNAL = "campaign.yaml", FILE.format(400)


def assert_refused(done, *parts):
    """Every part stands in the message, on one line of it; nothing else was printed."""
    assert done.status == 2, done
    assert done.out == ""
    assert "Traceback" not in done.err
    assert "bug" not in done.err
    flat = re.sub(r"[\s│]+", " ", done.err)  # usage errors stand in a box
    assert [part for part in parts if part not in flat] == []


def without_top(folder):
    with np.load(folder / SIGNAL) as data:
        np.savez(folder / SIGNAL, base=data["base"], bottom=data["top"])


def damaged(folder):
    """One byte in the middle of the archive is another."""
    content = bytearray((folder / SIGNAL).read_bytes())
    content[len(content) // 2] ^= 0xFF
    (folder / SIGNAL).write_bytes(content)


def signals(change, *bursts):
    def spoil(folder):
        for frequency in bursts or (400,):
            change_signals(folder, frequency, change)

    return spoil


def with_value(value, channel):
    def spoil(base, top):
        (base, top)[channel][1, 100] = value
        return base, top

    return spoil


def clipped(base, top):
    limit = 0.7 * np.abs(base).max()
    return np.clip(base, -limit, limit), top


def exchanged(base, top):
    return top, base


SIGNALS = {
    "missing": (
        lambda folder: (folder / SIGNAL).unlink(),
        ("configurations.0.bursts.1.file: there is no file", SIGNAL, "correct the name, or remove the burst"),
    ),
    "cut short": (
        lambda folder: (folder / SIGNAL).write_bytes((folder / SIGNAL).read_bytes()[:5000]),
        (f"{SIGNAL}: is no .npz archive, or one that is cut short; copy or export it again",),
    ),
    "empty": (
        lambda folder: (folder / SIGNAL).write_bytes(b""),
        (f"{SIGNAL}: is no .npz archive, or one that is cut short",),
    ),
    "damaged": (damaged, (f"{SIGNAL}: cannot be read as an .npz archive", "copy or export it again")),
    "no top": (without_top, (f"{SIGNAL}: has no array 'top'; it must hold 'base' and 'top', and holds: base, bottom",)),
    "lengths differ": (
        signals(lambda base, top: (base, top[:, :-1])),
        (f"{SIGNAL}: base has shape", "they must be recorded together"),
    ),
    "complex": (signals(lambda base, top: (base, 1j * top)), (f"{SIGNAL}: array 'top'", "must hold real numbers")),
    "NaN": (
        signals(with_value(np.nan, 1)),
        (f"{SIGNAL}: the top channel holds 1 values that are not finite", "export or measure"),
    ),
    "infinite": (signals(with_value(np.inf, 0)), (f"{SIGNAL}: the base channel holds 1 values that are not finite",)),
    "clipped": (
        signals(clipped),
        (f"{SIGNAL}: the base channel is clipped in 2 of 2 repeats", "lower the level or widen the input range"),
    ),
    "exchanged once": (
        signals(exchanged),
        (f"{SIGNAL}: base and top look exchanged", "in this burst; exchange the two channels"),
    ),
    "silent top": (
        signals(lambda base, top: (base, 0 * top)),
        (f"{SIGNAL}: the top channel is silent", "check accelerometer, cable and range"),
    ),
    "silent base": (signals(lambda base, top: (0 * base, top)), (f"{SIGNAL}: the base channel is silent",)),
    "noise only": (
        signals(lambda base, top: (base, 1e-3 * np.random.default_rng(0).standard_normal(top.shape))),
        (f"{SIGNAL}: the top channel is silent (no burst above its noise)",),
    ),
    "cut off": (
        signals(lambda base, top: (base[:, :200], top[:, :200])),
        (f"{SIGNAL}: the record lasts 0.0156 s, less than the burst of 0.025 s", "record longer"),
    ),
}

# what is replaced in campaign.yaml by what, the words that follow ``file:line:column:``, and where these stand
DESCRIPTIONS = {
    "exchanged everywhere": (
        signals(exchanged, *BURSTS),
        "name: h25mm",
        "configurations.0: base and top look exchanged: the top's energy arrives before the base's in 3 of 3 bursts",
    ),
    "sampling rate": (
        lambda folder: edit(folder, "12800", "25600"),
        "25600",
        "sampling_rate: all bursts appear at 2 times their stated frequency: is a sampling_rate of 25600 Hz right? "
        "12800 Hz would fit",
    ),
    "negative thickness": (
        lambda folder: edit(folder, "specimen_thickness: 25 mm", "specimen_thickness: -25 mm"),
        "-25 mm",
        "configurations.0.specimen_thickness: -0.025 is not allowed: it must be above 0",
    ),
    "Poisson's ratio": (
        lambda folder: edit(folder, "poisson_ratio: 0.3}", "poisson_ratio: 0.5}"),
        "0.5}",
        "specimen.poisson_ratio: 0.5 is not allowed: it must be below 0.5",
    ),
    "wrong unit": (
        lambda folder: edit(folder, "10 mm", "10 kg"),
        "10 kg",
        "base_plate.thickness: '10 kg' has the wrong unit: this is a quantity in m, as 0.05 or '50 mm'",
    ),
    "no configurations": (
        lambda folder: with_line(folder, r"configurations:\n(.*\n)*", "configurations: []\n"),
        "[]",
        "configurations: must not be empty",
    ),
    "no bursts": (
        lambda folder: with_line(folder, r"bursts:\n(.*\n)*", "bursts: []\n"),
        "[]",
        "configurations.0.bursts: must not be empty",
    ),
    "nothing under bursts": (
        lambda folder: with_line(folder, r"bursts:\n(.*\n)*", "bursts: # later\n"),
        " # later",
        "configurations.0.bursts: must be a list, not an empty value",
    ),
    "unknown field": (
        lambda folder: edit(folder, "specimen_radius", "specimen_radios"),
        "specimen_radios",
        "configurations.0.specimen_radios: there is no such field; did you mean 'specimen_radius'?",
    ),
    "missing field": (
        lambda folder: with_line(folder, r"    specimen_radius.*\n", ""),
        "name: h25mm",
        "configurations.0.specimen_radius: is missing; it is required",
    ),
    "twice the same key": (
        lambda folder: edit(folder, "rig:", "sampling_rate: 1\nrig:"),
        "sampling_rate: 12800",
        "sampling_rate: stands here a second time; it is in line 2 too",
    ),
    "twice the same burst": (
        lambda folder: edit(folder, "frequency: 600", "frequency: 400 Hz"),
        "400 Hz",
        "configurations.0.bursts.2.frequency: 400 Hz is there twice; each frequency of bursts must be another",
    ),
    "version": (
        lambda folder: edit(folder, "version: 1", "version: 2"),
        "2",
        "version: 2 is not allowed; allowed: 1",
    ),
    "beyond half the sampling rate": (
        lambda folder: edit(folder, "12800", "1000"),
        "600, file",
        "configurations.0.bursts.2.frequency: 600 Hz is not below half of the sampling_rate of 1000 Hz",
    ),
    "a path out of the folder": (
        lambda folder: edit(folder, "signals/0400.npz", "../0400.npz"),
        "../0400",
        "configurations.0.bursts.1.file: '../0400.npz' leads out of the campaign's folder; write a path relative to it",
    ),
    "no YAML": (
        lambda folder: edit(folder, "rig: shaker-two-plate", "rig: 'shaker-two-plate"),
        "'shaker",
        "this quote is not closed",
    ),
    "a tab": (
        lambda folder: edit(folder, "    specimen_radius", "\tspecimen_radius"),
        "\tspecimen",
        "a tab stands here; use spaces",
    ),
    "code": (
        lambda folder: edit(folder, "h25mm", "!!python/object/apply:os.getcwd []"),
        "!!python",
        "configurations.0.name: the tag '!!python/object/apply:os.getcwd' is not allowed: files hold plain data",
    ),
}

FIT_FILES = {
    "bounds in the wrong order": (
        "bounds: {storage_modulus: [1 MPa, 1 kPa]}",
        "{storage_modulus",
        "bounds: storage_modulus: the lower bound 1e+06 must lie below the upper bound 1000",
    ),
    "one bound": ("bounds: {loss_factor: [1]}", "[1]", "bounds.loss_factor.1: is missing; it is required"),
    "method": (
        "method: simplex",
        "simplex",
        "method: there is no method 'simplex'; allowed: joint, least-squares, nelder-mead,",
    ),
    "field": ("metod: nelder-mead", "metod", "metod: there is no such field; did you mean 'method'?"),
    "unit": (
        "acceptance: {time_of_flight: 40 Hz}",
        "40 Hz",
        "acceptance.time_of_flight: '40 Hz' has the wrong unit: this is a quantity in s, as 1e-3 or '1 ms'",
    ),
    "half a modulus": (
        "quasi_static: {storage_modulus: 120 kPa}",
        "{storage",
        "quasi_static.loss_modulus: is missing; it is required",
    ),
    "negative criterion": (
        "acceptance: {level_db: -0.5}",
        "-0.5",
        "acceptance.level_db: -0.5 is not allowed: it must be above 0",
    ),
}


class TestFit:
    @pytest.fixture
    def out(self, tmp_path):
        """Give a folder for results, and see that a refused fit has not made it."""
        yield tmp_path / "out"
        assert not (tmp_path / "out").exists()

    @pytest.mark.parametrize("case", SIGNALS)
    def test_signals(self, campaign, out, case):
        spoil, parts = SIGNALS[case]
        spoil(campaign)
        assert_refused(run("fit", campaign, "--out", out), *parts)

    def test_missing_signal_is_told_at_its_line(self, campaign, out):
        (campaign / SIGNAL).unlink()
        place = f"{campaign / CAMPAIGN}:{line_of(campaign / CAMPAIGN, SIGNAL)}: "
        assert_refused(run("fit", campaign, "--out", out), place)

    def test_another_frequency_than_stated(self, campaign, out):
        edit(campaign, "frequency: 400", "frequency: 500")
        done = run("fit", campaign, "--out", out)
        assert_refused(done, f"{SIGNAL}: the burst is stated at 500 Hz but found at 400 Hz; correct the frequency, or")

    @pytest.mark.parametrize("case", DESCRIPTIONS)
    def test_description(self, campaign, out, case):
        spoil, at, words = DESCRIPTIONS[case]
        spoil(campaign)
        file = campaign / CAMPAIGN
        assert_refused(run("fit", campaign, "--out", out), f"{file}:{line_of(file, at)}: {words}")

    @pytest.mark.parametrize("case", FIT_FILES)
    def test_fit_file(self, campaign, out, case):
        text, at, words = FIT_FILES[case]
        file = campaign / "fit.yaml"
        file.write_text(f"version: 1\ncampaign: .\n{text}\n")
        assert_refused(run("fit", campaign, "--out", out), f"{file}:{line_of(file, at)}: {words}")

    def test_every_mistake_at_once(self, campaign, out):
        """Mistakes of the description come alone; with a sound description, those of all signals come together."""
        change_signals(campaign, 200, clipped)
        (campaign / SIGNAL).unlink()
        change_signals(campaign, 600, with_value(np.nan, 1))
        done = run("fit", campaign, "--out", out)
        assert_refused(done, "0200.npz: the base channel is clipped", "there is no file", "0600.npz: the top channel")
        assert len(done.err.splitlines()) == 3

    def test_nothing_there(self, tmp_path, out):
        gone = tmp_path / "gone"
        assert_refused(run("fit", gone, "--out", out), f"{gone}: there is no such file or folder; name a folder")

    def test_folder_without_a_campaign(self, tmp_path, out):
        assert_refused(run("fit", tmp_path, "--out", out), f"{tmp_path}: holds no campaign.yaml and no fit.yaml; name")

    def test_fit_file_in_a_folder_without_a_campaign(self, tmp_path, out):
        file = tmp_path / "fit.yaml"
        file.write_text("version: 1\nmodel: finite\ncampaign: .\n")
        text = f"{file}:3:11: campaign: {tmp_path}: holds no campaign.yaml; name a folder that does"
        assert_refused(run("fit", file, "--out", out), text)
        assert_refused(run("fit", tmp_path, "--out", out), text)

    def test_campaign_of_the_fit_file_is_missing(self, campaign, out):
        (campaign / "fit.yaml").write_text("version: 1\ncampaign: elsewhere\n")
        assert_refused(run("fit", campaign, "--out", out), f"{campaign / 'elsewhere'}", "there is no")

    def test_calibration_in_place_of_a_campaign(self, tmp_path, out):
        calibration = write_calibration(tmp_path / "calibration", 1.0, 0.0)
        words = "rig: 'calibration' is not allowed; allowed: 'shaker-two-plate'"
        assert_refused(run("fit", calibration, "--out", out), f"{calibration / CAMPAIGN}:2:6: {words}")

    def test_bad_calibration(self, campaign, tmp_path, out):
        calibration = write_calibration(tmp_path / "calibration", 1.0, 0.0)
        with np.load(calibration / "0600.npz") as data:
            np.savez(calibration / "0600.npz", base=data["base"], top=-data["top"])
        (campaign / "fit.yaml").write_text("version: 1\ncalibration: ../calibration\n")
        done = run("fit", campaign, "--out", out)
        assert_refused(done, CAMPAIGN, "the calibration burst at 600 Hz", "of the same sign, and at one spot")

    def test_stack_file(self, tmp_path, out):
        (tmp_path / "stack.yaml").write_text("layers:\n  - {type: fluid, thickness: 1 mm}\n")
        done = run("fit", tmp_path / "stack.yaml", "--out", out)
        assert_refused(done, "stack.yaml: this is a stack file; a fit needs a campaign folder or a fit file")

    @pytest.mark.parametrize(
        ("method", "hint"),
        [("nelder-meed", "did you mean 'nelder-mead'?"), ("genetic", "allowed: joint, least-squares, nelder-mead,")],
    )
    def test_unknown_method(self, campaign, out, method, hint):
        words = f"--method: there is no method '{method}'; {hint}"
        assert_refused(run("fit", campaign, "--out", out, "--method", method), words)

    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            (("fit",), "Missing argument 'FILE_OR_CAMPAIGN'"),
            (("fit", "x", "--ouut", "y"), "No such option: --ouut"),
            (("fit", "x", "--ouut", "y"), "Usage: multilayer fit [OPTIONS]"),
            (("fitt",), "No such command 'fitt'. Did you mean 'fit'?"),
        ],
    )
    def test_usage(self, arguments, words):
        assert_refused(run(*arguments), words)


class TestResultsFolder:
    @pytest.fixture(autouse=True)
    def no_fit(self, monkeypatch):
        """See that a folder that cannot be used is told before anything is computed."""

        def fail(*arguments):
            raise AssertionError("a fit was started")

        monkeypatch.setattr("multilayer.fits.run.FitRun.run", fail)

    def test_is_a_file(self, campaign, tmp_path):
        out = tmp_path / "out"
        out.write_text("mine")
        done = run("fit", campaign, "--out", out)
        assert_refused(done, f"{out}: cannot be written to ({out} is a file); choose another folder with --out")
        assert out.read_text() == "mine"

    def test_lies_under_a_file(self, campaign, tmp_path):
        (tmp_path / "file").write_text("mine")
        done = run("fit", campaign, "--out", tmp_path / "file" / "out")
        assert_refused(done, f"({tmp_path / 'file'} is a file); choose another folder with --out")

    def test_has_too_long_a_name(self, campaign, tmp_path):
        done = run("fit", campaign, "--out", tmp_path / (300 * "x"))
        assert_refused(done, "cannot be written to (File name too long); choose another folder with --out")

    def test_may_not_be_written_to(self, campaign, tmp_path, monkeypatch):
        closed = tmp_path / "closed"
        closed.mkdir(mode=0o500)
        if os.access(closed, os.W_OK):  # the superuser may write anywhere
            access = os.access
            monkeypatch.setattr(os, "access", lambda at, mode, **how: at != closed and access(at, mode, **how))
        done = run("fit", campaign, "--out", closed / "out")
        assert_refused(done, f"(you may not write into {closed}); choose another folder with --out")
        assert list(closed.iterdir()) == []

    def test_default_is_checked_as_well(self, campaign, tmp_path):
        (tmp_path / "results").write_text("mine")
        assert_refused(run("fit", campaign, cwd=tmp_path), "results is a file")


LAYER = (
    "  - {type: elastic_solid, name: foam, thickness: 25 mm, density: 90, young_modulus: 200 kPa, poisson_ratio: 0.3}\n"
)
SOUND_STACK = f"version: 1\nlayers:\n  - {{type: fluid, thickness: 1 mm}}\n{LAYER}"

# what is replaced in the stack file by what, where it is told, and how
STACKS = {
    "negative thickness": (
        "25 mm",
        "-25 mm",
        "-25 mm",
        "layers.1.thickness: -0.025 is not allowed: it must be above 0",
    ),
    "Poisson's ratio": ("0.3", "0.5", "0.5", "layers.1.poisson_ratio: 0.5 is not allowed: it must be below 0.5"),
    "loss factor": (
        "0.3",
        "0.3, loss_factor: -0.1",
        "-0.1",
        "layers.1.loss_factor: -0.1 is not allowed: it must be at least 0",
    ),
    "two dampings": (
        "200 kPa",
        "2e5+1e4j Pa, loss_factor: 0.1",
        "{type: elastic_solid",
        "layers.1: loss_factor stands beside a young_modulus that has losses already; give one of the two",
    ),
    "energy from nothing": (
        "200 kPa",
        "2e5-1e4j Pa",
        "2e5-1e4j",
        "layers.1.young_modulus: 2e5-1e4j Pa is no modulus: its real part must be above 0 and its imaginary part at",
    ),
    "no layers": (SOUND_STACK.partition("layers:")[2], " []\n", "[]", "layers: must not be empty"),
    "unit": (
        "25 mm",
        "50 Pa",
        "50 Pa",
        "layers.1.thickness: '50 Pa' has the wrong unit: this is a quantity in m, as 0.05 or '50 mm'",
    ),
    "unknown unit": (
        "25 mm",
        "25 mn",
        "25 mn",
        "layers.1.thickness: 'mn' in '25 mn' is no unit known here; write 0.05",
    ),
    "decimal comma": (
        "25 mm",
        "'2,5 cm'",
        "'2,5 cm'",
        "layers.1.thickness: '2,5 cm' has a comma: decimals follow a point, '2.5 cm'",
    ),
    "no number": (
        "25 mm",
        "about 1 inch",
        "about",
        "layers.1.thickness: 'about 1 inch' is no number in m; write 0.05 or '50 mm'",
    ),
    "infinite": ("25 mm", ".inf", ".inf", "layers.1.thickness: inf is not finite"),
    "layer type": (
        "type: fluid",
        "type: fluidd",
        "{type: fluidd",
        "layers.0: there is no layer type 'fluidd'; did you mean 'fluid'?",
    ),
    "no layer type": (
        "type: fluid, ",
        "",
        "{thickness",
        "layers.0: has no 'type'; allowed: ",
    ),
    "law": (
        "200 kPa",
        "{law: fractional_zenner}",
        "{law",
        "layers.1.young_modulus: law 'fractional_zenner' is not known; did you mean 'fractional_zener'?",
    ),
    "table": (
        "200 kPa",
        "{law: table, file: gone.csv}",
        "{law",
        "layers.1.young_modulus: there is no file FOLDER/gone.csv; the path is relative to the YAML file",
    ),
    "termination": (
        LAYER,
        f"{LAYER}termination: rigidd\n",
        "rigidd",
        "termination: 'rigidd' is not allowed; allowed: rigid, ambient, free, or {type: fluid, density: ...}",
    ),
}


class TestCheck:
    @pytest.fixture
    def stack(self, tmp_path):
        file = tmp_path / "stack.yaml"
        file.write_text(SOUND_STACK)
        return file

    def test_sound_input(self, campaign, stack, tmp_path):
        calibration = write_calibration(tmp_path / "calibration", 1.0, 0.0)
        done = run("check", stack, campaign, calibration / CAMPAIGN)
        assert (done.status, done.err) == (0, "")
        assert done.out.splitlines() == [
            f"{stack}: a stack without mistakes",
            f"{campaign}: a campaign of 3 bursts without mistakes",
            f"{calibration / CAMPAIGN}: a calibration without mistakes",
        ]

    @pytest.mark.parametrize("case", STACKS)
    def test_stack(self, stack, case):
        old, new, at, words = STACKS[case]
        edit(stack.parent, old, new, stack.name)
        expected = f"{stack}:{line_of(stack, at)}: {words.replace('FOLDER', str(stack.parent))}"
        assert_refused(run("check", stack), expected)

    def test_several_mistakes_in_the_order_of_the_lines(self, stack):
        text = SOUND_STACK.replace("1 mm", "-1 mm").replace("25 mm", "25 Pa").replace("0.3", "0.5, colour: red")
        stack.write_text(f"{text}termination: open\nversion: 3\n".replace("version: 1\n", ""))
        done = run("check", stack)
        assert_refused(done)
        places = [line.removeprefix(f"{stack}:").split(": ")[:2] for line in done.err.splitlines()]
        assert [what for _, what in places] == [
            "layers.0.thickness",
            "layers.1.thickness",
            "layers.1.poisson_ratio",
            "layers.1.colour",
            "termination",
            "version",
        ]
        positions = [tuple(map(int, place.split(":"))) for place, _ in places]
        assert positions == sorted(positions)

    def test_signals_of_a_campaign(self, campaign):
        change_signals(campaign, 400, clipped)
        assert_refused(run("check", campaign), f"{SIGNAL}: the base channel is clipped")

    def test_mistakes_of_every_file(self, stack, campaign, tmp_path):
        sound = tmp_path / "sound.yaml"
        sound.write_text(SOUND_STACK)
        edit(tmp_path, "25 mm", "-25 mm", stack.name)
        edit(campaign, "version: 1", "version: 2")
        done = run("check", stack, sound, campaign, tmp_path / "gone")
        assert done.status == 2
        assert done.out == f"{sound}: a stack without mistakes\n"
        assert [line.partition(": ")[0].rpartition("/")[2] for line in done.err.splitlines()] == [
            "stack.yaml:4:50",
            "campaign.yaml:1:10",
            "gone",
        ]
