"""Simulation files: what they say, and every mistake at its place."""

import numpy as np
import pytest

from multilayer.config.kinds import OF_A_SIMULATION
from multilayer.errors import InputError
from multilayer.simulation import SimulationFile, load_simulation
from multilayer.simulation.bands import grid_of
from multilayer.simulation.settings import DiffuseIncidence, PlaneIncidence
from multilayer.stack import Stack, load_stack
from tests.simulation.files import FOAM, PANEL

FULL = """\
frequency: {from: 100 Hz, to: 1 kHz, points: 5, spacing: linear}
incidence: 30 deg
finite_size: {width: 1.4 m, height: 1.1 m}
sweep:
  layers.plate.thickness: [1 mm, 0.002]
  incidence: [normal, diffuse, {diffuse: {max_angle: 80}}]
tolerances: {layers.gap.thickness: 5 %}
samples: 10
seed: 3
"""


@pytest.fixture
def refused(written):
    """Give a function that returns the mistakes found in a file, without its name."""

    def read(text):
        file = written(text)
        with pytest.raises(InputError) as caught:
            load_simulation(file)
        return [str(problem).removeprefix(f"{file}:") for problem in caught.value.problems]

    return read


def place(text, wanted):
    """Return line and column of the first place of `wanted`."""
    before = text[: text.index(wanted)]
    return f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"


class TestReading:
    def test_a_stack_file_is_a_simulation(self, written):
        simulation = load_simulation(written(FOAM))
        (case,) = simulation.cases
        assert case.label == ""
        assert case.simulation is simulation
        assert simulation.incidence == PlaneIncidence(angle=0)
        frequency = grid_of(simulation.frequency).frequency
        assert (len(frequency), frequency[0], frequency[-1]) == (200, pytest.approx(89.13), pytest.approx(5623))
        assert np.ptp(np.diff(np.log(frequency))) < 1e-12

    def test_a_simulation_file_is_a_stack_file(self, written):
        stack = load_stack(written(PANEL + FULL))
        assert type(stack) is Stack
        assert stack == load_stack(written(PANEL))
        assert load_simulation(written(PANEL + FULL)).stack == stack

    def test_keys_that_a_stack_leaves_alone(self):
        assert set(SimulationFile.model_fields) - set(Stack.model_fields) == OF_A_SIMULATION

    def test_everything_is_read(self, written):
        simulation = load_simulation(written(PANEL + FULL))
        np.testing.assert_allclose(grid_of(simulation.frequency).frequency, [100, 325, 550, 775, 1000])
        assert simulation.incidence == PlaneIncidence(angle=30)
        assert (simulation.finite_size.width, simulation.finite_size.height) == (1.4, 1.1)
        assert (simulation.samples, simulation.seed) == (10, 3)
        assert [case.label for case in simulation.cases] == [
            f"plate.thickness = {thickness}, incidence = {incidence}"
            for thickness in ("1 mm", "0.002 m")
            for incidence in ("normal", "diffuse", "{'diffuse': {'max_angle': 80}}")
        ]
        last = simulation.cases[-1].simulation
        assert last.layers[0].thickness == 0.002
        assert last.incidence.diffuse.max_angle == 80

    def test_round_trip(self, written):
        simulation = load_simulation(written(PANEL + FULL))
        again = SimulationFile.model_validate(simulation.to_dict())
        assert again.to_dict() == simulation.to_dict()
        assert [case.label for case in again.cases] == [case.label for case in simulation.cases]

    @pytest.mark.parametrize(
        ("text", "expected"),
        [
            ("normal", PlaneIncidence()),
            ("0", PlaneIncidence()),
            ("89.9", PlaneIncidence(angle=89.9)),
            ("0.5 rad", PlaneIncidence(angle=np.rad2deg(0.5))),
            ("diffuse", DiffuseIncidence()),
        ],
    )
    def test_incidence(self, written, text, expected):
        found = load_simulation(written(f"{FOAM}incidence: {text}\n")).incidence
        if isinstance(expected, PlaneIncidence):
            assert found.angle == pytest.approx(expected.angle)
        else:
            assert found == expected

    def test_frequencies_listed(self, written):
        simulation = load_simulation(written(FOAM + "frequency: [200, 1 kHz]\n"))
        np.testing.assert_allclose(grid_of(simulation.frequency).points, [200, 1000])

    def test_third_octaves(self, written):
        grid = grid_of(load_simulation(written(FOAM + "frequency: {third_octaves: [100 Hz, 5 kHz]}\n")).frequency)
        assert grid.frequency.tolist() == [
            100, 125, 160, 200, 250, 315, 400, 500, 630, 800, 1000, 1250, 1600, 2000, 2500, 3150, 4000, 5000,
        ]  # fmt: skip
        edges = 10 ** (np.arange(19.5, 38) / 10)
        assert np.all((grid.points > edges[:-1, None]) & (grid.points < edges[1:, None]))

    def test_octaves(self, written):
        simulation = load_simulation(written(FOAM + "frequency: {octaves: [125 Hz, 4 kHz]}\n"))
        grid = grid_of(simulation.frequency)
        assert grid.frequency.tolist() == [125, 250, 500, 1000, 2000, 4000]
        # the very points of the third octaves inside
        thirds = SimulationFile.model_validate({**simulation.to_dict(), "frequency": {"third_octaves": [100, 5000]}})
        np.testing.assert_allclose(grid.points.ravel(), grid_of(thirds.frequency).points.ravel(), rtol=1e-12)
        assert SimulationFile.model_validate(simulation.to_dict()).frequency == simulation.frequency

    def test_a_reference(self, written, tmp_path):
        written(PANEL, "bare.yaml")
        simulation = load_simulation(written(PANEL + "reference: bare.yaml\n"))
        assert simulation.reference == load_stack(tmp_path / "bare.yaml")

    def test_a_reference_of_its_own_settings(self, written):
        written(PANEL, "bare.yaml")
        simulation = load_simulation(written(f"{PANEL}reference: bare.yaml\nsweep: {{layers.gap.thickness: [1 cm]}}\n"))
        again = SimulationFile.model_validate(simulation.to_dict())
        assert again.reference == simulation.reference == again.cases[0].simulation.reference


