"""The drawing of a place with its law: of every place of a rig, a tube or levels."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.patches import Rectangle

from multilayer.diagnosis.places import LEVEL_PLACES, PLACES, TUBE_PLACES
from multilayer.report.place_figures import draw_place
from multilayer.report.style import colour, figure_style

EVERY = [
    pytest.param(kind, name, variant, id=f"{kind or 'rig'}-{name}-{variant.variant}")
    for kind, registry in (("", PLACES), ("tube", TUBE_PLACES), ("levels", LEVEL_PLACES))
    for name, place in registry.working()
    for variant in place.variants()
]


@pytest.mark.parametrize(("kind", "name", "place"), EVERY)
def test_labels_stay_beside_their_axes(kind, name, place):
    f = np.geomspace(100, 1500, 20)
    parts = {f"{part}{end}": (0.1 * f / 1500).tolist() for part in ("real", "imag") for end in ("", "_low", "_high")}
    law = {
        "place": name,
        "variant": place.variant,
        "kind": kind,
        "quantity": place.quantity,
        "unit": place.unit,
        "frequency_hz": f.tolist(),
        **parts,
    }
    with figure_style():
        figure = draw_place(law)
        figure.draw(FigureCanvasAgg(figure).get_renderer())
        drawing, real, _ = figure.axes
        label = real.yaxis.label.get_window_extent()
        assert label.y0 >= 0
        assert label.y1 <= figure.bbox.y1
        assert label.x0 >= drawing.get_window_extent().x1


@pytest.mark.parametrize(
    ("name", "variant", "marked"),
    [
        ("one_configuration", "", "sample"),
        ("one_configuration", "height", "sample"),
        ("one_configuration", "plate", "plate"),
        ("plate", "", "plate"),
        ("sample", "", "sample"),
    ],
)
def test_what_is_another_is_marked(name, variant, marked):
    f = np.geomspace(100, 1500, 20)
    parts = {f"{part}{end}": (0.1 * f).tolist() for part in ("real", "imag") for end in ("", "_low", "_high")}
    figure = draw_place({"place": name, "variant": variant, "quantity": "q", "unit": "", "frequency_hz": f, **parts})
    boxes = [patch for patch in figure.axes[0].patches if isinstance(patch, Rectangle)]
    (box,) = [box for box in boxes if to_hex(box.get_facecolor()) == to_hex(colour(1))]
    assert (box.get_y() > 0.5) == (marked == "plate")
