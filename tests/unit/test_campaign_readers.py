"""Readers of recordings: the same thing from every format, and bad files told with a remedy."""

import zipfile

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.measurements.npz import read_npz
from multilayer.measurements.readers import READERS, read_waveforms
from multilayer.signals.recording import Recording, Waveforms

RATE = 25600.0
RNG = np.random.default_rng(0)
BASE, TOP = RNG.normal(size=(2, 2, 50)).round(6)


def table(separator=",", header="time,base_1,top_1,base_2,top_2", rate=RATE, digits=9):
    lines = [header.replace(",", separator)]
    for k in range(50):
        row = [f"{k / rate:.{digits}f}", *(f"{x[i, k]:.6f}" for i in range(2) for x in (BASE, TOP))]
        lines.append(separator.join(row))
    return lines


def write(path, lines):
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


class TestRegistry:
    def test_both_formats_give_the_same(self, tmp_path):
        np.savez(tmp_path / "burst.npz", base=BASE, top=TOP)
        write(tmp_path / "burst.csv", table())
        for name in ("burst.npz", "burst.csv"):
            found = read_waveforms(tmp_path / name)
            np.testing.assert_array_equal(found.base, BASE)
            np.testing.assert_array_equal(found.top, TOP)
            assert found.base.dtype == found.top.dtype == np.float64

    def test_suffixes_in_capitals_are_known(self, tmp_path):
        assert read_waveforms(write(tmp_path / "BURST.CSV", table())).base.shape == (2, 50)

    def test_an_unknown_suffix(self, tmp_path):
        with pytest.raises(InputError, match=r"burst.doc: nothing reads '.doc' files; .* .csv, .*.h5, .*.tdms"):
            read_waveforms(tmp_path / "burst.doc")

    @pytest.mark.parametrize("name", ["none.npz", "none.csv"])
    def test_a_missing_file(self, tmp_path, name):
        with pytest.raises(InputError, match=f"{name}: there is no such file"):
            read_waveforms(tmp_path / name)

    def test_a_new_format_is_one_function(self, tmp_path):
        def read_raw(path):
            both = np.fromfile(path).reshape(2, 1, -1)
            return Waveforms(both[0], both[1])

        READERS.register("raw", read_raw)
        try:
            np.stack([BASE[:1], TOP[:1]]).tofile(tmp_path / "burst.raw")
            np.testing.assert_array_equal(read_waveforms(tmp_path / "burst.raw").top, TOP[:1])
        finally:
            READERS.unregister("raw")


