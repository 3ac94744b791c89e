"""What a simulation computes is what the responses say, case by case and sample by sample."""

import csv
import io
import json
import warnings
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

from multilayer.config import parse_yaml
from multilayer.errors import InputError, ValidityWarning
from multilayer.response.diffuse_field import diffuse_field
from multilayer.response.finite_size import Window
from multilayer.response.plane_wave import plane_wave
from multilayer.simulation import SimulationFile, simulate
from multilayer.simulation.quantities import QUANTITIES
from multilayer.simulation.tolerances import draw
from multilayer.stack import Stack
from tests.simulation.files import FOAM, PANEL

F = [200.0, 500.0, 1300.0]
OF_AN_EXCITATION = ("radiation_efficiency", "input_mobility", "sound_power_level", "impact_level")
OF_FREE_WAVES = ("bending_stiffness", "loss_factor", "phase_speed")
OF_A_DUCT = ("duct_attenuation",)
BOARD = """
version: 1
layers:
  - {type: orthotropic_plate, name: board, thickness: 14 mm, density: 450, young_modulus_x: 6 GPa,
     young_modulus_y: 40 MPa, poisson_ratio_xy: 0.3, shear_modulus_xy: 60 MPa, loss_factor: 0.02}
termination: ambient
"""


@pytest.fixture
def read(tmp_path):
    """Give a function that makes a simulation of a text and of further fields."""

    def make(text, **further):
        data = parse_yaml(text, tmp_path / "file.yaml").data
        return SimulationFile.model_validate({**data, "frequency": F, **further})

    return make


