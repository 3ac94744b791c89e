"""Spectra in text and in other formats: the same values from each, wherever a table of measured values may stand."""

import numpy as np
import pytest

from multilayer.csv_table import csv_table, rows_of
from multilayer.errors import InputError
from multilayer.experiments.stacks.columns import read_values
from multilayer.experiments.stacks.measurements import Reflection, TransmissionLoss
from multilayer.measurements.columns import Column, find_columns
from multilayer.measurements.readers import READERS, read_channels, read_spectra
from multilayer.measurements.spectra import Spectra
from multilayer.simulation.measured import read_measured
from multilayer.tables import read_text_table
from multilayer.tube.data import read_transfer
from multilayer.tube.file import Source
from tests.recorders import SPECTRA_WRITERS, write_h5_spectra, write_mat_spectra, write_uff_spectra, write_wav

F = np.arange(100.0, 1300.0, 12.5)
RNG = np.random.default_rng(2)
SPECTRA = {
    "absorption": RNG.uniform(0, 1, F.size),
    "transmission_loss": RNG.uniform(10, 50, F.size),
    "reflection": RNG.normal(size=F.size) + 1j * RNG.normal(size=F.size),
    "h12": RNG.normal(size=F.size) + 1j * RNG.normal(size=F.size),
}
UNITS = {"transmission_loss": "dB"}


@pytest.fixture(params=SPECTRA_WRITERS)
def file(tmp_path, request):
    """Give a file with some spectra, in each format."""
    return SPECTRA_WRITERS[request.param](tmp_path / f"tube.{request.param}", F, SPECTRA, UNITS)


class TestEveryFormat:
    def test_compare(self, file):
        measured = read_measured(file)
        assert set(measured.quantities) == {"absorption", "transmission_loss", "reflection"}
        np.testing.assert_allclose(measured.frequency, F, rtol=1e-9)
        for name, values in measured.quantities.items():
            np.testing.assert_allclose(values, SPECTRA[name], rtol=1e-11)

    def test_fit_of_a_stack(self, file):
        band = {"from": 300, "to": 800, "noise": 0.02}
        loss = read_values(TransmissionLoss.model_validate({"file": file.name, **band}), file.parent)
        inside = (F >= 300) & (F <= 800)
        np.testing.assert_allclose(loss.values, SPECTRA["transmission_loss"][inside], rtol=1e-11)
        columns = {"real": "h12_re", "imag": "h12_im"}
        called = Reflection.model_validate({"file": file.name, "columns": columns, **band})
        np.testing.assert_allclose(read_values(called, file.parent).values, SPECTRA["h12"][inside], rtol=1e-11)

    def test_tube(self, file):
        transfer = read_transfer(Source(file=file.name), file.parent, 2)
        np.testing.assert_allclose(transfer.functions, [np.ones(F.size), SPECTRA["h12"]], rtol=1e-11)

    def test_what_is_not_there_is_told(self, file):
        with pytest.raises(InputError, match=rf"tube{file.suffix}.*: has no column h2_re, .*, h4_im; name the columns"):
            read_transfer(Source(file=file.name), file.parent, 4)
        with pytest.raises(InputError, match="no column holds the insertion_loss; name the columns"):
            read_measured(file, "insertion_loss")


def columns(file, *names):
    return find_columns(read_spectra(file), [Column(name, (name,), None) for name in ("frequency", *names)], "")