class TestSweptPaths:
    def test_materials(self, written):
        text = "layers: [{material: AA2009/T11.3/foam, name: foam, thickness: 20 mm}]\ntermination: rigid\n"
        sweep = "sweep: {layers.foam.material: [AA2009/T11.3/foam, AA2009/T6.1/glass_wool]}\n"
        cases = load_simulation(written(text + sweep)).cases
        assert [case.simulation.layers[0].flow_resistivity for case in cases] == [5000, 40000]
        assert [case.simulation.layers[0].thickness for case in cases] == [0.02, 0.02]

    def test_materials_that_nobody_knows(self, refused):
        text = "layers: [{material: AA2009/T11.3/foam, name: foam, thickness: 20 mm}]\n"
        (told,) = refused(f"{text}sweep: {{layers.foam.material: [AA2009/T11.3/foan]}}\n")
        assert told.startswith("2:32: sweep.layers.foam.material.0: ")
        assert "did you mean 'AA2009/T11.3/foam'?" in told

    @pytest.mark.parametrize(
        ("path", "values", "found"),
        [
            ("layers.foam.thickness", "[20 mm]", lambda case: case.layers[0].thickness == pytest.approx(0.02)),
            ("layers.0.thickness", "[20 mm]", lambda case: case.layers[0].thickness == pytest.approx(0.02)),
            ("layers.foam.loss_factor", "[0]", lambda case: case.layers[0].loss_factor == 0),
            (
                "layers.foam.young_modulus.loss_factor",
                "[0.5]",
                lambda case: case.layers[0].young_modulus(1).imag == 7e4,
            ),
            ("layers.foam.young_modulus", "[1 MPa]", lambda case: case.layers[0].young_modulus == 1e6),
            ("ambient.temperature", "[0 degC]", lambda case: case.ambient.temperature == 273.15),
            ("termination", "[ambient]", lambda case: case.termination == "ambient"),
            ("contacts", "[[{between: [foam, termination], kind: slip}]]", lambda case: case.interfaces[1] == "slip"),
            ("finite_size.width", "[2 m]", lambda case: case.finite_size.width == 2),
        ],
    )
    def test_any_parameter(self, written, path, values, found):
        size = "finite_size: {width: 1, height: 1}\n" if path.startswith("finite") else ""
        (case,) = load_simulation(written(f"{FOAM}{size}sweep: {{{path}: {values}}}\n")).cases
        assert found(case.simulation)
        assert case.simulation.sweep == {}


