"""Where tasks run: in this process, in processes beside it, on a Dask cluster, or in any executor."""

from __future__ import annotations

import logging
import os
import pickle
import re
import signal
import sys
from collections import deque
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from importlib import import_module
from multiprocessing import get_context, parent_process
from multiprocessing.process import BaseProcess
from pathlib import Path
from threading import Thread, current_thread, main_thread
from typing import Any, TypeVar
from warnings import warn

from multilayer.errors import InputError, MultilayerError, MultilayerWarning, show
from multilayer.limits import require_files
from multilayer.shared_results import join, remove, sharing
from multilayer.threads import THREADS

T = TypeVar("T")
R = TypeVar("R")

CONNECT_SECONDS = 10
_MOST_RUNNING = 512  # tasks with an executor at a time
STALLED_SECONDS = 60  # processes that have computed nothing for so long, with tasks left, wait for each other
MOST_JOBS = 64  # or four to a processor, where these are more
_FILES, _FILES_PER_JOB = 32, 4  # that a process opens, at most, without a pool and for each of its processes
_NO_LEAKS_TOLD = "ignore:resource_tracker:UserWarning"
_RETRIES = 3
_ADDRESS = re.compile(r"((tcp|tls|ws|wss|ucx)://)?[^\s/]+:\d+")


class LostWorkerWarning(MultilayerWarning):
    """Workers failed; their tasks were computed in this process, with the same result."""


def run_all(
    function: Callable[[T], R],
    tasks: Sequence[T],
    executor: Executor | None,
    done: Callable[[int], None] = lambda index: None,
) -> list[R]:
    """Return the result of `function` for every task, in the order of the tasks.

    Tasks on which an executor fails, whatever the reason, are computed in this process: a lost worker costs time, not
    results.

    Parameters
    ----------
    function : callable
        Gives the same result for the same task wherever it runs; pickled, as the tasks are.
    tasks : sequence
    executor : Executor or None
        None for this process.
    done : callable, optional
        Called with the index of each task that is done.

    Raises
    ------
    MultilayerError
        The first that a task raises; tasks that have not begun are cancelled.
    """
    results: dict[int, R] = {}
    for index, result in as_done(function, tasks, executor):
        results[index] = result
        done(index)
    return [results[index] for index in range(len(tasks))]


def call(task: Callable[[], R]) -> R:
    """Call a task and return its result: the function to give `run_all` where the tasks are functions themselves."""
    return task()


def as_done(function: Callable[[T], R], tasks: Sequence[T], executor: Executor | None) -> Iterator[tuple[int, R]]:
    """Give index and result of every task as they are done; see `run_all`."""
    finished: set[int] = set()
    reasons: list[Exception] = []
    if executor is not None:
        for index, outcome in _outcomes(function, tasks, executor):
            if isinstance(outcome, Exception):
                reasons.append(outcome)
                continue
            finished.add(index)
            yield index, outcome
    for index, task in enumerate(tasks):
        if index not in finished:
            yield index, function(task)
    if reasons:
        warn(_lost_workers(reasons, len(tasks)), LostWorkerWarning, stacklevel=4)


def _lost_workers(reasons: list[Exception], n_tasks: int) -> str:
    first = f"{type(reasons[0]).__name__}: {reasons[0]}".splitlines()[0].removesuffix(": ")
    return f"workers failed on {len(reasons)} of {n_tasks} tasks, which were computed here instead ({first})"


def _outcomes(function: Callable[[T], R], tasks: Sequence[T], executor: Executor) -> Iterator[tuple[int, Any]]:
    """Give index and result of each task as they arrive; an exception where the executor failed.

    Only so many tasks are with the executor at a time: what it has done and nobody has taken yet is held in memory.
    """
    waiting = deque(enumerate(tasks))
    running: dict[Future[R], int] = {}
    try:
        while waiting or running:
            while waiting and len(running) < _MOST_RUNNING:
                index, task = waiting.popleft()
                try:
                    running[_submit(executor, function, task)] = index
                except Exception as error:  # a pool that has broken takes no more
                    yield index, error
            for future in _done(running, executor):
                index = running.pop(future)
                if not future.done():
                    yield index, ConnectionError("the cluster's scheduler is lost")
                    continue
                try:
                    yield index, future.result()
                except MultilayerError:
                    raise
                except Exception as error:
                    yield index, error
    finally:
        for future in running:
            future.cancel()


