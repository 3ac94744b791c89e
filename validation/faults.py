"""Every step of every command's writing fails once, in every way: part of ``docs/validation/reliability.md``.

Run it as ``python -m validation.faults``; about half an hour. With commands as arguments: of these only.

Each command computes once. Where it writes, a copy of the process writes for every fault: its k-th call of the system
is preceded or followed by a signal (KILL, INT, TERM), or fails (disk full, input and output error), once on an empty
place and once over an older result beside a file of the user's, with folders exchanged and, as where a system cannot,
with files moved in one by one. Then the place must hold the old or the new result, as a whole, and the next run must
write the new one and leave nothing else behind.
"""

from __future__ import annotations

import errno
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, chdir, contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn
from unittest import mock

from multilayer.errors import InputError
from multilayer.writing import disk, folders, workspace
from validation.fuzz.corpus import write_corpus, write_tables

HEADING = """| command | files | written | faults tried | old or new, whole | to be finished by the next run | wrong |
|---|---|---|---|---|---|---|"""
FAULTS = ("KILL before", "KILL after", "INT before", "INT after", "TERM before", "TERM after", "ENOSPC", "EIO")
MODES = ("exchange", "one by one")
_CALLS = (
    "mkdir", "open", "write", "fsync", "close", "rename", "replace", "link", "unlink", "rmdir", "ftruncate", "chmod",
)  # fmt: skip
COMMANDS = (
    "simulate examples/double_wall.yaml",
    "compare examples/foam_absorption.yaml examples/foam_tube/tube.csv",
    "fit examples/foam_b",
    "fit examples/foam_tube/fit.yaml",
    "fit examples/foam_b --joint --no-figures",
    "methods examples/foam_b",
    "diagnose examples/foam_b",
    "rig examples/virtual_rig.yaml",
    "tube examples/raw_tube",
    "import examples/foam_b/signals/h25mm-t1mm_0200Hz.npz --base base_1 --top top_1 --rate 25600Hz",
    "schema",
    "plugins new my-foam --kind layer",
    "examples foam_b",
    "blind-check --campaigns 1 --seed 3 --no-figures",
    "optimise walls/design.yaml --no-figures",
    "diagnose walls/loss.yaml --no-figures",
    "export walls/board.yaml --as transmission_loss --angle 0,45 --out out/made.csv",
    "export soft.yaml --as nastran --frame-density bulk --out out/made.bdf",
    "materials --from tables/comma.csv --out out/made.yaml",
)
_NOTES, _MINE = "notes.txt", b"the user's"
_HARMLESS = ("close",)  # of a read-only folder or a lock: a failure there has nothing to lose
_ENDED, _REFUSED, _STOPPED, _BUG, _TOO_FEW = 0, 2, 130, 70, 99
State = dict[str, bytes]


@dataclass
class Tally:
    """What came of the faults of one place, written in one way."""

    tried: int = 0
    whole: int = 0
    pending: int = 0
    failures: list[str] = field(default_factory=list)

    def __add__(self, other: Tally) -> Tally:
        """Return both together."""
        return Tally(
            self.tried + other.tried, self.whole + other.whole, self.pending + other.pending,
            self.failures + other.failures,
        )  # fmt: skip


class _Fault:
    """Calls of the system by `multilayer.writing`, one of which fails."""

    def __init__(self, at: int, kind: str) -> None:
        self.at, self.kind, self.calls = at, kind, 0

    def around(self, call: Callable[..., Any], name: str) -> Callable[..., Any]:
        def faulty(*arguments: Any, **options: Any) -> Any:
            if "multilayer/writing" not in sys._getframe(1).f_code.co_filename.replace(os.sep, "/"):
                return call(*arguments, **options)
            self.calls += 1
            if self.calls != self.at:
                return call(*arguments, **options)
            if self.kind in ("ENOSPC", "EIO"):
                if name in _HARMLESS:
                    return call(*arguments, **options)
                if name == "write":  # a part arrives
                    call(arguments[0], bytes(arguments[1])[: len(arguments[1]) // 2])
                number = getattr(errno, self.kind)
                raise OSError(number, os.strerror(number))
            kind, _, when = self.kind.partition(" ")
            if when == "before":
                signal.raise_signal(signal.Signals[f"SIG{kind}"])
            result = call(*arguments, **options)
            if when == "after":
                signal.raise_signal(signal.Signals[f"SIG{kind}"])
            return result

        return faulty

    @contextmanager
    def armed(self) -> Iterator[None]:
        """Fail inside."""
        exchange = disk._exchange()
        faulty = exchange and self.around(exchange, "rename")
        patches = {name: self.around(getattr(os, name), name) for name in _CALLS}
        with mock.patch.multiple(os, **patches), mock.patch.object(disk, "_exchange", return_value=faulty):
            yield


def state(place: Path) -> State:
    """Return all files of a folder, or beside it if they belong to it, by path; hidden ones of a workspace left out."""
    files = sorted(path for path in place.parent.rglob("*") if path.is_file() or path.is_symlink())
    names = [path.relative_to(place.parent).as_posix() for path in files]
    return {
        name: path.read_bytes()
        for name, path in zip(names, files, strict=True)
        if not any(part.startswith(".") and part.endswith("multilayer") for part in name.split("/"))
    }


def leftovers(place: Path) -> list[str]:
    """Return what workspaces have left."""
    return sorted(path.name for path in place.parent.rglob(".*multilayer"))


def _outcome(write: Callable[[], object], fault: _Fault | None, mode: str) -> int:
    """Write in a copy of this process, and return how it ended; the negative number of a signal."""
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if child == 0:
        _end_with(write, fault, mode)
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status)


def _end_with(write: Callable[[], object], fault: _Fault | None, mode: str) -> NoReturn:
    status = _BUG
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, _stopped)
        exchange = disk._exchange() if mode == MODES[0] else None
        with mock.patch.object(disk, "_exchange", return_value=exchange):
            if fault is None:
                write()
                status = _ENDED
            else:
                with fault.armed():
                    write()
                status = _ENDED if fault.calls >= fault.at else _TOO_FEW
    except InputError:
        status = _REFUSED
    except KeyboardInterrupt:
        status = _STOPPED
    except BaseException as error:
        sys.stderr.write(f"{type(error).__name__}: {error}\n")
    finally:
        os._exit(status)


