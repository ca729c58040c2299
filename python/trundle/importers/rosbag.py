"""ROS 2 bags of a pushed object, or of joints; bags are found and read by `bags`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from trundle.importers import trundle_mcap
from trundle.importers.bags import check_topic, list_bags, messages, open_bag
from trundle.importers.config import MapError, typed
from trundle.importers.joints.bag import read_bag_joints
from trundle.importers.joints.joint_map import is_joint_map
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

__all__ = ["NEEDS_MAP", "BagMap", "BodyTopic", "GripperTopic", "TopicMap", "read"]

NEEDS_MAP = False
"""Bags that trundle wrote need no map; `read` requires one for others."""

ROLES = {"object": "pose", "gripper": "pose", "wrench": "wrench"}


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
    bags = list_bags(source)
    if is_joint_map(settings):
        return read_bag_joints(source, bags, settings, say)
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
    with open_bag(bag) as reader:
        for role, topic in topics.items():
            _check_topic(bag, reader, role, topic)
        for name, kind, stamp, message in messages(bag, reader, wanted, say):
            for role, topic in topics.items():
                if topic.topic == name:
                    samples[role].add(message, kind, stamp)
    for role, each in samples.items():
        each.check(bag, role)
    return samples


def _check_topic(bag: Path, reader: Reader, role: str, topic: TopicMap) -> None:
    fitting = [name for name, each in READERS.items() if each.gives == ROLES[role]]
    kind = check_topic(bag, reader, role, topic.topic, fitting)
    if READERS[kind].framed and _frame(topic) is None:
        raise MapError(f"`{role}.frame` is missing: give a child frame of {topic.topic}")
