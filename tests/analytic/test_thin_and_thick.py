"""The power series and the waves are two forms of one layer: nothing jumps where it changes from one to the other."""

import numpy as np
import pytest

from multilayer.matrix import faces
from multilayer.matrix.wave import Wave
from multilayer.media.gas import dry_air
from multilayer.response import plane_wave
from multilayer.stack import Stack
from tests.analytic import mp_reference
from tests.analytic.materials import AIR, ALUMINIUM, BORON_CARBIDE, FOAM, FOAM2, GEL, RUBBER, WATER, stack

LAYERS = {
    "air": AIR, "water": WATER, "aluminium": ALUMINIUM, "boron carbide": BORON_CARBIDE, "rubber": RUBBER, "gel": GEL,
    "foam": FOAM, "soft foam": FOAM2,
}  # fmt: skip
POINTS = [(50.0, 0.0), (1e3, 0.0), (1e3, 45.0), (1e3, 89.0), (2e4, 80.0)]


def thickness_of_change(layer, frequency, angle, monkeypatch):
    """Return the thickness, m, below which the layer takes the series, found by bisection."""
    wave = Wave.incident(frequency, angle, dry_air())

    def takes_series(thickness):
        slab = layer.model_copy(update={"thickness": thickness})
        chosen = slab.faces(wave).back
        with monkeypatch.context() as patch:
            patch.setattr(faces, "THIN", np.inf)
            patch.setattr(faces, "_APART", np.inf)
            return np.array_equal(chosen, slab.faces(wave).back)

    thin, thick = 1e-9, 1e4
    assert takes_series(thin)
    while thick / thin > 1 + 1e-12:
        middle = np.sqrt(thin * thick)
        thin, thick = (middle, thick) if takes_series(middle) else (thin, middle)
    assert not takes_series(thick)
    return thick


@pytest.mark.parametrize("name", LAYERS)
def test_nothing_jumps_where_the_form_changes(name, monkeypatch):
    (layer,) = stack((LAYERS[name], 1.0)).layers
    for frequency, angle in POINTS:
        h = thickness_of_change(layer, frequency, angle, monkeypatch)
        slabs = [layer.model_copy(update={"thickness": h * factor}) for factor in (1 - 1e-11, 1 + 1e-11)]
        for termination in ("ambient", "rigid"):
            panels = [Stack(layers=(slab,), termination=termination) for slab in slabs]
            series, waves = (plane_wave(panel, frequency, angle) for panel in panels)
            assert abs(series.reflection - waves.reflection) < 1e-9, (frequency, angle)
            if termination == "ambient":
                assert abs(series.transmission / waves.transmission - 1) < 1e-9, (frequency, angle)


@pytest.mark.parametrize("name", ["boron carbide", "foam"])
def test_a_range_of_thicknesses_around_the_change(name, monkeypatch):
    (layer,) = stack((LAYERS[name], 1.0)).layers
    for frequency, angle in POINTS[2:]:
        h = thickness_of_change(layer, frequency, angle, monkeypatch)
        for factor in (0.1, 0.5, 0.9, 1.1, 2.0):
            panel = stack((LAYERS[name], factor * h))
            reflection, transmission = mp_reference.plane_wave(panel, frequency, angle)
            result = plane_wave(panel, frequency, angle)
            assert abs(result.reflection - reflection) < 1e-9
            assert abs(result.transmission / transmission - 1) < 1e-9


@pytest.mark.parametrize("name", LAYERS)
def test_of_many_thicknesses_the_states_of_waves_are_made_once(name):
    layer, f = stack((LAYERS[name], 0.5)).layers[0], np.geomspace(5e3, 2e4, 7)
    wave, thickness = Wave.incident(f, 45.0, dry_air()), np.linspace(20, 40, 5)
    many = layer.model_copy(update={"thickness": thickness[:, None]}).faces(wave)
    assert many.states.front.shape[2:] == f.shape
    for i, h in enumerate(thickness):
        one = layer.model_copy(update={"thickness": h}).faces(wave)
        for side in ("front", "back"):
            np.testing.assert_array_equal(getattr(many, side)[:, :, i], getattr(one, side))
