"""Executors that fail, and what is left of their work."""

import os
import signal
import subprocess
import sys
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from multiprocessing import get_context
from textwrap import dedent
from threading import Event
from types import SimpleNamespace

import pytest

from multilayer import executors
from multilayer.errors import InputError
from multilayer.executors import LostWorkerWarning, cluster, local_pool, prepared, run_all


def square(x):
    return x * x


def square_or_die(x):
    """End this process the hard way on 3, unless it is the one the tests run in."""
    if x == 3 and os.environ.get("MULTILAYER_TEST_MAIN") != str(os.getpid()):
        os.kill(os.getpid(), signal.SIGKILL)
    return x * x


def refuse(x):
    raise InputError([f"{x} is bad"])


def stumble(x):
    raise ZeroDivisionError(f"{x} fell")


def square_or_wait(x):
    """Wait for ever on 3, unless this is the process the tests run in."""
    if x == 3 and os.environ.get("MULTILAYER_TEST_MAIN") != str(os.getpid()):
        Event().wait()
    return x * x


def threads(_):
    return [os.environ.get(name) for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")]


class Forgetful(Executor):
    """Fails on every other task, and takes no more after some."""

    def __init__(self, most):
        self.left = most

    def submit(self, function, /, *arguments):
        self.left -= 1
        if self.left < 0:
            raise RuntimeError("no more")
        future = Future()
        if self.left % 2:
            future.set_exception(OSError("gone\nfor good"))
        else:
            future.set_result(function(*arguments))
        return future


def ignore(index):
    pass


def test_in_this_process():
    done = []
    assert run_all(square, [1, 2, 3], None, done.append) == [1, 4, 9]
    assert done == [0, 1, 2]


def test_nothing_to_do():
    assert run_all(square, [], None, ignore) == []


def test_what_an_executor_loses_is_computed_here():
    done = []
    with pytest.warns(LostWorkerWarning, match=r"failed on 4 of 6 tasks, .* computed here instead \((OS|Runtime)Error"):
        assert run_all(square, range(6), Forgetful(4), done.append) == [0, 1, 4, 9, 16, 25]
    assert sorted(done) == list(range(6))


def test_a_killed_worker_of_a_process_pool(monkeypatch):
    monkeypatch.setenv("MULTILAYER_TEST_MAIN", str(os.getpid()))
    with (
        ProcessPoolExecutor(2, get_context("spawn")) as pool,
        pytest.warns(LostWorkerWarning, match="BrokenProcessPool"),
    ):
        assert run_all(square_or_die, range(8), pool, ignore) == [x * x for x in range(8)]


def test_mistakes_of_the_input_are_not_repeated_here():
    with local_pool(2) as pool, pytest.raises(InputError, match="is bad"):
        run_all(refuse, [1, 2, 3], pool, ignore)


def test_a_bug_is_raised_here():
    with local_pool(2) as pool, pytest.raises(ZeroDivisionError, match="1 fell"):
        run_all(stumble, [1, 2, 3], pool, ignore)


def test_a_local_worker_computes_with_one_thread(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    with local_pool(2) as pool:
        assert run_all(threads, [0], pool, ignore) == [["1", "1", "1"]]
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "MKL_NUM_THREADS" not in os.environ


def test_workers_end_with_the_process_that_began_them(tmp_path):
    """However it ends: what inherits its output would keep that open. They leave no folder behind."""
    code = """
        import time
        from multilayer.executors import local_pool
        with local_pool(2) as pool:
            print(pool.submit(abs, -3).result(), flush=True)
            time.sleep(60)
    """
    command = [sys.executable, "-c", dedent(code)]
    place = {**os.environ, "TMPDIR": str(tmp_path)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=place) as parent:
        assert parent.stdout.readline() == "3\n"
        assert len([*tmp_path.glob("multilayer-*")]) == 1
        parent.kill()
        assert parent.communicate(timeout=20)[0] == ""
    assert not [*tmp_path.glob("multilayer-*")]


def test_one_job_is_this_process():
    with local_pool(1) as pool:
        assert pool is None


def note(name):
    """Prepare a process."""
    os.environ["MULTILAYER_TEST_PREPARED"] = os.environ.get("MULTILAYER_TEST_PREPARED", "") + name


def preparations(x):
    return os.environ.get("MULTILAYER_TEST_PREPARED", ""), x


class Unpicklable:
    """Can be unpickled in a process that was prepared only."""

    def __reduce__(self):
        return _unpickled, ()


def _unpickled():
    assert os.environ["MULTILAYER_TEST_PREPARED"].startswith("ab")
    return "unpickled"


def test_workers_are_prepared_before_they_unpickle_a_task():
    with local_pool(2) as pool:
        with prepared(note, "a"), prepared(note, "b"):
            done = run_all(preparations, [Unpicklable(), Unpicklable()], pool, lambda index: None)
        assert {value for _, value in done} == {"unpickled"}
        assert all(set(names) == {"a", "b"} for names, _ in done)
        later = run_all(square, [1, 2, 3], pool, lambda index: None)
    assert later == [1, 4, 9]
    assert "MULTILAYER_TEST_PREPARED" not in os.environ


@pytest.mark.parametrize("jobs", [0, -2])
def test_jobs(jobs):
    with pytest.raises(InputError, match=r"--jobs: .* at least 1"), local_pool(jobs):
        pass


class TestCluster:
    def test_without_distributed(self, monkeypatch):
        monkeypatch.setitem(sys.modules, "distributed", None)
        with pytest.raises(InputError, match=r"pip install 'multilayer\[cluster\]'"), cluster("tcp://127.0.0.1:8786"):
            pass

    @pytest.mark.parametrize("address", ["here", "http://127.0.0.1:1", "127.0.0.1", "a b:1"])
    def test_no_address(self, address):
        pytest.importorskip("distributed")
        with pytest.raises(InputError, match="is no address of a scheduler; write it as"), cluster(address):
            pass

    def test_nothing_answers(self, monkeypatch):
        pytest.importorskip("distributed")
        monkeypatch.setattr(executors, "CONNECT_SECONDS", 0.5)
        with (
            pytest.raises(InputError, match=r"no Dask scheduler answers at 127.0.0.1:9 within"),
            cluster("127.0.0.1:9"),
        ):
            pass


@pytest.mark.skipif(sys.platform != "linux", reason="nobody tells what a process has computed")
def test_processes_that_wait_for_ever_are_ended(monkeypatch):
    monkeypatch.setenv("MULTILAYER_TEST_MAIN", str(os.getpid()))
    monkeypatch.setattr(executors, "STALLED_SECONDS", 1)
    with local_pool(2) as pool, pytest.warns(LostWorkerWarning, match="computed here instead"):
        assert run_all(square_or_wait, range(6), pool) == [0, 1, 4, 9, 16, 25]


class CutOff(Executor):
    """A Dask client's executor whose scheduler is lost: every other task is never heard of again."""

    def __init__(self):
        self._client = SimpleNamespace(status="running")
        self.count = 0

    def submit(self, function, /, *args, **kwargs):
        future = Future()
        self.count += 1
        if self.count % 2:
            future.set_result(function(*args, **kwargs))
        if self.count == 6:
            self._client.status = "closed"
        return future


def test_tasks_that_a_lost_scheduler_forgets_are_computed_here(monkeypatch):
    monkeypatch.setattr(executors, "STALLED_SECONDS", 0.1)
    with pytest.warns(
        LostWorkerWarning, match=r"3 of 6 tasks, .* \(ConnectionError: the cluster's scheduler is lost\)"
    ):
        assert run_all(abs, range(-6, 0), CutOff()) == [6, 5, 4, 3, 2, 1]


def test_more_processes_than_a_machine_is_good_for():
    with pytest.raises(InputError, match="--jobs: 100000 is not allowed; this machine has"), local_pool(100_000):
        pass


@pytest.mark.skipif(sys.platform == "win32", reason="no such limits")
class TestLimits:
    def limited(self, limit, *arguments):
        script = "import sys; from multilayer.cli import main; sys.argv[0] = 'multilayer'; main()"
        python = f'exec {sys.executable} -c "{script}" {" ".join(arguments)}'
        return subprocess.run(
            ["sh", "-c", f"ulimit {limit}; {python}"], capture_output=True, text=True, timeout=60, check=False
        )

    def test_too_little_memory(self):
        done = self.limited("-v 500000", "check", "examples/double_wall.yaml")
        assert done.returncode == 2
        assert "512 MB of address space, and needs 1000 MB; allow more" in done.stderr

    def test_too_few_files(self, tmp_path):
        done = self.limited("-n 20", "simulate", "examples/double_wall.yaml", "--jobs 2", f"--out {tmp_path / 'out'}")
        assert done.returncode == 2
        assert "--jobs 2 needs 40 open files, and the system allows 20; allow more" in done.stderr
        assert list(tmp_path.iterdir()) == []


class Hoarder(Executor):
    """Does nothing until somebody waits, and counts what it holds."""

    def __init__(self):
        self.held, self.most = [], 0

    def submit(self, function, /, *arguments):
        future = Future()
        self.held.append((future, function, arguments))
        self.most = max(self.most, len(self.held))
        return future

    def work(self, futures, *_):
        future, function, arguments = self.held.pop()  # the last first
        future.set_result(function(*arguments))
        return {future}, set(futures) - {future}


def test_an_executor_holds_few_tasks_at_a_time(monkeypatch):
    executor = Hoarder()
    monkeypatch.setattr(executors, "wait", executor.work)
    n = 3 * executors._MOST_RUNNING
    assert run_all(square, list(range(n)), executor, ignore) == [x * x for x in range(n)]
    assert executor.most == executors._MOST_RUNNING


def test_a_pool_that_takes_nothing_is_told_with_all_its_tasks():
    n = 2 * executors._MOST_RUNNING
    with pytest.warns(LostWorkerWarning, match=f"failed on {n} of {n} tasks"):
        assert run_all(square, list(range(n)), Forgetful(0), ignore) == [x * x for x in range(n)]
