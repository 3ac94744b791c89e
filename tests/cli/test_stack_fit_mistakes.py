"""Mistakes in files of ``multilayer fit`` about stacks."""

import pytest

from tests.cli.command import run
from tests.cli.test_stack_fit import TUBE, UNKNOWNS, tables
from tests.fits.stack_fits import IN_A_TUBE, write

BASE = """version: 1
nominal: nominal.yaml
measurements:
  - {kind: reflection, file: tube.csv, noise: 0.02}
unknowns:
  layers.wool.flow_resistivity: {lognormal: [1e4, 0.5]}
"""
BAD = {
    "no stack": (
        "nominal: nominal.yaml\n",
        "",
        "fit.yaml:1:1: give the stack as 'nominal: FILE', or several as 'stacks",
    ),
    "stack missing": ("nominal.yaml", "no.yaml", "fit.yaml:2:10: nominal: "),
    "no noise": (", noise: 0.02", "", "fit.yaml:4:5: measurements.0: noise: without noise nothing can be weighed"),
    "bad noise": ("0.02", "much", "fit.yaml:4:47: measurements.0.noise: 'much' is no number"),
    "kind": (
        "reflection",
        "reflexion",
        "measurements.0: 'reflexion' is not allowed as 'kind'; allowed: 'surface_impedance',",
    ),
    "field": (
        "noise: 0.02",
        "noise: 0.02, nois: 1",
        "measurements.0.nois: there is no such field; did you mean 'noise'?",
    ),
    "no file": ("tube.csv", "tub.csv", "fit.yaml:4:30: measurements.0.file: "),
    "band": (
        "noise: 0.02",
        "noise: 0.02, from: 2 kHz, to: 500",
        "measurements.0.to: 500 Hz is not allowed: it must not lie",
    ),
    "empty band": (
        "noise: 0.02",
        "noise: 0.02, from: 8 kHz",
        "holds no frequency from 8000 to inf Hz, only from 200 to 4000",
    ),
    "column": ("noise: 0.02", "noise: 0.02, columns: {real: Rel}", "tube.csv:1: no column is called 'Rel'; allowed: "),
    "role": ("noise: 0.02", "noise: 0.02, columns: {rael: Re}", "columns.rael: there is no such column here; allowed:"),
    "normalised": ("reflection", "surface_impedance", "measurements.0.normalised: is missing; it is required"),
    "columns": (
        "reflection",
        "surface_impedance, normalised: true",
        "no columns are known to hold the surface_impedance; say",
    ),
    "no wall behind": (
        "kind: reflection",
        "kind: transmission_loss, columns: {value: 'reflection_re [dB]'}",
        "this stack has no transmission_loss; end it with 'termination: ambient'",
    ),
    "diffuse": ("noise: 0.02", "noise: 0.02, incidence: diffuse", "incidence: a reflection is that of one plane wave"),
    "of which stack": (
        "nominal: nominal.yaml",
        "stacks: {a: nominal.yaml, b: nominal.yaml}",
        "fit.yaml:4:5: measurements.0: stack: of which stack? allowed: a, b",
    ),
    "unused stack": (
        "nominal: nominal.yaml",
        "stacks: {a: nominal.yaml, b: nominal.yaml}\nsearch: {}",
        "stacks.b: no measurement is of this stack; remove it",
    ),
    "path": (
        "wool.flow",
        "wol.flow",
        "fit.yaml:6:3: unknowns.layers.wol.flow_resistivity: layers.wol.flow_resistivity: leads nowhere: there is no",
    ),
    "name without paths": ("layers.wool.flow_resistivity", "sigma", "or give its fields by 'paths'"),
    "unit": (
        "1e4, 0.5",
        "1e4 m, 0.5",
        "fit.yaml:6:46: unknowns.layers.wool.flow_resistivity.lognormal.0: '1e4 m' has the wrong",
    ),
    "spread": ("1e4, 0.5", "1e4, 0", "lognormal: the spread 0 must be above 0"),
    "no spread": ("lognormal: [1e4, 0.5]", "normal: [1e12, 0.01]", "is lost in rounding beside 1e+12"),
    "two priors": (
        "[1e4, 0.5]",
        "[1e4, 0.5], uniform: [1, 2]",
        "give exactly one of normal, lognormal, uniform, loguniform, or",
    ),
    "outside": (
        "flow_resistivity: {lognormal: [1e4, 0.5]}",
        "tortuosity: {uniform: [0.5, 2]}",
        "tortuosity.uniform.0: 0.5 is not allowed: the field may be from 1",
    ),
    "no number": ("flow_resistivity", "type", "layers.wool.type: is no number, and only numbers can be unknown"),
    "left out": ("flow_resistivity", "thermal_permeability", "write a value into the stack file to start from"),
    "two units": (
        "layers.wool.flow_resistivity: {",
        "a: {paths: [layers.wool.thickness, layers.wool.porosity], ",
        "unknowns.a.paths: these fields are in 1 and m; one value cannot be all of them",
    ),
    "twice": (
        "0.5]}\n",
        "0.5]}\n  a: {paths: layers.wool.flow_resistivity, uniform: [1, 2]}\n",
        "unknowns.a: layers.wool.flow_resistivity is that of 'layers.wool.flow_resistivity' already",
    ),
    "no modulus": (
        "{lognormal: [1e4, 0.5]}",
        "{law: zener}",
        "a law takes the place of a modulus, and this field is none",
    ),
    "no unknowns": ("unknowns:\n  layers.wool.flow_resistivity: {lognormal: [1e4, 0.5]}\n", "", "unknowns: is missing"),
}


