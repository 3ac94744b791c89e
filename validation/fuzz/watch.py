"""One try of anything, in a process of its own, watched: what it raises, warns of, and how long and large it grows."""

from __future__ import annotations

import gc
import os
import re
import resource
import signal
import sys
import traceback
import warnings
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from pathlib import Path
from time import clock_gettime, monotonic

import multilayer
from multilayer.errors import InputError, MultilayerError, PlausibilityWarning, PluginWarning, ValidityWarning

SECONDS = 20  # of a processor: a machine that is busy with other things changes no outcome
_HANGS = 10 * SECONDS  # of a clock: what has computed nothing in that time waits for ever
_OF_A_PROCESS = 2  # CPUCLOCK_SCHED of Linux's clock identifiers, see clock_getcpuclockid(3)
MEGABYTES = 1000
OURS = (PlausibilityWarning, PluginWarning, ValidityWarning)
ROOT = str(Path(multilayer.__file__).parent)

PASSED, REFUSED, DIFFERENT = "passed", "refused", "different"


class UnsoundError(Exception):
    """A result that must not be: no number, or more energy than came in."""


class TooSlowError(BaseException):
    """Longer than `SECONDS`; no ``except Exception`` of a reader takes it."""


@dataclass(frozen=True)
class Outcome:
    """How one try ended.

    Attributes
    ----------
    kind : str
        ``passed``, ``refused`` (told as a mistake of the input), ``different`` (read without a word as something else),
        or the failure.
    text : str
        What was told.
    """

    kind: str
    text: str = ""

    @property
    def failed(self) -> bool:
        """Whether this must not be."""
        return self.kind not in (PASSED, REFUSED, DIFFERENT)


@dataclass
class Tally:
    """Outcomes of many tries of one target."""

    target: str
    seed: int
    counts: Counter[str] = field(default_factory=Counter)
    failures: dict[str, list[tuple[int, str]]] = field(default_factory=dict)

    def add(self, index: int, outcome: Outcome) -> None:
        """Count an outcome, and tell the first failure of each kind."""
        self.counts["failed" if outcome.failed else outcome.kind] += 1
        self.counts["tried"] += 1
        if outcome.failed:
            if outcome.kind not in self.failures:  # long runs are looked at before they end
                print(f"{index}: {outcome.kind}: {outcome.text[:300]}", file=sys.stderr, flush=True)  # noqa: T201
            self.failures.setdefault(outcome.kind, []).append((index, outcome.text))

    @property
    def row(self) -> str:
        """A row of the table."""
        numbers = (self.counts[kind] for kind in ("tried", REFUSED, PASSED, DIFFERENT, "failed"))
        return f"| {self.target} | {self.seed} | {' | '.join(map(str, numbers))} |"


HEAD = "| target | seed | tried | refused | passed | silently different | failures |\n|---|---|---|---|---|---|---|"


def tried(action: Callable[[], str], needs_line: Path | None = None) -> Outcome:
    """Return how an action ended; it returns ``passed`` or ``different``.

    Parameters
    ----------
    action : callable
    needs_line : Path, optional
        A file in which mistakes of a field must have a line.
    """
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        outcome = _ended(action, needs_line)
    foreign = [one for one in caught if not issubclass(one.category, OURS)]
    if foreign and not outcome.failed:
        one = foreign[0]
        where = f"{one.filename}:{one.lineno}".replace(f"{ROOT}/", "")
        outcome = Outcome(f"{one.category.__name__} at {where}", str(one.message))
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    if grown > MEGABYTES and not outcome.failed:
        outcome = Outcome(f"more than {MEGABYTES} MB", f"{grown:.0f} MB; {outcome.text}")
    return outcome


def _ended(action: Callable[[], str], needs_line: Path | None) -> Outcome:  # noqa: PLR0911
    def stop(*_: object) -> None:
        raise TooSlowError

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        return Outcome(action())
    except InputError as error:
        signal.setitimer(signal.ITIMER_PROF, 0)
        lost = [problem for problem in error.problems if problem.file is None]
        lost += [p for p in error.problems if p.file == needs_line and p.path and p.line is None]
        if lost:
            return Outcome(f"no place: {_pattern(lost[0].message)}", str(lost[0]))
        if "Unable to allocate" in str(error):
            return Outcome("memory asked for without a bound", str(error))
        return Outcome(REFUSED, str(error))
    except MultilayerError as error:
        return Outcome(f"no place: {_pattern(str(error))}", str(error))
    except TooSlowError:
        return Outcome(f"more than {SECONDS} s", _innermost(sys.exc_info()[1]))
    except Exception as error:
        return Outcome(f"{type(error).__name__} at {_innermost(error)}", " ".join(str(error).split())[:200])
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def _pattern(text: str) -> str:
    """Return a message without what differs from one to the next."""
    return re.sub(r"'[^']*'|[-+]?\d[\d.e+-]*", "…", text)[:90]


