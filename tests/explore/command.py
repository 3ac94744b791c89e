"""The command as a process of its own, which can be ended as a terminal ends it, and its server in this one."""

import subprocess
import sys
import threading
from contextlib import contextmanager

from multilayer.explore.server import Server

# a process in the background may have been told to ignore Ctrl-C
SCRIPT = (
    "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler);"
    "from multilayer.cli import main; sys.argv[0] = 'multilayer'; main()"
)


@contextmanager
def serving(explorer):
    """Give the server of a page, in this process, until the block ends."""
    with Server(explorer) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


@contextmanager
def exploring(*arguments):
    """Give the process of ``multilayer explore ARGUMENTS`` and the address that it printed."""
    command = [sys.executable, "-c", SCRIPT, "explore", *map(str, arguments), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            yield process, process.stdout.readline().strip()
        finally:
            process.kill()
