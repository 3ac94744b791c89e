"""Recordings in formats of other programs: the same channels from each, and damaged files told in words."""

import struct
import subprocess
import sys

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.measurements.accelerometers import acceleration_factor, parse_sensitivity, voltage_factor
from multilayer.measurements.readers import read_channels, read_waveforms
from multilayer.signals.channels import refuse_other_starts
from tests.recorders import write_csv, write_h5, write_mat, write_tdms, write_uff, write_wav

RATE = 12800.0
RNG = np.random.default_rng(1)
SIGNALS = {"ai0": RNG.normal(size=300), "ai1": RNG.normal(size=300), "force": RNG.normal(size=300)}
UNITS = {"ai0": "V", "ai1": "m/s^2", "force": None}


def excel(path, channels, rate, units):
    return write_csv(path, channels, rate, units, ";", comma=True)


WRITERS = {
    "tdms": write_tdms, "uff": write_uff, "unv": lambda *a: write_uff(*a, binary=0), "wav": write_wav, "mat": write_mat,
    "h5": write_h5, "csv": write_csv, "txt": lambda *a: write_csv(*a, "\t"),
}  # fmt: skip


@pytest.mark.parametrize(("suffix", "write"), [*WRITERS.items(), ("csv", excel)])
def test_round_trip(tmp_path, suffix, write):
    found = read_channels(write(tmp_path / f"run.{suffix}", SIGNALS, RATE, UNITS))
    wav = suffix == "wav"
    assert found.names == (("channel_1", "channel_2", "channel_3") if wav else tuple(SIGNALS))
    for channel, (name, signal) in zip(found.channels, SIGNALS.items(), strict=True):
        np.testing.assert_allclose(channel.samples, signal, rtol=1e-6 if wav else 1e-11)
        assert channel.sampling_rate == pytest.approx(RATE, rel=1e-9)
        assert channel.unit == (None if wav else UNITS[name])


def test_channels_are_found_in_capitals_or_not_and_listed_where_they_are_not(tmp_path):
    found = read_channels(write_tdms(tmp_path / "run.tdms", SIGNALS, RATE, UNITS))
    assert found["AI1"] is found["ai1"]
    text = r"run.tdms: has no channel 'ai9'; it holds: 'ai0' \(V, 12800 Hz, 300 samples\), .*'force' \(no unit, 12800"
    with pytest.raises(InputError, match=text):
        found["ai9"]


def test_a_burst_of_a_campaign_may_be_in_any_format(tmp_path):
    pair = {"base": SIGNALS["ai0"], "top": SIGNALS["ai1"]}
    found = read_waveforms(write_tdms(tmp_path / "burst.tdms", pair, RATE, {"base": "g", "top": "m/s^2"}))
    np.testing.assert_allclose(found.base, 9.80665 * SIGNALS["ai0"][None])
    np.testing.assert_allclose(found.top, SIGNALS["ai1"][None])
    with pytest.raises(InputError, match=r"channel 'base' is in V, which is no acceleration; .*multilayer import"):
        read_waveforms(write_tdms(tmp_path / "volts.tdms", pair, RATE, {"base": "V"}))
    with pytest.raises(InputError, match="channel 'ai0' is not known; name the channels"):
        read_waveforms(write_tdms(tmp_path / "others.tdms", SIGNALS, RATE, UNITS))


def test_commas_in_one_column_and_points_in_another(tmp_path):
    (tmp_path / "run.csv").write_text("time;base\n0.000;1,230\n0.001;1,231\n0.002;1,232\n")
    with pytest.raises(InputError, match=r"run.csv:2: '1,230' has a comma, and '0\.000' in line 2 a point"):
        read_channels(tmp_path / "run.csv")


