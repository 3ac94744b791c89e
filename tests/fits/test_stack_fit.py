"""Values, spreads and alternatives that fits of stacks find."""

import re
from dataclasses import replace

import numpy as np
import pytest

from multilayer.errors import PlausibilityWarning
from multilayer.experiments.stacks.file import load_stack_fit
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.fits.stacks.fit import describe, fit_stacks, reweighed
from multilayer.inference.least_squares import minimise
from multilayer.paths import locate, with_values
from multilayer.report.stack_fit import stack_fit_report
from multilayer.response import base_motion, plane_wave
from multilayer.rig import static_shape_factor
from multilayer.stack import load_stack
from tests.fits.stack_fits import (
    IMPEDANCE,
    IN_A_TUBE,
    ON_A_SHAKER,
    PORES,
    WOOL,
    ZENER,
    F,
    changed,
    noisy,
    of_every_kind,
    parts,
    problem,
    stack,
    table,
    tube_table,
    write,
)

KINDS = of_every_kind()
ZENER_AT_F = ON_A_SHAKER.layers[0].young_modulus(F)


class TestFits:
    def test_all_pores_of_a_tube(self, tmp_path):
        nominal = changed(IN_A_TUBE, wool__flow_resistivity=2e4, wool__viscous_length=5e-5)
        path = write(
            tmp_path, nominal, {"tube.csv": tube_table(IN_A_TUBE, size=0.01)}, [IMPEDANCE | {"noise": 0.01}], PORES
        )
        result = fit_stacks(path)
        assert result.converged
        assert result.name == tmp_path.name
        assert result.misfit_per_datum == pytest.approx(1, abs=0.4)
        for quantity in result.quantities:
            truth = locate(IN_A_TUBE, quantity.name).value
            assert quantity.determined
            assert abs(quantity.value - truth) < 3 * quantity.std
            (low, high), wide = quantity.intervals
            assert wide[0] < low < quantity.value < high < wide[1]

    def test_shared_by_two_thicknesses(self, tmp_path):
        thin, thick = IN_A_TUBE, changed(IN_A_TUBE, wool__thickness=0.08)
        measurements = [{**IMPEDANCE, "file": f"{name}.csv", "stack": name} for name in ("thin", "thick")]
        tables = {"thin.csv": tube_table(thin, size=0.02), "thick.csv": tube_table(thick, size=0.02, seed=1)}
        nominal = {"thin": changed(thin, wool__flow_resistivity=2e4), "thick": thick}
        unknowns = {
            "sigma": {
                "paths": ["thin.layers.wool.flow_resistivity", "thick.layers.wool.flow_resistivity"],
                "lognormal": [1e4, 0.5],
            },
            "layers.wool.tortuosity": {"uniform": [1, 2]},
            "thick.layers.wool.thickness": {"normal": ["78 mm", "5 mm"]},
        }
        result = fit_stacks(write(tmp_path, nominal, tables, measurements, unknowns))
        found = {quantity.name: quantity.value for quantity in result.quantities}
        assert found["sigma"] == pytest.approx(1.2e4, rel=0.03)
        assert found["thick.layers.wool.thickness"] == pytest.approx(0.08, rel=0.02)
        assert [curve.stack for curve in result.curves] == ["thin", "thick"]
        both = [result.stacks[name].layers[0] for name in ("thin", "thick")]
        assert {layer.flow_resistivity for layer in both} == {found["sigma"]}
        assert both[0].thickness == 0.04

    def test_a_law_from_three_methods(self, tmp_path):
        """A tube, a shaker and a press would each leave something open; the law is one."""
        nominal = with_values(ON_A_SHAKER, {"layers.foam.young_modulus": 2e5})
        dma, shaken = np.geomspace(1, 50, 12), np.geomspace(200, 3000, 30)
        law = ON_A_SHAKER.layers[0].young_modulus
        motion = base_motion(ON_A_SHAKER, shaken).transmissibility
        tables = {
            "dma.csv": parts("f_hz,e1_pa,e2_pa", dma, law(dma)),
            "shaker.csv": parts("f_hz,transmissibility_re,transmissibility_im", shaken, noisy(motion, 1e-3)),
        }
        factor = static_shape_factor(0.3, 0.0225 / 0.06) * np.pi * 0.0225**2 / 0.03
        measurements = [
            {"kind": "modulus", "layer": "foam", "file": "dma.csv", "noise": 0.02},
            {"kind": "transmissibility", "file": "shaker.csv", "noise": "2 %"},
            {
                "kind": "stiffness", "layer": "foam", "radius": "22.5 mm", "frequency": "0.1 Hz", "noise": 0.01,
                "stiffness": float(law(0.1).real * factor),
            },
        ]  # fmt: skip
        unknowns = {"E": {"paths": "layers.foam.young_modulus", "law": "fractional_zener"}}
        result = fit_stacks(write(tmp_path, nominal, tables, measurements, unknowns))
        assert [q.name for q in result.quantities] == [f"E.{name}" for name in ZENER if name != "law"]
        for quantity in result.quantities:
            assert quantity.value == pytest.approx(ZENER[quantity.name.removeprefix("E.")], rel=0.1)
            assert quantity.determined
        assert result.quantities[2].unit == "s"
        (tmp_path / "fitted.yaml").write_text(result.stack_files()["nominal"])
        assert load_stack(tmp_path / "fitted.yaml").layers[0].young_modulus.law == "fractional_zener"

    def test_lists_and_limits_of_a_law(self, tmp_path):
        tables = {"dma.csv": parts("f_hz,e1_pa,e2_pa", F, ZENER_AT_F)}
        unknowns = {
            "layers.foam.young_modulus": {
                "law": "maxwell", "elements": 3, "bounds": {"relaxation_time": ["1 us", "1 ms"]},
            }
        }  # fmt: skip
        measurement = {"kind": "modulus", "layer": "foam", "file": "dma.csv", "noise": 0.02}
        nominal = with_values(ON_A_SHAKER, {"layers.foam.young_modulus": 2e5})
        made = problem(tmp_path, nominal, tables, [measurement], unknowns)
        found = minimise(made, made.start)
        result = describe(made, [found])
        assert result.curves[0].rms < 0.03 * np.abs(ZENER_AT_F).mean()
        assert len(result.quantities) == 7

    def test_the_gas_of_a_tube(self, tmp_path):
        """Its fields take no arrays: one sample after the other."""
        cold = stack(WOOL, ambient={"temperature": 283.15})
        tables = {"tube.csv": parts("f_hz,reflection_re,reflection_im", F, plane_wave(cold, F).reflection)}
        unknowns = {"ambient.temperature": {"normal": ["20 degC", "8 K"]}}
        measurement = {"kind": "reflection", "file": "tube.csv", "noise": {"absolute": 0.002}}
        made = problem(tmp_path, IN_A_TUBE, tables, [measurement], unknowns)
        assert describe(made, [minimise(made, made.start)]).quantities[0].value == pytest.approx(283.15, abs=0.5)

    def test_an_absolute_impedance_keeps_its_reference(self, tmp_path):
        """Pa s/m are no multiples of the rho c of a gas that is itself sought."""
        cold = stack(WOOL, ambient={"temperature": 283.15})
        tables = {"tube.csv": parts("f_hz,re [Pa s/m],im [Pa s/m]", F, plane_wave(cold, F).surface_impedance)}
        columns = {"real": "re [Pa s/m]", "imag": "im [Pa s/m]"}
        measurement = {**IMPEDANCE, "normalised": False, "columns": columns, "noise": 0.002}
        unknowns = {"ambient.temperature": {"normal": ["20 degC", "8 K"]}}
        made = problem(tmp_path, IN_A_TUBE, tables, [measurement], unknowns)
        z = made.parameters[0].prior.coordinate([283.15])
        assert np.abs(made.residual(z)).max() < 1e-6

    def test_bands(self, tmp_path):
        wide = np.array([250.0, 500.0, 1000.0, 2000.0])
        truth, _, measurement, unknowns = KINDS["transmission loss"]
        one = {**measurement, "file": "wall.csv", "bands": "third octaves"}
        made = problem(tmp_path, truth, {"wall.csv": table("f_hz,tl_db", wide, wide)}, [one], unknowns)
        (observation,) = made.observations
        z = made.parameters[0].prior.coordinate([2e-3])
        (predicted,) = made.predict(z)
        alone = plane_wave(truth, 1000 * 10 ** ((np.arange(21) - 10) / 210), 30.0).transmission_loss
        assert predicted[2] == pytest.approx(-10 * np.log10(np.mean(10 ** (-alone / 10))), abs=1e-9)
        assert observation.points == 84


