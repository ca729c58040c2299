"""Streams of joints: removal of empty and repeated samples, and the interval in which all joints are seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from trundle.importers.joints.columns import Kind
from trundle.importers.layout import Floats, SourceError
from trundle.importers.streams import Stream, interval
from trundle.importers.takes import Take

__all__ = ["joint_take", "sample_stream"]


def sample_stream(kind: Kind, joint: str, t: Floats, values: Floats, held: bool) -> tuple[Stream, int]:
    """Return the samples of a column in the order of time, and how many repeat a time stamp.

    Parameters
    ----------
    kind, joint : str
        The column.
    t, values : (n,) array
        Times, s, and values; NaN where there is no sample.
    held : bool
        Whether a value holds until the next sample.
    """
    there = np.isfinite(values) & np.isfinite(t)
    stream = Stream([f"{kind}_{joint}"], t[there], values[there, None], held)
    return stream.ordered()


def joint_take(
    source: Path,
    joints: Sequence[str],
    streams: Mapping[str, Stream],
    repeated: Mapping[str, int],
    name: str | None = None,
) -> Take:
    """Return a take from the first to the last time at which the positions of all joints are known.

    Parameters
    ----------
    source : Path
        For messages.
    joints : sequence of str
        The joints.
    streams : mapping of str to Stream
        A stream for each column.
    repeated : mapping of str to int
        Number of samples of each column that repeated a time stamp.
    name : str, optional
        Name of the episode.

    Raises
    ------
    SourceError
        If a joint has no positions, or the joints were not recorded at the same time.
    """
    for joint in joints:
        if f"q_{joint}" not in streams or not len(streams[f"q_{joint}"].t):
            raise SourceError(
                source, f"no position of joint {joint!r}; map q_{joint}, or remove it from `joints`"
            )
    positions = [streams[f"q_{joint}"].t for joint in joints]
    begin, end = max(float(t[0]) for t in positions), min(float(t[-1]) for t in positions)
    if end <= begin:
        raise SourceError(
            source,
            f"the positions of {', '.join(joints)} have no interval in common; import joints of one "
            "recording, with times of one clock",
        )
    remarks, kept = [], []
    for column, stream in streams.items():
        piece = interval(stream, begin, end)
        outside = int(np.sum((stream.t < begin) | (stream.t > end)))
        if not len(piece.t):
            remarks.append(f"{column}: omitted, no sample while the positions were recorded")
            continue
        if outside:
            remarks.append(f"{column}: {outside} samples outside the interval of all positions omitted")
        if repeated.get(column):
            remarks.append(f"{column}: {repeated[column]} samples with a repeated time stamp omitted")
        kept.append(piece)
    return Take(source, kept, remarks, name)