class TestOneCase:
    def test_foam_on_a_wall(self, read):
        simulation = read(FOAM, incidence=40)
        (case,) = simulate(simulation).cases
        expected = plane_wave(simulation.stack, F, 40)
        np.testing.assert_array_equal(case.absorption, expected.absorption)
        np.testing.assert_array_equal(case.reflection, expected.reflection)
        np.testing.assert_allclose(case.surface_impedance, expected.surface_impedance, rtol=1e-14)
        assert case.transmission is case.transmission_loss is case.insertion_loss is None
        assert case.percentiles == {}

    def test_a_warning_does_not_depend_on_what_was_simulated_before(self, read):
        hot = {"temperature": 333.15, "relative_humidity": 0.5}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ValidityWarning)
            simulation = read(FOAM, ambient=hot)
        for _ in range(2):
            with pytest.warns(ValidityWarning) as told:
                simulate(simulation)
            assert len(told) == 1

    def test_panel(self, read):
        simulation = read(PANEL, incidence=40)
        (case,) = simulate(simulation).cases
        expected = plane_wave(simulation.stack, F, 40)
        np.testing.assert_array_equal(case.transmission_loss, expected.transmission_loss)
        np.testing.assert_array_equal(case.transmission, expected.transmission)

    def test_diffuse(self, read):
        simulation = read(PANEL, incidence={"diffuse": {"max_angle": 60}})
        (case,) = simulate(simulation).cases
        expected = diffuse_field(simulation.stack, F, 60)
        np.testing.assert_array_equal(case.transmission_loss, expected.transmission_loss)
        np.testing.assert_array_equal(case.absorption, expected.absorption)
        assert case.reflection is case.surface_impedance is None

    def test_diffuse_and_weighted(self, read):
        simulation = read(PANEL, incidence={"diffuse": {"weighting": "gaussian"}})
        (case,) = simulate(simulation).cases
        expected = diffuse_field(simulation.stack, F, weighting="gaussian")
        np.testing.assert_array_equal(case.transmission_loss, expected.transmission_loss)
        assert SimulationFile.model_validate(simulation.to_dict()).incidence == simulation.incidence

    @pytest.mark.parametrize("text", [FOAM, PANEL])
    def test_a_small_panel(self, read, text):
        size = {"width": 1.4, "height": 1.1}
        diffuse = simulate(read(text, incidence="diffuse", finite_size=size)).cases[0]
        expected = diffuse_field(read(text).stack, F, window=Window(**size))
        np.testing.assert_array_equal(diffuse.absorption, expected.absorption)
        np.testing.assert_array_equal(diffuse.transmission_loss, expected.transmission_loss)

    @pytest.mark.parametrize("incidence", [40, "diffuse"])
    def test_a_small_panel_on_water_is_refused(self, read, incidence):
        """Its radiation efficiency is that of the water, in which nearly all waves are evanescent."""
        water = {"type": "fluid", "density": 1000, "sound_speed": 1480}
        size = {"width": 1.4, "height": 1.1}
        with pytest.raises(InputError, match=r"^finite_size: .* a fluid of 1480 m/s behind it; .* leave the size out"):
            simulate(read(PANEL, incidence=incidence, finite_size=size, termination=water))
        simulate(read(PANEL, incidence=incidence, termination=water))

    @pytest.mark.parametrize("text", [FOAM, PANEL])
    @pytest.mark.parametrize("size", [None, {"width": 1.4, "height": 1.1}])
    def test_a_diffuse_field_up_to_grazing_incidence(self, read, text, size):
        (case,) = simulate(read(text, incidence={"diffuse": {"max_angle": 90}}, finite_size=size)).cases
        window = None if size is None else Window(**size)
        np.testing.assert_array_equal(case.absorption, diffuse_field(read(text).stack, F, 90, window=window).absorption)
        assert np.all(np.isfinite(case.absorption))
        if case.transmission_loss is not None:
            assert np.all(np.isfinite(case.transmission_loss))

    @pytest.mark.filterwarnings("ignore:.*bending wavelength")
    def test_a_diffuse_field_does_not_depend_on_how_a_single_plate_lies(self, read):
        sweep = {"layers.board.azimuth": ["0 deg", "25 deg", "90 deg"]}
        bands = {"third_octaves": ["100 Hz", "3150 Hz"]}
        cases = simulate(read(BOARD, incidence="diffuse", frequency=bands, sweep=sweep)).cases
        for case in cases[1:]:
            np.testing.assert_allclose(case.transmission_loss, cases[0].transmission_loss, atol=2e-3, rtol=0)
            assert case.ratings == cases[0].ratings
        single = simulate(read(BOARD, incidence=70, sweep=sweep)).cases
        assert np.ptp([case.transmission_loss[-1] for case in single]) > 3

    @pytest.mark.parametrize("text", [FOAM, PANEL])
    @pytest.mark.parametrize("angle", [0, 40])
    def test_a_large_panel_is_as_good_as_infinite(self, read, text, angle):
        small, large, infinite = (
            simulate(read(text, incidence=angle, **({"finite_size": {"width": side, "height": side}} if side else {})))
            for side in (0.3, 30, None)
        )
        for name in ("absorption", *(["transmission_loss"] if text == PANEL else [])):
            values = [result.cases[0].quantities[name] for result in (small, large, infinite)]
            np.testing.assert_allclose(values[1], values[2], rtol=0.03)
            assert np.abs(values[0] - values[2]).max() > 3 * np.abs(values[1] - values[2]).max()
        np.testing.assert_array_equal(small.cases[0].reflection, infinite.cases[0].reflection)

    def test_third_octaves_are_means_of_power(self, read):
        simulation = read(PANEL, frequency={"third_octaves": [200, 400]}, incidence=40)
        result = simulate(simulation)
        (case,) = result.cases
        assert result.frequency.tolist() == [200, 250, 315, 400]
        for centre, loss, absorption in zip(range(23, 27), case.transmission_loss, case.absorption, strict=True):
            fine = plane_wave(simulation.stack, 10 ** (np.linspace(centre - 0.5, centre + 0.5, 2001) / 10), 40)
            assert loss == pytest.approx(-10 * np.log10(np.mean(10 ** (-fine.transmission_loss / 10))), abs=0.1)
            assert absorption == pytest.approx(np.mean(fine.absorption), abs=0.005)
        assert case.reflection is None

    def test_octaves_are_means_of_their_third_octaves(self, read):
        """Of the power where the third octaves are in dB: three of them, of as many points each."""
        thirds, octaves = (
            simulate(read(PANEL, frequency={width: [180, 1400]}, incidence="diffuse"))
            for width in ("third_octaves", "octaves")
        )
        assert octaves.frequency.tolist() == [250, 500, 1000]
        assert (thirds.bands, octaves.bands) == ("third octaves", "octaves")
        loss, absorption = (
            thirds.cases[0].quantities[name].reshape(3, 3) for name in ("transmission_loss", "absorption")
        )
        expected = -10 * np.log10(np.mean(10 ** (-loss / 10), axis=1))
        np.testing.assert_allclose(octaves.cases[0].transmission_loss, expected, atol=0.01)
        np.testing.assert_allclose(octaves.cases[0].absorption, absorption.mean(axis=1), atol=1e-3)

    def test_insertion_loss(self, read):
        bare = Stack.model_validate({"layers": [read(PANEL).stack.layers[0]], "termination": "ambient"})
        simulation = read(PANEL, reference=bare, incidence=20)
        (case,) = simulate(simulation).cases
        losses = [plane_wave(stack, F, 20).transmission_loss for stack in (simulation.stack, bare)]
        np.testing.assert_array_equal(case.insertion_loss, losses[0] - losses[1])

    def test_a_stack_without_a_response(self, read):
        rigid = "layers: [{type: fluid, thickness: 0.17160, sound_speed: 343.2, density: 1.2}]\ntermination: rigid\n"
        simulation = read(rigid, frequency=[1000.0])
        assert simulate(simulation).cases[0].absorption == pytest.approx(0)

    def test_ratings(self, read):
        bands = {"third_octaves": [100, 5000]}
        assert set(simulate(read(FOAM, frequency=bands)).cases[0].ratings) == {"alpha_w", "NRC"}
        assert set(simulate(read(PANEL, frequency=bands)).cases[0].ratings) == {"Rw (C; Ctr)", "STC"}
        assert simulate(read(PANEL)).cases[0].ratings == {}

    def test_ratings_of_octaves(self, read):
        """Practical coefficients are means over octaves; what is defined in third octaves is left out."""
        thirds, octaves = (
            simulate(read(FOAM, frequency={width: [100, 5000]})).cases[0].ratings
            for width in ("third_octaves", "octaves")
        )
        assert octaves == {"alpha_w": thirds["alpha_w"]}
        assert simulate(read(PANEL, frequency={"octaves": [100, 5000]})).cases[0].ratings == {}
        assert simulate(read(FOAM, frequency={"octaves": [500, 4000]})).cases[0].ratings == {}


