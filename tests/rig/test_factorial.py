"""The numerical validation of the paper, in small: the same code as the page's, on a handful of cases."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.executors import local_pool
from multilayer.rig import TwoPlateRig, static_shape_factor
from validation import factorial
from validation.factorial import kept_in, run
from validation.factorial_cases import Design, Points, Table
from validation.factorial_page import write_page
from validation.factorial_rig import respond

SMALL = Design(
    frequencies=(100.0, 300.0),
    moduli=(1e6,),
    poisson_ratios=(0.0, 0.3),
    loss_factors=(0.1, 0.4),
    densities=(50.0, 200.0),
    thicknesses=(0.025,),
)


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Return the store of the small design, and what it holds."""
    store = kept_in(tmp_path_factory.mktemp("factorial") / "results.jsonl", SMALL)
    return store, run(SMALL, store, local_pool(1))


def test_moduli_are_found_as_theory_has_them(done):
    table = Table.of(done[1].outcomes)
    assert len(table) == SMALL.n_cases == 16
    flat, bulging = (table["poisson_ratio"] == nu for nu in (0.0, 0.3))
    for name in ("storage", "loss"):
        assert table[name][flat] == pytest.approx(1.0, abs=2e-3)
    slow = bulging & (table["frequency"] == 100)
    limit = 0.7 / (1.3 * 0.4) / static_shape_factor(0.3, 0.0225 / 0.05)
    assert table["storage"][slow] == pytest.approx(limit, rel=0.01)
    assert np.all(table["plausible"] == 1)


@pytest.mark.parametrize(
    ("design", "reduced"),
    [
        (SMALL, True),
        (replace(SMALL, frequencies=(2000.0,), moduli=(1e5,), densities=(400.0,), thicknesses=(0.010,)), False),
    ],
    ids=["reduced basis", "one by one"],
)
def test_transmissibilities_are_those_of_full_solutions(design, reduced):
    task = next(task for task in design.tasks if task.poisson_ratio == 0.3)
    response, points = respond(task), Points.of(task)
    assert bool(response.reduction) == reduced
    assert all(error < 1e-5 * size for size, error in response.reduction)
    where = (-1, -1, 0, slice(None, None, 4))
    rig = TwoPlateRig(0.0225, task.thickness, design.densities[-1], 0.3, 1e-3)
    direct = rig.transmissibility(points.frequency[where], points.modulus[where])
    error = np.abs(response.values[where] - direct) / np.abs(direct)
    # the longest samples have coarser meshes; the page tells their errors
    assert np.all(error < (1e-4 if reduced else 3e-2))
    assert response.mesh


def test_goes_on_where_it_was_killed(done, tmp_path, monkeypatch):
    store, whole = done
    text = store.path.read_text()
    again = kept_in(tmp_path / "results.jsonl", SMALL)
    again.path.write_text(text[: len(text) - 300])
    asked = []
    monkeypatch.setattr(factorial, "solve", lambda task: asked.append(task.key) or whole.outcomes[-1])
    found = run(SMALL, again, nullcontext())
    assert asked == [whole.outcomes[-1].key]
    assert found.outcomes == whole.outcomes
    assert found.n_computed == 1
    assert again.path.read_text() == text


def test_results_of_another_design_are_refused(done):
    with pytest.raises(InputError, match="another file"):
        kept_in(done[0].path, replace(SMALL, thicknesses=(0.050,))).begin(resume=True)


def test_page_tells_what_was_found(done, tmp_path):
    page = write_page(done[1], tmp_path)
    assert "16 cases" in page
    figures = sorted(path.name for path in tmp_path.iterdir())
    assert figures
    assert all(name in page for name in figures)
