"""Diagnoses of walls and absorbers whose effect is known, and what they are made of."""

import json
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.file import diagnosis_file
from multilayer.diagnosis.levels.data import band_nodes
from multilayer.diagnosis.levels.designs import LEVEL_DESIGNS
from multilayer.diagnosis.levels.diagnose import N_STEPS, _inputs, diagnose_levels
from multilayer.diagnosis.levels.paths import link_transmission
from multilayer.diagnosis.levels.uncertainty import absorption_spread, insulation_spread
from multilayer.diagnosis.places import LEVEL_PLACES
from multilayer.experiments.levels.effects import acts_through_stack
from multilayer.experiments.levels.places import with_share
from multilayer.experiments.levels.sound_field import (
    Ridges,
    SoundField,
    bending_stiffness,
    mean_power,
    surface_density,
)
from multilayer.experiments.places import DrawnLaw
from multilayer.inference.problem import GaussianPrior
from multilayer.layers.elastic_plate import ElasticPlate
from multilayer.matrix.wave import Wave
from multilayer.media.gas import dry_air
from multilayer.response import diffuse_field
from multilayer.response.bands import band_points
from multilayer.response.finite_size import Window
from multilayer.stack import Stack
from tests.diagnosis.walls import BANDS, BOARD, DOUBLE, GLASS, WALLS, WOOL, described, measured, write

AIR = dry_air()


def stack(layers, termination="ambient"):
    return Stack.model_validate({"version": 1, "layers": layers, "termination": termination})


def nodes():
    return band_nodes(BANDS, "third octaves", "wall")


@pytest.mark.parametrize("window", [None, Window(1.25, 1.5)])
@pytest.mark.parametrize("layers", [[BOARD], [GLASS], DOUBLE], ids=["board", "pane", "double"])
def test_few_directions_give_what_adaptive_quadrature_gives(layers, window):
    wall = stack(layers)
    points = band_points(BANDS)
    field = diffuse_field(wall, points.ravel(), 78.0, window=window)
    expected = -10 * np.log10(field.transmission_coefficient.reshape(points.shape).mean(axis=1))
    share = mean_power("transmission_loss", wall, SoundField(78.0, window=window), nodes(), Ridges.of(wall, 500.0))
    assert np.std(-10 * np.log10(share[0]) - expected) < 0.3


def test_absorption_of_a_finite_sample_is_that_of_adaptive_quadrature():
    wool, window, points = stack([WOOL], "rigid"), Window(3.0, 3.6), band_points(BANDS)
    expected = diffuse_field(wool, points.ravel(), 90.0, window=window).absorption.reshape(points.shape).mean(axis=1)
    sound = SoundField(90.0, window=window)
    np.testing.assert_allclose(
        mean_power("absorption", wool, sound, nodes(), Ridges.of(wool, 500.0))[0], expected, atol=0.025
    )


def test_what_is_remembered_is_of_its_prior(tmp_path):
    """Files with a reference and without share what was computed; their coordinates mean other values."""
    problem = measured(tmp_path, {}).hypothesis
    known = GaussianPrior(np.full(len(problem.nominal_parameters), 3.0), 0.1 * np.eye(len(problem.nominal_parameters)))
    start = np.zeros(len(problem.parameters))
    beside = replace(problem, earlier=known)
    cases = ((problem, start), (problem, known.mean), (beside, start))
    usual, there, found = (np.concatenate([*one.differences(z)], axis=-1) for one, z in cases)
    np.testing.assert_allclose(found, there, rtol=1e-12)
    assert np.abs(found - usual).max() > 0.5  # dB


def test_samples_are_computed_together_as_one_by_one():
    wall, law = stack([BOARD]), np.array([[650.0], [800.0]])
    ridges, sound = (
        Ridges.of(wall, 500.0),
        SoundField(np.array([[70.0], [80.0]]), concentration=np.array([[0.0], [1.0]])),
    )
    both = mean_power("transmission_loss", wall.replaced({"layers.board.density": law}), sound, nodes(), ridges)
    for i, row in enumerate(both):
        alone = stack([BOARD | {"density": float(law[i, 0])}])
        one = SoundField(float(sound.angle[i, 0]), concentration=float(sound.concentration[i, 0]))
        np.testing.assert_allclose(row, mean_power("transmission_loss", alone, one, nodes(), ridges)[0], rtol=1e-9)


