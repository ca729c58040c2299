"""Sequential access to the bytes of MATLAB files, with every length checked."""

from __future__ import annotations

import numpy as np

from trundle.importers.layout import Floats

__all__ = ["COMPRESSED", "Budget", "Bytes", "DamagedError"]

COMPRESSED = 15
"""Type of a compressed element, which is not padded."""


class DamagedError(ValueError):
    """The file is malformed; the message describes how."""


class Budget:
    """A memory budget, bytes."""

    def __init__(self, limit: int) -> None:
        self.limit = self.left = limit

    def take(self, size: int) -> None:
        """Reduce the budget by `size`; raise `DamagedError` if it is exceeded."""
        if size > self.left:
            raise DamagedError(
                f"its variables need more than {self.limit >> 20} MiB, the limit for a file of this size; "
                "save it uncompressed with `save(file, '-v6')`"
            )
        self.left -= size


class Bytes:
    """A sequential reader of bytes."""

    def __init__(self, data: memoryview, order: str, budget: Budget) -> None:
        self.data, self.order, self.budget = data, order, budget

    @property
    def left(self) -> int:
        """Number of remaining bytes."""
        return len(self.data)

    def take(self, size: int) -> Bytes:
        """Return the next `size` bytes."""
        if not 0 <= size <= len(self.data):
            raise DamagedError(f"{size} more bytes expected at the end")
        taken, self.data = self.data[:size], self.data[size:]
        return Bytes(taken, self.order, self.budget)

    def numbers(self, kind: str, count: int) -> Floats:
        """Return the next `count` numbers of a type such as `f8`, as float64."""
        size = np.dtype(kind).itemsize
        if not 0 <= count <= len(self.data) // size:
            raise DamagedError(f"{count} more numbers expected at the end")
        self.budget.take(8 * count)
        raw = np.frombuffer(self.take(size * count).data, dtype=self.order + kind)
        with np.errstate(invalid="ignore"):  # a signalling NaN
            return raw.astype(np.float64)

    def whole(self, count: int) -> list[int]:
        """Return the next `count` 4-byte integers."""
        size = self.take(4 * count).data
        return [int(value) for value in np.frombuffer(size, dtype=self.order + "i4")]

    def element(self) -> tuple[int, Bytes]:
        """Return type and content of the next data element."""
        tag = int(np.frombuffer(self.take(4).data, dtype=self.order + "u4")[0])
        if tag >> 16:
            content = self.take(4)
            return tag & 0xFFFF, content.take(tag >> 16)
        size = int(np.frombuffer(self.take(4).data, dtype=self.order + "u4")[0])
        content = self.take(size)
        if tag != COMPRESSED:
            self.take(min(-size % 8, self.left))
        return tag, content