def _stopped(number: int, frame: object) -> None:
    raise KeyboardInterrupt


def try_all(
    place: Path,
    write: Callable[[], object],
    before: Callable[[], object] | None,
    mode: str,
    faults: Sequence[str] = FAULTS,
    *,
    alone: bool = False,
) -> Tally:
    """Let every step of a writing fail in every way.

    Parameters
    ----------
    place : Path
        Of a folder or file, in an empty folder.
    write : callable
    before : callable or None
        Writes an older result; none where there is nothing yet.
    mode : str
        Of `MODES`.
    faults : sequence of str
        Of `FAULTS`.
    alone : bool
        Whether the older result has no file of the user's beside it.
    """
    parent, tally = place.parent, Tally()
    kept = parent.with_name(f"{parent.name}.kept")
    if before is not None:
        before()
        if place.is_dir() and not alone:
            (place / _NOTES).write_bytes(_MINE)
    shutil.copytree(parent, kept, symlinks=True)
    old = state(place)
    if _outcome(write, None, mode) != _ENDED:
        message = f"{place}: cannot be written even without a fault"
        raise RuntimeError(message)
    new = state(place)
    for kind in faults:
        for at in range(1, 10_000):
            _restore(parent, kept)
            status = _outcome(write, _Fault(at, kind), mode)
            if status == _TOO_FEW:
                break
            tally += _judged(place, write, old, new, status, f"{kind}, step {at}, {mode}", mode)
    _restore(parent, kept)
    shutil.rmtree(kept)
    return tally


def _restore(parent: Path, kept: Path) -> None:
    shutil.rmtree(parent)
    shutil.copytree(kept, parent, symlinks=True)


def _judged(
    place: Path, write: Callable[[], object], old: State, new: State, status: int, fault: str, mode: str
) -> Tally:
    """Return what came of one fault: a whole result, or one that the next run finishes, and what was wrong."""
    found, failures = state(place), []
    is_whole = found in (old, new)
    is_pending = not is_whole and folders.is_unfinished(place)
    if not is_whole and not is_pending:
        failures.append(f"{fault}: a mixture ({_told(found, old, new)})")
    if status == _BUG:
        failures.append(f"{fault}: ended as a bug")
    again = _outcome(write, None, mode)
    if again != _ENDED:
        if not (status == _ENDED or found == new):  # what may exist only once was written after all
            failures.append(f"{fault}: the next run ended with status {again}")
    elif state(place) != new:
        failures.append(f"{fault}: the next run gave {_told(state(place), old, new)}")
    elif left := leftovers(place):
        failures.append(f"{fault}: the next run left {', '.join(left)}")
    return Tally(1, int(is_whole), int(is_pending), failures)


def _told(found: State, old: State, new: State) -> str:
    def of(name: str) -> str:
        if found.get(name) == new.get(name):
            return "old and new" if found.get(name) == old.get(name) else "new"
        return "old" if found.get(name) == old.get(name) else "neither"

    return ", ".join(f"{name}: {of(name)}" for name in sorted({*found, *old, *new}))