class TestUncertainty:
    def test_what_no_datum_says_stays_the_prior(self, tmp_path):
        unknowns = {**PORES, "layers.cover.density": {"lognormal": [1.2, 0.3]}}
        truth = stack({"type": "fluid", "name": "cover", "thickness": 1e-7, "density": 1.2, "sound_speed": 343.0}, WOOL)
        made = problem(tmp_path, truth, {"tube.csv": tube_table(truth)}, [IMPEDANCE], unknowns)
        quantity = describe(made, [minimise(made, made.start)]).quantity("layers.cover.density")
        assert not quantity.determined
        assert quantity.left == pytest.approx(1, abs=1e-3)
        assert quantity.std == pytest.approx(1.2 * 0.3, rel=0.1)
        assert quantity.intervals[1] == pytest.approx((1.2 * np.exp(-0.3 * 1.645), 1.2 * np.exp(0.3 * 1.645)), rel=1e-3)

    def test_an_unexplained_residual_widens(self, tmp_path):
        tables = {"tube.csv": tube_table(IN_A_TUBE, size=0.05)}
        results = []
        for noise in (0.05, 0.01):
            made = problem(tmp_path, IN_A_TUBE, tables, [{**IMPEDANCE, "noise": noise}], PORES)
            results.append(describe(made, [minimise(made, made.start)]))
        assert results[1].scale == pytest.approx(5, rel=0.2)
        for right, wrong in zip(*(result.quantities for result in results), strict=True):
            assert wrong.std == pytest.approx(right.std, rel=0.3)

    def test_intervals_hold_the_truth_as_often_as_they_say(self, tmp_path):
        held = 0
        for seed in range(24):
            tables = {"tube.csv": tube_table(IN_A_TUBE, size=0.03, seed=seed)}
            made = problem(tmp_path, IN_A_TUBE, tables, [{**IMPEDANCE, "noise": 0.03}], PORES)
            result = describe(made, [minimise(made, np.zeros(4))])
            truths = [(q.intervals[1], locate(IN_A_TUBE, q.name).value) for q in result.quantities]
            held += sum(low <= value <= high for (low, high), value in truths)
        assert 0.8 < held / (24 * 4) < 0.98

    def test_several_minima_are_told(self, tmp_path):
        """Half a wave more of an undamped gap looks the same at one frequency."""
        gap = stack({"type": "fluid", "name": "gap", "thickness": 0.1})
        f = np.array([1000.0])
        tables = {"tube.csv": parts("f_hz,reflection_re,reflection_im", f, plane_wave(gap, f).reflection)}
        measurement = {"kind": "reflection", "file": "tube.csv", "noise": {"absolute": 0.02}}
        unknowns = {"layers.gap.thickness": {"uniform": ["10 mm", "600 mm"]}}
        result = fit_stacks(write(tmp_path, gap, tables, [measurement], unknowns))
        half = gap.ambient.gas.sound_speed / 1000 / 2
        found = sorted(minimum.values[0] for minimum in result.minima if minimum.misfit < 1e-3)
        assert found == pytest.approx([0.1, 0.1 + half, 0.1 + 2 * half], rel=1e-3)
        assert sum(minimum.probability for minimum in result.minima) == pytest.approx(1)

    def test_errors_that_are_shares_are_those_of_the_fitted_curve(self, tmp_path):
        """As shares of the measured values they draw a fit to values that happen to be small: Peelle's puzzle."""
        f = np.geomspace(200.0, 4000.0, 100)
        alpha, rng = plane_wave(IN_A_TUBE, f).absorption, np.random.default_rng(1)
        smooth = np.linalg.cholesky(np.exp(-np.abs(np.subtract.outer(np.log(f), np.log(f))) / 0.3))
        unknowns = {"layers.wool.flow_resistivity": {"lognormal": [1e4, 0.5]}}
        for errors, off in (
            ({"noise": 0.1}, lambda: rng.standard_normal(len(f))),
            (
                {"noise": {"absolute": 0.005}, "model_error": {"relative": 0.1, "length": 0.3}},
                lambda: smooth @ rng.standard_normal(len(f)),
            ),
        ):
            measurement = {"kind": "absorption", "file": "a.csv", **errors}
            pulls = []
            for _ in range(20):
                values = alpha * (1 + 0.1 * off()) + 0.001 * rng.standard_normal(len(f))
                made = problem(
                    tmp_path, IN_A_TUBE, {"a.csv": table("f_hz,absorption", f, values)}, [measurement], unknowns
                )
                (quantity,) = describe(*reweighed(made, [minimise(made, made.start)])).quantities
                pulls.append((quantity.value - 1.2e4) / quantity.std)
            assert abs(np.mean(pulls)) < 3 / np.sqrt(20), errors
            assert np.std(pulls) == pytest.approx(1, abs=0.5)

    def test_errors_that_are_amounts_stay(self, tmp_path):
        measurement = {**IMPEDANCE, "noise": {"absolute": 0.02}}
        made = problem(tmp_path, IN_A_TUBE, {"tube.csv": tube_table(IN_A_TUBE, size=0.02)}, [measurement], PORES)
        found = minimise(made, made.start)
        again, minima = reweighed(made, [found])
        assert again is made
        assert minima == [found]

    def test_unknowns_that_priors_hold_do_not_widen(self, tmp_path):
        """They take nothing from four data: a misfit of one per datum is by chance."""
        f = np.array([500.0, 1000.0, 2000.0, 4000.0])
        alpha = plane_wave(IN_A_TUBE, f).absorption + 0.02 * np.array([1, -1, -1, 1])
        held = {
            f"layers.wool.{name}": {"normal": [WOOL[name], "0.1 %"]}
            for name in ("thickness", "porosity", "tortuosity", "viscous_length", "thermal_length")
        }
        unknowns = {"layers.wool.flow_resistivity": {"lognormal": [1.2e4, 0.3]}, **held}
        measurement = {"kind": "absorption", "file": "a.csv", "noise": {"absolute": 0.02}}
        made = problem(tmp_path, IN_A_TUBE, {"a.csv": table("f_hz,absorption", f, alpha)}, [measurement], unknowns)
        result = describe(made, [minimise(made, made.start)])
        assert 0.5 < result.misfit_per_datum < 1.5
        assert result.scale == 1
        assert not any("wider" in text for text in result.remarks)

    def test_the_most_probable_minimum_is_told_where_errors_are_widened(self, tmp_path):
        """The lowest one is narrow: with wider errors a flat one beside it is more probable."""
        made = problem(tmp_path, IN_A_TUBE, {"tube.csv": tube_table(IN_A_TUBE)}, [IMPEDANCE], PORES)
        base = minimise(made, made.start)
        whole = np.full(base.residual.size, 3.0)
        lowest = replace(base, residual=whole)
        flat = replace(base, z=base.z + 0.5, residual=1.01 * whole, jacobian=base.jacobian / 2)
        assert lowest.log_evidence > flat.log_evidence
        result = describe(made, [lowest, flat])
        assert result.minima[0].misfit == pytest.approx(flat.misfit)
        assert result.minima[0].probability > 0.5