class TestBadInput:
    def spoiled(self, folder, old, new, text=BASE):
        write(folder, IN_A_TUBE, tables(), [TUBE], UNKNOWNS)
        assert old in text
        (folder / "fit.yaml").write_text(text.replace(old, new, 1))
        return folder / "fit.yaml"

    @pytest.mark.parametrize("name", BAD)
    def test_file(self, tmp_path, name):
        old, new, words = BAD[name]
        if name == "unused stack":
            path = self.spoiled(tmp_path, old, new)
            path.write_text(path.read_text().replace("{kind", "{stack: a, kind"))
        else:
            path = self.spoiled(tmp_path, old, new)
        done = run("fit", path, "--out", tmp_path / "out")
        assert (done.status, done.out) == (2, "")
        assert words in done.err
        assert len(done.err.splitlines()) == 1
        assert not (tmp_path / "out").exists()

    def test_all_at_once(self, tmp_path):
        path = self.spoiled(tmp_path, "unknowns:\n", "unknowns:\n  layers.wool.x: {uniform: [1, 2]}\n")
        path.write_text(path.read_text().replace("[1e4, 0.5]", "[1e4 Pa, 0.5]"))
        done = run("check", path)
        assert done.status == 2
        assert [line.split(": ")[0][-13:] for line in done.err.splitlines()] == ["/fit.yaml:6:3", "fit.yaml:7:46"]

    def test_noise_of_nothing(self, tmp_path):
        path = self.spoiled(tmp_path, "kind: reflection", "kind: absorption")
        (tmp_path / "tube.csv").write_text("f_hz,absorption\n100,0\n200,0.4\n")
        done = run("fit", path)
        assert done.status == 2
        assert "absorption tube: the noise is 0 at 100 Hz; add an absolute one" in done.err

    def test_several_series(self, tmp_path):
        path = self.spoiled(tmp_path, "noise", "noise")
        (tmp_path / "tube.csv").write_text("f_hz,reflection_re,reflection_im\n100,1,0\n200,1,0\n100,1,0\n")
        done = run("fit", path)
        assert done.status == 2
        assert "holds 100 Hz more than once; choose the rows of one series under 'rows'" in done.err

    def test_options_of_a_campaign(self, tmp_path):
        path = self.spoiled(tmp_path, "noise", "noise")
        done = run("fit", path, "--method", "nelder-mead")
        assert done.status == 2
        assert "--method is of the fit of a campaign" in done.err

    def test_beside_others(self, tmp_path):
        path = self.spoiled(tmp_path, "noise", "noise")
        done = run("fit", path, path, "--out", tmp_path / "out")
        assert done.status == 2
        assert "this is a stack-fit file; fit it by itself" in done.err
