"""``multilayer import``: recordings of other programs come through to the same fit, or are refused in words."""

import csv
import io
import sys
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np
import pytest

from multilayer.measurements.campaign import load_calibration, load_campaign, load_recordings
from tests.cli.campaigns import BURSTS, FILE, RATE, burst, edit, write_campaign
from tests.cli.command import run
from tests.cli.test_bad_input import assert_refused
from tests.recorders import write_csv, write_h5, write_mat, write_tdms, write_uff, write_wav

G = 9.80665
SENSITIVITY = {"ai0": 10.2e-3 / G, "ai1": 9.7e-3 / G}  # V per m/s2
OPTIONS = ("--base", "ai0", "--top", "ai1")
IN_VOLTS = (*OPTIONS, "--sensitivity", "base=10.2mV/g", "--sensitivity", "top=9.7 mV/g")
WINDOW = ("--before", "2 ms", "--after", "99 ms")  # nearly that of the campaign: other records hold other noise
VOLTS = {"ai0": "V", "ai1": "V"}
FOAM_B = Path(__file__).parents[2] / "examples" / "foam_b"


def long_recording(noise=1e-3):
    """Return base and top, m/s2: every burst of the small campaign with its repeats, one after the other."""
    pairs = [burst(frequency, noise=noise) for frequency in BURSTS]
    return [np.concatenate([one[channel].ravel() for one in pairs]) for channel in (0, 1)]


def shifted(signal, by):
    """Return a signal later by a fraction of a sample."""
    f = np.fft.rfftfreq(4 * signal.size)
    return np.fft.irfft(np.fft.rfft(signal, 4 * signal.size) * np.exp(-2j * np.pi * f * by))[: signal.size]


BASE, TOP = long_recording()
IN_V = {"ai0": BASE * SENSITIVITY["ai0"], "ai1": TOP * SENSITIVITY["ai1"]}


def test_help_names_every_format():
    ours = [one.name for one in entry_points(group="multilayer.readers") if one.dist.name == "multilayer"]
    words = run("import", "--help").out.replace(",", " ").split()
    assert ours
    assert [name for name in ours if f".{name}" not in words] == []


def moduli(campaign, folder):
    done = run("fit", campaign, "--out", folder, "--no-figures")
    assert (done.status, done.err) == (0, ""), done
    rows = csv.DictReader((folder / "moduli.csv").read_text().splitlines())
    return np.array([[float(row[name]) for name in ("frequency_hz", "E1_pa", "E2_pa")] for row in rows])


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """Give the moduli of the campaign of .npz files."""
    folder = tmp_path_factory.mktemp("npz")
    campaign = write_campaign(folder / "foam")
    for frequency in BURSTS:
        base, top = burst(frequency)
        np.savez(campaign / FILE.format(frequency), base=base.astype(np.float32), top=top.astype(np.float32))
    return campaign, moduli(campaign, folder / "fit")


@pytest.mark.parametrize(
    ("suffix", "write", "rtol"),
    [
        ("tdms", write_tdms, 1e-6), ("uff", write_uff, 1e-6), ("mat", write_mat, 1e-6), ("h5", write_h5, 1e-6),
        ("csv", write_csv, 1e-6), ("txt", lambda *a: write_csv(*a, ";", comma=True), 1e-6),
    ],
)  # fmt: skip
def test_volts_of_every_format_give_the_moduli_of_the_npz_campaign(tmp_path, expected, suffix, write, rtol):
    campaign, moduli_of_npz = expected
    path = write(tmp_path / f"run.{suffix}", IN_V, RATE, VOLTS)
    done = run("import", path, "--out", tmp_path / "foam", *IN_VOLTS, "--like", campaign, *WINDOW)
    assert (done.status, done.err) == (0, ""), done
    assert "written to" in done.out
    np.testing.assert_allclose(moduli(tmp_path / "foam", tmp_path / "fit"), moduli_of_npz, rtol=rtol)


def test_shares_of_full_scale(tmp_path, expected):
    """A WAV file says neither names nor units; single precision is all it has."""
    campaign, moduli_of_npz = expected
    path = write_wav(tmp_path / "run.wav", {"a": BASE / 50, "b": TOP / 50}, RATE)
    names = ("--base", "channel_1", "--top", "channel_2")
    assert_refused(run("import", path, "--out", tmp_path / "foam", *names), "has no unit", "--unit base=V")
    units = ("--unit", "base=50 m/s2", "--unit", "top=50 m/s2")
    done = run("import", path, "--out", tmp_path / "foam", *names, *units, "--like", campaign, *WINDOW)
    assert (done.status, done.err) == (0, ""), done
    np.testing.assert_allclose(moduli(tmp_path / "foam", tmp_path / "fit"), moduli_of_npz, rtol=1e-5)


