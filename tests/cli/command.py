"""The command line as a user meets it: in this process where that is enough, in another where imports matter."""

import io
import os
import subprocess
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import NamedTuple
from unittest import mock

from multilayer.cli import main


# what the console script does
_SCRIPT = "import sys; from multilayer.cli import main; sys.argv[0] = 'multilayer'; main()"


class Outcome(NamedTuple):
    """Exit status, standard output and standard error."""

    status: int
    out: str
    err: str


def run(*arguments, cwd=None) -> Outcome:
    """Run ``multilayer ARGUMENTS`` in this process."""
    out, err = io.StringIO(), io.StringIO()
    argv = ["multilayer", *map(str, arguments)]
    here = chdir(cwd or Path.cwd())
    with here, mock.patch.object(sys, "argv", argv), redirect_stdout(out), redirect_stderr(err):
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
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    return Outcome(done.returncode, done.stdout, done.stderr)
