"""Open rims that are worn away, beside a stepped rod, finer meshes, and depths between the tabled ones."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from multilayer.rig import partly_bonded, worn_rim
from multilayer.rig.mesh import Section, Slab
from multilayer.rig.partly_bonded import EDGES, on_plate, partly_bonded_disc, weighed
from multilayer.rig.worn_rim import DEPTHS, worn_change

SLOW = pytest.mark.slow
X = (np.linspace(0.02, 10, 300) / (1 + 0.15j))[None]
NONE = np.zeros((1, 1))
AT_REST = np.array([[1e-9 + 0j]])


def disc_of(ratio, shape, radii, rows):
    mesh = Section(radii, rows, (Slab("sample", 0.0, 1.0, 1.0, 1.0),)).mesh
    return worn_rim._Disc(mesh, ratio, 2 * shape)


def forces(disc, rim, depth):
    parts = on_plate([disc.forces(rim, depth)], 0.0)
    return weighed(parts, np.zeros((1, 1), dtype=int), np.ones((1, 1)), X)[:, 0]


def moved(forces):
    """Return the motion of a plate of three times the sample's mass."""
    return -forces[1] / (forces[0] - 3 * X[0])


@pytest.mark.parametrize("rim", [pytest.param(0.1, marks=SLOW), 0.3, pytest.param(0.5, marks=SLOW)])
def test_a_slim_rod_with_a_neck(rim):
    """Twice the length of a neck adds as much as a rod of its section is softer than the whole one."""
    disc = partly_bonded_disc(0.0, 0.05)
    bonded = disc.stiffness(AT_REST, NONE + rim, NONE)[0].real.item()
    soft = [
        1 / (bonded + worn_change(0.0, 0.05, AT_REST, NONE + rim, NONE + d)[0].real.item())
        for d in (DEPTHS[2], DEPTHS[3])
    ]
    assert soft[1] - soft[0] == pytest.approx((DEPTHS[3] - DEPTHS[2]) * (1 / (1 - rim) ** 2 - 1), rel=0.03)


def finely(ratio, shape, rim, depth):
    """Return the forces on a mesh of half the intervals, with a line at the depth."""
    radii, rows = (np.unique(np.round(line, 12)) for line in worn_rim._disc(ratio, shape).mesh.p)
    radii, rows = (np.unique([*line, *(line[1:] + line[:-1]) / 2]) for line in (radii, np.unique([*rows, 1 - depth])))
    return forces(disc_of(ratio, shape, radii, rows), rim, depth)


def tabled(ratio, shape, rim, depth):
    """Return the forces of the disc with an open rim, and those with what wearing it away changes."""
    at_rest = np.array(partly_bonded_disc(ratio, shape).stiffness(X, NONE + rim, NONE))[:, 0]
    return at_rest, at_rest + np.array(worn_change(ratio, shape, X, NONE + rim, NONE + depth))[:, 0]


@pytest.mark.parametrize(("ratio", "shape", "rim", "depth"), [(0.0, 0.45, 0.15, 1 / 16), (0.3, 0.9, 0.3, 1 / 8)])
def test_a_finer_mesh(ratio, shape, rim, depth):
    """Within 0.6 % of the largest motion, of which the depth changes more than 10."""
    exact = moved(finely(ratio, shape, rim, depth))
    at_rest, worn = map(moved, tabled(ratio, shape, rim, depth))
    assert np.abs(worn - exact).max() < 0.006 * np.abs(exact).max()
    assert np.abs(at_rest - exact).max() > 0.1 * np.abs(exact).max()


@pytest.mark.parametrize(("shape", "highest"), [(0.28, 60.0), (0.9, 20.0)])
def test_the_series_in_place_of_poles_hardly_differs_from_them(shape, highest, monkeypatch):
    """Which poles have a series differs from width to width: what that leaves out makes kinks in all that is fitted."""
    x = np.array([[highest / (1 + 0.3j)]])

    def of_widths():
        parts = [worn_rim._disc(0.0, shape).forces(rim, DEPTHS[2]) for rim in EDGES[10:15]]
        index = np.arange(len(parts))[:, np.newaxis]
        return weighed(on_plate(parts, 0.0), index, np.ones(index.shape), np.repeat(x, len(parts), axis=0))

    found = of_widths()
    monkeypatch.setattr(partly_bonded, "_KEPT", 400)
    exact = of_widths()
    for force, by_all_poles in zip(found, exact, strict=True):
        assert np.max(np.abs(force - by_all_poles)) < 5e-4 * np.max(np.abs(by_all_poles))


@pytest.mark.parametrize("depth", [1 / 64, pytest.param(3 / 64, marks=SLOW), 3 / 32])
@pytest.mark.parametrize("rim", [0.05, pytest.param(0.2, marks=SLOW), 0.4])
def test_depths_between_the_tabled_ones(rim, depth):
    """Within a tenth of what the depth changes."""
    exact = moved(finely(0.0, 0.45, rim, depth))
    at_rest, worn = map(moved, tabled(0.0, 0.45, rim, depth))
    assert np.abs(worn - exact).max() < 0.1 * np.abs(at_rest - exact).max()


# few widths: each asks for elements of its own
@given(st.sampled_from([0.0, 0.012, 0.13, 0.6]), st.floats(0, 1 / 8), st.sampled_from([(0.0, 0.45), (0.3, 0.9)]))
@example(0.0, 1 / 8, (0.0, 0.45))
@settings(max_examples=20, deadline=None)
@pytest.mark.slow
def test_worn_rims_are_softer_and_take_power(rim, depth, ratio_and_shape):
    ratio, shape = ratio_and_shape
    disc = partly_bonded_disc(ratio, shape)
    x = np.geomspace(1e-9, 30, 40)[None] / (1 + 0.2j)
    top, *_ = disc.stiffness(x, NONE + rim, NONE)
    change, *_ = worn_change(ratio, shape, x, NONE + rim, NONE + depth)
    assert -top[0, 0].real < change[0, 0].real <= 1e-6
    assert np.all(((top + change) * (1 + 0.2j)).imag > -1e-9)
    if rim == 0 or depth == 0:
        assert np.abs(change).max() < 1e-9


@pytest.mark.slow
def test_they_broadcast_over_samples():
    x = np.geomspace(0.1, 9, 5) * (1 - 0.2j)
    rims, depths = np.array([[0.02], [0.31]]), np.array([[0.1], [0.03]])
    together = np.array(worn_change(0.0, 0.9, x, rims, depths))
    alone = [np.array(worn_change(0.0, 0.9, x, r[None], d[None]))[:, 0] for r, d in zip(rims, depths, strict=True)]
    np.testing.assert_allclose(together, np.stack(alone, axis=1), rtol=1e-9, atol=1e-12)