class TestLabels:
    """No two cases have the same."""

    @staticmethod
    def labels(written, path, values):
        return [case.label for case in load_simulation(written(f"{FOAM}sweep: {{{path}: {values}}}\n")).cases]

    def test_of_laws_tell_what_differs(self, written):
        law = "law: fractional_zener, relaxed_modulus: 1 MPa, unrelaxed_modulus: 1 GPa, relaxation_time: 1 ms"
        values = f"[1 MPa, {{{law}, order: 0.3}}, {{{law}, order: 0.7}}]"
        assert self.labels(written, "layers.foam.young_modulus", values) == [
            f"foam.young_modulus = {told}" for told in ("1 MPa", "{'order': 0.3}", "{'order': 0.7}")
        ]

    def test_of_numbers_have_the_digits_it_takes(self, written):
        assert self.labels(written, "layers.foam.thickness", "[0.05, 0.06000001, 0.06000002]") == [
            f"foam.thickness = {told} m" for told in ("0.05", "0.06000001", "0.06000002")
        ]

    def test_of_lists_too_long_to_show_are_numbered(self, written):
        gaps = "[{type: fluid, name: front, thickness: 20 mm}, {type: fluid, name: back, thickness: 1 mm}]"
        told = self.labels(written, "layers", f"[{gaps}, {gaps.replace('1 mm', '2 mm')}]")
        assert told[1] == f"{told[0]} (2)"

    def test_are_numbered_where_different_texts_are_one(self, written):
        told = self.labels(written, "layers.foam.thickness", "[0.05, 0.05 m]")
        assert told == ["foam.thickness = 0.05 m", "foam.thickness = 0.05 m (2)"]
        assert self.labels(written, "incidence", "[45, '45']") == ["incidence = 45", "incidence = 45 (2)"]