class TestTdms:
    def test_groups_tell_channels_of_one_name_apart(self, tmp_path):
        from nptdms import ChannelObject, TdmsWriter

        with TdmsWriter(str(tmp_path / "run.tdms")) as writer:
            writer.write_segment([ChannelObject(group, "ai0", SIGNALS["ai0"]) for group in ("slow", "fast")])
        found = read_channels(tmp_path / "run.tdms")
        assert found.names == ("fast/ai0", "slow/ai0")
        assert found.channels[0].sampling_rate is None

    def test_a_common_start(self, tmp_path):
        pair = {"base": SIGNALS["ai0"], "top": SIGNALS["ai1"]}
        now = np.datetime64("2026-01-01T00:00:00.000000")
        starts, times = {"base": 0.5, "top": 0.4}, {"base": now, "top": now + np.timedelta64(100, "ms")}
        found = read_channels(write_tdms(tmp_path / "run.tdms", pair, RATE, {}, starts=starts, times=times))
        assert [channel.start for channel in found.channels] == pytest.approx([0.5, 0.5])
        refuse_other_starts(found, found.channels)
        read_waveforms(tmp_path / "run.tdms")
        found = read_channels(write_tdms(tmp_path / "run.tdms", pair, RATE, {}, times={"base": now}))
        assert [channel.start for channel in found.channels] == [0, None]
        assert read_channels(write_tdms(tmp_path / "run.tdms", pair, RATE, {})).channels[0].start is None

    @pytest.mark.parametrize("how", ["offsets", "times"])
    def test_other_starts(self, tmp_path, how):
        pair, now = {"base": SIGNALS["ai0"], "top": SIGNALS["ai1"]}, np.datetime64("2026-01-01T00:00:00.000000")
        told = (
            {"starts": {"base": 0.0, "top": 5e-4}}
            if how == "offsets"
            else {"times": {"base": now, "top": now + np.timedelta64(500, "us")}}
        )
        path = write_tdms(tmp_path / "run.tdms", pair, RATE, {}, **told)
        with pytest.raises(InputError, match=r"run.tdms: 'top' starts 500 us after 'base'; export all channels on a "):
            read_waveforms(path)


class TestUff:
    def test_other_starts(self, tmp_path):
        pair = {"base": SIGNALS["ai0"], "top": SIGNALS["ai1"]}
        path = write_uff(tmp_path / "run.uff", pair, RATE, {}, binary=0, starts={"base": 0.25})
        assert [channel.start for channel in read_channels(path).channels] == [0.25, 0]
        with pytest.raises(InputError, match=r"run.uff: 'top' starts 250 ms before 'base'"):
            read_waveforms(path)

    def test_records_without_a_name_are_called_by_their_place(self, tmp_path):
        nameless = {"NONE": SIGNALS["ai0"]}
        assert read_channels(write_uff(tmp_path / "run.uff", nameless, RATE, {})).names == ("1+Z",)

    def test_the_step_has_six_digits(self, tmp_path):
        for rate in (44100.0, 51200.0, 65536.0):
            found = read_channels(write_uff(tmp_path / "run.uff", {"a": SIGNALS["ai0"]}, rate, {}))
            assert found.channels[0].sampling_rate == rate


