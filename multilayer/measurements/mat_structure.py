"""Whether a MATLAB file (version 5 to 7.2) holds what it says: ahead of SciPy's reader, which some damage makes crash.

MAT-File Format, The MathWorks: a file is a list of data elements, each a tag (type, bytes) and its data; arrays are
elements of elements, compressed ones an element within a zlib stream.
"""

from __future__ import annotations

import struct
import zlib
from math import prod
from pathlib import Path

from multilayer.bounds import CHANNELS, DATA_VALUES

_HEADER = 128  # bytes
_SIZES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, 16: 1, 17: 2, 18: 4}  # of types of numbers
_INT32, _UINT32, _ARRAY, _COMPRESSED = 5, 6, 14, 15
_CELL, _STRUCT, _OBJECT, _SPARSE, _LAST_NUMERIC, _FUNCTION = 1, 2, 3, 5, 15, 16
_COMPLEX = 0x800
_DEEPEST = 20
_PIECE = 1 << 20


class _UnsoundError(ValueError):
    """What is wrong with a file; for people."""


def refuse_unsound(file: Path) -> None:
    """Refuse a file whose elements do not fit into each other, or claim more numbers than are taken.

    Parameters
    ----------
    file : Path
        Not of version 7.3, which is HDF5. One of version 4, plain matrices, is left to SciPy.

    Raises
    ------
    InputError
        For more numbers than `bounds.DATA_VALUES`.
    ValueError
        For all else.
    """
    content = memoryview(file.read_bytes())
    if 0 in bytes(content[:4]):  # version 4
        return
    if len(content) < _HEADER:
        raise _UnsoundError("it ends within its header")
    _Walk(file, "<" if bytes(content[126:128]) == b"IM" else ">").file_content(content)


