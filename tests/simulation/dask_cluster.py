"""A Dask scheduler and workers in processes of their own, as on a cluster."""

import json
import os
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

_ROOT = Path(__file__).parents[2]


class Cluster:
    """Its address, and its processes."""

    def __init__(self, address, scheduler, workers):
        self.address = address
        self.scheduler = scheduler
        self.workers = workers


@contextmanager
def dask_cluster(folder, workers, seconds=55):
    """Start a scheduler and workers on this machine; end them after some time, and whatever happens."""
    processes = []

    def start(module, *arguments):
        command = [sys.executable, "-m", f"distributed.cli.{module}", *map(str, arguments)]
        environment = {**os.environ, "PYTHONPATH": str(_ROOT)}
        with (folder / f"{module}-{len(processes)}.log").open("wb") as log:
            processes.append(subprocess.Popen(command, cwd=folder, env=environment, stdout=log, stderr=log))
        return processes[-1]

    def end():
        for process in processes:
            process.kill()

    watchdog = threading.Timer(seconds, end)
    watchdog.start()
    try:
        file = folder / "scheduler.json"
        local = ("--no-dashboard", "--host", "127.0.0.1")
        scheduler = start("dask_scheduler", *local, "--port", 0, "--scheduler-file", file)
        address = _address(file, seconds)
        alone = ("--no-nanny", "--nthreads", 1, "--local-directory", folder)
        yield Cluster(address, scheduler, [start("dask_worker", address, *local, *alone) for _ in range(workers)])
    finally:
        watchdog.cancel()
        end()
        for process in processes:
            process.wait()


def _address(file, seconds):
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        try:
            return json.loads(file.read_text())["address"]
        except (OSError, ValueError, KeyError):
            time.sleep(0.05)
    raise TimeoutError("the Dask scheduler did not start")
