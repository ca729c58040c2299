"""Conversion of named vectors (CSV columns, MATLAB variables) to the columns of a recording."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from trundle.importers.config import MapError
from trundle.importers.layout import Imported, ShowProgress, SourceError
from trundle.importers.poses import Poses, World
from trundle.importers.quantity import Quantity, Vectors, numbers
from trundle.importers.rotations import from_heading
from trundle.importers.streams import Stream
from trundle.importers.takes import (
    BodyMap,
    EpisodeMap,
    GripperMap,
    Take,
    assemble,
    clean_stream,
    to_recording_frames,
)
from trundle.importers.units import UNITS

__all__ = ["TableMap", "list_files", "read_files", "take"]

Role = Literal["object", "gripper", "wrench"]
POSE = {"x": "length", "y": "length", "z": "length", "theta": "angle"} | dict.fromkeys(
    ("qw", "qx", "qy", "qz"), "ratio"
)
DIMENSIONS = (
    {f"{body}_{part}": kind for body in ("object", "gripper") for part, kind in POSE.items()}
    | {f"force_{axis}": "force" for axis in "xyz"}
    | {f"torque_{axis}": "torque" for axis in "xyz"}
)
"""Physical dimension of each column that can be mapped."""


ROLES: tuple[Role, ...] = ("object", "gripper", "wrench")


@dataclass(frozen=True)
class TableMap:
    """Settings of a map file for files of named vectors.

    Attributes
    ----------
    columns : dict of str to str or Quantity
        Source of each column of the recording.
    time : str or Quantity
        Sample times, with any origin.
    times : dict
        Sample times by stream ("object", "gripper", "wrench"), if streams have separate time columns.
    recording : dict
        Tables that are copied to `recording.toml`.
    """

    columns: dict[str, str | Quantity]
    time: str | Quantity | None = None
    times: dict[Role, str | Quantity] = field(default_factory=dict)
    name: str | None = None
    world: World = field(default_factory=World)
    object: BodyMap = field(default_factory=BodyMap)
    gripper: GripperMap = field(default_factory=GripperMap)
    keep_repeats: bool = False
    episode: list[EpisodeMap] = field(default_factory=list)
    recording: dict[str, Any] = field(default_factory=dict)


def read_files(
    source: Path,
    suffix: str,
    open_file: Callable[[Path], Vectors],
    source_map: TableMap,
    say: ShowProgress,
) -> Imported:
    """Read one file, or every file of a folder with the suffix `suffix`, in the order of their names."""
    takes = []
    for file in list_files(source, suffix):
        say(file.name)
        takes.append(take(open_file(file), source_map))
    return assemble(takes, source_map.episode, source_map.recording, source_map.name or source.stem)


def list_files(source: Path, suffix: str) -> list[Path]:
    """Return a file, or the files of a folder with a suffix in the order of their names."""
    files = sorted(source.glob(f"*{suffix}")) if source.is_dir() else [source]
    if not files:
        raise SourceError(source, f"no *{suffix} in this folder")
    return files


def take(file: Vectors, source_map: TableMap) -> Take:
    """Return the streams of one file."""
    unknown = [column for column in source_map.columns if column not in DIMENSIONS]
    if unknown:
        raise MapError(
            f"`columns.{unknown[0]}`: unknown column; the columns of a recording are {', '.join(DIMENSIONS)}"
        )
    streams: dict[str, Stream] = {}
    remarks: list[str] = []
    for role in ROLES:
        names = [name for name in DIMENSIONS if name in source_map.columns and _role(name) == role]
        if names:
            streams[role], new_remarks = clean_stream(
                _stream(file, source_map, role, names), role, source_map.keep_repeats
            )
            remarks += new_remarks
    if not streams:
        raise MapError("`columns` is empty; map at least object_x and force_x")
    rail = (
        [streams.pop("object")] if streams.get("object") and streams["object"].names == ["object_x"] else []
    )
    bodies: dict[str, Poses] = {
        role: _poses(file.path, streams[role]) for role in ("object", "gripper") if role in streams
    }
    wrench = streams.get("wrench")
    moved, new_remarks = to_recording_frames(
        bodies, source_map.object, source_map.gripper, source_map.world, wrench
    )
    return Take(file.path, rail + moved, remarks + new_remarks)


def _role(column: str) -> str:
    body = column.split("_")[0]
    return body if body in ("object", "gripper") else "wrench"


def _stream(file: Vectors, source_map: TableMap, role: Role, names: list[str]) -> Stream:
    clock = source_map.times.get(role, source_map.time)
    if clock is None:
        raise MapError(f"no time for {role}; set `time` or `times.{role}`")
    t = numbers(file, clock, UNITS["time"], "time")
    vectors = [
        numbers(file, source_map.columns[name], UNITS[DIMENSIONS[name]], f"columns.{name}") for name in names
    ]
    for name, vector in zip(names, vectors, strict=True):
        if len(vector) != len(t):
            raise SourceError(
                file.path,
                f"{name} has {len(vector)} samples and its time {len(t)}; give the time of {role} in `times`",
            )
    values = np.column_stack(vectors)
    empty = np.isnan(values)
    torn = np.flatnonzero(empty.any(axis=1) & ~empty.all(axis=1))
    if len(torn):
        empty_name = names[int(np.argmax(empty[torn[0]]))]
        raise SourceError(
            file.path, f"row {torn[0] + 1}: {empty_name} is empty but other columns of {role} are not"
        )
    # Rows where all columns of the stream are empty are not samples of it.
    there = ~empty.all(axis=1)
    return Stream(names, t[there], values[there])


def _poses(path: Path, stream: Stream) -> Poses:
    column = {name.split("_")[1]: stream.values[:, i] for i, name in enumerate(stream.names)}
    role = _role(stream.names[0])
    quaternion = [column[part] for part in ("qw", "qx", "qy", "qz") if part in column]
    if (
        not ("x" in column and "y" in column)
        or len(quaternion) not in (0, 4)
        or bool(quaternion) == ("theta" in column)
    ):
        raise MapError(
            f"`columns` has {', '.join(stream.names)}; a pose needs {role}_x, {role}_y and either "
            f"{role}_theta or {role}_qw, {role}_qx, {role}_qy, {role}_qz"
        )
    z = column.get("z", np.zeros(len(stream.t)))
    q = np.column_stack(quaternion) if quaternion else from_heading(column["theta"])
    position = np.column_stack([column["x"], column["y"], z])
    return Poses.checked(path, role, stream.t, position, q)