def test_rigid_links_are_a_line_force_on_the_back_leaf():
    plate, f, spacing = ElasticPlate.model_validate(BOARD), np.array([500.0]), 0.6
    omega, mass = 2 * np.pi * f, 0.0125 * 700
    stiffness = 2.5e9 * 0.0125**3 / (12 * (1 - 0.3**2))
    line = 2 * mass * (stiffness * omega**2 / mass) ** 0.25  # |Z| = sqrt(2) times this
    velocity = np.sqrt(2) / (omega * mass)  # of the front leaf for a unit p^2 of the room, its half at the equal links
    force = np.sqrt(2) * line * velocity / 2
    power = AIR.density * force**2 / (2 * omega * mass**2)  # of a line force below coincidence, per length, one side
    expected = power / (spacing / (4 * AIR.impedance))
    loss = ElasticPlate.model_validate(BOARD | {"loss_factor": 0.0})
    np.testing.assert_allclose(link_transmission(f, loss, loss, spacing, 0.0, AIR), expected, rtol=1e-6)
    assert np.all(link_transmission(f, plate, plate, spacing, 1e-5, AIR) < expected)


def test_spreads_are_those_of_the_standards():
    f = np.array([50.0, 100.0, 1000.0, 5000.0])
    for situation, values in {"in_situ": (4.0, 2.8, 1.0, 2.2), "reproducibility": (6.8, 3.0, 1.8, 2.8)}.items():
        np.testing.assert_allclose(np.hypot(*insulation_spread(f, situation)), values)
    np.testing.assert_allclose(insulation_spread(f, "repeatability").alone, (2.0, 1.4, 0.6, 0.6))
    assert not insulation_spread(f, "repeatability").together.any()
    # the standard's example at 1000 Hz
    np.testing.assert_allclose(np.hypot(*absorption_spread(f[2:3], np.array([0.68]), "in_situ")), 0.0422)


def absorber(folder, kind, uncertainty="in_situ", tube=None, **given):
    """Return the diagnosis file of a measured absorption of 0.6."""
    write(folder, kind, {"wool": np.full(len(BANDS), 0.6)})
    measurement = {"kind": kind, "stack": "wool", "name": "wool", "file": "wool.csv"} | given
    return diagnosis_file(
        folder, stacks={"wool": {"version": 1, "layers": [WOOL], "termination": "rigid"}}, measurements=[measurement],
        unknowns={"r": {"paths": ["wool.layers.wool.flow_resistivity"], "lognormal": [8e3, 0.1]}},
        uncertainty=uncertainty, tube=tube or {},
    )  # fmt: skip


def test_absorption_at_one_angle_has_the_errors_of_its_tube(tmp_path):
    file = absorber(tmp_path, "absorption", incidence="normal", tube={"error": 0.03, "length": 0.8})
    (data,) = file.hypothesis.observations
    np.testing.assert_allclose(data.noise.real, 0.005)
    np.testing.assert_allclose(data.amounts, np.hypot(2 * 0.03 * np.sqrt(0.4), 0.01))
    assert data.error.length == 0.8
    inputs = _inputs(file, "x", file.hypothesis)
    assert inputs["noise"]["wool"] == "0.005 of absorption (none is said)"
    assert inputs["model_error"]["wool"] == "0.03 of each part of R, as 'tube' has it"


@pytest.mark.parametrize(
    ("situation", "error"),
    [
        ("in_situ", "ISO 12999-2, reproducibility beyond repeatability"),
        ("reproducibility", "ISO 12999-2, reproducibility beyond repeatability"),
        ("repeatability", "that of the model's solution alone"),
    ],
)
def test_the_errors_of_absorption_in_a_room_are_told_as_they_are_taken(tmp_path, situation, error):
    finite = {"finite_size": {"width": 3.0, "height": 3.6}}
    file = absorber(tmp_path, "reverberation_absorption", situation, {"length": 0.8}, **finite)
    (data,) = file.hypothesis.observations
    alone, together = absorption_spread(BANDS, np.full(len(BANDS), 0.6), situation)
    np.testing.assert_allclose(data.noise.real, alone)
    np.testing.assert_allclose(data.amounts, np.hypot(together, 0.01))
    assert data.error.length == 0.5
    inputs = _inputs(file, "x", file.hypothesis)
    assert inputs["noise"]["wool"] == "ISO 12999-2, repeatability"
    assert inputs["model_error"]["wool"] == error


