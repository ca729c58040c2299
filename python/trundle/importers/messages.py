"""ROS 2 messages that carry a pose or a wrench."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from trundle.importers.layout import SourceError
from trundle.importers.poses import Poses
from trundle.importers.streams import Stream

__all__ = ["READERS", "Samples"]

WRENCH = [f"{what}_{axis}" for what in ("force", "torque") for axis in "xyz"]
POSE = ["x", "y", "z", "qw", "qx", "qy", "qz"]


@dataclass(frozen=True)
class Reader:
    """Reader of one message type.

    Attributes
    ----------
    gives : str
        Quantity in the message.
    parts : callable
        Yields header, child frame (or None) and values of each sample in a message.
    framed : bool
        Whether one topic contains several frames.
    """

    gives: Literal["pose", "wrench"]
    parts: Callable[[Any], Iterator[tuple[Any, str | None, list[float]]]]
    framed: bool = False


def _pose(position: Any, turn: Any) -> list[float]:
    return [position.x, position.y, position.z, turn.w, turn.x, turn.y, turn.z]


def _pose_stamped(message: Any) -> Iterator[tuple[Any, str | None, list[float]]]:
    yield message.header, None, _pose(message.pose.position, message.pose.orientation)


def _pose_in_pose(message: Any) -> Iterator[tuple[Any, str | None, list[float]]]:
    yield message.header, None, _pose(message.pose.pose.position, message.pose.pose.orientation)


def _transform(message: Any) -> Iterator[tuple[Any, str | None, list[float]]]:
    transform = message.transform
    yield message.header, message.child_frame_id, _pose(transform.translation, transform.rotation)


def _transforms(message: Any) -> Iterator[tuple[Any, str | None, list[float]]]:
    for each in message.transforms:
        yield from _transform(each)


def _wrench(message: Any) -> Iterator[tuple[Any, str | None, list[float]]]:
    force, torque = message.wrench.force, message.wrench.torque
    yield message.header, None, [force.x, force.y, force.z, torque.x, torque.y, torque.z]


READERS = {
    "geometry_msgs/msg/PoseStamped": Reader("pose", _pose_stamped),
    "geometry_msgs/msg/PoseWithCovarianceStamped": Reader("pose", _pose_in_pose),
    "nav_msgs/msg/Odometry": Reader("pose", _pose_in_pose),
    "geometry_msgs/msg/TransformStamped": Reader("pose", _transform, framed=True),
    "tf2_msgs/msg/TFMessage": Reader("pose", _transforms, framed=True),
    "geometry_msgs/msg/WrenchStamped": Reader("wrench", _wrench),
}
"""Supported message types."""


@dataclass
class Samples:
    """Samples of one topic, in the order of the log.

    Attributes
    ----------
    topic : str
        Name of the topic.
    frame : str or None
        Child frame to keep.
    header : bool
        Whether to use the time in the message header instead of the log time.
    """

    topic: str
    frame: str | None
    header: bool
    nanoseconds: list[int] = field(default_factory=list)
    values: list[list[float]] = field(default_factory=list)
    frames: set[str] = field(default_factory=set)

    def add(self, message: Any, kind: str, logged: int) -> None:
        """Append the samples of one message."""
        for header, frame, values in READERS[kind].parts(message):
            if frame is not None:
                self.frames.add(frame)
                if frame.strip("/") != str(self.frame).strip("/"):
                    continue
            stamp = header.stamp.sec * 1_000_000_000 + header.stamp.nanosec
            self.nanoseconds.append(stamp if self.header else logged)
            self.values.append(values)

    def check(self, bag: Path, role: str) -> None:
        """Refuse a topic without samples or without times."""
        if not self.values and self.frames:
            raise SourceError(
                bag,
                f"no message on {self.topic} has the frame {self.frame!r} for {role}; "
                f"the frames are {', '.join(sorted(self.frames))}",
            )
        if not self.values:
            raise SourceError(bag, f"{self.topic} for {role} has no messages")
        if not any(self.nanoseconds):
            raise SourceError(bag, f'the headers of {self.topic} contain no time; set `stamp = "log"`')

    def stream(self, role: str, origin: int) -> tuple[Stream, int]:
        """Return the samples with times in s since `origin` (ns), and the number of dropped poses.

        Dropped poses have a quaternion of zeros: a tracker reports in this way that it has lost the object.
        """
        t = np.asarray((np.array(self.nanoseconds, dtype=np.int64) - origin) * 1e-9, dtype=np.float64)
        values = np.array(self.values, dtype=np.float64)
        if role == "wrench":
            return Stream(WRENCH, t, values), 0
        lost = np.all(values[:, 3:] == 0.0, axis=1)
        return Stream(POSE, t[~lost], values[~lost]), int(np.sum(lost))

    def poses(self, role: str, stream: Stream) -> Poses:
        """Return the poses in `stream` (7 columns), with validated rotations."""
        return Poses.checked(self.topic, role, stream.t, stream.values[:, :3], stream.values[:, 3:])
