"""What people read when a command fails on something that nobody foresaw: whose mistake it is, and where it lies."""

from __future__ import annotations

import errno
import os
import re
import traceback
from importlib.metadata import entry_points, metadata
from importlib.util import find_spec
from pathlib import Path

from multilayer.doors import cut, for_log, for_terminal

INPUT, PLUGIN, INTERNAL = 2, 2, 70  # exit statuses
_SHOWN, _LONGEST = 80, 4000  # characters of a name, and of what an exception says
_SCARCE = (errno.ENOMEM, errno.EMFILE, errno.ENFILE, errno.EAGAIN)
_FRAME = re.compile(r'File "(?P<file>[^"]+)", line (?P<line>\d+), in (?P<function>\S+)')
_BUG = (
    "multilayer failed on something it should have foreseen ({error}). This is a bug: please report it{where}, with "
    "the command, its input and what MULTILAYER_DEBUG=1 in the environment makes this command print."
)


def failure(error: Exception, files: tuple[Path, ...] = ()) -> tuple[str, int]:
    """Return a message and an exit status for an exception that is no `MultilayerError`.

    Parameters
    ----------
    error : Exception
        Also one that a process of a pool raised.
    files : tuple of Path, optional
        Plugins that ``--plugin`` named.
    """
    if isinstance(error, OSError) and error.errno == errno.ENAMETOOLONG:
        return f"{for_log(error.filename)[:_SHOWN]}...: no file's name may be so long; there is no such file", INPUT
    if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno in _SCARCE):
        said = cut(for_log(str(error)), _LONGEST) or "out of memory"
        return f"the system gives no more ({said}); use fewer --jobs, or allow this process more", INPUT
    text = cut(for_terminal(f"{type(error).__name__}: {error}"), _LONGEST)
    folders = [*map(str, files), *(str(file.resolve()) for file in files), *_plugin_folders()]
    for file, line, function in reversed(_frames(error)):
        if any(file == folder or file.startswith(f"{folder}{os.sep}") for folder in folders):
            return (
                f"{file}:{line}: the plugin failed here, in {function}: {text}. multilayer itself is not at fault.",
                PLUGIN,
            )
    return _BUG.format(error=text, where=_tracker()), INTERNAL


def _frames(error: Exception) -> list[tuple[str, int, str]]:
    """Return file, line and function of all calls, the innermost last; of another process from its text."""
    here = [(frame.filename, frame.lineno or 0, frame.name) for frame in traceback.extract_tb(error.__traceback__)]
    there = [(m["file"], int(m["line"]), m["function"]) for m in _FRAME.finditer(str(error.__cause__ or ""))]
    return [*here, *there]


def _plugin_folders() -> list[str]:
    """Return the folders, or single modules, of all packages that bring something for multilayer."""
    groups = [group for group in entry_points().groups if group.startswith("multilayer.")]
    modules = {entry.module.partition(".")[0] for group in groups for entry in entry_points(group=group)}
    found = []
    for name in sorted(modules - {"multilayer"}):
        spec = find_spec(name)
        if spec is not None and spec.origin is not None:
            origin = Path(spec.origin)
            found.append(str(origin.parent if origin.name == "__init__.py" else origin))
    return found


def _tracker() -> str:
    """Return where bugs are reported, if the package says so."""
    urls = dict(text.split(", ", 1) for text in metadata("multilayer").get_all("Project-URL") or ())
    return f" at {urls['Issues']}" if "Issues" in urls else " to whom you have it from"