MISTAKES = {
    "frequency zero": ("frequency: [0, 100]", "0,", "frequency.0: 0.0 is not allowed: it must be above 0"),
    "frequency negative": (
        "frequency: {from: -1 Hz}",
        "-1 Hz",
        "frequency.from: -1.0 is not allowed: it must be above",
    ),
    "frequencies fall": ("frequency: {from: 1 kHz, to: 100 Hz}", "100 Hz", "must be above 'from', 1000 Hz"),
    "frequencies not in order": (
        "frequency: [500, 100, 3000]",
        "100",
        "frequency.1: 100 Hz is not allowed: it must be above 500 Hz before it; list each frequency once, the lowest",
    ),
    "a frequency twice": ("frequency: [100, 500, 500.0 Hz]", "500.0", "frequency.2: 500 Hz is not allowed: it must be"),
    "frequency in m": ("frequency: {to: 3 m}", "3 m", "'3 m' has the wrong unit"),
    "frequency mistyped": ("frequency: {form: 3}", "form", "there is no such field; did you mean 'from'?"),
    "no list": ("frequency: 100 Hz", "100 Hz", "must be a list, not '100 Hz'"),
    "bands fall": ("frequency: {third_octaves: [200, 100]}", "100]", "the last band must not lie below the first"),
    "octaves fall": ("frequency: {octaves: [250, 125]}", "125]", "the last band must not lie below the first, 250 Hz"),
    "octaves in m": ("frequency: {octaves: [125, 4 km]}", "4 km", "'4 km' has the wrong unit"),
    "one octave": ("frequency: {octaves: [125]}", "[125]", "frequency.octaves"),
    "octaves mistyped": ("frequency: {octave: [1, 2]}", "octave", "there is no such field; did you mean 'octaves'?"),
    "both widths": (
        "frequency: {octaves: [125, 250], third_octaves: [125, 250]}",
        "{octaves",
        "either as 'third_octaves' or as 'octaves'",
    ),
    "no width": ("frequency: {octaves: null}", "{octaves", "either as 'third_octaves' or as 'octaves'"),
    "grazing": ("incidence: 90", "90", "90 is not allowed; allowed: normal, an angle in degrees from 0 to below 90"),
    "beyond": ("incidence: 120 deg", "120 deg", "'120 deg' is not allowed"),
    "negative angle": ("incidence: -5", "-5", "-5 is not allowed"),
    "incidence": ("incidence: sideways", "sideways", "'sideways' is not allowed; allowed: normal"),
    "diffuse angle": ("incidence: {diffuse: {max_angle: 95}}", "95", "95.0 is not allowed: it must be at most 90"),
    "weighting": (
        "incidence: {diffuse: {weighting: gauss}}",
        "gauss",
        "'gauss' is not allowed; allowed: 'uniform' or 'gaussian'",
    ),
    "size": ("finite_size: {width: 0 m, height: 1 m}", "0 m", "0.0 is not allowed: it must be above 0"),
    "samples": ("samples: 1", "1\n", "1 is not allowed: it must be at least 2"),
    "key": ("swep: {}", "swep", "there is no such field; did you mean 'sweep'?"),
    "no such layer": (
        "sweep: {layers.fom.thickness: [1 mm]}",
        "layers.fom",
        "leads nowhere: there is no 'fom' in layers; did you mean 'foam'?",
    ),
    "no such field": (
        "sweep: {layers.foam.thicknes: [1 mm]}",
        "layers.foam.thicknes",
        "there is no such field; did you mean 'thickness'?",
    ),
    "no such key": (
        "sweep: {ambent.pressure: [1]}",
        "ambent",
        "leads to nothing that can be swept; did you mean 'ambient'",
    ),
    "through a number": (
        "sweep: {layers.foam.thickness.x: [1]}",
        "layers.foam.thickness.x",
        "leads nowhere: layers.foam.thickness is '50 mm', which has no fields",
    ),
    "wrong unit": (
        "sweep: {layers.foam.thickness: [10 mm, 20 s]}",
        "20 s",
        "sweep.layers.foam.thickness.1: '20 s' has the wrong unit: this is a quantity in m",
    ),
    "out of range": ("sweep: {layers.foam.porosity: [0.9, 1.2]}", "1.2", "1.2 is not allowed: it must be below 1"),
    "twice": ("sweep: {layers.foam.porosity: [0.9, 0.9]}", "0.9]", "stands here a second time"),
    "empty": ("sweep: {layers.foam.porosity: []}", "[]", "must not be empty"),
    "one value": ("sweep: {layers.foam.porosity: 0.9}", "0.9", "must be a list, not 0.9"),
    "damped twice": (
        "sweep: {layers.foam.loss_factor: [0, 0.2]}",
        "0.2",
        "layers.0: loss_factor stands beside a young_modulus that has losses already",
    ),
    "one field by two paths": (
        "sweep: {layers.0.thickness: [25 mm], layers.foam.thickness: [30 mm, 40 mm]}",
        "layers.foam",
        "'layers.foam.thickness' and 'layers.0.thickness' lead to the same field; leave one of them out",
    ),
    "a field, then what holds it": (
        "sweep: {layers.0.young_modulus.loss_factor: [0, 0.2], layers.foam.young_modulus: [1 MPa]}",
        "layers.foam.young_modulus",
        "'layers.foam.young_modulus' replaces what 'layers.0.young_modulus.loss_factor' sets in it; write it before",
    ),
    "two tolerances of one field": (
        "tolerances: {layers.0.thickness: 1 mm, layers.foam.thickness: 20 mm}",
        "layers.foam",
        "'layers.foam.thickness' and 'layers.0.thickness' lead to the same field; leave one of them out",
    ),
    "a share of 0": ("tolerances: {layers.foam.loss_factor: 5 %}", "5 %", "5 % of 0 is 0; write an absolute one"),
    "a share of a mean of 0": (
        "tolerances: {layers.foam.loss_factor: {normal: [0, 5 %]}}",
        "{normal",
        "5 % of 0 is 0; write an absolute one",
    ),
    "tolerance of nothing": (
        "tolerances: {layers.foam.porsity: 1 %}",
        "layers.foam.porsity",
        "leads nowhere: there is no 'porsity'; did you mean 'porosity'?",
    ),
    "tolerance of a layer": ("tolerances: {layers.foam: 1 %}", "layers.foam", "leads to no single value"),
    "tolerance of a law": (
        "tolerances: {layers.foam.young_modulus: 1 %}",
        "1 %",
        "a tolerance needs a number, and the nominal value is 'LossFactor(...)'",
    ),
    "tolerance of text": ("tolerances: {layers.foam.name: 1 %}", "1 %", "the nominal value is 'foam'"),
    "tolerance of a default": ("tolerances: {ambient.density: 1 %}", "1 %", "left to its default; write it out"),
    "tolerance in s": ("tolerances: {layers.foam.thickness: 1 s}", "1 s", "'1 s' has the wrong unit"),
    "tolerance below 0": ("tolerances: {layers.foam.thickness: -1 %}", "-1 %", "is not allowed: it must be above 0"),
    "tolerance in degC": ("tolerances: {ambient.temperature: 2 degC}", "2 degC", "write it in K, as '2 K'"),
    "tolerance of no form": ("tolerances: {layers.foam.thickness: {beta: 2}}", "{beta", "is no tolerance; write '5 %'"),
    "a nothing": ("tolerances: {layers.foam.thickness: }", " }", "an empty value is no tolerance"),
    "high below low": (
        "tolerances: {layers.foam.porosity: {uniform: [0.9, 0.8]}}",
        "{uniform",
        "high must lie above low",
    ),
    "three values": ("tolerances: {layers.foam.porosity: {normal: [1, 2, 3]}}", "{normal", "two values are needed"),
    "no reference": ("reference: bare.yaml", "bare.yaml", "there is no such file; the path is relative to this file"),
}