@pytest.mark.parametrize(("suffix", "write"), [("tdms", write_tdms), ("uff", write_uff)])
def test_the_example_through_a_recorder(tmp_path, suffix, write):
    """Records cut otherwise hold other noise: moduli agree within a tenth of their standard deviations."""
    campaign = load_campaign(FOAM_B)
    pieces = [(one.base, one.top) for one in load_recordings(campaign).values()]
    channels = {
        name: np.concatenate([np.concatenate([np.zeros(200), row]) for pair in pieces for row in pair[i]])
        for i, name in enumerate(("base", "top"))
    }
    path = write(tmp_path / f"run.{suffix}", channels, campaign.sampling_rate, {"base": "m/s^2", "top": "m/s^2"})
    done = run("import", path, "--out", tmp_path / "foam", "--like", FOAM_B)
    assert (done.status, done.err) == (0, ""), done
    found, there = (
        run("fit", one, "--out", tmp_path / f"fit-{i}", "--no-figures")
        for i, one in enumerate((tmp_path / "foam", FOAM_B))
    )
    assert (found.status, there.status) == (0, 0)
    rows = [list(csv.DictReader((tmp_path / f"fit-{i}" / "moduli.csv").read_text().splitlines())) for i in (0, 1)]
    assert len(rows[0]) == 15
    for new, old in zip(*rows, strict=True):
        assert new["frequency_hz"] == old["frequency_hz"]
        for name in ("E1", "E2"):
            assert float(new[f"{name}_pa"]) == pytest.approx(
                float(old[f"{name}_pa"]), abs=0.1 * float(old[f"{name}_std_pa"])
            )


