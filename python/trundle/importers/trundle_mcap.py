"""Bags that `trundle export --mcap` wrote: they say themselves what is what, and give back every bit.

What a topic carries stands here once, for the reader below and for the writer, `trundle.export.mcap`.
"""

from __future__ import annotations

import json
import sys
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from trundle.importers.config import typed
from trundle.importers.layout import Columns, Imported, ShowProgress, SourceError
from trundle.importers.messages import POSE, READERS, WRENCH

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["DESCRIPTION", "FORMAT", "NAME", "NOTE", "TOPICS", "Description", "Episode", "describe", "read"]

FORMAT = "trundle-mcap/1"
DESCRIPTION = "/trundle/recording"
"""Topic of the message that describes all others. A message, because the metadata records of a bare `.mcap`
are dropped by `ros2 bag convert` and hidden from rosbags."""
NAME = "/episode/name"
NOTE = "/episode/note"
STRING = "std_msgs/msg/String"
NUMBER = "std_msgs/msg/Float64"


class Topic(NamedTuple):
    """Message type of a topic, and the recording's columns in the order of the message."""

    kind: str
    columns: list[str]


TOPICS = {
    "/episode/time": Topic(NUMBER, ["t"]),
    "/object/pose": Topic("geometry_msgs/msg/PoseStamped", [f"object_{part}" for part in POSE]),
    "/object/heading": Topic(NUMBER, ["object_theta"]),
    "/gripper/pose": Topic("geometry_msgs/msg/PoseStamped", [f"gripper_{part}" for part in POSE]),
    "/gripper/heading": Topic(NUMBER, ["gripper_theta"]),
    "/wrench": Topic("geometry_msgs/msg/WrenchStamped", WRENCH),
}
"""Topics of numbers. Whole turns and the last bit of a heading do not survive a quaternion, and stamps are
whole nanoseconds: hence topics of their own for headings and times."""


@dataclass(frozen=True)
class Episode:
    """One episode of a bag.

    Attributes
    ----------
    name : str
        Its name.
    begin : int
        ns, log time of its first row.
    columns : list of str
        Of its table, `t` first; a message has more axes than were measured.
    """

    name: str
    begin: int
    columns: list[str]


@dataclass(frozen=True)
class Description:
    """What a bag says about itself.

    Attributes
    ----------
    format : str
        `FORMAT`.
    episode : list of Episode
        In the order of time.
    recording : dict
        `recording.toml` as it was.
    """

    format: str
    episode: list[Episode] = field(default_factory=list)
    recording: dict[str, Any] = field(default_factory=dict)


def describe(reader: Reader) -> Description | None:
    """Return what an open bag says about itself, None if trundle did not write it."""
    for _, _, text in _messages(reader, {DESCRIPTION: STRING}):
        table = tomllib.loads(text)
        if table.get("format") != FORMAT:
            found = f"{DESCRIPTION}: `format` = {table.get('format')!r}; this trundle reads {FORMAT!r}"
            raise SourceError(
                str(reader.path), f"{found}: import it with the one that wrote it, or with --map"
            )
        return typed(Description, table, DESCRIPTION)
    return None


def read(reader: Reader, told: Description, say: ShowProgress) -> Imported:
    """Return the recording that an open bag holds, as it was before it was exported."""
    begins = [episode.begin for episode in told.episode]
    heard: list[dict[str, dict[int, Any]]] = [defaultdict(dict) for _ in begins]
    kinds = {topic: each.kind for topic, each in TOPICS.items()} | {NOTE: STRING}
    current = -1
    for topic, stamp, content in _messages(reader, kinds):
        episode = max(bisect_right(begins, stamp) - 1, 0)
        if episode != current:
            current = episode
            say(told.episode[episode].name)
        heard[episode][topic][stamp] = content
    tables = {each.name: _table(each, said) for each, said in zip(told.episode, heard, strict=True)}
    return Imported(told.recording, tables)


def _messages(reader: Reader, kinds: dict[str, str]) -> Iterator[tuple[str, int, Any]]:
    """Yield topic, log time in ns and content of the messages on topics of these kinds."""
    store = get_typestore(Stores.LATEST)
    wanted = [each for each in reader.connections if kinds.get(each.topic) == each.msgtype]
    # Asked for no connection, the reader gives all.
    for connection, stamp, data in reader.messages(wanted) if wanted else ():
        kind = connection.msgtype
        message: Any = store.deserialize_cdr(data, kind)
        if kind in READERS:
            yield connection.topic, stamp, next(READERS[kind].parts(message))[2]
        else:
            yield connection.topic, stamp, [message.data] if kind == NUMBER else message.data


def _table(episode: Episode, said: dict[str, dict[int, Any]]) -> Columns:
    """Return columns with a row per log time; what is wrong with them is found when they are validated."""
    row = {stamp: i for i, stamp in enumerate(sorted(set().union(*said.values())))}
    table: dict[str, Any] = {}
    for topic, (_, columns) in TOPICS.items():
        rows = [row[stamp] for stamp in said[topic]]
        values = np.array(list(said[topic].values()), dtype=np.float64).reshape(len(rows), len(columns))
        for k, name in enumerate(columns):
            if name in episode.columns:
                table[name] = np.full(len(row), np.nan)
                table[name][rows] = values[:, k]
    notes = {row[stamp]: json.loads(text) for stamp, text in said[NOTE].items()}
    for name in episode.columns:
        if name not in table:
            table[name] = [notes.get(i, {}).get(name, "") for i in range(len(row))]
    return table
