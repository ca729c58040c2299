"""Streams of samples: removal of stale reads, and joining into an episode table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from trundle.importers.layout import Columns, Floats

__all__ = ["MIN_REST_DURATION_S", "Stream", "drop_stale", "interval", "join"]

MIN_REST_DURATION_S = 0.1
"""Duration from which a repeated value indicates rest, s. A shorter repeat is a stale read."""


@dataclass(frozen=True)
class Stream:
    """Samples of one instrument.

    Attributes
    ----------
    names : sequence of str
        Table columns, k of them.
    t : (n,) array
        Sample times, s, not necessarily increasing.
    values : (n, k) array
        SI units.
    held : bool
        Whether a value holds until the next sample, as that of a command does.
    """

    names: Sequence[str]
    t: Floats
    values: Floats
    held: bool = False

    def where(self, keep: np.ndarray) -> Stream:
        """Return the samples selected by a mask or by indices."""
        return replace(self, t=self.t[keep], values=self.values[keep])

    def later(self, seconds: float) -> Stream:
        """Return the same samples with `seconds` added to their times."""
        return replace(self, t=self.t + seconds)

    def ordered(self) -> tuple[Stream, int]:
        """Return the samples sorted by time, without repeated stamps, and the number of dropped samples."""
        _, first = np.unique(self.t, return_index=True)
        return self.where(first), len(self.t) - len(first)


def drop_stale(stream: Stream, rest: float = MIN_REST_DURATION_S) -> tuple[Stream, int]:
    """Drop stale reads: short runs of a repeated value. Longer runs are kept as rest.

    Parameters
    ----------
    stream : Stream
        Ordered by time.
    rest : float
        Minimum duration of a run that is kept, s.

    Returns
    -------
    stream : Stream
        The remaining samples.
    count : int
        Number of dropped samples.
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
    """Return the samples with `begin` <= t <= `end`, and the value that a held stream has at `begin`."""
    inside = stream.where((stream.t >= begin) & (stream.t <= end))
    before = np.flatnonzero(stream.t < begin)
    if not stream.held or not len(before) or (len(inside.t) and inside.t[0] == begin):
        return inside
    first = stream.values[before[-1:]]
    return replace(inside, t=np.append(begin, inside.t), values=np.vstack([first, inside.values]))


def join(streams: Sequence[Stream]) -> Columns:
    """Join streams of different rates into one table with a row per distinct time.

    Parameters
    ----------
    streams : sequence of Stream
        Each with strictly increasing times and distinct column names.

    Returns
    -------
    Columns
        `t` and the columns of all streams, NaN where a stream has no sample.
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
