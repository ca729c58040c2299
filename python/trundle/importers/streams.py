"""Streams of samples: cleaned of stale reads, joined into the one table of an episode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trundle.importers.layout import Columns, Floats

__all__ = ["MIN_REST_DURATION_S", "Stream", "drop_stale", "interval", "join"]

MIN_REST_DURATION_S = 0.1
"""s; a value repeated for less is a stale read of a slower device, for longer the thing stands still."""


@dataclass(frozen=True)
class Stream:
    """Samples of one instrument.

    Attributes
    ----------
    names : sequence of str
        Table columns, k of them.
    t : (n,) array
        Sample times in s, not yet necessarily increasing.
    values : (n, k) array
        SI units.
    """

    names: Sequence[str]
    t: Floats
    values: Floats

    def where(self, keep: np.ndarray) -> Stream:
        """Return the samples selected by a mask or by indices."""
        return Stream(self.names, self.t[keep], self.values[keep])

    def ordered(self) -> tuple[Stream, int]:
        """Return the samples by time, the first of each time stamp only, and how many were left out."""
        _, first = np.unique(self.t, return_index=True)
        return self.where(first), len(self.t) - len(first)


def drop_stale(stream: Stream, rest: float = MIN_REST_DURATION_S) -> tuple[Stream, int]:
    """Leave out repeats of a held value, but not those of something that stands still.

    Parameters
    ----------
    stream : Stream
        Ordered by time.
    rest : float
        Runs of one value that last at least so long (s) are kept whole.

    Returns
    -------
    stream : Stream
        What remains.
    count : int
        How many samples were left out.
    """
    if len(stream.t) == 0:
        return stream, 0
    new = np.append(True, np.any(np.diff(stream.values, axis=0) != 0, axis=1))
    run = np.cumsum(new) - 1
    starts = np.flatnonzero(new)
    ends = np.append(starts[1:], len(new)) - 1
    still = (stream.t[ends] - stream.t[starts] >= rest)[run]
    keep = new | still
    return stream.where(keep), int(np.sum(~keep))


def interval(stream: Stream, begin: float, end: float) -> Stream:
    """Return the samples with `begin` <= t <= `end`."""
    return stream.where((stream.t >= begin) & (stream.t <= end))


def join(streams: Sequence[Stream]) -> Columns:
    """Put streams of different rates into one table, a row per distinct time.

    Parameters
    ----------
    streams : sequence of Stream
        Each strictly increasing in time and with names of its own.

    Returns
    -------
    Columns
        `t` and every stream's columns, NaN where a stream has no sample.
    """
    t = np.unique(np.concatenate([stream.t for stream in streams]))
    table: Columns = {"t": t}
    for stream in streams:
        rows = np.searchsorted(t, stream.t)
        for name, values in zip(stream.names, stream.values.T, strict=True):
            column = np.full(len(t), np.nan)
            column[rows] = values
            table[name] = column
    return table
