"""Cases that are computed together are the cases computed one by one."""

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.layers.fluid import Fluid
from multilayer.matrix.faces import Faces
from multilayer.simulation.batches import batches, run_batch
from multilayer.simulation.run import plan, run
from multilayer.simulation.settings import PlaneIncidence
from multilayer.simulation.tasks import Task, run_task
from multilayer.stack import Stack
from tests.simulation.files import FOAM, PANEL
from tests.simulation.test_run import read  # noqa: F401

THICKNESSES = np.geomspace(1e-4, 0.5, 7).tolist()  # power series, waves, and both in one batch
SWEEPS = {
    "thickness": (FOAM, {"layers.foam.thickness": THICKNESSES}),
    "medium": (FOAM, {"layers.foam.flow_resistivity": [1e3, 1e4, 1e5]}),
    "field of a law": (FOAM, {"layers.foam.young_modulus.loss_factor": [0.01, 0.1, 0.3]}),
    "another layer": (PANEL, {"layers.gap.thickness": [0.01, 0.1], "layers.back.thickness": [1e-3, 2e-3, 4e-3]}),
}


def one_by_one(tasks):
    return [run_task(task) for task in tasks]


@pytest.mark.parametrize("name", SWEEPS)
@pytest.mark.parametrize(
    "further", [{"incidence": 40}, {"frequency": {"octaves": [250, 1000]}}], ids=["lines", "bands"]
)
def test_the_same_as_one_by_one(read, name, further):  # noqa: F811
    text, sweep = SWEEPS[name]
    planned = plan(read(text, sweep=sweep, **further))
    (batch,) = batches(planned.tasks, [*sweep], 50)
    assert batch.values.keys() == sweep.keys()
    for together, alone in zip(run_batch(batch), one_by_one(planned.tasks), strict=True):
        assert together.quantities.keys() == alone.quantities.keys()
        for quantity, values in alone.quantities.items():
            np.testing.assert_allclose(together.quantities[quantity], values, rtol=1e-11, atol=1e-14)


def test_only_numbers_of_layers_go_together(read):  # noqa: F811
    """Of terminations and thicknesses, the thicknesses; of angles, of a diffuse field, of samples, none."""
    sweep = {"termination": ["rigid", "ambient"], "layers.gap.thickness": [0.01, 0.02, 0.03]}
    made = batches(plan(read(PANEL, sweep=sweep)).tasks, [*sweep], 50)
    assert [len(batch.tasks) for batch in made] == [3, 3]
    alone = [
        read(FOAM, sweep={"incidence": [0, 30]}),
        read(FOAM, layer_losses=True, sweep={"layers.foam.thickness": [0.01, 0.02]}),
        read(FOAM, incidence="diffuse", sweep={"layers.foam.thickness": [0.01, 0.02]}),
        read(
            FOAM, tolerances={"layers.foam.porosity": "1 %"}, samples=4, sweep={"layers.foam.thickness": [0.01, 0.02]}
        ),
    ]
    for simulation in alone:
        tasks = plan(simulation).tasks
        made = batches(tasks, [*simulation.cases[0].values], 50)
        assert [len(batch.tasks) for batch in made] == [1] * len(tasks)


def test_no_more_at_a_time_than_asked_for(read):  # noqa: F811
    sweep = {"layers.foam.thickness": THICKNESSES}
    planned = plan(read(FOAM, sweep=sweep))
    made = batches(planned.tasks, [*sweep], 3)
    assert [len(batch.tasks) for batch in made] == [3, 3, 1]
    assert [task for batch in made for task in batch.tasks] == [*planned.tasks]


def test_a_case_without_a_response_is_told(read, monkeypatch):  # noqa: F811
    """A layer that has no number in one of the cases, wherever that is in its batch."""
    whole = Fluid.faces

    def broken(layer, wave):
        faces = whole(layer, wave)
        front = faces.front * np.where(np.asarray(layer.thickness) == 0.02, np.nan, 1.0)
        return Faces(faces.family, front, faces.back)

    monkeypatch.setattr(Fluid, "faces", broken)
    simulation = read(PANEL, sweep={"layers.gap.thickness": [0.01, 0.02, 0.03]})
    with pytest.raises(InputError, match=r"gap\.thickness = 0\.02 m: the stack has no finite response"):
        run(plan(simulation))


class Stepped(Fluid):
    """A layer of a plugin that takes numbers only."""

    def faces(self, wave):
        return super().faces(wave) if self.thickness > 0.02 else Fluid(thickness=1e-3).faces(wave)


def test_layers_that_take_no_arrays_are_computed_one_by_one():
    tasks = [
        Task(Stack(layers=[Stepped(name="gap", thickness=h)]), np.array([500.0]), PlaneIncidence(angle=0.0))
        for h in (0.01, 0.03)
    ]
    (batch,) = batches(tasks, ["layers.gap.thickness"], 50)
    for together, alone in zip(run_batch(batch), one_by_one(tasks), strict=True):
        np.testing.assert_array_equal(together.quantities["reflection"], alone.quantities["reflection"])