class TestCampaign:
    def test_several_files_and_channels_called_base_and_top(self, tmp_path, expected):
        units = {"base": "g", "top": "m/s^2"}
        middle = BASE.size // 3 * 2
        while np.abs(BASE[middle]) > 0.02:
            middle += 1
        paths = [
            write_tdms(
                tmp_path / f"{i}.tdms", {"base": BASE[part] / G, "top": TOP[part], "mic": TOP[part]}, RATE, units
            )
            for i, part in enumerate((slice(0, middle), slice(middle, None)))
        ]
        done = run("import", *paths, "--out", tmp_path / "foam", "--like", expected[0], "--frequencies", "200,600")
        assert done.status == 0, done
        found = load_recordings(load_campaign(tmp_path / "foam"))
        assert {frequency for _, frequency in found} == {200, 600}
        assert "left out" in done.err
        assert "400 Hz is none of the frequencies given" in done.err

    def test_without_knowledge_a_template(self, tmp_path):
        path = write_tdms(tmp_path / "run.tdms", {"base": BASE, "top": TOP}, RATE, {"base": "m/s^2", "top": "m/s^2"})
        folder = tmp_path / "foam"
        done = run("import", path, "--out", folder)
        assert done.status == 0, done
        assert "fill in what" in done.out
        text = (folder / "campaign.yaml").read_text()
        assert text.count(": FILL_IN") == 12
        refused = run("fit", folder, "--out", tmp_path / "fit")
        assert_refused(refused, "12 fields are still to be filled in", "specimen.density (line 9)", "specimen_radius")
        assert len(refused.err.splitlines()) == 1
        for name, value in (
            ("specimen: {density", 90), ("poisson_ratio", 0.3), ("top_plate: {density", 7850),
            ("young_modulus", "210 GPa"), ("poisson_ratio", 0.3), ("base_plate: {density", 2700),
            ("young_modulus", "70 GPa"), ("poisson_ratio", 0.33), ("thickness", "10 mm"),
            ("specimen_thickness", "25 mm"), ("top_plate_thickness", "1 mm"),
            ("specimen_radius", "22.5 mm"),
        ):  # fmt: skip
            edit(folder, f"{name}: FILL_IN", f"{name}: {value}")
        assert run("fit", folder, "--out", tmp_path / "fit", "--no-figures").status == 0

    def test_one_configuration_of_several(self, tmp_path, expected):
        like = tmp_path / "known.yaml"
        text = (expected[0] / "campaign.yaml").read_text()
        start = text.index("  - name")
        like.write_text(text + text[start:].replace("h25mm", "h50mm").replace("25 mm", "50 mm"))
        path = write_tdms(tmp_path / "run.tdms", IN_V, RATE, VOLTS)
        command = ("import", path, "--out", tmp_path / "foam", *IN_VOLTS, "--like", like)
        assert_refused(run(*command), "known.yaml: has several configurations", "--configuration", "h25mm, h50mm")
        assert_refused(run(*command, "--configuration", "h52mm"), "there is no 'h52mm'", "did you mean 'h50mm'?")
        assert run(*command, "--configuration", "h50mm").status == 0
        (configuration,) = load_campaign(tmp_path / "foam").configurations
        assert (configuration.name, configuration.specimen_thickness) == ("h50mm", 0.05)

    def test_repeats_of_two_levels_are_remarked_on(self, tmp_path, expected):
        channels = {name: np.concatenate([one, 2 * one]) for name, one in IN_V.items()}
        path = write_tdms(tmp_path / "run.tdms", channels, RATE, VOLTS)
        done = run("import", path, "--out", tmp_path / "foam", *IN_VOLTS, "--like", expected[0])
        assert done.status == 0
        assert "remark: repeats at 200 Hz differ in level by a factor of 2; a fit averages them" in done.err

    def test_repeats_whose_channels_differ_are_remarked_on(self, tmp_path, expected):
        channels = {name: np.concatenate([one, one]) for name, one in IN_V.items()}
        channels["ai1"][BASE.size :] *= 0.9
        path = write_tdms(tmp_path / "run.tdms", channels, RATE, VOLTS)
        done = run("import", path, "--out", tmp_path / "foam", *IN_VOLTS, "--like", expected[0])
        assert done.status == 0
        assert "remark: repeats differ in top over base in 3 of 3 recordings" in done.err

    def test_a_calibration(self, tmp_path, expected):
        """Both accelerometers at one spot, the top's chain with a gain and a delay."""
        pairs = [burst(f, response=lambda f: 1.02 * np.exp(-2j * np.pi * f * 5e-6)) for f in BURSTS]
        channels = {name: np.concatenate([one[i].ravel() for one in pairs]) for i, name in enumerate(("base", "top"))}
        path = write_tdms(tmp_path / "run.tdms", channels, RATE, {"base": "m/s^2", "top": "m/s^2"})
        for number, options in enumerate(((), ("--like", expected[0]))):
            folder = tmp_path / f"calibration{number}"
            done = run("import", path, "--out", folder, "--calibration", *options)
            assert (done.status, done.err) == (0, ""), done
            found = load_calibration(folder)
            assert found.frequencies == pytest.approx(BURSTS)
            assert found.amplitude_ratio == pytest.approx(1.02, rel=1e-3)
            assert found.time_shift == pytest.approx(5e-6, abs=5e-7)
        assert run("check", tmp_path / "calibration0" / "campaign.yaml").status == 0

    def test_a_calibration_with_a_channel_of_the_wrong_sign(self, tmp_path):
        pairs = [burst(f, response=lambda f: -np.ones_like(f)) for f in BURSTS]
        channels = {name: np.concatenate([one[i].ravel() for one in pairs]) for i, name in enumerate(("base", "top"))}
        path = write_tdms(tmp_path / "run.tdms", channels, RATE, {"base": "m/s^2", "top": "m/s^2"})
        done = run("import", path, "--out", tmp_path / "calibration", "--calibration")
        assert_refused(done, "the calibration burst at 200 Hz shows no motion common to both channels", "same sign")
        assert not (tmp_path / "calibration").exists()

    def test_asks_on_a_terminal(self, tmp_path, monkeypatch, expected):
        class Terminal(io.StringIO):
            def isatty(self):
                return True

        monkeypatch.setattr(sys, "stdin", Terminal("ai0\nai1\n"))
        path = write_tdms(tmp_path / "run.tdms", IN_V, RATE, VOLTS)
        done = run("import", path, "--out", tmp_path / "foam", *IN_VOLTS[4:], "--like", expected[0])
        assert done.status == 0, done
        assert "holds: 'ai0' (V, 12800 Hz" in done.err


def mistake(tmp_path, *options, channels=IN_V, units=VOLTS, rate=RATE, names=OPTIONS):
    path = write_tdms(tmp_path / "run.tdms", channels, rate, units)
    return run("import", path, "--out", tmp_path / "foam", *names, *options)


