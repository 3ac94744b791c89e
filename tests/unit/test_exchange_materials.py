"""Materials from other programs' tables."""

import warnings
from pathlib import Path
from typing import Any

import pytest

from multilayer.errors import InputError, PlausibilityWarning
from multilayer.exchange.materials import NAMES, read_materials
from multilayer.layers.base import LAYERS
from multilayer.materials import load_library
from multilayer.stack import Stack
from multilayer.units import field_unit
from tests.cli.command import run

MELAMINE = {
    "type": "poroelastic", "flow_resistivity": 10500.0, "porosity": 0.99, "tortuosity": 1.01, "viscous_length": 1e-4,
    "thermal_length": 2e-4, "frame_density": 9.0, "young_modulus": 160e3, "poisson_ratio": 0.4, "loss_factor": 0.1,
}  # fmt: skip
WAYS = {
    "symbols": "name,sigma [N s/m4],phi,alpha_inf,Lambda [um],Lambda' [um],rho [kg/m3],E [kPa],nu,eta\n"
    "foam,10500,0.99,1.01,100,200,9,160,0.4,0.1\n",
    "greek letters, semicolons, decimal commas": "Material;σ [kN·s/m⁴];φ [%];α∞;Λ [µm];Λ′ [µm];ρ [kg/m³];E [MPa];ν;η\n"
    "foam;10,5;99;1,01;100;200;9;0,16;0,4;0,1\n",
    "words, units in the cells": "material\tresistivity\tporosity\ttortuosity\tviscous characteristic length\t"
    "thermal characteristic length\tbulk density\tYoung's modulus\tPoisson's ratio\tloss factor\n"
    "foam\t10.5 kPa s/m^2\t99 %\t1.01\t0.1 mm\t200 um\t9 kg/m^3\t160 kPa\t0.4\t10 %\n",
    "density of the solid, shear modulus": "id,afr [Pa s/m^2],por,tor,vle [m],tle [m],rho_s [kg/m^3],N [Pa],nu,eta\n"
    "foam,10500,0.99,1.01,1e-4,2e-4,900,57142.857142857,0.4,0.1\n",
}


def write(tmp_path: Path, text: str) -> Path:
    file = tmp_path / "foams.csv"
    file.write_text(text)
    return file


@pytest.mark.parametrize("way", WAYS)
def test_the_same_foam_however_it_is_written(way: str, tmp_path: Path) -> None:
    result = read_materials(write(tmp_path, WAYS[way]))
    fields = dict(result.materials["foam"])
    assert (fields.pop("source"), result.left_out) == ("foams.csv, line 2", ())
    assert fields.pop("type") == "poroelastic"
    assert fields == pytest.approx({key: value for key, value in MELAMINE.items() if key != "type"}, rel=1e-10)


def test_a_library_of_it_makes_layers(tmp_path: Path) -> None:
    result = read_materials(write(tmp_path, WAYS["symbols"]))
    (tmp_path / "ours.yaml").write_text(result.library)
    assert load_library(tmp_path / "ours.yaml") == {"foam": dict(result.materials["foam"])}
    data = {"library": "ours.yaml", "layers": [{"material": "foam", "thickness": 0.03}]}
    stack = Stack.model_validate(data, context={"folder": tmp_path})
    assert stack.layers[0].model_dump(exclude_none=True) == {**MELAMINE, "thickness": 0.03, "model": "jca"}


def test_what_is_given_says_the_type_and_the_model(tmp_path: Path) -> None:
    text = (
        "name,type,model,sigma [N s/m4],phi,tortuosity,lambda [um],lambda' [um],k0' [m2],rho [kg/m3],source\n"
        "rigid,,,10500,0.99,1,100,200,,,\n"
        "limp,,,10500,0.99,1,100,200,,9,a book\n"
        "lafarge,,,10500,0.99,1,100,200,1e-9,,\n"
        "wool,,miki,10500,-,,,,,,\n"
        "held,equivalent_fluid,,10500,0.99,1,100,200,,9,\n"
    )
    result = read_materials(write(tmp_path, text)).materials
    assert {name: (fields["type"], fields.get("model")) for name, fields in result.items()} == {
        "rigid": ("equivalent_fluid", None), "limp": ("limp", None), "lafarge": ("equivalent_fluid", "jcal"),
        "wool": ("equivalent_fluid", "miki"), "held": ("equivalent_fluid", None),
    }  # fmt: skip
    assert result["limp"]["source"] == "a book"


