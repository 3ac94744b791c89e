"""Speed beside other programs, and alone.

Run it as ``python -m validation.peers > docs/validation/speed.md``. Every peer is installed from the package
index into an environment of its own, once; one whose interpreter or package cannot be had is reported as absent. Every
program runs in processes of its own, on one thread, and the programs take turns.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from validation.peer_page import OURS, Findings, write_page

HERE = Path(__file__).parent
ROOT = HERE.parent
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
QUESTIONS = ("reference", "solve", "layers", "memory", "cores")


@dataclass(frozen=True)
class Peer:
    """A program to compare with; `python` is the version it runs on, `script` what it is asked."""

    name: str
    python: str
    script: str
    requirements: tuple[str, ...]


# pyva and pymls put arrays of one entry where numpy 2.4 and later want numbers
PEERS = (
    Peer("phonometry", "3.13", "peer_phonometry.py", ("phonometry==4.0.0rc1",)),
    Peer("pyva", "3.12", "peer_pyva.py", ("pyva-toolbox==1.3.1", "numpy<2.4")),
    Peer("pymls", "3.11", "peer_pymls.py", ("pymls==1.8.1", "numpy<2.4")),
)


class AbsentError(Exception):
    """A peer cannot be had on this machine; the text says why."""


def find_python(version: str) -> Path:
    """Return an interpreter of this version, from the path or from pyenv.

    Raises
    ------
    AbsentError
        When there is none.
    """
    for candidate in _candidates(version):
        told = _run([candidate, "-c", "import sys; print('{}.{}'.format(*sys.version_info))"])
        if told is not None and told.strip() == version:
            return candidate
    raise AbsentError(f"no Python {version}")


def _candidates(version: str) -> Iterator[Path]:
    if on_path := shutil.which(f"python{version}"):
        yield Path(on_path)
    root = (_run(["pyenv", "root"]) if shutil.which("pyenv") else None) or os.environ.get("PYENV_ROOT") or "~/.pyenv"
    yield from sorted((Path(root.strip()).expanduser() / "versions").glob(f"{version}.*/bin/python"))


def _run(command: list[Any]) -> str | None:
    """Return what a command prints, None when it fails."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stdout if done.returncode == 0 else None


def environment(peer: Peer, folder: Path) -> Path:
    """Return the interpreter of the peer's own environment, made when it is not there yet.

    Raises
    ------
    AbsentError
        When the interpreter or a package cannot be had.
    """
    home = folder.absolute() / peer.name
    python, done, wanted = home / "bin" / "python", home / "requirements.txt", "\n".join(peer.requirements)
    if done.exists() and done.read_text() == wanted and python.exists():
        return python
    base = find_python(peer.python)
    say(f"installing {', '.join(peer.requirements)}")
    if _run([base, "-m", "venv", "--clear", home]) is None:
        raise AbsentError(f"no virtual environment with Python {peer.python}")
    if _run([python, "-m", "pip", "install", "--quiet", *peer.requirements]) is None:
        raise AbsentError(f"{', '.join(peer.requirements)} cannot be installed")
    done.write_text(wanted)
    return python


def ask(python: Path, script: str, *arguments: str) -> dict[str, Any]:
    """Return what a script answers, run on one thread in a process of its own.

    Raises
    ------
    RuntimeError
        When the script fails.
    """
    ours = python == Path(sys.executable)
    settings = {**os.environ, **ONE_THREAD, "MPLBACKEND": "Agg", "PYTHONPATH": str(ROOT) if ours else ""}
    with tempfile.TemporaryDirectory() as folder:
        answer = Path(folder) / "answer.json"
        command = [str(python), str(HERE / script), str(answer), *arguments]
        done = subprocess.run(command, env=settings, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(f"{script} failed: {(done.stderr.splitlines() or ['no reason given'])[-1]}")
        found: dict[str, Any] = json.loads(answer.read_text())
        return found


def compare(options: argparse.Namespace) -> Findings:
    """Return everything measured: all programs in turns, then multilayer alone."""
    ready, absent = install(options.environments)
    runs, size = options.rounds * options.repeats, f"--frequencies={options.frequencies}"
    limits = (size, f"--few={options.few}", f"--repeats={options.repeats}")
    rounds = [one_round(ready, absent, limits) for _ in range(options.rounds)]
    programs = {name: least([answers[name] for answers in rounds]) for name in ready}
    alone = {question: _alone(question, size, f"--repeats={runs}") for question in QUESTIONS}
    return Findings(programs, absent, alone, runs, options.frequencies, options.few)


def one_round(
    ready: dict[str, tuple[Path, str]], absent: dict[str, str], arguments: tuple[str, ...]
) -> dict[str, dict[str, Any]]:
    """Return the answer of every program; a peer that fails goes over from `ready` to `absent`."""
    answers = {}
    for name, (python, script) in list(ready.items()):
        say(f"running {name}")
        try:
            answers[name] = ask(python, script, *arguments)
        except RuntimeError as error:
            if name == OURS:
                raise
            absent[name] = str(error)
            del ready[name]
    return answers


def install(folder: Path) -> tuple[dict[str, tuple[Path, str]], dict[str, str]]:
    """Return interpreter and script of every program at hand, and why the others are absent."""
    ready, absent = {OURS: (Path(sys.executable), "peer_multilayer.py")}, {}
    for peer in PEERS:
        try:
            ready[peer.name] = environment(peer, folder), peer.script
        except AbsentError as error:
            absent[peer.name] = str(error)
    return ready, absent


def least(answers: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the answer of a program with the least time of every case."""
    first = answers[0]
    cases = {
        name: {**case, "seconds": min(answer["cases"][name]["seconds"] for answer in answers)}
        for name, case in first["cases"].items()
    }
    return {**first, "cases": cases}


def _alone(question: str, *limits: str) -> dict[str, Any]:
    say(f"running {OURS} alone: {question}")
    return ask(Path(sys.executable), "peer_alone.py", question, *limits)


def say(text: str) -> None:
    """Tell the person who waits; the page itself goes to the standard output."""
    print(text, file=sys.stderr)  # noqa: T201


def main() -> None:
    """Run the comparison and print the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--environments", type=Path, default=ROOT / ".venv" / "peers", help="where the peers live")
    parser.add_argument("--rounds", type=int, default=3, help="how often the programs take turns")
    parser.add_argument("--repeats", type=int, default=5, help="timings of every case in a round, after a warm-up")
    parser.add_argument("--frequencies", type=int, default=1000)
    parser.add_argument("--few", type=int, default=20, help="frequencies for a diffuse field that takes long")
    print(write_page(compare(parser.parse_args())))  # noqa: T201


if __name__ == "__main__":
    main()