def _done(running: Collection[Future[R]], executor: Executor) -> set[Future[R]]:
    """Return futures that are done; processes of a pool that wait for ever are ended, whose tasks have failed then.

    Where a cluster's scheduler is lost, all of them: Dask may forget one that it was about to fetch.
    """
    before = None
    while running:
        done, _ = wait(running, STALLED_SECONDS, FIRST_COMPLETED)
        if done:
            return done
        if _is_cut_off(executor):
            return set(running)
        used = _processor_time(executor)
        if used is not None and used == before:
            _end(executor)
        before = used
    return set()


def _is_cut_off(executor: Executor) -> bool:
    """Tell whether the executor is that of a Dask client which has given its scheduler up."""
    client = getattr(executor, "_client", None)
    return getattr(client, "status", "running") in ("closing", "closed")


def _processor_time(executor: Executor) -> float | None:
    """Return what the processes of a pool have computed so far, s; None where nobody tells."""
    if not isinstance(executor, ProcessPoolExecutor) or sys.platform != "linux":
        return None
    total = 0
    for process in list((executor._processes or {}).values()):
        try:
            fields = Path(f"/proc/{process.pid}/stat").read_text(encoding="utf-8", errors="replace")
            user, system = fields.rpartition(")")[2].split()[11:13]
            total += int(user) + int(system)
        except (OSError, ValueError):  # it has ended
            continue
    return total / os.sysconf("SC_CLK_TCK")


def abandon(executor: Executor | None) -> None:
    """End the processes of a pool at once, which takes no more tasks then; other executors go on."""
    if isinstance(executor, ProcessPoolExecutor):
        _end(executor)
        executor.shutdown(wait=False, cancel_futures=True)


def _end(executor: Executor) -> None:
    """End the processes of a pool at once; there is no public way."""
    if isinstance(executor, ProcessPoolExecutor):
        for process in list((executor._processes or {}).values()):
            process.kill()


_preparations: list[tuple[Callable[..., object], tuple[Any, ...]]] = []


@contextmanager
def prepared(function: Callable[..., object], *arguments: Any) -> Iterator[None]:
    """Make every process call `function` before it unpickles a task that is submitted inside this context.

    Parameters
    ----------
    function : callable
        Of an installed module; called with every task, so that also workers that join late are prepared: a second
        call in the same process must cost nothing.
    arguments
        Pickled with every task.
    """
    preparation = (function, arguments)
    _preparations.append(preparation)
    try:
        yield
    finally:
        _preparations.remove(preparation)


def _submit(executor: Executor, function: Callable[[T], R], task: T) -> Future[R]:
    if not _preparations:
        return executor.submit(function, task)
    # as bytes: neither a worker nor a scheduler can unpickle the task before it is prepared
    return executor.submit(_run_prepared, list(_preparations), pickle.dumps((function, task)))


def _run_prepared(preparations: list[tuple[Callable[..., object], tuple[Any, ...]]], shipped: bytes) -> Any:
    for prepare, arguments in preparations:
        prepare(*arguments)
    function, task = pickle.loads(shipped)  # made by `_submit`
    return function(task)


@contextmanager
def executor_for(jobs: int, address: str | None) -> Iterator[Executor | None]:
    """Give what ``--jobs`` and ``--cluster`` ask for; see `local_pool` and `cluster`.

    Raises
    ------
    InputError
        When both are given.
    """
    if address is not None and jobs != 1:
        raise InputError("--jobs and --cluster exclude each other: the cluster's workers compute")
    with local_pool(jobs) if address is None else cluster(address) as executor:
        yield executor