def test_the_density_of_a_solid_is_no_frame_density(tmp_path: Path) -> None:
    head = "name,type,density [kg/m3],E [GPa],nu,eta\n"
    text = f"{head}alu,elastic_solid,2700,70,0.33,0.01\npane,elastic_plate,2500,65,0.2,0\n"
    result = read_materials(write(tmp_path, text))
    (tmp_path / "ours.yaml").write_text(result.library)
    layers = [{"material": name, "thickness": 0.001} for name in ("alu", "pane")]
    stack = Stack.model_validate({"library": "ours.yaml", "layers": layers}, context={"folder": tmp_path})
    assert [(layer.type, layer.density) for layer in stack.layers] == [("elastic_solid", 2700), ("elastic_plate", 2500)]


def test_points_in_names_are_no_decimal_points(tmp_path: Path) -> None:
    text = "name;sigma [kN s/m4];phi;source;model\nBasotect 2.1;10,5;0,99;of 01.02.2024;miki\n"
    assert read_materials(write(tmp_path, text)).materials["Basotect 2.1"]["flow_resistivity"] == 10500


HEAD = "name,sigma [N s/m4],phi,alpha_inf,Lambda [um],Lambda' [um],rho [kg/m3],E [kPa],nu\n"
MISTAKES = {
    "1: no column names the materials; call one of them 'name', 'material'": "sigma,phi\n1,2\n",
    "1: columns 'sigma' and 'resistivity' are both flow_resistivity; keep one": "name,sigma,resistivity\na,1,2\n",
    "2: column 'sigma': 10500 has no unit; call the column 'sigma [N s/m^4]'": "name,sigma\na,10500\n",
    "2: column 'sigma [kg]': '10500 kg' has the wrong unit": "name,sigma [kg]\na,10500\n",
    "2: column 'phi': 'x' is no number": HEAD + "a,1e4,x,1,100,200,9,160,0.4\n",
    "2: column 'nu': 'nan' is no number; leave the cell empty": HEAD + "a,1e4,.9,1,100,200,9,,nan\n",
    "2: column 'nu': '1e400' is no number; leave the cell empty": HEAD + "a,1e4,.9,1,100,200,9,,1e400\n",
    "2: column 'phi': 1.2 is not allowed: it must be below 1": HEAD + "a,1e4,1.2,1,100,200,9,160,0.4\n",
    "3: column 'phi': 1.2 is not allowed": HEAD + "a,1e4,.9,1,100,200,9,160,0.4\nb,1e4,1.2,1,100,200,9,160,0.4\n",
    "2: column 'alpha_inf': is missing; model 'jca' takes porosity": HEAD + "a,1e4,.9,,100,200,9,160,0.4\n",
    "2: column 'nu': is missing": HEAD + "a,1e4,.9,1,100,200,9,160,\n",
    "2: porosity is missing; model 'jca' takes": "name,sigma [N s/m4]\na,1e4\n",
    "3: column 'name': another material is called 'a', in line 2": HEAD + "a,1e4,.9,1,100,200,9,160,0.4\n" * 2,
    "2: column 'name': a material has no name": HEAD + ",1e4,.9,1,100,200,9,160,0.4\n",
    "2: has 10 cells where 9 columns are named": HEAD + "a,1e4,0,9,1,100,200,9,160,0.4\n",
    "2: column 'rho_s [kg/m3]': needs a porosity beside it": "name,rho_s [kg/m3]\na,900\n",
    "2: column 'N [Pa]': young_modulus is given, too": "name,N [Pa],E [Pa],nu\na,1,2,0.3\n",
    "2: column 'type': there is no layer type 'foam'": "name,type\na,foam\n",
    "2: column 'sigma [-]': 10500 has no unit; call the column 'sigma [N s/m^4]'": "name,sigma [-]\na,10500\n",
    "2: column 'sigma [N s/m4]': '10,500' has a comma: decimals follow a point, '10.500', and thousands have no mark, "
    "'10500'": 'name,sigma [N s/m4],phi\na,"10,500",0.9\n',
    "3: column 'r [N s/m4]': '10.500' stands among whole numbers as '900': are these thousands, or decimals? Write "
    "'10500', or '10.5000' for decimals": "name,r [N s/m4],model\na,900,miki\nb,10.500,miki\n",
    "2: column 'density [kg/m3]': -1.0 is not allowed": "name,type,density [kg/m3],E [GPa],nu\n"
    "a,elastic_solid,-1,70,0.3\n",
    "is empty; its first line must name the columns": "",
    "holds no material below its header": HEAD,
}


@pytest.mark.parametrize("told", MISTAKES)
def test_mistakes_are_told_with_line_and_column(told: str, tmp_path: Path) -> None:
    file = write(tmp_path, MISTAKES[told])
    with pytest.raises(InputError) as error:
        read_materials(file)
    assert f"foams.csv:{told}" in str(error.value).replace("csv: ", "csv:")


