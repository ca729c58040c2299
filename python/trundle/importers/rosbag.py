"""ROS 2 bags: a bare `.mcap` or `.db3`, a rosbag2 folder, or a folder of several."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from trundle._optional import require
from trundle.importers import trundle_mcap
from trundle.importers.config import MapError, typed
from trundle.importers.layout import Imported, ShowProgress, SourceError
from trundle.importers.messages import READERS, Samples
from trundle.importers.poses import Poses, World
from trundle.importers.takes import (
    BodyMap,
    EpisodeMap,
    GripperMap,
    Take,
    assemble,
    clean_stream,
    to_recording_frames,
)

if TYPE_CHECKING:
    from rosbags.rosbag2 import Reader

__all__ = ["NEEDS_MAP", "BagMap", "BodyTopic", "GripperTopic", "TopicMap", "open_bag", "read"]

NEEDS_MAP = False
"""Bags that trundle wrote need no map; `read` requires one for others."""

ROLES = {"object": "pose", "gripper": "pose", "wrench": "wrench"}
MESSAGES_PER_PROGRESS = 20_000
"""Number of messages between two progress reports."""


@dataclass(frozen=True)
class TopicMap:
    """Name of a topic."""

    topic: str


@dataclass(frozen=True)
class BodyTopic(BodyMap, TopicMap):
    """A topic of poses or transforms; for transforms, `frame` is the child frame to use."""

    frame: str | None = None


@dataclass(frozen=True)
class GripperTopic(GripperMap, BodyTopic):
    """The same for the gripper with the sensor."""


@dataclass(frozen=True)
class BagMap:
    """Settings of a map file for bags.

    Attributes
    ----------
    object, gripper, wrench : TopicMap
        The topics. A wrench in world or object axes needs no gripper.
    stamp : str
        Time of a sample: "header", that of the measurement, or "log", that of the recording.
    recording : dict
        Tables of `recording.toml`, passed through.
    """

    wrench: TopicMap
    object: BodyTopic
    gripper: GripperTopic | None = None
    stamp: Literal["header", "log"] = "header"
    name: str | None = None
    world: World = field(default_factory=World)
    keep_repeats: bool = False
    episode: list[EpisodeMap] = field(default_factory=list)
    recording: dict[str, Any] = field(default_factory=dict)

    def topics(self) -> dict[str, TopicMap]:
        """Return the mapped topics by role."""
        roles = {"object": self.object, "gripper": self.gripper, "wrench": self.wrench}
        return {role: topic for role, topic in roles.items() if topic is not None}


def read(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read a bag, or every bag of a folder in the order of their names."""
    bags = _bags(source)
    if not settings:
        return _read_exported(source, bags, say)
    source_map = typed(BagMap, settings)
    takes = [_read_take(bag, source_map, say) for bag in bags]
    return assemble(takes, source_map.episode, source_map.recording, source_map.name or source.stem)


def _read_exported(source: Path, bags: list[Path], say: ShowProgress) -> Imported:
    """Read a bag of `trundle export --mcap`, which needs no map."""
    if len(bags) == 1:
        with open_bag(bags[0]) as reader:
            if description := trundle_mcap.describe(reader):
                return trundle_mcap.read(reader, description, say)
    raise SourceError(
        source,
        "a bag needs --map: a TOML file that assigns the topics (docs/import.md); "
        "only a single file of `trundle export --mcap` does not",
    )


def _frame(topic: TopicMap) -> str | None:
    return topic.frame if isinstance(topic, BodyTopic) else None


def _bags(source: Path) -> list[Path]:
    if source.suffix == ".bag":
        raise SourceError(source, "a ROS 1 bag; convert it with `rosbags-convert --src IN.bag --dst OUT`")
    if source.is_file() or (source / "metadata.yaml").is_file():
        return [source]
    inside = sorted(
        path
        for path in source.iterdir()
        if path.suffix in (".mcap", ".db3") or (path / "metadata.yaml").is_file()
    )
    if not inside:
        raise SourceError(source, "no bag: neither metadata.yaml nor any .mcap, .db3 or bag folder inside")
    return inside