class _Walk:
    """A look at every element, none of which is kept."""

    def __init__(self, file: Path, order: str) -> None:
        self.file, self.order = file, order
        self.numbers = self.arrays = 0

    def file_content(self, content: memoryview) -> None:
        at = _HEADER
        while at < len(content):
            kind, data, at = self._element(content, at, pads=False)
            if kind == _COMPRESSED:
                kind, data, _ = self._element(memoryview(self._unpacked(data)), 0)
            if kind != _ARRAY:
                raise _UnsoundError(f"an element of type {kind} stands where an array must")
            self._array(data, 0)

    def _unpacked(self, data: memoryview) -> bytes:
        """Return the content of a compressed element, unless there is too much of it."""
        unpack, pieces, size = zlib.decompressobj(), [], 0
        for start in range(0, len(data), _PIECE):
            left = bytes(data[start : start + _PIECE])
            while left:
                pieces.append(unpack.decompress(left, _PIECE))
                size += len(pieces[-1])
                DATA_VALUES.check(size // 8, self.file)
                left = unpack.unconsumed_tail
        if not unpack.eof:
            raise _UnsoundError("a compressed array ends too early")
        return b"".join(pieces)

    def _element(self, content: memoryview, at: int, *, pads: bool = True) -> tuple[int, memoryview, int]:
        """Return type and data of the element at a place, and where the next begins."""
        if at + 8 > len(content):
            raise _UnsoundError("it ends within the head of an element")
        kind, size = struct.unpack_from(f"{self.order}II", content, at)
        if kind >> 16:  # a small element: its data are in the head
            kind, size, start, after = kind & 0xFFFF, kind >> 16, at + 4, at + 8
            if size > 4:
                raise _UnsoundError(f"a short element claims {size} bytes")
        else:
            start = at + 8
            after = start + size + (-size % 8 if pads else 0)
        if start + size > len(content):
            raise _UnsoundError(f"an element claims {size} bytes, and {len(content) - start} are left")
        return kind, content[start : start + size], after

    def _array(self, content: memoryview, depth: int) -> None:
        if depth > _DEEPEST:
            raise _UnsoundError("its structs are nested too deep")
        if not len(content):  # an empty cell may be left out
            return
        self.arrays += 1
        CHANNELS.check(self.arrays, self.file)
        flags, at = self._of_type(content, 0, _UINT32, "flags")
        shape, at = self._of_type(content, at, _INT32, "dimensions")
        if len(flags) != 2 or len(shape) < 2 or min(shape) < 0:
            raise _UnsoundError("an array has no flags or dimensions")
        kind, count = flags[0] & 0xFF, prod(shape)
        self._count(count)
        _, _, at = self._numbers(content, at)  # the name
        if kind in (_STRUCT, _OBJECT):
            self._struct(content, at, count, depth, is_object=kind == _OBJECT)
        elif kind == _CELL:
            self._arrays(content, at, count, depth)
        elif kind == _SPARSE:
            self._sparse(content, at, shape, 2 if flags[0] & _COMPLEX else 1)
        elif kind <= _LAST_NUMERIC:
            self._parts(content, at, count, 2 if flags[0] & _COMPLEX else 1, is_text=kind == 4)
        elif kind == _FUNCTION:
            self._arrays(content, at, 1, depth)
        else:
            raise _UnsoundError(f"an array is of class {kind}; save numbers and structs of numbers")

    def _of_type(self, content: memoryview, at: int, wanted: int, what: str) -> tuple[tuple[int, ...], int]:
        kind, data, after = self._element(content, at)
        if kind != wanted or len(data) % 4:
            raise _UnsoundError(f"an array has no {what}")
        return struct.unpack(f"{self.order}{len(data) // 4}{'I' if wanted == _UINT32 else 'i'}", data), after

    def _numbers(self, content: memoryview, at: int) -> tuple[int, int, int]:
        """Return type and count of the numbers at a place, and where the next element begins."""
        kind, data, after = self._element(content, at)
        if kind not in _SIZES or len(data) % _SIZES[kind]:
            raise _UnsoundError(f"an element of type {kind} and {len(data)} bytes stands where numbers must")
        return kind, len(data) // _SIZES[kind], after

    def _parts(self, content: memoryview, at: int, count: int, parts: int, *, is_text: bool) -> None:
        for _ in range(parts):
            kind, held, at = self._numbers(content, at)
            if held != count and not (is_text and kind >= 16):  # characters may take several bytes
                raise _UnsoundError(f"an array of {count} numbers holds {held}")

    def _sparse(self, content: memoryview, at: int, shape: tuple[int, ...], parts: int) -> None:
        """Walk a sparse matrix: rows, where the columns begin among these, and numbers, some of them to spare."""
        rows, at = self._of_type(content, at, _INT32, "rows of its numbers")
        begins, at = self._of_type(content, at, _INT32, "begins of its columns")
        held = begins[-1] if begins else -1
        is_rising = list(begins) == sorted(begins) and begins[:1] == (0,)
        if len(shape) != 2 or len(begins) != shape[1] + 1 or not is_rising or held > len(rows):
            raise _UnsoundError("the columns of a sparse array do not fit its rows")
        if not all(0 <= row < shape[0] for row in rows[:held]):
            raise _UnsoundError(f"a sparse array of {shape[0]} rows has numbers elsewhere")
        for _ in range(parts):
            _, numbers, at = self._numbers(content, at)
            if numbers < held:
                raise _UnsoundError(f"a sparse array of {held} numbers holds {numbers}")

    def _struct(self, content: memoryview, at: int, count: int, depth: int, *, is_object: bool) -> None:
        if is_object:
            _, _, at = self._numbers(content, at)  # the name of its class
        lengths, at = self._of_type(content, at, _INT32, "length of names")
        if len(lengths) != 1 or lengths[0] < 1:
            raise _UnsoundError("a struct has no length of names")
        _, held, at = self._numbers(content, at)
        self._arrays(content, at, count * (held // lengths[0]), depth)

    def _arrays(self, content: memoryview, at: int, count: int, depth: int) -> None:
        for _ in range(count):
            kind, data, at = self._element(content, at)
            if kind != _ARRAY:
                raise _UnsoundError(f"an element of type {kind} stands where an array must")
            self._array(data, depth + 1)

    def _count(self, more: int) -> None:
        self.numbers += more
        DATA_VALUES.check(self.numbers, self.file)