class TestMistakes:
    @pytest.mark.parametrize("name", MISTAKES)
    def test_one(self, refused, name):
        line, at, words = MISTAKES[name]
        text = f"{FOAM}{line}\n"
        (told,) = refused(text)
        start = text.index(line)
        before = text[: start + text[start:].index(at)]
        assert told.startswith(f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}: ")
        assert words in told

    def test_all_at_once(self, refused):
        text = (
            FOAM.replace("porosity: 0.98", "porosity: 1.98")
            + "incidence: 95\nsweep: {layers.foam.thickness: [1 s, 2 mm], layers.fom.thickness: [1 mm]}\n"
        )
        told = refused(text)
        assert [line.split(": ")[0] for line in told] == [
            place(text, "1.98"), place(text, "95"), place(text, "1 s"), place(text, "layers.fom"),
        ]  # fmt: skip

    def test_of_the_stack_are_not_repeated_for_every_value(self, refused):
        text = FOAM.replace("porosity: 0.98", "porosity: 1.98") + "sweep: {layers.foam.thickness: [1 mm, 2 mm]}\n"
        assert len(refused(text)) == 1

    def test_values_that_do_not_go_together(self, refused):
        law = "{law: fractional_zener, relaxed_modulus: 1e5, unrelaxed_modulus: 2e5, relaxation_time: 1e-3, order: 0.5}"
        text = FOAM.replace("{law: loss_factor, young_modulus: 140 kPa, loss_factor: 0.1}", law)
        path = "layers.foam.young_modulus"
        text += f"sweep: {{{path}.relaxed_modulus: [1e5, 1.5e5], {path}.unrelaxed_modulus: [1.2e5, 2e5]}}\n"
        (told,) = refused(text)
        assert "relaxed_modulus = 150000.0, layers.foam.young_modulus.unrelaxed_modulus = 120000.0: " in told
        assert "must be at least relaxed_modulus" in told

    def test_paths_that_do_not_go_together(self, refused):
        path = "layers.foam.young_modulus"
        law = "{law: loss_factor, young_modulus: 1e5, loss_factor: 0.1}"
        (told,) = refused(f"{FOAM}sweep: {{{path}: [{law}, 70 GPa], {path}.loss_factor: [0.1, 0.2]}}\n")
        assert "layers.foam.young_modulus is '70 GPa', which has no fields" in told

    def test_too_many_cases(self, refused):
        values = ", ".join(map(str, range(1, 200)))
        text = f"{FOAM}sweep: {{layers.foam.thickness: [{values}], layers.foam.frame_density: [{values}]}}\n"
        (told,) = refused(text)
        assert "39 601 cases of a sweep are too many: at most 10 000 are taken; sweep fewer values" in told

    def test_a_reference_that_lets_nothing_through(self, refused, written):
        written(FOAM, "foam.yaml")
        (told,) = refused(PANEL + "reference: foam.yaml\n")
        assert "an insertion loss needs a half-space behind the reference" in told

    @pytest.mark.parametrize(
        ("key", "more"),
        [
            ("beside", "area: 10\nbeside: [{type: flanking, transmission_loss: 30 dB}]\n"),
            ("links", "links: [{kind: line, between: [front, back], spacing: 0.6}]\n"),
        ],
    )
    @pytest.mark.parametrize("place", ["reference", "patch"])
    def test_a_wall_in_the_place_of_layers(self, refused, written, place, key, more):
        plate = (
            "{type: elastic_plate, name: NAME, thickness: 1 mm, density: 7800, young_modulus: 2e11, poisson_ratio: 0.3}"
        )
        layers = f"  - {plate}\n  - {{type: fluid, thickness: 5 cm}}\n  - {plate}\n".replace("NAME", "front", 1)
        layers = layers.replace("NAME", "back")
        written(f"version: 1\nlayers:\n{layers}termination: ambient\n{more}", "other.yaml")
        asked = "reference: other.yaml\n"
        if place == "patch":
            asked = "area: 10\nbeside: [{type: patch, area: 2, stack: other.yaml}]\n"
        (told,) = refused(PANEL + asked)
        assert "other.yaml:" in told
        assert f"{key}: belongs to a wall, and only the layers of this file count here" in told
        assert "name a file without 'beside' and 'links'" in told

    def test_of_a_reference_stand_in_its_own_file(self, refused, written):
        written(PANEL.replace("50 mm", "50 kg"), "bare.yaml")
        (told,) = refused(PANEL + "reference: bare.yaml\n")
        assert "bare.yaml:4:" in told
        assert "'50 kg' has the wrong unit" in told


@pytest.mark.parametrize(("field", "line"), [("samples", "samples: true"), ("seed", "seed: false")])
def test_what_is_true_is_no_number(refused, field, line):
    text = f"{FOAM}tolerances: {{layers.0.thickness: 5 %}}\n{line}\n"
    assert any(f" {field}: must be a whole number, not " in problem for problem in refused(text))