def _read_take(bag: Path, source_map: BagMap, say: ShowProgress) -> Take:
    topics = source_map.topics()
    samples = _collect(bag, source_map, say)
    streams, remarks = {}, []
    origin = min(min(each.nanoseconds) for each in samples.values() if each.nanoseconds)
    for role, each in samples.items():
        raw, lost = each.stream(role, origin)
        streams[role], new_remarks = clean_stream(raw, topics[role].topic, source_map.keep_repeats)
        remarks += (
            [f"{topics[role].topic}: {lost} poses of a lost tracker omitted"] if lost else []
        ) + new_remarks
    bodies: dict[str, Poses] = {
        role: samples[role].poses(role, streams[role]) for role in ("object", "gripper") if role in streams
    }
    moved, new_remarks = to_recording_frames(
        bodies, source_map.object, source_map.gripper or GripperMap(), source_map.world, streams["wrench"]
    )
    return Take(bag, moved, remarks + new_remarks)


def _collect(bag: Path, source_map: BagMap, say: ShowProgress) -> dict[str, Samples]:
    """Read all messages of the mapped topics."""
    topics = source_map.topics()
    samples = {
        role: Samples(topic.topic, _frame(topic), source_map.stamp == "header")
        for role, topic in topics.items()
    }
    wanted = {topic.topic for topic in topics.values()}
    types = require("rosbags.typesys", "ros", "ROS bags")
    store = types.get_typestore(types.Stores.LATEST)
    with open_bag(bag) as reader:
        for role, topic in topics.items():
            _check_topic(bag, reader, role, topic)
        connections = [connection for connection in reader.connections if connection.topic in wanted]
        for count, (connection, stamp, data) in enumerate(reader.messages(connections=connections)):
            if count % MESSAGES_PER_PROGRESS == 0:
                say(f"{bag.name}: {count} messages")
            message = store.deserialize_cdr(data, connection.msgtype)
            for role, topic in topics.items():
                if topic.topic == connection.topic:
                    samples[role].add(message, connection.msgtype, stamp)
    for role, each in samples.items():
        each.check(bag, role)
    return samples


@contextmanager
def open_bag(bag: Path) -> Iterator[Reader]:
    """Open a bag for reading; the error for a damaged bag names a remedy."""
    rosbag2 = require("rosbags.rosbag2", "ros", "ROS bags")
    try:
        with rosbag2.Reader(bag) as reader:
            yield reader
    except (SourceError, MapError, OSError):
        raise
    except KeyError as error:
        remedy = "copy the ROS 2 topics to another bag with `mcap filter IN -o OUT -y TOPIC`"
        raise SourceError(
            bag, f"contains channels that are not ROS 2 messages ({error}); {remedy}"
        ) from error
    except Exception as error:
        # For a damaged file the library may raise any exception.
        remedy = "recover it with `mcap recover IN -o OUT` or `ros2 bag reindex FOLDER`"
        raise SourceError(bag, f"damaged bag ({type(error).__name__}: {error}); {remedy}") from error


def _check_topic(bag: Path, reader: Reader, role: str, topic: TopicMap) -> None:
    types = {connection.topic: connection.msgtype for connection in reader.connections}
    listing = ", ".join(f"{name} ({kind})" for name, kind in sorted(types.items())) or "none"
    if topic.topic not in types:
        raise SourceError(bag, f"no topic {topic.topic!r} for {role}; the topics are: {listing}")
    kind = types[topic.topic]
    fitting = [name for name, each in READERS.items() if each.gives == ROLES[role]]
    if kind not in fitting:
        raise SourceError(
            bag, f"topic {topic.topic} for {role} has the type {kind}; it must be one of {', '.join(fitting)}"
        )
    if READERS[kind].framed and _frame(topic) is None:
        raise MapError(f"`{role}.frame` is missing: give a child frame of {topic.topic}")