class TestNpz:
    def test_one_repeat_may_be_flat_and_single_or_whole_numbers(self, tmp_path):
        path = tmp_path / "burst.npz"
        np.savez(path, base=BASE[0].astype(np.float32), top=np.arange(50))
        found = read_npz(path)
        assert found.base.shape == found.top.shape == (1, 50)
        assert found.sampling_rate is None

    def test_a_sampling_rate_may_stand_beside(self, tmp_path):
        np.savez(tmp_path / "burst.npz", base=BASE, top=TOP, sampling_rate=RATE)
        assert read_npz(tmp_path / "burst.npz").sampling_rate == RATE

    @pytest.mark.parametrize(
        ("arrays", "message"),
        [
            ({"base": BASE}, "has no array 'top'; it must hold 'base' and 'top', and holds: base"),
            ({"a0": BASE, "a1": TOP}, "has no array 'base'.* holds: a0, a1"),
            ({"base": BASE, "top": TOP[:1]}, r"base has shape \(2, 50\) but top \(1, 50\)"),
            ({"base": BASE[:, :0], "top": TOP[:, :0]}, r"array 'base' is empty: its shape is \(2, 0\)"),
            ({"base": BASE + 1j, "top": TOP}, "array 'base' is of type complex128"),
            ({"base": BASE, "top": TOP.astype(str)}, "array 'top' is of type <U"),
            ({"base": BASE > 0, "top": TOP}, "array 'base' is of type bool"),
            ({"base": BASE[None], "top": TOP[None]}, r"array 'base' has shape \(1, 2, 50\)"),
            ({"base": np.float64(1), "top": np.float64(1)}, r"array 'base' has shape \(\)"),
            ({"base": BASE, "top": TOP, "sampling_rate": -1.0}, "sampling_rate must be one number above 0"),
            ({"base": BASE, "top": TOP, "sampling_rate": [1.0, 2.0]}, "sampling_rate must be one number"),
            ({"base": BASE, "top": TOP, "sampling_rate": "fast"}, "sampling_rate must be one number"),
        ],
    )
    def test_bad_arrays(self, tmp_path, arrays, message):
        np.savez(tmp_path / "burst.npz", **arrays)
        with pytest.raises(InputError, match=message) as caught:
            read_npz(tmp_path / "burst.npz")
        assert caught.value.problems[0].file == tmp_path / "burst.npz"

    def test_pickled_objects_are_never_loaded(self, tmp_path):
        np.savez(tmp_path / "burst.npz", base=np.array([{}], dtype=object), top=TOP, allow_pickle=True)
        with pytest.raises(InputError, match=r"cannot be read as an .npz archive"):
            read_npz(tmp_path / "burst.npz")

    @pytest.mark.parametrize("share", [0.0, 0.3, 0.7, 0.98])
    @pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
    def test_truncated(self, tmp_path, share, save):
        path = tmp_path / "burst.npz"
        save(path, base=BASE, top=TOP)
        whole = path.read_bytes()
        path.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(InputError, match=r"burst.npz: is no .npz archive, or one that is cut short"):
            read_npz(path)

    def test_garbage_inside(self, tmp_path):
        path = tmp_path / "burst.npz"
        np.savez_compressed(path, base=BASE, top=TOP)
        damaged = bytearray(path.read_bytes())
        damaged[60:400] = b"\x5a" * 340
        path.write_bytes(bytes(damaged))
        with pytest.raises(InputError, match=r"burst.npz: cannot be read"):
            read_npz(path)

    @pytest.mark.parametrize("content", [b"\x00\x01garbage" * 100, b"time,base,top\n"])
    def test_other_files(self, tmp_path, content):
        (tmp_path / "burst.npz").write_bytes(content)
        with pytest.raises(InputError, match=r"is no .npz archive"):
            read_npz(tmp_path / "burst.npz")

    def test_a_plain_array_file(self, tmp_path):
        np.save(tmp_path / "burst.npy", BASE)
        (tmp_path / "burst.npy").rename(tmp_path / "burst.npz")
        with pytest.raises(InputError, match=r"is no .npz archive"):
            read_npz(tmp_path / "burst.npz")

    def test_an_archive_of_something_else(self, tmp_path):
        with zipfile.ZipFile(tmp_path / "burst.npz", "w") as archive:
            archive.writestr("base", "text")
            archive.writestr("top", "text")
        with pytest.raises(InputError, match=r"burst.npz: "):
            read_npz(tmp_path / "burst.npz")


