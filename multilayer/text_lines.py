"""Lines and cells of text files with tables, as programs and people of all kinds write them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from multilayer.bounds import TEXT_BYTES, TEXT_LINES
from multilayer.errors import InputError, Problem, show
from multilayer.files import refuse_endless
from multilayer.writing.manifest import note_input

_HINT = re.compile(r"sep=.?")  # ahead of the header, for spreadsheets
_QUOTED = r'(?:^|(?<=[,;\t]))\s*"(?:[^"]|"")*"'  # a cell in quotes
_DATA = re.compile(rf"(?:{_QUOTED}|[^#])*+")  # of a line, ahead of a comment

Line = tuple[int, str]  # its number from 1, and its text


@dataclass(frozen=True)
class Layout:
    """Where a table stands: its separator, the index of its header, and how many lines of units follow."""

    separator: str | None
    header: int
    n_units: int = 0

    @property
    def first(self) -> int:
        """Index of the first line of samples."""
        return self.header + 1 + self.n_units

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line, without blanks and quotes around them."""
        return [cell.strip().strip('"').strip() for cell in line.split(self.separator)]

    def pointed(self, text: str) -> str:
        """Return numbers with decimal points, as they are written where no comma separates columns."""
        return text if self.separator == "," else text.replace(",", ".")

    def refuse_two_marks(self, rows: Sequence[Line], file: Path) -> None:
        """Refuse commas in numbers where other numbers have points: which of them is before decimals, nothing tells.

        Parameters
        ----------
        rows : sequence of (int, str)
            Lines of numbers.
        file : Path
            Where they stand.

        Raises
        ------
        InputError
            With the line of the first comma.
        """
        if self.separator == ",":
            return
        comma, point = next(self._marked(rows, ","), None), next(self._marked(rows, "."), None)
        if comma and point:
            text = f"{show(comma[1])} has a comma, and {show(point[1])} in line {point[0]} a point"
            remedy = "write decimals with a point, and thousands without a mark"
            raise InputError(Problem(f"{text}; {remedy}", file=file, line=comma[0]))

    def _marked(self, rows: Sequence[Line], mark: str) -> Iterator[tuple[int, str]]:
        marked = ((number, cell) for number, line in rows if mark in line for cell in self.cells(line))
        return ((number, cell) for number, cell in marked if mark in cell and self.is_number(cell))

    def is_number(self, cell: str) -> bool:
        """Tell whether a cell is a number."""
        try:
            float(self.pointed(cell))
        except ValueError:
            return False
        return True

    def is_row(self, cells: Sequence[str]) -> bool:
        """Tell whether cells are a row of numbers, some of them missing perhaps."""
        return any(cells) and all(not cell or self.is_number(cell) for cell in cells)


def data_lines(file: Path) -> list[Line]:
    """Return the lines that are neither blank nor comments; a ``#`` in a quoted cell begins no comment."""
    note_input(file)
    try:
        if file.is_dir():
            raise InputError(Problem("is a folder; name the file in it", file=file))
        refuse_endless(file)
        TEXT_BYTES.check(file.stat().st_size, file, "save it in a binary format")
        raw = file.read_bytes()
        TEXT_LINES.check(raw.count(b"\n"), file, "save it in a binary format")
        text = _decoded(raw)
    except FileNotFoundError:
        raise InputError(Problem("there is no such file", file=file)) from None
    except (OSError, UnicodeDecodeError) as error:
        message = f"is no text that can be read ({error}); export it again as UTF-8"
        raise InputError(Problem(message, file=file)) from None
    stripped = ((number, _data(line).strip(" ")) for number, line in enumerate(text.splitlines(), start=1))
    return [(number, line) for number, line in stripped if line.strip() and not _HINT.fullmatch(line)]


def _data(line: str) -> str:
    before, hash_sign, _ = line.partition("#")
    if not hash_sign or '"' not in before:
        return before
    data = _DATA.match(line)
    assert data is not None  # it matches nothing, too
    return data[0]


def _decoded(raw: bytes) -> str:
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return raw.decode("utf-16")  # "Unicode text" of spreadsheets
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        if b"\0" in raw:
            raise
        text = raw.decode("cp1252")  # "CSV" of spreadsheets
    if "\0" in text:
        raise UnicodeDecodeError("utf-8", raw, raw.index(b"\0"), raw.index(b"\0") + 1, "a zero byte")
    return text
