"""Designs that cannot be computed, and choices that do not fit each other, end no search; all that differ are tried."""

from dataclasses import replace

import pytest

from multilayer.errors import InputError
from multilayer.optimisation import run, search
from multilayer.optimisation.run import LeftOutWarning, evaluated, optimise
from tests.optimisation.test_known_answers import FOAM, read
from tests.optimisation.test_predict import RESONATORS

pytestmark = pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")

WOOL = {
    "layers": [
        {
            "type": "equivalent_fluid", "name": "wool", "model": "delany_bazley", "flow_resistivity": 20e3,
            "thickness": 0.05,
        }
    ],
    "frequency": {"third_octaves": [100, 5000]},
    "design": {"layers.wool.thickness": [0.02, 0.06]},
    "search": {"starts": 2},
}  # fmt: skip
"""Where it is thin, this model creates energy at 100 Hz."""


def thinnest():
    """Return the least thickness of the wool, m, that a simulation accepts."""
    file = read(**WOOL, goal={"lowest": "thickness"})
    (variant,), (low, high) = file.space.variants(), (0.0, 1.0)
    x = variant.written
    for _ in range(14):
        x[0] = (low + high) / 2
        try:
            evaluated(file, variant, x)
        except InputError:
            low = x[0]
        else:
            high = x[0]
    return 0.02 + 0.04 * high


def test_the_search_avoids_what_creates_energy():
    result = optimise(read(**WOOL, goal=[{"highest": "alpha_w"}, {"lowest": "thickness"}]))
    thicknesses = [design.values["wool.thickness"] for design in result.designs]
    assert len(thicknesses) >= 8
    assert min(thicknesses) == pytest.approx(thinnest(), abs=1e-3)
    assert result.left_out == ()


def test_what_a_simulation_refuses_is_left_out():
    """Of thickness alone the search computes no response: the thinnest is refused, and others take its place."""
    with pytest.warns(LeftOutWarning, match=r"as a simulation refuses them: \d+; the first: wool.thickness = 20 mm: "):
        result = optimise(read(**WOOL, goal={"lowest": "thickness"}))
    assert thinnest() <= result.best.goals[0] < thinnest() + 3e-3
    assert "gives back more energy" in result.left_out[0]
    assert result.to_dict()["left_out"] == [*result.left_out]


@pytest.mark.filterwarnings("ignore::multilayer.optimisation.run.LeftOutWarning")
@pytest.mark.parametrize(("goal", "text"), [("alpha_w", "no design has a response; of"), ("thickness", "no design is")])
def test_none_is_left(goal, text):
    design = {"layers.wool.thickness": [0.02, 0.025]}
    with pytest.raises(InputError, match=f"{text}.*more energy"):
        optimise(read(**{**WOOL, "design": design}, goal={"lowest": goal}))


def test_the_file_as_written_is_refused():
    layers = [{**WOOL["layers"][0], "thickness": 0.02}]
    with pytest.warns(LeftOutWarning, match="as the file has it, the stack has no figures: the response gives back"):
        result = optimise(read(**{**WOOL, "layers": layers}, goal=[{"highest": "alpha_w"}, {"lowest": "thickness"}]))
    assert result.written.case is None
    assert result.written.goals == pytest.approx([float("nan"), 0.02], nan_ok=True)
    assert result.to_dict()["written"]["goals"] == [None, 0.02]
    assert result.to_csv().splitlines()[1] == "as written,0.02,,0.02"


def test_the_file_as_written_ends_otherwise():
    """Before a rigid wall a stack has no index of a wall; where it lets sound through, none of an absorber."""
    for written, chosen, goal in (("rigid", "ambient", "Rw"), ("ambient", "rigid", "alpha_w")):
        data = {
            "layers": [FOAM], "termination": written, "frequency": {"third_octaves": [100, 5000]},
            "design": {"termination": {"among": [chosen]}, "layers.foam.thickness": {"among": [0.02, 0.03]}},
            "goal": {"highest": goal},
        }  # fmt: skip
        result = optimise(read(**data))
        assert result.written.goals == pytest.approx([float("nan")], nan_ok=True)
        assert result.best.simulation.termination == chosen


NECKS = {
    "layers": [{**RESONATORS["layers"][0], "neck_radius": 1e-3, "pitch": 0.012}],
    "frequency": [500.0],
    "design": {"layers.r.neck_radius": {"among": [5e-3, 1e-3]}, "layers.r.pitch": {"among": [6e-3, 12e-3]}},
    "goal": {"highest": "absorption"},
}  # the first of each do not fit each other


def test_choices_that_do_not_fit_each_other():
    with pytest.warns(LeftOutWarning, match=r"not allowed together: 1; the first: r.neck_radius = 0.005, r.pitch = 0"):
        result = optimise(read(**NECKS))
    assert len(result.designs) == 3
    assert len(result.left_out) == 1


