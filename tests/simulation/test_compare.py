"""Comparisons: which case, which frequencies, and what is refused before anything is computed."""

import json

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.simulation import load_simulation, simulate
from multilayer.simulation.compare import compare
from multilayer.simulation.measured import Measured
from tests.cli.command import run
from tests.simulation.files import FOAM, PANEL

LAW = "law: fractional_zener, relaxed_modulus: 1 MPa, unrelaxed_modulus: 70 GPa, relaxation_time: 1 ms"
F = np.array([100.0, 200.0, 500.0, 1000.0])


def table(name, values):
    return "\n".join([f"frequency_hz,{name}", *(f"{f!r},{v!r}" for f, v in zip(F.tolist(), values, strict=True)), ""])


def compared(tmp_path, file, measured, *options):
    done = run("compare", file, measured, "--out", tmp_path / "out", "--no-figures", *options)
    record = tmp_path / "out" / "comparison.json"
    return done, json.loads(record.read_text()) if record.exists() else {}


def test_values_are_sought_in_the_best_of_cases_that_look_alike(written, tmp_path):
    laws = "[" + ", ".join(f"{{{LAW}, order: {order}}}" for order in (0.3, 0.7)) + "]"
    text = f"{PANEL}incidence: 60\nfrequency: {F.tolist()}\nsweep: {{layers.plate.young_modulus: {laws}}}\n"
    text = text.replace("thickness: 1 mm", "thickness: 10 mm", 1)
    file = written(text.replace(", loss_factor: 0.01", "", 1))  # laws have losses of their own
    best = simulate(file).cases[1]
    measured = written(table("transmission_loss_db", (best.transmission_loss + 0.1).tolist()), "loss.csv")
    done, record = compared(tmp_path, file, measured)
    assert done.status == 0
    assert {value["case"] for value in record["closest_values"]} == {"plate.young_modulus = {'order': 0.7}"}
    least = min(misfit["rms"] for misfit in record["misfits"])
    assert all(value["rms"] < least for value in record["closest_values"])


class TestFrequenciesWithoutAPrediction:
    """Free waves: below the first there is none."""

    @pytest.fixture
    def file(self, written):
        return written(f"{PANEL}frequency: {F.tolist()}\nfree_waves: true\n")

    def test_are_left_out_and_counted(self, file, written, tmp_path):
        predicted = simulate(file).cases[0].quantities["loss_factor"]
        there = ~np.isnan(predicted)
        assert 0 < np.count_nonzero(there) < len(F)
        measured = written(table("loss_factor", (np.where(there, predicted, 0) + 0.01).tolist()), "loss.csv")
        done, record = compared(tmp_path, file, measured)
        assert done.status == 0
        assert "nan" not in done.out
        missing = len(F) - np.count_nonzero(there)
        assert f"not predicted, left out: loss_factor at {missing} of 4 frequencies" in done.out
        (misfit,) = record["misfits"]
        assert (misfit["rms"], misfit["largest"]) == (pytest.approx(0.01), pytest.approx(0.01))

    def test_alone_are_refused(self, file):
        result = simulate(file)
        nothing = np.where(np.isnan(result.cases[0].quantities["loss_factor"]), 0.01, np.nan)
        with pytest.raises(InputError, match="loss holds loss_factor, and this simulation predicts absorption, "):
            compare(Measured("loss", F, {"loss_factor": nothing}), result)


def test_frequencies_without_a_measurement_are_left_out(written):
    result = simulate(written(f"{FOAM}frequency: {F.tolist()}\ntolerances: {{layers.foam.thickness: 1 mm}}\n"))
    measured = result.cases[0].absorption + np.array([0.001, 0.001, np.nan, 0.001])
    comparison = compare(Measured("tube", F, {"absorption": measured}), result)
    (misfit,) = comparison.misfits
    assert (misfit.rms, misfit.inside) == (pytest.approx(0.001), 1)
    assert comparison.left_out == []


def test_frequencies_without_percentiles_say_nothing_of_what_lies_between_them(written):
    """As where some samples have no free wave."""
    result = simulate(written(f"{FOAM}frequency: {F.tolist()}\ntolerances: {{layers.foam.thickness: 1 mm}}\n"))
    result.cases[0].percentiles["absorption"][:, 1] = np.nan
    comparison = compare(Measured("tube", F, {"absorption": result.cases[0].absorption}), result)
    assert comparison.misfits[0].inside == 1


class TestBeforeAnythingIsComputed:
    @pytest.fixture(autouse=True)
    def _computes_nothing(self, monkeypatch):
        def computed(*arguments):
            raise AssertionError("computed")

        monkeypatch.setattr("multilayer.simulation.run.run", computed)

    def test_the_case_that_does_not_predict_it_is_named(self, written, tmp_path):
        file = written(f"{PANEL}sweep: {{layers.gap.thickness: [1 cm, 2 cm], termination: [ambient, rigid]}}\n")
        done, _ = compared(tmp_path, file, written(table("transmission_loss_db", [5, 6, 7, 8]), "tl.csv"))
        assert (done.status, done.out) == (2, "")
        case = "the case gap.thickness = 1 cm, termination = rigid predicts absorption, "
        assert done.err.startswith(f"{file}: tl holds transmission_loss, and {case}")
        assert "transmission_loss" not in done.err.partition("predicts ")[2]
        assert done.err.endswith("or leave it out of the sweep\n")

    def test_only_one_of_like_cases_is_computed(self, written, tmp_path, monkeypatch):
        thicknesses = ", ".join(f"{i} mm" for i in range(10, 60))
        file = written(f"{PANEL}sweep: {{layers.gap.thickness: [{thicknesses}], incidence: [0, 30, diffuse]}}\n")
        seen = []
        from multilayer.simulation import compare as module

        monkeypatch.setattr(module, "run_task", lambda task, run=module.run_task: seen.append(task) or run(task))
        measured = written(table("reflection_re,reflection_im", [0, 0, 0, 0]).replace(",0\n", ",0,0\n"), "r.csv")
        done, _ = compared(tmp_path, file, measured)
        assert done.status == 2
        assert "the case gap.thickness = 10 mm, incidence = diffuse predicts absorption, transmission_loss" in done.err
        assert len(seen) == 2

    def test_draws_are_refused_with_their_place(self, written, tmp_path):
        file = written(f"{FOAM}tolerances: {{layers.foam.thickness: {{normal: [-1 mm, 0.01 mm]}}}}\n")
        done, _ = compared(tmp_path, file, written(table("absorption", [0.1, 0.2, 0.5, 0.9]), "tube.csv"))
        assert (done.status, done.out) == (2, "")
        assert done.err.startswith(f"{file}:15:13: tolerances: of layers.foam.thickness hardly any draw is allowed (")


def test_several_cases_of_a_table_are_noticed_though_they_look_alike(written, tmp_path):
    laws = "[" + ", ".join(f"{{{LAW}, order: {order}}}" for order in (0.3, 0.7)) + "]"
    file = written(f"{FOAM}frequency: {F.tolist()}\nsweep: {{layers.foam.young_modulus: {laws}}}\n")
    assert run("simulate", file, "--out", tmp_path / "simulated", "--no-figures").status == 0
    done, _ = compared(tmp_path, file, tmp_path / "simulated" / "simulation.csv")
    assert done.status == 2
    assert "holds several cases of a simulation" in done.err
    assert len({case.label for case in load_simulation(file).cases}) == 2