class TestCsv:
    @pytest.mark.parametrize("separator", [",", ";", "\t", "  ", " ; "])
    def test_separators(self, tmp_path, separator):
        found = read_waveforms(write(tmp_path / "burst.csv", table(separator)))
        np.testing.assert_array_equal(found.base, BASE)
        np.testing.assert_array_equal(found.top, TOP)
        assert found.sampling_rate == pytest.approx(RATE, rel=1e-5)

    def test_one_repeat_in_any_order_with_comments(self, tmp_path):
        lines = ["# a measurement", "", "top,Time,BASE  # the channels"]
        lines += [f"{TOP[0, k]},{k / RATE:.9f},{BASE[0, k]}" for k in range(50)] + ["# end"]
        found = read_waveforms(write(tmp_path / "burst.csv", lines))
        np.testing.assert_array_equal(found.base, BASE[:1])
        np.testing.assert_array_equal(found.top, TOP[:1])

    def test_the_rate_survives_short_times(self, tmp_path):
        """Six decimals at 39.0625 us: single steps are off by 2 %, the rate is not."""
        assert read_waveforms(write(tmp_path / "a.csv", table(digits=6))).sampling_rate == pytest.approx(RATE, rel=1e-3)

    def test_a_byte_order_mark_is_no_column(self, tmp_path):
        path = tmp_path / "burst.csv"
        path.write_bytes(b"\xef\xbb\xbf" + "\r\n".join(table()).encode())
        np.testing.assert_array_equal(read_waveforms(path).base, BASE)

    def test_repeats_are_taken_in_their_order(self, tmp_path):
        header = "time,base_10,top_10,base_2,top_2"
        found = read_waveforms(write(tmp_path / "burst.csv", table(header=header)))
        np.testing.assert_array_equal(found.base, BASE[::-1])

    def test_not_a_number_is_left_to_the_checks(self, tmp_path):
        lines = table()
        lines[10] = lines[10].rsplit(",", 1)[0] + ",nan"
        assert np.isnan(read_waveforms(write(tmp_path / "burst.csv", lines)).top[1, 9])

    @pytest.mark.parametrize(
        ("header", "message"),
        [
            ("time,base_1,top_1,base_2,speed", "1: column 'speed' is not known; name the columns 'time'"),
            ("x,base_1,top_1,base_2,top_2", "1: column 'x' is not known"),
            ("time,base_1,top_1,base_1,top_2", "1: column 'base_1' is there twice"),
            ("time,base_1,top_1,base_2,top_3", "1: has no column top_2, base_3"),
            ("base_3,base_1,top_1,base_2,top_2", "1: has no column top_3"),
            ("0.0,1.0,2.0,3.0,4.0", "1: no line names the columns"),
        ],
    )
    def test_bad_headers(self, tmp_path, header, message):
        with pytest.raises(InputError, match=f"burst.csv:{message}"):
            read_waveforms(write(tmp_path / "burst.csv", table(header=header)))

    def test_time_alone(self, tmp_path):
        with pytest.raises(InputError, match=r"burst.csv:1: has no column base, top"):
            read_waveforms(write(tmp_path / "burst.csv", ["time", "0", "1", "2"]))

    @pytest.mark.parametrize(
        ("line", "text", "message"),
        [
            (7, "1.0,2.0", "7: has 2 cells where 5 columns are named"),
            (7, "0,000195312,1,2,3,4", "7: has 6 cells where 5 columns are named; decimals have a point where commas"),
            (7, "0.000195312,1,2,x,4", "7: 'x' is no number"),
            (7, "0.000195312,1,2,,4", "7: '' is no number"),
            (7, None, "7: time steps by 7.8125e-05 s here and by 3.90625e-05 s elsewhere"),
        ],
    )
    def test_bad_rows(self, tmp_path, line, text, message):
        lines = table()
        lines[line - 1 : line] = [] if text is None else [text]
        with pytest.raises(InputError, match=f"burst.csv:{message}"):
            read_waveforms(write(tmp_path / "burst.csv", lines))

    def test_decimal_commas_of_spreadsheets(self, tmp_path):
        found = read_waveforms(write(tmp_path / "burst.csv", [line.replace(".", ",") for line in table(";")]))
        np.testing.assert_array_equal(found.base, BASE)
        assert found.sampling_rate == pytest.approx(RATE, rel=1e-5)

    def test_time_that_stands_still(self, tmp_path):
        with pytest.raises(InputError, match="time does not rise"):
            read_waveforms(write(tmp_path / "burst.csv", ["time,base,top"] + ["0,1,2"] * 10))

    @pytest.mark.parametrize(("lines", "message"), [([], "is empty"), (["time,base,top", "0,1,2"], "holds 1 rows")])
    def test_too_little(self, tmp_path, lines, message):
        with pytest.raises(InputError, match=message):
            read_waveforms(write(tmp_path / "burst.csv", lines))

    def test_no_text(self, tmp_path):
        (tmp_path / "burst.csv").write_bytes(b"\xff\xfe\x00garbage\xff")
        with pytest.raises(InputError, match="is no text that can be read"):
            read_waveforms(tmp_path / "burst.csv")


class TestRecording:
    def test_shapes_and_mean(self):
        recording = Recording(BASE.astype(np.float32), TOP, RATE)
        assert recording.base.dtype == np.float64
        assert (recording.n_repeats, recording.n_samples) == (2, 50)
        for mean, channel in zip(recording.mean(), (recording.base, recording.top), strict=True):
            np.testing.assert_allclose(mean, channel.mean(axis=0))
        assert recording.time[-1] == pytest.approx(49 / RATE)
        assert Recording(BASE[0], TOP[0], RATE).base.shape == (1, 50)
        np.testing.assert_array_equal(recording.exchanged().base, TOP)

    @pytest.mark.parametrize(
        ("base", "top", "rate", "message"),
        [
            (BASE, TOP[:1], RATE, "both must be"),
            (BASE[:, :0], TOP[:, :0], RATE, "is empty"),
            (BASE, TOP, 0.0, "must be above 0"),
            (BASE[None], TOP[None], RATE, "both must be"),
        ],
    )
    def test_refusals(self, base, top, rate, message):
        with pytest.raises(InputError, match=message):
            Recording(base, top, rate)
