"""``multilayer tube``: raw data of impedance tubes, and what other commands make of the result."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import firwin2

from multilayer.response import plane_wave
from tests.analytic.test_impedance_tube import ASYMMETRIC, FREQUENCY, POSITIONS, pressures, stack, thickness
from tests.cli.command import result_names, run
from tests.cli.test_bad_input import assert_refused
from tests.recorders import write_h5, write_tdms, write_wav

EXAMPLES = Path(__file__).parents[2] / "examples"
TWO = """\
version: 1
method: two_microphones
tube: {diameter: 40 mm}
spacing: 45 mm
distance: 100 mm
measurement: {file: h12.csv}
"""
FOUR = f"""\
version: 1
method: four_microphones
tube: {{width: 40 mm, height: 50 mm}}
positions: {list(POSITIONS)}
thickness: {thickness(ASYMMETRIC)}
loads: [{{file: open.csv}}, {{file: closed.csv}}]
"""

BOTH = "exchanged: {file: a.csv}\ncalibration: {straight: {file: b.csv}, exchanged: {file: c.csv}}\nmeasurement"


def write_table(path, frequency, **columns):
    parts = {f"{n}_{p}": getattr(v, q) for n, v in columns.items() for p, q in (("re", "real"), ("im", "imag"))}
    rows = zip(frequency, *parts.values(), strict=True)
    text = "\n".join([",".join(["frequency_hz", *parts]), *(",".join(f"{x:.12g}" for x in row) for row in rows), ""])
    path.write_text(text)


def table(path):
    rows = list(csv.DictReader(path.read_text().splitlines()))
    return {
        name: np.array([float(row[name] not in ("false",)) if name == "in_range" else float(row[name]) for row in rows])
        for name in rows[0]
    }


@pytest.fixture
def two(tmp_path):
    """Give a tube file with two microphones, and its table."""
    (tmp_path / "tube.yaml").write_text(TWO)
    found = pressures(ASYMMETRIC, 0.0, positions=(-0.145, -0.1, 1.0, 2.0))[0]
    write_table(tmp_path / "h12.csv", FREQUENCY, h12=found[1] / found[0])
    return tmp_path


@pytest.fixture
def four(tmp_path):
    """Give a tube file with four microphones, whose gains differ, and its tables."""
    (tmp_path / "wall.yaml").write_text(FOUR + "calibration: {file: together.csv}\n")
    gains = np.array([1, 1.1, 0.9 * np.exp(0.1j), 1.05 * np.exp(-0.2j)])[:, None] * np.ones_like(FREQUENCY)
    names = ("h1", "h2", "h3", "h4")
    for name, cavity in (("open", 0.4), ("closed", 0.47)):
        found = gains * np.array(pressures(ASYMMETRIC, cavity)[0])
        write_table(tmp_path / f"{name}.csv", FREQUENCY, **dict(zip(names[1:], (found / found[0])[1:], strict=True)))
    write_table(tmp_path / "together.csv", FREQUENCY, **dict(zip(names, gains, strict=True)))
    return tmp_path


class TestTwoMicrophones:
    def test_the_file_gives_the_stack_back_in_its_working_range(self, two):
        done = run("tube", two, "--out", two / "out")
        assert (done.status, done.err) == (0, "")
        assert "working range: 381.4 to 3432 Hz" in done.out
        found = table(two / "out" / "tube.csv")
        assert found["frequency_hz"].min() >= 381.3
        assert "frequencies outside of it were left out" in done.out
        exact = plane_wave(stack(ASYMMETRIC), found["frequency_hz"])
        np.testing.assert_allclose(found["reflection_re"] + 1j * found["reflection_im"], exact.reflection, atol=2e-8)
        np.testing.assert_allclose(found["absorption"], exact.absorption, atol=2e-8)
        assert (two / "out" / "tube.png").read_bytes()[:4] == b"\x89PNG"

    def test_exchanged_microphones_and_a_distance_in_mm_are_asked_back(self, two):
        done = run("tube", two, "--out", two / "right")
        assert (done.status, "warning" in done.err) == (0, False)
        found = pressures(ASYMMETRIC, 0.0, positions=(-0.145, -0.1, 1.0, 2.0))[0]
        write_table(two / "h12.csv", FREQUENCY, h12=found[0] / found[1])
        (two / "tube.yaml").write_text(TWO.replace("100 mm", "100"))
        done = run("tube", two, "--out", two / "wrong")
        assert done.status == 0
        assert "a distance of 100 m; numbers without a unit are in m: is '100 mm' meant?" in done.err
        assert "gives back more power than arrives: are microphones exchanged" in done.err

    def test_what_lies_outside_is_kept_on_demand_and_marked(self, two):
        (two / "tube.yaml").write_text(TWO + "keep_outside: true\nfrom: 200 Hz\n")
        done = run("tube", two / "tube.yaml", "--out", two / "out", "--no-figures")
        assert (done.status, done.err) == (0, "")
        found = table(two / "out" / "tube.csv")
        assert 200 <= found["frequency_hz"].min() < 250
        np.testing.assert_array_equal(found["in_range"] == 1, found["frequency_hz"] >= 381.33)
        assert result_names(two / "out") == {"tube.csv", "tube.json"}

    def test_compare_and_fit_take_the_table(self, tmp_path):
        out = tmp_path / "raw"
        assert run("tube", EXAMPLES / "raw_tube", "--out", out, "--no-figures").status == 0
        truth = EXAMPLES / "foam_tube" / "truth.yaml"
        done = run("compare", truth, out / "tube.csv", "--out", tmp_path / "compared", "--no-figures")
        assert (done.status, done.err) == (0, "")
        assert "reflection" in done.out
        text = (EXAMPLES / "foam_tube" / "fit.yaml").read_text()
        (tmp_path / "foam.yaml").write_text((EXAMPLES / "foam_tube" / "foam.yaml").read_text())
        (tmp_path / "fit.yaml").write_text(text.replace("tube.csv ", "raw/tube.csv ").replace("0.01}", "0.002}"))
        done = run("fit", tmp_path / "fit.yaml", "--out", tmp_path / "fitted", "--no-figures")
        assert (done.status, done.err) == (0, "")
        rows = csv.DictReader((tmp_path / "fitted" / "parameters.csv").read_text().splitlines())
        found = {row["name"]: float(row["value"]) for row in rows}
        assert found["layers.foam.flow_resistivity"] == pytest.approx(13.5e3, rel=0.02)
        done = run("check", tmp_path / "fit.yaml", EXAMPLES / "raw_tube")
        assert (done.status, done.err) == (0, "")

    @pytest.mark.parametrize("write", [write_tdms, write_wav])
    def test_signals_over_time(self, tmp_path, write):
        """Noise that a filter turns into what the second microphone hears."""
        rate, delay = 16384.0, 64
        grid = np.linspace(0, rate / 2, 513)
        found = pressures(ASYMMETRIC, 0.0, positions=(-0.145, -0.1, 1.0, 2.0))[0]
        wanted = np.interp(grid, FREQUENCY, np.abs(found[1] / found[0]))
        taps = firwin2(2 * delay + 1, grid, wanted, fs=rate)
        source = np.random.default_rng(0).standard_normal(int(8 * rate))
        signals = {"a": 0.1 * source, "b": 0.1 * np.convolve(source, taps)[: source.size]}
        path = write(tmp_path / f"run.{write.__name__[6:]}", signals, rate, {})
        names = "[a, b]" if path.suffix == ".tdms" else "[channel_1, channel_2]"
        text = TWO.replace("{file: h12.csv}", f"{{recording: {path.name}, channels: {names}, segment: 0.25 s}}")
        (tmp_path / "tube.yaml").write_text(text)
        done = run("tube", tmp_path, "--out", tmp_path / "out", "--no-figures")
        assert (done.status, done.err) == (0, "")
        found = table(tmp_path / "out" / "tube.csv")
        assert np.diff(found["frequency_hz"])[0] == pytest.approx(4)
        assert found["coherence"].min() > 0.9


class TestExchanged:
    """Microphones that differ by 8 % and 0.06 rad, and keep their channels when they change places."""

    MISMATCH = 1.08 * np.exp(0.06j)

    @pytest.fixture
    def read(self, two):
        """Give the folder of a tube file whose table the mismatch is in, and what both places have of each other."""
        (two / "tube.yaml").write_text(TWO + "exchanged: {file: exchanged.csv}\n")
        far, near = pressures(ASYMMETRIC, 0.0, positions=(-0.145, -0.1, 1.0, 2.0))[0][:2]
        write_table(two / "h12.csv", FREQUENCY, h12=self.MISMATCH * near / far)
        return two, near / far

    def test_channel_2_over_channel_1_gives_the_stack_back(self, read):
        folder, h12 = read
        write_table(folder / "exchanged.csv", FREQUENCY, h12=self.MISMATCH / h12)
        done = run("tube", folder, "--out", folder / "out", "--no-figures")
        assert (done.status, done.err) == (0, "")
        found = table(folder / "out" / "tube.csv")
        exact = plane_wave(stack(ASYMMETRIC), found["frequency_hz"])
        np.testing.assert_allclose(found["absorption"], exact.absorption, atol=2e-8)

    def test_a_ratio_turned_round_is_asked_back(self, read):
        folder, h12 = read
        write_table(folder / "exchanged.csv", FREQUENCY, h12=h12 / self.MISMATCH)
        done = run("tube", folder, "--out", folder / "out", "--no-figures")
        assert done.status == 0
        assert "'exchanged' looks like channel 1 over channel 2" in done.err
        text = (folder / "tube.yaml").read_text().replace("exchanged: {", "calibration: {straight: {file: h12.csv}, ")
        (folder / "tube.yaml").write_text(text.replace("file: exchanged.csv}", "exchanged: {file: exchanged.csv}}"))
        done = run("tube", folder, "--out", folder / "again", "--no-figures")
        assert "'calibration.exchanged' looks like channel 1 over channel 2" in done.err

    def test_recordings_have_their_channels_in_the_same_order(self, tmp_path):
        """The microphones change places in a field of which the second place hears a part, later."""
        rng, rate = np.random.default_rng(0), 16384.0
        far = rng.standard_normal(int(8 * rate))
        near = 0.6 * far + 0.5 * np.roll(far, 3)
        write_tdms(tmp_path / "a.tdms", {"a": far, "b": 1.08 * near}, rate, {})
        write_tdms(tmp_path / "b.tdms", {"a": near, "b": 1.08 * far}, rate, {})
        text = TWO.replace("{file: h12.csv}", "{recording: a.tdms, channels: [a, b]}")
        (tmp_path / "tube.yaml").write_text(text + "exchanged: {recording: b.tdms, channels: [a, b]}\n")
        done = run("tube", tmp_path, "--out", tmp_path / "out", "--no-figures")
        assert (done.status, done.err) == (0, "")
        write_tdms(tmp_path / "a.tdms", {"a": far, "b": near}, rate, {})
        (tmp_path / "tube.yaml").write_text(text)
        assert run("tube", tmp_path, "--out", tmp_path / "alike", "--no-figures").status == 0
        found, exact = (table(tmp_path / name / "tube.csv") for name in ("out", "alike"))
        np.testing.assert_allclose(found["absorption"], exact["absorption"], atol=0.02)

    @pytest.mark.parametrize(
        ("source", "place"),
        [
            ("exchanged: {recording: b.tdms, channels: [b, a]}", "7:42: exchanged.channels"),
            (
                "calibration: {straight: {recording: b.tdms, channels: [b, a]},"
                " exchanged: {recording: c.tdms, channels: [b, a]}}",
                "calibration.straight.channels",
            ),
            (
                "calibration: {straight: {recording: b.tdms, channels: [a, b]},"
                " exchanged: {recording: c.tdms, channels: [b, a]}}",
                "calibration.exchanged.channels",
            ),
        ],
    )
    def test_channels_the_other_way_round_are_refused(self, tmp_path, source, place):
        first = "{recording: a.tdms, channels: [a, b]}"
        (tmp_path / "tube.yaml").write_text(TWO.replace("{file: h12.csv}", f"{first}\n{source}"))
        told = f"{place}: these are the channels of '"
        assert_refused(
            run("tube", tmp_path, "--out", tmp_path / "out"),
            told,
            "the other way round; write the same order, ['a', 'b']",
        )
        assert not (tmp_path / "out").exists()


class TestFourMicrophones:
    def test_the_file_gives_the_stack_back(self, four):
        done = run("tube", four / "wall.yaml", "--out", four / "out")
        assert (done.status, done.err) == (0, "")
        names = {"tube.csv", "rigid_backed.csv", "transfer_matrix.csv", "tube.json", "tube.png"}
        assert result_names(four / "out") == names
        found, rigid = table(four / "out" / "tube.csv"), table(four / "out" / "rigid_backed.csv")
        exact = plane_wave(stack(ASYMMETRIC, "ambient"), found["frequency_hz"])
        np.testing.assert_allclose(found["transmission_loss_db"], exact.transmission_loss, atol=1e-6)
        np.testing.assert_allclose(found["absorption"], exact.absorption, atol=1e-7)
        absorption = plane_wave(stack(ASYMMETRIC), rigid["frequency_hz"]).absorption
        np.testing.assert_allclose(rigid["absorption"], absorption, atol=1e-7)

    def test_compare_takes_the_transmission_loss(self, four):
        assert run("tube", four / "wall.yaml", "--out", four / "out", "--no-figures").status == 0
        layers = "\n".join(f"  - {layer}" for layer in ASYMMETRIC)
        (four / "stack.yaml").write_text(f"version: 1\nlayers:\n{layers}\ntermination: ambient\n".replace("'", ""))
        done = run(
            "compare", four / "stack.yaml", four / "out" / "tube.csv", "--json", "--out", four / "c", "--no-figures"
        )
        assert (done.status, done.err) == (0, ""), done
        for quantity in ("transmission_loss", "reflection", "transmission", "normalised_impedance"):
            assert quantity in done.out


class TestRefused:
    @pytest.mark.parametrize(
        ("old", "new", "parts"),
        [
            ("two_microphones", "3_microphones", ("tube.yaml:2:9: method: '3_microphones' is not allowed", "four_")),
            ("diameter: 40 mm", "width: 40 mm", ("tube.yaml:3:7: tube: give the 'diameter'",)),
            ("45 mm", "45 kg", ("spacing: '45 kg' has the wrong unit",)),
            ("h12.csv", "none.csv", ("tube.yaml:6:21: measurement.file: ", "none.csv: there is no such file; the")),
            ("{file: h12.csv}", "{}", ("measurement: give either 'file'",)),
            ("{file: h12.csv}", "{recording: run.tdms}", ("measurement: a recording needs 'channels'",)),
            ("45 mm", "2 m", ("no frequency is left to evaluate", "this tube works from 8.581 to 77.23 Hz")),
            ("measurement", BOTH, ("calibration: give either 'exchanged' or 'calibration'",)),
            ("measurement", "from: 3 kHz\nto: 500 Hz\nmeasurement", ("tube.yaml:7:5: to: ", "below the first, 'from'")),
            ("measurement", "from: 2 kHz\nto: 2001 Hz\nmeasurement", ("wanted are those 'from' 2000 Hz 'to' 2001 Hz",)),
        ],
    )  # fmt: skip
    def test_mistakes_in_the_file(self, two, old, new, parts):
        text = (two / "tube.yaml").read_text()
        assert old in text
        (two / "tube.yaml").write_text(text.replace(old, new, 1))
        assert_refused(run("tube", two, "--out", two / "out"), *parts)
        assert not (two / "out").exists()

    @pytest.mark.parametrize(
        ("old", "new", "parts"),
        [
            ("frequency_hz", "frequency", ("h12.csv:1: column 'frequency' has no unit",)),
            ("h12_im", "h12", ("h12.csv:1: has no column h12_im; name the columns frequency_hz, h12_re, h12_im",)),
            ("\n150,", "\n-150,", ("h12.csv:3: a frequency of -150 Hz is not allowed",)),
            ("\n150,", "\nx,", ("h12.csv:3: 'x' is no number",)),
        ],
    )
    def test_mistakes_in_a_table(self, two, old, new, parts):
        text = (two / "h12.csv").read_text()
        assert old in text
        (two / "h12.csv").write_text(text.replace(old, new, 1))
        assert_refused(run("tube", two, "--out", two / "out"), *parts)

    def test_tables_at_other_frequencies(self, two):
        (two / "tube.yaml").write_text(TWO + "exchanged: {file: other.csv}\n")
        write_table(two / "other.csv", FREQUENCY[1:], h12=np.ones(len(FREQUENCY) - 1, dtype=complex))
        assert_refused(run("tube", two, "--out", two / "out"), "other.csv: has other frequencies than", "h12.csv")

    def test_positions_of_four_microphones(self, four):
        text = (four / "wall.yaml").read_text().replace("0.17,", "0.01,")
        (four / "wall.yaml").write_text(text)
        assert_refused(run("tube", four / "wall.yaml"), "positions: ", "two rising ones behind the thickness")

    def test_recordings(self, tmp_path):
        noise = np.random.default_rng(0).standard_normal((2, 5000))
        write_tdms(tmp_path / "run.tdms", {"a": noise[0], "b": noise[1], "c": 0 * noise[0]}, 8192, {})
        for source, part in (
            ("channels: [a, x]", "run.tdms: has no channel 'x'; it holds: 'a'"),
            ("channels: [a]", "1 channels are named for 2 microphones"),
            ("channels: [a, c]", "channel 'c' is silent"),
            ("channels: [a, b], segment: 9 s", "less than one segment of 9 s"),
        ):
            text = TWO.replace("{file: h12.csv}", f"{{recording: run.tdms, {source}}}")
            (tmp_path / "tube.yaml").write_text(text)
            assert_refused(run("tube", tmp_path, "--out", tmp_path / "out"), part)

    def test_loads_that_are_the_same(self, four):
        (four / "closed.csv").write_bytes((four / "open.csv").read_bytes())
        told = "loads: the two loads, open.csv and closed.csv, are the same: two terminations are needed that differ"
        assert_refused(run("tube", four / "wall.yaml", "--out", four / "out"), told)


RATE = 8192.0


def _of_two(folder, signals=None, *, source="", units=None, more="", name="run.h5"):
    """Write a recording, and a tube file that evaluates it."""
    if signals is not None:
        write_h5(folder / name, signals, RATE, units or {})
    first = f"{{recording: {name}, channels: [a, b]{source}}}"
    (folder / "tube.yaml").write_text(TWO.replace("{file: h12.csv}", first) + more)
    return run("tube", folder, "--out", folder / "out", "--no-figures")


@pytest.fixture
def field():
    """Give the signals of two places, 20 s: the second hears a part of the first, later."""
    far = np.random.default_rng(0).standard_normal(int(20 * RATE))
    return {"a": far, "b": 0.6 * far + 0.5 * np.roll(far, 3)}


class TestUnitsOfChannels:
    def test_alike_but_for_their_size_they_are_converted(self, field, tmp_path):
        assert _of_two(tmp_path, field).status == 0
        plain = table(tmp_path / "out" / "tube.csv")["absorption"]
        for units, factor in ((("Pa", "mPa"), 1e3), (("mV", "Volts"), 1e-3), (("N/m2", "Pa"), 1)):
            signals = {"a": field["a"], "b": factor * field["b"]}
            done = _of_two(tmp_path, signals, units=dict(zip("ab", units, strict=True)))
            assert (done.status, done.err) == (0, "")
            np.testing.assert_allclose(table(tmp_path / "out" / "tube.csv")["absorption"], plain, rtol=1e-9)

    @pytest.mark.parametrize(
        ("units", "part"),
        [
            ({"a": "Pa", "b": "V"}, "run.h5: has channels in Pa, V, whose ratio is no pure number"),
            ({"a": "Pa"}, "in Pa, no unit"),
            ({"a": "EU", "b": "Pa"}, "in EU, Pa"),
        ],
    )
    def test_unlike_units_are_refused(self, field, tmp_path, units, part):
        assert_refused(_of_two(tmp_path, field, units=units), part, "add 'exchanged' or 'calibration'")
        assert not (tmp_path / "out").exists()

    def test_unlike_units_that_an_exchange_takes_out(self, field, tmp_path):
        far, near = field["a"], field["b"]
        assert _of_two(tmp_path, field).status == 0
        plain = table(tmp_path / "out" / "tube.csv")["absorption"]
        in_volts = {"a": "Pa", "b": "V"}
        write_h5(tmp_path / "turned.h5", {"a": near, "b": 0.05 * far}, RATE, in_volts)
        more = "exchanged: {recording: turned.h5, channels: [a, b]}\n"
        done = _of_two(tmp_path, {"a": far, "b": 0.05 * near}, units=in_volts, more=more)
        assert (done.status, done.err) == (0, "")
        np.testing.assert_allclose(table(tmp_path / "out" / "tube.csv")["absorption"], plain, atol=0.02)
        write_h5(tmp_path / "turned.h5", {"a": near, "b": 50 * far}, RATE, {"a": "Pa", "b": "mV"})
        assert_refused(
            _of_two(tmp_path, more=more), "turned.h5: has channels in Pa, mV, and ", "in Pa, V: what corrects"
        )

    def test_unlike_units_of_four_microphones(self, tmp_path):
        rng = np.random.default_rng(0)
        signals = {name: rng.standard_normal(int(4 * RATE)) for name in "abcd"}
        write_h5(tmp_path / "run.h5", signals, RATE, {"a": "Pa", "b": "Pa", "c": "V", "d": "Pa"})
        loads = "loads: [{recording: run.h5, channels: [a, b, c, d]}]"
        (tmp_path / "tube.yaml").write_text(FOUR[: FOUR.index("loads")] + loads)
        assert_refused(run("tube", tmp_path, "--out", tmp_path / "out"), "in Pa, Pa, V, Pa", "add a 'calibration'")


class TestRecordings:
    def test_channels_named_twice(self, field, tmp_path):
        for names in ("a, a", "a, A"):
            source = f", channels: [{names}]"
            write_h5(tmp_path / "run.h5", field, RATE, {})
            text = TWO.replace("{file: h12.csv}", f"{{recording: run.h5{source}}}")
            (tmp_path / "tube.yaml").write_text(text)
            assert_refused(run("tube", tmp_path, "--out", tmp_path / "out"), "run.h5: 'channels' name 'a' twice")

    def test_clipped(self, field, tmp_path):
        field["b"] = np.clip(field["b"], -1.5, 1.5)
        assert_refused(_of_two(tmp_path, field), "run.h5: channel 'b' is clipped: its tops are flat")

    def test_a_rate_that_contradicts_the_file(self, field, tmp_path):
        told = "says that it is sampled at 8192 Hz, but 'sampling_rate' beside 'recording' says 51200 Hz"
        assert_refused(_of_two(tmp_path, field, source=", sampling_rate: 51.2 kHz"), told)
        assert _of_two(tmp_path, source=", sampling_rate: 8192 Hz").status == 0

    def test_channels_that_do_not_start_together(self, field, tmp_path):
        from nptdms import ChannelObject, TdmsWriter

        for late, status in ((0.0, 0), (1 / RATE, 2)):
            times = {"a": 0.0, "b": late}
            with TdmsWriter(str(tmp_path / "run.tdms")) as writer:
                writer.write_segment([
                    ChannelObject("rig", name, data, {"wf_increment": 1 / RATE, "wf_start_offset": times[name]})
                    for name, data in field.items()
                ])  # fmt: skip
            done = _of_two(tmp_path, name="run.tdms")
            assert (done.status, "'b' starts 122.1 us after 'a'" in done.err) == (status, status == 2)

    @pytest.mark.parametrize(
        ("segment", "part"),
        [
            ("20 s", "lasts 20 s: its segments of 20 s, which overlap by half, give 1 average; at least 2 are needed"),
            ("15 s", "give 1 average"),
            ("1 us", "'segment' of 1e-06 s is 0 samples at 8192 Hz; at least 8 are needed"),
        ],
    )
    def test_segments_of_which_spectra_cannot_be_made(self, field, tmp_path, segment, part):
        assert_refused(_of_two(tmp_path, field, source=f", segment: {segment}"), part)

    def test_of_few_averages_the_coherence_is_left_out(self, field, tmp_path):
        """Mere noise has a coherence of 1/5 there."""
        done = _of_two(tmp_path, field, source=", segment: 6 s")
        assert done.status == 0
        assert "warning: " in done.err
        assert "run.h5: lasts 20 s: its segments of 6 s, which overlap by half, give 5 averages" in done.err
        assert "coherence" not in table(tmp_path / "out" / "tube.csv")
        done = _of_two(tmp_path, source=", segment: 4 s")
        assert (done.status, done.err) == (0, "")
        assert "coherence" in table(tmp_path / "out" / "tube.csv")


class TestWhatToMind:
    def test_warnings_stand_in_the_record_also_when_quiet(self, two):
        (two / "tube.yaml").write_text(TWO.replace("100 mm", "100"))
        done = run("tube", two, "--quiet", "--out", two / "out", "--no-figures", "--json")
        assert (done.status, done.err) == (0, "")
        record = json.loads((two / "out" / "tube.json").read_text())
        assert "numbers without a unit are in m: is '100 mm' meant?" in record["warnings"][0]
        assert json.loads(done.out) == record
        assert set(record["spectra"]["tube"]) >= {"absorption", "reflection_re"}

    def test_loads_that_are_nearly_alike(self, four):
        text = (four / "wall.yaml").read_text().replace("calibration", "# calibration")
        (four / "wall.yaml").write_text(text)
        for name, cavity in (("open", 0.4), ("closed", 0.4003)):
            found = np.array(pressures(ASYMMETRIC, cavity)[0])
            write_table(four / f"{name}.csv", FREQUENCY, **dict(zip(("h1", "h2", "h3", "h4"), found, strict=True)))
        done = run("tube", four / "wall.yaml", "--out", four / "out", "--no-figures")
        assert done.status == 0
        assert "loads: the two loads, open.csv and closed.csv, are nearly alike: at " in done.err
        assert "they differ by less than 5 %, and errors of the data grow more than 20-fold" in done.err

    def test_what_rigid_backed_means_is_told(self, four):
        done = run("tube", four / "wall.yaml", "--out", four / "out", "--no-figures")
        assert "before a wall that the sample does not touch" in done.out
        assert "{type: fluid, thickness: 1 um} goes ahead of the wall" in done.out