def test_a_second_board_lies_loose_on_the_first():
    """Twice the mass and twice the bending stiffness, not eight times: the coincidence stays."""
    (design,) = (design for design in LEVEL_DESIGNS if design.change.startswith("a second board"))
    wall = stack(DOUBLE)
    wave = Wave(np.array([500.0]), np.zeros(1), AIR)
    for before, after in zip(wall.layers, design.stack(wall).layers, strict=True):
        if before is not wall.layers[1]:
            assert surface_density(after) == pytest.approx(2 * surface_density(before))
            assert bending_stiffness(after, wave) == pytest.approx(2 * bending_stiffness(before, wave))


def test_a_share_is_never_taken_away_altogether():
    share, added = np.full(5, 0.1), np.array([-10.0, -0.1, 0.0, 0.1, 1.0])
    assert np.all(with_share(share, added) > 0)
    np.testing.assert_allclose(with_share(share, added)[2:], [0.1, 0.2, 1.1])
    assert (with_share(share, share * 1e-6) - with_share(share, -share * 1e-6)) / (2e-6 * share) == pytest.approx(1)


def test_a_tabulated_law_is_what_the_changed_wall_does(tmp_path):
    problem = measured(tmp_path, {}).hypothesis
    place = LEVEL_PLACES["boards_mass"].instances(problem.settings)[0]
    law = DrawnLaw.at(place, BANDS, 0.3)
    start = np.concatenate([problem.start, law.constant(0.5)])
    changed = problem.with_effects(law).predict(start)
    factor = np.exp(0.15)
    for level, (name, (layer,)) in zip(changed, WALLS.items(), strict=True):
        heavier = stack([layer | {"density": layer["density"] * factor}])
        np.testing.assert_allclose(level, problem.data[[*WALLS].index(name)].response(heavier)[0], atol=0.15)


@pytest.mark.parametrize(
    ("acting", "place"),
    [
        ({"flanking_path": {"loss": 33.0, "slope": 2.0}}, "beside"),
        ({"receiving_absorption": {"level": 4.0}}, "reading"),
    ],
)
def test_an_effect_is_named_with_its_size(tmp_path, acting, place):
    (name, sizes) = next(iter(acting.items()))
    file = measured(
        tmp_path, acting, effects=["flanking_path", "receiving_absorption", "plate_losses"], uncertainty="repeatability"
    )
    told = []
    record = json.loads(diagnose_levels(file, progress=told.append).to_json())
    assert len(told) == N_STEPS
    assert record["verdict"] == "effect", record["sentence"]
    assert record["group"][0] == [name]
    first = next(iter(sizes))
    size = next(c for c in record["causes"] if c["effects"] == [name])["parameters"][f"{name}.{first}"]
    assert size["low"] < sizes[first] < size["high"]
    assert record["places"][0]["place"] == place
    assert record["where"][0]["quantity"] == "level"
    assert "imag" not in record["law"]


def test_an_unknown_cause_in_a_single_wall_is_told_with_its_place(tmp_path):
    """Real laws have no imaginary part that could be that of a causal response or not."""
    measured(tmp_path, {}, uncertainty="repeatability")
    table = np.loadtxt(tmp_path / "board.csv", delimiter=",", skiprows=1)
    others = np.loadtxt(tmp_path / "pane.csv", delimiter=",", skiprows=1)
    write(
        tmp_path,
        "transmission_loss",
        {"board": table[:, 1] + 4 * np.sin(2 * np.log(BANDS / 300)), "pane": others[:, 1]},
    )
    record = diagnose_levels(diagnosis_file(tmp_path, **described(uncertainty="repeatability")), effects={}).record
    assert record["verdict"] == "unknown"
    assert record["places"][0]["configuration"] == "board"
    assert (record["law"]["causal"], record["law"]["objection"]) == (None, "")


def test_without_an_effect_there_is_no_gap(tmp_path):
    found = diagnose_levels(measured(tmp_path, {}, effects=["leak", "receiving_absorption"]))
    assert (found.record["verdict"], found.record["causes"]) == ("no_gap", [])
    assert found.record["inputs"]["noise"]["board"] == "ISO 12999-1, repeatability"
    assert found.record["inputs"]["model_error"]["board"] == "ISO 12999-1, in situ beyond repeatability"
    assert found.curves[0].phase_before.size == 0