@contextmanager
def local_pool(jobs: int, modules: Sequence[str] = ()) -> Iterator[Executor | None]:
    """Give `jobs` processes of this machine as an executor; None, for this process, where one is asked for.

    Each process computes with one thread.

    Parameters
    ----------
    jobs : int
    modules : sequence of str, optional
        Imported by the processes at once, while this one prepares their tasks.

    Raises
    ------
    InputError
        For fewer than one job.
    """
    if jobs < 1:
        raise InputError(f"--jobs: {jobs} is not allowed; it must be at least 1")
    processors = os.cpu_count() or 1
    if jobs > max(MOST_JOBS, 4 * processors):
        text = f"this machine has {processors} processors, and more processes than that only wait"
        raise InputError(f"--jobs: {jobs} is not allowed; {text}: use --jobs {processors}")
    if jobs == 1:
        yield None
        return
    require_files(_FILES + _FILES_PER_JOB * jobs, f"--jobs {jobs}")
    # never forks of this process: they would copy the locks of its threads, and its settings of BLAS
    with _one_thread_each(), sharing() as folder:
        if sys.platform == "linux":  # forks of a process that does nothing but import, once for all of them
            from multiprocessing import forkserver

            context = get_context("forkserver")
            context.set_forkserver_preload([*modules, "multilayer.frozen"])
            if _NO_LEAKS_TOLD not in sys.warnoptions:  # of semaphores, which are cleaned up after Ctrl-C
                sys.warnoptions.append(_NO_LEAKS_TOLD)
            with _without_ctrl_c():
                forkserver.ensure_running()
            with _ended_by_ctrl_c(ProcessPoolExecutor(jobs, context, _begin, (folder,))) as pool:
                yield pool
        else:
            with _ended_by_ctrl_c(ProcessPoolExecutor(jobs, get_context("spawn"), _begin, (folder,))) as pool:
                for _ in range(jobs):
                    pool.submit(_import_all, modules)
                yield pool


@contextmanager
def _without_ctrl_c() -> Iterator[None]:
    """Make processes that start inside ignore Ctrl-C, also while they import; not possible outside the main thread."""
    if current_thread() is not main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _ended_by_ctrl_c(pool: ProcessPoolExecutor) -> Iterator[ProcessPoolExecutor]:
    """Give a pool; Ctrl-C ends its processes at once, in silence, and waits for nothing."""
    try:
        yield pool
    except KeyboardInterrupt:
        abandon(pool)
        raise
    except BaseException:
        pool.shutdown(cancel_futures=True)
        raise
    pool.shutdown()


def _begin(folder: Path | None) -> None:
    """Make this process a pool's worker, which ends when its parent ends, even by a signal: it would wait for ever.

    Ctrl-C is the parent's to answer: a terminal sends it to every process.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    join(folder)
    parent = parent_process()
    if parent is not None:
        Thread(target=_end_after, args=(parent,), daemon=True).start()


def _end_after(parent: BaseProcess) -> None:
    parent.join()
    remove()
    os._exit(1)


def _import_all(modules: Sequence[str]) -> None:
    for module in modules:
        import_module(module)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Make processes that start inside use one thread for linear algebra, since there is one process per job."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """Give the workers of a Dask cluster as an executor.

    Tasks of a lost worker go to another one.

    Parameters
    ----------
    address : str
        Of the scheduler, as ``tcp://10.0.0.1:8786``.

    Raises
    ------
    InputError
        When `distributed` is not installed, no scheduler answers, there is no worker, or the workers have another
        version of this package.
    """
    with _client(address) as client:
        yield client.get_executor(retries=_RETRIES, pure=False)


@contextmanager
def _client(address: str) -> Iterator[Any]:
    try:
        import distributed
    except ImportError:
        text = "--cluster needs the package 'distributed'; install it with: pip install 'multilayer[cluster]'"
        raise InputError(text) from None
    if not _ADDRESS.fullmatch(address):
        raise InputError(f"--cluster: {show(address)} is no address of a scheduler; write it as tcp://10.0.0.1:8786")
    try:
        connect: Any = distributed.Client
        client = connect(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except OSError:  # TimeoutError is one
        text = f"--cluster: no Dask scheduler answers at {address} within {CONNECT_SECONDS} s"
        raise InputError(f"{text}; start one with 'dask scheduler'") from None
    with _quiet("distributed.client"), client:  # its log of lost connections would repeat `LostWorkerWarning`
        _check_workers(client, address)
        yield client


@contextmanager
def _quiet(name: str) -> Iterator[None]:
    logger = logging.getLogger(name)
    before = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(before)


def _check_workers(client: Any, address: str) -> None:
    here = _version()
    try:
        client.wait_for_workers(1, timeout=CONNECT_SECONDS)
        versions = client.submit(_version, pure=False, retries=_RETRIES).result(timeout=CONNECT_SECONDS)
    except TimeoutError:
        text = f"--cluster: no worker of the scheduler at {address} answers; start one with 'dask worker {address}'"
        raise InputError(text) from None
    except ImportError as error:
        text = f"--cluster: the workers of {address} lack what this needs ({error}); install it there"
        raise InputError(text) from None
    if versions != here:
        raise InputError(f"--cluster: the workers run multilayer {versions}, this is {here}; install the same version")


def _version() -> str:
    from importlib.metadata import version

    return version("multilayer")
