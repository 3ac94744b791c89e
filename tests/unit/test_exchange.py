"""Tables for other programs: what they hold, in every format, and what is refused."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.exchange.formats import refuse_unknown_suffix
from multilayer.exchange.quantities import KINDS, Wanted, export
from multilayer.measurements.readers import read_spectra
from multilayer.response import admittance_matrix, diffuse_field, plane_wave, surface_impedance, transfer_matrix
from multilayer.response.bands import band_points, mean_value
from multilayer.simulation.file import SimulationFile
from tests.analytic.materials import FOAM2, SHEET

FOAM = {**FOAM2, "thickness": 0.03}
LAYERS = [{**SHEET, "thickness": 1e-3}, FOAM]
LISTED = {"frequency": [200.0, 457.3, 1234.5, 3000.0]}
SUFFIXES = (".csv", ".mat", ".h5", ".hdf5", ".uff", ".unv")
TWO, THREE = ("angle", (0.0, 60.0)), ("angle", (0.0, 45.0, 75.0))


def simulation(layers: Any = LAYERS, **fields: Any) -> SimulationFile:
    return SimulationFile.model_validate({"layers": layers, "termination": "ambient", **LISTED, **fields})


def columns(file: Path) -> dict[str, tuple[str | None, np.ndarray]]:
    """Return unit and values of the columns of a file, as its reader gives them."""
    table = read_spectra(file)
    numbers = table.numbers(range(len(table.headers)))
    return {header.name: (header.unit, numbers[i]) for i, header in enumerate(table.headers)}


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_one_direction_is_read_back_from_every_format(suffix: str, tmp_path: Path) -> None:
    file, stack = tmp_path / f"trim{suffix}", simulation().stack
    file.write_bytes(export(simulation(), Wanted("transfer_matrix")).content(file))
    result, expected = columns(file), transfer_matrix(stack, LISTED["frequency"])
    assert result["frequency"][1] == pytest.approx(LISTED["frequency"], rel=1e-5)  # of UFF six digits
    for entry, unit in (("11", None), ("12", "Pa s/m"), ("21", "m/Pa/s"), ("22", None)):
        values = expected[..., int(entry[0]) - 1, int(entry[1]) - 1]
        for part, of_part in (("re", values.real), ("im", values.imag)):
            assert result[f"t{entry}_{part}"][1] == pytest.approx(of_part, rel=1e-10)
            assert (result[f"t{entry}_{part}"][0] or None) == unit


@pytest.mark.parametrize("suffix", [".mat", ".h5"])
def test_several_directions_are_arrays_with_their_axes(suffix: str, tmp_path: Path) -> None:
    file = tmp_path / f"trim{suffix}"
    file.write_bytes(export(simulation(), Wanted("admittance_matrix", *TWO)).content(file))
    result, expected = columns(file), admittance_matrix(simulation().stack, LISTED["frequency"], [0, 60])
    for j in range(2):
        assert result[f"y12_{j + 1}_re"][1] == pytest.approx(expected[:, j, 0, 1].real, rel=1e-12)
        assert result[f"y22_{j + 1}_im"][1] == pytest.approx(expected[:, j, 1, 1].imag, rel=1e-12)
    if suffix == ".mat":
        from scipy.io import loadmat

        content = loadmat(file, simplify_cells=True)
        assert content["angle"].tolist() == [0, 60]
        assert content["y11"].shape == (4, 2)
        assert any("both velocities into the layers" in str(text) for text in content["remarks"])
    else:
        h5py = pytest.importorskip("h5py")
        with h5py.File(file) as opened:
            assert opened["angle"][:].tolist() == [0, 60]
            assert opened["angle"].attrs["units"] == "deg"
            assert "both velocities into the layers" in opened.attrs["remarks"]


def test_several_directions_are_blocks_of_rows_of_a_csv(tmp_path: Path) -> None:
    file = tmp_path / "z.csv"
    file.write_bytes(export(simulation(), Wanted("surface_impedance", *THREE)).content(file))
    result, expected = columns(file), surface_impedance(simulation().stack, LISTED["frequency"], THREE[1])
    assert result["angle"][1] == pytest.approx(np.repeat(THREE[1], 4))
    assert result["frequency"][1] == pytest.approx(np.tile(LISTED["frequency"], 3))
    assert result["surface_impedance_im"][1] == pytest.approx(expected.imag.T.ravel(), rel=1e-11)
    assert file.read_text().startswith("# stack: surface_impedance\n# time and trace dependence exp(+i (w t - kx x1))")


def test_several_directions_are_records_of_a_universal_file(tmp_path: Path) -> None:
    pytest.importorskip("pyuff")
    file = tmp_path / "z.uff"
    wanted = Wanted("surface_admittance", "trace_wavenumber", (0.0, 12.5))
    file.write_bytes(export(simulation(), wanted).content(file))
    result = columns(file)
    assert [name for name in result if name.endswith("_re")] == [
        "surface_admittance_at_0_rad/m_re", "surface_admittance_at_12.5_rad/m_re",
    ]  # fmt: skip
    expected = 1 / surface_impedance(simulation().stack, LISTED["frequency"], trace_wavenumber=12.5)
    assert result["surface_admittance_at_12.5_rad/m_re"][1] == pytest.approx(expected.real, rel=1e-10)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("name", ["-1", 'a"b,\n#c', "ä\x1b[2J", "x" * 500, ""])
def test_names_of_stacks_do_no_harm(suffix: str, name: str, tmp_path: Path) -> None:
    file, table = tmp_path / f"z{suffix}", export(simulation(), Wanted("surface_impedance"), name)
    file.write_bytes(table.content(file))
    expected = table.values["surface_impedance"][:, 0]
    assert columns(file)["surface_impedance_re"][1] == pytest.approx(expected.real, rel=1e-10)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_same_values_make_the_same_bytes(suffix: str) -> None:
    table, file = export(simulation(), Wanted("surface_impedance")), Path(f"x{suffix}")
    assert table.content(file) == table.content(file)


def test_absorption_by_angle_and_in_a_diffuse_field() -> None:
    stack = simulation().stack
    by_angle = export(simulation(incidence="diffuse"), Wanted("absorption", *THREE))
    assert by_angle.values["absorption"] == pytest.approx(plane_wave(stack, LISTED["frequency"], THREE[1]).absorption)
    field = export(simulation(incidence={"diffuse": {"max_angle": 90}}), Wanted("absorption"))
    assert field.values["absorption"][:, 0] == pytest.approx(diffuse_field(stack, LISTED["frequency"], 90).absorption)
    assert (field.along, field.remarks[-1][:29]) == ("", "diffuse field up to 90 degree")


def test_octaves_for_room_acoustics() -> None:
    file = simulation([FOAM], termination="rigid", incidence="diffuse", frequency={"octaves": [125, 4000]})
    table = export(file, Wanted("absorption"))
    assert table.frequency.tolist() == [125, 250, 500, 1000, 2000, 4000]
    points = band_points(table.frequency, "octaves")
    each = diffuse_field(file.stack, points.ravel()).absorption.reshape(points.shape)
    assert table.values["absorption"][:, 0] == pytest.approx(mean_value(each), rel=1e-9)
    assert table.remarks[-1].endswith("averages over octaves")


def test_sea_trim_holds_what_there_is() -> None:
    plate = {"layers": LAYERS[:1], "termination": "ambient"}
    table = export(simulation(incidence="diffuse", reference=plate), Wanted("sea_trim"))
    assert [*table.values] == ["absorption", "transmission_loss", "insertion_loss"]
    assert table.units == {"transmission_loss": "dB", "insertion_loss": "dB"}
    losses = [
        diffuse_field(simulation(layers).stack, LISTED["frequency"]).transmission_loss
        for layers in (LAYERS, LAYERS[:1])
    ]
    assert table.values["insertion_loss"][:, 0] == pytest.approx(losses[0] - losses[1])
    assert [*export(simulation(), Wanted("sea_trim")).values] == ["absorption", "transmission_loss"]


def test_what_touches_the_faces_is_said_and_counts() -> None:
    glued = export(simulation([FOAM]), Wanted("admittance_matrix", front="plate"))
    assert glued.remarks[-1].startswith("what touches the front face: a plate that is glued on")
    expected = admittance_matrix(simulation([FOAM]).stack, LISTED["frequency"], faces=("plate", "fluid"))
    assert glued.values["y11"][:, 0] == pytest.approx(expected[:, 0, 0])
    free = export(simulation([FOAM]), Wanted("admittance_matrix"))
    assert np.all(abs(glued.values["y11"] / free.values["y11"] - 1) > 0.01)


REFUSED = {
    "there is no table 'admitance_matrix'; did you mean 'admittance_matrix'": (Wanted("admitance_matrix"), {}),
    "the sweep has 2 cases": (Wanted("absorption"), {"sweep": {"layers.1.thickness": [0.01, 0.02]}}),
    "is complex, and has no mean over octaves; give single": (
        Wanted("transfer_matrix"),
        {"frequency": {"octaves": [125, 500]}},
    ),
    "the incidence is diffuse; give --angle": (Wanted("surface_impedance"), {"incidence": "diffuse"}),
    "needs a half-space behind the stack; write 'termination: ambient'": (Wanted("sea_trim"), {"termination": "rigid"}),
    "waves that come through the gas; give --angle": (Wanted("absorption", "trace_wavenumber", (1.0,)), {}),
    "an angle lies outside the range from 0 to below 90": (Wanted("absorption", "angle", (0.0, 90.0)), {}),
    "leave out --front and --back": (Wanted("absorption", front="plate"), {}),
    "keep their thickness have no impedance matrix": (Wanted("impedance_matrix"), {"layers": LAYERS[:1]}),
    "touches 'wall' is not known": (Wanted("impedance_matrix", back="wall"), {}),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_does_not_exist_is_refused_with_a_remedy(text: str) -> None:
    wanted, fields = REFUSED[text]
    with pytest.raises(InputError, match=text):
        export(simulation(**fields), wanted)


def test_formats_that_are_not_written() -> None:
    with pytest.raises(InputError, match=r"no table is written as '.xlsx'; allowed: .csv, .mat"):
        refuse_unknown_suffix(Path("trim.xlsx"))
    single = export(simulation(frequency=[500.0]), Wanted("surface_impedance"))
    with pytest.raises(InputError, match="needs two frequencies or more"):
        single.content(Path("z.uff"))
    assert single.content(Path("z.csv")).count(b"\n") == 6


@pytest.mark.parametrize(("suffix", "module"), [(".h5", "h5py"), (".uff", "pyuff")])
def test_without_its_library_a_format_says_how_to_install_it(
    suffix: str, module: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(
        InputError, match=rf"'{module}' to be written; install it with: pip install 'multilayer\[formats"
    ):
        export(simulation(), Wanted("surface_impedance")).content(Path(f"z{suffix}"))


def test_too_many_values_are_refused() -> None:
    with pytest.raises(InputError, match="ask for fewer frequencies or directions"):
        export(simulation(frequency={"points": 100_000}), Wanted("absorption", "angle", (0.0,) * 200))


def test_every_kind_has_a_summary() -> None:
    for kind in KINDS.values():
        assert kind.summary
        assert bool(kind.at_faces) != bool(kind.levels)
