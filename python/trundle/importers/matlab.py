"""Reader of numeric variables in MATLAB files of versions 4 to 7.2, safe for malformed input.

The format is described in MathWorks' "MAT-File Format" (R2019b). Of text, sparse arrays and objects
only name and shape are read. Every length is checked against the remaining bytes, and the size of
decompressed data is limited.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from trundle.importers.layout import Floats
from trundle.importers.matlab_bytes import COMPRESSED, Budget, Bytes, DamagedError

__all__ = ["Cell", "DamagedError", "HDF5Error", "Other", "Struct", "Value", "read"]

BASE_MEMORY_BYTES = 64 << 20
"""Constant part of the memory limit of a file's variables, bytes; as for tables of recordings."""
MEMORY_PER_FILE_BYTE = 64
"""Part of the memory limit per byte of the file."""
MAX_DEPTH = 16
"""Maximum nesting of structures."""
MAX_DIMENSIONS = 32
"""Maximum number of dimensions, that of NumPy 1."""

HEADER_BYTES = 128
MATRIX = 14
NUMBERS = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
}
"""Stored number types."""
CELL, STRUCT, NUMERIC = 1, 2, range(6, 16)
"""Array classes."""
CLASSES = {3: "object", 4: "text", 5: "sparse", 16: "function", 17: "object"}
COMPLEX = 0x800
VERSION_4_NUMBERS = ["f8", "f4", "i4", "i2", "u2", "u1"]
"""Stored number types of version 4."""


class HDF5Error(ValueError):
    """The file is of version 7.3, which is HDF5."""


@dataclass
class Struct:
    """A structure array; only its first element is read."""

    shape: tuple[int, ...]
    fields: dict[str, Value]


@dataclass
class Other:
    """An array without real numbers, known by shape and kind only."""

    shape: tuple[int, ...]
    kind: str


@dataclass
class Cell:
    """A cell array; its elements are in the order of its columns."""

    shape: tuple[int, ...]
    values: list[Value]


Value: TypeAlias = Floats | Struct | Cell | Other


def read(content: bytes) -> dict[str, Value]:
    """Return the variables in the content of a file by name.

    Raises
    ------
    DamagedError
        If it is not a MATLAB file, is malformed, or needs more memory than `BASE_MEMORY_BYTES` plus
        `MEMORY_PER_FILE_BYTE` per byte of the file.
    HDF5Error
        If the file is of version 7.3.
    """
    budget = Budget(BASE_MEMORY_BYTES + MEMORY_PER_FILE_BYTE * len(content))
    if len(content) >= 4 and 0 in content[:4]:
        return _read_version_4(Bytes(memoryview(content), "<", budget))
    if len(content) < HEADER_BYTES or content[126:128] not in (b"IM", b"MI"):
        raise DamagedError("invalid header")
    order = "<" if content[126:128] == b"IM" else ">"
    major = content[125] if order == "<" else content[124]
    if major == 2:
        raise HDF5Error("version 7.3")
    if major != 1:
        raise DamagedError(f"unknown version {major}")
    found: dict[str, Value] = {}
    rest = Bytes(memoryview(content)[HEADER_BYTES:], order, budget)
    while rest.left:
        variable = _variable(rest)
        if variable is not None:
            found[variable[0]] = variable[1]
    return found


def _variable(rest: Bytes) -> tuple[str, Value] | None:
    """Return name and value of the next variable; None for an element of another type."""
    kind, content = rest.element()
    if kind == COMPRESSED:
        kind, content = _decompress(content).element()
    return _matrix(content, 0) if kind == MATRIX else None


def _decompress(content: Bytes) -> Bytes:
    unpack = zlib.decompressobj()
    try:
        data = unpack.decompress(content.data, content.budget.left + 1)
    except zlib.error as error:
        raise DamagedError(f"a variable cannot be decompressed: {error}") from error
    content.budget.take(len(data))
    return Bytes(memoryview(data), content.order, content.budget)


def _matrix(content: Bytes, depth: int) -> tuple[str, Value]:
    """Return name and value of an array."""
    if depth > MAX_DEPTH:
        raise DamagedError(f"structures are nested more than {MAX_DEPTH} deep")
    if not content.left:
        return "", np.zeros((0, 0))
    flags = content.element()[1].whole(1)[0]
    number = flags & 0xFF
    if number == 17:
        return _text(content.element()[1]), Other((1, 1), CLASSES[number])
    _, sizes = content.element()
    shape = tuple(sizes.whole(sizes.left // 4))
    name = _text(content.element()[1])
    if not 2 <= len(shape) <= MAX_DIMENSIONS or min(shape) < 0:
        raise DamagedError(f"variable {name!r} has the shape {shape}")
    if number == STRUCT:
        return name, _struct(content, shape, depth)
    if number == CELL:
        return name, Cell(shape, [_element(content, name, depth) for _ in range(math.prod(shape))])
    if number not in NUMERIC or flags & COMPLEX:
        return name, Other(shape, CLASSES.get(number, "complex" if number in NUMERIC else "unknown"))
    kind, numbers = content.element()
    if kind not in NUMBERS:
        raise DamagedError(f"variable {name!r} has the unknown number type {kind}")
    return name, numbers.numbers(NUMBERS[kind], math.prod(shape)).reshape(shape, order="F")


def _struct(content: Bytes, shape: tuple[int, ...], depth: int) -> Struct:
    length = content.element()[1].whole(1)[0]
    _, names = content.element()
    if length < 1:
        raise DamagedError(f"a structure has field names of {length} bytes")
    known = [_text(names.take(length)) for _ in range(names.left // length)]
    fields: dict[str, Value] = {}
    for name in known if math.prod(shape) else []:
        fields[name] = _element(content, name, depth)
    return Struct(shape, fields)


def _element(content: Bytes, name: str, depth: int) -> Value:
    """Return the next array inside a structure or cell."""
    kind, inner = content.element()
    if kind != MATRIX:
        raise DamagedError(f"an element of {name!r} is not an array")
    return _matrix(inner, depth + 1)[1]


def _text(content: Bytes) -> str:
    return bytes(content.data).split(b"\0")[0].decode("ascii", errors="replace")


def _read_version_4(rest: Bytes) -> dict[str, Value]:
    """Return the variables of a file of version 4: each is a header of five integers and a matrix."""
    found: dict[str, Value] = {}
    while rest.left:
        head = rest.take(20)
        rest.order = "<" if 0 <= int.from_bytes(head.data[:4], "little") < 5000 else ">"
        head.order = rest.order
        form, rows, columns, imaginary, length = head.whole(5)
        machine, zero, precision, kind = (form // 10**k % 10 for k in (3, 2, 1, 0))
        known = (
            0 <= form < 5000
            and machine in (0, 1)
            and not zero
            and precision < len(VERSION_4_NUMBERS)
            and kind < 3
        )
        if not known or min(rows, columns, length) < 0:
            raise DamagedError("invalid header of the file or of a variable")
        name = _text(rest.take(length))
        size = np.dtype(VERSION_4_NUMBERS[precision]).itemsize * rows * columns
        if kind or imaginary:
            rest.take(size * (2 if imaginary else 1))
            found[name] = Other((rows, columns), ("complex", "text", "sparse")[kind])
        else:
            numbers = rest.numbers(VERSION_4_NUMBERS[precision], rows * columns)
            found[name] = numbers.reshape((rows, columns), order="F")
    return found
