"""Sweeps on a real Dask cluster, of which a worker dies."""

import signal

import pytest

from multilayer import executors
from multilayer.errors import InputError
from multilayer.executors import LostWorkerWarning, cluster
from multilayer.simulation import load_simulation, simulate
from tests.cli.command import run
from tests.simulation.dask_cluster import dask_cluster
from tests.simulation.files import FOAM

distributed = pytest.importorskip("distributed", reason="the extra [cluster] is not installed")

SWEEP = """\
sweep: {layers.foam.thickness: [10 mm, 20 mm, 30 mm, 40 mm]}
tolerances: {layers.foam.flow_resistivity: 30 %}
samples: 500
"""
N_TASKS = 4 * 11  # of each case the nominal one and ten chunks of 50 samples


@pytest.fixture
def file(tmp_path):
    (tmp_path / "foam.yaml").write_text(FOAM + SWEEP)
    return tmp_path / "foam.yaml"


@pytest.mark.slow
def test_a_worker_killed_during_the_run_changes_nothing(file, tmp_path):
    simulation = load_simulation(file)
    alone = simulate(simulation)
    done, seen = [], []
    with dask_cluster(tmp_path, workers=2) as dask, distributed.Client(dask.address, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=30)

        def kill_one(label):
            done.append(label)
            if len(done) == 3:
                seen.append(client.processing())
                dask.workers[0].send_signal(signal.SIGKILL)
                assert dask.workers[0].wait(10) == -signal.SIGKILL

        with cluster(dask.address) as executor:
            together = simulate(simulation, executor, kill_one)
        assert len(client.scheduler_info()["workers"]) == 1
    # both were at work when one was killed, and every task came back once
    assert [len(tasks) > 0 for tasks in seen[0].values()] == [True, True]
    assert len(done) == N_TASKS
    assert together.to_csv() == alone.to_csv()
    assert together.to_dict() == alone.to_dict()


def test_a_scheduler_killed_during_the_run_changes_nothing(file, tmp_path):
    simulation = load_simulation(file)
    done = []
    with dask_cluster(tmp_path, workers=1) as dask:

        def kill(label):
            done.append(label)
            if len(done) == 3:
                dask.scheduler.send_signal(signal.SIGKILL)

        told = pytest.warns(LostWorkerWarning, match=f"of {N_TASKS} tasks, which were computed here instead")
        with told, cluster(dask.address) as executor:
            result = simulate(simulation, executor, kill)
    assert len(done) == N_TASKS
    assert result.to_csv() == simulate(simulation).to_csv()


def test_from_the_command_line(file, tmp_path):
    options = ("--no-figures", "--json")
    with dask_cluster(tmp_path, workers=1) as dask:
        there = run("simulate", file, "--cluster", dask.address, "--out", tmp_path / "there", *options)
    here = run("simulate", file, "--out", tmp_path / "here", *options)
    assert there == here
    assert (here.status, here.err) == (0, "")


def test_a_plugin_file_reaches_the_workers(file, tmp_path):
    plugin = tmp_path / "plugin.py"
    plugin.write_text(
        "from typing import Literal\nfrom multilayer.layers.poroelastic import Poroelastic\n"
        "class OurFoam(Poroelastic):\n    type: Literal['our_foam'] = 'our_foam'\n"
    )
    file.write_text(file.read_text().replace("type: poroelastic", "type: our_foam"))
    command = ("simulate", file, "--plugin", plugin, "--no-figures", "--json")
    with dask_cluster(tmp_path, workers=1) as dask:
        there = run(*command, "--cluster", dask.address, "--out", tmp_path / "there")
    here = run(*command, "--out", tmp_path / "here")
    assert there == here
    assert (here.status, here.err) == (0, "")  # no worker was lost, whose work would have been done here


def test_a_cluster_without_workers(tmp_path, monkeypatch):
    monkeypatch.setattr(executors, "CONNECT_SECONDS", 2)
    refused = pytest.raises(InputError, match=r"no worker of the scheduler at .* answers")
    with dask_cluster(tmp_path, workers=0) as dask, refused, cluster(dask.address):
        pass
