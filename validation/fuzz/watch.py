"""One try of anything, in a process of its own, watched: what it raises, warns of, and how long and large it grows."""

from __future__ import annotations

import os
import re
import resource
import signal
import sys
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from time import monotonic

import multilayer
from multilayer.errors import InputError, MultilayerError, PlausibilityWarning, PluginWarning, ValidityWarning

SECONDS = 20
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
        """Count an outcome."""
        self.counts["failed" if outcome.failed else outcome.kind] += 1
        self.counts["tried"] += 1
        if outcome.failed:
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

    signal.signal(signal.SIGALRM, stop)
    signal.alarm(SECONDS)
    try:
        return Outcome(action())
    except InputError as error:
        signal.alarm(0)
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
        signal.alarm(0)


def _pattern(text: str) -> str:
    """Return a message without what differs from one to the next."""
    return re.sub(r"'[^']*'|[-+]?\d[\d.e+-]*", "…", text)[:90]


def _innermost(error: BaseException | None) -> str:
    frames = traceback.extract_tb(error.__traceback__ if error else None)
    ours = [frame for frame in frames if frame.filename.startswith(ROOT)] or frames
    frame = ours[-1] if ours else None
    return f"{frame.filename.removeprefix(ROOT + '/')}:{frame.lineno}" if frame else "?"


def watched(target: Callable[[int], Outcome], indices: Sequence[int], tally: Tally, until: float = 1e18) -> Tally:
    """Try all indices in a process of its own, begun anew after the try that ends or hangs it.

    Parameters
    ----------
    target : callable
    indices : sequence of int
    tally : Tally
        To which outcomes are added.
    until : float
        Of `time.monotonic`: then it stops.
    """
    context = get_context("fork")
    left = list(indices)
    while left and monotonic() < until:
        here, there = context.Pipe(duplex=False)
        process = context.Process(target=_try_all, args=(target, left, there))
        process.start()
        there.close()
        while left and monotonic() < until:
            try:
                outcome = here.recv() if here.poll(2 * SECONDS) else None
            except EOFError:
                outcome = Outcome("the process died", f"exit code {process.exitcode}")
            dead = outcome is None or outcome.kind == "the process died"
            tally.add(left.pop(0), outcome or Outcome("hangs where nothing can stop it"))
            if dead:
                break
        process.kill()
        process.join()
    return tally


def _try_all(target: Callable[[int], Outcome], indices: Sequence[int], out: Connection) -> None:
    resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), 2)
        os.dup2(nowhere.fileno(), 1)
    for index in indices:
        try:
            outcome = target(index)
        except Exception as error:  # of the fuzzer itself
            outcome = Outcome(f"fuzzer: {type(error).__name__} at {_innermost(error)}", str(error)[:200])
        out.send(outcome)