class TestPriorsThatAreOff:
    """Data that contradict what a prior states by many of its standard deviations."""

    def fit(self, folder, truth, prior, path="layers.wool.thickness"):
        made = changed(IN_A_TUBE, **{path.removeprefix("layers.").replace(".", "__"): truth})
        tables = {"a.csv": table("f_hz,absorption", F, plane_wave(made, F).absorption)}
        measurement = {"kind": "absorption", "file": "a.csv", "noise": {"absolute": 0.005}}
        return fit_stacks(write(folder, IN_A_TUBE, tables, [measurement], {path: prior}))

    @pytest.mark.parametrize(
        ("prior", "told"),
        [
            (
                {"normal": ["40 mm", "1.5 mm"], "nuisance": True},
                r"wool.thickness by 6.6\d standard deviations \(9.9\d mm",
            ),
            ({"lognormal": ["40 mm", 0.03]}, r"wool.thickness by 7.4\d standard deviations \(a factor of 1.25, stated"),
        ],
    )
    def test_are_told(self, tmp_path, prior, told):
        result = self.fit(tmp_path, 0.05, prior)
        (remark,) = [text for text in result.remarks if "states for wrong" in text or "state for wrong" in text]
        assert remark.startswith("this takes what the priors state for wrong, which has the probability")
        assert re.search(told, remark)
        data = result.to_dict()
        assert data["stated_p_value"] < 1e-9
        assert data["stated_deviations"]["layers.wool.thickness"] > 6
        assert stack_fit_report(result).label == "What is stated is off"

    def test_are_no_wall(self, tmp_path):
        """20 standard deviations away."""
        result = self.fit(tmp_path, 0.05, {"normal": ["40 mm", "0.5 mm"]})
        (quantity,) = result.quantities
        assert quantity.value == pytest.approx(0.05, rel=0.01)
        assert quantity.std > 1e-6
        assert all(low < quantity.value < high for low, high in quantity.intervals)

    def test_a_value_lies_in_its_interval_at_the_end_of_the_search(self, tmp_path):
        result = self.fit(tmp_path, 0.06, {"normal": ["40 mm", "0.05 mm"]})
        (quantity,) = result.quantities
        assert re.search(
            r"wool.thickness by 43.\d standard deviations .*, as far as the search goes", str(result.remarks)
        )
        assert all(low <= quantity.value <= high for low, high in quantity.intervals)

    def test_those_that_hold_are_not_doubted(self, tmp_path):
        result = self.fit(tmp_path, 0.041, {"normal": ["40 mm", "1 mm"]})
        assert result.to_dict()["stated_p_value"] > 0.05
        assert not result.remarks
        assert stack_fit_report(result).label == "Fitted"

    def test_of_a_truncated_prior_deviations_are_those_stated(self, tmp_path):
        """Cut at 1, coordinates of a porosity are no numbers of standard deviations; two of these are no wonder."""
        result = self.fit(tmp_path, 0.999, {"normal": [0.98, 0.01], "bounds": [0, 1]}, "layers.wool.porosity")
        data = result.to_dict()
        assert 1 < data["stated_deviations"]["layers.wool.porosity"] <= 2
        assert data["stated_p_value"] > 0.01

    def test_a_value_at_the_end_of_its_prior_is_said_to_be_there(self, tmp_path):
        result = self.fit(tmp_path, 0.05, {"uniform": ["30 mm", "40 mm"]})
        (text,) = result.summary.identifiability.sentences
        assert text.startswith("layers.wool.thickness is at the upper end of its prior, 0.04 m: the data draw it there")


