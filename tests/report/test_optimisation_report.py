"""What the report of an optimisation says of the rating that the search followed."""

import pytest

from multilayer.optimisation.file import OptimisationFile
from multilayer.optimisation.run import optimise
from multilayer.report.optimisation import optimisation_report

CLOTH = {"type": "screen", "name": "wall", "flow_resistance": 500.0}
WALL = {"type": "membrane", "name": "wall", "surface_density": 20.0}


@pytest.mark.parametrize(
    ("goal", "how"),
    [
        ("NRC", "without rounding"),
        ("SAA", "without rounding"),
        ("alpha_w", "with a real shift of its reference curve"),
        ("OITC", "without rounding"),
        ("Rw", "with a real shift of its reference curve"),
        ("Rw+C", "without rounding"),
        ("STC", "with a real shift of its reference curve"),
    ],
)
def test_it_says_how_a_rating_was_followed(goal, how):
    absorbs = goal in ("NRC", "SAA", "alpha_w")
    layers = [CLOTH, {"type": "fluid", "thickness": 0.1}] if absorbs else [WALL]
    field = "layers.wall.flow_resistance" if absorbs else "layers.wall.surface_density"
    result = optimise(
        OptimisationFile.model_validate(
            {
                "version": 1,
                "layers": layers,
                "termination": "rigid" if absorbs else "ambient",
                "frequency": {"third_octaves": [80, 5000]},
                "design": {field: [15, 900] if absorbs else [15, 30]},
                "goal": {"highest": goal},
                "search": {"starts": 1},
            }
        )
    )
    (note,) = optimisation_report(result).sections[0].remarks
    assert f"; {how}, as the search follows it, {goal} is " in note