class TestRefused:
    @pytest.fixture(autouse=True)
    def nothing_is_written(self, tmp_path):
        yield
        left = {path.name for path in tmp_path.iterdir()}
        assert "foam" not in left
        assert [name for name in left if name.startswith(".partial")] == []

    def test_a_channel_that_is_not_there(self, tmp_path):
        done = mistake(tmp_path, names=("--base", "ai7", "--top", "ai1"))
        assert_refused(done, "run.tdms: has no channel 'ai7'; it holds: 'ai0' (V, 12800 Hz", "'ai1'")

    def test_channels_that_are_not_named(self, tmp_path):
        assert_refused(mistake(tmp_path, names=()), "with --base and --top; it holds: 'ai0'")
        assert_refused(mistake(tmp_path, names=("--base", "ai0")), "with --top; it holds: 'ai0'")

    def test_one_channel_for_both(self, tmp_path):
        assert_refused(mistake(tmp_path, names=("--base", "ai0", "--top", "AI0")), "both name 'ai0'")

    @pytest.mark.parametrize(
        ("value", "message"),
        [
            ("base=0 mV/g", "--sensitivity base: a sensitivity of 0 mV/g is not allowed; it must be above 0"),
            ("base=-10mV/g", "must be above 0"),
            ("base=10 mV/Pa", "'10 mV/Pa' is no sensitivity of an accelerometer"),
            ("base=10", "'10' is no sensitivity with a unit"),
            ("bse=10mV/g", "does not give base or top a value"),
            ("base", "does not give base or top a value"),
        ],
    )
    def test_sensitivities(self, tmp_path, value, message):
        assert_refused(mistake(tmp_path, "--sensitivity", value), message)

    def test_volts_without_a_sensitivity(self, tmp_path):
        done = mistake(tmp_path, "--sensitivity", "base=10mV/g")
        assert_refused(done, "channel 'ai1' (top) is in V; say what that is in m/s2, as --sensitivity top=10.2mV/g")

    def test_a_sensitivity_of_what_is_an_acceleration(self, tmp_path):
        done = mistake(tmp_path, *IN_VOLTS[4:], units={"ai0": "g", "ai1": "V"})
        assert_refused(done, "channel 'ai0' (base) is in g, an acceleration already", "leave out --sensitivity base")

    def test_a_unit_that_contradicts_the_file(self, tmp_path):
        assert_refused(mistake(tmp_path, "--unit", "base=g"), "says that it is in V, but --unit base says g")
        assert_refused(mistake(tmp_path, "--unit", "base=kg"), "'kg' is no voltage and no acceleration")
        assert_refused(mistake(tmp_path, units={"ai0": "degC"}), "is in degC, neither a voltage nor an acceleration")

    def test_no_sampling_rate(self, tmp_path):
        assert_refused(mistake(tmp_path, *IN_VOLTS[4:], rate=None), "does not say its sampling rate", "--rate")
        assert_refused(mistake(tmp_path, *IN_VOLTS[4:], "--rate", "51.2 kHz"), "sampled at 12800 Hz, but --rate")
        assert_refused(mistake(tmp_path, "--rate", "fast"), "--rate: 'fast' is no number in Hz")

    def test_files_of_different_rates(self, tmp_path):
        paths = [write_tdms(tmp_path / f"{rate}.tdms", IN_V, rate, VOLTS) for rate in (12800, 25600)]
        done = run("import", *paths, "--out", tmp_path / "foam", *IN_VOLTS)
        assert_refused(done, "differ in sampling rate", "12800.tdms at 12800 Hz", "25600.tdms at 25600 Hz")

    def test_channels_of_different_rates_or_lengths(self, tmp_path):
        path = write_mat(tmp_path / "run.mat", {"ai0": BASE, "ai1": TOP[:-5]}, RATE, VOLTS)
        done = run("import", path, "--out", tmp_path / "foam", *IN_VOLTS)
        assert_refused(done, "base and top must be sampled together, but they are 'ai0'")

    def test_a_file_named_twice(self, tmp_path):
        path = write_tdms(tmp_path / "run.tdms", IN_V, RATE, VOLTS)
        done = run("import", path, path, "--out", tmp_path / "foam", *IN_VOLTS)
        assert_refused(done, "run.tdms: named more than once")

    def test_no_burst(self, tmp_path):
        noise = np.random.default_rng(0).normal(size=(2, 20000))
        done = mistake(tmp_path, *IN_VOLTS[4:], channels={"ai0": noise[0], "ai1": noise[1]})
        assert_refused(done, "run.tdms: no burst of 10 cycles in the base's signal")

    def test_not_finite(self, tmp_path):
        spoiled = IN_V["ai0"].copy()
        spoiled[7] = np.nan
        done = mistake(tmp_path, *IN_VOLTS[4:], channels={**IN_V, "ai0": spoiled})
        assert_refused(done, "channel 'ai0' holds 1 samples that are not finite")

    def test_exchanged_channels(self, tmp_path):
        done = mistake(tmp_path, *IN_VOLTS[4:], names=("--base", "ai1", "--top", "ai0"))
        assert_refused(done, "base and top look exchanged")

    def test_a_channel_that_failed_in_one_repeat(self, tmp_path):
        channels = {name: np.concatenate([one, one, one]) for name, one in IN_V.items()}
        channels["ai1"][2 * BASE.size :] *= 1e-3
        done = mistake(tmp_path, *IN_VOLTS[4:], channels=channels)
        assert_refused(done, "burst at 200 Hz (run.tdms at ", "repeats 5, 6 of 6 differ", "by a factor of 0.001")

    @pytest.mark.parametrize("clipped", [(0,), (1, 2)])
    def test_clipping_is_seen_ahead_of_the_shift_between_samples(self, tmp_path, clipped):
        """Repeats begin between samples: all but the first are shifted, which rounds flat tops."""
        pieces = []
        for i, by in enumerate((0.0, 0.37, 0.61)):
            for frequency in (400, 600):
                pair = [shifted(np.append(one[0], np.zeros(500)), by) for one in burst(frequency, noise=0.0)]
                if i in clipped:
                    pair[1] = np.clip(pair[1], -0.6 * pair[1].max(), 0.6 * pair[1].max())
                pieces.append(pair)
        rng = np.random.default_rng(1)
        base, top = (np.concatenate([pair[i] for pair in pieces]) for i in (0, 1))
        channels = {"ai0": base + 1e-3 * rng.normal(size=base.size), "ai1": top}
        done = mistake(tmp_path, channels=channels, units={"ai0": "m/s^2", "ai1": "m/s^2"})
        assert_refused(done, f"the top channel is clipped in {len(clipped)} of 3 repeats", "burst at 600 Hz")

    def test_channels_that_do_not_start_together(self, tmp_path):
        path = write_tdms(tmp_path / "run.tdms", IN_V, RATE, VOLTS, starts={"ai0": 0.0, "ai1": 1 / RATE})
        done = run("import", path, "--out", tmp_path / "foam", *IN_VOLTS)
        assert_refused(done, "run.tdms: 'ai1' starts 78.12 us after 'ai0'; export all channels on a common time axis")

    def test_damaged_files_all_at_once(self, tmp_path):
        good = write_tdms(tmp_path / "good.tdms", IN_V, RATE, VOLTS)
        (tmp_path / "cut.tdms").write_bytes(good.read_bytes()[:-1000])
        (tmp_path / "text.tdms").write_text("time,base\n0,1\n")
        paths = [good, tmp_path / "cut.tdms", tmp_path / "text.tdms", tmp_path / "none.tdms", tmp_path / "run.doc"]
        done = run("import", *paths, "--out", tmp_path / "foam", *IN_VOLTS)
        assert_refused(
            done, "cut.tdms: cannot be read as a TDMS file", "text.tdms: cannot be read as a TDMS file",
            "none.tdms: there is no such file", "run.doc: nothing reads '.doc' files",
        )  # fmt: skip

    def test_a_library_that_is_not_installed(self, tmp_path, monkeypatch):
        monkeypatch.setitem(sys.modules, "nptdms", None)
        (tmp_path / "run.tdms").write_bytes(b"TDSm")
        done = run("import", tmp_path / "run.tdms", "--out", tmp_path / "foam", *IN_VOLTS)
        assert_refused(done, "pip install 'multilayer[formats]'")

    def test_knowledge_with_mistakes(self, tmp_path, expected):
        like = tmp_path / "known.yaml"
        like.write_text((expected[0] / "campaign.yaml").read_text().replace("density: 90", "density: -90"))
        done = mistake(tmp_path, *IN_VOLTS[4:], "--like", like)
        assert_refused(done, "known.yaml:4:21: specimen.density: -90.0 is not allowed")
        like.write_text("rig: two-plate\n")
        assert_refused(mistake(tmp_path, *IN_VOLTS[4:], "--like", like), "describes a 'two-plate'")
        assert_refused(mistake(tmp_path, "--like", tmp_path / "none.yaml"), "none.yaml: there is no such file")
        assert_refused(mistake(tmp_path, "--like", expected[0], "--cycles", "7"), "--cycles says 7, but")
        assert_refused(mistake(tmp_path, "--configuration", "h25mm"), "give that, too")


def test_a_folder_that_holds_something_stays_as_it_is(tmp_path):
    (tmp_path / "foam").mkdir()
    (tmp_path / "foam" / "notes.txt").write_text("mine")
    assert_refused(mistake(tmp_path, *IN_VOLTS[4:]), "holds files already", "--out")
    assert [path.name for path in (tmp_path / "foam").iterdir()] == ["notes.txt"]
