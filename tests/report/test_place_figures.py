"""The drawing of a place with its law: of every place of a rig, a tube or levels."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from multilayer.diagnosis.places import LEVEL_PLACES, PLACES, TUBE_PLACES
from multilayer.report.place_figures import draw_place
from multilayer.report.style import figure_style

EVERY = [
    pytest.param(kind, name, place, id=f"{kind or 'rig'}-{name}")
    for kind, registry in (("", PLACES), ("tube", TUBE_PLACES), ("levels", LEVEL_PLACES))
    for name, place in registry.working()
]


@pytest.mark.parametrize(("kind", "name", "place"), EVERY)
def test_labels_stay_beside_their_axes(kind, name, place):
    f = np.geomspace(100, 1500, 20)
    parts = {f"{part}{end}": (0.1 * f / 1500).tolist() for part in ("real", "imag") for end in ("", "_low", "_high")}
    law = {
        "place": name,
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