def _innermost(error: BaseException | None) -> str:
    frames = traceback.extract_tb(error.__traceback__ if error else None)
    ours = [frame for frame in frames if frame.filename.startswith(ROOT)] or frames
    frame = ours[-1] if ours else None
    return f"{frame.filename.removeprefix(ROOT + '/')}:{frame.lineno}" if frame else "?"


class _Worker:
    """A process that tries some indices, one after the other, begun anew after a try that ends or hangs it."""

    def __init__(self, target: Callable[[int], Outcome], indices: Sequence[int]) -> None:
        self.target, self.left = target, deque(indices)
        self._begin()

    def _begin(self) -> None:
        context = get_context("fork")
        self.results, there = context.Pipe(duplex=False)
        self.process = context.Process(target=_try_all, args=(self.target, [*self.left], there))
        self.process.start()
        there.close()
        self._begin_try()

    def _begin_try(self) -> None:
        self.until, self.began, self.used = monotonic() + _HANGS, self._processor_time(), 0.0

    def _processor_time(self) -> float:
        """Return what the process has computed so far, s."""
        if sys.platform != "linux" or self.process.pid is None or not self.process.is_alive():
            return 0.0
        return clock_gettime(~self.process.pid << 3 | _OF_A_PROCESS)

    def _is_starved(self) -> bool:
        """Tell whether the try goes on, slowly, for other work has the processors; what stops it has not come due."""
        used = self._processor_time() - self.began
        goes_on = self.used < used < 2 * SECONDS
        self.until, self.used = monotonic() + _HANGS, used
        return goes_on

    def ended(self) -> Iterator[tuple[int, Outcome]]:
        """Give the try that has ended, if one has, with its index."""
        if self.results.poll():
            try:
                outcome = self.results.recv()
                self._begin_try()
                yield self.left.popleft(), outcome
                return
            except EOFError:
                self.stop()
                outcome = Outcome("the process died", f"exit code {self.process.exitcode}")
        elif monotonic() > self.until and not self._is_starved():
            outcome = Outcome("hangs where nothing can stop it")
            self.stop()
        else:
            return
        yield self.left.popleft(), outcome
        if self.left:
            self._begin()

    def stop(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.join()
        self.results.close()


def watched(
    target: Callable[[int], Outcome], indices: Sequence[int], tally: Tally, until: float = 1e18, jobs: int = 1
) -> Tally:
    """Try all indices in processes of their own.

    Parameters
    ----------
    target : callable
        Of an index; its tries may not meet in a file (`own`).
    indices : sequence of int
    tally : Tally
        To which outcomes are added.
    until : float
        Of `time.monotonic`: then it stops.
    jobs : int
        Number of processes; what is tried does not depend on it.
    """
    workers = [_Worker(target, share) for job in range(jobs) if (share := indices[job::jobs])]
    while workers and monotonic() < until:
        wait([worker.results for worker in workers], timeout=1)
        for worker in workers:
            for index, outcome in worker.ended():
                tally.add(index, outcome)
        workers = [worker for worker in workers if worker.left or worker.stop()]
    for worker in workers:
        worker.stop()
    return tally


def own(name: str) -> str:
    """Return a file's name that no other process writes to."""
    return f"{os.getpid()}{name}"


def _try_all(target: Callable[[int], Outcome], indices: Sequence[int], out: Connection) -> None:
    resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
    gc.freeze()  # what is there stays: it need not be looked through again and again
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), 2)
        os.dup2(nowhere.fileno(), 1)
    for index in indices:
        try:
            outcome = target(index)
        except Exception as error:  # of the fuzzer itself
            outcome = Outcome(f"fuzzer: {type(error).__name__} at {_innermost(error)}", str(error)[:200])
        out.send(outcome)
