"""ROS 2 bags of a push, written by the tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from trundle.importers.rotations import from_heading, product

STORE = get_typestore(Stores.LATEST)
EPOCH = 1_750_000_000_000_000_000
"""ns; a day in June 2025."""

Messages = list[tuple[str, str, int, Any]]
"""Topic, type, log time in ns, message."""


def header(nanoseconds: int) -> Any:
    stamp = STORE.types["builtin_interfaces/msg/Time"](nanoseconds // 10**9, nanoseconds % 10**9)
    return STORE.types["std_msgs/msg/Header"](stamp, "world")


def pose(position: Any, q: Any) -> Any:
    point = STORE.types["geometry_msgs/msg/Point"](*map(float, position))
    turn = STORE.types["geometry_msgs/msg/Quaternion"](*(float(q[i]) for i in (1, 2, 3, 0)))
    return STORE.types["geometry_msgs/msg/Pose"](point, turn)


def pose_stamped(ns: int, position: Any, q: Any) -> Any:
    return STORE.types["geometry_msgs/msg/PoseStamped"](header(ns), pose(position, q))


def odometry(ns: int, position: Any, q: Any) -> Any:
    zero = np.zeros(36)
    vector = STORE.types["geometry_msgs/msg/Vector3"]
    twist = STORE.types["geometry_msgs/msg/Twist"](vector(0.0, 0.0, 0.0), vector(0.0, 0.0, 0.0))
    return STORE.types["nav_msgs/msg/Odometry"](
        header(ns),
        "base",
        STORE.types["geometry_msgs/msg/PoseWithCovariance"](pose(position, q), zero),
        STORE.types["geometry_msgs/msg/TwistWithCovariance"](twist, zero),
    )


def transforms(ns: int, frames: dict[str, tuple[Any, Any]]) -> Any:
    made = []
    for name, (position, q) in frames.items():
        there = pose(position, q)
        vector = STORE.types["geometry_msgs/msg/Vector3"](*map(float, position))
        transform = STORE.types["geometry_msgs/msg/Transform"](vector, there.orientation)
        made.append(STORE.types["geometry_msgs/msg/TransformStamped"](header(ns), name, transform))
    return STORE.types["tf2_msgs/msg/TFMessage"](made)


def wrench_stamped(ns: int, values: Any) -> Any:
    vector = STORE.types["geometry_msgs/msg/Vector3"]
    wrench = STORE.types["geometry_msgs/msg/Wrench"](vector(*values[:3]), vector(*values[3:]))
    return STORE.types["geometry_msgs/msg/WrenchStamped"](header(ns), wrench)


class Push:
    """A push of a table along a curve for two seconds, in SI units and recording conventions.

    The tracker runs at 50 Hz, the sensor at 100 Hz, half a tick later.
    """

    def __init__(self) -> None:
        self.t = np.arange(100) * 0.02
        self.object = np.column_stack([0.3 * self.t**2, -0.1 * self.t, 0.4 + 0.5 * self.t])
        self.gripper = self.object + np.array([0.2, 0.1, 0.3])
        self.wrench_t = np.arange(200) * 0.01 + 0.005
        self.wrench = np.column_stack([np.sin((k + 1) * self.wrench_t) for k in range(6)])

    def messages(
        self,
        *,
        leaning: float = 0.0,
        hanging: bool = False,
        kind: Literal["pose", "odometry"] = "pose",
    ) -> Messages:
        """Return topics /table, /tf (frames hand, elbow) and /ft."""
        said: Messages = []
        over = np.array([0.0, 1.0, 0.0, 0.0]) if hanging else np.array([1.0, 0.0, 0.0, 0.0])
        lean = np.array([np.cos(leaning / 2), np.sin(leaning / 2), 0.0, 0.0])
        for t, body, hand in zip(self.t, self.object, self.gripper, strict=True):
            ns = EPOCH + round(t * 1e9)
            at, q = (*body[:2], 0.7), from_heading(body[2:])[0]
            table, name = (
                (pose_stamped(ns, at, q), "geometry_msgs/msg/PoseStamped")
                if kind == "pose"
                else (odometry(ns, at, q), "nav_msgs/msg/Odometry")
            )
            said.append(("/table", name, ns, table))
            held = product(product(from_heading(hand[2:]), lean), over)[0]
            frames = {"hand": ((*hand[:2], 0.9), held), "elbow": ((9.0, 9.0, 9.0), (1.0, 0.0, 0.0, 0.0))}
            said.append(("/tf", "tf2_msgs/msg/TFMessage", ns, transforms(ns, frames)))
        sign = np.array([1.0, -1.0, -1.0] * 2) if hanging else np.ones(6)
        for t, values in zip(self.wrench_t, self.wrench * sign, strict=True):
            ns = EPOCH + round(t * 1e9)
            said.append(("/ft", "geometry_msgs/msg/WrenchStamped", ns, wrench_stamped(ns, values)))
        return sorted(said, key=lambda message: message[2])


def write_bag(folder: Path, messages: Messages, storage: str = "mcap") -> Path:
    """Write a rosbag2 folder."""
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        connections = {
            (topic, kind): writer.add_connection(topic, kind, typestore=STORE)
            for topic, kind in dict.fromkeys((message[0], message[1]) for message in messages)
        }
        for topic, kind, ns, message in messages:
            writer.write(connections[topic, kind], ns, STORE.serialize_cdr(message, kind))
    return folder


BAG_MAP: dict[str, Any] = {
    "object": {"topic": "/table"},
    "gripper": {"topic": "/tf", "frame": "hand"},
    "wrench": {"topic": "/ft"},
}