class _Writer:
    """What writes for a command: before it does, all its faults are tried on the same contents elsewhere."""

    def __init__(self, faults: Sequence[str]) -> None:
        self.faults, self.found = faults, dict[str, tuple[int, Tally]]()

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Try faults of all that is written inside."""
        from multilayer import examples, json_lines
        from multilayer.measurements import importing
        from multilayer.rig import writer

        files, new, single = folders.write_files, folders.write_new, folders.write_file
        patches = [
            (folders, "write_files", self._folder(files)),
            (writer, "write_files", self._folder(files)),
            (folders, "write_new", self._new(new)),
            (importing, "write_new", self._new(new)),
            (folders, "write_file", self._file(single)),
            (json_lines, "write_file", self._file(single)),
            (examples, "copy_examples", self._copy(examples.copy_examples)),
        ]
        with ExitStack() as stack:
            for module, name, function in patches:
                stack.enter_context(mock.patch.object(module, name, function))
            yield

    def _folder(self, write: Callable[..., Any]) -> Callable[..., Any]:
        def tried(folder: Path, files: dict[str, Any], **options: Any) -> Any:
            old = {**dict.fromkeys(files, b"old"), "stale.txt": b"old"}

            def at(place: Path, contents: dict[str, Any]) -> Callable[[], object]:
                there = {**options, "beside": _moved(options.get("beside") or {}, folder, place)}
                there["gone"] = list(_moved(dict.fromkeys(options.get("gone") or [], b""), folder, place))
                return lambda: write(place, contents, **there)

            self._try(
                folder, len(files) + len(options.get("beside") or ()), lambda p: at(p, files), lambda p: at(p, old)
            )
            return write(folder, files, **options)

        return tried

    def _new(self, write: Callable[..., Any]) -> Callable[..., Any]:
        def tried(folder: Path, files: dict[str, Any], **options: Any) -> Any:
            self._try(folder, len(files), lambda place: lambda: write(place, files, **options), None)
            return write(folder, files, **options)

        return tried

    def _file(self, write: Callable[..., Any]) -> Callable[..., Any]:
        def tried(file: Path, content: Any) -> Any:
            self._try(file, 1, lambda p: lambda: write(p, content), lambda p: lambda: write(p, "old"))
            return write(file, content)

        return tried

    def _copy(self, copy: Callable[..., Any]) -> Callable[..., Any]:
        def tried(names: Sequence[str], out: Path) -> Any:
            self._try(out, len(names), lambda place: lambda: copy(names, place), None)
            return copy(names, out)

        return tried

    def _try(
        self,
        place: Path,
        n_files: int,
        new: Callable[[Path], Callable[[], object]],
        old: Callable[[Path], Callable[[], object]] | None,
    ) -> None:
        for held in list(workspace.held()):
            workspace.give_up(held)  # each fault claims for itself
        for mode in MODES:
            for is_there in (False, True) if old else (False,):
                with tempfile.TemporaryDirectory(dir=_memory()) as folder:
                    there = Path(folder, "here", place.absolute().name)
                    there.parent.mkdir()
                    older = old(there) if old and is_there else None
                    tally = try_all(there, new(there), older, mode, self.faults)
                before, known = self.found.get(mode, (0, Tally()))
                self.found[mode] = max(before, n_files), known + tally


def _moved(beside: dict[Path, bytes], folder: Path, place: Path) -> dict[Path, bytes]:
    parent = folder.absolute().parent
    return {place.parent / path.relative_to(parent): content for path, content in beside.items()}


def _memory() -> str | None:
    """Return a file system in memory where there is one: waiting for a disk changes nothing of what is tried."""
    return "/dev/shm" if Path("/dev/shm").is_dir() else None


def rows(command: str, faults: Sequence[str] = FAULTS) -> Iterator[str]:
    """Give the rows of a command's table."""
    from multilayer.cli import main as multilayer

    writer = _Writer(faults)
    words = [str(Path(word).absolute()) if word.startswith("examples/") else word for word in command.split()]
    with tempfile.TemporaryDirectory() as folder, chdir(folder), open(os.devnull, "w") as nowhere:  # noqa: PTH123
        write_corpus(Path())
        write_tables(Path("tables"))
        out = [] if "--out" in words else ["--out", "out/made"]
        with mock.patch.object(sys, "argv", ["multilayer", *words, *out]), writer.watching():
            try:
                with redirect_stdout(nowhere), redirect_stderr(nowhere):
                    multilayer()
            except SystemExit as end:
                if end.code not in (None, 0, 1):
                    message = f"{command}: ended with status {end.code}"
                    raise RuntimeError(message) from None
    for mode, (n_files, tally) in writer.found.items():
        wrong = "; ".join(tally.failures[:3]) or "0"
        yield f"| `{command}` | {n_files} | {mode} | {tally.tried} | {tally.whole} | {tally.pending} | {wrong} |"


def main() -> None:
    """Print the table."""
    sys.stdout.write(f"{HEADING}\n")
    for command in sys.argv[1:] or COMMANDS:
        for row in rows(command):
            sys.stdout.write(f"{row}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
