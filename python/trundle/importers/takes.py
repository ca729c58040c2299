"""Conversion of takes (bags, files) to the episodes of a recording."""

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
        File or bag within SOURCE; optional if there is only one.
    start, end : float
        Time after the first sample of the take, s; by default the whole take.
    """

    name: str
    source: str | None = None
    start: float = 0.0
    end: float = float("inf")


@dataclass(frozen=True)
class BodyMap:
    """Settings of the tracked body of the object.

    Attributes
    ----------
    offset : Offset
        Pose of the object frame in the tracked frame.
    """

    offset: Offset = field(default_factory=Offset)


@dataclass(frozen=True)
class GripperMap(BodyMap):
    """Settings of the tracked body of the gripper.

    Attributes
    ----------
    offset : Offset
        Pose of the sensor frame in the tracked frame.
    level_within_deg : float
        Maximum tilt of a level frame, degrees. Of a level frame only the heading is recorded.
    """

    level_within_deg: float = 2.0


@dataclass
class Take:
    """One continuous measurement.

    Attributes
    ----------
    source : Path
        File or bag.
    streams : list of Stream
        Streams with increasing times of one clock.
    remarks : list of str
        Remarks on omitted samples.
    name : str, optional
        Name of the episode, if the whole take is one; by default `episode_00`, `episode_01`, …
    """

    source: Path
    streams: list[Stream]
    remarks: list[str]
    name: str | None = None

    @property
    def label(self) -> str:
        """Name of the take in maps and messages."""
        return self.name or self.source.name


def to_recording_frames(
    bodies: Mapping[str, Poses], body: BodyMap, gripper_map: GripperMap, world: World, wrench: Stream | None
) -> tuple[list[Stream], list[str]]:
    """Transform tracked poses to the frames of a recording.

    Parameters
    ----------
    bodies : mapping
        Tracked poses of "object" and "gripper", if available.
    body, gripper_map : BodyMap, GripperMap
        Object and sensor frames in the tracked frames.
    world : World
        World frame of the tracker.
    wrench : Stream or None
        Wrench in axes of the gripper frame. It is rotated with the frame of a sensor that hangs upside down.

    Returns
    -------
    streams : list of Stream
        Streams of object, gripper and wrench, if available.
    remarks : list of str
        Remarks on rotated frames.
    """
    streams, remarks = [], []
    if "object" in bodies:
        streams.append(object_stream(_apply_offset(bodies["object"], body.offset, world, "object")))
    if "gripper" in bodies:
        there = _apply_offset(bodies["gripper"], gripper_map.offset, world, "gripper")
        stream, turned = gripper_stream(there, float(np.radians(gripper_map.level_within_deg)))
        streams.append(stream)
        if turned:
            remarks.append("the sensor hangs upside down: rotated its frame and its wrench about its x axis")
            wrench = None if wrench is None else _flip_wrench(wrench)
    return [*streams, *([] if wrench is None else [wrench])], remarks


def _apply_offset(poses: Poses, offset: Offset, world: World, role: str) -> Poses:
    return poses.turned(world.rotation()).carried(offset.translation, offset.rotation(f"{role}.offset"))


def _flip_wrench(wrench: Stream) -> Stream:
    signs = np.array([1.0 if name.endswith("_x") else -1.0 for name in wrench.names])
    return Stream(wrench.names, wrench.t, wrench.values * signs)


def clean_stream(stream: Stream, label: str, keep_repeats: bool) -> tuple[Stream, list[str]]:
    """Sort a stream by time and drop repeated time stamps, empty samples and stale reads.

    Returns
    -------
    stream : Stream
        The cleaned stream.
    remarks : list of str
        Counts of dropped samples.
    """
    complete = np.all(np.isfinite(stream.values), axis=1) & np.isfinite(stream.t)
    ordered, same = stream.where(complete).ordered()
    # A single quantised channel may repeat a value without being stale.
    stale = 0
    if not keep_repeats and len(stream.names) > 1:
        ordered, stale = drop_stale(ordered)
    counts = {
        "without a value": int(np.sum(~complete)),
        "with a repeated time stamp": same,
        "repeated": stale,
    }
    new_remarks = [f"{label}: {count} samples {what} omitted" for what, count in counts.items() if count]
    return ordered, new_remarks


def assemble(
    takes: Sequence[Take],
    episodes: Sequence[EpisodeMap],
    recording: Mapping[str, Any],
    name: str,
    form: str = "trundle-recording/1",
) -> Imported:
    """Cut takes into episodes.

    Parameters
    ----------
    takes : sequence of Take
        Takes in the order of time.
    episodes : sequence of EpisodeMap
        Episodes to cut. If empty, each take is an episode.
    recording : mapping
        Tables of the map that are copied to `recording.toml`.
    name : str
        Name of the recording, if the map has none.
    form : str
        Format of the recording.

    Returns
    -------
    Imported
        Times start at zero in each episode.
    """
    wanted = episodes or [
        EpisodeMap(take.name or f"episode_{index:02d}", take.label) for index, take in enumerate(takes)
    ]
    tables: dict[str, Columns] = {}
    for episode in wanted:
        if episode.name in tables:
            raise MapError(f"two episodes are named {episode.name!r}; names must be unique")
        tables[episode.name] = _cut_episode(_find_take(takes, episode), episode)
    metadata = {"format": form, "name": name, **recording}
    prefix = len(takes) > 1
    remarks = [f"{take.label}: {remark}" if prefix else remark for take in takes for remark in take.remarks]
    return Imported(metadata, tables, remarks)


def _find_take(takes: Sequence[Take], episode: EpisodeMap) -> Take:
    fitting = [take for take in takes if episode.source in (None, take.label)]
    if len(fitting) == 1:
        return fitting[0]
    listing = ", ".join(take.label for take in takes)
    raise MapError(f"episode {episode.name!r}: `source` = {episode.source!r}; it must be one of {listing}")


def _cut_episode(take: Take, episode: EpisodeMap) -> Columns:
    if episode.end <= episode.start:
        raise MapError(
            f"episode {episode.name!r}: `end` = {episode.end} s must be after `start` = {episode.start} s"
        )
    first = min(_first_time(stream.t) for stream in take.streams)
    pieces = []
    for stream in take.streams:
        piece = interval(stream.later(-first - episode.start), 0.0, episode.end - episode.start)
        if not len(piece.t):
            last = max(float(each.t[-1]) for each in take.streams if len(each.t)) - first
            raise SourceError(
                take.source,
                f"episode {episode.name!r} ({episode.start} to {min(episode.end, last):.3f} s) contains no "
                f"sample of {', '.join(stream.names)}; the take lasts {last:.3f} s",
            )
        pieces.append(piece)
    return join(pieces)


def _first_time(t: Floats) -> float:
    return float(t[0]) if len(t) else float("inf")