class TestWav:
    @pytest.mark.parametrize("kind", [np.int16, np.int32, np.uint8])
    def test_whole_numbers_are_shares_of_full_scale(self, tmp_path, kind):
        from scipy.io import wavfile

        limits = np.iinfo(kind)
        data = np.array([limits.min, limits.max // 2 + limits.min // 2 + 1, limits.max] * 2, dtype=kind)
        wavfile.write(tmp_path / "run.wav", 8000, data)
        found = read_channels(tmp_path / "run.wav").channels[0].samples
        assert found[:3] == pytest.approx([-1, 0, 1], abs=0.02)


class TestArrays:
    def test_time_gives_the_rate_and_tables_their_columns(self, tmp_path):
        from scipy.io import savemat

        time = np.arange(300) / RATE
        savemat(tmp_path / "run.mat", {"t": time, "data": np.stack([SIGNALS["ai0"], SIGNALS["ai1"]], axis=1)})
        found = read_channels(tmp_path / "run.mat")
        assert found.names == ("data_1", "data_2")
        assert found["data_2"].sampling_rate == RATE
        np.testing.assert_array_equal(found["data_2"].samples, SIGNALS["ai1"])

    def test_structs(self, tmp_path):
        from scipy.io import savemat

        savemat(tmp_path / "run.mat", {"rig": {"ai0": SIGNALS["ai0"], "fs": RATE}})
        assert read_channels(tmp_path / "run.mat")["rig/ai0"].sampling_rate == RATE

    def test_each_group_has_its_rate(self, tmp_path):
        import h5py
        from scipy.io import savemat

        x, time = SIGNALS["ai0"], np.arange(300) / RATE
        savemat(
            tmp_path / "run.mat",
            {
                "slow": {"ai0": x, "fs": 100.0}, "timed": {"ai0": x, "t": time}, "deep": {"in": {"ai0": x}, "dt": 0.5},
                "ai0": x, "fs": 7.0,
            },
        )  # fmt: skip
        found = read_channels(tmp_path / "run.mat")
        rates = {channel.name: channel.sampling_rate for channel in found.channels}
        assert rates == {"slow/ai0": 100, "timed/ai0": RATE, "deep/in/ai0": 2, "ai0": 7}
        with h5py.File(tmp_path / "run.h5", "w") as file:
            for name, rate in (("a", 100.0), ("b", 200.0)):
                file.create_group(name).attrs["fs"] = rate
                file[name]["ai0"] = x
        found = read_channels(tmp_path / "run.h5")
        assert [channel.sampling_rate for channel in found.channels] == [100, 200]

    def test_rates_that_differ(self, tmp_path):
        from scipy.io import savemat

        x = SIGNALS["ai0"]
        savemat(tmp_path / "run.mat", {"ai0": x, "info": {"fs": 100.0}, "more": {"dt": 0.01}})
        assert read_channels(tmp_path / "run.mat")["ai0"].sampling_rate == 100
        for arrays in ({"info": {"fs": 100.0}, "more": {"fs": 200.0}}, {"fs": 100.0, "t": np.arange(300) / 200}):
            savemat(tmp_path / "run.mat", {"ai0": x, **arrays})
            with pytest.raises(InputError, match=r"different sampling rates for 'ai0': 100 Hz by '.*fs', 200 Hz by '"):
                read_channels(tmp_path / "run.mat")

    def test_units_of_rates_and_times(self, tmp_path):
        import h5py
        from scipy.io import savemat

        x = SIGNALS["ai0"]
        for name, value, unit in (("fs", 12.8, "kHz"), ("dt", 1000 / RATE, "ms"), ("fs", 12800.0, "samples/s")):
            savemat(tmp_path / "run.mat", {"ai0": x, name: value, "units": {name: unit}})
            assert read_channels(tmp_path / "run.mat")["ai0"].sampling_rate == pytest.approx(RATE)
        with h5py.File(tmp_path / "run.h5", "w") as file:
            file["ai0"], file["time"] = x, 1000 * np.arange(300) / RATE + 5
            file["time"].attrs["units"] = "ms"
        found = read_channels(tmp_path / "run.h5")["ai0"]
        assert (found.sampling_rate, found.start) == (RATE, pytest.approx(0.005))
        savemat(tmp_path / "run.mat", {"ai0": x, "fs": 12.8, "units": {"fs": "V"}})
        with pytest.raises(InputError, match=r"run.mat: column 'fs': '1 V' has the wrong unit"):
            read_channels(tmp_path / "run.mat")

    def test_packed_numbers(self, tmp_path):
        import h5py

        with h5py.File(tmp_path / "run.h5", "w") as file:
            file["ai0"] = np.arange(300, dtype="i2")
            file["ai0"].attrs.update({"scale_factor": 0.5, "add_offset": np.array([-1.0])})
        np.testing.assert_array_equal(read_channels(tmp_path / "run.h5")["ai0"].samples, 0.5 * np.arange(300) - 1)
        with h5py.File(tmp_path / "run.h5", "a") as file:
            file["ai0"].attrs["scale_factor"] = [1.0, 2.0]
        with pytest.raises(InputError, match="'ai0' has a scale_factor or add_offset that is no single number"):
            read_channels(tmp_path / "run.h5")

    def test_matlab_73_is_hdf5(self, tmp_path):
        whole = write_h5(tmp_path / "run.h5", SIGNALS, RATE, UNITS).read_bytes()
        import h5py

        with h5py.File(tmp_path / "run.mat", "w", userblock_size=512) as file:
            file["ai0"], file["fs"] = SIGNALS["ai0"], RATE
            file["note"] = np.array([104, 105, 33], dtype=np.uint16)
            file["note"].attrs["MATLAB_class"] = b"char"
        found = read_channels(tmp_path / "run.mat")
        assert (found.names, found["ai0"].sampling_rate) == (("ai0",), RATE)
        assert whole[:4] == b"\x89HDF"

    def test_datasets_may_have_rates_of_their_own(self, tmp_path):
        import h5py

        with h5py.File(tmp_path / "run.h5", "w") as file:
            for name, rate in (("fast", 51200.0), ("slow", 10.0)):
                file[name] = SIGNALS["ai0"]
                file[name].attrs["sampling_rate"] = rate
        found = read_channels(tmp_path / "run.h5")
        assert (found["fast"].sampling_rate, found["slow"].sampling_rate) == (51200.0, 10.0)

    @pytest.mark.parametrize("damage", [(1, 0x1E), (1, 0x10), (19, 0xFF)], ids=["no type", "a list", "4 GB of text"])
    def test_damaged_texts_neither_crash_nor_fill_the_memory(self, tmp_path, damage):
        file = write_h5(tmp_path / "run.h5", {"ai0": SIGNALS["ai0"]}, RATE, {"ai0": "V"})
        raw, (offset, byte) = bytearray(file.read_bytes()), damage
        kind = raw.index(b"\x19\x01\x01\x00\x10")  # texts of any length, as ASCII or UTF-8, and what follows
        at = kind + offset if offset == 1 else raw.index(b"\1\0\0\0", kind + 24) + 3
        raw[at] = byte
        file.write_bytes(raw)
        code = f"from multilayer.measurements.readers import read_channels as r; r({str(file)!r})"
        # not ru_maxrss, which starts from the memory of the tests' process
        code += "\nlines = [line.split() for line in open('/proc/self/status')]"
        code += "\nassert next(int(line[1]) for line in lines if line[0] == 'VmHWM:') < 1e6"
        done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True)
        assert done.returncode in (0, 1), done
        assert done.returncode == 0 or "cannot be read as an HDF5 file" in done.stderr

    def test_a_piece_without_its_checksum(self, tmp_path):
        import h5py

        with h5py.File(tmp_path / "run.h5", "w") as file:
            data = file.create_dataset("ai0", data=SIGNALS["ai0"], chunks=True, fletcher32=True)
            size = struct.pack("<I", data.id.get_chunk_info(0).size)
        raw = (tmp_path / "run.h5").read_bytes()
        at = raw.index(size, raw.index(b"TREE\1"))
        (tmp_path / "run.h5").write_bytes(raw[:at] + bytes(4) + raw[at + 4 :])
        with pytest.raises(InputError, match="a piece of its numbers is empty"):
            read_channels(tmp_path / "run.h5")

    @pytest.mark.parametrize("kind", ["external", "virtual"])
    def test_numbers_of_other_files(self, tmp_path, kind):
        import h5py

        (tmp_path / "secret.bin").write_bytes(bytes(8 * 300))
        with h5py.File(tmp_path / "run.h5", "w") as file:
            file["ai1"] = SIGNALS["ai0"]
            if kind == "external":
                file.create_dataset("ai0", (300,), "f8", external=[(str(tmp_path / "secret.bin"), 0, 2400)])
            else:
                layout = h5py.VirtualLayout((300,), "f8")
                layout[:] = h5py.VirtualSource(str(tmp_path / "other.h5"), "ai0", (300,))
                file.create_virtual_dataset("ai0", layout)
            file["elsewhere"] = h5py.ExternalLink("other.h5", "/ai0")
        with pytest.raises(InputError, match="'ai0' takes its numbers from other files, which are not read"):
            read_channels(tmp_path / "run.h5")

    def test_uneven_times(self, tmp_path):
        from scipy.io import savemat

        savemat(tmp_path / "run.mat", {"time": np.arange(300.0) ** 1.01, "ai0": SIGNALS["ai0"]})
        with pytest.raises(InputError, match="times does not rise in even steps"):
            read_channels(tmp_path / "run.mat")


class TestText:
    @pytest.mark.parametrize(
        "text",
        [
            "Recorder 7;\nDate;01.02.2024\n\nZeit [ms];ai0 [V];ai1 [g]\n0;1,5;-2\n0,5;2,5;-3e0\n1;3,5;-4\n",
            'sep=;\n"time";"ai0";"ai1"\n"s";"V";"g"\n0;1,5;-2\n0,0005;2,5;-3\n0,001;3,5;-4\n',
            "time\tai0 (V)\tai1 (g)\n0\t1.5\t-2\n0.0005\t2.5\t-3\n0.001\t3.5\t-4\n",
            "time_ms;ai0 [V];ai1 [g];\n0;1,5;-2;\n0,5;2,5;-3;\n1;3,5;-4;\n",
        ],
    )
    @pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16"])
    def test_what_spreadsheets_and_recorders_write(self, tmp_path, text, encoding):
        (tmp_path / "run.csv").write_bytes(text.replace("\n", "\r\n").encode(encoding))
        found = read_channels(tmp_path / "run.csv")
        assert [(one.name, one.unit, one.sampling_rate) for one in found.channels] == [
            ("ai0", "V", 2000.0),
            ("ai1", "g", 2000.0),
        ]
        np.testing.assert_array_equal(found["ai0"].samples, [1.5, 2.5, 3.5])
        np.testing.assert_array_equal(found["ai1"].samples, [-2, -3, -4])

    def test_a_single_column_with_decimal_commas(self, tmp_path):
        (tmp_path / "run.txt").write_text("ai0 [V]\n0,5\n0,25\n-1,5\n")
        found = read_channels(tmp_path / "run.txt")
        np.testing.assert_array_equal(found["ai0"].samples, [0.5, 0.25, -1.5])
        assert found["ai0"].sampling_rate is None

    def test_latin_letters_of_spreadsheets(self, tmp_path):
        (tmp_path / "run.csv").write_bytes("Zeit [s];Beschl. [m/s²]\n0;1\n1;2\n2;3\n".encode("cp1252"))
        assert acceleration_factor(read_channels(tmp_path / "run.csv")["Beschl."].unit) == 1.0

    def test_a_wrong_cell_has_its_line(self, tmp_path):
        (tmp_path / "run.csv").write_text("note\ntime;a\n0;1\n1;2\n2;x\n")
        with pytest.raises(InputError, match=r"run.csv:5: 'x' is no number"):
            read_channels(tmp_path / "run.csv")

    def test_a_wrong_unit_of_time(self, tmp_path):
        (tmp_path / "run.csv").write_text("time [V];a\n0;1\n1;2\n2;3\n")
        with pytest.raises(InputError, match=r"run.csv:1: 'V' is no unit of time"):
            read_channels(tmp_path / "run.csv")


@pytest.mark.parametrize("suffix", ["tdms", "uff", "wav", "mat", "h5"])
class TestDamaged:
    def test_cut_short(self, tmp_path, suffix):
        path = WRITERS[suffix](tmp_path / f"run.{suffix}", SIGNALS, RATE, UNITS)
        whole = path.read_bytes()
        for share in (0.02, 0.4, 0.9):
            path.write_bytes(whole[: int(share * len(whole))])
            with pytest.raises(InputError, match=f"run.{suffix}: .*(cut short|no channel|no samples)"):
                read_channels(path)

    @pytest.mark.parametrize("content", [b"", b"time,base,top\n0,1,2\n" * 99, bytes(range(256)) * 9])
    def test_of_another_kind(self, tmp_path, suffix, content):
        (tmp_path / f"run.{suffix}").write_bytes(content)
        with pytest.raises(InputError, match=f"run.{suffix}: cannot be read as an? .* not what its suffix says"):
            read_channels(tmp_path / f"run.{suffix}")


@pytest.mark.parametrize(("suffix", "module"), [("tdms", "nptdms"), ("uff", "pyuff"), ("h5", "h5py")])
def test_a_library_that_is_not_installed(tmp_path, monkeypatch, suffix, module):
    path = WRITERS[suffix](tmp_path / f"run.{suffix}", SIGNALS, RATE, UNITS)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(InputError, match=rf"needs the package '{module}' .*pip install 'multilayer\[formats\]'"):
        read_channels(path)


class TestUnits:
    @pytest.mark.parametrize(
        ("unit", "factor"),
        [
            *((unit, 1) for unit in ("m/s^2", "m/s²", "m/s2", "ms-2", "m s-2", "m/s/s")),
            ("g", 9.80665),
            ("50 g", 490.3325),
        ],
    )
    def test_accelerations(self, unit, factor):
        assert acceleration_factor(unit) == pytest.approx(factor)
        assert voltage_factor(unit) is None

    @pytest.mark.parametrize(("unit", "factor"), [("V", 1), ("mV", 1e-3), ("Volts", 1), ("10 V", 10)])
    def test_voltages(self, unit, factor):
        assert voltage_factor(unit) == pytest.approx(factor)
        assert acceleration_factor(unit) is None

    @pytest.mark.parametrize(
        ("text", "value"),
        [
            ("10.2mV/g", 0.0102 / 9.80665),
            ("10.2 mV/g", 0.0102 / 9.80665),
            ("1.04 mV/(m/s2)", 1.04e-3),
            ("1.04 mV/(m/s²)", 1.04e-3),
            ("1.04 mV/ms-2", 1.04e-3),
            ("0.1 V/g", 0.1 / 9.80665),
        ],
    )
    def test_sensitivities(self, text, value):
        assert parse_sensitivity(text) == pytest.approx(value)

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("0 mV/g", "must be above 0"),
            ("-10 mV/g", "must be above 0"),
            ("10.2", "no sensitivity with a unit"),
            ("mV/g", "no sensitivity with a unit"),
            ("10 mV/Pa", "no sensitivity of an accelerometer"),
            ("10 g/mV", "no sensitivity of an accelerometer"),
        ],
    )
    def test_wrong_sensitivities(self, text, message):
        with pytest.raises(ValueError, match=message):
            parse_sensitivity(text)
