"""MCAP files of `trundle export --mcap`, which are self-describing and reproduce a recording bit for bit.

This module defines the topics for the reader below and for the writer, `trundle.export.mcap`.
"""

from __future__ import annotations

import json
import sys
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from trundle._optional import require
from trundle.importers.config import typed
from trundle.importers.layout import Columns, Imported, ShowProgress, SourceError
from trundle.importers.messages import POSE, READERS, WRENCH

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

if TYPE_CHECKING:
    from rosbags.rosbag2 import Reader

__all__ = ["DESCRIPTION", "FORMAT", "NAME", "NOTE", "TOPICS", "Description", "Episode", "describe", "read"]

FORMAT = "trundle-mcap/1"
DESCRIPTION = "/trundle/recording"
"""Topic of the message that describes the file. It is a message because `ros2 bag convert` drops the metadata
records of an `.mcap` file and rosbags does not read them."""
NAME = "/episode/name"
NOTE = "/episode/note"
STRING = "std_msgs/msg/String"
NUMBER = "std_msgs/msg/Float64"


class Topic(NamedTuple):
    """Message type of a topic, and the columns of the recording in the order of the message."""

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
"""Topics of numbers. Headings and times have separate topics, because a quaternion loses whole turns and the
last bits of a heading, and stamps are integer nanoseconds."""


@dataclass(frozen=True)
class Episode:
    """One episode of a bag.

    Attributes
    ----------
    name : str
        Name of the episode.
    begin : int
        Log time of its first row, ns.
    columns : list of str
        Columns of its table, `t` first. Messages may have more axes than were measured.
    """

    name: str
    begin: int
    columns: list[str]


@dataclass(frozen=True)
class Description:
    """Description of a bag, in the bag.

    Attributes
    ----------
    format : str
        `FORMAT`.
    episode : list of Episode
        Episodes in the order of time.
    recording : dict
        Content of `recording.toml`.
    """

    format: str
    episode: list[Episode] = field(default_factory=list)
    recording: dict[str, Any] = field(default_factory=dict)


def describe(reader: Reader) -> Description | None:
    """Return the description in an open bag; None if trundle did not write it."""
    for _, _, text in _messages(reader, {DESCRIPTION: STRING}):
        table = tomllib.loads(text)
        if table.get("format") != FORMAT:
            found = f"{DESCRIPTION}: `format` = {table.get('format')!r}; this trundle reads {FORMAT!r}"
            raise SourceError(
                str(reader.path), f"{found}; import it with the version that wrote it, or with --map"
            )
        return typed(Description, table, DESCRIPTION)
    return None


def read(reader: Reader, description: Description, say: ShowProgress) -> Imported:
    """Return the recording in an open bag, identical to the exported one."""
    begins = [episode.begin for episode in description.episode]
    contents: list[dict[str, dict[int, Any]]] = [defaultdict(dict) for _ in begins]
    kinds = {topic: each.kind for topic, each in TOPICS.items()} | {NOTE: STRING}
    current = -1
    for topic, stamp, content in _messages(reader, kinds):
        episode = max(bisect_right(begins, stamp) - 1, 0)
        if episode != current:
            current = episode
            say(description.episode[episode].name)
        contents[episode][topic][stamp] = content
    tables = {
        each.name: _table(each, topics) for each, topics in zip(description.episode, contents, strict=True)
    }
    return Imported(description.recording, tables)


def _messages(reader: Reader, kinds: dict[str, str]) -> Iterator[tuple[str, int, Any]]:
    """Yield topic, log time (ns) and content of the messages on topics with these types."""
    types = require("rosbags.typesys", "ros", "ROS bags")
    store = types.get_typestore(types.Stores.LATEST)
    wanted = [each for each in reader.connections if kinds.get(each.topic) == each.msgtype]
    # With an empty list the reader would yield all messages.
    for connection, stamp, data in reader.messages(wanted) if wanted else ():
        kind = connection.msgtype
        message: Any = store.deserialize_cdr(data, kind)
        if kind in READERS:
            yield connection.topic, stamp, next(READERS[kind].parts(message))[2]
        else:
            yield connection.topic, stamp, [message.data] if kind == NUMBER else message.data


def _table(episode: Episode, topics: dict[str, dict[int, Any]]) -> Columns:
    """Return columns with a row per log time. They are not validated here."""
    row = {stamp: i for i, stamp in enumerate(sorted(set().union(*topics.values())))}
    table: dict[str, Any] = {}
    for topic, (_, columns) in TOPICS.items():
        rows = [row[stamp] for stamp in topics[topic]]
        values = np.array(list(topics[topic].values()), dtype=np.float64).reshape(len(rows), len(columns))
        for k, name in enumerate(columns):
            if name in episode.columns:
                table[name] = np.full(len(row), np.nan)
                table[name][rows] = values[:, k]
    notes = {row[stamp]: json.loads(text) for stamp, text in topics[NOTE].items()}
    for name in episode.columns:
        if name not in table:
            table[name] = [notes.get(i, {}).get(name, "") for i in range(len(row))]
    return table
