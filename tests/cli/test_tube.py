"""``multilayer tube``: raw data of impedance tubes, and what other commands make of the result."""

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import firwin2

from multilayer.response import plane_wave
from tests.analytic.test_impedance_tube import ASYMMETRIC, FREQUENCY, POSITIONS, pressures, stack, thickness
from tests.cli.command import result_names, run
from tests.cli.test_bad_input import assert_refused
from tests.recorders import write_tdms, write_wav

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
        assert result_names(two / "out") == {"tube.csv"}

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
        names = {"tube.csv", "rigid_backed.csv", "transfer_matrix.csv", "tube.png"}
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