class TestSweep:
    def test_all_combinations(self, read):
        simulation = read(FOAM, sweep={"layers.foam.thickness": ["10 mm", "20 mm"], "incidence": ["normal", "60 deg"]})
        result = simulate(simulation)
        assert [case.label for case in result.cases] == [
            "foam.thickness = 10 mm, incidence = normal",
            "foam.thickness = 10 mm, incidence = 60 deg",
            "foam.thickness = 20 mm, incidence = normal",
            "foam.thickness = 20 mm, incidence = 60 deg",
        ]
        for case, (thickness, angle) in zip(result.cases, [(t, a) for t in (0.01, 0.02) for a in (0, 60)], strict=True):
            stack = simulation.stack.replaced({"layers.foam.thickness": thickness})
            np.testing.assert_array_equal(case.absorption, plane_wave(stack, F, angle).absorption)

    def test_cases_may_give_different_quantities(self, read):
        result = simulate(read(PANEL, sweep={"termination": ["rigid", "ambient"]}))
        closed, opened = result.cases
        assert closed.transmission_loss is None
        assert opened.transmission_loss is not None
        rows = list(csv.DictReader(io.StringIO(result.to_csv())))
        assert [row["transmission_loss_db"] == "" for row in rows] == [True] * 3 + [False] * 3

    def test_progress_tells_every_case(self, read):
        told = []
        simulate(read(FOAM, sweep={"layers.foam.thickness": ["10 mm", "20 mm"]}), progress=told.append)
        assert told == ["foam.thickness = 10 mm", "foam.thickness = 20 mm"]


TOLERANCES = {
    "layers.foam.flow_resistivity": "30 %",
    "layers.foam.young_modulus.young_modulus": {"normal": "20 %"},
    "layers.foam.poisson_ratio": "20 %",
}


class TestTolerances:
    @pytest.mark.parametrize(
        ("incidence", "further"),
        [("normal", {}), (50, {}), ("diffuse", {}), ("normal", {"ambient.temperature": "5 K"})],
    )
    def test_samples_are_those_of_a_loop(self, read, incidence, further):
        simulation = read(FOAM, tolerances=TOLERANCES | further, samples=70, incidence=incidence)
        (case,) = simulate(simulation).cases
        drawn = draw(simulation.stack, simulation.scatter, 70, simulation.seed)
        alone = []
        for i in range(70):
            foam = simulation.layers[0]
            law = foam.young_modulus.model_copy(
                update={"young_modulus": drawn["layers.foam.young_modulus.young_modulus"][i]}
            )
            changed = {name: drawn[f"layers.foam.{name}"][i] for name in ("flow_resistivity", "poisson_ratio")}
            warmer = {name.partition(".")[2]: float(drawn[name][i]) for name in further}
            stack = Stack(
                layers=(foam.model_copy(update={"young_modulus": law, **changed}),),
                ambient=simulation.ambient.model_copy(update=warmer),
            )
            field = (
                diffuse_field(stack, F) if incidence == "diffuse" else plane_wave(stack, F, simulation.incidence.angle)
            )
            alone.append(field.absorption)
        expected = np.percentile(alone, (5, 50, 95), axis=0)
        np.testing.assert_allclose(case.percentiles["absorption"], expected, rtol=1e-9)
        nominal = simulate(read(FOAM, incidence=incidence)).cases[0]
        np.testing.assert_array_equal(case.absorption, nominal.absorption)

    def test_percentiles_of_a_mass_law(self, read):
        """A limp sheet: the loss follows from its mass, and its percentiles from those of the mass."""
        sheet = (
            "layers: [{type: elastic_plate, name: sheet, thickness: 1 mm, density: 1000, young_modulus: 1 Pa, "
            "poisson_ratio: 0}]\ntermination: ambient\n"
        )
        simulation = read(sheet, tolerances={"layers.sheet.density": "10 %"}, samples=5000)
        (case,) = simulate(simulation).cases
        impedance = simulation.ambient.gas.impedance
        for share, found in zip((0.91, 1, 1.09), case.percentiles["transmission_loss_db"], strict=True):
            expected = 10 * np.log10(1 + (np.pi * np.array(F) * share / impedance) ** 2)
            np.testing.assert_allclose(found, expected, atol=0.05)

    def test_tolerances_follow_the_swept_nominal_value(self, read):
        simulation = read(
            FOAM,
            sweep={"layers.foam.thickness": ["10 mm", "40 mm"]},
            tolerances={"layers.foam.thickness": "10 %"},
            frequency=[200.0],
        )
        for case in simulate(simulation).cases:
            low, _, high = case.percentiles["normalised_impedance_im"][:, 0]
            nominal = case.quantities["normalised_impedance"][0].imag
            # the stiffness of the air inside: inversely as the thickness
            assert (low / nominal, high / nominal) == (
                pytest.approx(1 / 0.91, rel=0.03),
                pytest.approx(1 / 1.09, rel=0.03),
            )

    def test_layer_fields_that_the_response_ignores(self, read):
        simulation = read(PANEL, tolerances={"layers.plate.poisson_ratio": "10 %"}, samples=60)
        (case,) = simulate(simulation).cases
        np.testing.assert_allclose(case.percentiles["transmission_loss_db"], [case.transmission_loss] * 3)


