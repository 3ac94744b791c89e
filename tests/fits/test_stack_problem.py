"""Stacks and measurements as an inverse problem."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.experiments.stacks import problem as stack_problem
from multilayer.experiments.stacks.responses import shape_factor
from multilayer.fits.stacks.fit import describe
from multilayer.inference.derivative import central
from multilayer.inference.least_squares import minimise
from multilayer.paths import locate
from multilayer.response import plane_wave
from multilayer.rig import static_shape_factor
from tests.fits.stack_fits import (
    IMPEDANCE,
    IN_A_TUBE,
    IN_A_WALL,
    ON_A_SHAKER,
    PORES,
    F,
    of_every_kind,
    parts,
    problem,
    table,
    tube_table,
)

KINDS = of_every_kind()


@pytest.mark.parametrize("kind", KINDS)
class TestKinds:
    def make(self, kind, folder):
        truth, text, measurement, unknowns = KINDS[kind]
        one = {"noise": 0.02, "file": "data.csv", **measurement}
        return truth, problem(folder, truth, {"data.csv": text}, [one], unknowns)

    def test_the_truth_leaves_nothing(self, kind, tmp_path):
        truth, made = self.make(kind, tmp_path)
        (parameter,) = made.parameters
        z = parameter.prior.coordinate([locate(truth, parameter.name).value])
        assert np.abs(made.residual(z)).max() < 1e-6

    def test_is_found_from_elsewhere(self, kind, tmp_path):
        truth, made = self.make(kind, tmp_path)
        (parameter,) = made.parameters
        found = minimise(made, np.array([0.3]))
        wanted = locate(truth, parameter.name).value
        assert describe(made, [found]).quantities[0].value == pytest.approx(wanted, rel=0.02)

    def test_many_at_once_as_one_by_one(self, kind, tmp_path):
        _, made = self.make(kind, tmp_path)
        z = np.array([[-0.5], [0.0], [1.0]])
        together = made.residual(z)
        assert together.shape == (3, sum(observation.n_data for observation in made.observations))
        assert together == pytest.approx(np.stack([made.residual(one) for one in z]), rel=1e-6, abs=1e-6)


class TestDerivatives:
    """Exact derivatives beside differences, which fits take where these cost less."""

    @pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "modulus"])
    def test_of_every_kind(self, kind, tmp_path, monkeypatch):
        truth, text, measurement, unknowns = KINDS[kind]
        made = problem(
            tmp_path, truth, {"data.csv": text}, [{"noise": 0.02, "file": "data.csv", **measurement}], unknowns
        )
        z = np.array([0.4])
        expected_residual, expected = central(made.residual, z, 1e-3)
        monkeypatch.setattr(stack_problem, "_MANY", 0)
        (experiment,) = made.experiments
        assert experiment.is_differentiable
        residual, slopes = made.linearised(z)
        np.testing.assert_allclose(residual, expected_residual, rtol=1e-6, atol=1e-6)
        assert np.max(np.abs(slopes - expected)) < (1e-2 if "diffuse" in kind else 1e-4) * np.max(np.abs(expected))

    @pytest.mark.parametrize("incidence", ["diffuse", "50 deg"])
    def test_of_bands_through_a_window(self, tmp_path, monkeypatch, incidence):
        monkeypatch.setattr(stack_problem, "_MANY", 0)
        options = {"incidence": incidence, "finite_size": {"width": "1.2 m", "height": "0.9 m"}, "bands": "octaves"}
        centres = np.array([125.0, 250.0])
        measurement = {"kind": "transmission_loss", "file": "data.csv", "noise": "0.5 dB", **options}
        unknowns = {
            "layers.panel.thickness": {"normal": ["2 mm", "10 %"]},
            "layers.back.density": {"normal": [2700, 100]},
        }
        made = problem(
            tmp_path, IN_A_WALL, {"data.csv": table("f_hz,tl_db", centres, [20.0, 25.0])}, [measurement], unknowns
        )
        z = np.array([0.3, -0.2])
        expected_residual, expected = central(made.residual, z, 1e-2)
        residual, slopes = made.linearised(z)
        assert made.experiments[0].is_differentiable
        np.testing.assert_allclose(residual, expected_residual, rtol=1e-6)
        assert np.max(np.abs(slopes - expected)) < 1e-2 * np.max(np.abs(expected))

    def test_a_batch_of_few_points_is_left_to_differences(self, tmp_path):
        made = problem(tmp_path, IN_A_TUBE, {"tube.csv": tube_table(IN_A_TUBE)}, [IMPEDANCE], PORES)
        assert not made.experiments[0].is_differentiable
        f = np.geomspace(150, 4000, 2000)
        made = problem(tmp_path, IN_A_TUBE, {"tube.csv": tube_table(IN_A_TUBE, f)}, [IMPEDANCE], PORES)
        assert made.experiments[0].is_differentiable

    def test_fields_outside_of_layers_are_left_to_differences(self, tmp_path):
        f = np.geomspace(150, 4000, 2000)
        unknowns = {"ambient.temperature": {"normal": ["20 degC", "1 K"]}}
        made = problem(tmp_path, IN_A_TUBE, {"tube.csv": tube_table(IN_A_TUBE, f)}, [IMPEDANCE], unknowns)
        assert not made.experiments[0].is_differentiable


class TestWeights:
    def test_noise_of_an_impedance_is_white_in_the_residual(self, tmp_path):
        """What is fitted is R; what was said to scatter is Z."""
        f = np.geomspace(150, 4000, 2000)
        made = problem(tmp_path, IN_A_TUBE, {"tube.csv": tube_table(IN_A_TUBE, f, 0.02)}, [IMPEDANCE], PORES)
        z = np.array([float(p.prior.coordinate(locate(IN_A_TUBE, p.name).value)) for p in made.parameters])
        residual = made.residual(z).reshape(2, -1)
        assert residual.std(axis=1) == pytest.approx([1, 1], abs=0.05)
        assert abs(np.corrcoef(residual)[0, 1]) < 0.06

    def test_columns_of_standard_deviations(self, tmp_path):
        text = parts("frequency_hz,E1_pa,E2_pa", F, ZENER_AT_F).splitlines()
        text = [f"{text[0]},E1_std_pa,E2_std_pa", *(f"{line},1000,4000" for line in text[1:])]
        unknowns = {"layers.foam.young_modulus.order": {"uniform": [0.2, 0.9]}}
        measurement = {"kind": "modulus", "layer": "foam", "file": "dma.csv", "noise": {"absolute": "1 Pa"}}
        made = problem(tmp_path, ON_A_SHAKER, {"dma.csv": "\n".join(text)}, [measurement], unknowns)
        (observation,) = made.observations
        shifted = observation.residual(ZENER_AT_F + 10.0)
        # a real change turns into both parts of the logarithm; its size is that of the first column alone
        assert np.linalg.norm(shifted.reshape(2, -1), axis=0) == pytest.approx(10 / 1000, rel=1e-3)

    @pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "transmission loss"])
    def test_shares_of_a_response_are_those_of_its_data(self, kind, tmp_path):
        """Weighed at its response, measured values that are off are as uncertain as exact ones."""
        truth, text, measurement, unknowns = KINDS[kind]
        stated = {"noise": 0.02, "model_error": 0.03, "file": "data.csv", **measurement}
        made = problem(tmp_path, truth, {"data.csv": text}, [stated], unknowns)
        (exact,) = made.observations
        z = np.array([float(p.prior.coordinate(locate(truth, p.name).value)) for p in made.parameters])
        (response,) = made.predict(z)
        assert exact.weighed_at(response) is exact
        factor = np.where(np.arange(len(exact.measured)) % 2, 1.05, 0.95)
        off = replace(exact, measured=factor * exact.measured, amounts=factor * exact.amounts)
        if off.relative:
            off = replace(
                off, noise=type(off.noise)(*(factor * part for part in (off.noise.real, off.noise.imaginary)))
            )
        weighed = off.weighed_at(response)
        expected = np.abs(exact.scale.slope(off.measured) * weighed.amounts)
        assert expected == pytest.approx(np.abs(exact.scale.slope(exact.measured) * exact.amounts), rel=1e-5)
        if off.relative:
            spread = np.abs(off.scale.slope(off.measured)) * weighed.noise.real
            assert spread == pytest.approx(np.abs(exact.scale.slope(exact.measured)) * exact.noise.real, rel=1e-5)
        else:
            assert weighed.noise is off.noise

    def test_what_is_in_db_stays_as_stated(self, tmp_path):
        truth, text, measurement, unknowns = KINDS["transmission loss"]
        stated = {"model_error": 0.5, "file": "data.csv", **measurement}
        (data,) = problem(tmp_path, truth, {"data.csv": text}, [stated], unknowns).observations
        assert data.weighed_at(2 * data.measured) is data

    def test_a_response_near_0_does_not_outweigh_all(self, tmp_path):
        truth, text, measurement, unknowns = KINDS["absorption"]
        stated = {"noise": 0.02, "file": "data.csv", **measurement}
        (data,) = problem(tmp_path, truth, {"data.csv": text}, [stated], unknowns).observations
        assert data.weighed_at(0 * data.measured).noise.real == pytest.approx(0.01 * data.measured)

    def test_a_model_error_correlates(self, tmp_path):
        error = {"model_error": {"relative": 0.05, "length": 0.5}}
        text = {"tube.csv": tube_table(IN_A_TUBE)}
        sizes = []
        for more in ({}, error):
            made = problem(tmp_path, IN_A_TUBE, text, [{**IMPEDANCE, **more}], PORES)
            (observation,) = made.observations
            whole = observation.measured * 1.05
            reflection = (whole - 1) / (whole + 1)
            sizes.append(np.sum(observation.residual(reflection) ** 2))
        assert sizes[0] == pytest.approx(len(F) * (0.05 / 0.02) ** 2, rel=0.1)
        assert sizes[1] < 5  # one deviation that the model may have: 1 + ln(f2/f1)/(2 length)

    def test_what_is_in_db(self, tmp_path):
        truth, text, measurement, unknowns = KINDS["transmission loss"]
        made = problem(tmp_path, truth, {"data.csv": text}, [{**measurement, "file": "data.csv"}], unknowns)
        (observation,) = made.observations
        assert observation.residual(observation.measured + 1.0) == pytest.approx(2.0)


ZENER_AT_F = ON_A_SHAKER.layers[0].young_modulus(F)


class TestNoResponse:
    def test_a_sample_without_response_is_nan(self, tmp_path):
        made = self.made(tmp_path)
        rows = made.residual(np.array([[0.0], [0.5]]))
        assert np.isfinite(rows[0]).all()

        def fails(stack):
            if np.size(stack.layers[0].thickness) > 1 or stack.layers[0].thickness > 0.04:
                raise InputError("no response")
            return plane_wave(stack, F).reflection

        broken = replace(made, observations=(replace(made.observations[0], response=fails),))
        rows = broken.residual(np.array([[-1.0], [1.0]]))
        assert np.isfinite(rows[0]).all()
        assert np.isnan(rows[1]).all()

    def made(self, folder):
        tables = {"tube.csv": parts("f_hz,reflection_re,reflection_im", F, plane_wave(IN_A_TUBE, F).reflection)}
        measurement = {"kind": "reflection", "file": "tube.csv", "noise": {"absolute": 0.02}}
        return problem(folder, IN_A_TUBE, tables, [measurement], {"layers.wool.thickness": {"normal": [0.04, 0.002]}})


class TestPriors:
    def prior(self, folder, path, said):
        tables = {"tube.csv": tube_table(IN_A_TUBE)}
        return problem(folder, IN_A_TUBE, tables, [IMPEDANCE], {path: said}).parameters[0].prior

    def test_units(self, tmp_path):
        prior = self.prior(tmp_path, "layers.wool.thickness", {"normal": ["4 cm", "2 mm"], "bounds": ["35 mm", 0.05]})
        assert prior.normal == (0.04, 0.002)
        assert prior.bounds == (0.035, 0.05)

    def test_a_share_of_the_mean(self, tmp_path):
        assert self.prior(tmp_path, "layers.wool.thickness", {"normal": [0.04, "5 %"]}).normal == (0.04, 0.002)

    def test_cut_at_the_limits_of_the_field(self, tmp_path):
        prior = self.prior(tmp_path, "layers.wool.tortuosity", {"normal": [1.05, 0.1]})
        assert prior.bounds == pytest.approx((1, 1.65))
        assert prior.value(np.linspace(-9, 9, 19)).min() >= 1
        assert self.prior(tmp_path, "layers.wool.porosity", {"lognormal": [0.95, 0.1]}).bounds[1] == 1
        assert self.prior(tmp_path, "layers.wool.thickness", {"normal": [0.04, 0.001]}).bounds is None


def test_shape_factors_of_many_poisson_ratios():
    nu = np.array([0.05, 0.31, 0.44, 0.49])
    alone = [static_shape_factor(float(one), 0.45) for one in nu]
    assert shape_factor(nu[:, None], 0.45)[:, 0] == pytest.approx(alone, rel=1e-4)