def test_sizes_are_known_where_choices_do_not_fit():
    file = read(**{**NECKS, "goal": {"lowest": "mass"}, "catalogue": {"r": {"mass": 1.0}}})
    assert len(file.space.variants()) == 3
    with pytest.raises(ValueError, match="the mass of layer r is not known"):
        read(**{**NECKS, "goal": {"lowest": "mass"}})


def test_many_choices_that_do_not_fit(monkeypatch):
    """Of necks and pitches that mostly do not fit, the global search meets those that do."""
    monkeypatch.setattr(search, "_GENERATIONS", 4)
    design = {
        "layers.r.neck_radius": {"among": [1e-3, *(2e-3 + i * 1e-4 for i in range(12))]},
        "layers.r.pitch": {"among": [3.7e-3, 12e-3, *(3.8e-3 + i * 1e-5 for i in range(6))]},
    }
    file = read(**{**NECKS, "design": design})
    assert file.space.count > run.MOST_VARIANTS
    allowed = file.space.variants()
    with pytest.warns(LeftOutWarning, match="not allowed together"):
        result = optimise(file)
    best = max(evaluated(file, variant, variant.written).goals[0] for variant in allowed)
    assert result.best.goals[0] == pytest.approx(best)
    assert 0 < len(result.left_out) <= file.space.count - len(allowed)


def test_no_choices_fit():
    layers = [{**NECKS["layers"][0], "neck_radius": 1e-3, "pitch": 0.012}]
    design = {"layers.r.neck_radius": {"among": [4e-3, 5e-3]}, "layers.r.pitch": {"among": [6e-3, 7e-3]}}
    with pytest.raises(InputError, match="none of 4 combinations of choices is allowed, choose values that fit each"):
        optimise(read(**{**NECKS, "layers": layers, "design": design}))


def test_the_cheaper_of_two_materials_alike():
    """Both fields of the model stand in the layer: the materials differ in their prices alone."""
    dear, cheap = "AA2009/T11.3/foam", "AA2009/T11.6/foam"
    layer = {**FOAM, "material": dear, "flow_resistivity": 1e4}
    file = read(
        layers=[layer],
        frequency=[500.0],
        design={"layers.foam.material": {"among": [dear, cheap]}},
        goal={"lowest": "price"},
        catalogue={dear: {"price": 2.0}, cheap: {"price": 1.0}},
    )
    one, other = file.space.variants()
    assert one.simulation.to_dict() == other.simulation.to_dict()
    assert optimise(file).best.goals == (1.0,)


def test_which_of_two_layers_alike_may_vary():
    """Of two foams about a screen that which may vary stands in front, or behind; where both may, it is one variant."""
    alike = {key: value for key, value in FOAM.items() if key != "name"}
    layers = [alike, {"type": "screen", "flow_resistance": 500.0}, alike]
    data = {"layers": layers, "frequency": [500.0], "goal": {"highest": "absorption"}}
    front = {"layers.0.thickness": [0.01, 0.05], "order": [0, 2]}
    one, other = read(**data, design=front).space.variants()
    assert (one.ranges[0].path, other.ranges[0].path) == ("layers.0.thickness", "layers.2.thickness")
    assert len(read(**data, design={**front, "layers.2.thickness": [0.01, 0.05]}).space.variants()) == 1


def test_the_list_is_gone_down_until_enough_keep_the_limits(monkeypatch):
    """Of choices alone, the first six miss a limit when they are computed exactly, and the next are told."""
    thicknesses = [0.01 * i for i in range(1, 10)]
    exact = run.evaluated

    def strict(file, variant, x, name=""):
        design = exact(file, variant, x, name)
        return replace(design, is_kept=design.goals[0] > 0.065, limits=(0.0,))

    monkeypatch.setattr(run, "evaluated", strict)
    file = read(
        layers=[FOAM],
        frequency=[500.0],
        design={"layers.foam.thickness": {"among": thicknesses}},
        goal={"lowest": "thickness"},
        limits=[{"of": "absorption", "at_least": 0.01}],
    )
    assert [design.goals[0] for design in optimise(file).designs] == pytest.approx([0.07, 0.08, 0.09])


def test_choices_that_begin_alike_have_labels_of_their_own():
    """Mappings longer than a line are cut where they are shown; designs and what is left out go by these labels."""
    wools = [
        {
            "type": "equivalent_fluid", "model": "jca", "thickness": 0.05, "porosity": 0.95, "flow_resistivity": 20e3,
            "tortuosity": 1.1, "viscous_length": 1e-4, "thermal_length": thermal,
        }
        for thermal in (2e-4, 3e-4)
    ]  # fmt: skip
    file = read(**{**WOOL, "design": {"layers.0": {"among": wools}}}, goal={"highest": "alpha_w"})
    labels = [variant.label for variant in file.space.variants()]
    assert labels == ["0 = {'thermal_length': 0.0002}", "0 = {'thermal_length': 0.0003}"]
