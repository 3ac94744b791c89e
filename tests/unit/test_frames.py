"""Results as tables and data sets, and what a notebook shows of them."""

import io
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from multilayer import base_motion, diffuse_field, load_stack, plane_wave, simulate
from multilayer.errors import InputError
from multilayer.frames import html_table, over
from multilayer.layers.fluid import Fluid
from tests.report.reports import fit, joint, stack_fit
from tests.report.test_diagnosis_report import Page

EXAMPLES = Path(__file__).parents[2] / "examples"
F, ANGLES = np.array([100.0, 200.0, 500.0]), np.array([0.0, 30.0])


@pytest.fixture(scope="module")
def stack():
    return load_stack(EXAMPLES / "three_layers.yaml")


@pytest.fixture(scope="module")
def simulation():
    return simulate(EXAMPLES / "double_wall.yaml")


class TestPlaneWave:
    def test_table(self, stack):
        found = plane_wave(stack, F, ANGLES)
        table = found.to_pandas()
        assert list(table.columns[:2]) == ["frequency", "angle"]
        assert table.shape == (6, 7)
        row = table[(table.frequency == 200) & (table.angle == 30)].iloc[0]
        assert row.reflection == found.reflection[1, 1]
        assert row.transmission_loss == found.transmission_loss[1, 1]

    def test_data_set(self, stack):
        found = plane_wave(stack, F, ANGLES)
        data = found.to_xarray()
        assert dict(data.sizes) == {"frequency": 3, "angle": 2}
        assert data.absorption.sel(frequency=500, angle=30) == found.absorption[2, 1]
        assert data.surface_impedance.attrs == {"units": "Pa s/m"}
        assert data.frequency.attrs == {"units": "Hz"}

    def test_samples_have_an_axis(self, stack):
        varied = stack.replaced({"layers.foam.thickness": np.array([0.02, 0.03])[:, None, None]})
        found = plane_wave(varied, F, ANGLES)
        data = found.to_xarray()
        assert data.absorption.dims == ("sample", "frequency", "angle")
        table = found.to_pandas()
        assert len(table) == 12
        assert table.absorption.to_numpy() == pytest.approx(found.absorption.ravel())
        assert table.angle.to_list() == [0.0, 30.0] * 6

    @pytest.mark.parametrize(("frequency", "angle"), [(100.0, 0.0), (F, 0.0), (100.0, ANGLES), (F.reshape(3, 1), 0.0)])
    def test_any_shape(self, stack, frequency, angle):
        found = plane_wave(stack, frequency, angle)
        assert len(found.to_pandas()) == np.size(frequency) * np.size(angle)
        assert found.to_xarray().absorption.shape == found.absorption.shape
        assert "absorption" in repr(found)

    def test_what_is_not_there_is_left_out(self, stack):
        rigid = stack.model_copy(update={"termination": "rigid"})
        assert "transmission" not in plane_wave(rigid, F).to_pandas()

    def test_looks(self, stack):
        text = repr(plane_wave(stack, F, ANGLES))
        first, *rest = text.splitlines()
        assert first == "PlaneWave: 3 of frequency (100 to 500 Hz), 2 of angle (0 to 30 degree)"
        assert rest[0].split()[0] == "reflection"
        page = Page(plane_wave(stack, np.linspace(100, 500, 50))._repr_html_())
        assert page.tags.count("tr") == 14
        assert "frequency / Hz" in page.text
        assert "…" in page.text


def test_diffuse_field_and_base_motion(stack):
    found = diffuse_field(stack, F)
    assert found.to_xarray().attrs == {"max_angle": 78.0}
    assert found.to_pandas().transmission_loss.to_numpy() == pytest.approx(found.transmission_loss)
    motion = base_motion(stack, F)
    assert motion.to_pandas().transmissibility.to_numpy() == pytest.approx(motion.transmissibility)


def test_simulation(simulation):
    data, table = simulation.to_xarray(), simulation.to_pandas()
    assert dict(data.sizes) == {"case": 2, "frequency": 18}
    loss = simulation.cases[1].transmission_loss
    assert data.transmission_loss_db.sel(case=simulation.cases[1].label).to_numpy() == pytest.approx(loss)
    assert data.transmission_loss_db.attrs["units"] == "dB"
    assert table[table.incidence == "diffuse"].transmission_loss_db.to_numpy() == pytest.approx(loss)


def test_fit():
    result, _ = fit("one", "two", rejected=(100.0,))
    table = result.to_pandas()
    written = pd.read_csv(io.StringIO(result.to_csv()))
    assert list(table.columns) == list(written.columns)
    assert table.E2_pa.to_numpy() == pytest.approx(written.E2_pa.to_numpy())
    assert table.accepted.sum() == 28
    assert result.to_xarray().E1_pa.attrs == {"units": "Pa"}
    assert "accepted         28 of 30" in repr(result)


def test_joint_fit():
    table = joint().to_pandas()
    assert table.E1_pa.to_list() == [row["E1_pa"] for row in joint().rows()]
    assert "law fractional_zener" in repr(joint())


def test_stack_fit():
    result = stack_fit()
    table = result.to_pandas().set_index("name")
    assert table.loc["layers.foam.porosity"].value == result.quantity("layers.foam.porosity").value
    curve = result.curves[0].to_xarray()
    assert curve.predicted.to_numpy() == pytest.approx(result.curves[0].predicted)
    assert "converged" in repr(result)


@pytest.mark.parametrize("name", ["pandas", "xarray"])
def test_without_the_package_it_is_said_how_to_get_it(stack, name, monkeypatch):
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(InputError, match=rf"needs {name}: pip install 'multilayer\[frames\]'"):
        getattr(base_motion(stack, F), f"to_{name}")()


def test_frames_need_no_package(stack, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    flat = plane_wave(stack, F, ANGLES).frame.flat()
    assert {len(column) for column in flat.values()} == {6}


def test_stacks_and_layers_show_themselves(stack):
    lines = repr(stack).splitlines()
    assert lines[0] == "Stack of 3 layers, in Ambient(temperature=293.15 K, pressure=101325 Pa)"
    assert lines[-1] == "  behind: ambient"
    assert "thickness=0.025 m, density=87 kg/m^3" in lines[2]
    assert "FractionalZener(relaxed_modulus=80000 Pa" in lines[2]
    page = Page(stack._repr_html_())
    assert page.tags.count("tr") == 5
    assert "base_plate" in page.text
    assert repr(Fluid(thickness=0.05)) == "Fluid(thickness=0.05 m)"
    many = Fluid(thickness=0.05).model_copy(update={"thickness": np.ones((5, 1))})
    assert repr(many) == "Fluid(thickness=array(5, 1) m)"
    assert "fluid at rest" in Page(many._repr_html_()).text


def test_names_are_escaped():
    page = Page(html_table(("<b>",), [("<script>",)], "a & b"))
    assert not {"b", "script"} & set(page.tags)
    assert Page(Fluid(thickness=1.0, name="<b>")._repr_html_()).tags.count("b") == 0


def test_facts_and_coordinates_of_no_axis():
    frame = over({"f": np.array(3.0)}, {"y": np.array(4.0), "z": None}, {"f": "Hz"}, {"who": "me"})
    assert {name: column.tolist() for name, column in frame.flat().items()} == {"f": [3.0], "y": [4.0]}
