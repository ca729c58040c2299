"""ROS 2 bags of joints: states and commands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from trundle.importers.bags import check_topic, messages, open_bag
from trundle.importers.config import MapError, typed
from trundle.importers.joints.columns import Kind, known
from trundle.importers.joints.joint_map import JointMap, assemble_joints
from trundle.importers.joints.messages import JOINT_READERS
from trundle.importers.joints.streams import joint_take, sample_stream
from trundle.importers.layout import Imported, ShowProgress, SourceError
from trundle.importers.streams import Stream
from trundle.importers.takes import Take

__all__ = ["JointBagMap", "JointTopic", "read_bag_joints"]

Role = Literal["state", "target", "effort"]
COLUMNS: dict[Role, dict[str, Kind]] = {
    "state": {"position": "q", "velocity": "v", "effort": "effort"},
    "target": {"position": "target"},
    "effort": {"effort": "effort"},
}
"""Kind of column for each field of a message, by the role of its topic."""


@dataclass(frozen=True)
class JointTopic:
    """A topic.

    Attributes
    ----------
    topic : str
        Its name.
    order : list of str
        Names of the joints in the order of a message that has no names.
    """

    topic: str
    order: list[str] | None = None


@dataclass(frozen=True)
class JointBagMap(JointMap):
    """Settings of a map file for bags of joints.

    Attributes
    ----------
    state : JointTopic
        Positions, and velocities and efforts if the messages contain them.
    target, effort : JointTopic
        Commanded positions; efforts, in place of those of the state.
    stamp : str
        Time of a sample: "header", or "log" for that of the recording.
    """

    state: JointTopic = field(default_factory=lambda: JointTopic("/joint_states"))
    target: JointTopic | None = None
    effort: JointTopic | None = None
    stamp: Literal["header", "log"] = "header"

    def topics(self) -> dict[Role, JointTopic]:
        """Return the mapped topics by role."""
        roles: dict[Role, JointTopic | None] = {
            "state": self.state,
            "target": self.target,
            "effort": self.effort,
        }
        return {role: topic for role, topic in roles.items() if topic is not None}

    def kinds(self, role: Role) -> dict[str, Kind]:
        """Return the kind of column for each field of the messages of a role."""
        replaced = {"effort"} if role == "state" and self.effort is not None else set()
        return {name: kind for name, kind in COLUMNS[role].items() if name not in replaced}


class Samples:
    """Samples of all columns of a bag, in the order of the log: times in ns and values."""

    def __init__(self, bag: Path, source_map: JointBagMap) -> None:
        self.bag, self._map = bag, source_map
        self._joints = dict(zip(source_map.log_names, source_map.names, strict=True))
        self.seen: dict[Role, set[str]] = {role: set() for role in source_map.topics()}
        self.columns: dict[tuple[Kind, str], list[tuple[int, float]]] = {}

    def add(self, role: Role, kind: str, logged: int, count: int, message: Any) -> None:
        """Append the samples of message number `count` of type `kind`."""
        topic = self._map.topics()[role]
        for part in JOINT_READERS[kind](message):
            stamp = part.stamp if part.stamp is not None and self._map.stamp == "header" else logged
            names = part.joints if part.joints is not None else topic.order
            if names is None:
                raise MapError(
                    f"`{role}.order` is missing: the messages on {topic.topic} have no names of joints"
                )
            self.seen[role].update(names)
            for field_name, column in self._map.kinds(role).items():
                values = part.values[field_name]
                if len(values) not in (0, len(names)):
                    remedy = "correct `order`" if part.joints is None else "omit the message"
                    raise SourceError(
                        self.bag,
                        f"message {count} on {topic.topic}: {field_name} has {len(values)} values for "
                        f"{len(names)} joints ({', '.join(names)}); {remedy}",
                    )
                for name, value in zip(names, values, strict=False):
                    self._append(column, name, stamp + part.delay, float(value), part.replaces)

    def _append(self, column: Kind, name: str, ns: int, value: float, replaces: bool) -> None:
        if name not in self._joints:
            return
        samples = self.columns.setdefault((column, self._joints[name]), [])
        while replaces and samples and samples[-1][0] >= ns:
            samples.pop()
        samples.append((ns, value))

    def check(self) -> None:
        """Refuse joints that the state does not contain, and commands of none of the joints."""
        for role, topic in self._map.topics().items():
            absent = [name for name in self._joints if name not in self.seen[role]]
            if not self.seen[role]:
                raise SourceError(self.bag, f"{topic.topic} for {role} has no messages")
            if absent if role == "state" else len(absent) == len(self._joints):
                raise SourceError(
                    self.bag,
                    f"no joint {absent[0]!r} on {topic.topic} for {role}; {known(sorted(self.seen[role]))}",
                )

    def take(self, name: str | None) -> Take:
        """Return the samples as one take; efforts that are always zero are omitted as not measured."""
        origin = min((samples[0][0] for samples in self.columns.values() if samples), default=0)
        streams: dict[str, Stream] = {}
        repeated: dict[str, int] = {}
        remarks: list[str] = []
        for (kind, joint), samples in self.columns.items():
            column = f"{kind}_{joint}"
            t = np.array([ns - origin for ns, _ in samples], dtype=np.float64) * 1e-9
            values = self._map.radians(self.bag, kind, joint, np.array([value for _, value in samples]))
            if kind == "effort" and not np.any(values):
                remarks.append(f"{column}: omitted, 0 in all messages, so that it was not measured")
                continue
            streams[column], repeated[column] = sample_stream(
                kind, joint, t, values, self._map.holds(kind, joint)
            )
        take = joint_take(self.bag, self._map.names, streams, repeated, name)
        return replace(take, remarks=remarks + take.remarks)


def read_bag_joints(
    source: Path, bags: Sequence[Path], settings: Mapping[str, Any], say: ShowProgress
) -> Imported:
    """Read the joints in bags; each bag is an episode."""
    source_map = typed(JointBagMap, settings)
    takes = [_read_bag(bag, source_map, say, bag.stem if len(bags) > 1 else None) for bag in bags]
    return assemble_joints(takes, source_map, source.stem)


def _read_bag(bag: Path, source_map: JointBagMap, say: ShowProgress, name: str | None) -> Take:
    samples = Samples(bag, source_map)
    topics = source_map.topics()
    counts: dict[str, int] = {}
    with open_bag(bag) as reader:
        for role, topic in topics.items():
            check_topic(bag, reader, role, topic.topic, JOINT_READERS)
        for name_of_topic, kind, stamp, message in messages(
            bag, reader, {topic.topic for topic in topics.values()}, say
        ):
            counts[name_of_topic] = counts.get(name_of_topic, 0) + 1
            for role, topic in topics.items():
                if topic.topic == name_of_topic:
                    samples.add(role, kind, stamp, counts[name_of_topic], message)
    samples.check()
    return samples.take(name)
