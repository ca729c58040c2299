"""Frames and number parsing that both kinds of CMU logs share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from trundle.importers.layout import Floats, SourceError

__all__ = ["MILLIMETRE", "numbers", "wrench_metadata"]

MILLIMETRE = 1e-3


def wrench_metadata(sign: str, precontact: dict[str, list[float]]) -> dict[str, object]:
    """Return the table `[wrench]` of `recording.toml`: raw sensor readings, point contact."""
    return {
        "frame": "sensor",
        "reference": "sensor",
        "sign": sign,
        "raw": True,
        "precontact": precontact,
        "contact": "point",
        "source": "measured",
    }


def numbers(path: Path, lines: Sequence[str], rows: Sequence[int], width: int) -> Floats:
    """Parse lines of `width` numbers each.

    Parameters
    ----------
    path : Path
        For messages.
    lines : sequence of str
        Numbers separated by blanks.
    rows : sequence of int
        Row numbers in the file, from 1, for messages.
    width : int
        Required number of numbers per line.

    Returns
    -------
    (n, width) array
    """
    parsed = []
    for row, line in zip(rows, lines, strict=True):
        try:
            values = [float(word) for word in line.split()]
        except ValueError:
            values = []
        if len(values) != width or not np.all(np.isfinite(values)):
            raise SourceError(
                path, f"row {row} = {line[:60]!r}: must contain {width} numbers; is the file complete?"
            )
        parsed.append(values)
    return np.array(parsed, dtype=np.float64).reshape(len(parsed), width)