class TestArrays:
    def test_frequencies_have_a_unit_and_zero_is_left_out(self, tmp_path):
        f = np.arange(0.0, 1.0, 0.1)
        for write, suffix in ((write_mat_spectra, "mat"), (write_h5_spectra, "h5")):
            path = write(tmp_path / f"a.{suffix}", f, {"alpha": f / 10}, {"frequency": "kHz", "alpha": "%"})
            measured = read_measured(path)
            np.testing.assert_allclose(measured.frequency, 1e3 * f[1:])
            np.testing.assert_allclose(measured.quantities["absorption"], f[1:] / 1000)

    def test_structs_groups_and_tables(self, tmp_path):
        from scipy.io import savemat

        content = {"f": F, "z": np.stack([SPECTRA["h12"], SPECTRA["reflection"]], axis=1), "note": "x", "gain": 2.0}
        savemat(tmp_path / "run.mat", {"tube": content})
        assert set(columns(tmp_path / "run.mat", "z_1_re", "z_2_im")) == {"frequency", "z_1_re", "z_2_im"}
        import h5py

        with h5py.File(tmp_path / "run.h5", "w") as file:
            file["f_kHz"], file["a/alpha"], file["b/alpha"] = F / 1e3, SPECTRA["absorption"], SPECTRA["absorption"]
        table = read_spectra(tmp_path / "run.h5")
        assert table.names == ("frequency", "a/alpha", "b/alpha")
        assert table.rows[0][1][0] == pytest.approx(100)

    def test_complex_numbers_of_matlab_73(self, tmp_path):
        import h5py

        pairs = np.zeros((1, F.size), dtype=[("real", "<f8"), ("imag", "<f8")])
        pairs["real"], pairs["imag"] = SPECTRA["reflection"].real, SPECTRA["reflection"].imag
        with h5py.File(tmp_path / "run.mat", "w", userblock_size=512) as file:
            file["frequency"], file["reflection"] = F[None], pairs
        np.testing.assert_array_equal(
            read_measured(tmp_path / "run.mat").quantities["reflection"], SPECTRA["reflection"]
        )

    @pytest.mark.parametrize(
        ("arrays", "words"),
        [
            ({"alpha": F}, "holds no array called 'frequency'; values over frequency need"),
            ({"frequency": F, "alpha": F[1:]}, "holds no array of 96 values, as 'frequency' has"),
            ({"frequency": F, "f": F, "alpha": F}, "holds several arrays of frequencies: frequency, f; values"),
            ({"frequency": F, "alpha": F, "units": {"frequency": "m"}}, "column 'frequency': '1 m' has the wrong unit"),
            ({"frequency": F - 200, "alpha": F}, "a frequency of -100 Hz is not allowed"),
            ({"frequency": F, "alpha": np.full(F.size, np.nan)}, "'nan' is not finite"),
            ({"frequency": F, "tl": F}, "column 'tl' has no unit; write 'tl_db' or"),
        ],
    )
    def test_what_is_wrong_is_told(self, tmp_path, arrays, words):
        from scipy.io import savemat

        savemat(tmp_path / "run.mat", arrays)
        with pytest.raises(InputError, match=f"run.mat: {words}"):
            read_measured(tmp_path / "run.mat")


class TestUff:
    def test_uneven_frequencies_and_an_abscissa_that_does_not_say(self, tmp_path):
        f = np.geomspace(100.0, 4000.0, 40)
        reflection = np.exp(1j * f / 300)
        path = write_uff_spectra(tmp_path / "t.uff", f, {"reflection": reflection}, {}, 0, abscissa=0, even=False)
        measured = read_measured(path)
        np.testing.assert_allclose(measured.frequency, f, rtol=1e-5)
        np.testing.assert_allclose(measured.quantities["reflection"], reflection, rtol=1e-11)

    def test_time_records_beside_them_are_left_alone(self, tmp_path):
        import pyuff

        path = write_uff_spectra(tmp_path / "t.uff", F, {"alpha": SPECTRA["absorption"]}, {}, 0)
        record = pyuff.prepare_58(
            binary=0, func_type=1, id1="ai0", rsp_node=1, rsp_dir=3, ref_node=1, ref_dir=3, data=np.arange(50.0),
            x=np.arange(50.0), ord_data_type=4, num_pts=50, abscissa_spacing=1, abscissa_min=0.0, abscissa_inc=1e-3,
            abscissa_spec_data_type=17, orddenom_spec_data_type=0,
        )  # fmt: skip
        pyuff.UFF(str(path)).write_sets(record, mode="add")
        assert list(read_measured(path).quantities) == ["absorption"]
        assert read_channels(path).names == ("ai0",)

    def test_units_are_of_numerator_and_denominator(self, tmp_path):
        import pyuff

        def written(above, below):
            record = pyuff.prepare_58(
                binary=0, func_type=4, id1="z", rsp_node=1, rsp_dir=3, ref_node=1, ref_dir=3, x=F, data=SPECTRA["h12"],
                ord_data_type=6, num_pts=F.size, abscissa_spacing=1, abscissa_min=F[0], abscissa_inc=F[1] - F[0],
                abscissa_spec_data_type=18, orddenom_spec_data_type=0,
                ordinate_axis_units_lab=above, orddenom_axis_units_lab=below,
            )  # fmt: skip
            (tmp_path / "z.uff").unlink(missing_ok=True)
            pyuff.UFF(str(tmp_path / "z.uff")).write_sets(record, mode="add")
            return read_spectra(tmp_path / "z.uff").headers[1]

        assert written("kPa", "m/s").factor("Pa*s/m") == pytest.approx(1000)
        assert written("Pa", "Pa").factor("") == 1
        assert written("NONE", "NONE").unit is None
        # of accelerations g is no gram
        assert written("m/s^2", "g").factor("") == pytest.approx(1 / 9.80665)
        assert written("g", "m/s^2").factor("") == pytest.approx(9.80665)

    def test_different_frequencies(self, tmp_path):
        path = write_uff_spectra(tmp_path / "t.uff", F, {"alpha": SPECTRA["absorption"]}, {}, 0)
        text = path.read_text()
        path.write_text(text + write_uff_spectra(path, F + 1, {"tl": SPECTRA["absorption"]}, {}, 0).read_text())
        with pytest.raises(InputError, match="holds functions at different frequencies"):
            read_measured(path)


