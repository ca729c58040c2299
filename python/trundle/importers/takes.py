"""From the streams of one take (a bag, a file) to the episodes of a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from trundle.importers.config import MapError
from trundle.importers.layout import Columns, Floats, Imported, SourceError
from trundle.importers.poses import Offset, Poses, World, gripper_stream, object_stream
from trundle.importers.streams import Stream, drop_stale, interval, join

__all__ = ["BodyMap", "EpisodeMap", "GripperMap", "Take", "assemble", "clean_stream", "to_recording_frames"]


@dataclass(frozen=True)
class EpisodeMap:
    """One episode cut from a take.

    Attributes
    ----------
    name : str
        Name of the episode.
    source : str
        File or bag within SOURCE; may be left out if there is one.
    start, end : float
        s after the first sample of the take; all of it by default.
    """

    name: str
    source: str | None = None
    start: float = 0.0
    end: float = float("inf")


@dataclass(frozen=True)
class BodyMap:
    """How a tracked body becomes the object.

    Attributes
    ----------
    offset : Offset
        The object frame, seen from the tracked one.
    """

    offset: Offset = field(default_factory=Offset)


@dataclass(frozen=True)
class GripperMap(BodyMap):
    """How a tracked hand becomes the gripper.

    Attributes
    ----------
    offset : Offset
        The sensor frame, seen from the tracked one.
    level_within_deg : float
        A frame that never leans more is recorded by its heading alone.
    """

    level_within_deg: float = 2.0


@dataclass
class Take:
    """What was measured in one go.

    Attributes
    ----------
    source : Path
        File or bag.
    streams : list of Stream
        Increasing times, one clock.
    remarks : list of str
        What was left out.
    """

    source: Path
    streams: list[Stream]
    remarks: list[str]


def to_recording_frames(
    bodies: Mapping[str, Poses], body: BodyMap, hand: GripperMap, world: World, wrench: Stream | None
) -> tuple[list[Stream], list[str]]:
    """Bring tracked poses to the frames of a recording.

    Parameters
    ----------
    bodies : mapping
        Tracked poses of "object", "gripper", where there are any.
    body, hand : BodyMap, HandMap
        Where object and sensor are in the tracked frames.
    world : World
        The tracker's world.
    wrench : Stream or None
        In the axes of the gripper's frame; turned with it if that hangs upside down.

    Returns
    -------
    streams : list of Stream
        Object, gripper, wrench, as far as there are any.
    remarks : list of str
        What was turned.
    """
    streams, remarks = [], []
    if "object" in bodies:
        streams.append(object_stream(_apply_offset(bodies["object"], body.offset, world, "object")))
    if "gripper" in bodies:
        there = _apply_offset(bodies["gripper"], hand.offset, world, "gripper")
        stream, turned = gripper_stream(there, float(np.radians(hand.level_within_deg)))
        streams.append(stream)
        if turned:
            remarks.append("the sensor hangs upside down: its frame and its wrench were turned about its x")
            wrench = None if wrench is None else _flip_wrench(wrench)
    return [*streams, *([] if wrench is None else [wrench])], remarks


def _apply_offset(poses: Poses, offset: Offset, world: World, role: str) -> Poses:
    return poses.turned(world.rotation()).carried(offset.translation, offset.rotation(f"{role}.offset"))


def _flip_wrench(wrench: Stream) -> Stream:
    signs = np.array([1.0 if name.endswith("_x") else -1.0 for name in wrench.names])
    return Stream(wrench.names, wrench.t, wrench.values * signs)


def clean_stream(stream: Stream, label: str, keep_repeats: bool) -> tuple[Stream, list[str]]:
    """Order a stream by time; leave out shared time stamps, empty samples and stale reads, and say so."""
    whole = np.all(np.isfinite(stream.values), axis=1) & np.isfinite(stream.t)
    ordered, same = stream.where(whole).ordered()
    # A single quantised channel repeats itself without being stale.
    stale = 0
    if not keep_repeats and len(stream.names) > 1:
        ordered, stale = drop_stale(ordered)
    counts = {
        "without a value": int(np.sum(~whole)),
        "with a time stamp that was there": same,
        "repeated": stale,
    }
    said = [f"{label}: {count} samples {what} left out" for what, count in counts.items() if count]
    return ordered, said


def assemble(
    takes: Sequence[Take], episodes: Sequence[EpisodeMap], recording: Mapping[str, Any], name: str
) -> Imported:
    """Cut takes into episodes.

    Parameters
    ----------
    takes : sequence of Take
        In the order in which they happened.
    episodes : sequence of EpisodeMap
        None: each take is an episode.
    recording : mapping
        Tables of `recording.toml` passed through from the map.
    name : str
        Name of the recording, where the map has none.

    Returns
    -------
    Imported
        Times count from each episode's start.
    """
    wanted = episodes or [
        EpisodeMap(f"episode_{index:02d}", take.source.name) for index, take in enumerate(takes)
    ]
    tables: dict[str, Columns] = {}
    for episode in wanted:
        if episode.name in tables:
            raise MapError(f"two episodes are called {episode.name!r}; names are unique")
        tables[episode.name] = _cut_episode(_find_take(takes, episode), episode)
    metadata = {"format": "trundle-recording/1", "name": name, **recording}
    prefix = len(takes) > 1
    remarks = [f"{take.source.name}: {said}" if prefix else said for take in takes for said in take.remarks]
    return Imported(metadata, tables, remarks)


def _find_take(takes: Sequence[Take], episode: EpisodeMap) -> Take:
    fitting = [take for take in takes if episode.source in (None, take.source.name)]
    if len(fitting) == 1:
        return fitting[0]
    listing = ", ".join(take.source.name for take in takes)
    raise MapError(f"episode {episode.name!r} needs `source`, one of: {listing}; it has {episode.source!r}")


def _cut_episode(take: Take, episode: EpisodeMap) -> Columns:
    if episode.end <= episode.start:
        raise MapError(
            f"episode {episode.name!r} ends at {episode.end} s, before its start at {episode.start} s"
        )
    first = min(_first_time(stream.t) for stream in take.streams)
    pieces = []
    for stream in take.streams:
        moved = Stream(stream.names, stream.t - first - episode.start, stream.values)
        piece = interval(moved, 0.0, episode.end - episode.start)
        if not len(piece.t):
            last = max(float(each.t[-1]) for each in take.streams if len(each.t)) - first
            raise SourceError(
                take.source,
                f"episode {episode.name!r} ({episode.start} to {min(episode.end, last):.3f} s) holds no "
                f"sample of {stream.names[0].split('_')[0]}; the take lasts {last:.3f} s",
            )
        pieces.append(piece)
    return join(pieces)


def _first_time(t: Floats) -> float:
    return float(t[0]) if len(t) else float("inf")