def test_all_mistakes_are_told_at_once(tmp_path: Path) -> None:
    file = write(tmp_path, HEAD + "a,x,1.2,1,100,200,9,160,0.4\nb,1e4,2,1,100,200,9,160,0.7\n")
    with pytest.raises(InputError) as error:
        read_materials(file)
    assert [problem.line for problem in error.value.problems] == [2, 3, 3]


def test_exchanged_lengths_are_asked_back(tmp_path: Path) -> None:
    file = write(tmp_path, HEAD + "a,1e4,.9,1,200,100,9,160,0.4\n")
    with pytest.warns(
        PlausibilityWarning, match=r"foams.csv:2: column 'Lambda \[um\]': 200 um is above thermal_length"
    ):
        read_materials(file)


def test_the_density_of_the_solid_under_the_wrong_name_is_asked_back(tmp_path: Path) -> None:
    file = write(tmp_path, HEAD + "a,1e4,.98,1,100,200,1200,160,0.4\n")
    with pytest.warns(PlausibilityWarning, match=r"'rho \[kg/m3\]': 1200 kg/m3 .* of 6e\+04 kg/m3; .* column rho_s"):
        read_materials(file)


def test_names_of_columns_are_unambiguous_and_of_fields() -> None:
    names = [name for each in NAMES.values() for name in each]
    assert len(names) == len(set(names))
    assert all(name == "_".join(name.lower().split()) for name in names)
    fields = set(LAYERS["poroelastic"].model_fields)
    assert {key for key in NAMES if key not in fields} == {"source", "note", "solid_density", "shear_modulus"}
    assert field_unit(LAYERS["poroelastic"].model_fields["flow_resistivity"]) == "N*s/m^4"


class TestCommand:
    def table(self, tmp_path: Path) -> Path:
        return write(tmp_path, "name,price,sigma [N s/m4],model\n=foam,3,10500,miki\n")

    def test_lists_writes_and_says_what_is_left_out(self, tmp_path: Path) -> None:
        out = tmp_path / "ours.yaml"
        done = run("materials", "--from", self.table(tmp_path), "--out", out)
        assert done.status == 0
        assert done.err == "remark: column 'price' is no field of a material here, and was left out\n"
        assert done.out.endswith(f"written to {out}: 1 material\n")
        assert (
            run("materials", "--library", out).out.splitlines()[1].startswith("=foam     equivalent_fluid  foams.csv")
        )
        assert run("check", out).status == 0

    def test_a_library_written_by_hand_stays(self, tmp_path: Path) -> None:
        table, out = self.table(tmp_path), tmp_path / "ours.yaml"
        assert [run("materials", "--from", table, "--out", out).status for _ in range(2)] == [0, 0]  # its own
        out.write_text("kind: library\nmaterials: {}\n")
        done = run("materials", "--from", table, "--out", out)
        told = "there is such a file already, and it was not made of a table; choose another --out, or remove it first"
        assert (done.status, done.out, done.err) == (2, "", f"{out}: {told}\n")
        assert out.read_text() == "kind: library\nmaterials: {}\n"

    def test_without_a_file_nothing_is_written(self, tmp_path: Path) -> None:
        done = run("materials", "foam", "--from", self.table(tmp_path), "--json")
        assert '"flow_resistivity": 10500.0' in done.out
        assert [path.name for path in tmp_path.iterdir()] == ["foams.csv"]

    @pytest.mark.parametrize(
        ("options", "told"),
        [
            (("--out", "ours.yaml"), "--out belongs to --from"),
            (("--from", "foams.csv", "--library", "x.yaml"), "two sources of materials"),
            (("foam", "--from", "foams.csv", "--out", "ours.yaml"), "leave out the names"),
            (("--from", "foams.csv", "--out", "ours.csv"), "ours.csv: a library is a YAML file; call it ours.yaml"),
            (("--from", "foam.csv", "--out", "ours.yaml"), "foam.csv: "),
            (("--from", "wrong.csv", "--out", "ours.yaml"), "wrong.csv:2: column 'phi': 2.0 is not allowed"),
        ],
    )
    def test_mistakes(self, options: Any, told: str, tmp_path: Path) -> None:
        self.table(tmp_path)
        (tmp_path / "wrong.csv").write_text("name,phi\na,2\n")
        done = run("materials", *options, cwd=tmp_path)
        assert done.status == 2
        assert told in done.err
        assert "Traceback" not in done.err
        assert not (tmp_path / "ours.yaml").exists()


def test_a_sound_table_gives_no_warning(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_materials(write(tmp_path, WAYS["symbols"]))