class TestReaders:
    def test_a_new_format_is_one_function(self, tmp_path):
        def read_raw(path):
            both = np.fromfile(path).reshape(2, -1)
            return Spectra(both[0], {"alpha [%]": both[1]})

        READERS.register("raw", read_raw)
        try:
            np.stack([F, 50 + 0 * F]).tofile(tmp_path / "tube.raw")
            np.testing.assert_allclose(read_measured(tmp_path / "tube.raw").quantities["absorption"], 0.5)
            with pytest.raises(InputError, match=r"tube.raw: is read as values over frequency, and signals over time"):
                read_channels(tmp_path / "tube.raw")
        finally:
            READERS.unregister("raw")

    def test_a_reader_that_gives_other_lengths(self, tmp_path):
        with pytest.raises(InputError, match=r"t.raw: 'alpha' has the shape \(95,\), and the frequencies \(96,\)"):
            Spectra(F, {"alpha": F[1:]}).table(tmp_path / "t.raw")

    def test_signals_over_time_are_no_spectra(self, tmp_path):
        write_wav(tmp_path / "run.wav", {"a": np.ones(50)}, 8000.0)
        with pytest.raises(InputError, match=r"run.wav: is read as signals over time, and values over frequency are"):
            read_measured(tmp_path / "run.wav")
        with pytest.raises(InputError, match=r"none.wav: there is no such file"):
            read_measured(tmp_path / "none.wav")

    @pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16"])
    def test_texts_of_spreadsheets(self, tmp_path, encoding):
        text = 'sep=;\n"Frequency [Hz]";"alpha";"Größe"\n100;0,5;1\n200;0,75;2\n'
        (tmp_path / "tube.csv").write_bytes(text.encode(encoding))
        np.testing.assert_array_equal(read_measured(tmp_path / "tube.csv").quantities["absorption"], [0.5, 0.75])
        assert read_text_table(tmp_path / "tube.csv").names[-1] == "Größe"


@pytest.mark.parametrize(
    ("line", "cells"),
    [
        ('a,"b # c", d # comment', ["a", "b # c", "d"]),
        ('"#1",2,3', ["#1", "2", "3"]),
        ('"say ""x"" #", "y", z', ['say "x" #', "y", "z"]),
        ('5" # x, "y", 6', ['5"']),  # no quoted cell begins there
        ('a # "b", "c"', ["a"]),
        ('a, "b # c', ["a", "b"]),  # not closed
    ],
)
def test_comments_begin_outside_of_quoted_cells(tmp_path, line, cells):
    (tmp_path / "table.csv").write_text(f"x,y,z\n{line}\n")
    (_, found), *_ = read_text_table(tmp_path / "table.csv").rows
    assert [cell.strip() for cell in found] == cells


def test_texts_in_tables_of_ours_are_read_back(tmp_path):
    texts = ["#", "a # b", '"#', 'x,"#"', "'=#1", "=#1", "a;b#", "plain", "-#", ""]
    written = csv_table(["case", "frequency_hz"], [[text, 1.0] for text in texts])
    assert rows_of(written)[1:] == [[text, "1"] for text in texts]
    (tmp_path / "table.csv").write_text(written)
    # quotes at the ends of a cell count as its own marks
    assert read_text_table(tmp_path / "table.csv").text(0) == [text.strip('"') for text in texts]


def test_a_lone_empty_cell_is_a_row():
    assert rows_of(csv_table(["a"], [[""], [None], ["b"]])) == [["a"], [""], [""], ["b"]]
