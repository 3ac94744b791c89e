"""The command line as a user meets it: in this process where that is enough, in another where imports matter."""

import io
import json
import os
import re
import subprocess
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import NamedTuple
from unittest import mock

from multilayer.cli import main

# what the console script does
_SCRIPT = "import sys; from multilayer.cli import main; sys.argv[0] = 'multilayer'; main()"


_ANSI = re.compile(r"\x1b\[[0-9;]*m")
_LEFT_OUT = ("FORCE_COLOR", "PY_COLORS", "GITHUB_ACTIONS", "MULTILAYER_DEBUG")


def _environment(**additions):
    """Return an environment in which nothing asks for colours, and a page is 100 columns wide."""
    kept = {name: value for name, value in os.environ.items() if name not in _LEFT_OUT}
    return {**kept, "COLUMNS": "100", **additions}


class Outcome(NamedTuple):
    """Exit status, standard output and standard error."""

    status: int
    out: str
    err: str


def run(*arguments, cwd=None, **environment) -> Outcome:
    """Run ``multilayer ARGUMENTS`` in this process, with additions to the environment; colours are left out."""
    status, *texts = run_to_the_letter(*arguments, cwd=cwd, **environment)
    return Outcome(status, *(_ANSI.sub("", text) for text in texts))


def run_to_the_letter(*arguments, cwd=None, **environment) -> Outcome:
    """Run ``multilayer ARGUMENTS`` in this process, with additions to the environment."""
    out, err = io.StringIO(), io.StringIO()
    argv = ["multilayer", *map(str, arguments)]
    surroundings = mock.patch.dict(os.environ, _environment(**environment), clear=True)
    with (
        chdir(cwd or Path.cwd()),
        surroundings,
        mock.patch.object(sys, "argv", argv),
        redirect_stdout(out),
        redirect_stderr(err),
    ):
        try:
            main()
        except SystemExit as stop:
            status = stop.code or 0
        else:
            status = 0
    assert isinstance(status, int), status
    return Outcome(status, out.getvalue(), err.getvalue())


def run_elsewhere(*arguments, cwd=None, **environment) -> Outcome:
    """Run ``multilayer ARGUMENTS`` in a process of its own, with additions to the environment."""
    return python("-c", _SCRIPT, *arguments, cwd=cwd, **environment)


def python(*arguments, cwd=None, **environment) -> Outcome:
    """Run this Python with arguments in a process of its own."""
    done = subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=cwd,
        env=_environment(**environment),
        capture_output=True,
        text=True,
        check=False,
    )
    return Outcome(done.returncode, *(_ANSI.sub("", text) for text in (done.stdout, done.stderr)))


def result_names(folder: Path) -> set[str]:
    """Return the names in a folder of results beside its manifest, which must hold all of them."""
    names = {path.name for path in folder.iterdir()}
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    assert {name for entry in manifest["results"].values() for name in entry["files"]} == names - {"manifest.json"}
    return names - {"manifest.json"}
