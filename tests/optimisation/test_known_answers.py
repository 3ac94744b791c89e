"""Problems whose best design is known, in closed form or by going through a grid."""

import numpy as np
import pytest

from multilayer.optimisation import search
from multilayer.optimisation.file import OptimisationFile
from multilayer.optimisation.predict import Predictor
from multilayer.optimisation.run import MOST_VARIANTS, evaluated, optimise
from multilayer.response import plane_wave
from multilayer.simulation.bands import grid_of
from multilayer.stack import Stack

C = Stack(layers=[{"type": "fluid", "thickness": 1.0}]).ambient.gas.sound_speed
RHO_C = Stack(layers=[{"type": "fluid", "thickness": 1.0}]).ambient.gas.impedance


def read(**data):
    return OptimisationFile.model_validate({"version": 1, "termination": "rigid", **data})


def test_quarter_wave_absorber():
    """A resistance of rho c a quarter of a wavelength before a wall swallows everything."""
    f = 500.0
    result = optimise(
        read(
            layers=[
                {"type": "screen", "name": "cloth", "flow_resistance": 2000.0},
                {"type": "fluid", "name": "gap", "thickness": 0.05},
            ],
            frequency=[f],
            design={"layers.cloth.flow_resistance": [50, 5000], "layers.gap.thickness": [0.02, 0.3]},
            goal={"highest": "absorption"},
        )
    )
    assert result.best.goals[0] == pytest.approx(1.0, abs=1e-6)
    assert result.best.values["cloth.flow_resistance"] == pytest.approx(RHO_C, rel=1e-3)
    assert result.best.values["gap.thickness"] == pytest.approx(C / (4 * f), rel=1e-3)


def test_mass_law():
    """The lightest limp wall of a transmission loss is that of the mass law: |1 + i w m/(2 rho c)|^2."""
    f, loss = 500.0, 30.0
    result = optimise(
        read(
            layers=[{"type": "membrane", "name": "wall", "surface_density": 20.0}],
            termination="ambient",
            frequency=[f],
            design={"layers.wall.surface_density": [0.5, 50]},
            goal={"lowest": "mass"},
            limits=[{"of": "transmission_loss", "at_least": "30 dB", "from": f, "to": f}],
        )
    )
    mass = 2 * RHO_C / (2 * np.pi * f) * np.sqrt(10 ** (loss / 10) - 1)
    assert result.best.goals[0] == pytest.approx(mass, rel=1e-5)
    assert result.best.limits[0] >= loss - 1e-5


def test_micro_perforated_panel_resonates_where_it_is_wanted():
    """Its reactance and the cavity's cancel, and its resistance is rho c, at the frequency of the best absorption."""
    f = 500.0
    result = optimise(
        read(
            layers=[
                {
                    "type": "perforated_plate", "name": "mpp", "model": "maa", "thickness": 1e-3, "hole_radius": 2e-4,
                    "perforation": 0.02,
                },
                {"type": "fluid", "name": "cavity", "thickness": 0.05},
            ],
            frequency=[f],
            design={"layers.mpp.perforation": [0.002, 0.05], "layers.cavity.thickness": [0.01, 0.15]},
            goal={"highest": "absorption"},
        )
    )  # fmt: skip
    assert result.best.goals[0] == pytest.approx(1.0, abs=1e-6)
    stack = result.best.simulation.stack
    plate = Stack(layers=stack.layers[:1], termination="ambient")
    front = complex(plane_wave(plate, f).surface_impedance) - RHO_C  # the series impedance of the plate
    depth = result.best.values["cavity.thickness"]
    assert front.real == pytest.approx(RHO_C, rel=2e-3)
    assert front.imag == pytest.approx(RHO_C / np.tan(2 * np.pi * f * depth / C), abs=2e-3 * RHO_C)


FOAM = {
    "type": "equivalent_fluid", "name": "foam", "model": "miki", "thickness": 0.02, "flow_resistivity": 1e4,
}  # fmt: skip
TWO = {
    "layers": [FOAM, {"type": "fluid", "name": "gap", "thickness": 0.02}],
    "frequency": {"third_octaves": [200, 5000]},
    "design": {"layers.foam.flow_resistivity": [3000, 60000], "layers.foam.thickness": [0.005, 0.045]},
    "goal": {"highest": "alpha_w"},
}


@pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")
@pytest.mark.parametrize("goal", ["alpha_w", "NRC"])
def test_no_design_on_a_grid_is_better(goal):
    file = read(**{**TWO, "goal": {"highest": goal}})
    best = optimise(file).best
    variant = file.space.variant(())
    axis = np.linspace(0, 1, 41)
    x = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    predictor = Predictor(variant, grid_of(file.frequency), {}, file.goals)
    on_grid = file.goals[0].values(predictor.figures(variant, x))[:, 0]
    assert best.followed[0] >= on_grid.max() - 2e-4
    assert best.followed[0] - on_grid.max() < 0.01


@pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")
def test_every_choice_is_tried():
    """Order, what is left out and materials: the best is the best of all that are simulated one by one."""
    file = read(
        layers=[
            {**FOAM, "name": "a", "flow_resistivity": 5e3},
            {**FOAM, "name": "b", "flow_resistivity": 5e4, "thickness": 0.01},
            {"type": "fluid", "name": "gap", "thickness": 0.02},
        ],
        frequency={"third_octaves": [200, 5000]},
        design={"order": ["a", "b", "gap"], "optional": ["gap", "b"], "layers.a.thickness": {"among": [0.01, 0.02]}},
        goal={"highest": "SAA"},
        limits=[{"of": "thickness", "at_most": 0.045}],
    )
    # two thicknesses; six orders of three, two of a and b, two of a and gap, a alone
    assert (file.space.count, len(file.space.variants())) == (48, 2 * (6 + 2 + 2 + 1))
    result = optimise(file)
    designs = [evaluated(file, variant, np.zeros(0)) for variant in file.space.variants()]
    kept = [design for design in designs if design.is_kept]
    assert 0 < len(kept) < len(designs)
    assert result.best.followed[0] == max(design.followed[0] for design in kept)


@pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")
def test_front():
    """Of thickness and absorption no design of a grid is better in both, and the ends are those of each goal alone."""
    file = read(**{**TWO, "goal": [{"highest": "SAA"}, {"lowest": "thickness"}]})
    result = optimise(file)
    alone = optimise(read(**{**TWO, "goal": {"highest": "SAA"}}))
    values = np.array([design.followed for design in result.designs])
    assert len(values) >= 8
    assert values[0, 0] == pytest.approx(alone.best.followed[0], abs=1e-3)
    assert values[:, 1].min() == pytest.approx(0.025, rel=1e-6)
    assert np.all(np.diff(values, axis=0) <= 0)  # less absorption, less thickness
    variant, axis = file.space.variant(()), np.linspace(0, 1, 31)
    x = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    figures = Predictor(variant, grid_of(file.frequency), {}, file.goals).figures(variant, x)
    absorbed, thick = (aim.values(figures)[:, 0] for aim in file.goals)
    for saa, thickness in values:
        assert not np.any((absorbed > saa + 2e-3) & (thick <= thickness))


@pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")
def test_many_choices(monkeypatch):
    """Of more choices than are gone through, the global search finds what going through all of them on a grid has."""
    monkeypatch.setattr(search, "_GENERATIONS", 12)
    file = read(
        layers=[{**FOAM, "name": name, "thickness": 0.01} for name in "abc"]
        + [{"type": "fluid", "name": "gap", "thickness": 0.02}],
        frequency=[500.0, 1000.0],
        design={
            "order": ["a", "b", "gap"],
            "layers.a.flow_resistivity": {"among": [3e3, 3e4, 6e4]},
            "layers.b.thickness": {"among": [0.005, 0.02]},
            "layers.c.flow_resistivity": {"among": [3e3, 5e4]},
            "layers.gap.thickness": [0.005, 0.03],
        },
        goal={"highest": "absorption"},
        limits=[{"of": "thickness", "at_most": 0.055}],
        search={"starts": 2},
    )
    assert file.space.count == 6 * 3 * 2 * 2 > MOST_VARIANTS
    predictor = Predictor(file.space.variant((0,) * 5), grid_of(file.frequency), {}, (*file.goals, *file.bounds))
    best = -np.inf
    for variant in file.space.variants():
        figures = predictor.figures(variant, np.linspace(0, 1, 11)[:, None])
        kept = file.bounds[0].slack(file.bounds[0].values(figures)[:, 0]) >= 0
        best = max(best, *file.goals[0].values(figures)[kept, 0])
    found = optimise(file).best.goals[0]
    assert best - 1e-9 <= found < best + 0.01
