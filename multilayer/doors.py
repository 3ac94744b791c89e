r"""Text of others at the doors where it goes out: a terminal, a log, a page or drawing, a cell of a table.

Names of layers, channels, files and materials come from files that somebody sent. Inside they are kept to the letter,
and JSON keeps them so; each door shows what could act on its reader as an escape, as ``\\x1b``.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

_HIDDEN = (
    "\x00-\x1f\x7f-\x9f"  # C0, DEL, C1: they move the cursor, clear the screen, set titles
    "\u061c\u202a-\u202e\u2066-\u2069"  # they turn the direction of what follows
    "\u2028\u2029"  # line and paragraph separators
    "\ud800-\udfff\ufffe\uffff"  # no characters: XML cannot hold them, nor UTF-8 the first
)
_IN_A_LINE = re.compile(f"[{_HIDDEN}]")
_IN_LINES = re.compile(rf"(?!\n)[{_HIDDEN}]")
# what rich writes on a terminal: colours, and how a progress bar goes back to the beginning of its line
_BY_RICH = r"\x1b\[[\d;]*m|\r?\x1b\[(?:\d*[AK]|\?25[lh])"
_NOT_BY_RICH = re.compile(rf"{_BY_RICH}|(?!\n)[{_HIDDEN}]")
# the beginning of a cell, also where a spreadsheet cuts at semicolons; apostrophes are counted to be undone
_FORMULA = re.compile(r"(?:^|(?<=;))(?=\s*'*[=+\-@\uff0b\uff0d\uff1d\uff20])")
_DISARMED = re.compile(r"(?:^|(?<=;))'(?=\s*'*[=+\-@\uff0b\uff0d\uff1d\uff20])")


def for_log(text: object) -> str:
    r"""Return a text as one line of a log: control characters shown as escapes, newlines as ``\n`` among them.

    Parameters
    ----------
    text : object
        Taken as text.
    """
    return _IN_A_LINE.sub(_escape, str(text))


def for_terminal(text: object) -> str:
    r"""Return a text as a terminal may show it: control characters shown as escapes, newlines kept.

    Shown as escapes are C0 and C1 controls, DEL, controls that turn the direction of text, separators of lines and
    paragraphs, and lone surrogates, which stand for bytes of file names that are no text.

    Parameters
    ----------
    text : object
        Taken as text.
    """
    return _IN_LINES.sub(_escape, str(text))


def ascii_line(text: object, most: int) -> str:
    """Return a text as one line of ASCII of at most so many characters, as cards and records of other programs take it.

    Parameters
    ----------
    text : object
        Taken as text.
    most : int
        Characters; what is longer loses its end.
    """
    return for_log(text).encode("ascii", "backslashreplace").decode()[:most].strip()


def for_page(text: str) -> str:
    """Return HTML, SVG or XML, or a text to be escaped for it, with what XML 1.0 cannot hold shown as escapes.

    So are the other characters that `for_terminal` shows so. Escapes need no further escaping: of a finished page, its
    markup stays as it is.

    Parameters
    ----------
    text : str
    """
    return _IN_LINES.sub(_escape, text)


def for_cell(text: str) -> str:
    """Return a text as a cell of a CSV table that no spreadsheet takes for a formula; `from_cell` undoes that.

    A text that begins with ``=``, ``+``, ``-`` or ``@`` (spaces and apostrophes before them not counted), or goes on so
    behind a semicolon, gets an apostrophe there. Control characters are shown as escapes, so that a row is a line.

    Parameters
    ----------
    text : str
        Not that of a number, whose sign has to stay.
    """
    return _FORMULA.sub("'", for_log(text))


def from_cell(cell: str) -> str:
    """Return the text that `for_cell` wrote.

    Parameters
    ----------
    cell : str
        Of a table of ours, or of anybody's: without such an apostrophe it stays as it is.
    """
    return _DISARMED.sub("", cell)


def cut(text: str, longest: int) -> str:
    """Return a text with its middle left out where it is long.

    Parameters
    ----------
    text : str
    longest : int
        Characters to be kept.
    """
    if len(text) <= longest:
        return text
    kept = longest // 2
    return f"{text[:kept]}... ({len(text) - 2 * kept} characters) ...{text[-kept:]}"


def _escape(hidden: re.Match[str]) -> str:
    found = hidden[0]
    return found if len(found) > 1 else found.encode("unicode_escape").decode("ascii")


class GuardedStream:
    """Standard output or error, whoever writes to it: control characters are shown as escapes, newlines kept.

    Only rich has its colours, and the movements of a progress bar: what it gets from us was made harmless before
    (`for_terminal`). Bytes have no way past this.

    Parameters
    ----------
    stream : text stream
        Where texts go.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write a text, and return its length."""
        by_rich = sys._getframe(1).f_globals.get("__name__") == "rich.console"  # which takes any stream for its own
        self._stream.write((_NOT_BY_RICH if by_rich else _IN_LINES).sub(_escape, text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        if name == "buffer":
            raise AttributeError(name)
        return getattr(self._stream, name)


@contextmanager
def guarded_streams() -> Iterator[None]:
    """Guard standard output and error while a block runs."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (cast(TextIO, GuardedStream(stream)) for stream in before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before
