"""A recording as one MCAP file of ROS 2 messages, which Foxglove and rosbag2 open.

| topic | type | what |
| --- | --- | --- |
| `/object/pose` | `geometry_msgs/msg/PoseStamped` | object frame in `world`; m, unit quaternion |
| `/gripper/pose` | `geometry_msgs/msg/PoseStamped` | sensor frame in `world` |
| `/wrench` | `geometry_msgs/msg/WrenchStamped` | the reading as recorded; N, N·m |
| `/object/heading`, `/gripper/heading` | `std_msgs/msg/Float64` | rad, as recorded, including whole turns |
| `/episode/time` | `std_msgs/msg/Float64` | `t` of every row, s |
| `/episode/name` | `std_msgs/msg/String` | where an episode begins; latched |
| `/episode/note` | `std_msgs/msg/String` | a row's `note_` columns as JSON |
| `/trundle/recording` | `std_msgs/msg/String` | TOML: `recording.toml`, each episode's columns; latched |
| `/tf` | `tf2_msgs/msg/TFMessage` | frames `object` and `gripper` in `world`, with every pose |
| `/scene/object` | `visualization_msgs/msg/MarkerArray` | outline, feet and obstacles; latched |
| `/scene/wrench` | `visualization_msgs/msg/MarkerArray` | tared force on the object, an arrow at the sensor |

`frame_id` of a pose is `world`; of the wrench `gripper`, `object` or `world`, according to `[wrench] frame`.
Header stamp and log time are equal. A cell without a sample has no message. An axis that was not measured,
and the height of a level frame, is 0. Episodes follow each other with a gap of one second.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import tomli_w
from numpy.typing import NDArray

from trundle._native import Recording, TrundleError, _pushed
from trundle._optional import require
from trundle.atomic import report_target_path
from trundle.export.markers import MARKERS, TRANSFORMS, Marker, arrow_markers, scene_markers
from trundle.export.messages import NS_PER_S, Bag
from trundle.importers.bags import open_bag
from trundle.importers.config import MapError
from trundle.importers.layout import ShowProgress, SourceError
from trundle.importers.rotations import from_heading
from trundle.importers.trundle_mcap import (
    DESCRIPTION,
    FORMAT,
    NAME,
    NOTE,
    STRING,
    TOPICS,
    Description,
    Episode,
    describe,
)

__all__ = ["write_mcap"]

PathLike: TypeAlias = "str | os.PathLike[str]"
Stamps = NDArray[np.int64]
Table = Mapping[str, Any]

FIRST_STAMP_NS = NS_PER_S
"""First stamp, ns. Readers interpret a stamp of 0 as a missing time."""
EPISODE_GAP_NS = NS_PER_S
MAX_STAMP_S = 2**31
"""Largest ROS stamp, s (a signed 32-bit integer)."""
POSES = {"/object/pose": "object", "/gripper/pose": "gripper"}
"""Frames that the topics of poses place in the world."""
FRAMES = {"sensor": "gripper", "object": "object", "world": "world"}


def write_mcap(recording: Recording | PathLike, path: PathLike, say: ShowProgress = lambda _: None) -> Path:
    """Write a recording as one MCAP file.

    `trundle import FILE.mcap` reproduces the recording bit for bit.

    Parameters
    ----------
    recording : Recording or path
        The recording, or its folder.
    path : path
        Output file with the suffix `.mcap`, written atomically. An earlier export is replaced.
    say : callable
        Shows progress.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    TrundleError
        If the recording is invalid, two of its times are in the same nanosecond, `path` is another file, or
        the extra `trundle[ros]` is not installed.

    Examples
    --------
    >>> trundle.export.write_mcap(recording, "run_3.mcap").name
    'run_3.mcap'
    """
    rosbag2 = require("rosbags.rosbag2", "ros", "MCAP files")
    whole = _pushed(recording)
    path = Path(path)
    _check_target(path)
    placed = _assign_stamps(whole)
    scene, arrows = scene_markers(whole.metadata), arrow_markers(whole)
    path.parent.mkdir(parents=True, exist_ok=True)
    with (
        tempfile.TemporaryDirectory(prefix=f".{path.name}-", dir=path.parent) as partial,
        report_target_path(Path(partial), path),
    ):
        folder = Path(partial) / path.stem
        # Humble reads no later version; all later ones read this.
        with rosbag2.Writer(folder, version=8, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
            bag = Bag(writer)
            described = Description(FORMAT, [episode for episode, _ in placed], whole.metadata)
            bag.write(DESCRIPTION, STRING, FIRST_STAMP_NS, tomli_w.dumps(asdict(described)), latched=True)
            frame = FRAMES[whole.metadata["wrench"]["frame"]]
            for episode, stamps in placed:
                say(f"{path.name}: {episode.name}")
                bag.write(NAME, STRING, episode.begin, episode.name, latched=True)
                if scene:
                    bag.write("/scene/object", MARKERS, episode.begin, scene, latched=True)
                table = whole.episodes[episode.name]
                _write(bag, table, stamps.tolist(), frame, arrows.get(episode.name, {}))
        os.replace(folder / path.name, path)
    return path


def _assign_stamps(recording: Recording) -> list[tuple[Episode, Stamps]]:
    """Return the episodes in sequence and the stamps of their rows, ns."""
    placed, begin = [], FIRST_STAMP_NS
    for name, table in recording.episodes.items():
        t = table["t"]
        if t[-1] - t[0] >= MAX_STAMP_S - begin / NS_PER_S:
            message = f"lasts {t[-1] - t[0]:g} s, which exceeds the largest ROS stamp, {MAX_STAMP_S} s"
            raise TrundleError(f"episode {name}: {message}")
        stamps = begin + np.rint((t - t[0]) * NS_PER_S).astype(np.int64)
        same = np.flatnonzero(np.diff(stamps) == 0) + 1
        if len(same):
            message = f"{t[same[0]]} s is in the same nanosecond as the row before, so their stamps are equal"
            raise TrundleError(f"episode {name}, row {same[0] + 1}, column t: {message}; merge the two rows")
        placed.append((Episode(name, begin, list(table)), stamps))
        begin = int(stamps[-1]) + EPISODE_GAP_NS
    return placed


def _write(bag: Bag, table: Table, stamps: Sequence[int], frame: str, arrows: Mapping[float, Marker]) -> None:
    """Write the messages of one episode in order of time; `arrows` are by the time of their row, s."""
    samples = {topic: _samples(table, each.columns) for topic, each in TOPICS.items()}
    notes = {name: cells for name, cells in table.items() if name.startswith("note_")}
    for row, stamp in enumerate(stamps):
        for topic, (there, values) in samples.items():
            if there[row]:
                axes = frame if topic == "/wrench" else "world"
                bag.write(topic, TOPICS[topic].kind, stamp, values[row], axes)
                if topic in POSES:
                    bag.write("/tf", TRANSFORMS, stamp, (POSES[topic], values[row]), "world")
        if (arrow := arrows.get(table["t"][row])) is not None:
            bag.write("/scene/wrench", MARKERS, stamp, [arrow])
        row_notes = {name: cells[row] for name, cells in notes.items() if cells[row]}
        if row_notes:
            bag.write(NOTE, STRING, stamp, json.dumps(row_notes, ensure_ascii=False))


def _samples(table: Table, columns: Sequence[str]) -> tuple[NDArray[np.bool_], list[list[float]]]:
    """Return which rows have a sample of a topic, and the content of the messages."""
    nothing = np.zeros(len(table["t"]))
    measured = [table[name] for name in columns if name in table]
    if not measured:
        return nothing > 0.0, []
    values = np.column_stack([table.get(name, nothing) for name in columns])
    role, _, last = columns[-1].partition("_")
    if last == "qz" and columns[-1] not in table:
        values[:, 3:] = from_heading(table.get(f"{role}_theta", nothing))
    return ~np.isnan(measured[0]), values.tolist()


def _check_target(path: Path) -> None:
    """Refuse a path without the suffix `.mcap`, and an existing file that is not an export."""
    if path.suffix != ".mcap":
        raise TrundleError(f"{path}: the name must end in .mcap")
    ours = not path.exists()
    if path.is_file():
        with suppress(SourceError, MapError), open_bag(path) as reader:
            ours = describe(reader) is not None
    if not ours:
        raise TrundleError(f"{path}: exists and is not an export of trundle; give another name")