def test_data_given_twice_are_told(tmp_path):
    measurements = [{**IMPEDANCE, "file": f"{name}.csv", "name": name} for name in ("first", "copy", "other")]
    text = tube_table(IN_A_TUBE, size=0.02)
    tables = {"first.csv": text, "copy.csv": text, "other.csv": tube_table(IN_A_TUBE, size=0.02, seed=1)}
    path = write(tmp_path, IN_A_TUBE, tables, measurements, PORES)
    with pytest.warns(PlausibilityWarning, match="holds the same values as 'first': data given twice count") as warned:
        load_stack_fit(path)
    assert len(warned) == 1


def test_a_table_of_stiffnesses(tmp_path):
    law, f = ON_A_SHAKER.layers[0].young_modulus, np.array([1.0, 10.0])
    factor = static_shape_factor(0.3, 0.02 / 0.06) * np.pi * 0.02**2 / 0.03
    tables = {"press.csv": table("f_hz,stiffness [N/mm]", f, law(f).real * factor / 1e3)}
    measurement = {"kind": "stiffness", "layer": "foam", "radius": "20 mm", "file": "press.csv", "noise": 0.01}
    unknowns = {"layers.foam.poisson_ratio": {"uniform": [0, 0.499]}}
    made = problem(tmp_path, ON_A_SHAKER, tables, [measurement], unknowns)
    z = made.parameters[0].prior.coordinate([0.3])
    assert np.abs(made.residual(z)).max() < 0.01
    assert describe(made, [minimise(made, made.start)]).quantities[0].value == pytest.approx(0.3, abs=2e-3)


def test_a_file_in_python(tmp_path):
    path = write(tmp_path, IN_A_TUBE, {"tube.csv": tube_table(IN_A_TUBE)}, [IMPEDANCE], PORES)
    file = load_stack_fit(path.parent)
    assert [unknown.name for unknown in file.resolved] == list(PORES)
    assert StackProblem.of_file(file).start.shape == (4,)
    assert fit_stacks(file, "mine").to_dict()["name"] == "mine"