def test_a_gap_behind_an_absorber_is_named(tmp_path):
    wools = {"thin": [WOOL | {"name": "board"}], "thick": [WOOL | {"name": "board", "thickness": 0.1}]}
    unknowns = {"resistivity": {"paths": ["thin.layers.board.flow_resistivity", "thick.layers.board.flow_resistivity"],
                                "lognormal": [8e3, 0.05]}}  # fmt: skip
    file = measured(
        tmp_path, {"rear_air_gap": {"depth": 0.05}}, noise=0.005, kind="reverberation_absorption", walls=wools,
        unknowns=unknowns, effects=["rear_air_gap", "thickness_error", "flow_resistivity"],
        uncertainty="repeatability",
    )  # fmt: skip
    record = diagnose_levels(file).record
    assert record["group"][:1] == [["rear_air_gap"]], record["sentence"]


def test_what_is_remembered_is_what_is_computed(tmp_path):
    problem = measured(tmp_path, {}).hypothesis
    z = np.array([[0.3], [-0.2], [0.3]])
    before = problem.predict(z)
    fresh = tuple(replace(data, response=data.response.forgetful) for data in problem.data)
    for known, new in zip(before, replace(problem, observations=fresh).predict(z), strict=True):
        np.testing.assert_array_equal(known, new)
    part = problem.with_data([problem.data[0].part(np.array([1, 3]))])
    kept = np.isin(problem.data[0].burst, [1, 3])
    np.testing.assert_array_equal(part.predict(z)[0], before[0][:, kept])


def test_effects_are_those_of_what_is_measured(tmp_path):
    names = measured(tmp_path, {}).effect_names
    assert {"leak", "flanking_path", "structural_links"} <= set(names)
    assert not {"rear_air_gap", "sensor_mass", "microphone_gain"} & set(names)
    for name in ("microphone_gain", "sensor_mass"):
        with pytest.raises(ValidationError, match="of levels there are"):
            measured(tmp_path, {}, effects=[name])


def test_kinds_are_diagnosed_by_themselves(tmp_path):
    data = described()
    write(tmp_path, "transmission_loss", {name: np.full(len(BANDS), 30.0) for name in WALLS})
    write(tmp_path, "absorption", {"pane": np.full(len(BANDS), 0.3)})
    data["measurements"][1]["kind"] = "absorption"
    with pytest.raises(ValidationError, match="is diagnosed by itself"):
        diagnosis_file(tmp_path, **data)


def test_a_reverberation_room_is_a_diffuse_field_about_a_finite_sample(tmp_path):
    wools = {"thin": [WOOL | {"name": "board"}], "thick": [WOOL | {"name": "board", "thickness": 0.1}]}
    unknowns = {"resistivity": {"paths": ["thin.layers.board.flow_resistivity"], "lognormal": [8e3, 0.05]}}
    room = measured(tmp_path, {}, kind="reverberation_absorption", walls=wools, unknowns=unknowns)
    whole = {"incidence": {"diffuse": {"max_angle": 90.0}}, "finite_size": {"width": 3.0, "height": 3.6}}
    data = described(wools, unknowns=unknowns, kind="absorption")
    data["measurements"] = [measurement | whole for measurement in data["measurements"]]
    spelled = diagnosis_file(tmp_path, **data)
    z = np.zeros(1)
    for short, long in zip(room.hypothesis.predict(z), spelled.hypothesis.predict(z), strict=True):
        np.testing.assert_array_equal(short, long)
    assert np.max(room.hypothesis.predict(z)[1]) > 1.0  # edges of the sample absorb besides


@pytest.mark.parametrize(
    ("change", "message"),
    [({"incidence": "normal"}, "come from everywhere"), ({"finite_size": None}, "finite_size")],
)
def test_a_reverberation_room_without_a_sample_or_a_field_is_refused(tmp_path, change, message):
    write(tmp_path, "absorption", {name: np.full(len(BANDS), 0.5) for name in WALLS})
    data = described(kind="reverberation_absorption")
    data["measurements"][0] |= change
    with pytest.raises(ValidationError, match=message):
        diagnosis_file(tmp_path, **data)


def test_only_stacks_are_changed_by_effects_of_tubes_that_act_on_absorption():
    acting = {name for name, kind in EFFECTS.working() if acts_through_stack(kind())}
    assert acting == {"rear_air_gap", "thickness_error", "frame_motion", "facing"}