class TestExecutors:
    @pytest.fixture
    def simulation(self, read):
        return read(FOAM, sweep={"layers.foam.thickness": ["10 mm", "20 mm"]}, tolerances=TOLERANCES, samples=120)

    @pytest.fixture
    def alone(self, simulation):
        return simulate(simulation)

    def test_threads(self, simulation, alone):
        with ThreadPoolExecutor(2) as pool:
            assert simulate(simulation, pool).to_dict() == alone.to_dict()

    def test_processes(self, simulation, alone):
        with ProcessPoolExecutor(2, get_context("spawn")) as pool:
            assert simulate(simulation, pool).to_dict() == alone.to_dict()

    def test_mistakes_come_back_from_workers(self, read):
        table = {"law": "table", "frequency": [100, 1000], "storage_modulus": [1e5, 1e5], "loss_modulus": [1e4, 1e4]}
        simulation = read(FOAM, sweep={"layers.foam.young_modulus": [table]})
        told = pytest.raises(InputError, match=r"^foam.young_modulus = .*: the modulus table holds 100 to 1000 Hz")
        with ThreadPoolExecutor(2) as pool, told:
            simulate(simulation, pool)


class TestResult:
    def test_csv_and_json_hold_the_same(self, read):
        result = simulate(read(PANEL, tolerances={"layers.plate.thickness": "5 %"}, samples=10))
        rows = list(csv.DictReader(io.StringIO(result.to_csv())))
        plain = json.loads(json.dumps(result.to_dict(), allow_nan=False))
        (case,) = plain["cases"]
        assert plain["frequency_hz"] == [float(row["frequency_hz"]) for row in rows] == F
        columns = set(rows[0]) - {"case", "frequency_hz"}
        assert columns == {
            f"{name}{percent}"
            for quantity in QUANTITIES.values()
            for name in quantity.columns
            for percent in ("", "_p05", "_p50", "_p95")
            if quantity.name not in ("insertion_loss", *OF_AN_EXCITATION, *OF_FREE_WAVES, *OF_A_DUCT)
        } | {f"{column}_sd_from_plate.thickness" for column in ("absorption", "transmission_loss_db")}
        for column in columns:
            assert [float(row[column]) for row in rows] == pytest.approx(case[column], rel=1e-8)

    def test_settings_make_the_same_simulation(self, read):
        simulation = read(PANEL, sweep={"layers.plate.thickness": ["1 mm", "2 mm"]})
        again = SimulationFile.model_validate(simulate(simulation).settings)
        assert simulate(again).to_csv() == simulate(simulation).to_csv()

    def test_infinite_values(self, read):
        """Nothing comes through a mile of wool: an infinite loss, which JSON does not know."""
        wall = (
            "layers: [{type: equivalent_fluid, model: miki, thickness: 1600 m, flow_resistivity: 20000}]\n"
            "termination: ambient\n"
        )
        result = simulate(read(wall))
        assert np.all(np.isinf(result.cases[0].transmission_loss))
        plain = json.loads(json.dumps(result.to_dict(), allow_nan=False))
        assert plain["cases"][0]["transmission_loss_db"] == [None] * 3
        assert "inf" in result.to_csv()
